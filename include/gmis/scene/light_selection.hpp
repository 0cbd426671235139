#pragma once

namespace gmis::scene {

/// How a scene chooses the lights of next events. Light subpaths choose them by power.
enum class LightSelection {
  by_power,     ///< with probabilities proportional to power
  by_receiver,  ///< by power, distance and orientation as seen from the receiver (`LightHierarchy`)
};

}  // namespace gmis::scene
