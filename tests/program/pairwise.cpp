#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "program/block_statistics.hpp"
#include "program/disk_means.hpp"
#include "support/build_scene.hpp"
#include "support/catch.hpp"
#include "support/choices.hpp"
#include "support/pbrt/reader.hpp"
#include "support/render.hpp"
#include "support/seed.hpp"

// All integrators against each other, in pairs, on every kind of light with every kind of surface
// and of camera: 8 lights × 3 cameras × 2 sets of objects (scenes/). Single iterations are the
// independent estimates; Welch's t for the means of 8×8 blocks and of the whole picture, per
// channel, at the Šidák level of a false-alarm rate of 1e-3 for the whole family.
//
// What an integrator cannot make by its nature is left out:
// - among surfaces without delta lobes (`objects_rough`) each of the seven makes every path;
// - `lt` cannot connect the camera with what is seen by way of a delta lobe: it takes no part where
//   there are some;
// - where a delta light shines through or off a delta lobe onto a surface, `pt` and `bpt` lack that
//   light, seen directly (`pt`) or in a mirror (both): under delta lights and among delta lobes
//   they take part at two segments only, direct light, which all seven make.
//
// Merging is biased. Where it takes part, the difference may be larger by a bound on that,
// `bias_bound` radii over half the scene's diagonal. The bound is known without a photon: path
// tracing over `DiskMeans` shows 3.75 ± .06 radii in the worst block of the scenes with rough
// objects, which the coarse ball fills. Tests below show that photon mapping makes these means,
// that they stay within the bound, that photons do at several radii, and that the bias falls along
// the schedule.

using namespace gmis::tools;

namespace {

constexpr double family_level = 1e-3;
constexpr double radius = 0.005;
constexpr double bias_bound = 4.0;

struct Light {
  const char* name;
  bool is_delta;
};
constexpr Light lights[] = {{"triangle", false},   {"sphere", false},      {"point", true},  {"spot", true},
                            {"directional", true}, {"environment", false}, {"image", false}, {"many", false}};
constexpr const char* cameras[] = {"pinhole", "lens", "orthographic"};

struct Scene {
  std::string name;
  std::unique_ptr<BuiltScene> built;
};

Scene scene_of(const std::string& light, const std::string& camera, const std::string& objects) {
  Diagnostics diagnostics;
  const std::string text = "Include \"camera_" + camera + ".pbrt\"\nWorldBegin\nInclude \"light_" + light +
                           ".pbrt\"\nInclude \"objects_" + objects + ".pbrt\"\n";
  const SceneDescription description = read_pbrt_text(text, "test", GMIS_PAIRWISE_SCENE_FOLDER, diagnostics);
  for (const Diagnostic& diagnostic : diagnostics.all()) CHECK(diagnostic.severity == Severity::note);
  return {objects + " objects, light " + light + ", camera " + camera, build_scene(description, diagnostics)};
}

/// How an integrator is run: iterations and light trees a pixel, for about equal time.
struct Effort {
  IntegratorChoice integrator;
  std::uint32_t iterations;
  double light_paths;
};
constexpr Effort efforts[] = {{IntegratorChoice::pt, 1600, 1}, {IntegratorChoice::lt, 1000, 3},
                              {IntegratorChoice::bpt, 600, 1}, {IntegratorChoice::ppm, 600, 6},
                              {IntegratorChoice::bpm, 600, 6}, {IntegratorChoice::vcm, 600, 1},
                              {IntegratorChoice::gmis, 600, 1}};

RenderRequest request_for(const Scene& scene, const Effort& effort, int max_depth, std::uint64_t seed) {
  Options options;
  RenderRequest request;
  request.integrator = options.integrator = effort.integrator;
  request.expected_iterations = effort.iterations;
  request.settings.seed = gmis_test::seed(seed);
  request.settings.max_depth = max_depth;
  request.settings.radius = radius * scene.built->half_diagonal();
  options.light_paths = effort.light_paths;
  // The ways of gmis to split, one after the other.
  if (effort.integrator == IntegratorChoice::gmis) {
    options.split = seed % 2 == 0 ? SplitChoice::budgeted : SplitChoice::local;
  }
  request.split = options.split;
  set_counts(request, options, *scene.built);
  return request;
}

/// Single iterations as frames, by blocks and as a whole.
struct Estimates {
  gmis_test::BlockStatistics blocks, whole;

  explicit Estimates(glm::ivec2 resolution)
      : blocks(resolution, 8), whole(resolution, std::max(resolution.x, resolution.y)) {}
  [[nodiscard]] std::size_t count() const { return blocks.count() + whole.count(); }
  [[nodiscard]] double mean(std::size_t i) const {
    return i < blocks.count() ? blocks.mean(i) : whole.mean(i - blocks.count());
  }
  [[nodiscard]] double standard_error(std::size_t i) const {
    return i < blocks.count() ? blocks.standard_error(i) : whole.standard_error(i - blocks.count());
  }
};

/// Iterations `first` to `last` of a run.
Estimates estimates_of(const Scene& scene, const RenderRequest& request, std::uint32_t first, std::uint32_t last) {
  ThreadedExecutor executor(0);
  const auto source = start(*scene.built, request);
  Estimates result(scene.built->scene().camera().resolution());
  for (std::uint32_t i = 1; i <= last; ++i) {
    source->iterate(executor);
    if (i < first) continue;
    result.blocks.add(source->engine().frame());
    result.whole.add(source->engine().frame());
  }
  REQUIRE(source->counters().rejected_non_finite == 0);
  REQUIRE(source->counters().rejected_negative == 0);
  return result;
}

/// Frames of path tracing over `DiskMeans`, with the disk of `settings`.
Estimates disk_means_of(const Scene& scene, gmis::RenderSettings settings, std::uint64_t seed, int iterations) {
  const gmis_test::DiskMeans means(scene.built->scene(), static_cast<float>(*settings.radius));
  settings.counts = gmis::integrators::pt;
  settings.seed = gmis_test::seed(seed);
  gmis::Engine<std::remove_const_t<decltype(means)>, gmis::CameraSide> engine(means, settings);
  ThreadedExecutor executor(0);
  Estimates result(means.camera().resolution());
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    result.blocks.add(engine.frame());
    result.whole.add(engine.frame());
  }
  return result;
}

/// The two-sided p-value of values i that differ by more than `allowed`.
double p_value_beyond(const Estimates& left, const Estimates& right, std::size_t i, double allowed) {
  const double error = std::hypot(left.standard_error(i), right.standard_error(i));
  const double excess = std::max(0.0, std::abs(left.mean(i) - right.mean(i)) - allowed);
  return gmis::student_t_p_value(excess / error, std::min(left.blocks.frames(), right.blocks.frames()) - 1.0);
}

struct Comparison {
  std::string name;
  double p_value, relative_difference, relative_error;
};

/// All pairs of `integrators` in one scene.
void compare(const Scene& scene, const std::vector<IntegratorChoice>& integrators, int max_depth, std::uint64_t seed,
             std::vector<Comparison>& comparisons) {
  std::vector<std::pair<IntegratorChoice, Estimates>> all;
  for (const Effort& effort : efforts)
    if (std::find(integrators.begin(), integrators.end(), effort.integrator) != integrators.end())
      all.emplace_back(effort.integrator,
                       estimates_of(scene, request_for(scene, effort, max_depth, seed), 1, effort.iterations));
  for (std::size_t a = 0; a < all.size(); ++a)
    for (std::size_t b = a + 1; b < all.size(); ++b) {
      const Estimates& left = all[a].second;
      const Estimates& right = all[b].second;
      for (std::size_t i = 0; i < left.count(); ++i) {
        const double error = std::hypot(left.standard_error(i), right.standard_error(i));
        const double mean = std::max(left.mean(i), right.mean(i));
        const bool is_biased = merges(all[a].first) || merges(all[b].first);
        const double difference = std::abs(left.mean(i) - right.mean(i));
        const double allowed = is_biased ? bias_bound * radius * mean : 0.0;
        // Too few photons reach a block this dark, twenty times darker than the picture, for
        // Student's t to hold.
        const double whole = std::max(left.mean(left.count() - 1), right.mean(left.count() - 1));
        if (mean < 0.05 * whole || (error == 0.0 && difference <= allowed)) continue;
        comparisons.push_back({scene.name + ", " + std::to_string(max_depth) + " segments, " + name_of(all[a].first) +
                                   " and " + name_of(all[b].first) + ", value " + std::to_string(i),
                               p_value_beyond(left, right, i, allowed), difference / mean, error / mean});
      }
    }
}

/// Compares in every second scene: `half` is 0 or 1. Each half has every light with every camera,
/// every light with both sets of objects and every camera with both.
void check_agreement(int half) {
  using enum IntegratorChoice;
  const std::vector<IntegratorChoice> all{pt, lt, bpt, ppm, bpm, vcm, gmis};
  const std::vector<IntegratorChoice> all_but_lt{pt, bpt, ppm, bpm, vcm, gmis};
  const std::vector<IntegratorChoice> merging{ppm, bpm, vcm, gmis};
  std::vector<Comparison> comparisons;
  std::uint64_t seed = 500;
  int place = 0;
  for (const Light& light : lights)
    for (const char* camera : cameras) {
      ++seed;
      if ((place / 3 + place % 3) % 2 == half) {
        compare(scene_of(light.name, camera, "rough"), all, 5, seed, comparisons);
      } else {
        const Scene specular = scene_of(light.name, camera, "specular");
        compare(specular, light.is_delta ? merging : all_but_lt, 5, seed, comparisons);
        if (light.is_delta) compare(specular, all, 2, seed, comparisons);
      }
      ++place;
    }
  const double level = gmis::sidak_level(family_level / 2, comparisons.size());
  std::sort(comparisons.begin(), comparisons.end(),
            [](const Comparison& a, const Comparison& b) { return a.p_value < b.p_value; });
  std::vector<double> errors;
  for (const Comparison& comparison : comparisons) errors.push_back(comparison.relative_error);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  std::printf(
      "%zu comparisons, level %.1e, smallest p %.1e (%s); the median standard error of a difference is %.1f %%\n",
      comparisons.size(), level, comparisons[0].p_value, comparisons[0].name.c_str(),
      100.0 * errors[errors.size() / 2]);
  for (const Comparison& comparison : comparisons) {
    if (comparison.p_value > level) break;
    UNSCOPED_INFO(comparison.name << ": p " << comparison.p_value << ", difference " << comparison.relative_difference
                                  << " ± " << comparison.relative_error);
  }
  CHECK(comparisons[0].p_value > level);
}

}  // namespace

TEST_CASE("all integrators agree: the first half of the scenes") {
  check_agreement(0);
}
TEST_CASE("all integrators agree: the second half of the scenes") {
  check_agreement(1);
}

// The bias of merging is what the disk makes of the light: photon mapping agrees with path tracing
// over `DiskMeans`, in which no photon takes part, and does not with plain path tracing. Radii over
// half the scene's diagonal. At the largest, disks reach beyond whole faces of the coarse ball,
// whose faces meet at more than `Merge::least_normal_cosine`: the light beyond their edges is lost,
// in proportion to the radius, which makes the largest bias. All comparisons together raise a false
// alarm in a thousandth of the seeds.
TEST_CASE("photon mapping makes the means over its disks") {
  const Scene scene = scene_of("triangle", "pinhole", "rough");
  const Estimates plain = estimates_of(scene, request_for(scene, {IntegratorChoice::pt, 0, 1}, 5, 9300), 1, 8000);
  constexpr double disks[] = {0.06, 0.02, radius};
  const double level = gmis::sidak_level(family_level, std::size(disks) * plain.count());
  for (const double disk : disks) {
    RenderRequest request = request_for(scene, {IntegratorChoice::ppm, 0, 6}, 5, 9301);
    request.settings.radius = disk * scene.built->half_diagonal();
    request.settings.alpha = 1.0;
    const Estimates merged = estimates_of(scene, request, 1, 8000);
    const Estimates expected = disk_means_of(scene, request.settings, 9302, 8000);
    double smallest = 1.0, smallest_of_plain = 1.0;
    for (std::size_t i = 0; i < expected.count(); ++i) {
      smallest = std::min(smallest, p_value_beyond(merged, expected, i, 0.0));
      smallest_of_plain = std::min(smallest_of_plain, p_value_beyond(plain, expected, i, 0.0));
    }
    std::printf("radius %.4f: smallest p %.1e, of plain path tracing %.1e\n", disk, smallest, smallest_of_plain);
    CAPTURE(disk, smallest, smallest_of_plain);
    CHECK(smallest > level);
    CHECK(smallest_of_plain < level);
  }
}

// The scenes with rough objects, where all that a camera ray meets is merged; a false alarm in a
// thousandth of the seeds.
TEST_CASE("means over disks stay within the bound on merging's bias") {
  constexpr double disk = 0.02;
  double largest = 0.0, smallest = 1.0;
  std::size_t count = 0;
  for (const Light& light : lights)
    for (const char* camera : cameras) {
      const Scene scene = scene_of(light.name, camera, "rough");
      const Estimates plain = estimates_of(scene, request_for(scene, {IntegratorChoice::pt, 0, 1}, 5, 9400), 1, 4000);
      gmis::RenderSettings settings = request_for(scene, {IntegratorChoice::ppm, 0, 1}, 5, 9401).settings;
      settings.radius = disk * scene.built->half_diagonal();
      const Estimates expected = disk_means_of(scene, settings, 9402, 4000);
      for (std::size_t i = 0; i < expected.count(); ++i, ++count) {
        smallest = std::min(smallest, p_value_beyond(plain, expected, i, bias_bound * disk * plain.mean(i)));
        largest = std::max(largest, std::abs(expected.mean(i) / plain.mean(i) - 1.0) / disk);
      }
    }
  std::printf("largest bias %.2f radii, smallest p beyond %.1f radii %.1e\n", largest, bias_bound, smallest);
  CAPTURE(largest, smallest);
  CHECK(smallest > gmis::sidak_level(family_level, count));
}

namespace {

/// Means of blocks over independent frames, and the covariances of these means: photons and splats
/// of one light tree fall into several blocks, and all channels of a block see the same paths.
class BlockMeans {
 public:
  explicit BlockMeans(std::size_t count) : count_(count), sum_(count), products_(count * count) {}

  void add(const std::vector<double>& values) {
    ++frames_;
    for (std::size_t i = 0; i < count_; ++i) {
      sum_[i] += values[i];
      for (std::size_t j = 0; j <= i; ++j) products_[i * count_ + j] += values[i] * values[j];
    }
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] double frames() const { return frames_; }
  [[nodiscard]] double mean(std::size_t i) const { return sum_[i] / frames_; }
  /// Covariance of the means.
  [[nodiscard]] double covariance(std::size_t i, std::size_t j) const {
    return (products_[std::max(i, j) * count_ + std::min(i, j)] / frames_ - mean(i) * mean(j)) / (frames_ - 1.0);
  }

 private:
  std::size_t count_;
  double frames_ = 0.0;
  std::vector<double> sum_, products_;
};

/// Adds iterations `first` to `last` of a run, by blocks of 8×8 pixels.
void add_run(BlockMeans& means, const Scene& scene, const RenderRequest& request, std::uint32_t first,
             std::uint32_t last) {
  ThreadedExecutor executor(0);
  const glm::ivec2 resolution = scene.built->scene().camera().resolution();
  const gmis_test::BlockStatistics blocks(resolution, 8);
  const auto source = start(*scene.built, request);
  for (std::uint32_t i = 1; i <= last; ++i) {
    source->iterate(executor);
    if (i < first) continue;
    means.add(blocks.block_means([&](int x, int y, int c) {
      return static_cast<double>(source->engine().frame()[static_cast<std::size_t>(y * resolution.x + x)][c]);
    }));
  }
}

/// Relative differences d of means against `truth`, and their covariance Σ.
struct Differences {
  std::vector<double> value;
  std::vector<double> covariance;  ///< n × n

  Differences(const BlockMeans& biased, const BlockMeans& truth)
      : value(truth.count()), covariance(truth.count() * truth.count()) {
    const std::size_t n = truth.count();
    for (std::size_t i = 0; i < n; ++i) {
      value[i] = biased.mean(i) / truth.mean(i) - 1.0;
      for (std::size_t j = 0; j < n; ++j)
        covariance[i * n + j] = (biased.covariance(i, j) + truth.covariance(i, j)) / (truth.mean(i) * truth.mean(j));
    }
  }
  [[nodiscard]] double error(std::size_t i) const { return std::sqrt(covariance[i * value.size() + i]); }
  /// The standard deviation of Σ_i g_i d_i.
  [[nodiscard]] double error_along(const std::vector<double>& g) const {
    double variance = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i)
      for (std::size_t j = 0; j < g.size(); ++j) variance += g[i] * covariance[i * g.size() + j] * g[j];
    return std::sqrt(std::max(0.0, variance));
  }
  /// The largest difference of a block beyond `errors` times its standard error.
  [[nodiscard]] double worst_beyond(double errors) const {
    double worst = 0.0;
    for (std::size_t i = 0; i < value.size(); ++i) worst = std::max(worst, std::abs(value[i]) - errors * error(i));
    return worst;
  }
};

/// How much of a bias is left at a smaller radius. Before it is b, afterwards ρ b. With g = w
/// d_before, w the inverse variances, g·d_after − ρ g·d_before has at most the mean 0 and is normal
/// with deviations `error_along(g)` (thousands of frames); what the noise of d_before has to do
/// with g only takes from it. The two have truths of their own, so they are independent.
struct Decline {
  double left;       ///< g·d_after / g·d_before: estimates ρ, from below
  double by_chance;  ///< what chance may add to it, at `errors` standard errors
};

Decline decline(const Differences& before, const Differences& after, double most_left, double errors) {
  std::vector<double> g(before.value.size());
  double now = 0.0, then = 0.0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    g[i] = before.value[i] / (gmis::square(before.error(i)) + gmis::square(after.error(i)));
    now += g[i] * after.value[i];
    then += g[i] * before.value[i];
  }
  return {now / then, errors * (after.error_along(g) + most_left * before.error_along(g)) / then};
}

}  // namespace

// Photon mapping makes all its light by merging, so its bias is the largest. Runs start at 16 times
// the radius of the test above; r falls as i^((α − 1)/2) with α = 1/4, so that from row to row
// (iterations 2, 11 to 20, 101 to 200) it is less than half. The bias of a small disk grows as r²,
// of one that reaches beyond what it lies on less, about as r: 0.6 of it may be left. All
// comparisons together raise a false alarm in a thousandth of the seeds: 486 differences of blocks
// and channels (two-sided), and 12 declines.
TEST_CASE("merging's bias stays within its bound and falls along the radius schedule") {
  constexpr double most_left = 0.6;
  const double errors = gmis::normal_quantile(1.0 - gmis::sidak_level(1e-3, 2 * 486 + 12));
  int noticeable = 0;  // declines that a bias which stays as it is would fail
  for (const auto& [objects, light] : {std::pair("rough", "triangle"), std::pair("specular", "environment")}) {
    const Scene scene = scene_of(light, "pinhole", objects);
    const std::size_t blocks = gmis_test::BlockStatistics(scene.built->scene().camera().resolution(), 8).count();
    // One for every other row.
    std::vector<BlockMeans> truths(2, BlockMeans(blocks));
    for (std::size_t i = 0; i < truths.size(); ++i)
      add_run(truths[i], scene, request_for(scene, {IntegratorChoice::bpt, 0, 1}, 5, 9000 + i), 1, 4000);
    for (const IntegratorChoice integrator : {IntegratorChoice::ppm, IntegratorChoice::bpm, IntegratorChoice::vcm}) {
      RenderRequest request = request_for(scene, {integrator, 0, 2}, 5, 9100);
      const double first_radius = 16.0 * radius;
      request.settings.radius = first_radius * scene.built->half_diagonal();
      request.settings.alpha = 0.25;
      std::optional<Differences> previous;
      std::size_t row = 0;
      for (const std::uint32_t last : {2U, 20U, 200U}) {
        // The first iterations are few: many runs of them.
        BlockMeans merged(blocks);
        const std::uint32_t runs = 4000 / last, first = last / 2 + 1;
        for (std::uint32_t run = 0; run < runs; ++run) {
          request.settings.seed = gmis_test::seed(9200 + run);
          add_run(merged, scene, request, first, last);
        }
        double mean_radius = 0.0;
        for (std::uint32_t i = first; i <= last; ++i)
          mean_radius += first_radius * std::pow(i, -0.375) / static_cast<double>(last - first + 1);
        const Differences differences(merged, truths[row++ % 2]);
        const double worst = differences.worst_beyond(errors);
        std::printf("%s, %s, iterations up to %u: radius %.4f, worst beyond noise %.4f", scene.name.c_str(),
                    name_of(integrator), last, mean_radius, worst);
        CAPTURE(scene.name, name_of(integrator), last, mean_radius, worst);
        CHECK(worst < bias_bound * mean_radius);
        if (previous) {
          const Decline found = decline(*previous, differences, most_left, errors);
          std::printf(", %.2f of the bias is left (%.2f by chance)", found.left, found.by_chance);
          CAPTURE(found.left, found.by_chance);
          CHECK(found.left < most_left + found.by_chance);
          noticeable += most_left + found.by_chance < 1.0 ? 1 : 0;
        }
        std::printf("\n");
        std::fflush(stdout);
        previous = differences;
      }
    }
  }
  CHECK(noticeable >= 3);
}
