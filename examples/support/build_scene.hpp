#pragma once

#include <memory>
#include <string>

#include "gmis/scene/bvh_scene.hpp"
#include "gmis/scene/light_selection.hpp"
#include "gmis/transport/context/iteration_context.hpp"
#include "support/scene_description.hpp"

namespace gmis::tools {

/// A scene that the engine can render.
class BuiltScene {
 public:
  using SceneType = scene::BvhScene<float>;

  BuiltScene(SceneType scene, std::string film_file_name, std::string summary, std::optional<PixelBounds> film_crop)
      : scene_(std::move(scene)),
        film_file_name_(std::move(film_file_name)),
        summary_(std::move(summary)),
        film_crop_(film_crop) {}

  [[nodiscard]] const SceneType& scene() const { return scene_; }
  /// Half the diagonal of the box around all surfaces.
  [[nodiscard]] double half_diagonal() const { return scene_.statistics().half_diagonal; }
  [[nodiscard]] const std::string& film_file_name() const { return film_file_name_; }
  /// The part of the picture that the scene file asks for.
  [[nodiscard]] const std::optional<PixelBounds>& film_crop() const { return film_crop_; }
  /// The size of the scene in numbers, in one line.
  [[nodiscard]] const std::string& summary() const { return summary_; }

 private:
  SceneType scene_;
  std::string film_file_name_, summary_;
  std::optional<PixelBounds> film_crop_;
};

/// Hands the description to the scene layer. Throws `InputError` with the place of the element that
/// it refuses.
[[nodiscard]] std::unique_ptr<BuiltScene> build_scene(const SceneDescription& description, Diagnostics& diagnostics,
                                                      scene::LightSelection lights = scene::LightSelection::by_power);

}  // namespace gmis::tools
