#pragma once

#include <optional>

#include "gmis/render/render_run.hpp"
#include "support/engines/engines.hpp"
#include "support/render.hpp"

namespace gmis {

extern template class RenderRun<tools::SceneSpectrum>;

}  // namespace gmis

namespace gmis::tools {

/// A rendering of the built-in scene, with images that can be written to files.
class ProgressiveRender : public RenderRun<SceneSpectrum> {
 public:
  /// The scene must outlive this.
  ProgressiveRender(const BuiltScene& scene, const RenderRequest& request)
      : RenderRun<SceneSpectrum>(engines_for(scene, request), scene.scene().camera().resolution(), request) {}

  [[nodiscard]] Image image() const { return image_of(picture()); }
};

}  // namespace gmis::tools
