#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/executor_ref.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/result/batch_means.hpp"
#include "gmis/result/error_of_rows.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/result/run_parts.hpp"

namespace gmis {

/// A figure and the interval that covers its true value with the stated confidence.
struct Interval {
  double value = 0.0;  ///< the estimate
  double lower = 0.0;  ///< lower end
  double upper = 0.0;  ///< upper end
};

/// Why no interval stands around an estimated error.
enum class ErrorDoubt {
  none,
  nothing_found,  ///< no value differs between iterations: nothing has been found yet
  few_batches,    ///< fewer than 8
  rare_events,    ///< what the error is relative to depends on a few rare, bright samples
  few_pixels,     ///< a few pixels make much of the error: how many more there are is not known
};

[[nodiscard]] constexpr const char* name_of(ErrorDoubt doubt) noexcept {
  constexpr const char* names[] = {"none", "nothing_found", "few_batches", "rare_events", "few_pixels"};
  return names[static_cast<int>(doubt)];
}

/// A pixel and its share of the squared relative error of the image.
struct PixelShare {
  std::size_t pixel = 0;  ///< its number, by rows from the top
  double share = 0.0;     ///< of the squared relative error of the image
};

/// The relative error of an image, as its own iterations tell it.
struct ErrorEstimate {
  /// How many pixels are named.
  static constexpr std::size_t worst_count = 5;

  double relative_error = 0.0;          ///< estimates √relMSE of this very image against a perfect reference
  double relative_error_trimmed = 0.0;  ///< the same without `trimmed_pixels`
  Interval interval;                    ///< around `relative_error`; not to be shown unless the estimate is calibrated
  ErrorDoubt doubt = ErrorDoubt::few_batches;   ///< why no interval can be trusted, or `none`
  std::array<PixelShare, worst_count> worst{};  ///< the pixels that make most of the error, the worst first

  /// True when an interval can be trusted.
  [[nodiscard]] constexpr bool is_calibrated() const noexcept { return doubt == ErrorDoubt::none; }
  /// Share of the named pixels in the squared error.
  [[nodiscard]] constexpr double share_of_worst() const noexcept {
    double share = 0.0;
    for (const PixelShare& one : worst) share += one.share;
    return share;
  }
};

/// When an interval may be shown; chosen by calibration (docs/accuracy-and-time.md).
struct ErrorCalibration {
  std::size_t fewest_batches = 8;  ///< below it there is no interval
  /// Largest quotient of the squared error relative to the other batches and that relative to all
  /// batches: the two differ where rare samples make both the error and the value that it is
  /// relative to.
  double largest_disagreement = 1.15;
  double largest_deviation = 0.35;      ///< standard deviation of the squared error, relative
  double largest_share_of_worst = 0.2;  ///< of `ErrorEstimate::worst` in the squared error
};

/// The estimated variance of the mean of all iterations, for every pixel and channel, from the
/// parts of the run: Σ_b w_b² (x_b − m)² / (1 − w_b), w_b the share of part b. Empty before two
/// parts.
template <Spectrum S>
GMIS_RARE [[nodiscard]] std::vector<double> variances_of_means(const BatchMeans<S>& means) {
  const detail::RunParts<S> parts(means);
  std::vector<double> variances;
  if (parts.count() < 2) return variances;
  for (std::size_t i = 0; i < means.value_count(); ++i) {
    double mean = 0.0, sum = 0.0;
    for (std::size_t b = 0; b < parts.count(); ++b) mean += parts.share(b) * parts.value(b, i);
    for (std::size_t b = 0; b < parts.count(); ++b) {
      const double share = parts.share(b), deviation = parts.value(b, i) - mean;
      sum += share * share * deviation * deviation / (1.0 - share);
    }
    variances.push_back(sum);
  }
  return variances;
}

/// The error of an image from the sums of all its rows, which several processes may have looked at.
template <Spectrum S>
GMIS_RARE [[nodiscard]] std::optional<ErrorEstimate> estimate_error(detail::ErrorOfRows<S>& rows,
                                                                    double confidence = 0.95,
                                                                    const ErrorCalibration& calibration = {}) {
  constexpr std::size_t channels = BatchMeans<S>::channel_count;
  const detail::RunParts<S>& parts = rows.parts();
  std::vector<double> per_pixel = rows.take_per_pixel();
  const std::size_t count = parts.count(), values = per_pixel.size() * channels;
  if (count < 2 || values == 0) return {};
  const auto sums = rows.sums();
  const double near = sums.near, far = sums.far;

  ErrorEstimate estimate;
  const double sum = std::accumulate(per_pixel.begin(), per_pixel.end(), 0.0);
  estimate.relative_error = std::sqrt(sum / static_cast<double>(values));
  estimate.interval = {estimate.relative_error, 0.0, std::numeric_limits<double>::infinity()};
  if (!(sum > 0.0)) {
    estimate.doubt = ErrorDoubt::nothing_found;
    return estimate;
  }
  for (std::size_t pixel = 0; pixel < per_pixel.size(); ++pixel) {
    if (!(per_pixel[pixel] > estimate.worst.back().share)) continue;
    estimate.worst.back() = {pixel, per_pixel[pixel]};
    for (std::size_t k = estimate.worst.size() - 1; k > 0 && estimate.worst[k].share > estimate.worst[k - 1].share; --k)
      std::swap(estimate.worst[k], estimate.worst[k - 1]);
  }
  for (PixelShare& one : estimate.worst) one.share /= sum;
  estimate.relative_error_trimmed = std::sqrt(trimmed_mean(per_pixel, channels));
  if (count < std::max<std::size_t>(4, calibration.fewest_batches)) return estimate;

  // The mean of a product is −w_b w_c times the squared error; what it is off is chance. The
  // deviations from a common mean leave B (B − 3) / 2 of the B (B − 1) / 2 products free.
  const double parts_count = static_cast<double>(count);
  double chance = 0.0;
  for (std::size_t b = 0; b < count; ++b)
    for (std::size_t c = 0; c < b; ++c) {
      const double off = sums.product(b, c) + parts.share(b) * parts.share(c) * sum;
      chance += off * off;
    }
  const double deviation = 2.0 * std::sqrt(chance / ((parts_count - 1.0) * (parts_count - 3.0))) * parts_count / sum;
  const double disagreement = std::max({1.0, far / sum, sum / near, far / near});
  // In a picture of few pixels the worst of them hold much of any error.
  const double usual_share = 2.0 * ErrorEstimate::worst_count / static_cast<double>(per_pixel.size());
  estimate.doubt = disagreement > calibration.largest_disagreement ? ErrorDoubt::rare_events
                   : deviation > calibration.largest_deviation ||
                           estimate.share_of_worst() > std::max(calibration.largest_share_of_worst, usual_share)
                       ? ErrorDoubt::few_pixels
                       : ErrorDoubt::none;
  // From the squared error to its root, as a factor.
  const double t = student_t_quantile(0.5 + confidence / 2.0, parts_count - 1.0);
  const double reach = std::exp((t * deviation + std::log(std::max({1.0, far / sum, sum / near}))) / 2.0);
  estimate.interval.lower = estimate.relative_error / reach;
  estimate.interval.upper = estimate.relative_error * reach;
  return estimate;
}

/// The error of an image from the parts of its run: the batches and what has been added since.
/// Nothing before two parts.
///
/// For every pixel and channel let w_b be the share of part b in all iterations, x_b its value, m
/// the mean of all and m_-b that of the others. The unbiased estimate of the variance of m is
///
///     Σ_b w_b² (x_b − m)² / (1 − w_b).
///
/// Each of its terms is divided by what the *other* parts say of the value there, so that a bright,
/// rare sample is not divided by itself: by m_-b² + c, where c is `relative_error_floor`, and by
///
///     1 + v (3 m_-b² − c) / (m_-b² + c)²
///
/// for what the variance v of m_-b adds to the mean of that inverse (to second order). Where x_b
/// lies five standard deviations off what the others let expect, m_-b has most likely missed what
/// such samples add, and the mean around the pixel, of the other parts again, takes its place
/// (`detail::BrightnessSums`).
///
/// The interval is of this image's own squared error. With e_b the true deviations, that error is
/// Σ_bc w_b w_c e_b e_c and its estimate lacks the products b ≠ c; they have the mean 0 and a
/// variance that the products of different parts, summed over the image, show. *The bias of merging
/// is not part of any of this* (see `merging_bias`), nor is what no iteration has met. The bits do
/// not depend on the executor.
template <Spectrum S>
GMIS_RARE [[nodiscard]] std::optional<ErrorEstimate> estimate_error(const BatchMeans<S>& means, ExecutorRef executor,
                                                                    double confidence = 0.95,
                                                                    const ErrorCalibration& calibration = {}) {
  detail::ErrorOfRows<S> rows(means, executor);
  rows.add_rare(rows.brightness(), executor);
  return estimate_error(rows, confidence, calibration);
}
/// The same on one thread.
template <Spectrum S>
[[nodiscard]] std::optional<ErrorEstimate> estimate_error(const BatchMeans<S>& means, double confidence = 0.95,
                                                          const ErrorCalibration& calibration = {}) {
  SerialExecutor executor;
  return estimate_error(means, ExecutorRef(executor), confidence, calibration);
}

}  // namespace gmis
