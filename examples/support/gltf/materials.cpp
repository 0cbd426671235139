#include "support/gltf/materials.hpp"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <limits>

#include "support/image/texture_image.hpp"

namespace gmis::tools::gltf {
namespace {

using Tex = scene::Texture<float>;

TextureHandle constant(double value) {
  return Tex::constant(glm::dvec3(value));
}

Rgb color_of(const std::vector<double>& numbers, const Rgb& otherwise) {
  return numbers.size() >= 3 ? Rgb(numbers[0], numbers[1], numbers[2]) : otherwise;
}

double number_in(const tinygltf::Value& value, const char* name, double otherwise) {
  return value.IsObject() && value.Has(name) && value.Get(name).IsNumber() ? value.Get(name).GetNumberAsDouble()
                                                                           : otherwise;
}

const tinygltf::Value* extension_of(const tinygltf::Material& material, const char* name) {
  const auto found = material.extensions.find(name);
  return found == material.extensions.end() ? nullptr : &found->second;
}

/// One channel of an image whose colours are linear, as grey.
std::shared_ptr<const scene::TextureImage> channel_of(const scene::TextureImage& image, std::size_t channel) {
  auto result = std::make_shared<scene::TextureImage>();
  result->resolution = image.resolution;
  result->channels = 1;
  for (int y = 0; y < image.resolution.y; ++y)
    for (int x = 0; x < image.resolution.x; ++x) result->floats.push_back(image.texel(x, y)[static_cast<int>(channel)]);
  return result;
}

}  // namespace

const MadeMaterial& Materials::at(int number) {
  const auto found = made_.find(number);
  if (found != made_.end()) return found->second;
  const bool is_there = number >= 0 && static_cast<std::size_t>(number) < model_.materials.size();
  return made_[number] = make(is_there ? model_.materials[static_cast<std::size_t>(number)] : tinygltf::Material());
}

TextureHandle Materials::texture(int index, int uv_set, const tinygltf::ExtensionMap& extensions, Use use,
                                 std::optional<double> cutoff, double alpha_factor) {
  if (index < 0) return nullptr;
  if (uv_set_ >= 0 && uv_set_ != uv_set) unsupported("a material whose textures have different coordinates");
  uv_set_ = uv_set;
  scene::TexturePlacement placement;
  if (const auto found = extensions.find("KHR_texture_transform"); found != extensions.end()) {
    const auto pair = [&](const char* name, glm::dvec2 otherwise) {
      if (!found->second.Has(name) || found->second.Get(name).ArrayLen() != 2) return otherwise;
      const tinygltf::Value& list = found->second.Get(name);
      return glm::dvec2(list.Get(0).GetNumberAsDouble(), list.Get(1).GetNumberAsDouble());
    };
    if (number_in(found->second, "rotation", 0) != 0) unsupported("a texture that is turned by KHR_texture_transform");
    // glTF counts t from the top: t' = 1 − ((1 − t) scale + offset).
    placement.scale = pair("scale", glm::dvec2(1));
    const glm::dvec2 offset = pair("offset", glm::dvec2(0));
    placement.offset = {offset.x, 1 - placement.scale.y - offset.y};
  }
  const auto refuse = [&](const std::string& what) { return InputError(where_, what); };
  if (static_cast<std::size_t>(index) >= model_.textures.size()) throw refuse("a texture is not there");
  const tinygltf::Texture& description = model_.textures[static_cast<std::size_t>(index)];
  if (description.source < 0 || static_cast<std::size_t>(description.source) >= model_.images.size())
    throw refuse("a texture has no image");
  const tinygltf::Image& image = model_.images[static_cast<std::size_t>(description.source)];
  const std::string name = !image.uri.empty() ? image.uri : image.name.empty() ? "image" : image.name;
  if (image.image.empty() && !image.uri.empty())
    throw refuse("the image " + in_quotes(image.uri) + " is missing: check its name");
  scene::TextureWrap wrap = scene::TextureWrap::repeat;
  scene::TextureFilter filter = scene::TextureFilter::bilinear;
  if (description.sampler >= 0 && static_cast<std::size_t>(description.sampler) < model_.samplers.size()) {
    const tinygltf::Sampler& sampler = model_.samplers[static_cast<std::size_t>(description.sampler)];
    if (sampler.wrapS == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) wrap = scene::TextureWrap::clamp;
    if (sampler.wrapS != sampler.wrapT || sampler.wrapS == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT)
      unsupported("a texture that is mirrored, or wrapped in two ways");
    if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) filter = scene::TextureFilter::nearest;
  }
  TextureEncoding encoding;
  if (use != Use::color) encoding.curve = TextureEncoding::Curve::linear;
  auto pixels = read_texture_image(image.image.data(), image.image.size(), name, encoding,
                                   use == Use::alpha ? TexturePart::alpha : TexturePart::color, where_);
  if (use == Use::green) pixels = channel_of(*pixels, 1);
  if (use == Use::blue) pixels = channel_of(*pixels, 2);
  if (cutoff && !pixels->bytes.empty()) {
    auto cut = std::make_shared<scene::TextureImage>(*pixels);
    for (float& value : cut->decoded) value = static_cast<double>(value) * alpha_factor >= *cutoff ? 1.0F : 0.0F;
    pixels = std::move(cut);
  }
  try {
    return Tex::image(std::move(pixels), placement, wrap, filter);
  } catch (const std::invalid_argument& error) {
    throw refuse(name + ": " + error.what());
  }
}

void Materials::refuse_extensions(const tinygltf::Material& material) {
  static const std::set<std::string> understood{"KHR_materials_transmission", "KHR_materials_ior",
                                                "KHR_materials_emissive_strength", "KHR_materials_volume"};
  for (const auto& [name, value] : material.extensions) {
    if (understood.contains(name)) continue;
    if (name == "KHR_materials_specular" && number_in(value, "specularFactor", 1) == 1 &&
        !value.Has("specularColorFactor") && !value.Has("specularTexture") && !value.Has("specularColorTexture"))
      continue;
    unsupported("material " + in_quotes(material.name) + ": " + name);
  }
}

std::optional<AbsorptionDescription> Materials::volume_of(const tinygltf::Material& material) {
  const auto* extension = extension_of(material, "KHR_materials_volume");
  if (extension == nullptr) return {};
  // Without a thickness the surface is a thin wall, which absorbs nothing. How thick it is says the mesh.
  if (!(number_in(*extension, "thicknessFactor", 0) > 0)) return {};
  const double distance = number_in(*extension, "attenuationDistance", std::numeric_limits<double>::infinity());
  if (!(distance > 0)) throw InputError(where_, "material " + in_quotes(material.name) + " has no attenuationDistance");
  Rgb color(1);
  if (extension->Has("attenuationColor") && extension->Get("attenuationColor").ArrayLen() == 3)
    for (int c = 0; c < 3; ++c) color[c] = extension->Get("attenuationColor").Get(c).GetNumberAsDouble();
  constexpr double blackest = 1e-12;  // black glass: as good as none gets through
  const Rgb sigma = -glm::log(glm::clamp(color, Rgb(blackest), Rgb(1))) / distance;
  if (sigma == Rgb(0)) return {};
  return AbsorptionDescription{sigma, Rgb(0)};
}

MadeMaterial Materials::make(const tinygltf::Material& material) {
  uv_set_ = -1;
  refuse_extensions(material);
  const auto& model = material.pbrMetallicRoughness;
  const Rgb base = glm::clamp(color_of(model.baseColorFactor, Rgb(1)), Rgb(0), Rgb(1));
  const double metallic = std::clamp(model.metallicFactor, 0.0, 1.0);
  const double roughness = std::clamp(model.roughnessFactor, 0.0, 1.0);
  double ior = 1.5, transmission = 0;
  if (const auto* extension = extension_of(material, "KHR_materials_ior")) ior = number_in(*extension, "ior", 1.5);
  if (const auto* extension = extension_of(material, "KHR_materials_transmission")) {
    transmission = std::clamp(number_in(*extension, "transmissionFactor", 0), 0.0, 1.0);
    if (extension->Has("transmissionTexture")) unsupported("a texture of transmission");
  }
  if (!(ior >= 1 && ior < 10)) throw InputError(where_, "material " + in_quotes(material.name) + " has an ior below 1");

  MaterialTexturesDescription textures;
  const auto& base_image = model.baseColorTexture;
  const auto& layers = model.metallicRoughnessTexture;
  if (const auto image = texture(base_image.index, base_image.texCoord, base_image.extensions, Use::color))
    textures.color = base == Rgb(1) ? image : Tex::product(image, Tex::constant(base));
  TextureHandle rough = texture(layers.index, layers.texCoord, layers.extensions, Use::green);
  TextureHandle metal = texture(layers.index, layers.texCoord, layers.extensions, Use::blue);
  if (rough) {
    rough = Tex::product(rough, constant(roughness));
    textures.roughness = Tex::product(rough, rough);  // α is its square
  }
  const auto& normals = material.normalTexture;
  textures.normal_map = texture(normals.index, normals.texCoord, normals.extensions, Use::normal);
  if (textures.normal_map && normals.scale != 1) unsupported("a normal map with a scale other than 1");
  const double alpha = rough ? 0.5 : roughness * roughness;

  const auto add = [&](const auto& kind, const MaterialTexturesDescription& varying) {
    scene_.materials.push_back({kind, where_, varying});
    return scene_.materials.size() - 1;
  };
  const auto mixed = [&](std::size_t first, std::size_t second, const TextureHandle& amount) {
    return add(MixDescription{first, second, amount}, {});
  };
  const auto smooth = [](double a) { return a < 1e-3 ? 0.0 : a; };
  const auto dielectric_part = [&] { return add(CoatedDiffuseDescription{base, smooth(alpha), ior}, textures); };
  const auto metallic_part = [&] {
    const Rgb r = glm::min(base, Rgb(0.9999));
    return add(ConductorDescription{Rgb(1), 2.0 * glm::sqrt(r) / glm::sqrt(1.0 - r), smooth(alpha)}, textures);
  };
  MadeMaterial result;
  if (metallic == 0 || (metal && metal->upper().x == 0.0F))
    result.number = dielectric_part();
  else if (!metal && metallic == 1)
    result.number = metallic_part();
  else
    result.number =
        mixed(dielectric_part(), metallic_part(), metal ? Tex::product(metal, constant(metallic)) : constant(metallic));
  diagnostics_.note(
      where_,
      "metallic-roughness becomes a diffuse lobe under a glossy coat, a metal, or one of the two point by "
      "point");
  if (transmission > 0) {
    if (base != Rgb(1) || textures.color) unsupported("material " + in_quotes(material.name) + ": coloured glass");
    MaterialTexturesDescription clear = textures;
    clear.color = nullptr;
    const std::size_t glass = add(DielectricDescription{ior, smooth(alpha)}, clear);
    result.number = transmission == 1 ? glass : mixed(result.number, glass, constant(transmission));
    result.absorption = volume_of(material);
    if (result.absorption && transmission != 1) {
      unsupported("material " + in_quotes(material.name) + ": a volume behind a surface that transmits in part");
      result.absorption.reset();
    }
  }

  double strength = 1;
  if (const auto* extension = extension_of(material, "KHR_materials_emissive_strength"))
    strength = number_in(*extension, "emissiveStrength", 1);
  Rgb emission = glm::max(color_of(material.emissiveFactor, Rgb(0)) * strength, Rgb(0));
  const auto& glow = material.emissiveTexture;
  if (const auto image = texture(glow.index, glow.texCoord, glow.extensions, Use::color); image && emission != Rgb(0)) {
    if (!image->is_constant() && image->lower() != image->upper())
      unsupported("material " + in_quotes(material.name) + ": a texture of emission; its mean is used");
    emission *= image->mean();
  }
  if (emission != Rgb(0)) result.emission = EmissionDescription{emission, material.doubleSided};

  const double base_alpha = model.baseColorFactor.size() == 4 ? model.baseColorFactor[3] : 1;
  if (material.alphaMode != "OPAQUE" && !material.alphaMode.empty()) {
    const bool is_mask = material.alphaMode == "MASK";
    TextureHandle image = texture(base_image.index, base_image.texCoord, base_image.extensions, Use::alpha,
                                  is_mask ? std::optional(material.alphaCutoff) : std::nullopt, base_alpha);
    if (!image)
      image = constant(!is_mask ? base_alpha : base_alpha >= material.alphaCutoff ? 1 : 0);
    else if (!is_mask)
      image = Tex::product(image, constant(base_alpha));
    if (image->lower().x < 1.0F) result.opacity = image;
    if (result.opacity && result.absorption) {
      unsupported("material " + in_quotes(material.name) + ": a volume with alpha");
      result.opacity = nullptr;
    }
    if (result.opacity && result.emission) {
      unsupported("material " + in_quotes(material.name) + ": a light with alpha");
      result.opacity = nullptr;
    }
  }
  result.uv_set = std::max(uv_set_, 0);
  return result;
}

}  // namespace gmis::tools::gltf
