#include <cmath>

#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/technique_estimates.hpp"

// In the uniform furnace each technique by itself, with the weight 1, must find a^{k−1} for paths
// of k edges: within a sphere every pair of points has the same form factor, so all of them have
// little noise, and photons lie evenly. What shows here and not in single contributions is how
// often things are drawn: roulette, lobes, children, vertices of the cache. Some 90 comparisons, a
// false alarm in less than a thousandth of the runs; standard errors are 0.01 to 0.5 %, and up to 1
// % for the few splats that the camera sees and for photons.

namespace {

using gmis::Technique;
using Scene = gmis_test::FurnaceScene<float>;

gmis_test::ways::Settings settings() {
  gmis_test::ways::Settings result;
  result.max_depth = 5;
  result.radius = 0.05;
  result.counts.light_paths = 4.0;
  result.alpha = 1.0;
  result.seed = gmis_test::seed(3);
  return result;
}

template <class I, class Source>
void check_techniques(const gmis_test::ways::Settings& render_settings, int lobes, int iterations, double power) {
  const double albedo = 0.8;
  const Scene scene(static_cast<float>(albedo), 1.0F, 24, lobes);
  const auto estimates = gmis_test::estimate<I, Source>(scene, render_settings, iterations);
  for (int edges = 2; edges <= render_settings.max_depth; ++edges) {
    const double truth = std::pow(albedo, edges - 1);
    CAPTURE(edges);
    gmis_test::check_closed_form("emitter hit", estimates.alone(Technique::emitter_hit, edges), truth, power);
    gmis_test::check_closed_form("together", estimates.together(edges), truth, power);
    // What comes to a photon's place on the curved wall from below the camera vertex's horizon is
    // lost to merging: of diffuse light the share (1 − cos α)/2 at the angle α, a quarter of the
    // squared distance, r²/8 in the mean.
    const double merged = truth * (edges - 1) * (1.0 - gmis::square(*render_settings.radius) / 8.0);
    // Merging and connecting can make a path in several ways.
    gmis_test::check_closed_form("next event", estimates.alone(Technique::next_event, edges), truth, power);
    gmis_test::check_closed_form("splat", estimates.alone(Technique::splat, edges), truth, 2.5 * power);
    gmis_test::check_closed_form("merge", estimates.alone(Technique::merge, edges), merged, 2.5 * power);
    if (edges >= 3)
      gmis_test::check_closed_form("connect", estimates.alone(Technique::connect, edges), truth * (edges - 2),
                                   2.5 * power);
  }
}

}  // namespace

TEST_CASE("each technique alone finds the furnace's closed form at every length") {
  using namespace gmis_test::ways;
  SECTION("connections of paired subpaths") {
    auto paired = settings();
    paired.counts.connects_paired_tree = true;
    check_techniques<Vcm, gmis_test::ShiftedLattice>(paired, 1, 800, 0.004);
  }
  SECTION("connections drawn from the cache of all trees") {
    auto cached = settings();
    cached.counts.connections = 2;
    cached.counts.light_paths = 3.0;
    check_techniques<Vcm, gmis_test::ShiftedLattice>(cached, 2, 1300, 0.004);
  }
  SECTION("trees") {
    auto split = settings();
    split.counts.connections = 2;
    split.sampler.budget = 6;
    check_techniques<Gmis, gmis::Philox>(split, 2, 250, 0.006);
  }
  SECTION("trees of more children, by another scheme") {
    auto split = settings();
    split.counts.connections = 4;
    split.sampler.rounds = 2;
    split.sampler.scheme = gmis::Scheme::N2;
    check_techniques<Gmis, gmis::Philox>(split, 2, 250, 0.006);
  }
}
