#include "support/build_scene.hpp"

#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <type_traits>
#include <utility>
#include <vector>

#include "gmis/scene/absorption.hpp"
#include "gmis/scene/scene_builder.hpp"

namespace gmis::tools {
namespace {

using Builder = scene::SceneBuilder<float>;

/// Runs `step`, which adds the element at `where`; turns `std::invalid_argument` of the scene layer
/// into an `InputError` with that place.
template <class Step>
void at(const SourcePosition& where, Step&& step) {
  try {
    step();
  } catch (const std::invalid_argument& error) {
    throw InputError(where, error.what());
  }
}

struct MakeMaterial {
  using Material = scene::Material<float>;
  const std::vector<Material>& made;

  Material operator()(const DiffuseDescription& m) const { return scene::make_diffuse(m.reflectance); }
  Material operator()(const PhongDescription& m) const {
    return scene::make_phong(m.reflectance, m.specular, m.exponent);
  }
  Material operator()(const MirrorDescription& m) const { return scene::make_mirror(m.reflectance); }
  Material operator()(const ConductorDescription& m) const {
    return scene::make_conductor(m.eta, m.k, m.alpha, m.masking);
  }
  Material operator()(const DielectricDescription& m) const {
    if (m.is_thin) return scene::make_thin_dielectric(m.eta, m.tint);
    return scene::make_dielectric(m.eta, m.alpha, scene::Masking::height_correlated, m.tint);
  }
  Material operator()(const CoatedDiffuseDescription& m) const {
    return scene::make_coated_diffuse(m.reflectance, m.eta, m.alpha, m.specular);
  }
  Material operator()(const DiffuseTransmissionDescription& m) const {
    return scene::make_diffuse_transmission(m.reflectance, m.transmittance);
  }
  Material operator()(const CoatedConductorDescription& m) const {
    return scene::make_coated_conductor(m.eta, m.k, m.alpha, m.coat_eta, m.coat_alpha);
  }
  Material operator()(const MixDescription& m) const {
    return scene::make_mix(made.at(m.first), made.at(m.second), m.amount);
  }
};

scene::Material<float> material_of(const MaterialDescription& description,
                                   const std::vector<scene::Material<float>>& made) {
  // A texture replaces a value only where the material has that lobe: the value must not be black.
  MaterialDescription there = description;
  const MaterialTexturesDescription& given = description.textures;
  if (given.color || given.transmittance) {
    const auto show = [](Rgb& color, const TextureHandle& texture) {
      if (texture) color = glm::clamp(Rgb(texture->upper()), Rgb(1e-3), Rgb(1));
    };
    if (auto* diffuse = std::get_if<DiffuseDescription>(&there.kind)) show(diffuse->reflectance, given.color);
    if (auto* phong = std::get_if<PhongDescription>(&there.kind)) show(phong->reflectance, given.color);
    if (auto* mirror = std::get_if<MirrorDescription>(&there.kind)) show(mirror->reflectance, given.color);
    if (auto* coated = std::get_if<CoatedDiffuseDescription>(&there.kind)) show(coated->reflectance, given.color);
    if (auto* sheet = std::get_if<DiffuseTransmissionDescription>(&there.kind)) {
      show(sheet->reflectance, given.color);
      show(sheet->transmittance, given.transmittance);
      if (max_channel(sheet->transmittance) == 0) sheet->transmittance = Rgb(1e-6);
    }
  }
  const scene::Material<float> plain = std::visit(MakeMaterial{made}, there.kind);
  if (given.is_empty()) return plain;
  scene::MaterialTextures<float> textures;
  textures.color = given.color;
  textures.transmittance = given.transmittance;
  // A coat that reflects nothing is left out: a roughness texture then has no lobe.
  if (!(std::holds_alternative<CoatedDiffuseDescription>(there.kind) &&
        plain.kind == scene::Material<float>::Kind::diffuse))
    textures.roughness = given.roughness;
  textures.is_remapped = given.is_remapped;
  textures.height = given.height;
  textures.normal_map = given.normal_map;
  return scene::with_textures(plain, std::move(textures));
}

/// The materials as the builder numbers them; those of shapes with an opacity or with media are
/// made when the first such shape comes.
class Materials {
 public:
  Materials(Builder& builder, const std::vector<MaterialDescription>& descriptions) : builder_(builder) {
    for (const MaterialDescription& description : descriptions)
      at(description.where, [&] {
        made_.push_back(material_of(description, made_));
        builder.add_material(made_.back());
      });
  }
  [[nodiscard]] std::size_t number_of(const ShapeDescription& shape) {
    if (shape.absorption) return number_of(shape.material, *shape.absorption);
    if (!shape.opacity) return shape.material;
    const auto [place, is_new] = cut_.try_emplace({shape.material, shape.opacity.get()}, 0);
    if (is_new) {
      scene::MaterialTextures<float> textures;
      textures.opacity = shape.opacity;
      place->second = builder_.add_material(scene::with_textures(made_.at(shape.material), std::move(textures)));
    }
    return place->second;
  }

 private:
  [[nodiscard]] std::size_t number_of(std::size_t material, const AbsorptionDescription& media) {
    const Rgb &in = media.inside, &out = media.outside;
    const auto [place, is_new] = boundaries_.try_emplace({double(material), in.x, in.y, in.z, out.x, out.y, out.z}, 0);
    if (is_new) place->second = builder_.add_material(scene::with_absorption(made_.at(material), in, out));
    return place->second;
  }

  Builder& builder_;
  std::vector<scene::Material<float>> made_;
  std::map<std::array<double, 7>, std::size_t> boundaries_;
  std::map<std::pair<std::size_t, const void*>, std::size_t> cut_;
};

void add_shape(Builder& builder, const ShapeDescription& shape, std::size_t material) {
  std::optional<scene::AreaEmission> emission;
  if (shape.emission) emission = scene::AreaEmission{shape.emission->radiance, shape.emission->is_two_sided};
  if (const auto* sphere = std::get_if<SphereDescription>(&shape.geometry)) {
    builder.add_sphere(sphere->center, sphere->radius, material, emission, sphere->normal_points_inward, sphere->axes);
  } else {
    const auto& mesh = std::get<MeshDescription>(shape.geometry);
    builder.add_mesh({mesh.positions, mesh.triangles, mesh.normals, mesh.uv}, material, emission,
                     shape.emission ? shape.emission->texture : nullptr);
  }
}

struct AddLight {
  Builder& builder;
  void operator()(const PointLightDescription& l) const { builder.add_point_light(l.position, l.intensity); }
  void operator()(const DistantLightDescription& l) const { builder.add_directional_light(l.to_light, l.irradiance); }
  void operator()(const SpotLightDescription& l) const {
    builder.add_spot_light(l.position, l.direction, l.intensity, l.inner, l.outer);
  }
  // Every integrator lets camera subpaths hit the sky, so that next-event samples may leave out its
  // dark part.
  void operator()(const EnvironmentLightDescription& l) const {
    builder.add_environment(l.image, l.world_from_sky, 0.5);
  }
  void operator()(const InfiniteLightDescription& l) const { builder.add_environment(l.radiance); }
};

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// Pixels whose corner is in the window, as pbrt has it.
std::optional<PixelBounds> crop_of(const FilmDescription& film) {
  if (!film.crop_window) return {};
  const auto& [x0, x1, y0, y1] = *film.crop_window;
  // The product may be a hair above the whole number that is meant.
  const auto pixel = [](double part, int size) { return static_cast<int>(std::ceil(part * size - 1e-6)); };
  PixelBounds crop{{pixel(x0, film.width), pixel(y0, film.height)}, {pixel(x1, film.width), pixel(y1, film.height)}};
  if (!(crop.lower.x < crop.upper.x && crop.lower.y < crop.upper.y))
    throw InputError(film.where, "cropwindow holds no pixel: make it larger");
  return crop;
}

}  // namespace

std::unique_ptr<BuiltScene> build_scene(const SceneDescription& description, Diagnostics& diagnostics,
                                        scene::LightSelection lights) {
  Builder builder;
  builder.set_light_selection(lights);
  Materials materials(builder, description.materials);
  for (const ShapeDescription& shape : description.shapes)
    at(shape.where, [&] { add_shape(builder, shape, materials.number_of(shape)); });
  for (const LightDescription& light : description.lights)
    at(light.where, [&] { std::visit(AddLight{builder}, light.kind); });
  const FilmDescription& film = description.film;
  at(description.camera.where, [&] {
    const CameraDescription& camera = description.camera;
    builder.set_camera({camera.world_from_camera,
                        picture_window(camera, film.width, film.height),
                        {film.width, film.height},
                        camera.is_orthographic ? scene::Projection::orthographic : scene::Projection::perspective,
                        camera.lens_radius,
                        camera.focal_distance});
  });
  auto built = builder.build();
  const auto& facts = built.statistics();
  if (facts.degenerate_triangle_count > 0)
    diagnostics.warning(
        description.shapes.front().where,
        counted(facts.degenerate_triangle_count, "triangle", "triangles") + " without area in this scene: left out");
  const std::string summary = counted(facts.triangle_count, "triangle", "triangles") + ", " +
                              counted(facts.sphere_count, "sphere", "spheres") + ", " +
                              counted(facts.light_count, "light", "lights");
  return std::make_unique<BuiltScene>(std::move(built), film.file_name, summary, crop_of(film));
}

}  // namespace gmis::tools
