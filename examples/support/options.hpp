#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gmis/mis/scheme.hpp"

namespace gmis::tools {

enum class IntegratorChoice { pt, bpt, vcm, gmis };
enum class SplitChoice { none, paper, budgeted };

/// What the command line of gmis-render asks for.
struct Options {
  std::string scene;
  bool list_scenes = false;
  IntegratorChoice integrator = IntegratorChoice::gmis;
  SplitChoice split = SplitChoice::budgeted;
  Scheme scheme = Scheme::N3;
  std::optional<std::array<int, 2>> size;
  int max_depth = 16;
  double radius = 0.003;  ///< as a fraction of half the scene's diagonal
  double alpha = 2.0 / 3.0;
  double light_paths = 1;
  std::uint64_t seed = 0;
  int threads = 0;  ///< 0: all cores
  std::optional<std::uint32_t> iterations;
  std::optional<double> seconds;
  std::optional<double> relative_error;
  std::optional<std::array<int, 4>> crop;
  std::filesystem::path techniques_folder;
  bool halves = false;
  std::vector<std::filesystem::path> outputs;
  std::filesystem::path statistics_file;
  std::filesystem::path reference_file;
  bool explain = false;
  bool quiet = false;
};

/// Nothing when the text of --help or --version was printed and all is done.
/// Throws `InputError` for a command line that is not understood.
[[nodiscard]] std::optional<Options> parse_command_line(int argc, char** argv);

[[nodiscard]] const char* name_of(IntegratorChoice integrator);
[[nodiscard]] const char* name_of(SplitChoice split);

}  // namespace gmis::tools
