#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

namespace gmis::tools {

/// A line of a text file, counted from 1.
struct SourcePosition {
  std::shared_ptr<const std::string> file;
  int line = 0;

  [[nodiscard]] std::string to_string() const { return (file ? *file : "?") + ":" + std::to_string(line); }
};

/// Something is wrong with what the user gave us. `what()` is one line: where, what, and what to change.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message) {}
  InputError(const SourcePosition& where, const std::string& message)
      : std::runtime_error(where.to_string() + ": " + message) {}
};

/// A result could not be written. `what()` is one line.
class OutputError : public std::runtime_error {
 public:
  explicit OutputError(const std::string& message) : std::runtime_error(message) {}
};

enum class Severity { note, warning };

struct Diagnostic {
  Severity severity;
  SourcePosition where;
  std::string message;

  [[nodiscard]] std::string to_string() const {
    return where.to_string() + ": " + (severity == Severity::note ? "note: " : "warning: ") + message;
  }
};

/// Collects what the reader has to say. The same message is kept once, at the place where it came up first.
class Diagnostics {
 public:
  void note(const SourcePosition& where, std::string message) { add(Severity::note, where, std::move(message)); }
  void warning(const SourcePosition& where, std::string message) { add(Severity::warning, where, std::move(message)); }
  [[nodiscard]] const std::vector<Diagnostic>& all() const { return all_; }

 private:
  void add(Severity severity, const SourcePosition& where, std::string message) {
    if (seen_.insert(message).second) all_.push_back({severity, where, std::move(message)});
  }

  std::vector<Diagnostic> all_;
  std::unordered_set<std::string> seen_;
};

/// The text in quotation marks, cut to a length that fits a line, with everything but printable ASCII shown as `?`.
[[nodiscard]] inline std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 48;
  std::string result = "\"";
  for (const char c : text.substr(0, longest)) result += (c >= ' ' && c < '\x7f') ? c : '?';
  if (text.size() > longest) result += "…";
  return result + "\"";
}

}  // namespace gmis::tools
