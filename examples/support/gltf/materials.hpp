#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include "support/gltf/document.hpp"
#include "support/image/texture_image.hpp"
#include "support/scene_description.hpp"

namespace gmis::tools::gltf {

/// A material of glTF in this library's terms.
struct MadeMaterial {
  std::size_t number = 0;  ///< in `SceneDescription::materials`
  std::optional<EmissionDescription> emission;
  TextureHandle opacity;
  std::optional<AbsorptionDescription> absorption;
};

/// How textures and colours lie on one part of a mesh.
struct SurfaceLayout {
  /// Maps a texture over TEXCOORD_set to the coordinates that this part of the mesh has; null: it
  /// has that set itself.
  std::function<TextureHandle(std::size_t set, TextureHandle)> over;
  TextureHandle vertex_color, vertex_alpha;  ///< null where vertices have none
};

/// Makes the materials of a file.
class Materials {
 public:
  Materials(const Document& document, SceneDescription& scene, Diagnostics& diagnostics)
      : document_(document), scene_(scene), diagnostics_(diagnostics) {}

  /// The sets of coordinates (TEXCOORD_n) that the textures of a material use; no number is the
  /// default material.
  [[nodiscard]] std::set<std::size_t> coordinate_sets(std::optional<std::size_t> number) const;
  /// The set that its normal map uses; nothing without a normal map.
  [[nodiscard]] std::optional<std::size_t> normal_map_set(std::optional<std::size_t> number) const;
  /// Its surface emits its colour.
  [[nodiscard]] bool is_unlit(std::optional<std::size_t> number) const;
  /// The extensions of materials that are read, or ignored with a note.
  [[nodiscard]] static const std::set<std::string>& understood_extensions();
  /// The material over the coordinates of a mesh as they are; made once and kept.
  [[nodiscard]] const MadeMaterial& at(std::optional<std::size_t> number);
  [[nodiscard]] MadeMaterial made(std::optional<std::size_t> number, const SurfaceLayout& layout);

 private:
  /// Metallic-roughness: factors, and textures of which each may be null.
  struct Layers {
    Rgb base{1};
    double alpha = 1, metallic = 1, roughness = 1;
    TextureHandle color, opacity, metal, rough;
  };
  /// Index and surface, the same for all lobes of a material.
  struct Finish {
    double ior = 1.5, alpha = 1;
    MaterialTexturesDescription textures;
  };
  enum class Use { color, red, green, blue, alpha, normal };
  [[nodiscard]] const Json& json_of(std::optional<std::size_t> number) const;
  [[nodiscard]] Layers metallic_roughness(const Json& material);
  [[nodiscard]] Layers specular_glossiness(const Json& packed);
  [[nodiscard]] Finish finish_of(const Json& material, const Layers& layers);
  [[nodiscard]] std::size_t surface_of(const Json& material, const Layers& layers,
                                       std::optional<AbsorptionDescription>& absorption);
  [[nodiscard]] std::size_t glass_of(const Json& material, const Layers& layers, Finish finish);
  [[nodiscard]] bool has_thickness(const Json& material) const;
  /// KHR_materials_volume: σ = −ln(attenuation colour) / attenuation distance.
  [[nodiscard]] std::optional<AbsorptionDescription> volume_of(const Json& material);
  [[nodiscard]] std::optional<EmissionDescription> emission_of(const Json& material);
  [[nodiscard]] TextureHandle opacity_of(const Json& material, const Layers& layers);
  void refuse_extensions(const Json& material);
  /// A texture as an object like `baseColorTexture` names it; null where there is none, or its
  /// image is missing (a grey for a colour).
  [[nodiscard]] TextureHandle texture(const Json& info, Use use, double normal_scale = 1);
  [[nodiscard]] std::shared_ptr<const scene::TextureImage> pixels(std::size_t image, Use use, double normal_scale);
  [[nodiscard]] TextureHandle tinted(const TextureHandle& image, const Rgb& factor) const;
  [[nodiscard]] double share(const Json& object, const char* name, double otherwise);
  [[nodiscard]] Rgb color(const Json& object, const char* name, const Rgb& otherwise, double most);
  std::size_t add(const decltype(MaterialDescription::kind)& kind, const MaterialTexturesDescription& varying = {});
  void unsupported(const std::string& message) { diagnostics_.unsupported(document_.where(), message); }
  void note(const std::string& message) { diagnostics_.note(document_.where(), message); }

  const Document& document_;
  SceneDescription& scene_;
  Diagnostics& diagnostics_;
  std::map<std::optional<std::size_t>, MadeMaterial> made_;
  std::map<std::tuple<std::size_t, Use, double>, std::shared_ptr<const scene::TextureImage>> pixels_;
  const SurfaceLayout* layout_ = nullptr;  ///< of the material that is being made
  std::string name_;                       ///< what messages call it
};

}  // namespace gmis::tools::gltf
