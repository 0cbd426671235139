#include "support/read_file.hpp"

#include <fstream>
#include <limits>

#if GMIS_HAS_ZLIB
#include <zlib.h>
#endif

namespace gmis::tools {

std::string read_file(const std::filesystem::path& file, const std::string& what, LoadBudget& budget,
                      const SourcePosition& where) {
  const std::string name = what + " " + file_in_quotes(file.string());
  std::error_code error;
  const bool is_there = std::filesystem::exists(file, error);
  if (!is_there) throw InputError(where, name + " is missing: check its name");
  if (!std::filesystem::is_regular_file(file, error))  // a pipe or a device might never end
    throw InputError(where, name + " is no regular file: check its name");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  budget.open_file(where);
  std::ifstream stream(file, std::ios::binary);
  if (error || !stream) throw InputError(where, name + " cannot be read: check its permissions");
  budget.take(size, name, where);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));  // it may have become shorter
  return bytes;
}

#if GMIS_HAS_ZLIB

std::string unpacked_gzip(const std::string& packed, const std::string& name, LoadBudget& budget,
                          const SourcePosition& where) {
  const auto fail = [&] { return InputError(where, name + " cannot be unpacked: it is no whole gzip file"); };
  if (packed.size() > std::numeric_limits<unsigned>::max()) throw fail();
  z_stream state{};
  constexpr int window = 15, gzip = 16;
  if (inflateInit2(&state, window + gzip) != Z_OK) throw fail();
  struct End {
    z_stream& state;
    ~End() { inflateEnd(&state); }
  } end{state};
  state.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  state.avail_in = static_cast<unsigned>(packed.size());
  std::string result;
  while (true) {
    const std::size_t had = result.size(), step = std::max(std::size_t{1} << 16, had / 2);
    budget.take(step, name + ", unpacked,", where);
    result.resize(had + step);
    state.next_out = reinterpret_cast<Bytef*>(result.data() + had);
    state.avail_out = static_cast<unsigned>(std::min<std::size_t>(step, 1U << 30));
    const std::size_t room = state.avail_out;
    const int code = inflate(&state, Z_NO_FLUSH);
    result.resize(had + room - state.avail_out);
    if (code == Z_STREAM_END) {
      if (state.avail_in == 0) return result;
      if (inflateReset(&state) != Z_OK) throw fail();  // members one after the other are one file
    } else if (code != Z_OK || (state.avail_in == 0 && result.size() == had)) {
      throw fail();
    }
  }
}

#else

std::string unpacked_gzip(const std::string&, const std::string& name, LoadBudget&, const SourcePosition& where) {
  throw InputError(where,
                   name + " cannot be unpacked: this program was built without the library zlib, which reads gzip");
}

#endif

}  // namespace gmis::tools
