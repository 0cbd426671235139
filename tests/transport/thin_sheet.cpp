#include <cmath>

#include "gmis/scene.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/technique_estimates.hpp"

// A closed sphere of a thin sheet, which reflects the share r diffusely and lets the share t
// through, in light of radiance 1 from everywhere. Light is the same at all points within: a wall
// there shows the light that it lets in, t, and the share r of the light from the wall around it.
// So paths of k edges carry t r^(k−2) to a camera inside; to one outside, r by 2 edges, and from
// within t · t r^(k−3). Each technique alone must find that, through the sheet or within it. Some
// 45 comparisons, each at the level of a false alarm in 100,000 runs.

namespace {

using gmis::Technique;
using gmis_test::check_closed_form;
using Point = glm::dvec3;

constexpr double r = 0.35, t = 0.5;

gmis::RenderSettings settings(int max_depth) {
  gmis::RenderSettings result;
  result.max_depth = max_depth;
  result.counts.light_paths = 4;
  result.radius = 0.05;
  result.alpha = 1.0;
  result.seed = gmis_test::seed(71);
  return result;
}

gmis::scene::BvhScene<float> sphere_seen_from(const Point& eye, const gmis::scene::Material<float>& sheet) {
  gmis::scene::SceneBuilder<float> builder;
  builder.add_sphere({0, 0, 0}, 1, builder.add_material(sheet));
  builder.add_environment(Point(1));
  builder.set_camera(gmis::scene::look_at(eye, {0, 0, 0}, {0, 1, 0}, 10, {8, 8}));
  return builder.build();
}

/// `carried(k)`: what paths of k edges carry.
template <class Carried>
void check_sphere(const Point& eye, const gmis::scene::Material<float>& sheet, const Carried& carried, double power) {
  const int deepest = 4;
  const auto estimates =
      gmis_test::estimate<gmis_test::ways::Vcm>(sphere_seen_from(eye, sheet), settings(deepest), 1200);
  for (int edges = 2; edges <= deepest; ++edges) {
    const double truth = carried(edges);
    CAPTURE(edges);
    check_closed_form("emitter hit", estimates.alone(Technique::emitter_hit, edges), truth, power);
    check_closed_form("next event", estimates.alone(Technique::next_event, edges), truth, power);
    check_closed_form("splat", estimates.alone(Technique::splat, edges), truth, 4 * power);
    if (edges > 2)
      check_closed_form("connect", estimates.alone(Technique::connect, edges), truth * (edges - 2), 2 * power);
    // Photons on a curved wall: see furnace_techniques.cpp.
    check_closed_form("together", estimates.together(edges), truth, power, 0.001);
  }
}

}  // namespace

TEST_CASE("light through a sheet, from within a sphere of it") {
  check_sphere(
      {0.3, 0.1, 0}, gmis::scene::make_diffuse_transmission(Point(r), Point(t)),
      [](int edges) { return t * std::pow(r, edges - 2); }, 0.025);
}

TEST_CASE("light through a sheet and out again") {
  check_sphere(
      {0, 0, 8}, gmis::scene::make_diffuse_transmission(Point(r), Point(t)),
      [](int edges) { return edges == 2 ? r : t * t * std::pow(r, edges - 3); }, 0.025);
}

TEST_CASE("a sheet that lets light through and reflects none") {
  const auto sheet = gmis::scene::make_diffuse_transmission(Point(0), Point(t));
  const auto estimates =
      gmis_test::estimate<gmis_test::ways::Vcm>(sphere_seen_from({0, 0, 8}, sheet), settings(3), 600);
  check_closed_form("connect", estimates.alone(Technique::connect, 3), t * t, 0.06);
  check_closed_form("together", estimates.image(), t * t, 0.02, 0.001);
}

TEST_CASE("path tracing, bidirectional path tracing and vcm see one picture through a sheet") {
  const auto scene = sphere_seen_from({0.3, 0.1, 0}, gmis::scene::make_diffuse_transmission(Point(r), Point(t)));
  const double truth = t * (1 - std::pow(r, 4)) / (1 - r);
  using namespace gmis_test::ways;
  check_closed_form("pt", gmis_test::estimate<Pt>(scene, settings(5), 600).image(), truth, 0.005);
  check_closed_form("lt", gmis_test::estimate<Lt>(scene, settings(5), 600).image(), truth, 0.1);
  check_closed_form("bpt", gmis_test::estimate<Bpt>(scene, settings(5), 600).image(), truth, 0.005);
}
