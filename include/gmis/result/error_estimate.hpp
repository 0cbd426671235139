#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/result/batch_means.hpp"

namespace gmis {

/// A figure and the interval that covers its true value with the stated confidence.
struct Interval {
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
};

/// The relative error of an image, estimated without a reference from independent batches of its iterations.
///
/// The true value is √(mean over pixels and channels of Var / (v² + 0.01)): v is the expected value there and Var the
/// variance of the mean of `iterations` iterations. It is the expected relMSE against a perfect reference, square-rooted,
/// so far as the image is unbiased: *the bias of merging is not part of it* (see `merging_bias`).
///
/// `value` is the estimate from the batches, the jackknife's correction for the curvature of the ratio included. The
/// interval is Student's, by the jackknife over batches, of the logarithm: the error is positive and its estimate
/// skewed. Nothing is returned with fewer than 4 batches, or when all the variance comes from a single batch: then not
/// even its order of magnitude is known. [Efron, Tibshirani 1993, ch. 11]
template <Spectrum S>
[[nodiscard]] std::optional<Interval> estimate_error(const BatchMeans<S>& means, std::uint64_t iterations,
                                                     double confidence = 0.95) {
  const std::size_t batches = means.batch_count();
  const std::size_t values = means.value_count();
  if (batches < 4 || values == 0 || iterations == 0) return {};
  const double count = static_cast<double>(batches);

  // Sums over pixels of (sample variance of a batch mean) / (mean² + 0.01): with all batches, and without each one. In
  // blocks, so that every inner loop runs along an image.
  double with_all = 0.0;
  std::vector<double> without(batches, 0.0);
  constexpr std::size_t block = 512;
  std::array<double, block> mean, squares;
  for (std::size_t begin = 0; begin < values; begin += block) {
    const std::size_t size = std::min(block, values - begin);
    mean.fill(0.0);
    squares.fill(0.0);
    for (std::size_t b = 0; b < batches; ++b) {
      const std::span<const float> image = means.batch(b).subspan(begin, size);
      for (std::size_t i = 0; i < size; ++i) mean[i] += static_cast<double>(image[i]) / count;
    }
    for (std::size_t b = 0; b < batches; ++b) {
      const std::span<const float> image = means.batch(b).subspan(begin, size);
      for (std::size_t i = 0; i < size; ++i) {
        const double deviation = static_cast<double>(image[i]) - mean[i];
        squares[i] += deviation * deviation;
      }
    }
    for (std::size_t i = 0; i < size; ++i) with_all += squares[i] / (count - 1.0) / (mean[i] * mean[i] + 0.01);
    for (std::size_t b = 0; b < batches; ++b) {
      const std::span<const float> image = means.batch(b).subspan(begin, size);
      double sum = 0.0;
      for (std::size_t i = 0; i < size; ++i) {
        const double deviation = static_cast<double>(image[i]) - mean[i];
        const double rest = std::max(0.0, squares[i] - deviation * deviation * (count / (count - 1.0)));
        const double mean_of_rest = mean[i] - deviation * (1.0 / (count - 1.0));
        sum += rest / (mean_of_rest * mean_of_rest + 0.01);
      }
      without[b] += sum / (count - 2.0);
    }
  }
  const double smallest = *std::min_element(without.begin(), without.end());
  constexpr double rounding = 1e-12;
  if (!(smallest > rounding * with_all) || !std::isfinite(with_all)) return {};

  double mean_log = 0.0, spread = 0.0;
  for (const double sum : without) mean_log += std::log(sum) / count;
  for (const double sum : without) spread += (std::log(sum) - mean_log) * (std::log(sum) - mean_log);
  const double standard_error = std::sqrt(spread * (count - 1.0) / count);
  const double centre = count * std::log(with_all) - (count - 1.0) * mean_log;

  // From the variance of one batch mean to that of the mean of all iterations, and from squares to the root.
  const double scale =
      static_cast<double>(means.iterations_per_batch()) / static_cast<double>(iterations) / static_cast<double>(values);
  const double reach = student_t_quantile(0.5 + confidence / 2.0, count - 1.0) * standard_error;
  const auto error_at = [&](double log_sum) { return std::sqrt(scale * std::exp(log_sum)); };
  return Interval{error_at(centre), error_at(centre - reach), error_at(centre + reach)};
}

}  // namespace gmis
