#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "support/image/image.hpp"
#include "support/pbrt/elements.hpp"
#include "support/sky.hpp"

namespace gmis::tools::pbrt {

bool is_too_bright(const Rgb& color) {
  constexpr double brightest = 1e20;
  return !(color.x <= brightest && color.y <= brightest && color.z <= brightest);
}

double luminance(const Rgb& color) {
  return glm::dot(color, Rgb(0.2126, 0.7152, 0.0722));
}

namespace {

Rgb emitted(Parameters& parameters, const std::string& name) {
  const Rgb value = parameters.color(name, SpectrumOf::light).value_or(Rgb(1));
  if (value.x < 0 || value.y < 0 || value.z < 0) parameters.fail(name, "is negative: use a value of at least 0");
  const double scale = parameters.number_or("scale", 1);
  if (scale < 0) parameters.fail("scale", "is negative: use a value of at least 0");
  if (is_too_bright(value * scale)) parameters.fail(name, "is above 1e20");
  return value * scale;
}

/// A quantity that sets the strength of a light by its luminance instead of by its colour. It is
/// not given where it is 0 or less, as in pbrt.
std::optional<double> strength(Parameters& parameters, const std::string& name) {
  const std::optional<double> value = parameters.number(name);
  return value && *value > 0 ? value : std::nullopt;
}

/// The colour of the parameter `name` with the luminance `wanted`, which `strength` sets, times the
/// parameter "scale".
Rgb with_luminance(Parameters& parameters, const std::string& name, double wanted, const char* strength) {
  const Rgb color = parameters.color(name, SpectrumOf::light).value_or(Rgb(1));
  const double current = luminance(color);
  if (!(current > 0)) return Rgb(0);
  const Rgb result = color * (wanted * parameters.number_or("scale", 1) / current);
  if (is_too_bright(result)) parameters.fail(strength, "makes light above 1e20");
  return result;
}

SpotLightDescription make_spot(Parameters& parameters, const Transform& world_from_light) {
  SpotLightDescription spot;
  spot.intensity = emitted(parameters, "I");
  const double cone = parameters.number_or("coneangle", 30);
  const double delta = parameters.number_or("conedeltaangle", 5);
  if (!(cone >= 0.01 && cone <= 180)) parameters.fail("coneangle", "must be from 0.01 to 180 degrees");
  if (!(delta >= 0 && delta <= cone)) parameters.fail("conedeltaangle", "must be from 0 to \"coneangle\"");
  spot.outer = std::min(cone * std::numbers::pi / 180, std::numbers::pi);
  spot.inner = (cone - delta) * std::numbers::pi / 180;
  if (const auto power = strength(parameters, "power"))
    spot.intensity = with_luminance(
        parameters, "I", *power / (std::numbers::pi * (2 - std::cos(spot.inner) - std::cos(spot.outer))), "power");
  const Point from = parameters.point("from").value_or(Point(0));
  const Point to = parameters.point("to").value_or(Point(0, 0, 1));
  spot.position = transform_point(world_from_light, from);
  spot.direction = transform_vector(world_from_light, to - from);
  if (!(glm::length(spot.direction) > 0)) parameters.fail("to", "equals \"from\": a spot light needs a direction");
  if (!similarity_scale(world_from_light))
    throw InputError(parameters.where(), "the transforms above a spot light stretch space: scale all axes alike");
  spot.direction = glm::normalize(spot.direction);
  return spot;
}

/// An image of the sky, times the parameter "scale".
EnvironmentLightDescription make_sky(Parameters& parameters, const Transform& world_from_light, const Files& files,
                                     Diagnostics& diagnostics) {
  for (const char* name : {"L", "illuminance"})
    if (parameters.has(name)) parameters.fail(name, "cannot stand beside an image: use scale");
  const double scale = parameters.number_or("scale", 1);
  if (!(scale >= 0 && scale <= 1e20)) parameters.fail("scale", "must be from 0 to 1e20");
  const std::string name = parameters.string("filename").value_or("");
  Image image;
  try {
    const std::filesystem::path file = files.find(name);
    files.budget->open_file(parameters.where());
    image = read_image(file, files.budget);
    files.budget->take(image.rgb.size(), 2 * sizeof(float), "the image " + file_in_quotes(name), parameters.where());
  } catch (const InputError& error) {
    throw InputError(parameters.where(), error.what());
  }
  EnvironmentLightDescription sky;
  sky.world_from_sky = glm::dmat3(world_from_light);
  SkyImage made = sky_image(
      image, scale, [&](const std::string& message) { parameters.fail("filename", "names an image that " + message); });
  if (made.image.mapping == scene::SkyMapping::latitude_longitude)
    diagnostics.note(parameters.where(),
                     in_quotes(name) + " is twice as wide as high: it is taken for latitude and longitude");
  if (made.has_negative)
    diagnostics.warning(parameters.where(), in_quotes(name) + " has negative values: they are taken for 0");
  if (!similarity_scale(world_from_light))
    throw InputError(parameters.where(),
                     "the transforms above an environment image stretch space: scale all axes alike");
  sky.image = std::move(made.image);
  return sky;
}

}  // namespace

std::optional<LightDescription> make_light(const std::string& kind, Parameters& parameters,
                                           const Transform& world_from_light, const Files& files,
                                           Diagnostics& diagnostics) {
  LightDescription light;
  light.where = parameters.where();
  Rgb color(0);
  if (kind == "point") {
    color = emitted(parameters, "I");
    if (const auto power = strength(parameters, "power"))
      color = with_luminance(parameters, "I", *power / (4 * std::numbers::pi), "power");
    const Point from = parameters.point("from").value_or(Point(0));
    light.kind = PointLightDescription{transform_point(world_from_light, from), color};
  } else if (kind == "spot") {
    const SpotLightDescription spot = make_spot(parameters, world_from_light);
    color = spot.intensity;
    light.kind = spot;
  } else if (kind == "distant") {
    color = emitted(parameters, "L");
    if (const auto illuminance = strength(parameters, "illuminance"))
      color = with_luminance(parameters, "L", *illuminance, "illuminance");
    const Point from = parameters.point("from").value_or(Point(0));
    const Point to = parameters.point("to").value_or(Point(0, 0, 1));
    const glm::dvec3 towards = transform_vector(world_from_light, from - to);
    if (!(glm::length(towards) > 0)) parameters.fail("to", "equals \"from\": a distant light needs a direction");
    light.kind = DistantLightDescription{glm::normalize(towards), color};
  } else if (kind == "infinite") {
    if (parameters.has("filename")) {
      EnvironmentLightDescription sky;
      try {
        sky = make_sky(parameters, world_from_light, files, diagnostics);
      } catch (const InputError& error) {
        diagnostics.unsupported(error.where().value_or(parameters.where()), error.message());
        sky.image = {};
        sky.image.resolution = {2, 1};
        sky.image.mapping = scene::SkyMapping::latitude_longitude;
        sky.image.radiance.assign(2, glm::vec3(1));  // white with --lenient
      }
      for (const glm::vec3& pixel : sky.image.radiance) color = glm::max(color, Rgb(pixel));
      light.kind = std::move(sky);
    } else {
      color = emitted(parameters, "L");
      if (const auto illuminance = strength(parameters, "illuminance"))
        color = with_luminance(parameters, "L", *illuminance / std::numbers::pi, "illuminance");
      light.kind = InfiniteLightDescription{color};
    }
    if (parameters.has("portal"))
      diagnostics.warning(parameters.where(), "\"portal\" is ignored: the sky shines through all openings");
    parameters.ignore({"portal"});
  } else {
    diagnostics.unsupported(parameters.where(), "the light " + in_quotes(kind) +
                                                    " is not understood: use point, spot, distant or infinite");
    parameters.ignore_all();
    return {};
  }
  if (color == Rgb(0)) {
    diagnostics.note(parameters.where(), "a black light is left out");
    return {};
  }
  return light;
}

void expose(LightDescription& light, const glm::dmat3& matrix) {
  if (matrix == glm::dmat3(1)) return;
  struct {
    const glm::dmat3& matrix;
    bool is_too_bright = false;
    void change(Rgb& color) {
      color = glm::max(matrix * color, Rgb(0));
      is_too_bright = is_too_bright || pbrt::is_too_bright(color);
    }
    void operator()(PointLightDescription& l) { change(l.intensity); }
    void operator()(SpotLightDescription& l) { change(l.intensity); }
    void operator()(DistantLightDescription& l) { change(l.irradiance); }
    void operator()(InfiniteLightDescription& l) { change(l.radiance); }
    void operator()(EnvironmentLightDescription& l) {
      for (glm::vec3& pixel : l.image.radiance) {
        pixel = glm::max(glm::mat3(matrix) * pixel, glm::vec3(0));
        is_too_bright = is_too_bright || pbrt::is_too_bright(Rgb(pixel));
      }
    }
  } brighten{matrix};
  std::visit(brighten, light.kind);
  if (brighten.is_too_bright) throw InputError(light.where, too_bright_film);
}

AreaLight make_area_light(const std::string& kind, Parameters& parameters, Diagnostics& diagnostics) {
  if (kind != "diffuse")
    throw InputError(parameters.where(), "the area light " + in_quotes(kind) + " is not understood: use diffuse");
  if (parameters.has("filename")) {
    parameters.ignore({"filename"});
    parameters.unsupported("filename", "names an emission image, which is not supported: give a constant L",
                           diagnostics);
  }
  AreaLight light;
  light.where = parameters.where();
  light.emission.radiance = emitted(parameters, "L");
  light.emission.is_two_sided = parameters.boolean_or("twosided", false);
  light.power = strength(parameters, "power");
  if (light.power) *light.power *= parameters.number_or("scale", 1);
  return light;
}

std::optional<EmissionDescription> emission_of(const AreaLight& light, const ShapeDescription& shape) {
  EmissionDescription result = light.emission;
  if (result.radiance == Rgb(0)) return {};
  if (light.power) {
    const double area = area_of(shape) * (result.is_two_sided ? 2 : 1);
    if (!(area > 0)) return {};
    result.radiance *= *light.power / (luminance(result.radiance) * std::numbers::pi * area);
    if (is_too_bright(result.radiance))
      throw InputError(light.where, "AreaLightSource: parameter \"power\" makes light above 1e20");
  }
  if (result.radiance == Rgb(0)) return {};
  return result;
}

}  // namespace gmis::tools::pbrt
