#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/vec2.hpp>
#include <limits>
#include <span>

#include "gmis/core/math.hpp"
#include "gmis/result/batch_means.hpp"

/// \file
/// The parts of a run, and how they lie about their mean.

namespace gmis {

namespace detail {

/// The parts of a run, complete batches and the unfinished one, with the share of each in all
/// iterations.
template <Spectrum S>
class RunParts {
 public:
  static constexpr std::size_t most = BatchMeans<S>::capacity + 1;

  explicit RunParts(const BatchMeans<S>& means) : means_(means), count_(means.batch_count()) {
    const double iterations = static_cast<double>(means.iterations());
    for (std::size_t b = 0; b < count_; ++b) shares_[b] = static_cast<double>(means.iterations_of(b)) / iterations;
    if (means.unfinished_iterations() > 0)
      shares_[count_++] = static_cast<double>(means.unfinished_iterations()) / iterations;
  }

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  /// Number of the first parts whose lengths differ by one iteration at most.
  [[nodiscard]] std::size_t equal_count() const noexcept {
    return means_.has_equal_batches() ? means_.batch_count() : 0;
  }
  [[nodiscard]] glm::ivec2 resolution() const noexcept { return means_.resolution(); }
  [[nodiscard]] double share(std::size_t part) const noexcept { return shares_[part]; }
  /// w / (1 − w) for the share w of a part.
  [[nodiscard]] double ratio(std::size_t part) const noexcept { return shares_[part] / (1.0 - shares_[part]); }
  /// The mean of the other parts, from m, the mean of all, and x − m of this part.
  [[nodiscard]] double mean_of_others(std::size_t part, double mean, double deviation) const noexcept {
    return mean - ratio(part) * deviation;
  }
  /// w² (x − m)² / (1 − w): the sum over the parts is the unbiased estimate of the variance of m.
  [[nodiscard]] double variance_by(std::size_t part, double deviation) const noexcept {
    return shares_[part] * ratio(part) * deviation * deviation;
  }
  [[nodiscard]] double value(std::size_t part, std::size_t index) const noexcept {
    return part < means_.batch_count() ? means_.value(part, index) : means_.unfinished()[index];
  }
  /// Calls `use(values)` once with all values of a part, a span of float or of double.
  template <class Use>
  void with_values(std::size_t part, Use&& use) const {
    if (part >= means_.batch_count())
      use(means_.unfinished());
    else
      means_.with_values(part, use);
  }

 private:
  const BatchMeans<S>& means_;
  std::size_t count_;
  std::array<double, most> shares_{};
};

/// The statistics of a few values over the parts of a run, each value a channel of a pixel. They
/// are computed side by side, because every value of a picture needs them. Below, w_b is the share
/// of part b, x_b its value there, and m the mean of all.
template <Spectrum S>
class PartsOfValues {
 public:
  static constexpr std::size_t lanes = 32;
  static constexpr std::size_t most = RunParts<S>::most;
  using Numbers = std::array<double, lanes>;
  using Indices = std::array<std::size_t, lanes>;

  /// `mean`: m of every value of the picture.
  PartsOfValues(const RunParts<S>& parts, std::span<const double> mean, const Indices& indices) : parts_(parts) {
    for (std::size_t l = 0; l < lanes; ++l) mean_[l] = mean[indices[l]];
    for (std::size_t b = 0; b < parts.count(); ++b) {
      const double share = parts.share(b);
      Numbers& deviation = deviations_[b];
      parts.with_values(b, [&](const auto values) {
        for (std::size_t l = 0; l < lanes; ++l) deviation[l] = static_cast<double>(values[indices[l]]);
      });
      for (std::size_t l = 0; l < lanes; ++l) {
        deviation[l] -= mean_[l];
        total_[l] += share * deviation[l] * deviation[l];
      }
    }
    find_spreads();
    constexpr double standard_deviations = 5.0;
    for (std::size_t b = 0; b < parts.count(); ++b)
      for (std::size_t l = 0; l < lanes; ++l) {
        beyond_[b][l] =
            parts.ratio(b) * deviations_[b][l] * deviations_[b][l] - square(standard_deviations) * spreads_[b][l];
        farthest_beyond_[l] = std::max(farthest_beyond_[l], beyond_[b][l]);
      }
  }

  /// False where the parts differ by rounding alone.
  [[nodiscard]] bool varies(std::size_t lane) const noexcept {
    constexpr double rounding = 1e-14;  // batches are stored as float
    return total_[lane] > rounding * mean_[lane] * mean_[lane];
  }
  /// m.
  [[nodiscard]] const Numbers& mean() const noexcept { return mean_; }
  /// x_b − m.
  [[nodiscard]] const Numbers& deviation(std::size_t b) const noexcept { return deviations_[b]; }
  /// The variance of m as the other parts tell it without the one of them that is farthest off: two
  /// bright samples must not hide each other. 0 for fewer than four parts.
  [[nodiscard]] const Numbers& variance_by_others(std::size_t b) const noexcept { return spreads_[b]; }
  /// True where part b lies more than five standard deviations off what the others let expect, or
  /// some part does.
  [[nodiscard]] bool is_rare(std::size_t b, std::size_t lane) const noexcept { return beyond_[b][lane] > 0.0; }
  [[nodiscard]] bool has_rare(std::size_t lane) const noexcept { return farthest_beyond_[lane] > 0.0; }

 private:
  void find_spreads() {
    const std::size_t count = parts_.count(), equal = parts_.equal_count();
    if (count < 4) {
      for (std::size_t b = 0; b < count; ++b) spreads_[b].fill(0.0);
      return;
    }
    // The two smallest and the two largest deviations of parts of equal length; the others are
    // looked at one by one.
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Numbers low, next_low, high, next_high;
    low.fill(infinity), next_low.fill(infinity), high.fill(-infinity), next_high.fill(-infinity);
    for (std::size_t b = 0; b < equal; ++b)
      for (std::size_t l = 0; l < lanes; ++l) {
        const double deviation = deviations_[b][l];
        next_low[l] = std::min(next_low[l], std::max(low[l], deviation));
        low[l] = std::min(low[l], deviation);
        next_high[l] = std::max(next_high[l], std::min(high[l], deviation));
        high[l] = std::max(high[l], deviation);
      }
    Numbers nobody;
    nobody.fill(std::numeric_limits<double>::quiet_NaN());
    const double per_degree_of_freedom = 1.0 / static_cast<double>(count - 3);
    for (std::size_t b = 0; b < count; ++b) {
      const double ratio = parts_.ratio(b), share = parts_.share(0);
      const Numbers &deviation = deviations_[b], &left_out = b < equal ? deviation : nobody;
      Numbers& spread = spreads_[b];  // first that of the farthest of the others
      spread.fill(0.0);
      if (equal > 1)
        for (std::size_t l = 0; l < lanes; ++l) {
          const double lowest = left_out[l] == low[l] ? next_low[l] : low[l];
          const double highest = left_out[l] == high[l] ? next_high[l] : high[l];
          const double off =
              std::max(std::abs(lowest + ratio * deviation[l]), std::abs(highest + ratio * deviation[l]));
          spread[l] = share * off * off;
        }
      for (std::size_t c = equal; c < count; ++c) {
        if (c == b) continue;
        for (std::size_t l = 0; l < lanes; ++l) {
          const double off = deviations_[c][l] + ratio * deviation[l];
          spread[l] = std::max(spread[l], parts_.share(c) * off * off);
        }
      }
      for (std::size_t l = 0; l < lanes; ++l) {
        const double own = ratio * deviation[l] * deviation[l];
        spread[l] = std::max(0.0, (total_[l] - own - spread[l]) * per_degree_of_freedom);
      }
    }
  }

  const RunParts<S>& parts_;
  Numbers mean_{}, total_{}, farthest_beyond_{};
  std::array<Numbers, most> deviations_, spreads_, beyond_;  // of the parts that there are
};

}  // namespace detail

}  // namespace gmis
