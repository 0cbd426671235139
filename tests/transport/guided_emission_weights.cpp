#include "transport/path_by_path.hpp"

// Guided emission: every weight and every value that the engine forms, against brute force. The
// density of a start depends on the light, its numbers, and how near its line passes the centre;
// next events, hits and escapes ask for it, too. With the factor forgotten at one of these places,
// single contributions are wrong by factors.

namespace {

using World = gmis_test::DiscreteWorld<double>;

gmis_test::ways::Settings settings() {
  auto result = gmis_test::path_by_path::settings(gmis_test::seed(17));
  result.emission = gmis::Emission::learned;
  return result;
}

constexpr int iterations = 5;  // enough for the numbers of whole paths with any seed

template <class I, class World_ = World>
void check(const gmis_test::ways::Settings& render_settings = settings()) {
  gmis_test::path_by_path::check_both_cameras<I, World_>(1e-10, 100, render_settings, iterations);
}

}  // namespace

TEST_CASE("guided emission: what the engine weights and adds is what brute force says") {
  using namespace gmis_test::ways;
  SECTION("lt") {
    gmis_test::path_by_path::check_both_cameras<Lt, World>(1e-10, 50, settings(), iterations);
  }
  SECTION("bpt") {
    check<Bpt>();
  }
  SECTION("bpm") {
    check<Bpm>();
  }
  SECTION("vcm") {
    check<Vcm>();
  }
  SECTION("vcm, next events choose for their receiver") {
    check<Vcm, gmis_test::DiscreteWorld<double, true>>();
  }
  SECTION("vcm, connections drawn from the cache, a local count of merging") {
    auto local = gmis_test::path_by_path::with_cache(settings(), 3);
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
