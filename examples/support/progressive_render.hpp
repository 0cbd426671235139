#pragma once

#include <optional>

#include "gmis/render/render.hpp"
#include "support/render.hpp"

namespace gmis {

extern template class Render<tools::SceneType>;

}  // namespace gmis

namespace gmis::tools {

/// A rendering of the built-in scene, with images that can be written to files.
class ProgressiveRender : public Render<SceneType> {
 public:
  /// The scene must outlive this.
  ProgressiveRender(const BuiltScene& scene, const RenderRequest& request)
      : Render<SceneType>(scene.scene(), static_cast<const gmis::RenderRequest&>(request)) {}

  [[nodiscard]] Image image() const { return image_of(picture()); }
};

}  // namespace gmis::tools
