#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "hand/sums.hpp"

namespace hand {

double sum_by_engine(const gmis::scene::BvhScene<float>& scene, std::uint32_t iterations) {
  gmis::RenderSettings settings;
  settings.seed = 1;
  settings.max_depth = max_depth;
  settings.counts = gmis::integrators::pt;
  gmis::PathTracer<gmis::scene::BvhScene<float>> engine(scene, settings);
  gmis::SerialExecutor executor;
  double sum = 0;
  for (std::uint32_t i = 1; i <= iterations; ++i) {
    engine.iterate(executor);
    for (const gmis::Vec3<float>& value : engine.frame()) sum += static_cast<double>(gmis::mean_channel(value));
  }
  return sum;
}

}  // namespace hand
