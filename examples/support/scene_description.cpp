#include "support/scene_description.hpp"

#include <cmath>
#include <numbers>

namespace gmis::tools {

std::array<double, 4> picture_window(const CameraDescription& camera, int width, int height) {
  const double half = camera.is_orthographic ? 1 : std::tan(camera.field_of_view * std::numbers::pi / 360);
  std::array<double, 4> window{};
  if (camera.screen_window) {
    window = *camera.screen_window;
  } else {
    const double aspect = camera.frame_aspect_ratio.value_or(static_cast<double>(width) / height);
    const double x = aspect > 1 ? aspect : 1;
    const double y = aspect > 1 ? 1 : 1 / aspect;
    window = {-x, x, -y, y};
  }
  for (double& side : window) side *= half;
  return window;
}

}  // namespace gmis::tools
