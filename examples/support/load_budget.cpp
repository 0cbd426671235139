#include "support/load_budget.hpp"

#include <unistd.h>

#include <cstdio>
#include <limits>

namespace gmis::tools {
namespace {

/// In MiB, or in bytes where those are few.
std::string size_text(std::uintmax_t bytes) {
  constexpr std::uintmax_t few = 10'000;
  if (bytes < few) return std::to_string(bytes) + (bytes == 1 ? " byte" : " bytes");
  char text[32];
  const double mebibytes = static_cast<double>(bytes) / (1 << 20);
  std::snprintf(text, sizeof text, mebibytes < 10 ? "%.2g MiB" : "%.0f MiB", mebibytes);
  return text;
}

}  // namespace

std::uintmax_t LoadBudget::default_limit() {
  const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || size <= 0) return std::uintmax_t{4} << 30;
  return static_cast<std::uintmax_t>(pages) * static_cast<std::uintmax_t>(size) / 4 * 3;
}

void LoadBudget::take(std::uintmax_t bytes, const std::string& what, const SourcePosition& where) {
  if (bytes > limit_ - taken_)
    throw InputError(where, what + " would take " + size_text(bytes) + ", and " + size_text(taken_) + " of " +
                                size_text(limit_) + " are taken: make the scene smaller, or see --max-memory");
  taken_ += bytes;
}

void LoadBudget::take(std::uintmax_t count, std::uintmax_t bytes_each, const std::string& what,
                      const SourcePosition& where) {
  constexpr std::uintmax_t most = std::numeric_limits<std::uintmax_t>::max();
  take(bytes_each != 0 && count > most / bytes_each ? most : count * bytes_each, what, where);
}

void LoadBudget::open_file(const SourcePosition& where) {
  constexpr std::uintmax_t most = 20'000;
  if (++files_ > most)
    throw InputError(where, "the scene opens more than " + std::to_string(most) +
                                " files: does one include another again and again?");
}

}  // namespace gmis::tools
