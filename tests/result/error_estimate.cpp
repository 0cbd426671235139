#include "gmis/result/error_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>
#include <map>
#include <numeric>
#include <random>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/render/thread_executor.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/seed.hpp"

TEST_CASE("Batches are the means of their iterations, and there are never too many") {
  // Iteration i is the number i in every pixel: a batch of length L that begins after b L
  // iterations has the mean b L + (L + 1) / 2.
  const std::size_t capacity = gmis::BatchMeans<float>::capacity;
  gmis::BatchMeans<float> means({3, 1});
  CHECK(means.batch_count() == 0);
  for (int iteration = 1; iteration <= 1000; ++iteration) {
    const auto value = static_cast<float>(iteration);
    means.add_iteration(std::vector<float>{value, 2.0F * value, -value});
    const auto length = static_cast<double>(means.iterations_of(0));
    CAPTURE(iteration, length);
    REQUIRE(means.batch_count() <= capacity);
    if (iteration > static_cast<int>(capacity)) REQUIRE(means.batch_count() >= capacity / 2);
    // What is left over is less than a batch.
    REQUIRE(iteration - static_cast<int>(length) * static_cast<int>(means.batch_count()) < static_cast<int>(length));
    for (std::size_t b = 0; b < means.batch_count(); ++b) {
      const double expected = static_cast<double>(b) * length + (length + 1.0) / 2.0;
      REQUIRE(static_cast<double>(means.value(b, 0)) == Approx(expected).epsilon(1e-6));
      REQUIRE(static_cast<double>(means.value(b, 1)) == Approx(2.0 * expected).epsilon(1e-6));
      REQUIRE(static_cast<double>(means.value(b, 2)) == Approx(-expected).epsilon(1e-6));
    }
  }
}

namespace {

/// A made-up picture whose truth is known: smooth brightness, noise of a gamma distribution, and in
/// some pixels now and then a bright sample (a firefly), which is part of the truth.
class Picture {
 public:
  Picture(glm::ivec2 size, double firefly_rate, double firefly) : size_(size), rate_(firefly_rate), firefly_(firefly) {
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) quiet_.push_back(0.05 + 0.6 * x / size.x + 0.3 * y / size.y);
  }

  [[nodiscard]] double truth(std::size_t pixel) const { return quiet_[pixel] + rate_ * firefly_; }

  void add_iteration(std::mt19937& source, gmis::BatchMeans<float>& means) const {
    std::gamma_distribution<double> noise(4.0, 0.25);
    std::uniform_real_distribution<double> uniform;
    std::vector<float> frame;
    for (const double quiet : quiet_)
      frame.push_back(static_cast<float>(quiet * noise(source) + (uniform(source) < rate_ ? firefly_ : 0.0)));
    means.add_iteration(frame);
  }

  [[nodiscard]] gmis::BatchMeans<float> run(std::mt19937& source, int iterations) const {
    gmis::BatchMeans<float> means(size_);
    for (int i = 0; i < iterations; ++i) add_iteration(source, means);
    return means;
  }

  /// √relMSE of the mean of all iterations against the truth; by the older rule, which divides by
  /// the same pixel's mean.
  struct Errors {
    double true_error = 0, by_own_mean = 0;
  };
  [[nodiscard]] Errors errors_of(const gmis::BatchMeans<float>& means) const {
    const std::size_t batches = means.batch_count();
    double error = 0, own = 0;
    for (std::size_t p = 0; p < quiet_.size(); ++p) {
      double mean = 0, squares = 0;
      for (std::size_t b = 0; b < batches; ++b) mean += means.value(b, p) / static_cast<double>(batches);
      for (std::size_t b = 0; b < batches; ++b) squares += std::pow(means.value(b, p) - mean, 2);
      error += std::pow(mean - truth(p), 2) / (std::pow(truth(p), 2) + gmis::relative_error_floor);
      own += squares / static_cast<double>(batches * (batches - 1)) / (mean * mean + gmis::relative_error_floor);
    }
    const auto count = static_cast<double>(quiet_.size());
    return {std::sqrt(error / count), std::sqrt(own / count)};
  }

 private:
  glm::ivec2 size_;
  double rate_, firefly_;
  std::vector<double> quiet_;
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace

namespace {

using Real = long double;

/// The mean of `value_at` around a pixel, by the definition of `neighbourhood_without`, and how far
/// it reaches.
std::pair<Real, int> value_around(glm::ivec2 size, std::size_t pixel, Real added, const auto& value_at) {
  const int x = static_cast<int>(pixel) % size.x, y = static_cast<int>(pixel) / size.x;
  for (int reach = 1;; reach *= 2) {
    Real light = 0, sum = 0, weights = 0;
    for (int v = std::max(0, y - reach); v < std::min(size.y, y + reach + 1); ++v)
      for (int u = std::max(0, x - reach); u < std::min(size.x, x + reach + 1); ++u) {
        const Real value = value_at(static_cast<std::size_t>(v * size.x + u));
        const Real weight = (reach + 1 - std::abs(u - x)) * (reach + 1 - std::abs(v - y));
        light += value;
        sum += weight * value;
        weights += weight;
      }
    if (light >= 2.5L * added || reach == 16) return {sum / weights, reach};
  }
}

/// The sums of `estimate_error`, by its definition.
struct Definition {
  Real sum = 0, near = 0, far = 0;  // the squared error; relative to the mean of all parts, and to that of the others
  std::vector<Real> per_pixel;      // of `sum`
  std::vector<std::vector<Real>> scaled;  // for every part its deviations, divided by what the value is taken for
  int rare = 0, brighter = 0;             // rare samples; those in places that are brighter than what is around
};

/// `shares` of the parts; `value(part, pixel, channel)`.
Definition by_definition(glm::ivec2 size, int channels, const std::vector<Real>& shares, const auto& value) {
  const std::size_t count = shares.size(), pixels = static_cast<std::size_t>(size.x * size.y);
  const auto mean_without = [&](std::size_t p, int c, std::size_t left_out) {
    Real sum = 0, weight = 0;
    for (std::size_t b = 0; b < count; ++b)
      if (b != left_out) sum += shares[b] * value(b, p, c), weight += shares[b];
    return sum / weight;
  };
  struct Look {  // of a part at a value
    std::size_t pixel, part;
    Real deviation, all, others, variance,
        spread;  // spread: the variance of the mean by the others, without the farthest
    bool is_rare;
    Real around;
    int reach;
  };
  std::vector<Look> looks;
  struct Brightness {  // of pixels with rare samples
    Real there = 0, there_squares = 0, around = 0;
    [[nodiscard]] Real factor() const {
      const Real effective = there * there / there_squares;
      return 1 + std::max(0.0L, there / around - 1) * effective / (effective + 20);
    }
  };
  std::map<int, Brightness> brightness;  // by reach
  for (std::size_t p = 0; p < pixels; ++p)
    for (int c = 0; c < channels; ++c)
      for (std::size_t b = 0; b < count; ++b) {
        const Real here = value(b, p, c), all = mean_without(p, c, count), others = mean_without(p, c, b);
        const Real own = shares[b] * (1 - shares[b]) * (here - others) * (here - others);
        Look look{p, b, here - all, all, others, shares[b] * own, 0, false, 0, 0};
        Real rest = 0, farthest = 0;
        for (std::size_t k = 0; k < count; ++k) {
          if (k == b) continue;
          const Real off = value(k, p, c) - others;
          rest += shares[k] * off * off;
          farthest = std::max(farthest, shares[k] * off * off);
        }
        look.spread = (rest - farthest) / static_cast<Real>(count - 3);
        look.is_rare = own > 25 * look.spread;
        if (look.is_rare) {
          std::tie(look.around, look.reach) =
              value_around(size, p, shares[b] * here, [&](std::size_t q) { return mean_without(q, c, b); });
          const Real weight = look.variance / (look.around * look.around + 0.01L);
          brightness[look.reach].there += weight * others;
          brightness[look.reach].there_squares += weight * weight * others * others;
          brightness[look.reach].around += weight * look.around;
        }
        looks.push_back(look);
      }
  Definition all;
  all.per_pixel.resize(pixels);
  all.scaled.resize(count);
  for (const Look& look : looks) {
    const Real v = look.others;
    all.near += look.variance / (look.all * look.all + 0.01L);
    all.far += look.variance / (v * v + 0.01L);
    Real inverse = 1 / (v * v + 0.01L);
    if (look.is_rare) {
      const Real factor = brightness[look.reach].factor(), taken_for = look.around * factor;
      inverse = 1 / (taken_for * taken_for + 0.01L);
      ++all.rare;
      all.brighter += factor > 1 ? 1 : 0;
    } else {
      const Real curvature = std::max(0.0L, 3 * v * v - 0.01L) / ((v * v + 0.01L) * (v * v + 0.01L));
      inverse /= 1 + curvature * look.spread / (1 - shares[look.part]);
    }
    all.sum += look.variance * inverse;
    all.per_pixel[look.pixel] += look.variance * inverse;
    all.scaled[look.part].push_back(shares[look.part] * look.deviation * std::sqrt(inverse));
  }
  return all;
}

}  // namespace

TEST_CASE("The estimate is its definition, summed by brute force") {
  // In long double, from the frames themselves, with batches of two iterations and one iteration
  // left over. The estimate takes pixels in blocks: the larger picture is of three, the last not
  // whole.
  const glm::ivec2 size = GENERATE(glm::ivec2(7, 6), glm::ivec2(83, 71));
  CAPTURE(size.x, size.y);
  const auto pixels = static_cast<std::size_t>(size.x * size.y);
  std::mt19937 source(gmis_test::seed(3));
  std::gamma_distribution<float> noise(0.7F, 1.0F);
  std::uniform_int_distribution<std::size_t> anywhere(0, pixels - 1);
  const int iterations = 21;
  std::vector<std::vector<glm::vec3>> frames;
  gmis::BatchMeans<glm::vec3> means(size);
  for (int i = 0; i < iterations; ++i) {
    auto& frame = frames.emplace_back();
    for (std::size_t p = 0; p < pixels; ++p)
      frame.emplace_back(noise(source), 0.1F * noise(source), 3.0F * noise(source));
    frame[anywhere(source)] += glm::vec3(50.0F);
    if (i == 3 || i == 12) frame[17] += glm::vec3(300.0F);  // where the other parts see bright samples, too
    // A batch and the iteration that is left over are equally far off the others.
    frame[5] = i == 4 || i == 5 || i == 20 ? glm::vec3(0.0F) : glm::vec3(1.0F) + 0.01F * frame[5];
    means.add_iteration(frame);
  }
  std::vector<Real> shares(10, Real(2) / iterations);
  shares.push_back(Real(1) / iterations);
  const Definition expected = by_definition(size, 3, shares, [&](std::size_t part, std::size_t p, int c) {
    const std::size_t first = 2 * part;
    const auto at = [&](std::size_t i) { return static_cast<Real>(frames[i][p][c]); };
    return part < 10 ? (at(first) + at(first + 1)) / 2 : at(first);
  });
  const Real sum = expected.sum;
  const std::vector<Real>& per_pixel = expected.per_pixel;
  REQUIRE(expected.rare > 10);
  REQUIRE(expected.brighter > 0);
  const auto estimate = gmis::estimate_error(means);
  REQUIRE(estimate.has_value());
  CHECK(estimate->relative_error == Approx(static_cast<double>(std::sqrt(sum / (3.0L * pixels)))).epsilon(1e-5));
  CHECK(estimate->interval.value == estimate->relative_error);
  std::vector<Real> sorted = per_pixel;
  std::sort(sorted.rbegin(), sorted.rend());
  Real five = 0;
  for (std::size_t k = 0; k < 5; ++k) {
    five += sorted[k] / sum;
    CHECK(estimate->worst[k].share == Approx(static_cast<double>(sorted[k] / sum)).epsilon(1e-4));
    CHECK(static_cast<double>(per_pixel[estimate->worst[k].pixel]) == Approx(static_cast<double>(sorted[k])));
  }
  CHECK(estimate->share_of_worst() == Approx(static_cast<double>(five)).epsilon(1e-4));
  const std::size_t kept = pixels - pixels / 1000;  // all of 42, 5888 of 5893
  const Real sum_of_kept = std::accumulate(sorted.end() - static_cast<std::ptrdiff_t>(kept), sorted.end(), Real(0));
  CHECK(estimate->relative_error_trimmed ==
        Approx(static_cast<double>(std::sqrt(sum_of_kept / static_cast<Real>(3 * kept)))).epsilon(1e-5));

  // The interval: how far the products of different parts scatter about the mean that they should
  // have.
  Real chance = 0;
  for (std::size_t b = 0; b < shares.size(); ++b)
    for (std::size_t c = 0; c < b; ++c) {
      Real product = 0;
      for (std::size_t i = 0; i < expected.scaled[b].size(); ++i)
        product += expected.scaled[b][i] * expected.scaled[c][i];
      chance += std::pow(product + shares[b] * shares[c] * sum, 2.0L);
    }
  const auto count = static_cast<Real>(shares.size());
  const Real deviation = 2 * std::sqrt(chance / ((count - 1) * (count - 3))) * count / sum;
  const auto reach_at = [&](double quantile) {
    const Real t = gmis::student_t_quantile(quantile, static_cast<double>(shares.size() - 1));
    return static_cast<double>(
        std::exp((t * deviation + std::log(std::max({1.0L, expected.far / sum, sum / expected.near}))) / 2));
  };
  CHECK(estimate->interval.upper / estimate->relative_error == Approx(reach_at(0.975)).epsilon(1e-4));
  CHECK(estimate->relative_error / estimate->interval.lower == Approx(reach_at(0.975)).epsilon(1e-4));
  const auto with_half = gmis::estimate_error(means, 0.5);  // a confidence of a half
  CHECK(with_half->interval.upper / estimate->relative_error == Approx(reach_at(0.75)).epsilon(1e-4));

  // On threads: the same bits.
  for (const int threads : {1, 3}) {
    gmis::ThreadExecutor executor(threads);
    const auto same = gmis::estimate_error(means, executor);
    CHECK(same->relative_error == estimate->relative_error);
    CHECK(same->relative_error_trimmed == estimate->relative_error_trimmed);
    CHECK(same->interval.upper == estimate->interval.upper);
    for (std::size_t k = 0; k < 5; ++k) CHECK(same->worst[k].pixel == estimate->worst[k].pixel);
  }
}

TEST_CASE("Joined runs: few parts, none short, and nothing lost") {
  struct Lengths {
    int first, second, third;
  };
  for (const Lengths n :
       {Lengths{1, 1, 1}, {8, 8, 8}, {16, 16, 0}, {100, 100, 100}, {1000, 3, 7}, {5, 1000, 64}, {37, 40, 1}})
    for (const std::size_t replications : {std::size_t{0}, std::size_t{8}}) {
      CAPTURE(n.first, n.second, n.third, replications);
      gmis::BatchMeans<float> joined({2, 1}, replications);
      double sum = 0, iterations = 0;
      int value = 0;
      for (const int length : {n.first, n.second, n.third}) {
        gmis::BatchMeans<float> means({2, 1}, replications);
        for (int i = 0; i < length; ++i) {
          ++value;
          means.add_iteration(std::vector<float>{static_cast<float>(value), -static_cast<float>(value)});
          sum += value;
          ++iterations;
        }
        joined.join(means);
        REQUIRE(static_cast<double>(joined.iterations()) == iterations);
        REQUIRE(joined.batch_count() <= gmis::BatchMeans<float>::capacity);
        REQUIRE(joined.unfinished_iterations() == 0);
        std::uint64_t shortest = joined.iterations(), longest = 0;
        double parts = 0, opposite = 0, lengths = 0;
        for (std::size_t b = 0; b < joined.batch_count(); ++b) {
          shortest = std::min(shortest, joined.iterations_of(b));
          longest = std::max(longest, joined.iterations_of(b));
          lengths += static_cast<double>(joined.iterations_of(b));
          parts += static_cast<double>(joined.iterations_of(b)) * joined.value(b, 0);
          opposite += static_cast<double>(joined.iterations_of(b)) * joined.value(b, 1);
        }
        REQUIRE(2 * shortest >= longest);
        REQUIRE(lengths == iterations);
        REQUIRE(parts == Approx(sum).epsilon(1e-6));
        REQUIRE(opposite == Approx(-sum).epsilon(1e-6));
      }
      if (n.first >= 100 && n.second >= 100) CHECK(joined.batch_count() >= gmis::BatchMeans<float>::capacity / 2);
    }
}

TEST_CASE("The estimate of joined runs is its definition, summed by brute force") {
  // In long double, from parts of unequal lengths.
  std::mt19937 source(gmis_test::seed(4));
  std::gamma_distribution<float> noise(0.7F, 1.0F);
  std::uniform_int_distribution<std::size_t> anywhere(0, 41);
  const glm::ivec2 size{7, 6};
  gmis::BatchMeans<float> means(size);
  for (const int iterations : {11, 18}) {
    gmis::BatchMeans<float> run(size);
    for (int i = 0; i < iterations; ++i) {
      std::vector<float> frame;
      for (int p = 0; p < 42; ++p) frame.push_back(noise(source));
      frame[anywhere(source)] += 50.0F;
      run.add_iteration(frame);
    }
    means.join(run);
  }
  std::vector<Real> shares;
  for (std::size_t b = 0; b < means.batch_count(); ++b)
    shares.push_back(static_cast<Real>(means.iterations_of(b)) / 29);
  const Definition expected = by_definition(
      size, 1, shares, [&](std::size_t part, std::size_t p, int) { return static_cast<Real>(means.value(part, p)); });
  CHECK(std::any_of(shares.begin(), shares.end(), [&](Real share) { return share != shares[0]; }));
  REQUIRE(expected.rare > 10);
  const auto estimate = gmis::estimate_error(means);
  REQUIRE(estimate.has_value());
  CHECK(estimate->relative_error == Approx(static_cast<double>(std::sqrt(expected.sum / 42))).epsilon(1e-6));

  // The variance of each mean, from how far each part is off the mean of the others.
  const std::vector<double> variances = gmis::variances_of_means(means);
  REQUIRE(variances.size() == 42);
  for (std::size_t p = 0; p < 42; ++p) {
    Real all = 0, variance = 0;
    for (std::size_t b = 0; b < shares.size(); ++b) all += shares[b] * static_cast<Real>(means.value(b, p));
    for (std::size_t b = 0; b < shares.size(); ++b) {
      const auto here = static_cast<Real>(means.value(b, p));
      const Real others = (all - shares[b] * here) / (1 - shares[b]);
      variance += shares[b] * shares[b] * (1 - shares[b]) * (here - others) * (here - others);
    }
    CHECK(variances[p] == Approx(static_cast<double>(variance)).epsilon(1e-9));
  }
  CHECK(gmis::variances_of_means(gmis::BatchMeans<float>(size)).empty());
}

// As below for single runs: fewer than 90 % of 400 would be in 1 of 40,000 seeds.
TEST_CASE("The interval of joined runs covers the true error in at least 90 % of 400 runs", "[long]") {
  std::mt19937 source(gmis_test::seed(14));
  const Picture picture({16, 16}, 0.0, 0.0);
  int covered = 0, shown = 0;
  double stated = 0, true_errors = 0;
  constexpr int runs = 400;
  for (int run = 0; run < runs; ++run) {
    gmis::BatchMeans<float> means = picture.run(source, 13);
    means.join(picture.run(source, 40));
    const auto estimate = gmis::estimate_error(means);
    REQUIRE(estimate.has_value());
    double truth = 0;
    for (std::size_t p = 0; p < 256; ++p) {
      double mean = 0;
      for (std::size_t b = 0; b < means.batch_count(); ++b)
        mean += static_cast<double>(means.iterations_of(b)) * means.value(b, p) / 53;
      truth +=
          gmis::square(mean - picture.truth(p)) / (gmis::square(picture.truth(p)) + gmis::relative_error_floor) / 256;
    }
    stated += gmis::square(estimate->relative_error) / runs;
    true_errors += truth / runs;
    if (!estimate->is_calibrated()) continue;
    ++shown;
    if (gmis::square(estimate->interval.lower) <= truth && truth <= gmis::square(estimate->interval.upper)) ++covered;
  }
  CAPTURE(covered, shown, stated / true_errors);
  CHECK(shown > runs * 9 / 10);
  CHECK(covered >= shown * 9 / 10);
  // A squared error over 256 pixels has a relative standard deviation of √(2/256), its mean over
  // 400 runs one of 0.0044; that it is relative to measured values adds up to 0.01.
  CHECK(stated / true_errors == Approx(1.0).margin(0.03));
}

// Fireflies carry a fifth of this picture's light. In 6 × 41 runs at most a sixth was above 1.2 or
// below 0.85, whatever the number of iterations; were it a fifth, the median of 41 would be beyond
// either limit with a chance of 8e-6. What divides by the same pixel's mean is far off.
TEST_CASE("Fireflies: the stated error is the true one, and has no interval") {
  std::mt19937 source(gmis_test::seed(17));
  const Picture picture({24, 24}, 0.006, 20.0);
  for (const int iterations : {8, 16, 32, 128}) {
    std::vector<double> stated, own;
    int shown = 0;
    for (int run = 0; run < 41; ++run) {
      const auto means = picture.run(source, iterations);
      const auto errors = picture.errors_of(means);
      const auto estimate = gmis::estimate_error(means);
      REQUIRE(estimate.has_value());
      stated.push_back(estimate->relative_error / errors.true_error);
      own.push_back(errors.by_own_mean / errors.true_error);
      shown += estimate->is_calibrated() ? 1 : 0;
    }
    CAPTURE(iterations, median(stated), median(own), shown);
    CHECK(median(stated) > 0.85);
    CHECK(median(stated) < 1.2);
    CHECK(median(own) < (iterations < 128 ? 0.6 : 0.9));
    CHECK(shown == 0);
  }
}

// Intervals are for this very picture's error, so every run has its own truth. Were each covered
// with a probability of 95 %, fewer than 90 % of 400 would be in 1 of 40,000 seeds.
TEST_CASE("Without fireflies the interval covers the true error in at least 90 % of 400 runs", "[long]") {
  std::mt19937 source(gmis_test::seed(11));
  const Picture picture({16, 16}, 0.0, 0.0);
  for (const int iterations : {16, 32, 128}) {
    int covered = 0, shown = 0;
    double reach = 0;
    constexpr int runs = 400;
    for (int run = 0; run < runs; ++run) {
      const auto means = picture.run(source, iterations);
      const auto estimate = gmis::estimate_error(means);
      REQUIRE(estimate.has_value());
      if (!estimate->is_calibrated()) continue;
      ++shown;
      const double truth = picture.errors_of(means).true_error;
      if (estimate->interval.lower <= truth && truth <= estimate->interval.upper) ++covered;
      reach += estimate->interval.upper / estimate->relative_error - 1;
    }
    CAPTURE(iterations, covered, shown, reach / shown);
    CHECK(shown > runs * 9 / 10);
    CHECK(covered >= shown * 9 / 10);
    CHECK(reach / shown < 0.2);
  }
}

TEST_CASE("Replications are batches: iteration i belongs to (i - 1) mod R, and all are complete") {
  constexpr std::size_t replications = 8;
  gmis::BatchMeans<float> means({2, 1}, replications);
  std::vector<std::vector<double>> seen(replications);
  for (std::size_t i = 0; i < 45; ++i) {
    const float value = static_cast<float>((i * 7) % 13);
    means.add_iteration(std::vector<float>{value, -value});
    seen[i % replications].push_back(static_cast<double>(value));
    REQUIRE(means.batch_count() == std::min(i + 1, replications));
    REQUIRE(means.unfinished_iterations() == 0);
    for (std::size_t b = 0; b < means.batch_count(); ++b) {
      double mean = 0.0;
      for (const double one : seen[b]) mean += one / static_cast<double>(seen[b].size());
      REQUIRE(means.iterations_of(b) == seen[b].size());
      REQUIRE(means.value(b, 0) == Approx(mean));
      REQUIRE(means.value(b, 1) == Approx(-mean));
    }
  }
}

// As above, with iterations that depend on each other within a replication, as those of
// low-discrepancy numbers do: the samples of a replication are strata of one uniform number, in an
// order of their own.
TEST_CASE(
    "With dependent iterations in independent replications the interval covers the true error in at least 90 % of 400 "
    "runs",
    "[long]") {
  constexpr std::size_t replications = 8, pixels = 256;
  std::mt19937 source(gmis_test::seed(12));
  for (const int iterations : {16, 64, 100}) {
    int covered = 0, shown = 0;
    double stated = 0.0, of_consecutive = 0.0, true_errors = 0.0;
    constexpr int runs = 400;
    for (int run = 0; run < runs; ++run) {
      gmis::BatchMeans<float> means({16, 16}, replications), consecutive({16, 16});
      std::uniform_real_distribution<double> uniform;
      std::vector<double> shift(replications * pixels), sums(pixels, 0.0);
      for (double& one : shift) one = uniform(source);
      for (int i = 0; i < iterations; ++i) {
        std::vector<float> frame;
        for (std::size_t p = 0; p < pixels; ++p) {
          // Of the golden ratio: any consecutive points are spread evenly. Beside it, noise of its
          // own.
          const double turn = shift[static_cast<std::size_t>(i) % replications * pixels + p] +
                              0.6180339887498949 * (i / static_cast<int>(replications));
          const double u = turn - std::floor(turn);
          frame.push_back(static_cast<float>(0.3 + u * u + 0.3 * uniform(source)));
          sums[p] += static_cast<double>(frame.back());
        }
        means.add_iteration(frame);
        consecutive.add_iteration(frame);
      }
      constexpr double truth = 0.3 + 1.0 / 3.0 + 0.15;
      double error = 0.0;
      for (const double sum : sums) error += std::pow(sum / iterations - truth, 2) / (truth * truth + 0.01) / pixels;
      error = std::sqrt(error);
      const auto estimate = gmis::estimate_error(means);
      REQUIRE(estimate.has_value());
      true_errors += error / runs;
      stated += estimate->relative_error / runs;
      of_consecutive += gmis::estimate_error(consecutive)->relative_error / runs;
      if (!estimate->is_calibrated()) continue;
      ++shown;
      if (estimate->interval.lower <= error && error <= estimate->interval.upper) ++covered;
    }
    CAPTURE(iterations, covered, shown, stated / true_errors, of_consecutive / true_errors);
    CHECK(shown > runs * 9 / 10);
    CHECK(covered >= shown * 9 / 10);
    CHECK(stated / true_errors == Approx(1.0).margin(0.03));
    if (iterations > 16) CHECK(of_consecutive / true_errors > 1.2);  // why replications must be the batches
  }
}

TEST_CASE("Doubts: what is too little, what is black, what does not vary, what a few pixels rule") {
  std::mt19937 source(gmis_test::seed(5));
  const Picture picture({16, 16}, 0.0, 0.0);
  CHECK_FALSE(gmis::estimate_error(picture.run(source, 1)).has_value());
  CHECK(gmis::estimate_error(picture.run(source, 2))->relative_error > 0);
  CHECK(gmis::estimate_error(picture.run(source, 7))->doubt == gmis::ErrorDoubt::few_batches);
  const auto sure = picture.run(source, 32);  // 16 batches
  CHECK(gmis::estimate_error(sure)->doubt == gmis::ErrorDoubt::none);
  // Each limit by itself brings its own doubt.
  const auto doubt_with = [&](const gmis::ErrorCalibration& calibration) {
    return gmis::estimate_error(sure, 0.95, calibration)->doubt;
  };
  CHECK(doubt_with({.fewest_batches = 16}) == gmis::ErrorDoubt::none);
  CHECK(doubt_with({.fewest_batches = 17}) == gmis::ErrorDoubt::few_batches);
  CHECK(doubt_with({.largest_disagreement = 1.0}) == gmis::ErrorDoubt::rare_events);
  CHECK(doubt_with({.largest_deviation = 0.0}) == gmis::ErrorDoubt::few_pixels);
  CHECK(doubt_with({.largest_share_of_worst = 0.0}) == gmis::ErrorDoubt::few_pixels);

  for (const float value : {0.0F, 0.1F, 3.0F}) {  // black, or what needs no sampling
    gmis::BatchMeans<float> constant({4, 4});
    for (int i = 0; i < 37; ++i) constant.add_iteration(std::vector<float>(16, value));
    const auto estimate = gmis::estimate_error(constant);
    REQUIRE(estimate.has_value());
    CHECK(estimate->doubt == gmis::ErrorDoubt::nothing_found);
    CHECK_FALSE(estimate->is_calibrated());
    CHECK(estimate->relative_error == 0);
  }

  std::normal_distribution<float> noise(1.0F, 0.02F);
  gmis::BatchMeans<float> spiked({16, 16});
  for (int i = 0; i < 64; ++i) {
    std::vector<float> frame(256);
    for (float& value : frame) value = noise(source);
    if (i == 11) frame[37] = 500.0F;
    spiked.add_iteration(frame);
  }
  const auto estimate = gmis::estimate_error(spiked);
  CHECK(estimate->doubt == gmis::ErrorDoubt::rare_events);
  CHECK(estimate->worst[0].pixel == 37);
  CHECK(estimate->worst[0].share > 0.99);
  // Of 256 pixels none is trimmed; the squared error is that of one sample among 64, relative to a
  // value of 1.
  CHECK(estimate->relative_error_trimmed == estimate->relative_error);
  CHECK(estimate->relative_error == Approx(500.0 / 64 / std::sqrt(1.01) / 16).epsilon(0.05));
}

TEST_CASE("An image and a reference of another size are not compared") {
  const std::vector<float> two_pixels{1, 2, 3, 100, 100, 100}, one_pixel{1, 2, 3}, none;
  for (const auto& [image, reference] :
       {std::pair(two_pixels, one_pixel), std::pair(one_pixel, two_pixels), std::pair(one_pixel, none)})
    CHECK(gmis_test::message_of([&shown = image, &wanted = reference] {
            return gmis::image_error(std::span<const float>(shown), std::span<const float>(wanted), 3);
          }) == "the reference must have the pixels and channels of the image");
}

TEST_CASE("A number of replications that batches cannot hold is refused") {
  using Means = gmis::BatchMeans<float>;
  for (const std::size_t number : {std::size_t{1}, Means::capacity + 1, std::size_t{40}})
    CHECK(gmis_test::message_of([&] {
            return Means({4, 4}, number);
          }) == "the number of replications must be 0, or from 2 to BatchMeans::capacity");
  for (const std::size_t number : {std::size_t{0}, std::size_t{2}, Means::capacity}) {
    Means means({4, 4}, number);
    for (int i = 0; i < 80; ++i) means.add_iteration(std::vector<float>(16, static_cast<float>(i % 3)));
    CHECK(gmis::estimate_error(means).has_value());
  }
}

TEST_CASE("What is dropped from a trimmed error is what image_error drops") {
  // 2,000 pixels: two are dropped.
  gmis::BatchMeans<float> means({50, 40});
  for (int i = 0; i < 16; ++i) {
    std::vector<float> frame(2000, i % 2 == 0 ? 0.9F : 1.1F);
    for (const std::size_t p : {3U, 700U, 1500U}) frame[p] = i == 4 ? 300.0F : 1.0F;
    means.add_iteration(frame);
  }
  const auto estimate = gmis::estimate_error(means);
  REQUIRE(estimate.has_value());
  const double all = estimate->relative_error * estimate->relative_error * 2000;
  const double kept = estimate->relative_error_trimmed * estimate->relative_error_trimmed * 1998;
  CHECK(kept / all == Approx(1.0 / 3).epsilon(0.01));
  std::vector<float> image(2000, 1.0F), reference(2000, 1.0F);
  for (const std::size_t p : {3U, 700U, 1500U}) image[p] = 20.0F;
  const gmis::ImageError error = gmis::image_error(std::span<const float>(image), std::span<const float>(reference), 1);
  CHECK(error.relmse_trimmed * 1998 / (error.relmse * 2000) == Approx(1.0 / 3).epsilon(1e-9));
}
