#include "transport/guided_discrete_world.hpp"
#include "transport/path_by_path.hpp"

// Guided directions: every weight and every value that the engine forms over guided surfaces, against brute force. A camera
// subpath goes on by the lobe for radiance, a light subpath by that for importance; a weight asks for both at every vertex. With
// the two swapped, one side forgotten, or a delta lobe that keeps its whole probability, single contributions are wrong by
// factors.

namespace {

using World = gmis_test::GuidedDiscreteWorld<double>;

gmis::RenderSettings settings() {
  return gmis_test::path_by_path::settings(gmis_test::seed(23));
}

constexpr int iterations = 8;  // so many that the numbers of whole paths are reached with any seed

template <class I>
void check(const gmis::RenderSettings& render_settings = settings()) {
  gmis_test::path_by_path::check_both_cameras<I, World>(1e-10, 100, render_settings, iterations);
}

}  // namespace

TEST_CASE("guided directions: what the engine weights and adds is what brute force says") {
  using namespace gmis_test::ways;
  SECTION("pt, which asks for no reverse density") {
    check<Pt>();
  }
  SECTION("bpt") {
    check<Bpt>();
  }
  SECTION("vcm") {
    check<Vcm>();
  }
  SECTION("vcm, connections drawn from the cache, a local count of merging") {
    gmis::RenderSettings local = settings();
    local.counts.light_paths = 1.0;
    local.counts.connections = 3;
    local.counts.local_merges = true;
    local.radius = 0.05;
    local.counts.radius_factor = 8.0;
    check<Vcm>(local);
  }
  SECTION("trees that split, on both sides: the lobe is one of those that children are drawn from") {
    gmis::RenderSettings split = settings();
    split.max_depth = 4;
    split.counts.camera_children = 3;
    check<Gmis>(split);
  }
}
