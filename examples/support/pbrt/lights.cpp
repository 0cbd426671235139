#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "support/pbrt/elements.hpp"

namespace gmis::tools::pbrt {

double luminance(const Rgb& color) {
  return glm::dot(color, Rgb(0.2126, 0.7152, 0.0722));
}

namespace {

Rgb emitted(Parameters& parameters, const std::string& name) {
  const Rgb value = parameters.color(name).value_or(Rgb(1));
  if (value.x < 0 || value.y < 0 || value.z < 0) parameters.fail(name, "is negative: light cannot be");
  const double scale = parameters.number_or("scale", 1);
  if (scale < 0) parameters.fail("scale", "is negative: light cannot be");
  constexpr double brightest = 1e20;
  if (!(std::max({value.x, value.y, value.z}) * scale <= brightest)) parameters.fail(name, "is above 1e20");
  return value * scale;
}

/// A quantity that sets the strength of a light by its luminance instead of by its colour.
std::optional<double> strength(Parameters& parameters, const std::string& name) {
  const std::optional<double> value = parameters.number(name);
  if (value && *value < 0) parameters.fail(name, "is negative: light cannot be");
  return value;
}

/// `color` brought to the luminance `wanted`, `scale` left in.
Rgb with_luminance(Parameters& parameters, const std::string& name, double wanted) {
  const Rgb color = parameters.color(name).value_or(Rgb(1));
  const double current = luminance(color);
  return current > 0 ? color * (wanted * parameters.number_or("scale", 1) / current) : Rgb(0);
}

}  // namespace

std::optional<LightDescription> make_light(const std::string& kind, Parameters& parameters,
                                           const Transform& world_from_light, Diagnostics& diagnostics) {
  LightDescription light;
  light.where = parameters.where();
  Rgb color(0);
  if (kind == "point") {
    color = emitted(parameters, "I");
    if (const auto power = strength(parameters, "power"))
      color = with_luminance(parameters, "I", *power / (4 * std::numbers::pi));
    const Point from = parameters.point("from").value_or(Point(0));
    light.kind = PointLightDescription{transform_point(world_from_light, from), color};
  } else if (kind == "distant") {
    color = emitted(parameters, "L");
    if (const auto illuminance = strength(parameters, "illuminance"))
      color = with_luminance(parameters, "L", *illuminance);
    const Point from = parameters.point("from").value_or(Point(0));
    const Point to = parameters.point("to").value_or(Point(0, 0, 1));
    const glm::dvec3 towards = transform_vector(world_from_light, from - to);
    if (!(glm::length(towards) > 0)) parameters.fail("to", "equals \"from\": a distant light needs a direction");
    light.kind = DistantLightDescription{glm::normalize(towards), color};
  } else if (kind == "infinite") {
    if (parameters.has("filename"))
      parameters.fail("filename", "names an environment image, which is not supported: give a constant L");
    color = emitted(parameters, "L");
    if (const auto illuminance = strength(parameters, "illuminance"))
      color = with_luminance(parameters, "L", *illuminance / std::numbers::pi);
    parameters.ignore({"portal"});
    light.kind = InfiniteLightDescription{color};
  } else {
    throw InputError(parameters.where(),
                     "the light " + in_quotes(kind) + " is not understood: use point, distant or infinite");
  }
  if (color == Rgb(0)) {
    diagnostics.note(parameters.where(), "a black light is left out");
    return {};
  }
  return light;
}

AreaLight make_area_light(const std::string& kind, Parameters& parameters) {
  if (kind != "diffuse")
    throw InputError(parameters.where(), "the area light " + in_quotes(kind) + " is not understood: use diffuse");
  if (parameters.has("filename"))
    parameters.fail("filename", "names an emission image, which is not supported: give a constant L");
  AreaLight light;
  light.where = parameters.where();
  light.emission.radiance = emitted(parameters, "L");
  light.emission.is_two_sided = parameters.boolean_or("twosided", false);
  light.power = strength(parameters, "power");
  if (light.power) *light.power *= parameters.number_or("scale", 1);
  return light;
}

namespace {

double area_of(const ShapeDescription& shape) {
  if (const auto* sphere = std::get_if<SphereDescription>(&shape.geometry))
    return 4 * std::numbers::pi * sphere->radius * sphere->radius;
  const auto& mesh = std::get<MeshDescription>(shape.geometry);
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Point& p = mesh.positions[static_cast<std::size_t>(a)];
    area += glm::length(glm::cross(mesh.positions[static_cast<std::size_t>(b)] - p,
                                   mesh.positions[static_cast<std::size_t>(c)] - p)) /
            2;
  }
  return area;
}

}  // namespace

std::optional<EmissionDescription> emission_of(const AreaLight& light, const ShapeDescription& shape) {
  EmissionDescription result = light.emission;
  if (result.radiance == Rgb(0)) return {};
  if (light.power) {
    const double area = area_of(shape) * (result.is_two_sided ? 2 : 1);
    if (!(area > 0)) return {};
    result.radiance *= *light.power / (luminance(result.radiance) * std::numbers::pi * area);
  }
  if (result.radiance == Rgb(0)) return {};
  return result;
}

}  // namespace gmis::tools::pbrt
