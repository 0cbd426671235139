#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gmis/result/counters.hpp"
#include "gmis/result/film.hpp"
#include "gmis/transport/contribution.hpp"
#include "gmis/transport/engine.hpp"
#include "gmis/transport/settings.hpp"
#include "support/build_scene.hpp"
#include "support/executor.hpp"
#include "support/image/image.hpp"
#include "support/options.hpp"

namespace gmis::tools {

/// How far a rendering is.
struct Progress {
  std::uint32_t iterations = 0;
  double seconds = 0;
  double relative_error = 0;  ///< 0 while it is not known
};

struct RenderRequest {
  IntegratorChoice integrator = IntegratorChoice::gmis;
  SplitChoice split = SplitChoice::budgeted;
  RenderSettings settings;
  std::optional<PixelBounds> crop;
  // Stops at the first one met; at least one iteration is done.
  std::optional<std::uint32_t> iterations;
  std::optional<double> seconds;  ///< wall time
  std::optional<double> relative_error;
  const std::atomic<bool>* interrupted = nullptr;
  bool halves = false;
  bool techniques = false;
  std::function<void(const Progress&)> on_iteration;
};

/// The part of the image that one technique makes.
struct TechniqueImage {
  TechniqueId id;
  Image weighted;    ///< as it adds to the image
  Image unweighted;  ///< as if it were the only technique
};

struct RenderResult {
  Image image;
  Image half_a, half_b;  ///< means of the odd and of the even iterations, when asked for
  std::vector<TechniqueImage> techniques;
  ImageEstimate estimate;
  Counters counters;
  Tuning tuning;              ///< the counts that the last iteration was made with
  std::vector<Trial> trials;  ///< how they were measured
  PhaseSeconds phases;
  double wall_seconds = 0;
  double cpu_seconds = 0;
  std::uint32_t iterations = 0;
  std::string stopped_by;
  std::size_t photon_bytes = 0;
};

/// Renders on the threads of `executor`.
[[nodiscard]] RenderResult render(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor);

// One per integrator, each in a file of its own: the engine is compiled anew for each.
[[nodiscard]] RenderResult render_pt(const BuiltScene&, const RenderRequest&, ThreadedExecutor&);
[[nodiscard]] RenderResult render_lt(const BuiltScene&, const RenderRequest&, ThreadedExecutor&);
[[nodiscard]] RenderResult render_ppm(const BuiltScene&, const RenderRequest&, ThreadedExecutor&);
[[nodiscard]] RenderResult render_bpm(const BuiltScene&, const RenderRequest&, ThreadedExecutor&);
[[nodiscard]] RenderResult render_bpt(const BuiltScene&, const RenderRequest&, ThreadedExecutor&);
[[nodiscard]] RenderResult render_vcm(const BuiltScene&, const RenderRequest&, ThreadedExecutor&);
[[nodiscard]] RenderResult render_gmis_paper(const BuiltScene&, const RenderRequest&, ThreadedExecutor&);
[[nodiscard]] RenderResult render_gmis_budgeted(const BuiltScene&, const RenderRequest&, ThreadedExecutor&);

}  // namespace gmis::tools
