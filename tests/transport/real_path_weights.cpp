#include <algorithm>
#include <cmath>
#include <vector>

#include "transport/path_by_path.hpp"

namespace {

using gmis_test::DiscreteWorld;
using gmis_test::ways::Way;

gmis_test::ways::Settings settings() {
  return gmis_test::path_by_path::settings(gmis_test::seed(11));
}

template <class I, class T = double>
void check_both_cameras(double tolerance, std::size_t whole,
                        const gmis_test::ways::Settings& render_settings = settings()) {
  gmis_test::path_by_path::check_both_cameras<I, DiscreteWorld<T>>(tolerance, whole, render_settings);
}

}  // namespace

TEST_CASE("what the engine weights and what it adds is what brute force says, path by path") {
  using namespace gmis_test::ways;
  SECTION("pt") {
    check_both_cameras<Pt>(1e-10, 100);
  }
  SECTION("lt") {
    check_both_cameras<Lt>(1e-10, 50);
  }
  SECTION("bpt") {
    check_both_cameras<Bpt>(1e-10, 100);
  }
  SECTION("ppm") {
    check_both_cameras<Ppm>(1e-10, 100);
  }
  SECTION("bpm") {
    check_both_cameras<Bpm>(1e-10, 100);
  }
  SECTION("vcm") {
    check_both_cameras<Vcm>(1e-10, 100);
  }
  SECTION("vcm, a radius that shrinks") {
    auto shrinking = settings();
    shrinking.alpha = 0.25;  // in the third iteration the disk is 0.44 of the first
    check_both_cameras<Vcm>(1e-10, 100, shrinking);
  }
  SECTION("bpm, a radius that shrinks") {
    auto shrinking = settings();
    shrinking.alpha = 0.5;
    check_both_cameras<Bpm>(1e-10, 100, shrinking);
  }
  SECTION("vcm in float") {
    check_both_cameras<Vcm, float>(1e-4, 100);
  }
  SECTION("vcm, power heuristic") {
    using Power [[maybe_unused]] = Way<gmis::Method<gmis::RecursiveWeights<gmis::PowerRatio>>, gmis::integrators::vcm,
                                       gmis::TreeBudget::softened, gmis::PowerRatio>;
    check_both_cameras<Power>(1e-10, 100);
  }
  SECTION("vcm, connections drawn from the cache of all trees") {
    check_both_cameras<Vcm>(1e-10, 100, gmis_test::path_by_path::with_cache(settings(), 3));
  }
  SECTION("vcm, a local count of merging") {
    auto local = settings();
    local.counts.local_merges = true;
    local.radius = 0.05;
    local.counts.radius_factor = 8.0;
    check_both_cameras<Vcm>(1e-10, 100, local);
  }
  // Trees with an ample budget: the number of children that are drawn is the one that the weights
  // count on.
  SECTION("gmis") {
    auto split = settings();
    split.max_depth = 4;
    check_both_cameras<Gmis>(1e-10, 100, split);
  }
  SECTION("gmis, more children, a local count of merging") {
    auto split = settings();
    split.counts.local_merges = true;
    split.max_depth = 4;
    split.sampler.scheme = gmis::Scheme::R3;
    split.sampler.rounds = 2;
    check_both_cameras<Gmis>(1e-10, 100, split);
  }
}

namespace {

struct Recorded {
  std::uint32_t pixel;
  int technique, s, t;
  double value, weight;
  [[nodiscard]] bool operator==(const Recorded&) const = default;
};

struct Rendering {
  std::vector<Recorded> records;
  std::vector<double> frame;
};

template <class I>
Rendering render(int max_depth) {
  using World = DiscreteWorld<double>;
  const World world(gmis_test::make_atlas<double>(5, false), 32);
  auto render_settings = settings();
  render_settings.max_depth = max_depth;
  typename I::template Engine<World> engine(world, I::settings(render_settings));
  engine.keep_contributions(true);
  gmis::SerialExecutor executor;
  engine.iterate(executor);
  Rendering result;
  engine.for_each_contribution([&](const auto& record) {
    result.records.push_back({record.pixel, static_cast<int>(record.id.technique), record.id.s, record.id.t,
                              record.value.value, record.weight});
  });
  for (const auto& pixel : engine.frame()) result.frame.push_back(pixel.value);
  return result;
}

/// The image of every depth is what the records add up to, and the records of a depth are those of
/// the depth before and those with one edge more, bit by bit: the same paths, with the same
/// weights.
template <class I>
void check_path_lengths() {
  Rendering before;
  for (int max_depth = 1; max_depth <= 4; ++max_depth) {
    CAPTURE(max_depth);
    const Rendering rendering = render<I>(max_depth);
    std::vector<double> sum(rendering.frame.size(), 0.0), longest(rendering.frame.size(), 0.0);
    std::vector<Recorded> shorter;
    int longer = 0;
    for (const Recorded& record : rendering.records) {
      const int edges = record.s + record.t - (record.technique == static_cast<int>(gmis::Technique::merge) ? 2 : 1);
      longer += edges > max_depth;
      (edges == max_depth ? longest : sum)[record.pixel] += record.value * record.weight;
      if (edges < max_depth) shorter.push_back(record);
    }
    CHECK(rendering.records.size() > shorter.size());
    CHECK(longer == 0);
    CHECK((shorter == before.records));
    double worst = 0.0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      worst = std::max(worst, std::abs(sum[i] + longest[i] - rendering.frame[i]));
      if (max_depth > 1) worst = std::max(worst, std::abs(before.frame[i] + longest[i] - rendering.frame[i]));
    }
    CHECK(worst < 1e-11);
    before = rendering;
  }
}

}  // namespace

TEST_CASE("path lengths add up to the image, and a greater depth only adds longer paths") {
  using namespace gmis_test::ways;
  SECTION("pt") {
    check_path_lengths<Pt>();
  }
  SECTION("lt") {
    check_path_lengths<Lt>();
  }
  SECTION("bpt") {
    check_path_lengths<Bpt>();
  }
  SECTION("ppm") {
    check_path_lengths<Ppm>();
  }
  SECTION("bpm") {
    check_path_lengths<Bpm>();
  }
  SECTION("vcm") {
    check_path_lengths<Vcm>();
  }
  SECTION("gmis") {
    check_path_lengths<Gmis>();
  }
}
