#include "support/gltf/materials.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <limits>
#include <utility>

namespace gmis::tools::gltf {
namespace {

using Tex = scene::Texture<float>;

constexpr const char* or_cut = ": correct it (with --lenient it is cut)";

TextureHandle constant(double value) {
  return Tex::constant(glm::dvec3(value));
}

double smooth(double alpha) {
  return alpha < 1e-3 ? 0.0 : alpha;
}

/// All textures of a material.
std::vector<const Json*> textures_in(const Json& material) {
  std::vector<const Json*> found;
  const auto look = [&](const Json& object, std::initializer_list<const char*> names) {
    for (const char* name : names)
      if (const Json& info = Document::member(object, name); info.is_object()) found.push_back(&info);
  };
  look(Document::member(material, "pbrMetallicRoughness"), {"baseColorTexture", "metallicRoughnessTexture"});
  look(material, {"normalTexture", "emissiveTexture"});
  look(Document::extension(material, "KHR_materials_pbrSpecularGlossiness"),
       {"diffuseTexture", "specularGlossinessTexture"});
  look(Document::extension(material, "KHR_materials_transmission"), {"transmissionTexture"});
  return found;
}

/// One channel of an image whose values are linear, as grey.
std::shared_ptr<const scene::TextureImage> channel_of(const scene::TextureImage& image, int channel) {
  auto result = std::make_shared<scene::TextureImage>();
  result->resolution = image.resolution;
  result->channels = 1;
  for (int y = 0; y < image.resolution.y; ++y)
    for (int x = 0; x < image.resolution.x; ++x) result->floats.push_back(image.texel(x, y)[channel]);
  return result;
}

/// Normals that are turned further from or nearer to the shading normal: x and y of 2 c − 1 times
/// `scale`.
std::shared_ptr<const scene::TextureImage> scaled_normals(const scene::TextureImage& image, double scale) {
  auto result = std::make_shared<scene::TextureImage>();
  result->resolution = image.resolution;
  const auto s = static_cast<float>(scale);
  for (int y = 0; y < image.resolution.y; ++y)
    for (int x = 0; x < image.resolution.x; ++x) {
      const glm::vec3 c = image.texel(x, y);
      for (const float value : {(c.x - 0.5F) * s + 0.5F, (c.y - 0.5F) * s + 0.5F, c.z}) result->floats.push_back(value);
    }
  return result;
}

double brightness(const glm::dvec3& c) {
  return std::sqrt(0.299 * c.x * c.x + 0.587 * c.y * c.y + 0.114 * c.z * c.z);
}

/// The share of light that a smooth dielectric reflects head on, and the index that reflects a
/// share.
double head_on(double ior) {
  return square((ior - 1) / (ior + 1));
}
double ior_of(double reflectance) {
  const double root = std::min(std::sqrt(reflectance), 0.98);  // an index of 99
  return (1 + root) / (1 - root);
}

/// A dielectric coat: its index, and factors of its reflection.
struct Reflection {
  double ior;
  Rgb factors;
};

/// KHR_materials_specular: reflectances head on of min(F color, 1) · factor, F by the index.
/// Colours above 1 raise the index.
Reflection reflection_of(double ior, const Rgb& color, double factor) {
  const double reflectance = head_on(ior), most = reflectance * max_channel(color);
  if (!(most > reflectance)) return {ior, glm::min(color, Rgb(1)) * factor};
  const double raised = ior_of(std::min(most, 1.0));
  return {raised, glm::min(color * (reflectance / head_on(raised)), Rgb(1)) * factor};
}

struct MetalOf {
  glm::dvec3 base;
  double metallic;
};

/// Metallic-roughness of a diffuse and a specular colour, as Khronos's convertPbr.js has it: the
/// metalness m that solves 0.04 m² + (d (1 − s)/0.96 + s − 0.08) m + 0.04 − s = 0 for their
/// brightnesses d and s.
MetalOf metal_of(const glm::dvec3& diffuse, const glm::dvec3& specular) {
  constexpr double plastic = 0.04, tiny = 1e-6;
  const double rest = 1 - std::max({specular.x, specular.y, specular.z});
  const double d = brightness(diffuse), s = brightness(specular);
  double metallic = 0;
  if (s >= plastic) {
    const double b = d * rest / (1 - plastic) + s - 2 * plastic, c = plastic - s;
    metallic = std::clamp((-b + std::sqrt(std::max(0.0, b * b - 4 * plastic * c))) / (2 * plastic), 0.0, 1.0);
  }
  const glm::dvec3 by_diffuse = diffuse * (rest / (1 - plastic) / std::max(1 - metallic, tiny));
  const glm::dvec3 by_specular = (specular - plastic * (1 - metallic)) / std::max(metallic, tiny);
  return {glm::clamp(glm::mix(by_diffuse, by_specular, metallic * metallic), glm::dvec3(0), glm::dvec3(1)), metallic};
}

}  // namespace

const Json& Materials::json_of(std::optional<std::size_t> number) const {
  static const Json standard = Json::object();
  return number ? document_.entry("materials", *number, "a primitive") : standard;
}

namespace {

std::size_t set_of(const Document& document, const Json& info) {
  const auto moved = document.index(Document::extension(info, "KHR_texture_transform"), "texCoord");
  return moved ? *moved : document.index(info, "texCoord").value_or(0);
}

}  // namespace

std::set<std::size_t> Materials::coordinate_sets(std::optional<std::size_t> number) const {
  std::set<std::size_t> sets;
  for (const Json* info : textures_in(json_of(number))) sets.insert(set_of(document_, *info));
  return sets;
}

std::optional<std::size_t> Materials::normal_map_set(std::optional<std::size_t> number) const {
  const Json& info = Document::member(json_of(number), "normalTexture");
  return info.is_object() ? std::optional(set_of(document_, info)) : std::nullopt;
}

bool Materials::is_unlit(std::optional<std::size_t> number) const {
  return Document::extension(json_of(number), "KHR_materials_unlit").is_object();
}

const MadeMaterial& Materials::at(std::optional<std::size_t> number) {
  const auto found = made_.find(number);
  if (found != made_.end()) return found->second;
  return made_[number] = made(number, {});
}

double Materials::share(const Json& object, const char* name, double otherwise) {
  const double value = document_.number(object, name, otherwise);
  if (!(value >= 0 && value <= 1)) unsupported(name_ + ": " + name + " must be from 0 to 1" + or_cut);
  return std::clamp(value, 0.0, 1.0);
}

Rgb Materials::color(const Json& object, const char* name, const Rgb& otherwise, double most) {
  const auto list = document_.numbers(object, name, {otherwise.x, otherwise.y, otherwise.z});
  const Rgb value(list[0], list[1], list[2]);
  for (const double c : list)
    if (!(c >= 0 && c <= most))
      unsupported(name_ + ": " + name + (c < 0 ? " is negative" : " is above its limit") + or_cut);
  return glm::clamp(value, Rgb(0), Rgb(most));
}

std::size_t Materials::add(const decltype(MaterialDescription::kind)& kind,
                           const MaterialTexturesDescription& varying) {
  scene_.materials.push_back({kind, document_.where(), varying});
  return scene_.materials.size() - 1;
}

TextureHandle Materials::tinted(const TextureHandle& image, const Rgb& factor) const {
  if (!image) return nullptr;
  return factor == Rgb(1) ? image : Tex::product(image, Tex::constant(factor));
}

std::shared_ptr<const scene::TextureImage> Materials::pixels(std::size_t number, Use use, double normal_scale) {
  const auto key = std::tuple(number, use, normal_scale);
  if (const auto found = pixels_.find(key); found != pixels_.end()) return found->second;
  const Document::ImageFile file = document_.image(number);
  TextureEncoding encoding;
  if (use != Use::color) encoding.curve = TextureEncoding::Curve::linear;
  auto read = read_texture_image(reinterpret_cast<const unsigned char*>(file.bytes.data()), file.bytes.size(),
                                 file.name, encoding, use == Use::alpha ? TexturePart::alpha : TexturePart::color,
                                 document_.budget(), document_.where());
  const std::map<Use, int> channels{{Use::red, 0}, {Use::green, 1}, {Use::blue, 2}};
  const bool is_copied = channels.contains(use) || (use == Use::normal && normal_scale != 1);
  if (is_copied)
    document_.budget().take(
        static_cast<std::uintmax_t>(read->resolution.x) * static_cast<std::uintmax_t>(read->resolution.y), 12,
        file.name, document_.where());
  if (const auto channel = channels.find(use); channel != channels.end()) read = channel_of(*read, channel->second);
  if (use == Use::normal && normal_scale != 1) read = scaled_normals(*read, normal_scale);
  return pixels_[key] = read;
}

TextureHandle Materials::texture(const Json& info, Use use, double normal_scale) {
  if (!info.is_object()) return nullptr;
  const auto number = document_.index(info, "index");
  if (!number) throw document_.error(name_ + " has a texture without an index");
  const Json& description = document_.entry("textures", *number, name_);
  scene::TexturePlacement placement;
  if (const Json& moved = Document::extension(info, "KHR_texture_transform"); moved.is_object()) {
    const auto scale = document_.numbers(moved, "scale", {1, 1}), offset = document_.numbers(moved, "offset", {0, 0});
    const double turn = document_.number(moved, "rotation", 0), c = std::cos(turn), n = std::sin(turn);
    // glTF counts t from the top, t = 1 − v, and turns counter-clockwise as it is seen:
    // s' = c sx s + n sy t + ox, t' = −n sx s + c sy t + oy.
    placement.scale = {c * scale[0], c * scale[1]};
    placement.cross = {-n * scale[1], n * scale[0]};
    placement.offset = {offset[0] + n * scale[1], 1 - c * scale[1] - offset[1]};
  }
  std::array wrap{scene::TextureWrap::repeat, scene::TextureWrap::repeat};
  scene::TextureFilter filter = scene::TextureFilter::bilinear;
  if (const auto place = document_.index(description, "sampler")) {
    const Json& sampler = document_.entry("samplers", *place, "texture " + std::to_string(*number));
    constexpr double clamp = 33071, mirror = 33648, nearest = 9728;
    const char* const names[] = {"wrapS", "wrapT"};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double mode = document_.number(sampler, names[axis], 10497);
      wrap[axis] = mode == clamp    ? scene::TextureWrap::clamp
                   : mode == mirror ? scene::TextureWrap::mirror
                                    : scene::TextureWrap::repeat;
    }
    if (document_.number(sampler, "magFilter", 0) == nearest) filter = scene::TextureFilter::nearest;
  }
  try {
    const auto source = document_.index(description, "source");
    if (!source) throw document_.error(name_ + " has a texture without an image in a format that is read (.png, .jpg)");
    const TextureHandle image = Tex::image(pixels(*source, use, normal_scale), placement, wrap, filter);
    return layout_->over ? layout_->over(set_of(document_, info), image) : image;
  } catch (const std::invalid_argument& error) {
    throw document_.error(name_ + ": " + error.what());
  } catch (const InputError& error) {
    unsupported(error.message());  // ends the reading unless --lenient goes on
    return use == Use::color ? constant(0.5) : nullptr;
  }
}

const std::set<std::string>& Materials::understood_extensions() {
  static const std::set<std::string> understood{"KHR_materials_transmission",
                                                "KHR_materials_ior",
                                                "KHR_materials_emissive_strength",
                                                "KHR_materials_volume",
                                                "KHR_materials_specular",
                                                "KHR_materials_unlit",
                                                "KHR_materials_pbrSpecularGlossiness",
                                                "KHR_materials_clearcoat",
                                                "KHR_materials_anisotropy",
                                                "KHR_materials_variants",
                                                "KHR_materials_dispersion"};
  return understood;
}

void Materials::refuse_extensions(const Json& material) {
  const Json& all = Document::member(material, "extensions");
  if (!all.is_object()) return;
  for (const auto& [name, value] : all.items()) {
    if (understood_extensions().contains(name)) continue;
    if (name == "KHR_materials_sheen" && color(value, "sheenColorFactor", Rgb(0), 1) == Rgb(0)) continue;
    if (name == "KHR_materials_iridescence" && document_.number(value, "iridescenceFactor", 0) == 0) continue;
    if (name == "KHR_materials_diffuse_transmission" && document_.number(value, "diffuseTransmissionFactor", 0) == 0)
      continue;
    if (name.starts_with("KHR_materials_") || name.starts_with("EXT_materials_"))
      unsupported(name_ + ": " + name + ", which is left out with --lenient");
    else
      note(name_ + ": " + name + " is ignored");
  }
  if (Document::member(all, "KHR_materials_anisotropy").is_object())
    diagnostics_.warning(document_.where(), name_ + ": anisotropic roughness is not supported, that across is used");
  if (Document::member(all, "KHR_materials_dispersion").is_object())
    note(name_ + ": glass has one index of refraction here: no dispersion");
}

Materials::Layers Materials::metallic_roughness(const Json& material) {
  const Json& model = Document::member(material, "pbrMetallicRoughness");
  Layers layers;
  const auto base = document_.numbers(model, "baseColorFactor", {1, 1, 1, 1});
  for (const double c : base)
    if (!(c >= 0 && c <= 1)) unsupported(name_ + ": baseColorFactor must be from 0 to 1" + or_cut);
  layers.base = glm::clamp(Rgb(base[0], base[1], base[2]), Rgb(0), Rgb(1));
  layers.alpha = std::clamp(base[3], 0.0, 1.0);
  layers.metallic = share(model, "metallicFactor", 1);
  layers.roughness = share(model, "roughnessFactor", 1);
  const Json& image = Document::member(model, "baseColorTexture");
  layers.color = texture(image, Use::color);
  const std::string mode = document_.text(material, "alphaMode", "OPAQUE");
  if (mode != "OPAQUE") layers.opacity = texture(image, Use::alpha);
  const Json& both = Document::member(model, "metallicRoughnessTexture");
  layers.rough = texture(both, Use::green);
  layers.metal = texture(both, Use::blue);
  return layers;
}

Materials::Layers Materials::specular_glossiness(const Json& packed) {
  Layers layers;
  const auto diffuse = document_.numbers(packed, "diffuseFactor", {1, 1, 1, 1});
  const Rgb diffuse_factor = glm::clamp(Rgb(diffuse[0], diffuse[1], diffuse[2]), Rgb(0), Rgb(1));
  const Rgb specular_factor = color(packed, "specularFactor", Rgb(1), 1);
  const double glossiness = share(packed, "glossinessFactor", 1);
  layers.alpha = std::clamp(diffuse[3], 0.0, 1.0);
  const Json &diffuse_info = Document::member(packed, "diffuseTexture"),
             &specular_info = Document::member(packed, "specularGlossinessTexture");
  const TextureHandle diffuse_image = texture(diffuse_info, Use::color);
  layers.opacity = texture(diffuse_info, Use::alpha);
  const TextureHandle specular_image = texture(specular_info, Use::color);
  const TextureHandle gloss_image = texture(specular_info, Use::alpha);
  note(name_ + ": specular-glossiness becomes the metallic-roughness that is nearest to it");
  layers.roughness = 1 - glossiness;
  if (gloss_image) {
    layers.roughness = 1;
    layers.rough = Tex::mix(constant(1), constant(0), tinted(gloss_image, Rgb(glossiness)));
  }
  if (!specular_image) {
    const MetalOf whole =
        metal_of(diffuse_factor * (diffuse_image ? Rgb(diffuse_image->mean()) : Rgb(1)), specular_factor);
    layers.metallic = whole.metallic;
    layers.base = diffuse_image ? diffuse_factor : whole.base;
    layers.color = diffuse_image;
    return layers;
  }
  // Resampled to 1024 × 1024 texels, over the coordinates of the specular image.
  constexpr int side = 1024;
  document_.budget().take(std::uintmax_t{side} * side, 4 * sizeof(float), name_ + ", converted,", document_.where());
  auto base = std::make_shared<scene::TextureImage>(), metal = std::make_shared<scene::TextureImage>();
  base->resolution = metal->resolution = {side, side};
  metal->channels = 1;
  const SurfaceLayout* const layout = std::exchange(layout_, nullptr);
  static const SurfaceLayout plain;
  layout_ = &plain;
  const TextureHandle flat_diffuse = texture(diffuse_info, Use::color),
                      flat_specular = texture(specular_info, Use::color);
  layout_ = layout;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const glm::vec2 uv((static_cast<float>(x) + 0.5F) / side, 1 - (static_cast<float>(y) + 0.5F) / side);
      const Rgb d = diffuse_factor * (flat_diffuse ? Rgb(flat_diffuse->at(uv)) : Rgb(1));
      const MetalOf here = metal_of(glm::clamp(d, Rgb(0), Rgb(1)),
                                    glm::clamp(specular_factor * Rgb(flat_specular->at(uv)), Rgb(0), Rgb(1)));
      for (int c = 0; c < 3; ++c) base->floats.push_back(static_cast<float>(here.base[c]));
      metal->floats.push_back(static_cast<float>(here.metallic));
    }
  const auto laid = [&](std::shared_ptr<const scene::TextureImage> image) {
    TextureHandle made = Tex::image(std::move(image));
    return layout_->over ? layout_->over(set_of(document_, specular_info), made) : made;
  };
  layers.color = laid(base);
  layers.metal = laid(metal);
  return layers;
}

Materials::Finish Materials::finish_of(const Json& material, const Layers& layers) {
  Finish finish;
  finish.ior = document_.number(Document::extension(material, "KHR_materials_ior"), "ior", 1.5);
  if (finish.ior == 0) {
    unsupported(name_ + ": an ior of 0 is not supported: 1.5 is used");
    finish.ior = 1.5;
  }
  if (!(finish.ior >= 1 && finish.ior < 10)) throw document_.error(name_ + " has an ior that is not from 1 to 10");
  finish.textures.color = tinted(layers.color, layers.base);
  if (layers.rough) {
    const TextureHandle rough = tinted(layers.rough, Rgb(layers.roughness));
    finish.textures.roughness = Tex::product(rough, rough);  // α is its square
  }
  const Json& normals = Document::member(material, "normalTexture");
  finish.textures.normal_map = texture(normals, Use::normal, document_.number(normals, "scale", 1));
  finish.alpha = smooth(layers.rough ? 0.5 : layers.roughness * layers.roughness);
  return finish;
}

std::size_t Materials::surface_of(const Json& material, const Layers& layers,
                                  std::optional<AbsorptionDescription>& absorption) {
  const Finish finish = finish_of(material, layers);
  const MaterialTexturesDescription& textures = finish.textures;
  Reflection reflection{finish.ior, Rgb(1)};
  if (const Json& extension = Document::extension(material, "KHR_materials_specular"); extension.is_object()) {
    const Rgb factors = color(extension, "specularColorFactor", Rgb(1), std::numeric_limits<double>::infinity());
    reflection = reflection_of(finish.ior, factors, share(extension, "specularFactor", 1));
    for (const char* name : {"specularTexture", "specularColorTexture"})
      if (Document::member(extension, name).is_object())
        unsupported(name_ + ": a texture of KHR_materials_specular: its factor is used alone");
  }
  const Json& coat = Document::extension(material, "KHR_materials_clearcoat");
  const double coat_share = share(coat, "clearcoatFactor", 0);
  const double coat_alpha = std::pow(share(coat, "clearcoatRoughnessFactor", 0), 2);
  if (coat_share > 0)
    for (const char* name : {"clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"})
      if (Document::member(coat, name).is_object())
        unsupported(name_ + ": " + name + " of KHR_materials_clearcoat: its factors are used alone");
  const auto matte_part = [&] {
    const std::size_t bare =
        add(CoatedDiffuseDescription{layers.base, finish.alpha, reflection.ior, reflection.factors}, textures);
    if (!(coat_share > 0)) return bare;
    // The clear coat merges with the dielectric coat of the base: only the outer surface remains,
    // which reflects as much as the stronger of the two.
    MaterialTexturesDescription under = textures;
    under.roughness = nullptr;
    const double ior = std::max(ior_of(head_on(reflection.ior) * max_channel(reflection.factors)), 1.5);
    const std::size_t coated = add(CoatedDiffuseDescription{layers.base, smooth(coat_alpha), ior, Rgb(1)}, under);
    return coat_share == 1 ? coated : add(MixDescription{bare, coated, constant(coat_share)});
  };
  const Json& extension = Document::extension(material, "KHR_materials_transmission");
  const double transmission = share(extension, "transmissionFactor", 0);
  const auto dielectric_part = [&] {
    if (!(transmission > 0)) return matte_part();
    const TextureHandle where = texture(Document::member(extension, "transmissionTexture"), Use::red);
    if (coat_share > 0) unsupported(name_ + ": a clear coat over glass, which is left out with --lenient");
    absorption = volume_of(material);
    const std::size_t glass = glass_of(material, layers, finish);
    if (transmission == 1 && !where) return glass;
    return add(MixDescription{matte_part(), glass, where ? tinted(where, Rgb(transmission)) : constant(transmission)});
  };
  const auto metallic_part = [&] {
    const Rgb r = glm::min(layers.base, Rgb(0.9999));
    const Rgb k = 2.0 * glm::sqrt(r) / glm::sqrt(1.0 - r);
    const std::size_t bare = add(ConductorDescription{Rgb(1), k, finish.alpha}, textures);
    if (!(coat_share > 0)) return bare;
    MaterialTexturesDescription under = textures;
    if (textures.color || textures.roughness) {
      unsupported(name_ + ": a clear coat over a metal with textures, which is left out with --lenient");
      return bare;
    }
    const std::size_t coated = add(CoatedConductorDescription{Rgb(1), k, finish.alpha, 1.5, smooth(coat_alpha)}, under);
    return coat_share == 1 ? coated : add(MixDescription{bare, coated, constant(coat_share)});
  };
  if (coat_share > 0) note(name_ + ": a clear coat of index 1.5 joins a dielectric base, and lies over a metal");
  note("metallic-roughness becomes a diffuse lobe under a glossy coat, a metal, or one of the two point by point");
  if (layers.metallic == 1 && (!layers.metal || layers.metal->lower().x >= 1.0F)) return metallic_part();
  std::size_t result = dielectric_part();
  if (layers.metallic > 0 && !(layers.metal && layers.metal->upper().x == 0.0F))
    result = add(MixDescription{result, metallic_part(),
                                layers.metal ? tinted(layers.metal, Rgb(layers.metallic)) : constant(layers.metallic)});
  if (absorption && !std::holds_alternative<DielectricDescription>(scene_.materials[result].kind)) {
    unsupported(name_ + ": a volume behind a surface that transmits in part: it is clear with --lenient");
    absorption.reset();
  }
  return result;
}

bool Materials::has_thickness(const Json& material) const {
  return document_.number(Document::extension(material, "KHR_materials_volume"), "thicknessFactor", 0) > 0;
}

std::optional<AbsorptionDescription> Materials::volume_of(const Json& material) {
  // Without a thickness the surface is a thin wall, which absorbs nothing. The mesh itself gives
  // the thickness.
  if (!has_thickness(material)) return {};
  const Json& volume = Document::extension(material, "KHR_materials_volume");
  const double distance = document_.number(volume, "attenuationDistance", std::numeric_limits<double>::infinity());
  if (!(distance > 0)) throw document_.error(name_ + " has an attenuationDistance that is not above 0");
  constexpr double blackest = 1e-12;  // black glass: as good as none gets through
  const Rgb tint = glm::clamp(color(volume, "attenuationColor", Rgb(1), 1), Rgb(blackest), Rgb(1));
  const Rgb sigma = -glm::log(tint) / distance;
  if (sigma == Rgb(0)) return {};
  return AbsorptionDescription{sigma, Rgb(0)};
}

std::size_t Materials::glass_of(const Json& material, const Layers& layers, Finish finish) {
  DielectricDescription glass{finish.ior, finish.alpha, layers.base};
  glass.is_thin = !has_thickness(material);
  // Where the index hardly bends light, roughness changes nothing, and there is no lobe for a
  // texture of it.
  if (glass.alpha * std::abs(glass.eta - 1) < 1e-4) finish.textures.roughness = nullptr;
  if (glass.is_thin) {
    const double roughness = layers.roughness * (layers.rough ? double(layers.rough->upper().x) : 1);
    if (smooth(roughness * roughness) * std::abs(glass.eta - 1) >= 1e-4)
      unsupported(name_ + ": rough glass without a thickness: give it a thicknessFactor (it is smooth with --lenient)");
    glass.alpha = 0;
    finish.textures.roughness = nullptr;
  }
  return add(glass, finish.textures);
}

std::optional<EmissionDescription> Materials::emission_of(const Json& material) {
  constexpr double brightest = 1e20;
  const double strength =
      document_.number(Document::extension(material, "KHR_materials_emissive_strength"), "emissiveStrength", 1);
  if (!(strength >= 0 && strength <= brightest))
    throw document_.error(name_ + " has an emissiveStrength that is negative or above 1e20");
  const Rgb radiance = color(material, "emissiveFactor", Rgb(0), brightest) * strength;
  if (!(std::max({radiance.x, radiance.y, radiance.z}) <= brightest))
    throw document_.error(name_ + " emits more than 1e20");
  if (radiance == Rgb(0)) return {};
  const Json& sided = Document::member(material, "doubleSided");
  EmissionDescription emission{radiance, sided.is_boolean() && sided.get<bool>(), nullptr};
  emission.texture = texture(Document::member(material, "emissiveTexture"), Use::color);
  if (emission.texture && emission.texture->upper() == glm::vec3(0)) return {};
  return emission;
}

TextureHandle Materials::opacity_of(const Json& material, const Layers& layers) {
  const std::string mode = document_.text(material, "alphaMode", "OPAQUE");
  if (mode == "OPAQUE") return nullptr;
  TextureHandle opacity = layers.opacity ? tinted(layers.opacity, Rgb(layers.alpha)) : constant(layers.alpha);
  if (layout_->vertex_alpha) opacity = Tex::product(opacity, layout_->vertex_alpha);
  if (mode == "MASK") opacity = Tex::threshold(opacity, document_.number(material, "alphaCutoff", 0.5));
  return opacity->lower().x < 1.0F ? opacity : nullptr;
}

MadeMaterial Materials::made(std::optional<std::size_t> number, const SurfaceLayout& layout) {
  const Json& material = json_of(number);
  layout_ = &layout;
  name_ = number ? document_.named("material", material, *number) : "the default material";
  refuse_extensions(material);
  const Json& old_model = Document::extension(material, "KHR_materials_pbrSpecularGlossiness");
  Layers layers = old_model.is_object() ? specular_glossiness(old_model) : metallic_roughness(material);
  if (layout.vertex_color)
    layers.color = layers.color ? Tex::product(layers.color, layout.vertex_color) : layout.vertex_color;

  MadeMaterial result;
  result.opacity = opacity_of(material, layers);
  if (is_unlit(number)) {
    result.number = add(DiffuseDescription{Rgb(0)});
    if (layers.base != Rgb(0)) result.emission = EmissionDescription{layers.base, true, layers.color};
    note(name_ + ": an unlit surface emits its colour, and lights what is around it");
    return result;
  }
  result.number = surface_of(material, layers, result.absorption);
  result.emission = emission_of(material);
  if (result.opacity && result.absorption) {
    unsupported(name_ + ": a volume with alpha: it has no holes with --lenient");
    result.opacity = nullptr;
  }
  return result;
}

}  // namespace gmis::tools::gltf
