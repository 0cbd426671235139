#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/scene.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/mean_of_iterations.hpp"

// The energy of a local count of merging, at radii so large that a factor forgotten at one end of a
// path shows: the means of whole pictures against path tracing, which has no part in it.

namespace {

/// The built-in surfaces without the optional member `has_narrow_lobe()`: every one of them counts
/// as narrow then.
class SilentBsdf {
 public:
  using Inner = gmis::scene::SurfaceBsdf<float>;
  using Spectrum = Inner::Spectrum;
  using Material = Inner::Material;

  SilentBsdf() = default;
  SilentBsdf(const Material& material, const gmis::Vec3<float>& geometric_normal,
             const gmis::Vec3<float>& shading_normal)
      : inner_(material, geometric_normal, shading_normal) {}
  [[nodiscard]] auto evaluate(const gmis::Vec3<float>& to_prev, const gmis::Vec3<float>& to_next,
                              gmis::TransportMode mode) const {
    return inner_.evaluate(to_prev, to_next, mode);
  }
  [[nodiscard]] auto sample(const gmis::Vec3<float>& to_prev, float u, const gmis::Vec2<float>& uv,
                            gmis::TransportMode mode) const {
    return inner_.sample(to_prev, u, uv, mode);
  }
  [[nodiscard]] bool is_purely_delta() const { return inner_.is_purely_delta(); }
  [[nodiscard]] Spectrum albedo() const { return inner_.albedo(); }

 private:
  Inner inner_;
};

static_assert(gmis::BsdfWithNarrowLobes<gmis::scene::SurfaceBsdf<float>>);
static_assert(!gmis::BsdfWithNarrowLobes<SilentBsdf>);

using gmis::scene::Material;

/// A closed box lit by a panel and by a ball that shines and has the material `lamp`; in it a ball
/// of the material `ball` and a coated one, which has a delta lobe beside a diffuse one.
template <class Bsdf>
auto box(const Material<float>& ball, const Material<float>& lamp) {
  gmis::scene::SceneBuilder<float, Bsdf> builder;
  const auto wall = builder.add_material(gmis::scene::make_diffuse({0.6, 0.6, 0.6}));
  const auto coat = builder.add_material(gmis::scene::make_coated_diffuse({0.4, 0.4, 0.4}, 1.5, 0.0));
  std::vector<glm::dvec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  const std::vector<std::array<int, 3>> triangles{{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                                  {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 3, 7}, {1, 7, 5}};
  builder.add_mesh({corners, triangles}, wall);
  const std::vector<glm::dvec3> panel{{-0.5, 0.99, -0.5}, {0.5, 0.99, -0.5}, {0.5, 0.99, 0.5}, {-0.5, 0.99, 0.5}};
  const std::vector<std::array<int, 3>> halves{{0, 1, 2}, {0, 2, 3}};
  builder.add_mesh({panel, halves}, wall, gmis::scene::AreaEmission{{2.0, 2.0, 2.0}, true});
  builder.add_sphere({-0.45, -0.6, 0.3}, 0.4, builder.add_material(ball));
  builder.add_sphere({0.5, -0.65, 0.2}, 0.3, coat);
  builder.add_sphere({0.3, 0.3, 0.6}, 0.25, builder.add_material(lamp),
                     gmis::scene::AreaEmission{{1.0, 1.0, 1.0}, true});
  builder.set_camera(gmis::scene::look_at({0, 0, -0.95}, {0, -0.2, 1}, {0, 1, 0}, 80, {24, 24}));
  return builder.build();
}

using gmis_test::Mean;

gmis::RenderSettings settings_with(const gmis::SampleCounts& counts, double radius = 0.12) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 8;
  settings.radius = radius;
  settings.alpha = 1.0;
  settings.seed = gmis_test::seed(41);
  return settings;
}

template <class Scene>
Mean mean_of(const Scene& scene, const gmis::SampleCounts& counts, int iterations, double radius = 0.12) {
  gmis::Engine<Scene> engine(scene, settings_with(counts, radius));
  const Mean mean = gmis_test::mean_of_iterations(engine, iterations);
  CHECK(engine.counters().rejected() == 0);
  return mean;
}

/// A merge: pixel, vertices of either side, value without its weight.
using Merged = std::tuple<std::uint32_t, int, int, float>;

/// The merges of one iteration with light subpaths of at least `least_s` vertices, in order.
template <class Scene>
std::vector<Merged> merges_of(const Scene& scene, const gmis::SampleCounts& counts, int least_s) {
  gmis::Engine<Scene> engine(scene, settings_with(counts));
  engine.keep_contributions(true);
  gmis::SerialExecutor executor;
  engine.iterate(executor);
  std::vector<Merged> merges;
  engine.for_each_contribution([&](const auto& one) {
    if (one.id.technique == gmis::Technique::merge && one.id.s >= least_s)
      merges.emplace_back(one.pixel, one.id.s, one.id.t, one.value.x);
  });
  std::sort(merges.begin(), merges.end());
  return merges;
}

constexpr gmis::SampleCounts local_vcm = [] {
  gmis::SampleCounts counts = gmis::integrators::vcm_local;
  counts.radius_factor = 1.0;
  return counts;
}();

/// A family of 8 comparisons: a false alarm in a thousandth of the seeds. `bias`: what merging may
/// be off by, relative to all light; merged light is a small part of it.
void check_equal(const Mean& a, const Mean& b, double bias) {
  const double quantile = gmis::normal_quantile(1 - gmis::sidak_level(1e-3, 8) / 2);
  const double error = std::hypot(a.standard_error, b.standard_error);
  CAPTURE(a.value, b.value, a.value / b.value, error / b.value);
  CHECK(std::abs(a.value - b.value) < quantile * error + bias * b.value);
  CHECK(quantile * error < 0.012 * b.value);  // so that 1.5 % shows
}

const Material<float> mirror = gmis::scene::make_mirror({0.9, 0.9, 0.9}), glass = gmis::scene::make_dielectric(1.5),
                      diffuse = gmis::scene::make_diffuse({0.5, 0.5, 0.5});

}  // namespace

TEST_CASE("Local merging keeps the energy: mirrors, glass, lamps that are mirrors", "[long]") {
  using Bsdf = gmis::scene::SurfaceBsdf<float>;
  for (const auto* const ball : {&mirror, &glass})
    for (const auto* const lamp : {&diffuse, &mirror}) {
      CAPTURE(ball == &mirror, lamp == &mirror);
      const auto scene = box<Bsdf>(*ball, *lamp);
      const Mean local = mean_of(scene, local_vcm, 400);
      CHECK(local.counters.merges > 0);
      check_equal(local, mean_of(scene, gmis::integrators::pt, 1500), 0.003);
    }
}

TEST_CASE("Local merging keeps the energy with a BSDF that does not say whether its lobes are narrow") {
  const auto scene = box<SilentBsdf>(glass, diffuse);
  check_equal(mean_of(scene, local_vcm, 250, 0.04), mean_of(scene, gmis::integrators::pt, 1500), 0.003);
}

TEST_CASE("Many light trees and other techniques off: local merging keeps the energy") {
  const auto scene = box<gmis::scene::SurfaceBsdf<float>>(mirror, mirror);
  gmis::SampleCounts counts = local_vcm;
  counts.light_paths = 8.0;
  counts.connections = 0;
  counts.splats = false;
  const Mean truth = mean_of(scene, gmis::integrators::pt, 2500);
  check_equal(mean_of(scene, counts, 350), truth, 0.004);
  counts = local_vcm;
  counts.next_events = false;
  check_equal(mean_of(scene, counts, 800), truth, 0.004);
}

TEST_CASE(
    "Where no lobe is narrow there are no photons: no grid point, no merge, and nothing stored without connections") {
  gmis::scene::SceneBuilder<float> builder;
  const auto wall = builder.add_material(diffuse);
  builder.add_sphere({0, 0, 0}, 2, wall, gmis::scene::AreaEmission{{1.0, 1.0, 1.0}, true});
  builder.set_camera(gmis::scene::look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 60, {12, 12}));
  const auto scene = builder.build();
  gmis::SampleCounts counts = local_vcm;
  CHECK(mean_of(scene, counts, 2).counters.merges == 0);
  counts.connections = 0;
  CHECK(mean_of(scene, counts, 2).counters.photons_stored == 0);
  counts.local_merges = false;
  CHECK(mean_of(scene, counts, 2).counters.merges > 0);
}

TEST_CASE("With every count global, local merging with all surfaces narrow differs by the lights' photons alone") {
  // What merges at the first vertices of light subpaths (s = 2) is missing; every other merge has
  // the same value.
  const auto scene = box<SilentBsdf>(mirror, diffuse);
  gmis::SampleCounts counts = local_vcm;
  const Mean local = mean_of(scene, counts, 3), plain = mean_of(scene, gmis::integrators::vcm, 3);
  CHECK(local.counters.merges < plain.counters.merges);
  CHECK(local.counters.photons_stored == plain.counters.photons_stored);
  const std::vector<Merged> merges = merges_of(scene, counts, 0);
  REQUIRE_FALSE(merges.empty());
  CHECK((merges == merges_of(scene, gmis::integrators::vcm, 3)));
}

TEST_CASE("the merging radius that nobody sets follows the pixels of long and narrow pictures, too") {
  for (const glm::ivec2 size : {glm::ivec2(96, 64), {95, 1}, {96, 1}, {1000, 1}, {480, 5}, {1, 96}, {1, 1}}) {
    // Seen from the centre of a ball, all surfaces have one distance.
    gmis::scene::SceneBuilder<> builder;
    const double distance = 3;
    builder.add_sphere({0, 0, 0}, distance, builder.add_material(gmis::scene::make_diffuse({0.5, 0.5, 0.5})));
    builder.set_camera(gmis::scene::look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 30, size));
    const auto scene = builder.build();
    std::vector<double> widths;
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        widths.push_back(distance / std::sqrt(scene.camera().sample_ray({x, y}, {0.5F, 0.5F}, {0.5F, 0.5F})->density));
    std::nth_element(widths.begin(), widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2), widths.end());
    CAPTURE(size.x, size.y);
    // A 48th of the longer side lies between pixels that are looked at.
    CHECK(gmis::default_radius(scene) == Approx(0.4 * widths[widths.size() / 2]).epsilon(0.1));
  }
}
