#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <span>

#include "gmis/core/math.hpp"

namespace gmis {

/// A density on the unit square, constant on each of 16 × 16 equal bins, with the inverse of its
/// distribution. Its mean is 1.
template <std::floating_point T>
class SquareTable {
 public:
  static constexpr std::size_t side = 16;           ///< bins along one side
  static constexpr std::size_t size = side * side;  ///< bins in all

  /// A point and the density there.
  struct Sample {
    Vec2<T> point;  ///< in the unit square
    T density;      ///< per unit area
  };

  /// The uniform density.
  SquareTable() noexcept { set(std::array<double, size>{}, 1.0); }
  /// A density in proportion to `masses` (rows of bins with the same y, from y = 0), which are not
  /// negative, mixed with the uniform one: `uniform_share` in (0, 1] is its part. Masses that are
  /// all 0 give the uniform density.
  SquareTable(std::span<const double, size> masses, double uniform_share) noexcept { set(masses, uniform_share); }

  /// Masses in bins, spread by (1 2 1) along both axes: their sum is 16 times that of `masses`.
  /// Mass that would leave the square stays in the bin at the border.
  [[nodiscard]] static std::array<double, size> smoothed(std::span<const double, size> masses) noexcept {
    constexpr int bins = static_cast<int>(side);
    std::array<double, size> spread{};
    for (int y = 0; y < bins; ++y)
      for (int x = 0; x < bins; ++x)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx)
            spread[static_cast<std::size_t>(std::clamp(y + dy, 0, bins - 1) * bins +
                                            std::clamp(x + dx, 0, bins - 1))] +=
                masses[static_cast<std::size_t>(y * bins + x)] * ((dy == 0 ? 2 : 1) * (dx == 0 ? 2 : 1));
    return spread;
  }

  /// Density at a point of the unit square.
  [[nodiscard]] T density(const Vec2<T>& point) const noexcept { return bins_[bin_of(point)]; }
  /// The bin of a point of the unit square: the place in `bins`.
  [[nodiscard]] static constexpr std::size_t bin_of(const Vec2<T>& point) noexcept {
    return place(point.y) * side + place(point.x);
  }
  /// The densities of all bins.
  [[nodiscard]] const std::array<T, size>& bins() const noexcept { return bins_; }

  /// Turns a uniform point of the unit square into one with this density: a bijection, continuous
  /// within each row of bins.
  [[nodiscard]] Sample warp(const Vec2<T>& u) const noexcept {
    const Found row = find(rows_, u.y);
    const Found column = find(columns_[row.place], u.x);
    return {{column.value, row.value}, bins_[row.place * side + column.place]};
  }

 private:
  using Cumulative = std::array<T, side + 1>;
  struct Found {
    std::size_t place;
    T value;
  };

  [[nodiscard]] static constexpr std::size_t place(T x) noexcept {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(x * T(side)), 0, static_cast<int>(side) - 1));
  }
  [[nodiscard]] static Found find(const Cumulative& cumulative, T u) noexcept {
    const auto above = std::upper_bound(cumulative.begin() + 1, cumulative.end() - 1, u);
    const auto place = static_cast<std::size_t>(above - cumulative.begin()) - 1;
    const T inside = (u - cumulative[place]) / (cumulative[place + 1] - cumulative[place]);
    // Rounding must not move the point into another bin.
    const T low = T(place) / T(side), high = std::nextafter(T(place + 1) / T(side), T(0));
    return {place, std::clamp((T(place) + inside) / T(side), low, high)};
  }
  void set(std::span<const double, size> masses, double uniform_share) noexcept {
    double total = 0;
    for (const double mass : masses) total += mass;
    if (!(total > 0)) uniform_share = 1;
    std::array<double, size> densities{};
    for (std::size_t i = 0; i < size; ++i)
      densities[i] =
          uniform_share + (uniform_share < 1 ? (1 - uniform_share) * masses[i] / total * static_cast<double>(size) : 0);
    double before = 0;
    for (std::size_t row = 0; row < side; ++row) {
      double in_row = 0;
      for (std::size_t column = 0; column < side; ++column) in_row += densities[row * side + column];
      double left = 0;
      columns_[row][0] = T(0);
      for (std::size_t column = 0; column < side; ++column) {
        left += densities[row * side + column];
        columns_[row][column + 1] = static_cast<T>(left / in_row);
        bins_[row * side + column] = static_cast<T>(densities[row * side + column]);
      }
      columns_[row][side] = T(1);
      rows_[row] = static_cast<T>(before / static_cast<double>(size));
      before += in_row;
    }
    rows_[side] = T(1);
  }

  std::array<T, size> bins_;
  Cumulative rows_;
  std::array<Cumulative, side> columns_;
};

}  // namespace gmis
