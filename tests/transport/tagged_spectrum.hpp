#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "gmis/core/spectrum.hpp"

namespace gmis_test {

/// The event that put a tag on a throughput.
enum class TagRole : std::uint8_t { camera, light, scattered_radiance, scattered_importance };

/// One vertex of a path. `order` counts the ray that found the vertex, so that it grows along a
/// subpath.
struct Tag {
  std::uint32_t order;
  std::uint8_t node;
  std::uint8_t lobe;  ///< `smooth` or the number of a delta lobe
  TagRole role;
  static constexpr std::uint8_t smooth = 255;
};

/// One channel of light that remembers by which vertices it came: every factor brings its tag
/// along, so a contribution tells its whole path, whatever the renderer computed it by.
template <std::floating_point T>
struct Tagged {
  static constexpr std::size_t most_tags = 12;

  T value{};
  std::uint8_t count = 0;
  std::array<Tag, most_tags> tags;

  Tagged() = default;
  explicit Tagged(T v) : value(v) {}
  Tagged(T v, const Tag& tag) : value(v), count(1) { tags[0] = tag; }
  Tagged(const Tagged& other) : value(other.value), count(other.count) {
    std::copy_n(other.tags.begin(), other.count, tags.begin());
  }
  Tagged& operator=(const Tagged& other) {
    value = other.value;
    count = other.count;
    if (this != &other) std::copy_n(other.tags.begin(), other.count, tags.begin());
    return *this;
  }
  ~Tagged() = default;

  /// A sum over paths belongs to no path.
  Tagged& operator+=(const Tagged& other) {
    value += other.value;
    count = 0;
    return *this;
  }
  [[nodiscard]] friend Tagged operator+(const Tagged& a, const Tagged& b) { return Tagged(a.value + b.value); }
  [[nodiscard]] friend Tagged operator*(const Tagged& a, T factor) {
    Tagged result(a);
    result.value *= factor;
    return result;
  }
  [[nodiscard]] friend Tagged operator*(const Tagged& a, const Tagged& b) {
    if (a.count + b.count > most_tags) throw std::length_error("a path is longer than its tags");
    Tagged result(a);
    result.value *= b.value;
    std::copy_n(b.tags.begin(), b.count, result.tags.begin() + a.count);
    result.count = static_cast<std::uint8_t>(a.count + b.count);
    return result;
  }
};

}  // namespace gmis_test

template <std::floating_point T>
struct gmis::SpectrumTraits<gmis_test::Tagged<T>> {
  using Scalar = T;
  static constexpr int channel_count = 1;
  static T channel(const gmis_test::Tagged<T>& s, int) noexcept { return s.value; }
};
