#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "support/executor.hpp"
#include "support/load_scene.hpp"
#include "support/report/records.hpp"
#include "support/session.hpp"

namespace gmis::tools {

/// The scenes and integrators that are to be compared, and how far.
struct ComparisonRequest {
  struct Contender {
    IntegratorChoice integrator;
    SplitChoice split;
    std::string name;
  };
  using Size = std::optional<std::array<int, 2>>;
  /// Loads a scene, as `load_scene` does.
  std::function<LoadedScene(const std::filesystem::path& file, Size size, scene::LightSelection lights)> load;
  std::vector<std::string> scenes;
  std::vector<Contender> contenders;
  Size size;
  /// Depth, radius and the like. Its integrator, lights, emission, size and limits are not used.
  Options settings;
  std::optional<double> cpu_seconds;  ///< per integrator and seed
  std::optional<double> error;        ///< against the reference
  std::uint32_t seeds = 3;
  std::filesystem::path reference;  ///< empty: one is made for each scene
  double reference_seconds = 0;     ///< processor time for making one; 0: none is made, errors are estimated
  /// The integrators that make the references: one for all scenes or one for each.
  std::vector<IntegratorChoice> reference_integrators{IntegratorChoice::bpt};
  std::filesystem::path folder;  ///< for references, logs and whatever else is written
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(const std::string&)> say;      ///< one line about what is being done
  std::function<void(const Comparison&)> on_scene;  ///< whenever there is more to show
};

/// "vcm", "gmis" or, with a way to split, "gmis/paper". Throws `InputError`.
[[nodiscard]] ComparisonRequest::Contender contender_of(const std::string& name);

/// Runs the integrators on every scene, seed after seed: after each iteration the turn goes to the
/// one that has had the least processor time. Ends early when interrupted; what there is then is
/// valid.
[[nodiscard]] Comparison compare(const ComparisonRequest& request, ThreadedExecutor& executor);

}  // namespace gmis::tools
