#pragma once

#include <cstdint>

#include "gmis/scene/bvh_scene.hpp"

/// \file
/// The two ways to render. Each is compiled in a file of its own: a compiler limits how much it
/// inlines in one file, and neither way is to use up the other's share.

namespace hand {

inline constexpr int max_depth = 8;

/// The sum of all values of all pictures, by the path tracer written by hand.
[[nodiscard]] double sum_by_hand(const gmis::scene::BvhScene<float>& scene, std::uint32_t iterations);
/// The same by the engine.
[[nodiscard]] double sum_by_engine(const gmis::scene::BvhScene<float>& scene, std::uint32_t iterations);

}  // namespace hand
