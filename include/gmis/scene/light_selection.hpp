#pragma once

#include <algorithm>
#include <cstddef>

namespace gmis::scene {

/// How a scene chooses the lights of next events. Light subpaths choose them by power.
enum class LightSelection {
  by_power,     ///< in proportion to the power that may meet the scene, but see `infinite_share`
  by_receiver,  ///< by power, distance and orientation as seen from the receiver (`LightHierarchy`)
  learned,      ///< for the receiver in runs whose first samples say that it pays, else by power
};

/// The probability of infinite lights together, half by power and half as if all lights at a place
/// were one. The power of a sky is that through the whole scene, of which little may be seen: by
/// power alone, a lamp on a wide plane would hardly ever be chosen.
[[nodiscard]] constexpr double balanced_infinite_share(double infinite_power, std::size_t infinite_lights,
                                                       double local_power) noexcept {
  if (!(infinite_power > 0) || !(local_power > 0)) return infinite_power > 0 ? 1 : 0;
  const double count = static_cast<double>(infinite_lights);
  return 0.5 * infinite_power / (infinite_power + local_power) + 0.5 * count / (count + 1);
}

/// The probability of infinite lights together in `LightSelection::by_power`: by power or balanced,
/// whichever is less. With a sun (a directional light) it is by power where the lights at a place
/// have a tenth or more: a sun is found by next events alone, a sky also by other rays. Both powers
/// must be above 0.
[[nodiscard]] constexpr double infinite_share(double infinite_power, std::size_t infinite_lights, double local_power,
                                              bool has_sun) noexcept {
  constexpr double least = 0.1;
  const double by_power = infinite_power / (infinite_power + local_power);
  if (has_sun && 1 - by_power >= least) return by_power;
  return std::min(by_power, balanced_infinite_share(infinite_power, infinite_lights, local_power));
}

}  // namespace gmis::scene
