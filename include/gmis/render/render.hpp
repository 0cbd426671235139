#pragma once

#include <utility>

#include "gmis/render/render_run.hpp"
#include "gmis/transport/allocation/engines_with_pilot.hpp"

namespace gmis {

/// A rendering of a scene that improves iteration by iteration (`RenderRun`).
///
/// ```
/// gmis::Render render(scene, gmis::automatic_request(scene, {.iterations = 64}));
/// const gmis::RenderResult result = render.run(executor);
/// ```
///
/// The engines of the scene are compiled where the constructor is called, which takes seconds;
/// `GMIS_DECLARE_ENGINES` (declare_engines.hpp) compiles them in one file of a project.
template <Scene Sc, class Source = SampleNumbers>
class Render : public RenderRun<typename Sc::Spectrum> {
 public:
  /// Prepares a run over `scene`, which must outlive it.
  Render(const Sc& scene, RenderRequest request)
      : RenderRun<typename Sc::Spectrum>(engines_with_pilot<Sc, Source>(scene), scene.camera().resolution(),
                                         std::move(request)) {}
};

}  // namespace gmis
