#include "support/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <fstream>
#include <system_error>

#include "support/diagnostics.hpp"

namespace gmis::tools {
namespace fs = std::filesystem;

fs::path target_of(fs::path file) {
  std::error_code error;
  for (int links = 0; links < 40 && fs::is_symlink(file, error) && !fs::exists(file, error); ++links)
    file = file.parent_path() / fs::read_symlink(file, error);
  if (!fs::is_symlink(file, error)) return file;
  fs::path target = fs::canonical(file, error);
  return error ? file : target;
}

namespace {

/// The number of the process keeps two runs that write the same file apart.
fs::path beside(const fs::path& file) {
  fs::path part = file;
  part += ".part" + std::to_string(getpid());
  return part;
}

bool is_special(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// Some file systems say only now that there was no space.
bool reaches_the_disk(const fs::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_there = fsync(descriptor) == 0;
  return close(descriptor) == 0 && is_there;
}

}  // namespace

void write_whole(const fs::path& file, const std::function<void(const fs::path&)>& write) {
  const fs::path target = target_of(file);
  std::error_code error;
  if (is_special(target)) return write(target);
  const OutputError failure(file.string() +
                            ": this file cannot be written: check that the folder exists and has space");
  if (fs::is_directory(target, error)) throw failure;
  const fs::path part = beside(target);
  try {
    write(part);
    if (!reaches_the_disk(part)) throw failure;
    if (const fs::file_status old = fs::status(target, error); fs::exists(old))
      fs::permissions(part, old.permissions(), error);
    fs::rename(part, target);
  } catch (const OutputError&) {
    fs::remove(part, error);
    throw failure;
  } catch (const fs::filesystem_error&) {
    fs::remove(part, error);
    throw failure;
  } catch (...) {
    fs::remove(part, error);
    throw;
  }
}

void write_whole(const std::string& text, const fs::path& file) {
  write_whole(file, [&](const fs::path& part) {
    std::ofstream stream(part, std::ios::binary);
    stream << text << std::flush;
    if (!stream) throw OutputError(part.string() + ": this file cannot be written");
  });
}

void require_writable(const fs::path& file) {
  const fs::path target = target_of(file);
  std::error_code error;
  if (fs::is_directory(target, error))
    throw InputError(file.string() + ": this file cannot be written: a folder has that name");
  if (is_special(target)) {
    if (access(target.c_str(), W_OK) != 0) throw InputError(file.string() + ": this file cannot be written");
    return;
  }
  const fs::path part = beside(target);
  const bool can_write = static_cast<bool>(std::ofstream(part, std::ios::binary) << '\n' << std::flush);
  fs::remove(part, error);
  if (!can_write)
    throw InputError(file.string() +
                     ": no file can be written in this folder: check that it exists, its permissions and free space");
}

}  // namespace gmis::tools
