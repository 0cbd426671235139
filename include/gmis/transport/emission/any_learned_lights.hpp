#pragma once

namespace gmis {

/// What an engine has learned about the lights of its scene, for code without the scene's type:
/// `LearnedLights`.
struct AnyLearnedLights {
  AnyLearnedLights() = default;
  virtual ~AnyLearnedLights() = default;
  AnyLearnedLights(const AnyLearnedLights&) = delete;
  AnyLearnedLights& operator=(const AnyLearnedLights&) = delete;
};

}  // namespace gmis
