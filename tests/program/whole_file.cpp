#include "support/whole_file.hpp"

#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "program/scratch_folder.hpp"
#include "support/catch.hpp"
#include "support/diagnostics.hpp"
#include "support/image/image.hpp"

using namespace gmis::tools;
namespace fs = std::filesystem;
using gmis_test::text_of;

namespace {

struct ScratchFolder : gmis_test::ScratchFolder {
  [[nodiscard]] std::ptrdiff_t file_count() const {
    return std::distance(fs::directory_iterator(path), fs::directory_iterator());
  }
};

/// While it lives no file can grow beyond this number of bytes, as on a full disk.
class LimitedFiles {
 public:
  explicit LimitedFiles(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~LimitedFiles() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  LimitedFiles(const LimitedFiles&) = delete;
  LimitedFiles& operator=(const LimitedFiles&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

}  // namespace

TEST_CASE("A text replaces the file that was there, with its permissions, and leaves nothing else") {
  const ScratchFolder folder;
  const fs::path file = folder.path / "a.txt";
  write_whole("old", file);
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
  write_whole("new", file);
  CHECK(text_of(file) == "new");
  CHECK(fs::status(file).permissions() == (fs::perms::owner_read | fs::perms::owner_write));
  CHECK(folder.file_count() == 1);
}

TEST_CASE("When writing fails the old file stays whole, and nothing else is left") {
  const ScratchFolder folder;
  const fs::path file = folder.path / "a.txt";
  write_whole("old", file);
  CHECK_THROWS_AS(write_whole(file,
                              [](const fs::path& part) {
                                std::ofstream(part) << "half";
                                throw OutputError("no more");
                              }),
                  OutputError);
  CHECK(text_of(file) == "old");
  CHECK(folder.file_count() == 1);
  {
    const LimitedFiles limit(1000);
    CHECK_THROWS_AS(write_whole(std::string(5000, 'x'), file), OutputError);
    CHECK(text_of(file) == "old");
    CHECK(folder.file_count() == 1);
    for (const char* name : {"a.pfm", "a.exr", "a.png"}) {
      CAPTURE(name);
      Image image(100, 100);
      std::mt19937 source(1);
      for (float& value : image.rgb) value = static_cast<float>(source() % 1000U) / 1000.0F;
      try {
        require_writable_format(name);
      } catch (const InputError&) {
        continue;  // not in this build
      }
      write_whole("old", folder.path / name);
      CHECK_THROWS_AS(write_image(image, folder.path / name), OutputError);
      CHECK(text_of(folder.path / name) == "old");
    }
  }
  write_whole("new", file);
  CHECK(text_of(file) == "new");
}

TEST_CASE("A link goes on pointing where it did") {
  const ScratchFolder folder;
  fs::create_directory(folder.path / "elsewhere");
  write_whole("old", folder.path / "elsewhere/a.txt");
  fs::create_symlink("elsewhere/a.txt", folder.path / "link");
  write_whole("new", folder.path / "link");
  CHECK(fs::is_symlink(folder.path / "link"));
  CHECK(text_of(folder.path / "elsewhere/a.txt") == "new");
  fs::remove(folder.path / "elsewhere/a.txt");
  fs::create_symlink("link", folder.path / "link of a link");
  write_whole("newer", folder.path / "link of a link");
  CHECK(text_of(folder.path / "elsewhere/a.txt") == "newer");
  fs::create_symlink("absent/a.txt", folder.path / "to no folder");
  CHECK_THROWS_AS(require_writable(folder.path / "to no folder"), InputError);
}

TEST_CASE("What is no regular file is written, not replaced") {
  write_whole("gone", "/dev/null");
  CHECK(fs::is_character_file("/dev/null"));
  CHECK_NOTHROW(require_writable("/dev/null"));
}

TEST_CASE("What cannot be written is known before the work") {
  const ScratchFolder folder;
  CHECK_NOTHROW(require_writable(folder.path / "a.txt"));
  CHECK(folder.file_count() == 0);
  write_whole("old", folder.path / "a.txt");
  CHECK_NOTHROW(require_writable(folder.path / "a.txt"));
  CHECK(text_of(folder.path / "a.txt") == "old");
  CHECK_THROWS_AS(require_writable(folder.path), InputError);
  CHECK_THROWS_AS(require_writable(folder.path / "absent/a.txt"), InputError);
  CHECK_THROWS_AS(write_whole("text", folder.path), OutputError);
}
