#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/executor_ref.hpp"
#include "gmis/core/instruction_set.hpp"
#include "gmis/scene/box.hpp"
#include "gmis/scene/bvh_build.hpp"
#include "gmis/scene/bvh_scene.hpp"
#include "gmis/scene/cut_large_triangles.hpp"
#include "gmis/scene/enclosure.hpp"
#include "gmis/scene/light_hierarchy_build.hpp"
#include "gmis/scene/light_powers.hpp"
#include "gmis/scene/light_reach.hpp"
#include "gmis/scene/light_selection.hpp"
#include "gmis/scene/material_effects.hpp"
#include "gmis/scene/mesh_shape.hpp"
#include "gmis/scene/position_error.hpp"

namespace gmis::scene {

/// Takes a scene in double precision and world coordinates and makes a `BvhScene` of it.
///
///     SceneBuilder<> builder;
///     const auto white = builder.add_material(make_diffuse({.7, .7, .7}));
///     builder.add_sphere({0, 0, 5}, 1, white);
///     builder.add_point_light({0, 5, 0}, {10, 10, 10});
///     builder.set_camera(look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 40, {640, 480}));
///     const auto scene = builder.build();
///
/// Every function throws `std::invalid_argument`, naming what is wrong, when a number is not
/// finite, an index is out of range, a shape is invalid or the camera is missing.
///
/// `SceneBuilder<float, MyBsdf>` makes a scene whose surfaces scatter by a BSDF of yours (see
/// `SurfaceModel`).
template <std::floating_point T = float, SurfaceModel<T> Bsdf_ = SurfaceBsdf<T>>
class SceneBuilder {
 public:
  using Scene = BvhScene<T, Bsdf_>;
  using Material = typename Bsdf_::Material;

  /// The number by which shapes refer to it.
  std::size_t add_material(const Material& material) {
    materials_.push_back(material);
    return materials_.size() - 1;
  }

  /// Adds triangles of one material, with an emission if they are a light. With an
  /// `emission_texture` the radiance is its value times that of `emission`; each triangle on which
  /// it is not black everywhere is a light.
  void add_mesh(const MeshShape& mesh, std::size_t material, const std::optional<AreaEmission>& emission = {},
                const typename Texture<T>::Handle& emission_texture = {}) {
    check_surface(material, emission);
    check_mesh(mesh);
    Surface surface{material, emission, no_pattern};
    if (emission && (emission_texture || cuts(materials_[material])))
      surface.pattern = add_pattern(*emission, emission_texture, materials_[material]);
    const bool needs_uv = varies(materials_[material]) || surface.pattern != no_pattern;
    for (const auto& triangle : mesh.triangles) {
      Triangle added;
      added.surface = surfaces_.size();
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const auto index = static_cast<std::size_t>(triangle[corner]);
        added.corners[corner] = mesh.positions[index];
        if (!mesh.normals.empty()) added.normals[corner] = mesh.normals[index];
      }
      added.has_normals = !mesh.normals.empty();
      TriangleCoordinates<T> uv{Vec2<T>(0, 0), Vec2<T>(1, 0), Vec2<T>(1, 1)};
      if (!mesh.uv.empty())
        for (std::size_t corner = 0; corner < 3; ++corner)
          uv[corner] = Vec2<T>(mesh.uv[static_cast<std::size_t>(triangle[corner])]);
      if (needs_uv) {
        added.coordinates = static_cast<std::uint32_t>(coordinates_.size());
        coordinates_.push_back(uv);
      }
      added.emits = emission && !is_black(emission->radiance) &&
                    (surface.pattern == no_pattern || !is_black(patterns_[surface.pattern].upper_on(uv)));
      triangles_.push_back(added);
    }
    surfaces_.push_back(surface);
  }

  /// `axes`, of unit length and perpendicular, are those of the coordinates (u, v), see
  /// `sphere_coordinates`.
  void add_sphere(const glm::dvec3& center, double radius, std::size_t material,
                  const std::optional<AreaEmission>& emission = {}, bool normal_points_inward = false,
                  const glm::dmat3& axes = glm::dmat3(1)) {
    check_surface(material, emission);
    if (emission && cuts(materials_[material])) fail("a sphere with an opacity cannot be a light");
    check_place(center);
    if (!(radius > 0 && radius < largest_coordinate)) fail("a sphere's radius must be positive and finite");
    spheres_.push_back({center, radius, normal_points_inward, surfaces_.size(), axes});
    surfaces_.push_back({material, emission, no_pattern});
  }

  /// `intensity` in power per steradian.
  void add_point_light(const glm::dvec3& position, const glm::dvec3& intensity) {
    check_place(position);
    check_color(intensity);
    point_lights_.push_back({position, intensity});
  }
  /// A point light that shines into a cone around `direction` (any length but 0): with `intensity`
  /// up to the half angle `inner`, falling smoothly to nothing at `outer`; radians, 0 ≤ inner ≤
  /// outer ≤ π, outer above 1e-4.
  void add_spot_light(const glm::dvec3& position, const glm::dvec3& direction, const glm::dvec3& intensity,
                      double inner, double outer) {
    check_place(position);
    check_place(direction);
    check_color(intensity);
    if (!(glm::length(direction) > 0)) fail("a spot light needs a direction");
    if (!(inner >= 0 && inner <= outer && outer > 1e-4 && outer <= pi<double>))
      fail("the angles of a spot light must be 0 <= inner <= outer <= pi, and outer above 0.0001");
    spot_lights_.push_back({position, direction, intensity, inner, outer});
  }
  /// `irradiance` on a plane perpendicular to `to_light` (any length but 0).
  void add_directional_light(const glm::dvec3& to_light, const glm::dvec3& irradiance) {
    check_place(to_light);
    check_color(irradiance);
    if (!(glm::length(to_light) > 0)) fail("a directional light needs a direction");
    infinite_lights_.push_back(Light<T>::directional(Vec3<T>(glm::normalize(to_light)), Vec3<T>(irradiance)));
  }
  /// The same `radiance` from all directions.
  void add_environment(const glm::dvec3& radiance) {
    check_color(radiance);
    infinite_lights_.push_back(Light<T>::environment(Vec3<T>(radiance)));
  }
  /// The columns of `world_from_sky` are the axes of the image's frame (see `EnvironmentMap`). A
  /// black image is no light. `next_event_fraction` below 1 compensates next-event samples; it
  /// needs rays that reach the sky by scattering.
  void add_environment(const EnvironmentImage& image, const glm::dmat3& world_from_sky = glm::dmat3(1),
                       double next_event_fraction = 1.0) {
    auto map = std::make_shared<const EnvironmentMap<T>>(image, world_from_sky, next_event_fraction);
    if (!(map->total() > 0)) return;
    infinite_lights_.push_back(Light<T>::environment(*map));
    environment_maps_.push_back(std::move(map));
  }

  /// `by_receiver` costs a walk down a tree at every next event and emitter hit. It pays where many
  /// lights each reach little of the scene; with `learned` each run measures whether it does. By
  /// power is the default.
  void set_light_selection(LightSelection selection) { light_selection_ = selection; }

  /// The camera of the scene; a scene needs one.
  void set_camera(const CameraDescription& camera) {
    static_cast<void>(Camera<T>(camera, glm::dvec3(0)));  // throws what it has to
    check_place(glm::dvec3(camera.world_from_camera[3]));
    camera_ = camera;
  }

  /// Makes the scene; the builder can be used again.
  [[nodiscard]] Scene build() const {
    const SerialExecutor serial;
    return build(serial);
  }

  /// The executor's threads share the building of the tree; the scene has the same bits for any
  /// number of them.
  [[nodiscard]] Scene build(ExecutorRef executor) const;

 private:
  struct Surface {
    std::size_t material;
    std::optional<AreaEmission> emission;
    std::size_t pattern;  ///< in `patterns_`
  };
  static constexpr std::size_t no_pattern = std::numeric_limits<std::size_t>::max();
  static constexpr std::uint32_t no_coordinates = std::numeric_limits<std::uint32_t>::max();
  struct Triangle {
    std::array<glm::dvec3, 3> corners{};
    std::array<glm::dvec3, 3> normals{};
    bool has_normals = false;
    bool emits = false;
    std::uint32_t coordinates = no_coordinates;  ///< in `coordinates_`
    std::size_t surface = 0;
  };
  /// The triangles of the tree: `numbers` are indices of triangles that were added, or, from
  /// `triangles_.size()` on, of pieces.
  struct KeptTriangles {
    /// A piece of a triangle that was cut.
    struct Piece {
      std::uint32_t source;  ///< in `triangles_`
      glm::dvec3 normal;     ///< of the whole, unit
      TrianglePiece shape;   ///< its corners
    };
    std::vector<std::uint32_t> numbers;
    std::vector<Piece> pieces;
    std::size_t whole_count = 0;  ///< triangles that have an area
  };
  struct Sphere {
    glm::dvec3 center;
    double radius;
    bool normal_points_inward;
    std::size_t surface;
    glm::dmat3 axes;
  };
  /// Shapes in the scene's own space, and the box and the ball around them.
  struct MovedShapes {
    std::vector<TriangleCorners<T>> corners;
    KeptTriangles kept;
    std::vector<SphereShape<T>> balls;
    std::vector<SharpEdges> sharp;
    Box<double> box;
    glm::dvec3 center{0};
    double radius = 1;
    ReceiverBall receivers;  ///< around the shapes that do not shine
  };
  struct PointLight {
    glm::dvec3 position, intensity;
  };
  struct SpotLight {
    glm::dvec3 position, direction, intensity;
    double inner, outer;
  };
  static constexpr std::uint32_t no_light = std::numeric_limits<std::uint32_t>::max();
  /// From the camera: the third power must be finite in T, and distances within the range of float,
  /// which the tree orders its nodes by.
  static constexpr double largest_coordinate = std::same_as<T, float> ? 1e12 : 1e37;

  [[noreturn]] static void fail(const std::string& what) { reject_argument(what.c_str()); }
  /// The place `v` of the world as seen from `origin`.
  [[nodiscard]] static Vec3<T> moved_to(const glm::dvec3& origin, const glm::dvec3& v) {
    const glm::dvec3 moved = v - origin;
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(moved[axis]) < largest_coordinate)) fail("a shape or a light is too far from the camera");
    return Vec3<T>(moved);
  }
  static void check_color(const glm::dvec3& v) {
    for (int c = 0; c < 3; ++c)
      if (!(v[c] >= 0 && v[c] < static_cast<double>(std::numeric_limits<T>::max())))
        fail("the colour of a light must be finite and not negative");
  }
  void check_surface(std::size_t material, const std::optional<AreaEmission>& emission) const {
    if (material >= materials_.size()) fail("a shape refers to a material that was not added");
    if (emission) check_color(emission->radiance);
  }
  /// The radiance of a light that varies or has holes.
  std::size_t add_pattern(const AreaEmission& emission, const typename Texture<T>::Handle& texture,
                          const Material& material) {
    EmissionPattern<T> pattern;
    pattern.radiance = Texture<T>::constant(emission.radiance);
    if (texture) {
      if (min_channel(texture->lower()) < T(0)) fail("the radiance of a light must not be negative");
      pattern.radiance = Texture<T>::product(pattern.radiance, texture);
    }
    if (cuts(material)) {
      if constexpr (requires { material.textures->opacity; })
        pattern.opacity = material.textures->opacity;
      else
        fail("a surface with an opacity of your own cannot be a light");
    }
    patterns_.push_back(std::move(pattern));
    return patterns_.size() - 1;
  }
  [[nodiscard]] static bool varies(const Material& material) {
    if constexpr (VaryingSurfaceModel<Bsdf_, T>) return material.is_varying;
    return false;
  }
  [[nodiscard]] static bool cuts(const Material& material) {
    if constexpr (VaryingSurfaceModel<Bsdf_, T>) return has_opacity(material);
    return false;
  }
  [[nodiscard]] bool emits(const Sphere& sphere) const {
    const auto& emission = surfaces_[sphere.surface].emission;
    return emission && !is_black(emission->radiance);
  }

  /// Moves the shapes into the scene's own space. Triangles that have no area there are left out,
  /// large ones are cut.
  [[nodiscard]] MovedShapes moved_shapes(const glm::dvec3& origin) const {
    MovedShapes shapes;
    const auto cutter = LargeTriangleCutter::for_precision<T>(farthest_corner(origin));
    for (std::size_t i = 0; i < triangles_.size(); ++i) add_moved(i, origin, cutter, shapes);
    for (const Sphere& sphere : spheres_)
      shapes.balls.push_back({moved_to(origin, sphere.center), static_cast<T>(sphere.radius)});
    enclose(shapes);
    std::vector<T> errors;
    for (std::size_t i = 0; i < shapes.corners.size(); ++i)
      errors.push_back(position_error(shapes.corners[i], normal_of(shapes.kept, i, shapes.corners[i])));
    shapes.sharp = find_sharp_edges<T>(shapes.corners, errors);
    return shapes;
  }
  /// Adds the triangle with this number, whole or in pieces, unless it has no area.
  void add_moved(std::size_t i, const glm::dvec3& origin, const LargeTriangleCutter& cutter,
                 MovedShapes& shapes) const {
    KeptTriangles& kept = shapes.kept;
    TriangleCorners<T> moved;
    for (std::size_t corner = 0; corner < 3; ++corner) moved[corner] = moved_to(origin, triangles_[i].corners[corner]);
    const glm::dvec3 normal = area_normal(moved);
    if (!(static_cast<T>(glm::length(normal)) >= std::numeric_limits<T>::min())) return;
    ++kept.whole_count;
    const std::array<glm::dvec3, 3> exact{triangles_[i].corners[0] - origin, triangles_[i].corners[1] - origin,
                                          triangles_[i].corners[2] - origin};
    const std::size_t first_piece = kept.pieces.size();
    if (!triangles_[i].emits)  // a light stays one
      cutter.for_each_piece(exact, [&](const TrianglePiece& piece) {
        kept.pieces.push_back({static_cast<std::uint32_t>(i), glm::normalize(normal), piece});
      });
    if (kept.pieces.size() - first_piece < 2) {
      kept.pieces.resize(first_piece);
      shapes.corners.push_back(moved);
      kept.numbers.push_back(static_cast<std::uint32_t>(i));
      return;
    }
    for (std::size_t p = first_piece; p < kept.pieces.size(); ++p) {
      const auto& ends = kept.pieces[p].shape.corners;
      shapes.corners.push_back({Vec3<T>(ends[0]), Vec3<T>(ends[1]), Vec3<T>(ends[2])});
      kept.numbers.push_back(static_cast<std::uint32_t>(triangles_.size() + p));
    }
  }
  /// Sets the box and the ball around all shapes, and the ball around those that do not shine.
  void enclose(MovedShapes& shapes) const {
    const auto always = [](std::size_t) { return true; };
    const Enclosure all = enclosure_of(shapes.corners, shapes.balls, always, always);
    shapes.box = all.box;
    shapes.center = all.center;
    constexpr double unit = static_cast<double>(std::numeric_limits<T>::epsilon());
    if (all.radius > 0) shapes.radius = all.radius * (1 + 64 * unit) + 8 * unit * glm::length(shapes.center);
    const Enclosure dark = enclosure_of(
        shapes.corners, shapes.balls, [&](std::size_t i) { return !source_of(shapes.kept, i).emits; },
        [&](std::size_t i) { return !emits(spheres_[i]); });
    shapes.receivers = {dark.center, dark.box.is_empty() ? -1 : dark.radius};
  }
  /// The largest distance of a triangle's corner from `origin`.
  [[nodiscard]] double farthest_corner(const glm::dvec3& origin) const {
    double farthest = 0;
    for (const Triangle& triangle : triangles_)
      for (const glm::dvec3& corner : triangle.corners) farthest = std::max(farthest, glm::length(corner - origin));
    return farthest;
  }
  /// Coordinates (u, v) at barycentric weights; those of a corner itself to the bit.
  [[nodiscard]] static glm::dvec2 interpolated(const TriangleCoordinates<T>& uv, const glm::dvec3& weights) {
    return glm::dvec2(uv[0]) * weights[0] + glm::dvec2(uv[1]) * weights[1] + glm::dvec2(uv[2]) * weights[2];
  }

  [[nodiscard]] const typename KeptTriangles::Piece* piece_of(const KeptTriangles& kept, std::size_t i) const {
    return kept.numbers[i] < triangles_.size() ? nullptr : &kept.pieces[kept.numbers[i] - triangles_.size()];
  }
  [[nodiscard]] const Triangle& source_of(const KeptTriangles& kept, std::size_t i) const {
    const auto* const piece = piece_of(kept, i);
    return triangles_[piece == nullptr ? kept.numbers[i] : piece->source];
  }
  /// Unit, that of the whole triangle: the rounding of a piece's corners counts for more.
  [[nodiscard]] glm::dvec3 normal_of(const KeptTriangles& kept, std::size_t i,
                                     const TriangleCorners<T>& corners) const {
    const auto* const piece = piece_of(kept, i);
    return piece == nullptr ? glm::normalize(area_normal(corners)) : piece->normal;
  }
  [[nodiscard]] glm::dmat3 weights_of(const KeptTriangles& kept, std::size_t i) const {
    const auto* const piece = piece_of(kept, i);
    return piece == nullptr ? glm::dmat3(1) : piece->shape.weights;
  }

  /// The effects that the kept shapes and lights make possible.
  [[nodiscard]] Effects derived_effects(const Scene& scene, const KeptTriangles& kept) const {
    Effects effects;
    std::vector<bool> is_used(materials_.size(), false);
    for (std::size_t i = 0; i < kept.numbers.size(); ++i) {
      const Triangle& triangle = source_of(kept, i);
      is_used[surfaces_[triangle.surface].material] = true;
      effects.shading_normals = effects.shading_normals || triangle.has_normals;
    }
    for (const Sphere& sphere : spheres_) is_used[surfaces_[sphere.surface].material] = true;
    for (std::size_t i = 0; i < materials_.size(); ++i)
      if (is_used[i]) add_effects_of(materials_[i], effects);

    for (const Light<T>& light : scene.lights_) {
      if (!(light.power() > 0)) continue;
      if (!light.is_delta())
        (light.is_infinite() ? effects.environment_lights : effects.area_lights) = true;
      else if (light.is_infinite())
        effects.directional_lights = true;
      else
        (light.is_spot() ? effects.spot_lights : effects.point_lights) = true;
    }
    effects.thin_lens = camera_->lens_radius > 0;
    return effects;
  }

  /// Around the surfaces of each material that is a boundary of media.
  [[nodiscard]] std::vector<Box<T>> absorbing_boxes(const std::vector<TriangleCorners<T>>& corners,
                                                    const KeptTriangles& kept,
                                                    const std::vector<SphereShape<T>>& balls) const {
    std::vector<Box<T>> boxes(materials_.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::size_t material = surfaces_[source_of(kept, i).surface].material;
      if (boundary_of<T>(materials_[material]) != nullptr)
        for (const Vec3<T>& corner : corners[i]) boxes[material].add(corner);
    }
    for (std::size_t i = 0; i < balls.size(); ++i) {
      const std::size_t material = surfaces_[spheres_[i].surface].material;
      if (boundary_of<T>(materials_[material]) == nullptr) continue;
      boxes[material].add(balls[i].center - balls[i].radius);
      boxes[material].add(balls[i].center + balls[i].radius);
    }
    std::erase_if(boxes, [](const Box<T>& box) { return box.is_empty(); });
    return boxes;
  }

  /// One light per emitting primitive, then the others.
  void add_lights(Scene& scene, const MovedShapes& shapes, const glm::dvec3& origin) const {
    std::vector<Light<T>>& lights = scene.lights_;
    std::vector<std::size_t> groups;  // triangles of one mesh are a light to its user
    for (std::size_t i = 0; i < shapes.corners.size(); ++i)
      if (source_of(shapes.kept, i).emits) {
        lights.push_back(light_of(scene, shapes, i));
        groups.push_back(source_of(shapes.kept, i).surface);
      }
    const auto& balls = shapes.balls;
    for (std::size_t i = 0; i < balls.size(); ++i) {
      if (!emits(spheres_[i])) continue;
      const AreaEmission& emission = *surfaces_[spheres_[i].surface].emission;
      lights.push_back(Light<T>::sphere(balls[i].center, balls[i].radius, spheres_[i].normal_points_inward,
                                        position_error(balls[i]), Vec3<T>(emission.radiance), emission.is_two_sided));
    }
    for (const PointLight& light : point_lights_)
      lights.push_back(Light<T>::point(moved_to(origin, light.position), Vec3<T>(light.intensity)));
    for (const SpotLight& light : spot_lights_)
      lights.push_back(Light<T>::spot(moved_to(origin, light.position),
                                      SpotCone<T>(Vec3<T>(glm::normalize(light.direction)), light.inner, light.outer),
                                      Vec3<T>(light.intensity)));
    for (Light<T> light : infinite_lights_) {
      light.enclose(Vec3<T>(shapes.center), static_cast<T>(shapes.radius));
      lights.push_back(light);
    }

    while (groups.size() < lights.size()) groups.push_back(surfaces_.size() + groups.size());
    std::uint16_t group = 0;
    for (std::size_t i = 0; i < lights.size(); ++i) {
      if (i > 0 && groups[i] != groups[i - 1] && group + 1 < Scene::most_light_groups) ++group;
      lights[i].set_group(group);
    }
    std::vector<double> powers = powers_towards(shapes.receivers, lights);
    keep_local_lights(lights, powers);
    choose_lights_by(scene, powers, groups);
  }
  /// The light that a triangle is.
  [[nodiscard]] Light<T> light_of(const Scene& scene, const MovedShapes& shapes, std::size_t i) const {
    const Triangle& triangle = source_of(shapes.kept, i);
    const Surface& surface = surfaces_[triangle.surface];
    const TriangleCorners<T>& corners = shapes.corners[i];
    const glm::dvec3 normal = normal_of(shapes.kept, i, corners);
    Vec3<T> radiance(surface.emission->radiance);
    const EmissionPattern<T>* pattern = nullptr;
    TriangleCoordinates<T> uv{};
    if (surface.pattern != no_pattern) {
      pattern = &scene.emission_patterns_[surface.pattern];
      uv = coordinates_[triangle.coordinates];
      radiance = pattern->mean_on(uv);
    }
    return Light<T>::triangle(corners[0], corners[1], corners[2], Vec3<T>(normal), position_error(corners, normal),
                              radiance, surface.emission->is_two_sided, shapes.sharp[i], pattern, uv);
  }
  void choose_lights_by(Scene& scene, const std::vector<double>& powers, std::span<const std::size_t> groups) const {
    std::vector<Light<T>>& lights = scene.lights_;
    scene.light_choice_ = AliasTable<T>(powers);
    const std::vector<double> chances = scene.light_choice_.realised_probabilities();
    for (std::size_t i = 0; i < lights.size(); ++i) {
      if (!chances.empty()) lights[i].set_selection_probability(static_cast<T>(chances[i]));
      if (lights[i].is_infinite()) scene.infinite_lights_.push_back(&lights[i]);
    }
    if (light_selection_ == LightSelection::by_power || scene.light_choice_.is_empty()) return;
    scene.light_hierarchy_ = LightHierarchyBuilder<T>::build(lights, groups);
    if (light_selection_ == LightSelection::by_receiver)
      scene.receiver_choice_ = ReceiverChoice::always;
    else if (scene.light_hierarchy_.has_choice())
      scene.receiver_choice_ = ReceiverChoice::where_it_pays;
  }

  void fill_slots(Scene& scene, const BuiltBvh<T>& built, const MovedShapes& shapes) const {
    const auto& corners = shapes.corners;
    const auto& kept = shapes.kept;
    const auto& balls = shapes.balls;
    // Lights were added in the order of the shapes.
    std::uint32_t next_light = 0;
    std::vector<std::uint32_t> light_of_triangle(corners.size(), no_light), light_of_sphere(balls.size(), no_light);
    for (std::size_t i = 0; i < corners.size(); ++i)
      if (source_of(kept, i).emits) light_of_triangle[i] = next_light++;
    for (std::size_t i = 0; i < balls.size(); ++i)
      if (emits(spheres_[i])) light_of_sphere[i] = next_light++;
    const auto light_at = [&](std::uint32_t number) { return number == no_light ? nullptr : &scene.lights_[number]; };

    scene.triangles_.resize(built.triangle_in_slot.size());
    scene.sharp_edges_.resize(built.triangle_in_slot.size());
    const bool has_varying = std::any_of(materials_.begin(), materials_.end(), varies) || !patterns_.empty();
    if (has_varying) scene.coordinates_.resize(built.triangle_in_slot.size());
    if (has_varying) scene.sphere_axes_.resize(built.sphere_in_slot.size());
    scene.has_cut_surfaces_ = std::any_of(surfaces_.begin(), surfaces_.end(),
                                          [&](const Surface& surface) { return cuts(materials_[surface.material]); });
    for (std::size_t slot = 0; slot < built.triangle_in_slot.size(); ++slot)
      if (const std::uint32_t i = built.triangle_in_slot[slot]; i != BuiltBvh<T>::empty_slot)
        fill_triangle(scene, slot, shapes, i, light_at(light_of_triangle[i]));
    scene.spheres_.resize(built.sphere_in_slot.size());
    for (std::size_t slot = 0; slot < built.sphere_in_slot.size(); ++slot) {
      const std::uint32_t i = built.sphere_in_slot[slot];
      if (i == BuiltBvh<T>::empty_slot) continue;
      if (has_varying)
        for (int axis = 0; axis < 3; ++axis)
          scene.sphere_axes_[slot][static_cast<std::size_t>(axis)] = Vec3<T>(spheres_[i].axes[axis]);
      scene.spheres_[slot] = {balls[i].center,
                              balls[i].radius,
                              spheres_[i].normal_points_inward ? T(-1) : T(1),
                              position_error(balls[i]),
                              &scene.materials_[surfaces_[spheres_[i].surface].material],
                              light_at(light_of_sphere[i])};
    }
  }

  /// Fills in triangle `i`, which the tree has in this slot.
  void fill_triangle(Scene& scene, std::size_t slot, const MovedShapes& shapes, std::size_t i,
                     const Light<T>* light) const {
    const Triangle& source = source_of(shapes.kept, i);
    const TriangleCorners<T>& corners = shapes.corners[i];
    const glm::dvec3 normal = normal_of(shapes.kept, i, corners);
    auto& triangle = scene.triangles_[slot];
    const T error = position_error(corners, normal);
    triangle = {Vec3<T>(normal),
                error,
                &scene.materials_[surfaces_[source.surface].material],
                light,
                Scene::Triangle::flat,
                largest_edge_margin(corners, shapes.sharp[i], error)};
    scene.sharp_edges_[slot] = shapes.sharp[i];
    const glm::dmat3 weights = weights_of(shapes.kept, i);
    if (source.coordinates != no_coordinates) {
      const TriangleCoordinates<T>& whole = coordinates_[source.coordinates];
      for (int corner = 0; corner < 3; ++corner)
        scene.coordinates_[slot][static_cast<std::size_t>(corner)] = Vec2<T>(interpolated(whole, weights[corner]));
    }
    if (!source.has_normals) return;
    triangle.vertex_normals = static_cast<std::uint32_t>(scene.vertex_normals_.size());
    std::array<glm::dvec3, 3> normals = source.normals;
    for (glm::dvec3& n : normals) {
      const double length = glm::length(n);
      n = length > 0 ? n / length : normal;
    }
    for (int corner = 0; corner < 3; ++corner)
      scene.vertex_normals_.push_back(
          Vec3<T>(normals[0] * weights[corner][0] + normals[1] * weights[corner][1] + normals[2] * weights[corner][2]));
  }

  std::vector<Material> materials_;
  std::vector<Surface> surfaces_;
  std::vector<Triangle> triangles_;
  std::vector<TriangleCoordinates<T>> coordinates_;
  std::vector<EmissionPattern<T>> patterns_;
  std::vector<Sphere> spheres_;
  std::vector<PointLight> point_lights_;
  std::vector<SpotLight> spot_lights_;
  std::vector<Light<T>> infinite_lights_;
  std::vector<std::shared_ptr<const EnvironmentMap<T>>> environment_maps_;
  std::optional<CameraDescription> camera_;
  LightSelection light_selection_ = LightSelection::by_power;
};

template <std::floating_point T, SurfaceModel<T> Bsdf_>
BvhScene<T, Bsdf_> SceneBuilder<T, Bsdf_>::build(ExecutorRef executor) const {
  if (!camera_) fail("the scene has no camera");
  const glm::dvec3 origin(camera_->world_from_camera[3]);
  Scene scene(Camera<T>(*camera_, origin));
  scene.materials_ = materials_;
  scene.environment_maps_ = environment_maps_;
  scene.emission_patterns_ = patterns_;

  const MovedShapes shapes = moved_shapes(origin);
  const auto& [corners, kept, balls, sharp, box, center, radius, receivers] = shapes;
  BuiltBvh<T> built = BvhBuilder<T>(corners, balls).build(executor);
  scene.bvh_ = std::move(built.bvh);
  add_lights(scene, shapes, origin);
  fill_slots(scene, built, shapes);
  scene.effects_ = derived_effects(scene, kept);
  scene.absorbing_boxes_ = absorbing_boxes(corners, kept, balls);
  scene.has_absorption_ = !scene.absorbing_boxes_.empty();

  SceneStatistics& statistics = scene.statistics_;
  statistics.triangle_count = kept.whole_count;
  statistics.sphere_count = balls.size();
  statistics.degenerate_triangle_count = triangles_.size() - kept.whole_count;
  statistics.light_count = scene.lights_.size();
  statistics.bvh_bytes = scene.bvh_.byte_count();
  statistics.half_diagonal = box.is_empty() ? 0 : glm::length(box.upper - box.lower) * 0.5;
  statistics.bounding_radius = radius;
  statistics.world_origin = origin;
  return scene;
}

#ifdef GMIS_COMPILED
extern template class SceneBuilder<float>;
extern template class SceneBuilder<double>;
#endif

}  // namespace gmis::scene
