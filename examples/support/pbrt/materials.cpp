#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <set>

#include "support/image/texture_image.hpp"
#include "support/pbrt/elements.hpp"
#include "support/pbrt/spectra.hpp"

namespace gmis::tools::pbrt {
namespace {

Rgb reflectance_or(Parameters& parameters, const std::string& name, const Rgb& otherwise, Diagnostics& diagnostics) {
  const Rgb value = parameters.color(name).value_or(otherwise);
  if (value.x < 0 || value.y < 0 || value.z < 0) parameters.fail(name, "is negative: use values from 0 to 1");
  if (value.x > 1 || value.y > 1 || value.z > 1) {
    diagnostics.warning(parameters.where(),
                        parameters.directive() + ": parameter " + in_quotes(name) + " is above 1 and is cut to 1");
    return glm::min(value, Rgb(1));
  }
  return value;
}

/// `reflectance_or`, for a reflectance that may vary over the surface: then `texture` is set, and
/// the value is the mean.
Rgb reflectance_or(Parameters& parameters, const std::string& name, const Rgb& otherwise, Diagnostics& diagnostics,
                   TextureHandle& texture) {
  if (!parameters.varies(name)) return reflectance_or(parameters, name, otherwise, diagnostics);
  texture = *parameters.color_texture(name);
  return glm::clamp(Rgb(texture->mean()), Rgb(0), Rgb(1));
}

/// GGX alpha, 0 for a smooth surface, of parameters that begin with `prefix`.
double layer_alpha(Parameters& parameters, Diagnostics& diagnostics, const std::string& prefix = "") {
  constexpr double specular_below = 1e-3;
  const double roughness = parameters.number_or(prefix + "roughness", 0);
  const double u = parameters.number_or(prefix + "uroughness", roughness);
  const double v = parameters.number_or(prefix + "vroughness", roughness);
  if (u < 0 || v < 0 || roughness < 0) parameters.fail(prefix + "roughness", "is negative: use values from 0 to 1");
  if (u > 1 || v > 1)
    diagnostics.warning(parameters.where(), parameters.directive() + ": a roughness above 1 is cut to 1");
  if (u != v)
    diagnostics.warning(parameters.where(),
                        parameters.directive() + ": anisotropic roughness is not supported, the mean of both is used");
  const double mean = (std::min(u, 1.0) + std::min(v, 1.0)) / 2;
  const double alpha = parameters.boolean_or("remaproughness", true) ? std::sqrt(mean) : mean;
  return alpha < specular_below ? 0 : alpha;
}

/// `layer_alpha`, for a roughness that may vary over the surface: then `textures` has it, and the
/// value is any alpha of a rough surface.
double alpha_of(Parameters& parameters, Diagnostics& diagnostics, MaterialTexturesDescription& textures) {
  const char* varying = nullptr;
  for (const char* name : {"roughness", "uroughness", "vroughness"})
    if (varying == nullptr && parameters.varies(name)) varying = name;
  if (varying == nullptr) return layer_alpha(parameters, diagnostics);
  textures.roughness = *parameters.number_texture(varying);
  textures.is_remapped = parameters.boolean_or("remaproughness", true);
  for (const char* name : {"roughness", "uroughness", "vroughness"}) {
    const auto other = parameters.number_texture(name);
    if (other && *other != textures.roughness)
      diagnostics.warning(parameters.where(), parameters.directive() + ": anisotropic roughness is not supported, " +
                                                  in_quotes(varying) + " is used both ways");
  }
  return 0.5;
}

double index_of_refraction(Parameters& parameters, Diagnostics& diagnostics, double otherwise,
                           const char* name = "eta") {
  double eta = otherwise;
  if (parameters.is_spectrum(name)) {
    eta = parameters.color(name)->y;
    diagnostics.note(parameters.where(), "glass has one index of refraction here, that of yellow light: no dispersion");
  } else {
    eta = parameters.number_or(name, otherwise);
  }
  if (!(eta > 0.1 && eta < 10)) parameters.fail(name, "must be between 0.1 and 10");
  return eta;
}

/// The index of a metal, whose parameters begin with `prefix`.
void read_metal(Parameters& parameters, Diagnostics& diagnostics, const std::string& prefix, Rgb& eta, Rgb& k,
                TextureHandle* texture) {
  const std::string reflectance = "reflectance";
  const std::string eta_name = prefix + "eta", k_name = prefix + "k";
  if (parameters.has(reflectance)) {
    if (parameters.has(eta_name) || parameters.has(k_name))
      parameters.fail(reflectance, "cannot stand beside eta and k: give one or the other");
    // eta = 1 and the k that gives this reflectance head on.
    const Rgb value = texture != nullptr ? reflectance_or(parameters, reflectance, Rgb(0), diagnostics, *texture)
                                         : reflectance_or(parameters, reflectance, Rgb(0), diagnostics);
    const Rgb r = glm::min(value, Rgb(0.9999));
    eta = Rgb(1);
    k = 2.0 * glm::sqrt(r) / glm::sqrt(1.0 - r);
    return;
  }
  eta = parameters.color(eta_name).value_or(*named_spectrum("metal-Cu-eta"));
  k = parameters.color(k_name).value_or(*named_spectrum("metal-Cu-k"));
  for (int c = 0; c < 3; ++c) {
    if (!(eta[c] > 0 && eta[c] < 100)) parameters.fail(eta_name, "must be above 0 and below 100");
    if (!(k[c] >= 0 && k[c] < 100)) parameters.fail(k_name, "must be from 0 to 100");
  }
}

ConductorDescription make_conductor(Parameters& parameters, Diagnostics& diagnostics,
                                    MaterialTexturesDescription& textures) {
  ConductorDescription result;
  read_metal(parameters, diagnostics, "", result.eta, result.k, &textures.color);
  result.alpha = alpha_of(parameters, diagnostics, textures);
  return result;
}

CoatedConductorDescription make_coated_conductor(Parameters& parameters, Diagnostics& diagnostics) {
  CoatedConductorDescription result;
  read_metal(parameters, diagnostics, "conductor.", result.eta, result.k, nullptr);
  result.alpha = layer_alpha(parameters, diagnostics, "conductor.");
  result.coat_alpha = layer_alpha(parameters, diagnostics, "interface.");
  result.coat_eta = index_of_refraction(parameters, diagnostics, 1.5, "interface.eta");
  if (result.coat_eta < 1) parameters.fail("interface.eta", "of a coat must be at least 1");
  if (parameters.has("albedo") && parameters.color("albedo") != Rgb(0))
    parameters.unsupported("albedo", "is not supported: the coat is clear", diagnostics);
  parameters.ignore({"thickness", "g", "maxdepth", "nsamples", "interface.thickness"});
  diagnostics.note(parameters.where(),
                   "coatedconductor becomes a glossy lobe over another; light between the two is summed as for smooth "
                   "layers");
  return result;
}

PhongDescription make_phong(Parameters& parameters, Diagnostics& diagnostics, MaterialTexturesDescription& textures) {
  PhongDescription result;
  result.reflectance = reflectance_or(parameters, "reflectance", Rgb(0.5), diagnostics, textures.color);
  result.specular = reflectance_or(parameters, "specular", Rgb(0), diagnostics);
  result.exponent = parameters.number_or("exponent", 1);
  if (!(result.exponent >= 0 && result.exponent <= 1e6)) parameters.fail("exponent", "must be from 0 to 1000000");
  const Rgb sum = result.reflectance + result.specular;
  if (sum.x > 1 + 1e-6 || sum.y > 1 + 1e-6 || sum.z > 1 + 1e-6)
    diagnostics.warning(parameters.where(),
                        parameters.directive() + ": reflectance and specular add up to more than 1");
  return result;
}

/// Null where none is given, and with --lenient where the image cannot be used.
TextureHandle normal_map_of(Parameters& parameters, const Files& files, Diagnostics& diagnostics) {
  const std::optional<std::string> file = parameters.string("normalmap");
  if (!file) return nullptr;
  TextureEncoding encoding;
  encoding.curve = TextureEncoding::Curve::linear;
  const SourcePosition& where = parameters.where("normalmap");
  try {
    return scene::Texture<float>::image(
        read_texture_image(files.find(*file), encoding, TexturePart::color, *files.budget, where));
  } catch (const std::invalid_argument& error) {
    diagnostics.unsupported(where, in_quotes(*file) + ": " + error.what());
  } catch (const InputError& error) {
    diagnostics.unsupported(where, error.message());
  }
  return nullptr;
}

DiffuseTransmissionDescription make_diffuse_transmission(Parameters& parameters, Diagnostics& diagnostics,
                                                         MaterialTexturesDescription& textures) {
  const double scale = parameters.number_or("scale", 1);
  if (!(scale >= 0 && scale <= 1e6)) parameters.fail("scale", "must be from 0 to 1000000");
  const auto scaled = [&](const char* name, TextureHandle& texture) {
    const Rgb value = reflectance_or(parameters, name, Rgb(0.25), diagnostics, texture) * scale;
    if (texture && scale != 1)
      texture = scene::Texture<float>::product(texture, scene::Texture<float>::constant(glm::dvec3(scale)));
    if (!texture && (value.x > 1 || value.y > 1 || value.z > 1))
      diagnostics.warning(parameters.where(), parameters.directive() + ": parameter " + in_quotes(name) +
                                                  " times \"scale\" is above 1 and is cut to 1");
    return glm::min(value, Rgb(1));
  };
  DiffuseTransmissionDescription sheet;
  sheet.reflectance = scaled("reflectance", textures.color);
  sheet.transmittance = scaled("transmittance", textures.transmittance);
  return sheet;
}

}  // namespace

MaterialDescription make_material(const std::string& kind, Parameters& parameters, const Files& files,
                                  Diagnostics& diagnostics) {
  MaterialDescription result;
  result.where = parameters.where();
  MaterialTexturesDescription& textures = result.textures;
  if (const auto height = parameters.number_texture("displacement"); height && !(*height)->is_constant())
    textures.height = *height;
  textures.normal_map = normal_map_of(parameters, files, diagnostics);
  if (kind == "diffuse") {
    result.kind = DiffuseDescription{reflectance_or(parameters, "reflectance", Rgb(0.5), diagnostics, textures.color)};
  } else if (kind == "phong") {
    result.kind = make_phong(parameters, diagnostics, textures);
  } else if (kind == "mirror") {
    result.kind = MirrorDescription{reflectance_or(parameters, "reflectance", Rgb(1), diagnostics, textures.color)};
  } else if (kind == "conductor") {
    result.kind = make_conductor(parameters, diagnostics, textures);
  } else if (kind == "dielectric") {
    const double eta = index_of_refraction(parameters, diagnostics, 1.5);
    result.kind = DielectricDescription{eta, alpha_of(parameters, diagnostics, textures)};
  } else if (kind == "thindielectric") {
    result.kind = DielectricDescription{index_of_refraction(parameters, diagnostics, 1.5), 0, Rgb(1), true};
  } else if (kind == "diffusetransmission") {
    result.kind = make_diffuse_transmission(parameters, diagnostics, textures);
  } else if (kind == "coatedconductor") {
    result.kind = make_coated_conductor(parameters, diagnostics);
  } else if (kind == "coateddiffuse") {
    CoatedDiffuseDescription coated;
    coated.reflectance = reflectance_or(parameters, "reflectance", Rgb(0.5), diagnostics, textures.color);
    coated.alpha = alpha_of(parameters, diagnostics, textures);
    coated.eta = index_of_refraction(parameters, diagnostics, 1.5);
    if (coated.eta < 1) parameters.fail("eta", "of a coat must be at least 1");
    if (parameters.has("albedo") && parameters.color("albedo") != Rgb(0))
      parameters.unsupported("albedo", "is not supported: the coat is clear", diagnostics);
    parameters.ignore({"thickness", "g", "maxdepth", "nsamples"});
    diagnostics.note(parameters.where(),
                     "coateddiffuse becomes a diffuse lobe under a glossy one; light between the two is summed as for "
                     "a smooth coat");
    result.kind = coated;
  } else {
    static const std::set<std::string> of_version_3{"matte",     "plastic", "glass",       "metal",   "uber",
                                                    "substrate", "disney",  "translucent", "fourier", "kdsubsurface"};
    if (of_version_3.contains(kind))
      throw InputError(parameters.where(),
                       "the material " + in_quotes(kind) + " is of pbrt-v3: bring the scene to v4 by pbrt --upgrade");
    diagnostics.unsupported(parameters.where(),
                            "the material " + in_quotes(kind) +
                                " is not understood: use diffuse, conductor, dielectric, thindielectric, "
                                "coateddiffuse, coatedconductor, diffusetransmission, mix, phong or mirror");
    parameters.ignore_all();
    result.kind = DiffuseDescription{Rgb(0.5)};
  }
  return result;
}

}  // namespace gmis::tools::pbrt
