#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "support/load_budget.hpp"
#include "support/pbrt/parameters.hpp"
#include "support/pbrt/transform.hpp"
#include "support/scene_description.hpp"

/// \file
/// The materials, lights and shapes that the directives Material, LightSource, AreaLightSource and
/// Shape make of their parameters. An unknown kind goes to `Diagnostics::unsupported` or throws
/// `InputError`; invalid parameters throw `InputError`.

namespace gmis::tools::pbrt {

/// Where the files that a scene names are, and what reading them counts against.
struct Files {
  std::function<std::filesystem::path(const std::string&)> find;
  LoadBudget* budget;
};

/// `is_color`: of type spectrum, else of type float.
[[nodiscard]] TextureHandle make_texture(const std::string& kind, bool is_color, Parameters& parameters,
                                         const Files& files, Diagnostics& diagnostics);

/// Any but a mixture.
[[nodiscard]] MaterialDescription make_material(const std::string& kind, Parameters& parameters, const Files& files,
                                                Diagnostics& diagnostics);

/// Nothing when the light is black or of an unsupported kind.
[[nodiscard]] std::optional<LightDescription> make_light(const std::string& kind, Parameters& parameters,
                                                         const Transform& world_from_light, const Files& files,
                                                         Diagnostics& diagnostics);

/// Beyond what light may have.
[[nodiscard]] bool is_too_bright(const Rgb& color);
inline constexpr const char* too_bright_film =
    "this light times the exposure of Film and Camera is above 1e20: lower iso, imagingratio or exposuretime";

/// Multiplies the colour of a light by this matrix; what becomes negative is 0. Throws `InputError`
/// where it becomes too bright.
void expose(LightDescription& light, const glm::dmat3& matrix);

/// The emission of an area light, before its area is known.
struct AreaLight {
  EmissionDescription emission;
  std::optional<double> power;  ///< of the whole shape, over all directions and, if two-sided, both sides
  SourcePosition where;
};
[[nodiscard]] AreaLight make_area_light(const std::string& kind, Parameters& parameters, Diagnostics& diagnostics);
/// The emission of `light` on `shape`; nothing when it is black.
[[nodiscard]] std::optional<EmissionDescription> emission_of(const AreaLight& light, const ShapeDescription& shape);

/// A shape in its own space, without material and emission; nothing when it is of a kind that is
/// not supported.
[[nodiscard]] std::optional<ShapeDescription> make_shape(const std::string& kind, Parameters& parameters,
                                                         bool reverse_orientation, const Files& files,
                                                         Diagnostics& diagnostics);

[[nodiscard]] double luminance(const Rgb& color);

}  // namespace gmis::tools::pbrt
