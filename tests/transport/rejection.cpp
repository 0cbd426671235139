#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "gmis/result/rejection_limit.hpp"
#include "gmis/transport/replay/replay.hpp"
#include "support/backward_executor.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/provoking_scene.hpp"
#include "transport/ways.hpp"

// Surfaces and lights of somebody's own that do wrong. The oracle is the same scene without the
// wrong, whose contributions say by their second channel how often they met what would be wrong.

namespace {

using gmis_test::Provocation;
using gmis_test::ProvokingScene;
using Record = gmis::Contribution<glm::vec2>;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr int size = 12;

gmis::RenderSettings settings() {
  gmis::RenderSettings result;
  result.max_depth = 5;
  result.radius = 0.1;
  result.seed = gmis_test::seed(5);
  result.counts.connects_paired_tree = true;  // what is left out must not move what is drawn
  return result;
}

/// How many factors of the contribution are marked.
int marks(const Record& record) {
  return static_cast<int>(std::lround(std::log2(record.value.x / record.value.y)));
}

struct Run {
  std::vector<glm::vec2> frame;
  std::vector<Record> records;
  gmis::Counters counters;
  std::vector<gmis::RejectedPath> rejected;
};

template <class I, class Executor = gmis::SerialExecutor>
Run run(const ProvokingScene::Provoked& provoked, int iterations = 1, float radiance = 1.0F) {
  const ProvokingScene scene(size, provoked, radiance);
  typename I::template Engine<ProvokingScene> engine(scene, I::settings(settings()));
  engine.keep_contributions(true);
  Executor executor;
  for (int i = 0; i < iterations; ++i) engine.iterate(executor);
  Run result{{engine.frame().begin(), engine.frame().end()}, {}, engine.counters(), {}};
  engine.for_each_contribution([&](const Record& record) { result.records.push_back(record); });
  result.rejected.assign(engine.rejections().paths().begin(), engine.rejections().paths().end());
  return result;
}

/// The frame that the contributions make for which `is_kept`, summed as the engine sums.
template <class IsKept>
std::vector<float> frame_of(const std::vector<Record>& records, const IsKept& is_kept) {
  std::vector<float> frame(size * size, 0.0F);
  for (const bool splats : {false, true})
    for (const Record& record : records)
      if ((record.id.technique == gmis::Technique::splat) == splats && is_kept(record))
        frame[record.pixel] += (record.value * record.weight).x;
  return frame;
}

/// `is_bad(marks)`: whether a contribution with this number of marks must be left out.
template <class I, class IsBad>
void check_provocation(Provocation mark, Provocation what, float bad, const IsBad& is_bad, bool is_exact = true) {
  CAPTURE(static_cast<int>(what), bad);
  const Run marked = run<I>({mark, 0.0F, nullptr});
  REQUIRE(marked.counters.rejected() == 0);
  std::atomic<std::uint64_t> bad_samples{0};
  const Run provoked = run<I>({what, bad, &bad_samples});

  const auto expected = frame_of(marked.records, [&](const Record& record) { return !is_bad(marks(record)); });
  std::uint64_t left_out = 0;
  for (const Record& record : marked.records) left_out += is_bad(marks(record)) ? 1 : 0;
  REQUIRE(left_out > 50);
  REQUIRE(left_out < marked.records.size());
  int differences = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const glm::vec2 pixel = provoked.frame[i];
    REQUIRE(std::isfinite(pixel.x));
    REQUIRE(std::isfinite(pixel.y));
    REQUIRE(pixel.x >= 0.0F);
    REQUIRE(pixel.y >= 0.0F);
    differences += is_exact ? pixel.x != expected[i] : std::abs(pixel.x - expected[i]) > 1e-5F * expected[i];
  }
  CHECK(differences == 0);

  const bool is_density = what == Provocation::density || what == Provocation::light_density;
  const std::uint64_t rejections = what == Provocation::density ? bad_samples.load() : left_out;
  const gmis::Counters& counters = provoked.counters;
  CHECK(counters.rejected_zero_pdf == (is_density ? rejections : 0));
  CHECK(counters.rejected_negative == (!is_density && bad < 0.0F && std::isfinite(bad) ? rejections : 0));
  CHECK(counters.rejected_non_finite == (!is_density && !std::isfinite(bad) ? rejections : 0));
  CHECK(provoked.records.size() == marked.records.size() - left_out);
}

template <class I>
void check_provocations(bool is_exact_without_vertices) {
  const auto any = [](int count) { return count > 0; };
  const auto odd = [](int count) { return count % 2 == 1; };
  for (const float bad : {nan, infinity, -infinity})
    check_provocation<I>(Provocation::mark, Provocation::value, bad, any);
  check_provocation<I>(Provocation::mark, Provocation::value, -1.0F, odd);  // two of them make it positive again
  for (const float bad : {0.0F, -1.0F, nan, infinity}) {
    check_provocation<I>(Provocation::mark_sample, Provocation::density, bad, any, is_exact_without_vertices);
    check_provocation<I>(Provocation::mark_light, Provocation::light_density, bad, any);
  }
}

template <class Executor>
void check_names() {
  gmis::RenderSettings many_trees = settings();
  many_trees.counts.light_paths = 8;
  const int iterations = 2;
  const float edge = 0.68F;  // so that no chunk of trees fills the list alone
  // The oracle: every path of a marked run by itself, in order.
  std::vector<gmis::RejectedPath> expected;
  for (std::uint32_t iteration = 1; iteration <= iterations; ++iteration) {
    const ProvokingScene scene(size, {Provocation::mark, 0.0F, nullptr, edge});
    gmis::Engine<ProvokingScene> engine(scene, many_trees);
    gmis::SerialExecutor executor;
    engine.prepare_replay(executor, iteration);
    for (const gmis::PathKind kind : {gmis::PathKind::light, gmis::PathKind::camera})
      for (std::uint32_t number = 0; number < (kind == gmis::PathKind::light ? 8 : 1) * size * size; ++number) {
        gmis::RejectedPath path{{kind, iteration, number}, 0, gmis::RejectionCause::non_finite, {}};
        for (const auto& made : gmis::replay(engine, kind, number).contributions)
          if (marks(made.contribution) > 0 && ++path.count == 1) path.technique = made.contribution.id;
        if (path.count > 0) expected.push_back(path);
      }
  }
  REQUIRE(expected.size() > gmis::RejectionLog::capacity);
  const ProvokingScene scene(size, {Provocation::value, nan, nullptr, edge});
  gmis::Engine<ProvokingScene> engine(scene, many_trees);
  Executor executor;
  for (int i = 0; i < iterations; ++i) engine.iterate(executor);
  const auto got = engine.rejections().paths();
  REQUIRE(got.size() == gmis::RejectionLog::capacity);
  for (std::size_t i = 0; i < got.size(); ++i) {
    CAPTURE(i, got[i].path.number, expected[i].path.number);
    CHECK(got[i].path == expected[i].path);
    CHECK(got[i].count == expected[i].count);
    CHECK(got[i].cause == expected[i].cause);
    REQUIRE(got[i].technique.has_value());
    CHECK(got[i].technique->technique == expected[i].technique->technique);
    CHECK(got[i].technique->s == expected[i].technique->s);
    CHECK(got[i].technique->t == expected[i].technique->t);
  }
  // Some trees stand in later chunks than the first.
  CHECK(std::any_of(got.begin(), got.end(), [](const gmis::RejectedPath& rejected) {
    return rejected.path.kind == gmis::PathKind::light && rejected.path.number >= 256;
  }));
}

}  // namespace

TEST_CASE("What is wrong is left out and counted by its cause; all else is as it would be, bit by bit") {
  SECTION("pt") {
    check_provocations<gmis_test::ways::Pt>(true);
  }
  SECTION("vcm") {
    // Fewer light vertices make another grid: merges are summed in another order.
    check_provocations<gmis_test::ways::Vcm>(false);
  }
}

TEST_CASE("A sum that is not finite is left out as well") {
  const Run overflown = run<gmis_test::ways::Vcm>({}, 1, 3.0e38F);
  CHECK(overflown.counters.rejected_non_finite > 0);
  for (const glm::vec2& pixel : overflown.frame) REQUIRE(std::isfinite(pixel.x));

  // Splats that arrive where the camera's own sum is near the end of the range.
  const Run splatted = run<gmis_test::ways::Lt>({Provocation::seen_light, 3.4e38F, nullptr}, 1, 8.0e36F);
  CHECK(splatted.counters.rejected_non_finite > 10);
  for (const glm::vec2& pixel : splatted.frame) {
    REQUIRE(std::isfinite(pixel.x));
    REQUIRE(pixel.x >= 3.4e38F);
  }
}

TEST_CASE("The first paths of which something was rejected are known by name, whatever the order of execution") {
  SECTION("in order") {
    check_names<gmis::SerialExecutor>();
  }
  SECTION("backward") {
    check_names<gmis_test::BackwardExecutor>();
  }
}

TEST_CASE("A path without a technique: its own density is of no use") {
  const Run run = ::run<gmis_test::ways::Pt>({Provocation::density, 0.0F, nullptr});
  REQUIRE_FALSE(run.rejected.empty());
  CHECK(run.rejected[0].cause == gmis::RejectionCause::zero_pdf);
  CHECK_FALSE(run.rejected[0].technique.has_value());
}

TEST_CASE("How much may be rejected") {
  gmis::Counters counters;
  counters.contributions = 1'000'000;
  const gmis::RejectionLimit limit;
  counters.rejected_negative = 100;
  CHECK_FALSE(limit.is_exceeded(counters));
  counters.rejected_zero_pdf = 1;
  CHECK(limit.is_exceeded(counters));
  CHECK_FALSE(limit.is_surely_exceeded(counters));
  // n − 5 √n > 100 from n = 165 on, one of them of density zero.
  counters.rejected_negative = 163;
  CHECK_FALSE(limit.is_surely_exceeded(counters));
  counters.rejected_negative = 164;
  CHECK(limit.is_surely_exceeded(counters));
  CHECK_FALSE(gmis::RejectionLimit{1.0}.is_exceeded(counters));

  gmis::Counters nothing;
  CHECK_FALSE(limit.is_exceeded(nothing));
  nothing.rejected_zero_pdf = 1;
  CHECK(limit.is_exceeded(nothing));
  CHECK_FALSE(limit.is_surely_exceeded(nothing));
  CHECK_FALSE(gmis::RejectionLimit{infinity}.is_exceeded(nothing));
  CHECK(gmis::RejectionLimit{0.0}.is_exceeded(nothing));
}
