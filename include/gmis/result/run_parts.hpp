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
/// What `estimate_error` is made of.

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

/// The mean around a pixel without one part of the run, by a tent, cut at the borders of the image: the smallest one, from 3
/// to 33 pixels wide, whose square holds `enough_light` times what the part adds to the pixel. In less light than that it
/// is chance whether samples of the same kind have been met around; further away the picture is another one.
template <Spectrum S>
[[nodiscard]] double neighbourhood_without(const RunParts<S>& parts, std::span<const double> mean,
                                           glm::ivec2 resolution, std::size_t index, std::size_t part) {
  constexpr double enough_light = 2.5;
  constexpr int channels = BatchMeans<S>::channel_count, farthest = 16;
  const int pixel = static_cast<int>(index / channels), x = pixel % resolution.x, y = pixel / resolution.x;
  const double share = parts.share(part), added = share * parts.value(part, index);
  for (int reach = 1;; reach *= 2) {
    double light = 0.0, sum = 0.0, weights = 0.0;
    for (int v = std::max(0, y - reach); v <= std::min(resolution.y - 1, y + reach); ++v)
      for (int u = std::max(0, x - reach); u <= std::min(resolution.x - 1, x + reach); ++u) {
        const std::size_t there =
            (static_cast<std::size_t>(v) * static_cast<std::size_t>(resolution.x) + static_cast<std::size_t>(u)) *
                channels +
            index % channels;
        const double weight = (reach + 1 - std::abs(u - x)) * (reach + 1 - std::abs(v - y));
        const double value = (mean[there] - share * parts.value(part, there)) / (1.0 - share);
        light += value;
        sum += weight * value;
        weights += weight;
      }
    if (light >= enough_light * added || reach == farthest) return sum / weights;
  }
}

}  // namespace detail

}  // namespace gmis
