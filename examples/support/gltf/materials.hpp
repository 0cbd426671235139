#pragma once

#include <optional>
#include <set>
#include <string>

#include "support/gltf/model.hpp"
#include "support/scene_description.hpp"

namespace gmis::tools::gltf {

/// What a material of glTF is here.
struct MadeMaterial {
  std::size_t number = 0;  ///< in `SceneDescription::materials`
  std::optional<EmissionDescription> emission;
  TextureHandle opacity;
  std::optional<AbsorptionDescription> absorption;
  int uv_set = 0;  ///< of all its textures
};

/// Adds the materials of a model to a scene, each when it is first used.
class Materials {
 public:
  Materials(const tinygltf::Model& model, SceneDescription& scene, const SourcePosition& where,
            Diagnostics& diagnostics)
      : model_(model), scene_(scene), where_(where), diagnostics_(diagnostics) {}

  /// `number` −1 is the default material.
  [[nodiscard]] const MadeMaterial& at(int number);

 private:
  [[nodiscard]] MadeMaterial make(const tinygltf::Material& material);
  void refuse_extensions(const tinygltf::Material& material);
  /// KHR_materials_volume: σ = −ln(attenuation colour) / attenuation distance.
  [[nodiscard]] std::optional<AbsorptionDescription> volume_of(const tinygltf::Material& material);
  enum class Use { color, green, blue, alpha, normal };
  /// Null for a texture that is not there.
  [[nodiscard]] TextureHandle texture(int index, int uv_set, const tinygltf::ExtensionMap& extensions, Use use,
                                      std::optional<double> cutoff = {}, double alpha_factor = 1);
  void unsupported(const std::string& message) { diagnostics_.unsupported(where_, message); }

  const tinygltf::Model& model_;
  SceneDescription& scene_;
  SourcePosition where_;
  Diagnostics& diagnostics_;
  std::map<int, MadeMaterial> made_;
  int uv_set_ = -1;
};

}  // namespace gmis::tools::gltf
