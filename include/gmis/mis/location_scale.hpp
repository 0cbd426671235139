#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/exp_in_lanes.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/storage.hpp"

/// \file
/// Many proposals of one shape on the line, each parameter in an array of its own: one loop
/// evaluates all densities at a point, and compilers turn it into vector instructions.

namespace gmis {

/// Standard densities on the line: `pdf(z)`, without calls and branches, and `sample<T>(source)`.
namespace shapes {

/// Half the step of the numbers that `uniform` returns in float and double, less in long double. An
/// inversion adds it, so that it never meets 0 and 1.
template <std::floating_point T>
inline constexpr T half_step = std::numeric_limits<T>::epsilon() / T(4);

/// 1/(π (1 + z²)).
struct Cauchy {
  /// The density at z.
  template <std::floating_point T>
  [[nodiscard]] GMIS_ALWAYS_INLINE static T pdf(T z) noexcept {
    return std::numbers::inv_pi_v<T> / (T(1) + z * z);
  }
  /// A number with this density, by inversion: one number of the source.
  template <std::floating_point T>
  [[nodiscard]] static T sample(UniformSource auto& source) {
    return std::tan(std::numbers::pi_v<T> * ((uniform<T>(source) - T(0.5)) + half_step<T>));
  }
};

/// e^{−|z|}/(1 + e^{−|z|})².
struct Logistic {
  /// The density at z.
  template <std::floating_point T>
  [[nodiscard]] GMIS_ALWAYS_INLINE static T pdf(T z) noexcept {
    const T tail = static_cast<T>(exp_in_lanes(-std::abs(static_cast<double>(z))));
    return tail / ((T(1) + tail) * (T(1) + tail));
  }
  /// A number with this density, by inversion: one number of the source.
  template <std::floating_point T>
  [[nodiscard]] static T sample(UniformSource auto& source) {
    const T u = uniform<T>(source);
    return std::log((u + half_step<T>) / ((T(1) - u) - half_step<T>));
  }
};

/// e^{−z²/2}/√(2π).
struct Normal {
  /// The density at z.
  template <std::floating_point T>
  [[nodiscard]] GMIS_ALWAYS_INLINE static T pdf(T z) noexcept {
    constexpr T peak = std::numbers::inv_sqrtpi_v<T> / std::numbers::sqrt2_v<T>;
    return peak * static_cast<T>(exp_in_lanes(-0.5 * (static_cast<double>(z) * static_cast<double>(z))));
  }
  /// Two numbers of the source a sample [Box, Muller 1958].
  template <std::floating_point T>
  [[nodiscard]] static T sample(UniformSource auto& source) {
    const T radius = std::sqrt(T(-2) * std::log(T(1) - uniform<T>(source)));
    return radius * std::cos(T(2) * std::numbers::pi_v<T> * uniform<T>(source));
  }
};

}  // namespace shapes

/// A standard density on the line.
template <class S, class T>
concept LineShape = requires(T z, Philox& source) {
  { S::pdf(z) } -> std::same_as<T>;
  { S::template sample<T>(source) } -> std::same_as<T>;
};

/// The set of q_i(x) = shape((x − location_i)/scale_i)/scale_i. With a `Capacity` it never
/// allocates and holds at most that number of proposals.
template <class Shape, std::floating_point T = double, std::size_t Capacity = dynamic_capacity>
requires LineShape<Shape, T>
class LocationScaleSet {
 public:
  using Value = T;
  using Density = T;
  static constexpr std::size_t capacity = Capacity;

  /// Throws std::invalid_argument unless there is one scale for each location, at least one, all
  /// finite, scales positive and with a finite inverse.
  LocationScaleSet(std::span<const T> locations, std::span<const T> scales) : size_(locations.size()) {
    require_argument(size_ > 0, "the set of proposals is empty: give it at least one location");
    require_argument(scales.size() == size_, "give one scale for each location");
    locations_.prepare(size_);
    scales_.prepare(size_);
    inverses_.prepare(size_);
    for (std::size_t i = 0; i < size_; ++i) {
      require_argument(std::isfinite(locations[i]), "a location is not finite");
      require_argument(scales[i] > T(0) && std::isfinite(scales[i]) && std::isfinite(T(1) / scales[i]),
                       "a scale must be positive and finite, and so must its inverse");
      locations_[i] = locations[i];
      scales_[i] = scales[i];
      inverses_[i] = T(1) / scales[i];
    }
  }

  /// How many proposals there are.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// A sample of proposal i.
  [[nodiscard]] T sample(std::size_t i, UniformSource auto& source) const {
    return locations_[i] + scales_[i] * Shape::template sample<T>(source);
  }
  /// The density of proposal i at x.
  [[nodiscard]] GMIS_ALWAYS_INLINE T pdf(std::size_t i, T x) const noexcept {
    return Shape::pdf((x - locations_[i]) * inverses_[i]) * inverses_[i];
  }
  /// The densities of all proposals at x, in one loop. The same bits as `pdf`.
  GMIS_ALWAYS_INLINE void pdfs(T x, std::span<T> out) const noexcept {
    const T* const locations = locations_.data();
    const T* const inverses = inverses_.data();
    T* const densities = out.data();
    for (std::size_t i = 0; i < size_; ++i) densities[i] = Shape::pdf((x - locations[i]) * inverses[i]) * inverses[i];
  }

 private:
  std::size_t size_;
  Storage<T, Capacity> locations_, scales_, inverses_;
};

}  // namespace gmis
