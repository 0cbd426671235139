#include <algorithm>
#include <cmath>
#include <vector>

#include "gmis/scene.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/ways.hpp"

// A furnace without symmetry: a closed box whose walls emit 1 and reflect the share a; in it a
// mirror ball that does the same and a ball of clear glass, which in uniform light cannot be seen.
// Radiance is 1/(1 − a) everywhere but in the glass, in every direction; with a = 0.5 and 24 edges
// (a chain through glass is longer than its reflections are many) all but 1e-6 of it is there.
// Every weight, cosine and density of delta and diffuse vertices, of lights hit by chance, must be
// right for it.

namespace {

using Scene = gmis::scene::BvhScene<float>;

Scene make_scene(bool with_balls = true) {
  gmis::scene::SceneBuilder<float> builder;
  const auto wall = builder.add_material(gmis::scene::make_diffuse({0.5, 0.5, 0.5}));
  const auto mirror = builder.add_material(gmis::scene::make_mirror({0.5, 0.5, 0.5}));
  const auto glass = builder.add_material(gmis::scene::make_dielectric(1.5));
  const gmis::scene::AreaEmission emission{{1.0, 1.0, 1.0}, true};
  std::vector<glm::dvec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 1.7 : -1.1, i & 2 ? 1.0 : -1.2, i & 4 ? 2.5 : -0.6);
  const std::vector<std::array<int, 3>> triangles{{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                                  {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 3, 7}, {1, 7, 5}};
  builder.add_mesh({corners, triangles}, wall, emission);
  if (with_balls) {
    builder.add_sphere({-0.4, -0.5, 1.5}, 0.5, mirror, emission);
    builder.add_sphere({0.7, 0.2, 1.2}, 0.55, glass);
  }
  builder.set_camera(gmis::scene::look_at({0, 0, 0}, {0.1, 0, 1}, {0, 1, 0}, 70, {20, 20}));
  return builder.build();
}

constexpr gmis::SampleCounts connect_splat_merge = gmis::integrators::vcm.only(
    [](gmis::Technique t) { return t != gmis::Technique::emitter_hit && t != gmis::Technique::next_event; });
constexpr gmis::SampleCounts connect_splat =
    connect_splat_merge.only([](gmis::Technique t) { return t != gmis::Technique::merge; });
using ConnectSplat = gmis_test::ways::Way<gmis::BothSides, connect_splat>;
using ConnectSplatMerge = gmis_test::ways::Way<gmis::BothSides, connect_splat_merge>;

struct Measured {
  double mean, standard_error, smallest, largest;
};

template <class I>
Measured render(double light_paths, double radius, int iterations, bool with_balls = true) {
  const Scene scene = make_scene(with_balls);
  gmis::RenderSettings settings;
  settings.max_depth = 24;
  settings.radius = radius;
  settings.alpha = 1.0;
  settings.counts.light_paths = light_paths;
  settings.seed = gmis_test::seed(23);
  typename I::template Engine<Scene> engine(scene, I::settings(settings));
  gmis::SerialExecutor executor;
  double sum = 0.0, squares = 0.0;
  std::vector<double> pixels(engine.frame().size());
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    double mean = 0.0;
    for (std::size_t p = 0; p < pixels.size(); ++p) {
      const double value = static_cast<double>(gmis::mean_channel(engine.frame()[p]));
      mean += value / static_cast<double>(pixels.size());
      pixels[p] += value / iterations;
    }
    sum += mean;
    squares += mean * mean;
  }
  CHECK(engine.counters().rejected_non_finite + engine.counters().rejected_negative == 0);
  const double mean = sum / iterations;
  return {mean, std::sqrt(std::max(0.0, squares / iterations - mean * mean) / (iterations - 1)),
          *std::min_element(pixels.begin(), pixels.end()), *std::max_element(pixels.begin(), pixels.end())};
}

/// `bias`: what merging may be off by.
void check(const Measured& measured, double bias) {
  CAPTURE(measured.mean, measured.standard_error, measured.smallest, measured.largest);
  // 4.5 standard errors: a false alarm in 7e-6 of the cases. Each sees an error of 1.5 %, most one
  // of 0.7 %.
  CHECK(std::abs(measured.mean - 2.0) < 4.5 * measured.standard_error + 2.0 * bias);
  CHECK(measured.standard_error < 0.006);
}

}  // namespace

TEST_CASE("a furnace with a mirror and glass in it is uniform for every integrator") {
  using namespace gmis_test::ways;
  SECTION("pt") {
    check(render<Pt>(1.0, 0.0, 600), 0.0);
  }
  SECTION("bpt") {
    check(render<Bpt>(1.0, 0.0, 400), 0.0);
  }
  SECTION("vcm") {
    check(render<Vcm>(1.0, 0.03, 400), 0.003);
  }
  SECTION("vcm where merging does most of it") {
    check(render<Vcm>(16.0, 0.06, 100), 0.006);
  }
  SECTION("vcm with few light paths") {
    check(render<Vcm>(0.3, 0.03, 500), 0.003);
  }
}

TEST_CASE("light that only connections, splats and merges make is right in a furnace") {
  // Without emitter hits the empty box shows what has been reflected at least once: 1/(1 − a) −
  // 1 = 1. Every such path has a splat; connections and merges share the longer ones.
  using namespace gmis_test::ways;
  const auto off = [](const Measured& measured, double bias) {
    CAPTURE(measured.mean, measured.standard_error);
    CHECK(std::abs(measured.mean - 1.0) < 4.5 * measured.standard_error + bias);
    CHECK(measured.standard_error < 0.0045);  // so that 2 % would show
  };
  SECTION("connect and splat") {
    off(render<ConnectSplat>(1.0, 0.0, 600, false), 0.0);
  }
  SECTION("connect, splat and merge") {
    off(render<ConnectSplatMerge>(1.0, 0.1, 600, false), 0.003);
  }
}
