#include <cmath>
#include <cstdio>
#include <gmis/gmis.hpp>
#include <gmis/render/thread_executor.hpp>

int main() {  // ./first_render >picture.ppm
  gmis::scene::SceneBuilder<> builder;
  const auto white = builder.add_material(gmis::scene::make_diffuse({0.7, 0.7, 0.7}));
  const auto glass = builder.add_material(gmis::scene::make_dielectric(1.5));
  builder.add_sphere({0, -101, 0}, 100, white);
  builder.add_sphere({0, 0, 0}, 1, glass);
  builder.add_sphere({2, 4, -1}, 0.7, white, gmis::scene::AreaEmission{{60, 60, 60}});
  builder.set_camera(gmis::scene::look_at({0, 2, -6}, {0, 0, 0}, {0, 1, 0}, 40, {160, 120}));
  const auto scene = builder.build();

  gmis::ThreadExecutor threads;
  const auto request = gmis::automatic_request(scene, {.iterations = 16});
  const gmis::RenderResult result = gmis::Render(scene, request).run(threads);
  if (result.error) std::fprintf(stderr, "relative error %.4f\n", result.error->relative_error);
  std::printf("P3 160 120 255\n");
  for (const float value : result.picture.values) std::printf("%.0f ", 255 * std::sqrt(std::fmin(value, 1.0F)));
}
