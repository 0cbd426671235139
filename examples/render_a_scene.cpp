#include <cstdio>
#include <gmis/render.hpp>
#include <gmis/render/thread_executor.hpp>
#include <gmis/scene.hpp>

// A complete program: a scene, its picture with an error of 5 %, and what a smaller error would
// take.

int main() {
  // The built-in scene. Any type that meets gmis::Scene can stand in its place.
  gmis::scene::SceneBuilder<> builder;
  const auto white = builder.add_material(gmis::scene::make_diffuse({0.7, 0.7, 0.7}));
  const auto glass = builder.add_material(gmis::scene::make_dielectric(1.5));
  const auto black = builder.add_material(gmis::scene::make_diffuse({0, 0, 0}));
  builder.add_sphere({0, -101, 0}, 100, white);
  builder.add_sphere({0, 0, 0}, 1, glass);
  builder.add_sphere({2, 4, -1}, 0.7, black, gmis::scene::AreaEmission{{20, 20, 20}});
  builder.set_camera(gmis::scene::look_at({0, 2, -6}, {0, 0, 0}, {0, 1, 0}, 40, {96, 72}));
  const auto scene = builder.build();

  gmis::ThreadExecutor threads;
  const auto request = gmis::automatic_request(scene, {.iterations = 500, .relative_error = 0.05});
  const gmis::RenderResult result = gmis::Render(scene, request).run(threads);

  std::printf("%u iterations, stopped by %s, mean %.4f\n", result.iterations, gmis::name_of(result.stopped_by),
              result.estimate.mean);
  if (result.error) std::printf("relative error %.4f\n", result.error->relative_error);
  if (result.prices)
    for (const gmis::Price& price : result.prices->prices)
      std::printf("error %.4f: %.0f iterations, %.1f s\n", price.error, price.iterations, price.wall_seconds);
  // result.picture.values: three floats for each pixel, rows from the top.
  return result.is_trustworthy ? 0 : 1;
}
