#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "fuzz/input.hpp"
#include "gmis/scene/bvh_build.hpp"

// The tree against brute force: a ray through the tree of all primitives meets what it meets
// through a tree of each alone. The test of a primitive is the same there, so that only the tree
// can make a difference; where rounding decides whether a primitive is hit at all, or which of two
// is nearer (its box and it are then told apart by rounding too), long double says so.

namespace {

using namespace gmis;
using namespace gmis::scene;
using Long = glm::vec<3, long double>;

/// Coordinates on a coarse grid, where ties are many, or anywhere in a range.
float coordinate(fuzz::Input& input) {
  const auto kind = input.below(8);
  const auto value = static_cast<float>(static_cast<std::int8_t>(input.byte()));
  switch (kind) {
    case 0:
      return value * 1000.0F;
    case 1:
      return value * 1e-4F;
    case 2:
      return value + static_cast<float>(input.byte()) / 256.0F;
    default:
      return std::round(value / 16.0F);
  }
}
Vec3<float> point(fuzz::Input& input) {
  const float x = coordinate(input), y = coordinate(input), z = coordinate(input);
  return {x, y, z};
}

/// How far inside the primitive its line passes, relative to its size: near 0, rounding decides.
long double margin_of(const TriangleCorners<float>& corners, const Ray<float>& ray) {
  const Long d(ray.direction), s = Long(ray.origin) - Long(corners[0]);
  const Long ab = Long(corners[1]) - Long(corners[0]), ac = Long(corners[2]) - Long(corners[0]), p = glm::cross(d, ac);
  const long double determinant = glm::dot(ab, p);
  if (std::abs(determinant) < 1e-5L * glm::length(ab) * glm::length(ac)) return 0;  // edge-on
  const long double u = glm::dot(s, p) / determinant, v = glm::dot(d, glm::cross(s, ab)) / determinant;
  // Seen from afar, rounding moves the ray by a part of the distance.
  const long double reach = 1e-5L * (1 + glm::length(s) / std::min(glm::length(ab), glm::length(ac)));
  return std::abs(std::min({u, v, 1 - u - v})) / reach;
}
long double margin_of(const SphereShape<float>& sphere, const Ray<float>& ray) {
  const Long f = Long(ray.origin) - Long(sphere.center), d(ray.direction);
  const long double b = glm::dot(f, d), r = sphere.radius;
  const long double reach = 1e-5L * (1 + glm::length(f) / r);
  return std::abs((b * b - glm::dot(f, f) + r * r) / (r * r)) / reach;
}

/// Where the line really meets the primitive. A long thin triangle's `t` in float can be off by
/// more than all the rest.
long double true_t_of(const TriangleCorners<float>& corners, const Ray<float>& ray, float t) {
  const Long normal = glm::cross(Long(corners[1]) - Long(corners[0]), Long(corners[2]) - Long(corners[0]));
  const long double slope = glm::dot(Long(ray.direction), normal);
  if (slope == 0) return t;  // exactly edge-on: every t is as good
  return glm::dot(Long(corners[0]) - Long(ray.origin), normal) / slope;
}
/// The hit of a sphere that is nearer to `t`.
long double true_t_of(const SphereShape<float>& sphere, const Ray<float>& ray, float t) {
  const Long f = Long(ray.origin) - Long(sphere.center), d(ray.direction);
  const long double a = glm::dot(d, d), b = glm::dot(f, d), r = sphere.radius;
  const long double root = std::sqrt(std::max(b * b - a * (glm::dot(f, f) - r * r), 0.0L));
  const long double first = (-b - root) / a, second = (-b + root) / a;
  return std::abs(first - t) < std::abs(second - t) ? first : second;
}

template <class Primitive>
BvhHit<float> hit_alone(const Primitive& primitive, const Ray<float>& ray) {
  if constexpr (std::same_as<Primitive, SphereShape<float>>)
    return BvhBuilder<float>({}, std::span(&primitive, 1)).build().bvh.closest(ray);
  else
    return BvhBuilder<float>(std::span(&primitive, 1), {}).build().bvh.closest(ray);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const std::size_t triangle_count = input.below(40), sphere_count = input.below(12), ray_count = 1 + input.below(6);
  std::vector<TriangleCorners<float>> triangles;
  std::vector<SphereShape<float>> spheres;
  for (std::size_t i = 0; i < triangle_count; ++i) {
    const TriangleCorners<float> corners{point(input), point(input), point(input)};
    const Long normal = glm::cross(Long(corners[1]) - Long(corners[0]), Long(corners[2]) - Long(corners[0]));
    if (glm::length(normal) > 0) triangles.push_back(corners);  // the builder of scenes leaves out those without area
  }
  for (std::size_t i = 0; i < sphere_count; ++i)
    spheres.push_back({point(input), 0.01F + static_cast<float>(input.between(0.0, 4.0))});
  const auto built = BvhBuilder<float>(triangles, spheres).build();

  for (std::size_t r = 0; r < ray_count; ++r) {
    Ray<float> ray{point(input), point(input)};
    if (input.below(4) == 0) ray.direction[static_cast<int>(input.below(3))] = -0.0F;
    if (input.below(4) == 0) ray.direction[static_cast<int>(input.below(3))] = 0x1p-140F;
    const float length = glm::length(ray.direction);
    if (!(length > 1e-20F)) continue;
    ray.direction /= length;
    const BvhHit<float> hit = built.bvh.closest(ray);

    BvhHit<float> nearest{ray.t_max};
    long double margin = std::numeric_limits<long double>::max(), true_t = margin;
    const auto consider = [&](const auto& primitive) {
      const BvhHit<float> alone = hit_alone(primitive, ray);
      if (alone.kind == BvhChild::nothing || alone.t >= nearest.t) return;
      nearest = alone;
      margin = margin_of(primitive, ray);
      true_t = true_t_of(primitive, ray, alone.t);
    };
    for (const auto& triangle : triangles) consider(triangle);
    for (const auto& sphere : spheres) consider(sphere);

    const bool agrees = (hit.kind == BvhChild::nothing) == (nearest.kind == BvhChild::nothing) && hit.t == nearest.t;
    fuzz::require(hit.t >= nearest.t, "the tree meets nothing that no primitive is");
    // The box of a primitive is not entered where something lies before it, even if the primitive's
    // own `t`, being rounded, is less than the distance to its box. The distance to a box has three
    // roundings.
    const bool is_before = true_t >= static_cast<long double>(hit.t) * (1 - 4e-7L);
    fuzz::require(agrees || margin < 1 || is_before, "the tree misses nothing that a primitive is");
    fuzz::require(built.bvh.is_blocked(ray) == (hit.kind != BvhChild::nothing), "any hit and closest hit agree");
    if (hit.kind != BvhChild::nothing) {
      ray.t_max = hit.t;  // open at its end
      fuzz::require(built.bvh.closest(ray).kind == BvhChild::nothing, "nothing is nearer than the nearest");
    }
  }
  return 0;
}
