#include "transport/path_by_path.hpp"

// Lights chosen for their receiver: every weight and every value that the engine forms, against
// brute force. The probability of a light depends on place and normals at x_1; with the one of
// light subpaths in its place, or with that of another vertex, single contributions are wrong by
// factors.

namespace {

using World = gmis_test::DiscreteWorld<double, true>;

gmis_test::ways::Settings settings() {
  return gmis_test::path_by_path::settings(gmis_test::seed(13));
}

template <class I>
void check(const gmis_test::ways::Settings& render_settings = settings()) {
  gmis_test::path_by_path::check_both_cameras<I, World>(1e-10, 100, render_settings);
}

}  // namespace

TEST_CASE("lights chosen for their receiver: what the engine weights and adds is what brute force says") {
  using namespace gmis_test::ways;
  SECTION("pt") {
    check<Pt>();
  }
  SECTION("bpt") {
    check<Bpt>();
  }
  SECTION("vcm") {
    check<Vcm>();
  }
  SECTION("vcm, two and four connections drawn from the cache of all trees") {
    for (const int connections : {2, 4}) check<Vcm>(gmis_test::path_by_path::with_cache(settings(), connections));
  }
  SECTION("vcm, a local count of merging") {
    auto local = settings();
    local.counts.local_merges = true;
    local.radius = 0.05;
    local.counts.radius_factor = 8.0;
    check<Vcm>(local);
  }
  SECTION("trees that split") {
    auto split = settings();
    split.max_depth = 4;
    check<Gmis>(split);
  }
}
