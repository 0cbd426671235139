#include <cmath>
#include <gmis/testing/catch.hpp>
#include <gmis/transport/weights/path_densities.hpp>
#include <vector>

// A renderer's own VCM weights against the sum over all techniques: docs/test-your-estimator.md.

namespace {

using Path = gmis::PathDensities<double>;
using Counts = gmis::TechniqueCounts<double>;

/// The weight of one technique as a renderer may compute it: Σ over the others of the ratios of
/// neighbouring densities, each a_i/b_i, so that no product leaves the range of double [Veach 1997,
/// section 10.2]. `forgets_delta`: a planted bug.
double my_vcm_weight(const Path& path, const Counts& counts, gmis::TechniqueIndex technique,
                     bool forgets_delta = false) {
  const int k = static_cast<int>(path.from_light.size());
  const auto a = [&](int i) { return path.from_light[static_cast<std::size_t>(i)]; };
  const auto b = [&](int i) { return path.from_camera[static_cast<std::size_t>(i)]; };
  const auto diffuse = [&](int i) {
    return i == 0 || i == k || forgets_delta || !path.is_delta[static_cast<std::size_t>(i)];
  };
  // In units of U(s) = Π_{i<s} a_i Π_{i≥s} b_i: what connecting with s light vertices, and merging
  // at x_s, make of a path.
  const auto connecting = [&](int s) {
    if (s == 0) return path.light_can_be_hit ? counts.emitter_hit : 0.0;
    if (s == 1 && k >= 2) return diffuse(1) ? counts.next_event * path.next_event / a(0) : 0.0;
    if (s == k && k >= 2) return diffuse(k - 1) ? counts.splat : 0.0;
    return s >= 2 && diffuse(s - 1) && diffuse(s) ? counts.connect : 0.0;
  };
  const auto merging = [&](int i) { return i >= 1 && i < k && diffuse(i) ? counts.merge * a(i) : 0.0; };  // at x_i
  const auto of = [&](int s) { return connecting(s) + merging(s); };
  const int start = technique.s;
  double others = of(start), ratio = 1.0;
  for (int s = start + 1; s <= k; ++s) others += of(s) * (ratio *= a(s - 1) / b(s - 1));
  ratio = 1.0;
  for (int s = start - 1; s >= 0; --s) others += of(s) * (ratio *= b(s) / a(s));
  return (technique.is_merge ? merging(start) : connecting(start)) / others;
}

Path random_path(gmis::Philox& source) {
  const auto density = [&] { return std::exp(8.0 * gmis::uniform<double>(source) - 4.0); };
  Path path;
  const std::size_t edges = 2 + gmis::uniform_index(source, 7);
  for (std::size_t i = 0; i < edges; ++i) {
    path.from_light.push_back(density());
    path.from_camera.push_back(density());
  }
  path.is_delta.assign(edges + 1, false);
  for (std::size_t i = 1; i < edges; ++i) path.is_delta[i] = gmis::uniform<double>(source) < 0.3;
  path.next_event = density();
  return path;
}

gmis::WeightCheck check(bool forgets_delta) {
  const Counts counts{.emitter_hit = 1.0, .next_event = 1.0, .connect = 2.0, .splat = 1000.0, .merge = 0.1};
  gmis::Philox source = gmis::seeded("vcm weights");
  gmis::WeightCheck check;
  for (int i = 0; i < 1000; ++i) {
    const Path path = random_path(source);
    std::vector<double> densities, weights;
    for (const auto& [technique, density] : gmis::technique_densities(path, counts)) {
      densities.push_back(density);
      weights.push_back(my_vcm_weight(path, counts, technique, forgets_delta));
    }
    check.add(densities, weights);
  }
  return check;
}

}  // namespace

TEST_CASE("my VCM weights sum to one over the techniques of every path") {
  REQUIRE_THAT(check(false), gmis::SumsToOne());
}

TEST_CASE("VCM weights that merge at mirrors are found") {
  CHECK_FALSE(check(true).passes());
}
