#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <glm/vec2.hpp>
#include <limits>
#include <span>
#include <utility>

#include "gmis/result/batch_means.hpp"

/// \file
/// The parts of a run, and how they lie about their mean.

namespace gmis {

namespace detail {

/// The parts of a run, complete batches and the unfinished one, with the share of each in all iterations.
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
  /// Parts whose lengths differ by one iteration at most: the first so many.
  [[nodiscard]] std::size_t equal_count() const noexcept {
    return means_.has_equal_batches() ? means_.batch_count() : 0;
  }
  [[nodiscard]] glm::ivec2 resolution() const noexcept { return means_.resolution(); }
  [[nodiscard]] std::size_t value_count() const noexcept { return means_.value_count(); }
  [[nodiscard]] double share(std::size_t part) const noexcept { return shares_[part]; }
  [[nodiscard]] double value(std::size_t part, std::size_t index) const noexcept {
    return part < means_.batch_count() ? means_.value(part, index) : means_.unfinished()[index];
  }

 private:
  const BatchMeans<S>& means_;
  std::size_t count_;
  std::array<double, most> shares_{};
};

/// The two smallest and the two largest of some numbers.
class Extremes {
 public:
  explicit Extremes(std::span<const double> numbers) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      insert({numbers[i], i}, low_, [](double a, double b) { return a < b; });
      insert({numbers[i], i}, high_, [](double a, double b) { return a > b; });
    }
  }

  /// How far from a point the one farthest off is, the one at index `left_out` not counted; 0 when there is none.
  [[nodiscard]] double farthest_from(double point, std::size_t left_out) const noexcept {
    const Entry& low = low_[low_[0].index == left_out ? 1 : 0];
    const Entry& high = high_[high_[0].index == left_out ? 1 : 0];
    if (low.index == none) return 0.0;
    return std::max(std::abs(low.number - point), std::abs(high.number - point));
  }

 private:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  struct Entry {
    double number = 0.0;
    std::size_t index = none;
  };

  static void insert(Entry entry, std::array<Entry, 2>& best, auto is_better) {
    if (best[0].index == none || is_better(entry.number, best[0].number)) std::swap(entry, best[0]);
    if (entry.index != none && (best[1].index == none || is_better(entry.number, best[1].number))) best[1] = entry;
  }

  std::array<Entry, 2> low_{}, high_{};
};

/// What the parts of a run say of one value: of a channel of a pixel. With w_b the share of part b, x_b its value there and m
/// the mean of all.
template <Spectrum S>
class PartsOfValue {
 public:
  static constexpr std::size_t most = RunParts<S>::most;

  PartsOfValue(const RunParts<S>& parts, std::size_t index, double mean) : parts_(parts), mean_(mean) {
    for (std::size_t b = 0; b < parts.count(); ++b) {
      deviations_[b] = parts.value(b, index) - mean;
      total_ += parts.share(b) * deviations_[b] * deviations_[b];
    }
    extremes_ = Extremes(std::span<const double>(deviations_).first(parts.equal_count()));
  }

  /// False where the parts differ by rounding alone.
  [[nodiscard]] bool varies() const noexcept {
    constexpr double rounding = 1e-14;  // batches are stored as float
    return total_ > rounding * mean_ * mean_;
  }
  /// x_b − m.
  [[nodiscard]] double deviation(std::size_t b) const noexcept { return deviations_[b]; }
  /// The mean of the other parts.
  [[nodiscard]] double others(std::size_t b) const noexcept { return mean_ - ratio(b) * deviations_[b]; }
  /// w_b² (x_b − m)² / (1 − w_b): the sum over b is the unbiased estimate of the variance of m.
  [[nodiscard]] double variance_by(std::size_t b) const noexcept { return parts_.share(b) * own(b); }
  /// The variance of m as the other parts tell it without the one of them that is farthest off: two bright samples must not
  /// hide each other. 0 for fewer than four parts.
  [[nodiscard]] double variance_by_others(std::size_t b) const noexcept {
    const std::size_t count = parts_.count(), equal = parts_.equal_count();
    if (count < 4) return 0.0;
    const double to_others = ratio(b) * deviations_[b];
    const double off = extremes_.farthest_from(-to_others, b);
    double farthest = parts_.share(0) * off * off;
    for (std::size_t c = equal; c < count; ++c) {
      const double there = deviations_[c] + to_others;
      if (c != b) farthest = std::max(farthest, parts_.share(c) * there * there);
    }
    return std::max(0.0, (total_ - own(b) - farthest) / static_cast<double>(count - 3));
  }
  /// True where part b lies more than five standard deviations off what the others let expect.
  [[nodiscard]] bool is_rare(std::size_t b) const noexcept {
    constexpr double standard_deviations = 5.0;
    return own(b) > standard_deviations * standard_deviations * variance_by_others(b);
  }

 private:
  [[nodiscard]] double ratio(std::size_t b) const noexcept { return parts_.share(b) / (1.0 - parts_.share(b)); }
  /// w_b (x_b − m)² / (1 − w_b), whose mean is the variance of m.
  [[nodiscard]] double own(std::size_t b) const noexcept { return ratio(b) * deviations_[b] * deviations_[b]; }

  const RunParts<S>& parts_;
  double mean_, total_ = 0.0;
  std::array<double, most> deviations_{};
  Extremes extremes_{std::span<const double>{}};
};

}  // namespace detail

}  // namespace gmis
