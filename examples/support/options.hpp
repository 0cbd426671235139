#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/mis/scheme.hpp"
#include "gmis/render/render_request.hpp"
#include "gmis/scene/light_selection.hpp"
#include "gmis/transport/state/path_class.hpp"
#include "gmis/transport/state/settings.hpp"
#include "support/image/image.hpp"
#include "support/load_options.hpp"

namespace gmis::tools {

enum class IntegratorChoice { pt, lt, bpt, ppm, bpm, vcm, gmis, automatic };
enum class SplitChoice { none, paper, budgeted, local };

/// A merging radius as --radius has it.
struct RadiusChoice {
  double value = 0.4;
  bool is_in_scene_units = false;  ///< else in pixel widths (transport/photons/pixel_width.hpp)
};

/// One path of a run, as the command line names it.
struct PathChoice {
  std::uint32_t iteration = 1;
  bool is_light = false;
  std::uint32_t number = 0;                           ///< of the light tree, or index of the pixel in the frame
  std::optional<std::array<std::uint32_t, 2>> pixel;  ///< column and row, which then replace the index
};

/// The options of gmis-render's command line.
struct Options {
  std::string scene;
  LoadOptions load;
  bool list_scenes = false;
  IntegratorChoice integrator = IntegratorChoice::automatic;
  SplitChoice split = SplitChoice::local;
  Scheme scheme = Scheme::N3;
  Sampler sampler = Sampler::sobol;
  Emission emission = Emission::power;                             ///< of light subpaths
  scene::LightSelection lights = scene::LightSelection::by_power;  ///< of next events
  std::optional<std::array<int, 2>> size;
  int max_depth = 16;
  std::optional<RadiusChoice> radius;  ///< unset: 0.4 pixel widths, more where merging has a local count
  double alpha = 2.0 / 3.0;
  std::optional<double> light_paths;  ///< 1 where nothing chooses
  std::optional<int> connections;     ///< light vertices drawn per camera vertex; unset: a pilot chooses
  bool connects_paired_tree = false;  ///< all vertices of one light tree, in place of drawn ones
  std::uint64_t seed = 0;
  int threads = 0;  ///< 0: all cores
  std::optional<std::uint32_t> iterations;
  std::optional<std::uint32_t> expected_iterations;  ///< that a pilot chooses for; unset: by what ends the run
  std::optional<RunPart> part;                       ///< the part to render of a run of that number of iterations
  std::optional<double> seconds;
  std::optional<double> relative_error;
  std::optional<std::array<int, 4>> crop;
  double max_rejected = 1e-4;        ///< share of the contributions that may be rejected
  bool list_rejected = false;        ///< print the paths that were
  std::optional<PathChoice> replay;  ///< instead of rendering
  std::filesystem::path techniques_folder;
  std::string effects;                       ///< as given; empty: all
  std::optional<PathClassSet> path_classes;  ///< those that --effects leaves
  bool class_images = false;                 ///< --aov classes
  bool layers = false;                       ///< --aov layers
  bool technique_layers = false;             ///< --aov techniques
  bool light_layers = false;                 ///< --aov lights
  std::optional<double> exposure;            ///< of .png, in powers of two; nothing: by the picture
  ToneCurve tone = ToneCurve::clamp;         ///< of .png
  std::string command_line;
  bool halves = false;
  bool denoise = false;
  std::vector<std::filesystem::path> outputs;
  std::filesystem::path statistics_file;
  std::filesystem::path log_file;
  std::filesystem::path checkpoint_file;
  std::vector<std::filesystem::path> resume_files;  ///< one: go on from it; several: join their runs
  double write_every = 30;  ///< seconds between pictures and checkpoints on disk while the run goes on
  std::string tev_address;  ///< HOST:PORT of the viewer tev; empty: none
  std::filesystem::path reference_file;
  bool check = false;    ///< read the scene, and say all that is not supported
  bool lenient = false;  ///< input that is not supported is a warning
  bool explain = false;
  bool quiet = false;
};

/// Nothing when the text of --help or --version was printed and all is done.
/// Throws `InputError` for a command line that is not understood.
[[nodiscard]] std::optional<Options> parse_command_line(int argc, char** argv);

/// The integrators that always have the same techniques.
inline constexpr std::array all_integrators{IntegratorChoice::pt,  IntegratorChoice::lt,  IntegratorChoice::bpt,
                                            IntegratorChoice::ppm, IntegratorChoice::bpm, IntegratorChoice::vcm,
                                            IntegratorChoice::gmis};
/// Whether the integrator connects camera vertices with light vertices, and whether it merges them;
/// true for `automatic`, which may do so.
[[nodiscard]] bool connects(IntegratorChoice integrator);
[[nodiscard]] bool merges(IntegratorChoice integrator);
/// Whether it traces light subpaths, and whether it samples lights from camera vertices.
[[nodiscard]] bool traces_light(IntegratorChoice integrator);
[[nodiscard]] bool makes_next_events(IntegratorChoice integrator);
/// How it chooses lights, and where its light subpaths start, where nothing else is asked for.
[[nodiscard]] scene::LightSelection default_lights(IntegratorChoice integrator);
[[nodiscard]] Emission default_emission(IntegratorChoice integrator);

// Parsers of option values; they throw `InputError`, which names the option, for an invalid text.
[[nodiscard]] IntegratorChoice integrator_of(const std::string& name, const std::string& option = "--integrator");
[[nodiscard]] SplitChoice split_of(const std::string& name, const std::string& option = "--split");
[[nodiscard]] std::array<int, 2> size_of(const std::string& text);
[[nodiscard]] PathChoice path_choice_of(const std::string& text);
[[nodiscard]] RadiusChoice radius_of(const std::string& text);
[[nodiscard]] std::uint64_t seed_of(const std::string& text);
void require_above_zero(const char* option, double value);
/// Depth, number of light trees and alpha, which must be in their ranges.
void require_in_range(const Options& options);
[[nodiscard]] std::string argument_of(double value);                ///< the shortest text that reads as this value
[[nodiscard]] std::string argument_of(const RadiusChoice& radius);  ///< what `radius_of` reads
[[nodiscard]] std::string text_of(const RadiusChoice& radius);      ///< for a reader

[[nodiscard]] const char* name_of(IntegratorChoice integrator);
[[nodiscard]] const char* name_of(SplitChoice split);
[[nodiscard]] const char* name_of(scene::LightSelection lights);

}  // namespace gmis::tools
