#include "hand/path_tracer.hpp"
#include "hand/sums.hpp"

namespace hand {

double sum_by_hand(const gmis::scene::BvhScene<float>& scene, std::uint32_t iterations) {
  const PathTracer tracer{scene, 1, max_depth};
  double sum = 0;
  for (std::uint32_t i = 1; i <= iterations; ++i)
    for (const gmis::Vec3<float>& value : tracer.iterate(i)) sum += static_cast<double>(gmis::mean_channel(value));
  return sum;
}

}  // namespace hand
