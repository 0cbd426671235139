#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gmis/scene/scene_builder.hpp"

namespace hostile {

using Builder = gmis::scene::SceneBuilder<float>;

/// The paths of a scene, by the reason why some integrators cannot make them (docs/integrators.md).
enum class Paths {
  all,            ///< each of the seven makes every path
  through_delta,  ///< delta surfaces: lt cannot connect the camera with what is seen by way of them
  narrow,         ///< lobes so narrow that lt and ppm, which do not sample them from the camera, find them too rarely
  /// Lobes that lt finds, but ppm, which has to find a photon besides, so rarely that its error is
  /// not known. At a Phong exponent of 100 its pictures have skewness 40, and so the mean of 600
  /// has 1.7; Student's t holds for far less than 1.
  narrow_for_ppm
};

/// A small scene that is hard on numbers, and what its picture must be.
struct HostileScene {
  std::string name;
  std::function<void(Builder&)> make;
  int max_depth = 5;
  double radius = 0.005;  ///< of merging, over half the scene's diagonal
  Paths paths = Paths::all;
  /// The radiance of every pixel; where there is none, `pt` says what the mean is.
  std::optional<double> radiance{};
  /// The largest bias of merging, relative to the mean.
  double bias = 0.015;
  /// Rare paths of enormous weight: the estimate is held to nothing but being finite.
  bool has_heavy_tail = false;
};

/// Pictures are this many pixels wide and high.
inline constexpr int picture_size = 8;

[[nodiscard]] std::vector<HostileScene> hostile_scenes();

/// A floor, a wall, a ball and two lights, all `scale` times as large and moved by `shift`, the
/// light so that the picture stays the same.
void make_stage(Builder& builder, double scale, const glm::dvec3& shift);

}  // namespace hostile
