#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <vector>

#include "gmis/scene/light.hpp"
#include "gmis/scene/light_reach.hpp"
#include "gmis/scene/light_selection.hpp"

/// \file
/// The powers in proportion to which a scene chooses its lights.

namespace gmis::scene {

/// The power by which each light is chosen, for a local light times the share of it that may meet
/// the receivers. Light reaches the surfaces that shine, too, and they may reflect it: each local
/// light keeps at least a hundredth of the mean over all local lights, or all of its power.
template <std::floating_point T>
[[nodiscard]] std::vector<double> powers_towards(const ReceiverBall& receivers, const std::vector<Light<T>>& lights) {
  std::vector<double> whole, part;
  double sum = 0, count = 0;
  for (const Light<T>& light : lights) {
    whole.push_back(light.power_to_choose_by());
    const bool has_share = !light.is_infinite() && receivers.radius >= 0;
    part.push_back(has_share ? whole.back() * light.share_towards(receivers) : whole.back());
    if (light.is_infinite() || !(whole.back() > 0)) continue;
    sum += part.back();
    ++count;
  }
  if (receivers.radius < 0 || !(sum > 0)) return whole;
  for (std::size_t i = 0; i < lights.size(); ++i) part[i] = std::max(part[i], std::min(whole[i], 0.01 * sum / count));
  return part;
}

/// Scales the powers of infinite lights so that these have the probability `infinite_share`.
template <std::floating_point T>
void keep_local_lights(const std::vector<Light<T>>& lights, std::vector<double>& powers) {
  double local = 0, infinite = 0;
  std::size_t infinite_count = 0;
  bool has_sun = false;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    (lights[i].is_infinite() ? infinite : local) += powers[i];
    if (!lights[i].is_infinite() || !(powers[i] > 0)) continue;
    ++infinite_count;
    has_sun = has_sun || lights[i].is_delta();
  }
  if (!(infinite > 0) || !(local > 0)) return;
  const double share = infinite_share(infinite, infinite_count, local, has_sun);
  if (!(share < infinite / (infinite + local))) return;
  const double scale = share / (1 - share) * local / infinite;
  for (std::size_t i = 0; i < lights.size(); ++i)
    if (lights[i].is_infinite()) powers[i] *= scale;
}

}  // namespace gmis::scene
