#include "gmis/result/error_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <numeric>
#include <random>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/result/merging_bias.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

TEST_CASE("Batches are the means of their iterations, and there are never too many") {
  // Iteration i is the number i in every pixel: a batch of length L that begins after b L iterations has the mean
  // b L + (L + 1) / 2.
  const std::size_t capacity = gmis::BatchMeans<float>::capacity;
  gmis::BatchMeans<float> means(3);
  CHECK(means.batch_count() == 0);
  for (int iteration = 1; iteration <= 1000; ++iteration) {
    const auto value = static_cast<float>(iteration);
    means.add_iteration(std::vector<float>{value, 2.0F * value, -value});
    const auto length = static_cast<double>(means.iterations_per_batch());
    CAPTURE(iteration, length);
    REQUIRE(means.batch_count() <= capacity);
    if (iteration > static_cast<int>(capacity)) REQUIRE(means.batch_count() >= capacity / 2);
    // What is left over is less than a batch.
    REQUIRE(iteration - static_cast<int>(length) * static_cast<int>(means.batch_count()) < static_cast<int>(length));
    for (std::size_t b = 0; b < means.batch_count(); ++b) {
      const double expected = static_cast<double>(b) * length + (length + 1.0) / 2.0;
      REQUIRE(static_cast<double>(means.batch(b)[0]) == Approx(expected).epsilon(1e-6));
      REQUIRE(static_cast<double>(means.batch(b)[1]) == Approx(2.0 * expected).epsilon(1e-6));
      REQUIRE(static_cast<double>(means.batch(b)[2]) == Approx(-expected).epsilon(1e-6));
    }
  }
}

TEST_CASE("No interval without four batches, or when one batch has all the variance") {
  gmis::BatchMeans<float> means(1);
  for (const float value : {1.0F, 2.0F, 3.0F}) means.add_iteration(std::vector<float>{value});
  CHECK_FALSE(gmis::estimate_error(means, 3).has_value());
  means.add_iteration(std::vector<float>{4.0F});
  CHECK(gmis::estimate_error(means, 4).has_value());

  gmis::BatchMeans<float> spiked(1);
  for (int i = 0; i < 16; ++i) spiked.add_iteration(std::vector<float>{i == 5 ? 100.0F : 1.0F});
  CHECK_FALSE(gmis::estimate_error(spiked, 16).has_value());
  gmis::BatchMeans<float> constant(1);
  for (int i = 0; i < 16; ++i) constant.add_iteration(std::vector<float>{1.0F});
  CHECK_FALSE(gmis::estimate_error(constant, 16).has_value());
}

TEST_CASE("The leave-one-out sums are those of films made without a batch") {
  // The oracle: the textbook's jackknife by brute force, in long double, and the error of the mean of *all* iterations: also of
  // those that are in no complete batch yet.
  struct Case {
    std::size_t iterations, batches, length;
    long double t;  ///< 97.5 % of Student's distribution with `batches` − 1 degrees of freedom, from tables
  };
  const std::vector<Case> cases{{11, 11, 1, 2.2281388519649385L},
                                {35, 8, 4, 2.3646242515927844L},     // and three more
                                {143, 8, 16, 2.3646242515927844L}};  // and fifteen more
  for (const Case& c : cases) {
    CAPTURE(c.iterations);
    std::mt19937 source(gmis_test::seed(3));
    std::gamma_distribution<float> noise(0.7F, 1.0F);
    const std::size_t pixels = 5;
    std::vector<std::vector<glm::vec3>> frames(c.iterations);
    gmis::BatchMeans<glm::vec3> means(pixels);
    for (auto& frame : frames) {
      for (std::size_t p = 0; p < pixels; ++p)
        frame.emplace_back(noise(source), 0.1F * noise(source), 3.0F * noise(source));
      means.add_iteration(frame);
    }
    REQUIRE(means.batch_count() == c.batches);
    const auto batch_mean = [&](std::size_t b, std::size_t p, int channel) {
      long double sum = 0;
      for (std::size_t i = b * c.length; i < (b + 1) * c.length; ++i)
        sum += static_cast<long double>(frames[i][p][channel]);
      return sum / static_cast<long double>(c.length);
    };
    const auto log_sum_without = [&](std::size_t left_out) {
      long double sum = 0;
      for (std::size_t p = 0; p < pixels; ++p)
        for (int channel = 0; channel < 3; ++channel) {
          long double mean = 0, squares = 0, count = 0;
          for (std::size_t b = 0; b < c.batches; ++b)
            if (b != left_out) {
              mean += batch_mean(b, p, channel);
              count += 1;
            }
          mean /= count;
          for (std::size_t b = 0; b < c.batches; ++b)
            if (b != left_out) squares += std::pow(batch_mean(b, p, channel) - mean, 2.0L);
          sum += squares / (count - 1) / (mean * mean + 0.01L);
        }
      return std::log(sum / (3.0L * static_cast<long double>(pixels)));
    };
    const auto count = static_cast<long double>(c.batches);
    long double mean_log = 0, spread = 0;
    for (std::size_t b = 0; b < c.batches; ++b) mean_log += log_sum_without(b) / count;
    for (std::size_t b = 0; b < c.batches; ++b) spread += std::pow(log_sum_without(b) - mean_log, 2.0L);
    const long double error = std::sqrt(spread * (count - 1) / count);
    const long double centre = count * log_sum_without(c.batches) - (count - 1) * mean_log;
    // The variance of a batch mean, times the length of a batch, is that of an iteration.
    const long double share = static_cast<long double>(c.length) / static_cast<long double>(c.iterations);
    const auto error_at = [&](long double log_sum) {
      return static_cast<double>(std::sqrt(std::exp(log_sum) * share));
    };
    const auto estimate = gmis::estimate_error(means, c.iterations);
    REQUIRE(estimate.has_value());
    CHECK(estimate->value == Approx(error_at(centre)).epsilon(1e-5));
    CHECK(estimate->lower == Approx(error_at(centre - c.t * error)).epsilon(1e-5));
    CHECK(estimate->upper == Approx(error_at(centre + c.t * error)).epsilon(1e-5));
  }
}

// 1,000 runs whose truth is known in closed form: 6 pixels, log-normal noise. The count of intervals that cover it is
// binomial: were the coverage exactly 95 %, it would be outside 93–97 % in 0.4 % of all seeds.
TEST_CASE("The 95 % interval covers a known error in 93 to 97 % of 1,000 runs") {
  const std::size_t pixels = 6;
  const int iterations = 200, runs = 1000;
  const double sigma = 0.6;
  const double relative_variance = std::exp(sigma * sigma) - 1.0;
  double truth = 0.0;
  std::vector<float> scale;
  for (std::size_t p = 0; p < pixels; ++p) {
    scale.push_back(0.1F + 0.2F * static_cast<float>(p));
    const double mean = static_cast<double>(scale.back());
    truth += mean * mean * relative_variance / iterations / (mean * mean + 0.01) / static_cast<double>(pixels);
  }
  truth = std::sqrt(truth);
  std::mt19937 source(gmis_test::seed(11));
  std::lognormal_distribution<float> noise(static_cast<float>(-0.5 * sigma * sigma), static_cast<float>(sigma));
  int covered = 0;
  for (int run = 0; run < runs; ++run) {
    gmis::BatchMeans<float> means(pixels);
    std::vector<float> frame(pixels);
    for (int i = 0; i < iterations; ++i) {
      std::transform(scale.begin(), scale.end(), frame.begin(), [&](float mean) { return mean * noise(source); });
      means.add_iteration(frame);
    }
    const auto estimate = gmis::estimate_error(means, static_cast<std::uint64_t>(iterations));
    if (estimate && estimate->lower <= truth && truth <= estimate->upper) ++covered;
  }
  INFO("covered " << covered << " of " << runs);
  CHECK(covered >= 930);
  CHECK(covered <= 970);
}

TEST_CASE("Merging's bias from two radii: found where there is one, not where there is none") {
  // A made-up estimator whose expected value at radius r is 1 + 0.5 r² in every pixel, with noise that both radii share for
  // the most part; the relative bias at r = 0.2 is 0.02 / √(1.02² + 0.01).
  std::mt19937 source(gmis_test::seed(5));
  std::normal_distribution<float> noise(0.0F, 1.0F);
  const auto bias_of = [&](float strength) {
    gmis::Film<float> difference({20, 20}), value({20, 20});
    std::vector<float> at_r(400), apart(400);
    for (int i = 0; i < 64; ++i) {
      for (std::size_t p = 0; p < at_r.size(); ++p) {
        at_r[p] = 1.0F + strength * 0.04F + 0.3F * noise(source);
        apart[p] = strength * 0.12F + 0.1F * noise(source);
      }
      difference.add_iteration(apart);
      value.add_iteration(at_r);
    }
    return gmis::merging_bias(difference, value, 2.0);
  };
  const gmis::MergingBias present = bias_of(0.5F);
  // Its square is what is estimated, the mean of 400 pixels: 4.5 of its standard errors, a false alarm in 7e-6 of the seeds.
  const double truth = 0.02 / std::sqrt(1.02 * 1.02 + 0.01);
  CHECK(std::abs(gmis::square(present.relative_bias) - gmis::square(truth)) <
        4.5 * gmis::square(present.standard_error));
  CHECK(present.standard_error < 0.25 * truth);
  CHECK(present.relative_bias > 3.0 * present.standard_error);
  const gmis::MergingBias absent = bias_of(0.0F);
  CHECK(gmis::square(absent.relative_bias) < 4.5 * gmis::square(absent.standard_error));
  CHECK(absent.standard_error < 0.003);
}
