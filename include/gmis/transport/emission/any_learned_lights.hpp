#pragma once

namespace gmis {

/// Base of `LearnedLights`, for code without the type of the scene.
struct AnyLearnedLights {
  AnyLearnedLights() = default;
  virtual ~AnyLearnedLights() = default;
  AnyLearnedLights(const AnyLearnedLights&) = delete;
  AnyLearnedLights& operator=(const AnyLearnedLights&) = delete;
};

}  // namespace gmis
