#include <limits>

#include "gmis/core/interaction.hpp"
#include "scene/shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;
using namespace scene_test;

namespace {

/// Unit, on the side of `normal` that `side` says, its cosine with the normal about 10^−x: from
/// steep to grazing.
template <std::floating_point T>
Vec3<T> direction_on_side(const Vec3<T>& normal, T side, Philox& source) {
  const double lowest = std::same_as<T, float> ? -7 : -15;
  const double cosine = random_magnitude(source, uniform<double>(source) < 0.3 ? -1 : lowest, 0);
  const double angle = 2 * pi<double> * uniform<double>(source);
  const double sine = std::sqrt(1 - cosine * cosine);
  const auto frame = Frame<double>::around(glm::normalize(glm::dvec3(normal)));
  Vec3<T> w(frame.to_world({sine * std::cos(angle), sine * std::sin(angle), cosine * static_cast<double>(side)}));
  if (glm::dot(w, normal) * side <= T(0)) w = normal * side;  // rounding took it over the horizon
  return w;
}

TEMPLATE_TEST_CASE("a ray that leaves a sphere outwards never meets it, inwards always", "[offset]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(31));
  int met_again = 0, leaked = 0, wrong_place = 0, hits = 0;
  double worst_error = 0;
  for (int scene_number = 0; scene_number < 400; ++scene_number) {
    const double radius = random_magnitude(source, -3, 4);
    const glm::dvec3 center = random_in_cube(source) * radius * random_magnitude(source, 0, 3);
    SceneBuilder<T> builder;
    builder.add_sphere(center, radius, builder.add_material(make_dielectric<T>(1.5)), {}, scene_number % 2 == 1);
    builder.set_camera(camera_at({0, 0, 0}));
    const auto scene = builder.build();
    for (int i = 0; i < 300; ++i) {
      const glm::dvec3 target = center + random_in_cube(source) * radius * 0.55;
      const glm::dvec3 from = center + glm::dvec3(random_direction<double>(source)) * radius *
                                           (i % 3 == 0 ? 0.5 : random_magnitude(source, 0.01, 3));
      const auto hit = scene.intersect({Vec3<T>(from), Vec3<T>(glm::normalize(target - from))});
      if (!hit) continue;
      ++hits;
      const Vec3<T> outward = scene_number % 2 == 1 ? -hit->point.geometric_normal : hit->point.geometric_normal;
      const glm::dvec3 place(hit->point.position);
      const double error = std::abs(glm::length(place - glm::dvec3(Vec3<T>(center))) - double(T(radius)));
      worst_error = std::max(worst_error, error / static_cast<double>(hit->point.position_error));

      const Vec3<T> away = direction_on_side(outward, T(1), source);
      if (scene.intersect(leave(hit->point, away)) || !scene.visible(leave(hit->point, away))) ++met_again;
      const Vec3<T> inward = direction_on_side(outward, T(-1), source);
      const auto far = scene.intersect(leave(hit->point, inward));
      if (!far) {
        ++leaked;
        continue;
      }
      // The chord, 2 r cos; a grazing one is lengthened by the offset, which is then most of its
      // depth.
      const double chord = -2 * radius * glm::dot(glm::dvec3(outward), glm::dvec3(inward));
      const double found = glm::length(glm::dvec3(far->point.position) - place);
      const double slack = 20 * std::sqrt(static_cast<double>(hit->point.position_error) * radius) + 1e-5 * chord;
      if (!(std::abs(found - chord) < slack)) ++wrong_place;
    }
  }
  CHECK(hits > 50'000);
  CHECK(met_again == 0);
  CHECK(leaked == 0);
  CHECK(wrong_place == 0);
  CHECK(worst_error < 0.5);
}

TEMPLATE_TEST_CASE("a ray that leaves a sphere from where rounding has its surface meets it at once or never",
                   "[offset]", float, double) {
  // The origin may be inside by a rounding error: the ray then meets the surface after so little,
  // and never on the far side.
  using T = TestType;
  Philox source(gmis_test::seed(36));
  int at_once = 0, elsewhere = 0;
  for (int scene_number = 0; scene_number < 200; ++scene_number) {
    const double radius = random_magnitude(source, -3, 4);
    const glm::dvec3 center = random_in_cube(source) * radius;
    SceneBuilder<T> builder;
    builder.add_sphere(center, radius, builder.add_material(make_dielectric<T>(1.5)));
    builder.set_camera(camera_at({0, 0, 0}));
    const auto scene = builder.build();
    for (int i = 0; i < 300; ++i) {
      const glm::dvec3 normal(random_direction<double>(source));
      const Vec3<T> from(center + normal * radius);
      Vec3<T> away(random_direction<double>(source));
      const double cosine = glm::dot(normal, glm::dvec3(away));
      if (std::abs(cosine) < 0.1) continue;
      if (cosine < 0) away = -away;
      const auto hit = scene.intersect({from, away});
      if (!hit) continue;
      const double moved = glm::length(glm::dvec3(hit->point.position) - glm::dvec3(from));
      const double rounding = std::numeric_limits<T>::epsilon() * (glm::length(center) + radius) / std::abs(cosine);
      ++(moved < 16 * rounding ? at_once : elsewhere);
    }
  }
  CAPTURE(at_once);
  CHECK(at_once > 1000);
  CHECK(elsewhere == 0);
}

TEMPLATE_TEST_CASE("a ray that leaves a triangle never meets it", "[offset]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(32));
  int met_again = 0, hits = 0;
  for (int scene_number = 0; scene_number < 1000; ++scene_number) {
    const double size = random_magnitude(source, -3, 4);
    const glm::dvec3 center = random_in_cube(source) * size * random_magnitude(source, 0, 3);
    Mesh mesh;
    mesh.triangles = {{0, 1, 2}};
    const double thin = scene_number % 4 == 0 ? 0.01 : 1;
    for (int k = 0; k < 3; ++k) {
      glm::dvec3 corner = random_in_cube(source) * size * (k == 0 ? 1.0 : thin);
      if (scene_number % 3 == 0) corner.x = 0;  // axis-aligned
      mesh.positions.push_back(center + corner);
    }
    SceneBuilder<T> builder;
    builder.add_mesh(mesh.shape(), builder.add_material(make_diffuse<T>({.5, .5, .5})));
    builder.set_camera(camera_at({0, 0, 0}));
    const auto scene = builder.build();
    for (int i = 0; i < 60; ++i) {
      const Vec2<double> b = square_to_triangle(random_square<double>(source));
      const glm::dvec3 target = mesh.positions[0] * (1 - b.x - b.y) + mesh.positions[1] * b.x + mesh.positions[2] * b.y;
      const glm::dvec3 from = target + random_in_cube(source) * size * random_magnitude(source, -2, 2);
      const auto hit = scene.intersect({Vec3<T>(from), Vec3<T>(glm::normalize(target - from))});
      if (!hit) continue;
      ++hits;
      for (const T side : {T(1), T(-1)}) {
        const Vec3<T> away = direction_on_side(hit->point.geometric_normal, side, source);
        if (scene.intersect(leave(hit->point, away)) || !scene.visible(leave(hit->point, away))) ++met_again;
      }
    }
  }
  CHECK(hits > 40'000);
  CHECK(met_again == 0);
}

TEMPLATE_TEST_CASE("from inside a closed box every ray meets the box, from outside none", "[offset]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(33));
  int leaked = 0, met_again = 0;
  for (int scene_number = 0; scene_number < 60; ++scene_number) {
    const double size = random_magnitude(source, -3, 4);
    const glm::dvec3 center = random_in_cube(source) * size * random_magnitude(source, 0, 3);
    SceneBuilder<T> builder;
    const glm::dvec3 half = glm::dvec3(1, 0.3 + uniform<double>(source), 0.7) * size;
    builder.add_mesh(box(center - half, center + half).shape(), builder.add_material(make_dielectric<T>(1.5)));
    builder.set_camera(camera_at({0, 0, 0}));
    const auto scene = builder.build();
    for (int i = 0; i < 400; ++i) {
      const auto hit = scene.intersect({Vec3<T>(center), random_direction<T>(source)});
      if (!hit) {
        ++leaked;
        continue;
      }
      // Near an edge the offset can leave through the other face: stay as far from edges as the
      // offset is wide.
      int faces_near = 0;
      for (int axis = 0; axis < 3; ++axis)
        if (half[axis] - std::abs(static_cast<double>(hit->point.position[axis]) - center[axis]) <
            4 * static_cast<double>(hit->point.position_error))
          ++faces_near;
      if (faces_near > 1) continue;
      const Vec3<T> in = direction_on_side(hit->point.geometric_normal, T(-1), source);
      leaked += scene.intersect(leave(hit->point, in)) ? 0 : 1;
      const Vec3<T> out = direction_on_side(hit->point.geometric_normal, T(1), source);
      met_again += scene.intersect(leave(hit->point, out)) ? 1 : 0;
    }
  }
  CHECK(leaked == 0);
  CHECK(met_again == 0);
}

/// Two surfaces and nothing between: the points of the one see the points of the other that face
/// them.
template <std::floating_point T>
int false_shadows(double lowest_cosine, Philox& source, int& pairs) {
  int shadows = 0;
  for (int scene_number = 0; scene_number < 300; ++scene_number) {
    const double size = random_magnitude(source, -2, 2);
    const glm::dvec3 first = random_in_cube(source) * size * random_magnitude(source, 0, 2);
    const glm::dvec3 second =
        first + glm::dvec3(random_direction<double>(source)) * size * random_magnitude(source, 0.7, 2);
    SceneBuilder<T> builder;
    const auto material = builder.add_material(make_diffuse<T>({.5, .5, .5}));
    for (const glm::dvec3& center : {first, second}) {
      if (uniform<double>(source) < 0.5) {
        builder.add_sphere(center, size, material);
      } else {
        Mesh mesh;
        mesh.triangles = {{0, 1, 2}};
        for (int k = 0; k < 3; ++k) mesh.positions.push_back(center + random_in_cube(source) * size);
        builder.add_mesh(mesh.shape(), material);
      }
    }
    builder.set_camera(camera_at({0, 0, 0}));
    const auto scene = builder.build();
    const auto point_on = [&](const glm::dvec3& center) {
      const Vec3<T> from(center + random_in_cube(source) * size * 3.0);
      return scene.intersect(
          {from, Vec3<T>(glm::normalize(center + random_in_cube(source) * size - glm::dvec3(from)))});
    };
    for (int i = 0; i < 100; ++i) {
      const auto a = point_on(first), b = point_on(second);
      if (!a || !b) continue;
      const Vec3<T> offset = b->point.position - a->point.position;
      const T distance = glm::length(offset);
      if (!(distance > T(3 * size))) continue;  // on one shape
      const Vec3<T> direction = offset / distance;
      const auto is_sphere_facing_away = [&](const auto& hit, const Vec3<T>& w) {
        // A triangle is seen from both sides.
        return glm::dot(hit.point.geometric_normal, w) < T(lowest_cosine);
      };
      if (is_sphere_facing_away(*a, direction) || is_sphere_facing_away(*b, -direction)) continue;
      ++pairs;
      shadows += scene.visible(segment(a->point, b->point, direction)) ? 0 : 1;
    }
  }
  return shadows;
}

TEMPLATE_TEST_CASE("two points that face each other see each other", "[offset]", float, double) {
  Philox source(gmis_test::seed(34));
  int pairs = 0;
  CHECK(false_shadows<TestType>(0.02, source, pairs) == 0);
  CHECK(pairs > 500);  // so that it says something: there are about a thousand
}

TEMPLATE_TEST_CASE("a point far away is seen, whatever the angle", "[offset]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(35));
  int shadows = 0, pairs = 0;
  for (int scene_number = 0; scene_number < 300; ++scene_number) {
    // Near the origin coordinates are fine, and the far end of the ray is not.
    SceneBuilder<T> builder;
    const auto material = builder.add_material(make_diffuse<T>({.5, .5, .5}));
    Mesh mesh;
    mesh.triangles = {{0, 1, 2}};
    glm::dvec3 center(0);
    for (int k = 0; k < 3; ++k) {
      mesh.positions.push_back(random_in_cube(source));
      center += mesh.positions.back() / 3.0;
    }
    if (scene_number % 2 == 0)
      builder.add_mesh(mesh.shape(), material);
    else
      builder.add_sphere(center, 1, material);
    builder.set_camera(camera_at({0, 0, 0}));
    const auto scene = builder.build();
    for (int i = 0; i < 100; ++i) {
      const Vec3<double> from = center + random_direction<double>(source) * 5.0;
      const auto hit = scene.intersect({Vec3<T>(from), Vec3<T>(glm::normalize(center - from))});
      if (!hit) continue;
      const Vec3<T> away = direction_on_side(hit->point.geometric_normal, T(1), source);
      const SurfacePoint<T> far{
          hit->point.position + away * static_cast<T>(random_magnitude(source, -1, 4)), {}, {}, T(0)};
      const Vec3<T> offset = hit->point.position - far.position;
      // Nearer to the horizon than this, rounding may put the far point below it.
      if (glm::dot(away, hit->point.geometric_normal) < T(1e-5)) continue;
      ++pairs;
      shadows += scene.visible(segment(far, hit->point, offset / glm::length(offset))) ? 0 : 1;
    }
  }
  CHECK(pairs > 10'000);
  CHECK(shadows == 0);
}

}  // namespace
