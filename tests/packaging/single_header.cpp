#include <gmis_single.hpp>

#include <cmath>
#include <cstdlib>

// The single header alone: an estimate, a scene of the built-in layer and its effects. That two
// files may include the same headers is tested in tests/linkage.

namespace {
struct Half {
  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  double pdf(double) const { return 1.0; }
};
}  // namespace

int main() {
  gmis::Philox source(1);
  const std::array<Half, 1> proposals{};
  const auto estimate = gmis::estimate<gmis::Scheme::N3>([](double x) { return x; }, proposals, 10'000, source);
  gmis::scene::SceneBuilder<float> builder;
  builder.add_sphere({0, 0, 5}, 1, builder.add_material(gmis::scene::make_diffuse<float>({0.5, 0.5, 0.5})));
  builder.set_camera(gmis::scene::look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 40, {4, 4}));
  const auto scene = builder.build();
  const auto hit = scene.intersect({{0, 0, 0}, {0, 0, 1}});
  const bool is_right = std::abs(estimate.mean - 0.5) < 0.02 && hit && std::abs(hit->point.position.z - 4.0F) < 1e-3F;
  return is_right ? EXIT_SUCCESS : EXIT_FAILURE;
}
