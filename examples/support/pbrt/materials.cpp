#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "support/pbrt/elements.hpp"

namespace gmis::tools::pbrt {
namespace {

struct NamedMetal {
  const char* name;
  Rgb eta, k;
};

// The measured spectra behind pbrt's names, brought to linear sRGB.
constexpr std::array known_metals{
    NamedMetal{"Cu", {0.200438, 0.924033, 1.10221}, {3.91295, 2.45285, 2.14219}},
    NamedMetal{"Au", {0.143119, 0.374957, 1.44248}, {3.98316, 2.38572, 1.60322}},
    NamedMetal{"Ag", {0.155265, 0.116723, 0.138381}, {4.82834, 3.12225, 2.14705}},
    NamedMetal{"Al", {1.65746, 0.880369, 0.521229}, {9.22387, 6.26952, 4.83700}},
};

struct NamedGlass {
  const char* name;
  double eta;  ///< at 587.6 nm
};

constexpr std::array known_glasses{
    NamedGlass{"glass-BK7", 1.5168},   NamedGlass{"glass-BAF10", 1.6700}, NamedGlass{"glass-FK51A", 1.4866},
    NamedGlass{"glass-LASF9", 1.8503}, NamedGlass{"glass-SF11", 1.7847},
};

std::optional<Rgb> named_metal(const std::string& name) {
  for (const NamedMetal& metal : known_metals) {
    if (name == std::string("metal-") + metal.name + "-eta") return metal.eta;
    if (name == std::string("metal-") + metal.name + "-k") return metal.k;
  }
  return {};
}

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

/// GGX alpha; 0 for a smooth surface.
double alpha_of(Parameters& parameters, Diagnostics& diagnostics) {
  constexpr double specular_below = 1e-3;
  const double roughness = parameters.number_or("roughness", 0);
  const double u = parameters.number_or("uroughness", roughness);
  const double v = parameters.number_or("vroughness", roughness);
  if (u < 0 || v < 0 || roughness < 0) parameters.fail("roughness", "is negative: use values from 0 to 1");
  if (u > 1 || v > 1)
    diagnostics.warning(parameters.where(), parameters.directive() + ": a roughness above 1 is cut to 1");
  if (u != v)
    diagnostics.warning(parameters.where(),
                        parameters.directive() + ": anisotropic roughness is not supported, the mean of both is used");
  const double mean = (std::min(u, 1.0) + std::min(v, 1.0)) / 2;
  const double alpha = parameters.boolean_or("remaproughness", true) ? std::sqrt(mean) : mean;
  return alpha < specular_below ? 0 : alpha;
}

double index_of_refraction(Parameters& parameters, Diagnostics& diagnostics, double otherwise) {
  double eta = otherwise;
  if (parameters.is_spectrum("eta")) {
    const auto glass = [](const std::string& name) -> std::optional<Rgb> {
      for (const NamedGlass& known : known_glasses)
        if (name == known.name) return Rgb(known.eta);
      return {};
    };
    eta = parameters.color("eta", glass)->x;
    diagnostics.note(parameters.where(), "glass has one index of refraction here, that of yellow light: no dispersion");
  } else {
    eta = parameters.number_or("eta", otherwise);
  }
  if (!(eta > 0.1 && eta < 10)) parameters.fail("eta", "must be between 0.1 and 10");
  return eta;
}

ConductorDescription make_conductor(Parameters& parameters, Diagnostics& diagnostics) {
  ConductorDescription result;
  if (parameters.has("reflectance")) {
    if (parameters.has("eta") || parameters.has("k"))
      parameters.fail("reflectance", "cannot stand beside eta and k: give one or the other");
    // eta = 1 and the k that gives this reflectance head on.
    const Rgb r = glm::min(reflectance_or(parameters, "reflectance", Rgb(0), diagnostics), Rgb(0.9999));
    result.eta = Rgb(1);
    result.k = 2.0 * glm::sqrt(r) / glm::sqrt(1.0 - r);
  } else {
    result.eta = parameters.color("eta", named_metal).value_or(known_metals[0].eta);
    result.k = parameters.color("k", named_metal).value_or(known_metals[0].k);
    for (int c = 0; c < 3; ++c) {
      if (!(result.eta[c] > 0 && result.eta[c] < 100)) parameters.fail("eta", "must be above 0 and below 100");
      if (!(result.k[c] >= 0 && result.k[c] < 100)) parameters.fail("k", "must be from 0 to 100");
    }
  }
  result.alpha = alpha_of(parameters, diagnostics);
  return result;
}

PhongDescription make_phong(Parameters& parameters, Diagnostics& diagnostics) {
  PhongDescription result;
  result.reflectance = reflectance_or(parameters, "reflectance", Rgb(0.5), diagnostics);
  result.specular = reflectance_or(parameters, "specular", Rgb(0), diagnostics);
  result.exponent = parameters.number_or("exponent", 1);
  if (!(result.exponent >= 0 && result.exponent <= 1e6)) parameters.fail("exponent", "must be from 0 to 1000000");
  const Rgb sum = result.reflectance + result.specular;
  if (sum.x > 1 + 1e-6 || sum.y > 1 + 1e-6 || sum.z > 1 + 1e-6)
    diagnostics.warning(parameters.where(),
                        parameters.directive() + ": reflectance and specular add up to more than 1");
  return result;
}

}  // namespace

MaterialDescription make_material(const std::string& kind, Parameters& parameters, Diagnostics& diagnostics) {
  MaterialDescription result;
  result.where = parameters.where();
  for (const char* name : {"displacement", "normalmap"}) {
    if (!parameters.has(name)) continue;
    parameters.ignore({name});
    parameters.unsupported(name, "is not supported: the surface stays smooth without it", diagnostics);
  }
  if (kind == "diffuse") {
    result.kind = DiffuseDescription{reflectance_or(parameters, "reflectance", Rgb(0.5), diagnostics)};
  } else if (kind == "phong") {
    result.kind = make_phong(parameters, diagnostics);
  } else if (kind == "mirror") {
    result.kind = MirrorDescription{reflectance_or(parameters, "reflectance", Rgb(1), diagnostics)};
  } else if (kind == "conductor") {
    result.kind = make_conductor(parameters, diagnostics);
  } else if (kind == "dielectric") {
    const double eta = index_of_refraction(parameters, diagnostics, 1.5);
    result.kind = DielectricDescription{eta, alpha_of(parameters, diagnostics)};
  } else if (kind == "coateddiffuse") {
    CoatedDiffuseDescription coated;
    coated.reflectance = reflectance_or(parameters, "reflectance", Rgb(0.5), diagnostics);
    coated.alpha = alpha_of(parameters, diagnostics);
    coated.eta = index_of_refraction(parameters, diagnostics, 1.5);
    if (coated.eta < 1) parameters.fail("eta", "of a coat must be at least 1");
    parameters.ignore({"thickness", "albedo", "g", "maxdepth", "nsamples"});
    diagnostics.note(parameters.where(),
                     "coateddiffuse becomes a diffuse lobe under a glossy one; light between the two is summed as for "
                     "a smooth coat");
    result.kind = coated;
  } else {
    diagnostics.unsupported(
        parameters.where(),
        "the material " + in_quotes(kind) +
            " is not understood: use diffuse, conductor, dielectric, coateddiffuse, phong or mirror");
    parameters.ignore_all();
    result.kind = DiffuseDescription{Rgb(0.5)};
  }
  return result;
}

}  // namespace gmis::tools::pbrt
