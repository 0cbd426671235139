// Whether MIS compensation of a sky pays: mean squared error of path tracing with next-event
// samples in proportion to the radiance, and compensated for a fraction of samples that scatter, at
// equal paths.
#include <cmath>
#include <cstdio>
#include <gmis/scene.hpp>
#include <gmis/transport.hpp>
#include <vector>

#include "scene/sky_world.hpp"

namespace {

using Scene = gmis::scene::BvhScene<float>;

/// The sum of all channels of the mean picture of `iterations`.
std::vector<double> picture(const Scene& scene, const gmis::SampleCounts& counts, int max_depth, std::uint64_t seed,
                            int iterations) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = max_depth;
  settings.seed = seed;
  gmis::Engine<Scene, gmis::CameraSide> engine(scene, settings);
  gmis::SerialExecutor executor;
  std::vector<double> sum;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    const auto& frame = engine.frame();
    sum.resize(frame.size());
    for (std::size_t p = 0; p < frame.size(); ++p)
      sum[p] += static_cast<double>(gmis::mean_channel(frame[p])) / iterations;
  }
  return sum;
}

}  // namespace

/// A line for each sky and depth, of both and of error and standard error, times 10⁴, for each
/// fraction.
int main() {
  constexpr int width = 48, runs = 24, iterations = 4, reference_iterations = 4000;
  for (const auto sky : sky_world::all_skies)
    for (const int depth : {2, 5}) {
      const auto reference =
          picture(sky_world::make_scene(sky, 1.0, width), gmis::integrators::pt, depth, 1, reference_iterations);
      std::printf("%s %d", sky_world::name_of(sky), depth);
      for (const double fraction : {1.0, 0.75, 0.5}) {
        const auto scene = sky_world::make_scene(sky, fraction, width);
        double sum = 0, squares = 0;
        for (int run = 0; run < runs; ++run) {
          const auto image =
              picture(scene, gmis::integrators::pt, depth, 100 + static_cast<std::uint64_t>(run), iterations);
          double error = 0;
          for (std::size_t p = 0; p < image.size(); ++p)
            error += (image[p] - reference[p]) * (image[p] - reference[p]) / static_cast<double>(image.size());
          sum += error / runs;
          squares += error * error / runs;
        }
        const double spread = std::sqrt(std::max(0.0, squares - sum * sum) / (runs - 1));
        std::printf(" %.3f %.3f", 1e4 * sum, 1e4 * spread);
      }
      std::printf("\n");
    }
}
