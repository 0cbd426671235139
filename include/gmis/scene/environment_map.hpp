#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/compensation.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/core/warp.hpp"
#include "gmis/scene/alias_table.hpp"

namespace gmis::scene {

/// The map from the pixels of an image to directions of the sky. In the frame of the sky z is up;
/// the first row is the top of the image.
enum class SkyMapping : std::uint8_t {
  equal_area,         ///< an octahedron unfolded to a square, with z in the middle, as in pbrt-v4 [Clarberg 2008]
  latitude_longitude  ///< the column grows with the angle from x towards y, the row with the angle from z
};

/// Radiance from all directions, constant over each pixel.
struct EnvironmentImage {
  glm::ivec2 resolution{0};                     ///< in pixels
  std::vector<glm::vec3> radiance;              ///< rows from the top
  SkyMapping mapping = SkyMapping::equal_area;  ///< from directions to pixels
};

/// Equal-area map from the unit square to unit directions: a uniform point becomes a uniform
/// direction, density 1/(4π) per steradian [Clarberg 2008].
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> square_to_octahedral_sphere(const Vec2<T>& u) noexcept {
  const T x = T(2) * u.x - T(1), y = T(2) * u.y - T(1);
  const T from_diagonal = T(1) - std::abs(x) - std::abs(y);  // > 0 in the inner diamond, the upper half
  const T radius = T(1) - std::abs(from_diagonal);
  const T turn = radius > T(0) ? ((std::abs(y) - std::abs(x)) / radius + T(1)) * (pi<T> / T(4)) : T(0);
  const T sine = radius * std::sqrt(T(2) - radius * radius);
  return {std::copysign(sine * std::cos(turn), x), std::copysign(sine * std::sin(turn), y),
          std::copysign(T(1) - radius * radius, from_diagonal)};
}

/// The inverse of `square_to_octahedral_sphere`, for a unit vector. It stays accurate near the
/// poles.
template <std::floating_point T>
[[nodiscard]] inline Vec2<T> octahedral_sphere_to_square(const Vec3<T>& w) noexcept {
  const T x = std::abs(w.x), y = std::abs(w.y);
  const T radius = std::sqrt((x * x + y * y) / (T(1) + std::abs(w.z)));  // √(1 − |z|)
  const T along_y = radius * std::atan2(y, x) * (T(2) / pi<T>);
  const T along_x = radius - along_y;
  // The lower half is folded out over the diagonals.
  const T u = w.z < T(0) ? T(1) - along_y : along_x;
  const T v = w.z < T(0) ? T(1) - along_x : along_y;
  return {(std::copysign(u, w.x) + T(1)) / T(2), (std::copysign(v, w.y) + T(1)) / T(2)};
}

/// A sky of pixels, sampled in proportion to the radiance (mean of the channels). Within a pixel
/// the direction is uniform over solid angle, so the density is right at the poles, too. One number
/// chooses the pixel, and in `float` it has 2^24 values: where a sun has a hundred times the light
/// of the rest, the rest is 2 % too bright with 2048² pixels and 8 % too bright with 8192².
template <std::floating_point T = float>
class EnvironmentMap {
 public:
  /// A direction towards the sky.
  struct Sample {
    Vec3<T> to_sky;    ///< unit, from the scene
    Vec3<T> radiance;  ///< of the sky there
    T density;         ///< per steradian
  };

  /// The columns of `world_from_sky` are the axes of the sky. They must have the same length and be
  /// perpendicular; either handedness is allowed. Throws `std::invalid_argument` for an invalid
  /// image and for a column that is 0 or not finite; equal lengths and right angles are not
  /// checked.
  ///
  /// `next_event_fraction` c in (0, 1): next-event samples are compensated (`compensated_density`)
  /// for a fraction 1 − c of samples that fall elsewhere, uniform over the sphere, as those of
  /// diffuse surfaces on average do: they leave out the dark part of the sky, which must then be
  /// reached by rays that scatter into it. 1: in proportion to the radiance. Emission is always in
  /// proportion to the radiance.
  EnvironmentMap(const EnvironmentImage& image, const glm::dmat3& world_from_sky, double next_event_fraction = 1.0)
      : resolution_(image.resolution), mapping_(image.mapping) {
    if (!(next_event_fraction > 0 && next_event_fraction <= 1))
      reject_argument("the fraction of next-event samples must lie in (0, 1]");
    if (resolution_.x < 1 || resolution_.y < 1 || resolution_.x > largest_side || resolution_.y > largest_side ||
        image.radiance.size() != pixel_count())
      reject_argument("an environment image needs one radiance per pixel and sides of 1 to 32768 pixels");
    if (mapping_ == SkyMapping::equal_area && resolution_.x != resolution_.y)
      reject_argument("an environment image with equal areas must be square");
    for (int i = 0; i < 3; ++i) {
      const double length = glm::length(world_from_sky[i]);
      if (!(length > 0 && length < std::numeric_limits<double>::infinity()))
        reject_argument("the transform of an environment image is singular or not finite");
      axes_[static_cast<std::size_t>(i)] = Vec3<T>(world_from_sky[i] / length);
    }
    if (mapping_ == SkyMapping::latitude_longitude)
      for (int row = 0; row <= resolution_.y; ++row) {
        const double half = pi<double> / 2 * row / resolution_.y;
        row_edges_.push_back({static_cast<T>(square(std::sin(half))), static_cast<T>(square(std::cos(half)))});
      }
    for (const glm::vec3& pixel : image.radiance) {
      pixels_.emplace_back(pixel);
      for (int c = 0; c < 3; ++c)
        if (!(pixels_.back()[c] >= T(0) && pixels_.back()[c] <= T(1e30)))
          reject_argument("the radiance of an environment image must be finite and not negative");
    }
    emission_ = table_of([](const Vec3<T>& radiance) { return static_cast<double>(mean_channel(radiance)); }, total_);
    inverse_total_ = total_ > 0 ? static_cast<T>(1 / total_) : T(0);
    if (next_event_fraction < 1 && total_ > 0) compensate(next_event_fraction);
  }

  /// ∫ radiance over the sphere, mean of the channels.
  [[nodiscard]] double total() const noexcept { return total_; }

  /// Radiance that arrives from the unit direction `to_sky`.
  [[nodiscard]] GMIS_NEVER_INLINE Vec3<T> radiance(Vec3<T> to_sky) const noexcept {
    const Vec3<T> w(glm::dot(axes_[0], to_sky), glm::dot(axes_[1], to_sky), glm::dot(axes_[2], to_sky));
    const Vec2<T> place = mapping_ == SkyMapping::equal_area ? octahedral_sphere_to_square(w) : angles_to_square(w);
    const auto at = [](T x, int cells) {
      return static_cast<std::size_t>(std::clamp(static_cast<int>(x * static_cast<T>(cells)), 0, cells - 1));
    };
    return pixels_[at(place.y, resolution_.y) * static_cast<std::size_t>(resolution_.x) + at(place.x, resolution_.x)];
  }

  /// Density per steradian with which `sample` makes a direction from which this radiance arrives.
  [[nodiscard]] T density(const Vec3<T>& radiance) const noexcept { return mean_channel(radiance) * inverse_total_; }

  /// Draws a direction towards the sky, for emission. The sky must not be black.
  [[nodiscard]] Sample sample(const Vec2<T>& uv) const noexcept {
    Sample drawn = sample_from(emission_, uv);
    drawn.density = density(drawn.radiance);
    return drawn;
  }

  /// `density` for next-event samples, which may be compensated.
  [[nodiscard]] T next_event_density(const Vec3<T>& radiance) const noexcept {
    if (!is_compensated()) return density(radiance);
    // Close to zero nothing but rounding is left of the difference: that counts as zero, in the
    // table too.
    const T excess = slope_ * mean_channel(radiance) - offset_;
    return excess > offset_ * T(1e-4) ? excess * scale_ : T(0);
  }
  /// A direction for a next event, by the compensated density where there is one.
  [[nodiscard]] Sample sample_next_event(const Vec2<T>& uv) const noexcept {
    Sample drawn = sample_from(is_compensated() ? next_event_ : emission_, uv);
    drawn.density = next_event_density(drawn.radiance);
    return drawn;
  }
  /// True when next events are compensated: they leave out the dark part of the sky.
  [[nodiscard]] bool is_compensated() const noexcept { return offset_ > T(0); }

 private:
  static constexpr int largest_side = 32768;
  struct RowEdge {
    T sin2_half, cos2_half;  ///< sin² and cos² of half the angle from z
  };

  /// Rows, and columns given the row, in proportion to some density times solid angle.
  struct Table {
    std::vector<AliasTable<T>> columns;
    AliasTable<T> rows;
  };
  template <class DensityOf>
  [[nodiscard]] Table table_of(DensityOf density_of, double& total) const {
    Table table;
    const auto width = static_cast<std::size_t>(resolution_.x);
    std::vector<double> row_power, weights(width);
    total = 0;
    for (int row = 0; row < resolution_.y; ++row) {
      double sum = 0;
      for (std::size_t column = 0; column < width; ++column)
        sum += weights[column] = density_of(pixels_[static_cast<std::size_t>(row) * width + column]);
      table.columns.emplace_back(std::span<const double>(weights));
      row_power.push_back(sum * solid_angle_in_row(row));
      total += row_power.back();
    }
    table.rows = AliasTable<T>(std::span<const double>(row_power));
    return table;
  }

  /// The compensated density per steradian is max(0, λ L − (1 − c)/(4π))/c: it depends on the
  /// radiance L alone.
  void compensate(double fraction) {
    std::vector<double> target, others;
    std::size_t brightest = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const double angle = solid_angle_in_row(static_cast<int>(i / static_cast<std::size_t>(resolution_.x)));
      target.push_back(static_cast<double>(mean_channel(pixels_[i])) * angle);
      others.push_back(angle / (4 * pi<double>));
      if (mean_channel(pixels_[i]) > mean_channel(pixels_[brightest])) brightest = i;
    }
    const double offset = (1 - fraction) / (4 * pi<double> * fraction);
    const double peak = compensated_density(target, others, fraction)[brightest] / (4 * pi<double> * others[brightest]);
    slope_ = static_cast<T>((peak + offset) / static_cast<double>(mean_channel(pixels_[brightest])));
    offset_ = static_cast<T>(offset);
    double sum = 0;
    next_event_ =
        table_of([&](const Vec3<T>& radiance) { return static_cast<double>(next_event_density(radiance)); }, sum);
    scale_ = static_cast<T>(1 / sum);  // rounding, and the zeros near zero
  }

  [[nodiscard]] GMIS_NEVER_INLINE Sample sample_from(const Table& table, Vec2<T> uv) const noexcept {
    const auto row = table.rows.sample_and_reuse(uv.y);
    const auto column = table.columns[row.index].sample_and_reuse(uv.x);
    const Vec3<T>& radiance = pixels_[row.index * static_cast<std::size_t>(resolution_.x) + column.index];
    const T u = (static_cast<T>(column.index) + column.rest) / static_cast<T>(resolution_.x);
    Vec3<T> w;
    if (mapping_ == SkyMapping::equal_area) {
      w = square_to_octahedral_sphere<T>({u, (static_cast<T>(row.index) + row.rest) / static_cast<T>(resolution_.y)});
    } else {
      // Uniform in z. (1 − z) / 2 and (1 + z) / 2 are interpolated separately, so that both poles
      // stay accurate.
      const RowEdge& from = row_edges_[row.index];
      const RowEdge& to = row_edges_[row.index + 1];
      const T sin2_half = from.sin2_half + (to.sin2_half - from.sin2_half) * row.rest;
      const T cos2_half = from.cos2_half + (to.cos2_half - from.cos2_half) * row.rest;
      const T radius = T(2) * std::sqrt(sin2_half * cos2_half);
      const auto turn = cos_sin_of_turns(u);
      w = {radius * turn.cos, radius * turn.sin, cos2_half - sin2_half};
    }
    return {axes_[0] * w.x + axes_[1] * w.y + axes_[2] * w.z, radiance, T(0)};
  }

  [[nodiscard]] std::size_t pixel_count() const noexcept {
    return static_cast<std::size_t>(resolution_.x) * static_cast<std::size_t>(resolution_.y);
  }
  /// Solid angle of one pixel in this row, in steradians.
  [[nodiscard]] double solid_angle_in_row(int row) const noexcept {
    if (mapping_ == SkyMapping::equal_area) return 4 * pi<double> / static_cast<double>(pixel_count());
    const auto edge = [&](int i) { return square(std::sin(pi<double> / 2 * i / resolution_.y)); };
    return 4 * pi<double> * (edge(row + 1) - edge(row)) / resolution_.x;
  }
  [[nodiscard]] static Vec2<T> angles_to_square(const Vec3<T>& w) noexcept {
    const T turn = std::atan2(w.y, w.x) / (T(2) * pi<T>);
    return {turn < T(0) ? turn + T(1) : turn, std::atan2(std::sqrt(w.x * w.x + w.y * w.y), w.z) / pi<T>};
  }

  glm::ivec2 resolution_;
  SkyMapping mapping_;
  std::array<Vec3<T>, 3> axes_{};
  std::vector<RowEdge> row_edges_;
  std::vector<Vec3<T>> pixels_;
  Table emission_, next_event_;           // the latter only where it differs
  T slope_ = 0, offset_ = 0, scale_ = 1;  // of the compensated density over the radiance
  double total_ = 0;
  T inverse_total_ = 0;
};

}  // namespace gmis::scene
