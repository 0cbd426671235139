#include "support/engines/engines.hpp"

#include "gmis/transport/allocation/engines_with_pilot.hpp"
#include "gmis/transport/splitting/gmis_engines.hpp"
#include "support/scene_engine.hpp"

namespace gmis {

template class AnyEngine<tools::SceneSpectrum>;
template class AnyPilot<tools::SceneSpectrum>;
template class RenderEngine<tools::SceneSpectrum>;

namespace tools {

EngineMaker<SceneSpectrum> engines_for(const BuiltScene& scene, const RenderRequest& request) {
  EngineMaker<SceneSpectrum> engines = engines_with_pilot(scene.scene());
  if (!request.sampler) return engines;
  EngineMaker<SceneSpectrum> splitting = gmis_engines(scene.scene(), *request.sampler);
  splitting.pilot = engines.pilot;  // it chooses connections by light paths that do not split
  return splitting;
}

}  // namespace tools
}  // namespace gmis
