#pragma once

#include <string>

#include "gmis/core/concept_diagnostics.hpp"
#include "gmis/core/effects.hpp"
#include "gmis/core/light_choice.hpp"
#include "gmis/core/light_groups.hpp"
#include "gmis/transport/state/path_class.hpp"

namespace gmis {

/// The optional members of a scene and its types that are missing, and what each costs: a line for
/// each, empty when none is missing.
template <Scene Sc>
[[nodiscard]] std::string explain(const Sc& scene) {
  using B = typename Sc::Bsdf;
  std::string text;
  if constexpr (!SceneWithEffects<Sc>) {
    text +=
        "Scene::effects() is missing: every effect is taken to occur, so that no technique is left out for the scene's "
        "sake; a pilot still leaves out what does not pay\n";
  } else {
    const Effects effects = effects_of(scene);
    if (effects == Effects::everything())
      text += "Scene::effects() names every effect: no technique is left out for the scene's sake\n";
    if (!effects.has_lights()) text += "Scene::effects() names no light: the picture will be black\n";
  }
  if constexpr (!chooses_for_receiver<Sc>())
    text +=
        "Scene::sample_light(from, u) and selection_probability(light, from) are missing: next events choose lights "
        "without regard to their receiver, which makes more noise with many lights of which each reaches little\n";
  if constexpr (!SceneWithLightGroups<Sc>)
    text += "Scene::light_group(light) is missing: all lights are one in RenderRequest::light_pictures\n";
  if constexpr (!BsdfWithLobes<B>)
    text +=
        "Bsdf names no lobes (BsdfWithLobes): a light tree that splits draws its children from sample() alone, with "
        "GmisSampler::rounds above 1\n";
  if constexpr (!requires(const B& bsdf) { bsdf.is_glossy(); })
    text +=
        "Bsdf::is_glossy() is missing: surfaces without a diffuse part count as diffuse in path classes, which matters "
        "for "
        "RenderSettings::path_classes and pictures of classes alone\n";
  return text;
}

/// \cond
// For a type that is no scene: the compiler names what it lacks.
template <class Sc>
requires(!Scene<Sc>) IsScene<Sc> explain(const Sc&);
/// \endcond

}  // namespace gmis
