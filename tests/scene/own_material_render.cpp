#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cloth.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/scene.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/mean_of_iterations.hpp"
#include "transport/ways.hpp"

// Cloth and the materials of the library in one scene: path tracing, bidirectional path tracing and
// vertex connection and merging have one mean.

namespace {

using gmis_test::Mean;
using Bsdf = gmis::scene::EitherBsdf<gmis::scene::SurfaceBsdf<float>, own::ClothBsdf>;
using Scene = gmis::scene::BvhScene<float, Bsdf>;

/// A box of cloth with a light, a mirror ball and a ball of Phong in it: most light has met cloth
/// more than once.
Scene make_scene() {
  gmis::scene::SceneBuilder<float, Bsdf> builder;
  const auto velvet = builder.add_material(own::make_cloth({0.4F, 0.3F, 0.3F}, {0.9F, 0.8F, 0.7F}, 0.3F));
  const auto linen = builder.add_material(own::make_cloth({0.5F, 0.5F, 0.6F}, {0.2F, 0.2F, 0.2F}, 0.8F));
  const auto mirror = builder.add_material(gmis::scene::make_mirror({0.9, 0.9, 0.9}));
  const auto phong = builder.add_material(gmis::scene::make_phong({0.3, 0.3, 0.3}, {0.4, 0.4, 0.4}, 10));
  const auto black = builder.add_material(gmis::scene::make_diffuse({0, 0, 0}));
  std::vector<glm::dvec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 1.5 : -1.5, i & 2 ? 1.2 : -1.2, i & 4 ? 2.5 : -1.0);
  const std::vector<std::array<int, 3>> walls{{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}};
  const std::vector<std::array<int, 3>> others{{2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 3, 7}, {1, 7, 5}};
  builder.add_mesh({corners, walls}, velvet);
  builder.add_mesh({corners, others}, linen);
  builder.add_sphere({-0.5, -0.6, 1.4}, 0.5, mirror);
  builder.add_sphere({0.6, -0.5, 1.6}, 0.5, phong);
  builder.add_sphere({0.2, 0.8, 1.0}, 0.2, black, gmis::scene::AreaEmission{{10, 10, 10}});
  builder.set_camera(gmis::scene::look_at({0, 0, -0.5}, {0, -0.1, 1}, {0, 1, 0}, 70, {24, 24}));
  return builder.build();
}

template <class I>
Mean render(const Scene& scene, std::uint64_t seed, int iterations) {
  gmis::RenderSettings settings;
  settings.max_depth = 8;
  settings.radius = 0.02;
  settings.alpha = 1.0;
  settings.seed = gmis_test::seed(seed);
  typename I::template Engine<Scene> engine(scene, I::settings(settings));
  const Mean mean = gmis_test::mean_of_iterations(engine, iterations);
  CHECK(engine.counters().rejected_non_finite + engine.counters().rejected_negative == 0);
  return mean;
}

}  // namespace

TEST_CASE("cloth and the library's materials: pt, bpt and vcm have one mean") {
  using namespace gmis_test::ways;
  const Scene scene = make_scene();
  constexpr int iterations = 400;
  const Mean pt = render<Pt>(scene, 71, iterations), bpt = render<Bpt>(scene, 72, iterations),
             vcm = render<Vcm>(scene, 73, iterations);
  // Student's t with the degrees of one run: a false alarm of the three comparisons together in a
  // thousandth of the seeds.
  const double limit = gmis::student_t_quantile(1 - gmis::sidak_level(1e-3, 3) / 2, iterations - 1);
  const auto compare = [&](const Mean& a, const Mean& b, double bias) {
    const double error = std::hypot(a.standard_error, b.standard_error);
    CAPTURE(a.value, b.value, error);
    CHECK(std::abs(a.value - b.value) < limit * error + bias * a.value);
    CHECK(limit * error < 0.02 * a.value);  // so that an error of 2 % would show: it is 1.7 ± 0.06 %
  };
  compare(pt, bpt, 0);
  compare(pt, vcm, 0.001);  // what merging within 0.02 of walls some 3 apart may be off by
  compare(bpt, vcm, 0.001);
}
