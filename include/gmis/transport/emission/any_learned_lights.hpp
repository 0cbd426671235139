#pragma once

#include <optional>

namespace gmis {

/// The choice of lights and of the starts of light subpaths in a run, and the gains that decided
/// it.
struct LightUse {
  bool chooses_for_receiver = false;  ///< next events choose lights for the receiver, light subpaths by power
  /// `receiver_gain`: second moment of next events with lights chosen by power over that with
  /// lights chosen for the receiver. Empty where the scene leaves no choice.
  std::optional<double> receiver_gain;
  bool guides_emission = false;  ///< light subpaths start by the learned guide (`EmissionGuide`)
  /// Second moment of the light that arrives by emission without the guide over that with it, the
  /// inverse of `relative_moment`; 1 where there is nothing to guide. Empty where no guide was
  /// learned.
  std::optional<double> emission_gain;

  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(chooses_for_receiver, receiver_gain, guides_emission, emission_gain);
  }
};

/// Base of `LearnedLights`, for code without the type of the scene.
struct AnyLearnedLights {
  AnyLearnedLights() = default;
  virtual ~AnyLearnedLights() = default;
  AnyLearnedLights(const AnyLearnedLights&) = delete;
  AnyLearnedLights& operator=(const AnyLearnedLights&) = delete;
};

}  // namespace gmis
