#pragma once

#include <glm/vec2.hpp>

namespace gmis {

/// A rectangle of pixels: `lower` inclusive, `upper` exclusive, y down from the upper left.
struct PixelBounds {
  glm::ivec2 lower{0, 0};  ///< first column and row
  glm::ivec2 upper{0, 0};  ///< one past the last column and row
};

}  // namespace gmis
