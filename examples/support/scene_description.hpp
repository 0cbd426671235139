#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gmis/scene/environment_map.hpp"
#include "gmis/scene/microfacet.hpp"
#include "gmis/scene/texture.hpp"
#include "support/diagnostics.hpp"

/// \file
/// A scene as it was read: plain data in double precision and world coordinates, instances already
/// copied out, every element with its place in the file. Colours are linear RGB; light is radiance,
/// radiant intensity or irradiance.

namespace gmis::tools {

using Rgb = glm::dvec3;
using Point = glm::dvec3;

using TextureHandle = std::shared_ptr<const scene::Texture<float>>;

struct DiffuseDescription {
  Rgb reflectance{0.5};
};
/// f = reflectance/π + specular · (n + 2)/(2π) cosⁿ, on the upper side only.
struct PhongDescription {
  Rgb reflectance{0.5}, specular{0};
  double exponent = 1;
};
/// A delta reflection with a constant reflectance.
struct MirrorDescription {
  Rgb reflectance{1};
};
/// `alpha` is that of GGX; 0 is a smooth surface.
struct ConductorDescription {
  Rgb eta{1}, k{1};
  double alpha = 0;
  scene::Masking masking = scene::Masking::height_correlated;
};
/// With a constant index of refraction; `alpha` is that of GGX, 0 is a smooth surface.
struct DielectricDescription {
  double eta = 1.5;
  double alpha = 0;
  Rgb tint{1};           ///< factor of refracted light
  bool is_thin = false;  ///< a smooth pane, both faces in one surface: light passes straight on
};
/// A diffuse base under a dielectric coat; `alpha` 0 is a smooth coat.
struct CoatedDiffuseDescription {
  Rgb reflectance{0.5};
  double alpha = 0;
  double eta = 1.5;
  Rgb specular{1};  ///< factor on the light that the coat reflects
};

/// A thin sheet that scatters to both sides.
struct DiffuseTransmissionDescription {
  Rgb reflectance{0.25}, transmittance{0.25};
};
/// A metal under a dielectric coat; alpha 0 is smooth.
struct CoatedConductorDescription {
  Rgb eta{1}, k{1};
  double alpha = 0;
  double coat_eta = 1.5;
  double coat_alpha = 0;
};
/// The second material at this share of the points, the first elsewhere; both stand before this
/// one.
struct MixDescription {
  std::size_t first = 0, second = 0;
  TextureHandle amount;
};

/// The textures that replace numbers and colours of the description where these vary over the
/// surface; else null.
struct MaterialTexturesDescription {
  TextureHandle color, transmittance, roughness, height, normal_map;
  bool is_remapped = false;  ///< α = √roughness

  [[nodiscard]] bool is_empty() const { return !color && !transmittance && !roughness && !height && !normal_map; }
};

struct MaterialDescription {
  std::variant<DiffuseDescription, PhongDescription, MirrorDescription, ConductorDescription, DielectricDescription,
               CoatedDiffuseDescription, DiffuseTransmissionDescription, CoatedConductorDescription, MixDescription>
      kind;
  SourcePosition where;
  MaterialTexturesDescription textures{};
};

/// The geometric normal of a triangle is that of its winding, (b − a) × (c − a); the reader has
/// already applied ReverseOrientation, mirroring transforms and the side that vertex normals
/// choose.
struct MeshDescription {
  std::vector<Point> positions;
  std::vector<glm::dvec3> normals;  ///< one per position, unit, or none
  std::vector<std::array<int, 3>> triangles;
  std::vector<glm::dvec2> uv;  ///< one per position, or none
};

struct SphereDescription {
  Point center{0};
  double radius = 1;
  bool normal_points_inward = false;
  glm::dmat3 axes{1};  ///< unit; of its coordinates (u, v)
};

struct EmissionDescription {
  Rgb radiance{1};
  bool is_two_sided = false;
  TextureHandle texture{};  ///< factor of the radiance over a mesh; null where it is the same everywhere
};

/// The absorption of the media on both sides of a dielectric, per scene unit: behind the geometric
/// normal and before it.
struct AbsorptionDescription {
  Rgb inside{0}, outside{0};
};

struct ShapeDescription {
  std::variant<MeshDescription, SphereDescription> geometry;
  std::size_t material = 0;  ///< index into `SceneDescription::materials`
  std::optional<EmissionDescription> emission;
  SourcePosition where;
  TextureHandle opacity;  ///< the share of the surface that is there; null where it is all there
  std::optional<AbsorptionDescription> absorption{};
};

struct PointLightDescription {
  Point position{0};
  Rgb intensity{1};
};
struct SpotLightDescription {
  Point position{0};
  glm::dvec3 direction{0, 0, 1};
  Rgb intensity{1};
  double inner = 0, outer = 1;  ///< half angles in radians: full strength within the one, nothing beyond the other
};
struct DistantLightDescription {
  glm::dvec3 to_light{0, 0, 1};  ///< unit
  Rgb irradiance{1};             ///< on a plane perpendicular to it
};
struct InfiniteLightDescription {
  Rgb radiance{1};
};
struct EnvironmentLightDescription {
  scene::EnvironmentImage image;
  glm::dmat3 world_from_sky{1};
};

struct LightDescription {
  std::variant<PointLightDescription, SpotLightDescription, DistantLightDescription, InfiniteLightDescription,
               EnvironmentLightDescription>
      kind;
  SourcePosition where;
};

/// Camera space is left-handed: x to the right of the picture, y up, z forward. `world_from_camera`
/// may mirror.
struct CameraDescription {
  glm::dmat4 world_from_camera{1};
  bool is_orthographic = false;                        ///< parallel rays
  double field_of_view = 90;                           ///< in degrees, across the shorter side of the picture
  std::optional<double> vertical_field_of_view;        ///< in degrees; takes the place of `field_of_view`
  std::optional<double> frame_aspect_ratio;            ///< width over height when not that of the film
  std::optional<std::array<double, 4>> screen_window;  ///< x0, x1, y0, y1
  double lens_radius = 0;                              ///< in camera space; 0 is a pinhole
  double focal_distance = 1e6;                         ///< in camera space, along z
  SourcePosition where;
};

struct FilmDescription {
  int width = 1280;
  int height = 720;
  std::string file_name = "pbrt.exr";
  std::optional<std::array<double, 4>> crop_window;  ///< x0, x1, y0, y1 as fractions of width and height, y down
  SourcePosition where;
};

struct SceneDescription {
  FilmDescription film;
  CameraDescription camera;
  /// Takes the place of `camera` where surfaces hide the sky from that one; given where all light
  /// is the sky's.
  std::optional<CameraDescription> camera_outside;
  std::vector<MaterialDescription> materials;
  std::vector<ShapeDescription> shapes;
  std::vector<LightDescription> lights;
  std::vector<std::filesystem::path> files;  ///< that it was read from: scenes, meshes, images, spectra; each once
};

/// A sphere counts as one.
[[nodiscard]] std::size_t triangle_count(const ShapeDescription& shape);
/// The area of the surface, of one side.
[[nodiscard]] double area_of(const ShapeDescription& shape);
/// Memory that the description takes.
[[nodiscard]] std::uintmax_t bytes_of(const ShapeDescription& shape);
/// About what it takes once all is built: in the description, the builder and the scene.
[[nodiscard]] std::uintmax_t built_bytes_of(const ShapeDescription& shape);

/// Adds a file to `SceneDescription::files` unless it is there, or no regular file.
void add_file(SceneDescription& scene, const std::filesystem::path& file);

/// The rectangle x0, x1, y0, y1 that the picture spans on the plane z = 1 of camera space, y up;
/// with parallel rays on every plane.
[[nodiscard]] std::array<double, 4> picture_window(const CameraDescription& camera, int width, int height);

}  // namespace gmis::tools
