#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/result/batch_means.hpp"
#include "gmis/result/image_error.hpp"

namespace gmis {

/// A figure and the interval that covers its true value with the stated confidence.
struct Interval {
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
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
  std::size_t pixel = 0;
  double share = 0.0;
};

/// The relative error of an image, as its own iterations tell it.
struct ErrorEstimate {
  static constexpr std::size_t worst_count = 5;

  double relative_error = 0.0;          ///< estimates √relMSE of this very image against a perfect reference
  double relative_error_trimmed = 0.0;  ///< the same without `trimmed_pixels`
  Interval interval;                    ///< around `relative_error`; not to be shown unless the estimate is calibrated
  ErrorDoubt doubt = ErrorDoubt::few_batches;
  std::array<PixelShare, worst_count> worst{};  ///< the pixels that make most of the error, the worst first

  [[nodiscard]] constexpr bool is_calibrated() const noexcept { return doubt == ErrorDoubt::none; }
  [[nodiscard]] constexpr double share_of_worst() const noexcept {
    double share = 0.0;
    for (const PixelShare& one : worst) share += one.share;
    return share;
  }
};

/// When an interval may be shown; chosen by calibration (docs/accuracy-and-time.md).
struct ErrorCalibration {
  std::size_t fewest_batches = 8;
  /// Of the squared error relative to other batches over that relative to all batches: where rare samples are both the
  /// error and the value that it is relative to, the two differ.
  double largest_disagreement = 1.15;
  double largest_deviation = 0.35;      ///< standard deviation of the squared error, relative
  double largest_share_of_worst = 0.2;  ///< of `ErrorEstimate::worst` in the squared error
};

namespace detail {

/// The parts of a run, complete batches and the unfinished one, with the share of each in all iterations.
template <Spectrum S>
class RunParts {
 public:
  static constexpr std::size_t most = BatchMeans<S>::capacity + 1;

  explicit RunParts(const BatchMeans<S>& means) : means_(means), count_(means.batch_count()) {
    const double iterations = static_cast<double>(means.iterations());
    for (std::size_t b = 0; b < count_; ++b)
      shares_[b] = static_cast<double>(means.iterations_per_batch()) / iterations;
    if (means.unfinished_iterations() > 0)
      shares_[count_++] = static_cast<double>(means.unfinished_iterations()) / iterations;
  }

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] double share(std::size_t part) const noexcept { return shares_[part]; }
  [[nodiscard]] double value(std::size_t part, std::size_t index) const noexcept {
    return part < means_.batch_count() ? static_cast<double>(means_.batch(part)[index]) : means_.unfinished()[index];
  }

 private:
  const BatchMeans<S>& means_;
  std::size_t count_;
  std::array<double, most> shares_{};
};

/// The mean around a pixel without one part of the run, by a tent five pixels wide, cut at the borders of the image.
template <Spectrum S>
[[nodiscard]] double neighbourhood_without(const RunParts<S>& parts, std::span<const double> mean,
                                           glm::ivec2 resolution, std::size_t index, std::size_t part) {
  constexpr int channels = BatchMeans<S>::channel_count, reach = 2;
  const int pixel = static_cast<int>(index / channels), x = pixel % resolution.x, y = pixel / resolution.x;
  double sum = 0.0, weights = 0.0;
  for (int v = std::max(0, y - reach); v <= std::min(resolution.y - 1, y + reach); ++v)
    for (int u = std::max(0, x - reach); u <= std::min(resolution.x - 1, x + reach); ++u) {
      const std::size_t there =
          (static_cast<std::size_t>(v) * static_cast<std::size_t>(resolution.x) + static_cast<std::size_t>(u)) *
              channels +
          index % channels;
      const double weight = (reach + 1 - std::abs(u - x)) * (reach + 1 - std::abs(v - y));
      sum += weight * (mean[there] - parts.share(part) * parts.value(part, there)) / (1.0 - parts.share(part));
      weights += weight;
    }
  return sum / weights;
}

}  // namespace detail

/// The error of an image from the parts of its run: the batches and what has been added since. Nothing before two parts.
///
/// For every pixel and channel, with w_b the share of part b in all iterations, x_b its value, m the mean of all and
/// m_-b that of the others, Σ_b w_b² (x_b − m)² / (1 − w_b) is the unbiased estimate of the variance of m. Each of its terms is
/// divided by what the *other* parts say of the value there, so that a bright, rare sample is not divided by itself:
/// by m_-b² + `relative_error_floor`, but where x_b lies five standard deviations off what the others let expect, m_-b has most
/// likely missed what such samples add, and the mean around the pixel, of the other parts again, takes its place.
///
/// The interval is of this image's own squared error. With e_b the true deviations, that error is Σ_bc w_b w_c e_b e_c and
/// its estimate lacks the products b ≠ c; they have the mean 0 and a variance that the products of different parts, summed
/// over the image, show. *The bias of merging is not part of any of this* (see `merging_bias`), nor is what no iteration has met.
template <Spectrum S>
[[nodiscard]] std::optional<ErrorEstimate> estimate_error(const BatchMeans<S>& means, double confidence = 0.95,
                                                          const ErrorCalibration& calibration = {}) {
  using Parts = detail::RunParts<S>;
  constexpr std::size_t channels = BatchMeans<S>::channel_count;
  const Parts parts(means);
  const std::size_t count = parts.count(), values = means.value_count();
  if (count < 2 || values == 0) return {};

  std::vector<double> mean(values, 0.0);
  for (std::size_t b = 0; b < count; ++b)
    for (std::size_t i = 0; i < values; ++i) mean[i] += parts.share(b) * parts.value(b, i);

  std::vector<double> per_pixel(values / channels, 0.0);
  std::array<std::array<double, Parts::most>, Parts::most> products{};  // of parts, over the image: the lower triangle
  double near = 0.0, far = 0.0;  // relative to the mean of all parts, and to that of the others
  for (std::size_t i = 0; i < values; ++i) {
    std::array<double, Parts::most> scaled{};
    double total = 0.0;
    for (std::size_t b = 0; b < count; ++b) {
      const double deviation = parts.value(b, i) - mean[i];
      total += parts.share(b) * deviation * deviation;
    }
    constexpr double rounding = 1e-14;  // batches are stored as float
    if (!(total > rounding * mean[i] * mean[i])) continue;
    for (std::size_t b = 0; b < count; ++b) {
      const double share = parts.share(b), deviation = parts.value(b, i) - mean[i];
      const double square = share * share * deviation * deviation / (1.0 - share);
      double value = mean[i] - share * deviation / (1.0 - share);
      near += square / (mean[i] * mean[i] + relative_error_floor);
      far += square / (value * value + relative_error_floor);
      // The spread of the others without the one of them that is farthest off: two bright samples must not hide each other.
      double spread = 0.0, farthest = 0.0;
      for (std::size_t c = 0; c < count; ++c) {
        if (c == b) continue;
        const double other = parts.value(c, i) - value;
        spread += parts.share(c) * other * other;
        farthest = std::max(farthest, parts.share(c) * other * other);
      }
      constexpr double standard_deviations = 5.0;
      const double expected = count > 3 ? (spread - farthest) / static_cast<double>(count - 3) : 0.0;
      if (share / (1.0 - share) * deviation * deviation > standard_deviations * standard_deviations * expected)
        value = detail::neighbourhood_without(parts, std::span<const double>(mean), means.resolution(), i, b);
      scaled[b] = share * deviation / std::sqrt(value * value + relative_error_floor);
      per_pixel[i / channels] += scaled[b] * scaled[b] / (1.0 - share);
    }
    for (std::size_t b = 0; b < count; ++b)
      for (std::size_t c = 0; c < b; ++c) products[b][c] += scaled[b] * scaled[c];
  }

  ErrorEstimate estimate;
  const double sum = std::accumulate(per_pixel.begin(), per_pixel.end(), 0.0);
  estimate.relative_error = std::sqrt(sum / static_cast<double>(values));
  estimate.interval = {estimate.relative_error, 0.0, std::numeric_limits<double>::infinity()};
  if (!(sum > 0.0)) {
    estimate.doubt = ErrorDoubt::nothing_found;
    return estimate;
  }
  std::vector<std::size_t> order(per_pixel.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::size_t shown = std::min(ErrorEstimate::worst_count, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(shown), order.end(),
                    [&](std::size_t a, std::size_t b) { return per_pixel[a] > per_pixel[b]; });
  for (std::size_t k = 0; k < shown; ++k) estimate.worst[k] = {order[k], per_pixel[order[k]] / sum};
  estimate.relative_error_trimmed = std::sqrt(trimmed_mean(per_pixel, channels));
  if (count < std::max<std::size_t>(4, calibration.fewest_batches)) return estimate;

  // The mean of a product is −w_b w_c times the squared error; what it is off is chance. The deviations from a common mean
  // leave B (B − 3) / 2 of the B (B − 1) / 2 products free.
  const double parts_count = static_cast<double>(count);
  double chance = 0.0;
  for (std::size_t b = 0; b < count; ++b)
    for (std::size_t c = 0; c < b; ++c) {
      const double off = products[b][c] + parts.share(b) * parts.share(c) * sum;
      chance += off * off;
    }
  const double deviation = 2.0 * std::sqrt(chance / ((parts_count - 1.0) * (parts_count - 3.0))) * parts_count / sum;
  const double disagreement = std::max({1.0, far / sum, sum / near, far / near});
  estimate.doubt =
      disagreement > calibration.largest_disagreement ? ErrorDoubt::rare_events
      : deviation > calibration.largest_deviation || estimate.share_of_worst() > calibration.largest_share_of_worst
          ? ErrorDoubt::few_pixels
          : ErrorDoubt::none;
  // From the squared error to its root, as a factor.
  const double t = student_t_quantile(0.5 + confidence / 2.0, parts_count - 1.0);
  const double reach = std::exp((t * deviation + std::log(std::max({1.0, far / sum, sum / near}))) / 2.0);
  estimate.interval.lower = estimate.relative_error / reach;
  estimate.interval.upper = estimate.relative_error * reach;
  return estimate;
}

}  // namespace gmis
