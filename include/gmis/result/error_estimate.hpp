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
#include "gmis/result/image_error.hpp"
#include "gmis/result/rare_samples.hpp"
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

/// The mean of `variances_of_means` over pixels and channels. Not a number before two parts.
template <Spectrum S>
[[nodiscard]] double variance_of_mean(const BatchMeans<S>& means) {
  const std::vector<double> variances = variances_of_means(means);
  if (variances.empty()) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (const double variance : variances) sum += variance;
  return sum / static_cast<double>(variances.size());
}

namespace detail {

/// The sums over the values of a picture that estimate its error.
template <Spectrum S>
class ErrorSums {
 public:
  using Parts = PartsOfValues<S>;
  using Numbers = typename Parts::Numbers;
  static constexpr std::size_t lanes = Parts::lanes;

  /// Adds the values of the lanes for which `counts` is true; returns the squared relative error of
  /// each. `rare`, by part and lane: 1 / (v² + `relative_error_floor`) for a rare sample, v the
  /// value that it is compared with, else 0; null where none is rare.
  Numbers add(const RunParts<S>& parts, const Parts& here, const std::array<bool, lanes>& counts,
              const std::array<Numbers, Parts::most>* rare) {
    const std::size_t count = parts.count();
    std::array<Numbers, Parts::most> scaled;
    Numbers use, squares{}, errors{}, far{};
    for (std::size_t l = 0; l < lanes; ++l) use[l] = counts[l] ? 1.0 : 0.0;
    for (std::size_t b = 0; b < count; ++b) {
      const double share = parts.share(b), of_others = 1.0 / (1.0 - share);
      const Numbers &deviation = here.deviation(b), &spread = here.variance_by_others(b);
      Numbers inverse;
      for (std::size_t l = 0; l < lanes; ++l) {
        const double others = parts.mean_of_others(b, here.mean()[l], deviation[l]);
        const double variance = parts.variance_by(b, deviation[l]);
        const double plain = 1.0 / (others * others + relative_error_floor);
        squares[l] += variance;
        far[l] += variance * plain;
        // Half the second derivative of 1 / (v² + c) over the function is (3v² − c) / (v² + c)².
        const double curvature = std::max(0.0, 3.0 * others * others - relative_error_floor) * plain * plain;
        inverse[l] = plain / (1.0 + curvature * spread[l] * of_others);
      }
      if (rare != nullptr)
        for (std::size_t l = 0; l < lanes; ++l) inverse[l] = (*rare)[b][l] > 0.0 ? (*rare)[b][l] : inverse[l];
      for (std::size_t l = 0; l < lanes; ++l) {
        errors[l] += parts.variance_by(b, deviation[l]) * inverse[l];
        scaled[b][l] = use[l] > 0.0 ? share * deviation[l] * std::sqrt(inverse[l]) : 0.0;
      }
    }
    for (std::size_t l = 0; l < lanes; ++l) {
      far_ += counts[l] ? far[l] : 0.0;
      near_ += counts[l] ? squares[l] / (here.mean()[l] * here.mean()[l] + relative_error_floor) : 0.0;
    }
    for (std::size_t b = 0; b < count; ++b)
      for (std::size_t c = 0; c < b; ++c)
        for (std::size_t first = 0; first < lanes; first += folded)
          for (std::size_t l = 0; l < folded; ++l) products_[b][c][l] += scaled[b][first + l] * scaled[c][first + l];
    return errors;
  }
  void add(const ErrorSums& other, std::size_t count) noexcept {
    near_ += other.near_;
    far_ += other.far_;
    for (std::size_t b = 0; b < count; ++b)
      for (std::size_t c = 0; c < b; ++c)
        for (std::size_t l = 0; l < folded; ++l) products_[b][c][l] += other.products_[b][c][l];
  }

  /// Relative to the mean of all parts, and to that of the others.
  [[nodiscard]] double near() const noexcept { return near_; }
  [[nodiscard]] double far() const noexcept { return far_; }
  /// Sum of the products of the deviations of two parts, c < b, each relative to the value that it
  /// is compared with.
  [[nodiscard]] double product(std::size_t b, std::size_t c) const noexcept {
    return std::accumulate(products_[b][c].begin(), products_[b][c].end(), 0.0);
  }

 private:
  static constexpr std::size_t folded = 8;  // sums side by side

  double near_ = 0.0, far_ = 0.0;
  std::array<std::array<std::array<double, folded>, Parts::most>, Parts::most> products_{};  // the lower triangle
};

}  // namespace detail

/// The error of an image from the parts of its run: the batches and what has been added since.
/// Nothing before two parts.
///
/// For every pixel and channel, with w_b the share of part b in all iterations, x_b its value, m
/// the mean of all and m_-b that of the others, Σ_b w_b² (x_b − m)² / (1 − w_b) is the unbiased
/// estimate of the variance of m. Each of its terms is divided by what the *other* parts say of the
/// value there, so that a bright, rare sample is not divided by itself: by m_-b² +
/// `relative_error_floor`, and by 1 + v (3 m_-b² − c) / (m_-b² + c)² for what the variance v of
/// m_-b adds to the mean of that inverse (second order; c is the floor). Where x_b lies five
/// standard deviations off what the others let expect, m_-b has most likely missed what such
/// samples add, and the mean around the pixel, of the other parts again, takes its place
/// (`detail::RareSamples`).
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
  using Parts = detail::RunParts<S>;
  using Values = detail::PartsOfValues<S>;
  using Indices = typename Values::Indices;
  constexpr std::size_t channels = BatchMeans<S>::channel_count, lanes = Values::lanes;
  const Parts parts(means);
  const std::size_t count = parts.count(), values = means.value_count();
  if (count < 2 || values == 0) return {};

  // Block by block, and in each a few values side by side. First those without rare samples.
  constexpr std::size_t values_of_block = 64 * lanes * channels;
  struct Block {
    detail::ErrorSums<S> sums;
    std::vector<detail::RareSample> rare;
    std::size_t first_rare = 0;  ///< where they lie among those of all blocks
  };
  std::vector<Block> blocks((values + values_of_block - 1) / values_of_block);
  std::vector<double> mean(values, 0.0), per_pixel(values / channels, 0.0);
  executor.parallel_for(blocks.size(), [&](std::size_t block) {
    const std::size_t begin = block * values_of_block, end = std::min(values, begin + values_of_block);
    for (std::size_t b = 0; b < count; ++b)
      parts.with_values(b, [&](const auto of_part) {
        for (std::size_t i = begin; i < end; ++i) mean[i] += parts.share(b) * static_cast<double>(of_part[i]);
      });
    for (std::size_t first = begin; first < end; first += lanes) {
      Indices indices;
      for (std::size_t l = 0; l < lanes; ++l) indices[l] = std::min(first + l, end - 1);
      const Values here(parts, mean, indices);
      std::array<bool, lanes> counts{};
      for (std::size_t l = 0; l < lanes && first + l < end; ++l) {
        if (!here.varies(l)) continue;
        counts[l] = !here.has_rare(l);
        for (std::size_t b = 0; b < count && !counts[l]; ++b)
          if (here.is_rare(b, l)) blocks[block].rare.push_back({first + l, b});
      }
      const auto errors = blocks[block].sums.add(parts, here, counts, nullptr);
      for (std::size_t l = 0; l < lanes; ++l)
        if (counts[l]) per_pixel[(first + l) / channels] += errors[l];
    }
  });

  // Then those with rare samples, for which the picture around them must be known.
  std::vector<detail::RareSample> found;
  for (Block& block : blocks) {
    block.first_rare = found.size();
    found.insert(found.end(), block.rare.begin(), block.rare.end());
  }
  const detail::RareSamples rare(parts, mean, std::move(found), executor);
  executor.parallel_for(blocks.size(), [&](std::size_t block) {
    const auto here = rare.samples().subspan(blocks[block].first_rare, blocks[block].rare.size());
    for (auto next = here.begin(); next != here.end();) {
      Indices indices{};
      std::array<typename Values::Numbers, Parts::most> inverse{};
      std::array<bool, lanes> counts{};
      for (std::size_t l = 0; l < lanes && next != here.end(); ++l) {
        counts[l] = true;
        indices[l] = next->index;
        for (; next != here.end() && next->index == indices[l]; ++next)
          inverse[next->part][l] = 1.0 / (square(rare.value_at(*next)) + relative_error_floor);
      }
      const auto errors = blocks[block].sums.add(parts, Values(parts, mean, indices), counts, &inverse);
      for (std::size_t l = 0; l < lanes; ++l)
        if (counts[l]) per_pixel[indices[l] / channels] += errors[l];
    }
  });
  detail::ErrorSums<S> sums;
  for (const Block& block : blocks) sums.add(block.sums, count);
  const double near = sums.near(), far = sums.far();

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
/// The same on one thread.
template <Spectrum S>
[[nodiscard]] std::optional<ErrorEstimate> estimate_error(const BatchMeans<S>& means, double confidence = 0.95,
                                                          const ErrorCalibration& calibration = {}) {
  SerialExecutor executor;
  return estimate_error(means, ExecutorRef(executor), confidence, calibration);
}

}  // namespace gmis
