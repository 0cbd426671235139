#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "program/scratch_folder.hpp"

/// \file
/// Runs gmis-render as a user does.

namespace program {

namespace fs = std::filesystem;
using gmis_test::ScratchFolder;
using gmis_test::text_of;

struct Outcome {
  int exit_code = -1;  ///< −1 when it was ended by a signal
  std::string out, err;
};

/// Runs a program with `arguments` (as a shell reads them) in `folder`, after the shell has done
/// what comes `before`.
inline Outcome run_program(const std::string& file, const ScratchFolder& folder, const std::string& arguments,
                           const std::string& before = ":") {
  const std::string command = "cd '" + folder.path.string() + "' && " + before + " && '" + file + "' " + arguments +
                              " >stdout.txt 2>stderr.txt </dev/null";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(folder.path / "stdout.txt"),
          text_of(folder.path / "stderr.txt")};
}

/// Runs the program that this test is about.
inline Outcome run(const ScratchFolder& folder, const std::string& arguments, const std::string& before = ":") {
  return run_program(GMIS_RENDER_PROGRAM, folder, arguments, before);
}

/// Waits until `file` holds `text` this number of times. Returns false, with the exit code in
/// `status`, where the program has ended before. There is no time limit.
inline bool wait_for(pid_t child, const fs::path& file, const std::string& text, int times, int& status) {
  while (true) {
    const bool has_ended = waitpid(child, &status, WNOHANG) == child;
    const std::string content = text_of(file);
    int found = 0;
    for (std::size_t at = content.find(text); at != std::string::npos; at = content.find(text, at + text.size()))
      ++found;
    if (found >= times) return !has_ended;
    if (has_ended) return false;
    usleep(10'000);
  }
}

inline std::size_t line_count(const std::string& text) {
  std::size_t lines = 0;
  for (const char c : text) lines += c == '\n' ? 1 : 0;
  return lines;
}

/// The beginning of a scene whose next events must choose between two lamps.
inline const char* const two_lamps_over_a_floor = R"(LookAt 0 2 -6 0 0 0 0 1 0 Camera "perspective" "float fov" 60
WorldBegin
LightSource "point" "rgb I" [ 9 9 9 ] "point3 from" [ -2 1 0 ]
LightSource "point" "rgb I" [ 9 9 9 ] "point3 from" [ 2 1 0 ]
Shape "bilinearmesh" "point3 P" [ -3 0 -3  3 0 -3  -3 0 3  3 0 3 ]
)";

}  // namespace program
