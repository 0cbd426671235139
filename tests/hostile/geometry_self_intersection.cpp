#include <cstdint>
#include <cstdio>
#include <utility>

#include "gmis/core/interaction.hpp"
#include "gmis/scene/cut_large_triangles.hpp"
#include "hostile/geometry_shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// Rays that leave surfaces: none may meet the surface it leaves, none may slip through an edge.
// Sizes 1e-4 to 1e6; the camera, which is where the scene's own space has its origin, is up to 1e4
// sizes away in float and 1e9 in double, and the world's origin up to 1e9 from both. What is true
// is known of spheres, planes and convex bodies, and worked out in double precision from the
// corners as they were given. A few random rays in each run, ten million in the slow test.

using namespace gmis;
using namespace gmis::scene;
using namespace hostile;
using scene_test::camera_at;
using scene_test::random_direction;
using scene_test::random_square;

namespace {

struct Tally {
  std::uint64_t rays = 0;
  std::uint64_t leaks = 0;          ///< a ray that had to meet a surface met none
  std::uint64_t false_shadows = 0;  ///< a ray met a surface that it had left, or one that was not in its way
  std::uint64_t wrong_places = 0;   ///< a hit that is not where it must be

  /// Counts a false shadow unless both queries say that nothing is in the way of this ray.
  template <class Scene, class Ray>
  void expect_nothing(const Scene& scene, const Ray& ray) {
    rays += 2;
    if (scene.intersect(ray) || !scene.visible(ray)) ++false_shadows;
  }
  void report(const char* what, const char* scalar) const {
    std::printf("%s, %s: %llu rays, %llu leaks, %llu false shadows, %llu in wrong places\n", what, scalar,
                static_cast<unsigned long long>(rays), static_cast<unsigned long long>(leaks),
                static_cast<unsigned long long>(false_shadows), static_cast<unsigned long long>(wrong_places));
  }
};

template <std::floating_point T>
constexpr const char* name_of = std::same_as<T, float> ? "float" : "double";

/// Where a shape of one size may be: in the world, and from the camera.
template <std::floating_point T>
struct Placement {
  double size;
  glm::dvec3 camera;  ///< in the world
  glm::dvec3 center;  ///< from the camera

  explicit Placement(Philox& source)
      : size(random_magnitude(source, -4, 6)),
        camera(random_in_cube(source) * size * random_magnitude(source, 0, 9)),
        center(glm::dvec3(random_direction<double>(source)) * size *
               random_magnitude(source, -1, std::same_as<T, float> ? 4 : 9)) {
    if (uniform<double>(source) < 0.1) center = glm::dvec3(0);
    if (uniform<double>(source) < 0.5) camera = glm::dvec3(0);
  }
};

template <std::floating_point T>
Tally spheres(std::uint64_t rays, std::uint64_t seed) {
  Philox source(gmis_test::seed(seed));
  Tally tally;
  while (tally.rays < rays) {
    const Placement<T> at(source);
    const bool inward = uniform<double>(source) < 0.5;
    SceneBuilder<T> builder;
    builder.add_sphere(at.camera + at.center, at.size, builder.add_material(make_dielectric<T>(1.5)), {}, inward);
    builder.set_camera(camera_at(at.camera));
    const auto scene = builder.build();
    for (int i = 0; i < 300; ++i) {
      const glm::dvec3 target = at.center + random_in_cube(source) * at.size * 0.55;
      const glm::dvec3 from = at.center + glm::dvec3(random_direction<double>(source)) * at.size *
                                              (i % 3 == 0 ? 0.5 : 1.2 * random_magnitude(source, 0, 3));
      ++tally.rays;
      const auto hit = scene.intersect({Vec3<T>(from), Vec3<T>(glm::normalize(target - from))});
      if (!hit) {
        ++tally.leaks;
        continue;
      }
      const Vec3<T> outward = inward ? -hit->point.geometric_normal : hit->point.geometric_normal;
      const Vec3<T> away = direction_on_side(outward, T(1), source);
      tally.expect_nothing(scene, leave(hit->point, away));
      const Vec3<T> inside = direction_on_side(outward, T(-1), source);
      ++tally.rays;
      const auto far = scene.intersect(leave(hit->point, inside));
      if (!far) {
        ++tally.leaks;
        continue;
      }
      // The chord is 2 r cos; of a grazing one the offset is most of the depth, and lengthens it to
      // √(2 r offset).
      const double chord = -2 * at.size * glm::dot(glm::dvec3(outward), glm::dvec3(inside));
      const double found = glm::length(glm::dvec3(far->point.position) - glm::dvec3(hit->point.position));
      const double error = static_cast<double>(hit->point.position_error);
      if (!(std::abs(found - chord) < 8 * std::sqrt(error * at.size) + 1e-5 * chord)) ++tally.wrong_places;
    }
  }
  tally.report("spheres", name_of<T>);
  return tally;
}

template <std::floating_point T>
Tally triangles(std::uint64_t rays, std::uint64_t seed) {
  Philox source(gmis_test::seed(seed));
  Tally tally;
  std::uint64_t missed = 0;
  while (tally.rays < rays) {
    const Placement<T> at(source);
    Mesh mesh;
    mesh.triangles = {{0, 1, 2}};
    const bool is_thin = uniform<double>(source) < 0.25, is_aligned = uniform<double>(source) < 0.25;
    for (int k = 0; k < 3; ++k) {
      glm::dvec3 corner = random_in_cube(source) * (is_thin && k > 0 ? 0.01 : 1.0);
      if (is_aligned) corner.x = 0;
      mesh.positions.push_back(at.camera + at.center + corner * at.size);
    }
    const auto scene = scene_of<T>(mesh, make_diffuse<T>({.5, .5, .5}), at.camera);
    for (int i = 0; i < 100; ++i) {
      const Vec2<double> b = square_to_triangle(random_square<double>(source));
      const glm::dvec3 target =
          mesh.positions[0] * (1 - b.x - b.y) + mesh.positions[1] * b.x + mesh.positions[2] * b.y - at.camera;
      const glm::dvec3 from = target + random_in_cube(source) * at.size * random_magnitude(source, -2, 2);
      ++tally.rays;
      const auto hit = scene.intersect({Vec3<T>(from), Vec3<T>(glm::normalize(target - from))});
      if (!hit) {  // far from the camera rounding may take the ray past it
        ++missed;
        continue;
      }
      for (const T side : {T(1), T(-1)}) {
        const Vec3<T> away = direction_on_side(hit->point.geometric_normal, side, source);
        tally.expect_nothing(scene, leave(hit->point, away));
      }
    }
  }
  tally.report("triangles", name_of<T>);
  CHECK(missed < tally.rays / 10);
  return tally;
}

/// Corners of the pieces into which the faces of a mesh, seen from `eye`, are cut; those of the
/// faces where none is.
template <std::floating_point T>
std::vector<glm::dvec3> corners_of_pieces(const Mesh& mesh, const glm::dvec3& eye) {
  double farthest = 0;
  for (const glm::dvec3& position : mesh.positions) farthest = std::max(farthest, glm::length(position - eye));
  std::vector<glm::dvec3> corners;
  for (const auto& triangle : mesh.triangles) {
    std::array<glm::dvec3, 3> face{};
    for (std::size_t k = 0; k < 3; ++k) face[k] = mesh.positions[static_cast<std::size_t>(triangle[k])] - eye;
    LargeTriangleCutter::for_precision<T>(farthest).for_each_piece(face, [&](const TrianglePiece& piece) {
      corners.insert(corners.end(), piece.corners.begin(), piece.corners.end());
    });
  }
  return corners;
}

/// Closed convex bodies: half of the rays go to an edge or a corner, exactly or nearly. With
/// `is_near` the camera is so near a body that most have faces that are cut, and rays go to the
/// corners of the pieces.
template <std::floating_point T>
Tally bodies(std::uint64_t rays, std::uint64_t seed, bool is_near = false) {
  Philox source(gmis_test::seed(seed));
  Tally tally;
  std::uint64_t undecided = 0;
  while (tally.rays < rays) {
    Placement<T> at(source);
    Body body = random_body(source);
    if (is_near) at.center = point_near_edge(body.mesh, source) * (-random_magnitude(source, -0.5, 0.3) * at.size);
    Mesh moved = body.mesh;
    for (auto& position : moved.positions) position = at.camera + at.center + position * at.size;
    const auto scene = scene_of<T>(moved, make_dielectric<T>(1.5), at.camera);
    const std::vector<glm::dvec3> corners =
        is_near ? corners_of_pieces<T>(moved, at.camera) : std::vector<glm::dvec3>{};
    const auto point_near_piece = [&] {
      const auto i = static_cast<std::size_t>(uniform<double>(source) * static_cast<double>(corners.size()));
      const double off = uniform<double>(source) < 0.3 ? 0.0 : random_magnitude(source, -9, -3);
      return corners[i] + random_in_cube(source) * (off * at.size);
    };
    const auto point_inside = [&] { return at.center + random_in_cube(source) * (0.5 * body.inner * at.size); };
    const auto point_outside = [&] {
      return at.center + glm::dvec3(random_direction<double>(source)) * at.size * random_magnitude(source, 0.1, 2);
    };
    const auto aim = [&](const glm::dvec3& from) {
      const glm::dvec3 target =
          uniform<double>(source) < 0.5
              ? (is_near ? point_near_piece() : at.center + point_near_edge(body.mesh, source) * at.size)
              : from + glm::dvec3(random_direction<double>(source));
      const Vec3<T> origin(from);
      return Ray<T>{origin, Vec3<T>(glm::normalize(target - glm::dvec3(origin)))};
    };
    /// How far a point of the scene is above the plane of a hit, in double.
    const auto height = [](const auto& hit, const Vec3<T>& of) {
      return glm::dot(glm::dvec3(of) - glm::dvec3(hit.point.position), glm::dvec3(hit.point.geometric_normal));
    };
    std::optional<typename BvhScene<T>::Hit> last;
    for (int i = 0; i < 100; ++i) {
      // From inside something is met; from outside too, on the way to the inside.
      const glm::dvec3 from = i % 4 == 0 ? point_outside() : point_inside();
      const Ray<T> ray = i % 4 == 0 ? Ray<T>{Vec3<T>(from), Vec3<T>(glm::normalize(point_inside() - from))} : aim(from);
      ++tally.rays;
      const auto hit = scene.intersect(ray);
      if (!hit) {
        ++tally.leaks;
        continue;
      }
      const Vec3<T> normal = hit->point.geometric_normal;
      if ((glm::dot(normal, ray.direction) > T(0)) == (i % 4 == 0)) ++tally.wrong_places;

      // Outwards nothing is met, inwards another face.
      const Vec3<T> out = direction_on_side(normal, T(1), source);
      tally.expect_nothing(scene, leave(hit->point, out));
      const Vec3<T> in = direction_on_side(normal, T(-1), source);
      ++tally.rays;
      const auto next = scene.intersect(leave(hit->point, in));
      if (!next)
        ++tally.leaks;
      else if (next->point.geometric_normal == normal)
        ++tally.false_shadows;

      // A point outside is seen when it is above the face, and else hidden by the body.
      const SurfacePoint<T> free{Vec3<T>(point_outside()), {}, {}, T(0)};
      const auto link = [](const SurfacePoint<T>& a, const SurfacePoint<T>& b) {
        return segment(a, b, Vec3<T>(glm::normalize(b.position - a.position)));
      };
      const double above = height(*hit, free.position);
      if (std::abs(above) > 2 * static_cast<double>(hit->point.position_error)) {
        tally.rays += 2;
        for (const Ray<T>& shadow : {link(hit->point, free), link(free, hit->point)})
          if (scene.visible(shadow) != (above > 0)) ++(above > 0 ? tally.false_shadows : tally.leaks);
      } else {
        ++undecided;
      }

      // Two points of the inside see each other. Nearer to the other's face than the error of a
      // position there is no saying on which side of it they are.
      if (last && last->point.geometric_normal != normal) {
        const double bound = 2 * static_cast<double>(hit->point.position_error + last->point.position_error);
        if (height(*hit, last->point.position) < -bound && height(*last, hit->point.position) < -bound) {
          // A ray ends before its target by its own rounding as well, 4 ε of its length. On a piece
          // near the camera that may be more than the errors by which points are kept off edges,
          // where the ray comes from afar: a limit of `segment`.
          const T reach =
              T(4) * std::numeric_limits<T>::epsilon() * glm::length(hit->point.position - last->point.position);
          for (const auto& [start, end] : {std::pair(hit->point, last->point), std::pair(last->point, hit->point)}) {
            if (is_near && reach > end.position_error) continue;
            ++tally.rays;
            if (!scene.visible(link(start, end))) ++tally.false_shadows;
          }
        } else {
          ++undecided;
        }
      }
      last = hit;
    }
  }
  tally.report(is_near ? "bodies cut into pieces" : "bodies", name_of<T>);
  CHECK(undecided < tally.rays / 50);
  return tally;
}

template <std::floating_point T>
void check_all(std::uint64_t rays, std::uint64_t seed) {
  for (const Tally& tally : {spheres<T>(rays, seed), triangles<T>(rays, seed + 1), bodies<T>(rays, seed + 2),
                             bodies<T>(rays, seed + 3, true)}) {
    CHECK(tally.rays >= rays);
    CHECK(tally.leaks == 0);
    CHECK(tally.false_shadows == 0);
    CHECK(tally.wrong_places == 0);
  }
}

TEMPLATE_TEST_CASE("hostile: no ray that leaves a sphere, a triangle or a closed body leaks or meets it again",
                   "[hostile][geometry]", float, double) {
  check_all<TestType>(100'000, 301);
}

TEMPLATE_TEST_CASE(
    "hostile: none of ten million rays that leave a sphere, a triangle or a closed body leaks or meets it again",
    "[.][slow]", float, double) {
  check_all<TestType>(10'000'000, 401);
}

}  // namespace
