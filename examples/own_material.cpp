#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <gmis/core/statistics.hpp>
#include <gmis/scene.hpp>
#include <gmis/transport.hpp>

#include "cloth.hpp"

// Your own material (cloth.hpp) beside those of the library, in one scene, rendered by path
// tracing and by vertex connection and merging. Both must have the same mean: the program fails
// where they have not.

namespace {

using Bsdf = gmis::scene::EitherBsdf<gmis::scene::SurfaceBsdf<float>, own::ClothBsdf>;
using Scene = gmis::scene::BvhScene<float, Bsdf>;

Scene make_scene() {
  gmis::scene::SceneBuilder<float, Bsdf> builder;
  const auto floor = builder.add_material(gmis::scene::make_diffuse({0.6, 0.5, 0.4}));
  const auto velvet = builder.add_material(own::make_cloth({0.3F, 0.05F, 0.08F}, {0.9F, 0.7F, 0.7F}, 0.3F));
  const auto mirror = builder.add_material(gmis::scene::make_mirror({0.9, 0.9, 0.9}));
  const auto black = builder.add_material(gmis::scene::make_diffuse({0, 0, 0}));

  const std::array<glm::dvec3, 4> corners{{{-3, -1, -3}, {3, -1, -3}, {3, -1, 3}, {-3, -1, 3}}};
  const std::array<std::array<int, 3>, 2> triangles{{{0, 1, 2}, {0, 2, 3}}};
  builder.add_mesh({corners, triangles}, floor);
  builder.add_sphere({-0.7, 0, 0}, 1, velvet);
  builder.add_sphere({1.3, -0.3, 0.3}, 0.7, mirror);
  builder.add_sphere({0, 4, -1}, 0.8, black, gmis::scene::AreaEmission{{12, 12, 12}});
  builder.set_camera(gmis::scene::look_at({0, 0.7, -6}, {0, -0.2, 0}, {0, 1, 0}, 40, {32, 24}));
  return builder.build();
}

struct Measured {
  double mean, standard_error;
};

/// The mean of the picture, with the standard error that independent iterations show.
template <class Engine>
Measured render(const Scene& scene, const gmis::SampleCounts& counts, std::uint64_t seed, int iterations) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 8;
  settings.radius = 0.01;  // small beside the spheres: the bias of merging is far below the noise here
  settings.seed = seed;
  Engine engine(scene, settings);
  gmis::SerialExecutor executor;
  double sum = 0, squares = 0;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    double mean = 0;
    for (const auto& pixel : engine.frame()) mean += static_cast<double>(gmis::mean_channel(pixel));
    mean /= static_cast<double>(engine.frame().size());
    sum += mean;
    squares += mean * mean;
  }
  const double mean = sum / iterations;
  return {mean, std::sqrt(std::max(0.0, squares / iterations - mean * mean) / (iterations - 1))};
}

}  // namespace

int main() {
  const Scene scene = make_scene();
  constexpr int iterations = 200;
  const Measured pt = render<gmis::Engine<Scene, gmis::CameraSide>>(scene, gmis::integrators::pt, 1, iterations);
  const Measured vcm = render<gmis::Engine<Scene, gmis::BothSides>>(scene, gmis::integrators::vcm, 2, iterations);
  std::printf("pt   mean %.5f, standard error %.5f\n", pt.mean, pt.standard_error);
  std::printf("vcm  mean %.5f, standard error %.5f\n", vcm.mean, vcm.standard_error);

  // Seeds are fixed: this either always passes or never. With others it would fail once in 10,000
  // runs by chance.
  const double error = std::hypot(pt.standard_error, vcm.standard_error);
  const gmis::StatisticalTest test = gmis::t_test(vcm.mean - pt.mean, error, iterations, 0);
  const bool agree = test.passes(1e-4);
  std::printf("they %s: t = %.2f\n", agree ? "agree" : "differ", test.statistic);
  return agree ? 0 : 1;
}
