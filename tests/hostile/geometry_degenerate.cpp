#include <cstdio>
#include <functional>
#include <limits>
#include <string>

#include "gmis/core/interaction.hpp"
#include "hostile/geometry_shapes.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/seed.hpp"

// Triangles and rays that are special cases of themselves: no area, twice the same, a million in
// one plane; along an axis, through a corner, with components that are ±0 or too small to be normal
// numbers. And what is refused.

using namespace gmis;
using namespace gmis::scene;
using namespace hostile;
using scene_test::box;
using scene_test::camera_at;
using scene_test::random_direction;

namespace {

/// A cube from −n to n, each face a lattice of 2n × 2n squares of two triangles, corners at whole
/// numbers: many a ray of a lattice meets a corner or runs along edges.
Mesh lattice_cube(int n) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-n, n}) {
      const auto first = static_cast<int>(mesh.positions.size());
      for (int i = -n; i <= n; ++i)
        for (int j = -n; j <= n; ++j) {
          glm::dvec3 p;
          p[axis] = side;
          p[(axis + 1) % 3] = i;
          p[(axis + 2) % 3] = j;
          mesh.positions.push_back(p);
        }
      const int row = 2 * n + 1;
      for (int i = 0; i < 2 * n; ++i)
        for (int j = 0; j < 2 * n; ++j) {
          const int at = first + i * row + j;
          std::array<int, 3> one{at, at + row, at + row + 1}, two{at, at + row + 1, at + 1};
          if (side < 0) {
            std::swap(one[1], one[2]);
            std::swap(two[1], two[2]);
          }
          mesh.triangles.push_back(one);
          mesh.triangles.push_back(two);
        }
    }
  return mesh;
}

template <std::floating_point T>
BvhScene<T> scene_of(const Mesh& mesh, double scale) {
  Mesh scaled = mesh;
  for (auto& position : scaled.positions) position *= scale;
  return hostile::scene_of<T>(scaled, make_diffuse<T>({.5, .5, .5}), {0, 0, 0});
}

/// ±0, numbers that are not normal, and the smallest that are.
template <std::floating_point T>
std::vector<T> nothings() {
  using limits = std::numeric_limits<T>;
  std::vector<T> result;
  for (const T x : {T(0), limits::denorm_min(), T(100) * limits::denorm_min(), limits::min() / T(2), limits::min(),
                    T(2) * limits::min()}) {
    result.push_back(x);
    result.push_back(-x);
  }
  return result;
}

TEMPLATE_TEST_CASE("hostile: rays along axes, through corners, with zero and subnormal components",
                   "[hostile][geometry]", float, double) {
  using T = TestType;
  constexpr int n = 4;
  const Mesh cube = lattice_cube(n);
  const std::vector<T> tiny = nothings<T>();
  for (const double scale : {1e-4, 0.25, 1.0, 1e6}) {
    const auto scene = scene_of<T>(cube, scale);
    const auto unit = static_cast<T>(scale);
    const T wall = static_cast<T>(n * scale);
    int missed = 0, elsewhere = 0, rays = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const T sign : {T(1), T(-1)})
        for (int i = -n + 1; i < n; ++i)
          for (int j = -n + 1; j < n; ++j) {
            Vec3<T> direction;
            direction[axis] = sign;
            direction[(axis + 1) % 3] = tiny[static_cast<std::size_t>(rays) % tiny.size()];
            direction[(axis + 2) % 3] = tiny[static_cast<std::size_t>(rays / 7) % tiny.size()];
            // From a plane of the lattice within, and from without: both through a corner of four
            // squares.
            for (const T start : {T(i) * unit, -sign * T(3) * wall}) {
              Vec3<T> origin;
              origin[axis] = start;
              origin[(axis + 1) % 3] = T(i) * unit;
              origin[(axis + 2) % 3] = T(j) * unit;
              ++rays;
              const auto hit = scene.intersect({origin, direction});
              if (!hit || scene.visible({origin, direction})) {
                ++missed;
                continue;
              }
              Vec3<T> expected = origin;
              expected[axis] = std::abs(start) > wall ? -sign * wall : sign * wall;
              const T error = glm::length(hit->point.position - expected);
              // A point keeps off edges by some 80 roundings, and off a corner of 45° by 2.6 times
              // as much.
              if (!(error <= T(80 * 2.7) * std::numeric_limits<T>::epsilon() * wall)) ++elsewhere;
            }
          }
    // From the middle to every corner of the lattice, and along the diagonals of squares and of the
    // cube.
    for (const glm::dvec3& corner : cube.positions) {
      ++rays;
      const auto hit = scene.intersect({Vec3<T>(T(0)), glm::normalize(Vec3<T>(corner))});
      if (!hit)
        ++missed;
      else if (!(glm::length(glm::dvec3(hit->point.position) - corner * scale) <
                 330 * static_cast<double>(std::numeric_limits<T>::epsilon()) * n * scale))
        ++elsewhere;
    }
    CAPTURE(scale, rays);
    CHECK(missed == 0);
    CHECK(elsewhere == 0);
  }
}

TEMPLATE_TEST_CASE("hostile: rays that are parallel to a surface but for nothing", "[hostile][geometry]", float,
                   double) {
  // The normal of the floor is an axis, so cosines as small as the type allows are true ones.
  using T = TestType;
  Mesh floor;
  floor.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  floor.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto scene = scene_of<T>(floor, 1);
  std::vector<T> cosines = nothings<T>();
  for (int e = 1; e < (std::same_as<T, float> ? 37 : 307); e += 3)
    for (const double sign : {1.0, -1.0}) cosines.push_back(static_cast<T>(sign * std::pow(10.0, -e)));
  Philox source(gmis_test::seed(311));
  int met = 0, rays = 0;
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 target = random_in_cube(source) * glm::dvec3(0.99, 0.99, 0);
    const auto hit = scene.intersect({Vec3<T>(target + glm::dvec3(0, 0, 1)), Vec3<T>(T(0), T(0), T(-1))});
    REQUIRE(hit);
    for (const T cosine : cosines) {
      const double angle = 2 * pi<double> * uniform<double>(source);
      const auto sine = std::sqrt(T(1) - cosine * cosine);
      const Vec3<T> away(sine * static_cast<T>(std::cos(angle)), sine * static_cast<T>(std::sin(angle)), cosine);
      const Ray<T> ray = leave(hit->point, away);
      rays += 2;
      met += scene.intersect(ray) ? 1 : 0;
      met += scene.visible(ray) ? 0 : 1;
    }
  }
  CHECK(rays > 10'000);
  CHECK(met == 0);
}

TEMPLATE_TEST_CASE("hostile: a link between coinciding or nearly coinciding points", "[hostile][geometry]", float,
                   double) {
  using T = TestType;
  Philox source(gmis_test::seed(312));
  for (int i = 0; i < 20'000; ++i) {
    const Vec3<T> n = random_direction<T>(source);
    SurfacePoint<T> a{Vec3<T>(random_in_cube(source) * random_magnitude(source, -4, 6)), n, n, T(0)};
    a.position_error = static_cast<T>(random_magnitude(source, -9, -2));
    SurfacePoint<T> b = a;
    if (i % 3 == 1) b.position += a.geometric_normal * (a.position_error * uniform<T>(source));
    if (i % 3 == 2) b.geometric_normal = random_direction<T>(source);
    const Vec3<T> offset = b.position - a.position;
    const T length = glm::length(offset);
    const Vec3<T> direction = length > T(0) ? offset / length : random_direction<T>(source);
    const Ray<T> ray = segment(a, b, direction);
    for (int axis = 0; axis < 3; ++axis) {
      REQUIRE(std::isfinite(ray.origin[axis]));
      REQUIRE(std::isfinite(ray.direction[axis]));
    }
    REQUIRE(ray.t_max >= T(0));
    constexpr T unit = std::numeric_limits<T>::epsilon();
    REQUIRE(std::abs(glm::length(ray.direction) - T(1)) < T(4) * unit);
    // Not farther than the two offsets, but for the rounding of the two ends.
    REQUIRE(ray.t_max <= length + T(2.01) * a.position_error + T(2) * unit * glm::length(a.position));
  }
}

TEST_CASE("hostile: triangles without area, almost without, and twice the same", "[hostile][geometry]") {
  Philox source(gmis_test::seed(313));
  const Mesh clean = scene_test::bumpy_ball({0, 0, 0}, 1, 8, source);
  Mesh spoilt = clean;
  const std::size_t count = clean.triangles.size();
  std::size_t no_area = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto t = clean.triangles[i];
    spoilt.triangles.push_back(t);                   // twice the same
    spoilt.triangles.push_back({t[0], t[2], t[1]});  // and turned over
    spoilt.triangles.push_back({t[0], t[0], t[1]});  // a line
    spoilt.triangles.push_back({t[2], t[2], t[2]});  // a point
    no_area += 2;
  }
  // Slivers between a corner, its neighbour and a point of the edge between them: an area of
  // rounding errors, or none.
  for (std::size_t i = 0; i < count; ++i) {
    const auto& t = clean.triangles[i];
    spoilt.positions.push_back(glm::mix(clean.positions[static_cast<std::size_t>(t[0])],
                                        clean.positions[static_cast<std::size_t>(t[1])], 0.3));
    spoilt.triangles.push_back({t[0], t[1], static_cast<int>(spoilt.positions.size()) - 1});
  }
  const auto expected = scene_of<double>(clean, 1);
  const auto scene = scene_of<double>(spoilt, 1);
  CHECK(scene.statistics().degenerate_triangle_count >= no_area);
  int differences = 0;
  for (int i = 0; i < 20'000; ++i) {
    const glm::dvec3 from = random_in_cube(source) * (i % 2 == 0 ? 0.4 : 3.0);
    const glm::dvec3 target = i % 4 < 2 ? point_near_edge(clean, source) : from + random_direction<double>(source);
    const Ray<double> ray{from, glm::normalize(target - from)};
    const auto a = expected.intersect(ray), b = scene.intersect(ray);
    // A sliver may stick out of the edge by a rounding error: there, from outside, either may be;
    // and from inside a ray that just passes an edge which points inwards may meet the sliver
    // there.
    if (i % 4 != 1) REQUIRE(a.has_value() == b.has_value());
    if (!b) continue;
    if (i % 4 == 1) REQUIRE(std::isfinite(b->point.position.x + b->point.position.y + b->point.position.z));
    const auto& p = b->point;
    const auto distance_to = [&](const glm::dvec3& at) { return glm::length(at - from); };
    const bool is_at_edge = i % 4 == 0 && glm::length(p.position - target) < 1e-12;
    if (a && i % 4 != 1 && !(is_at_edge && distance_to(p.position) < distance_to(a->point.position)))
      differences += glm::length(a->point.position - p.position) < 1e-9 ? 0 : 1;
    REQUIRE(std::abs(glm::length(p.geometric_normal) - 1) < 1e-14);
    REQUIRE(std::isfinite(p.position_error));
  }
  CHECK(differences == 0);
}

/// `side` × `side` squares of two triangles in the plane z = 1, and rays to corners, edges and
/// anywhere.
void check_plane(int side) {
  Mesh plane;
  plane.positions.reserve(static_cast<std::size_t>(side + 1) * static_cast<std::size_t>(side + 1));
  for (int i = 0; i <= side; ++i)
    for (int j = 0; j <= side; ++j) plane.positions.emplace_back(i - side / 2, j - side / 2, 1);
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const int at = i * (side + 1) + j;
      plane.triangles.push_back({at, at + side + 1, at + side + 2});
      plane.triangles.push_back({at, at + side + 2, at + 1});
    }
  const auto scene = scene_of<float>(plane, 1);
  std::printf("%zu triangles in one plane: %.1f MB\n", plane.triangles.size(),
              static_cast<double>(scene.statistics().bvh_bytes) / 1e6);
  // Some 70 bytes a triangle where packets are full: these are at least a quarter full.
  CHECK(scene.statistics().bvh_bytes < 256 * plane.triangles.size());
  CHECK(scene.statistics().triangle_count == plane.triangles.size());
  Philox source(gmis_test::seed(314));
  const double half = side / 2 - 1.0;
  int missed = 0, elsewhere = 0, met_again = 0;
  for (int i = 0; i < 100'000; ++i) {
    glm::dvec3 target = random_in_cube(source) * half;
    target.z = 1;
    if (i % 3 == 0) target = glm::round(target);  // a corner
    if (i % 3 == 1) target.x = std::round(target.x);
    // Straight down, or from the side: in this direction the ray is exact, so the corner is met
    // exactly.
    const glm::dvec3 from =
        i % 2 == 0 ? target - glm::dvec3(0, 0, 16) : target + random_direction<double>(source) * 8.0;
    const glm::dvec3 origin(Vec3<float>{from});
    if (std::abs(origin.z - 1) < 0.5) continue;
    const Vec3<float> direction(glm::normalize(target - origin));
    const auto hit = scene.intersect({Vec3<float>(origin), direction});
    if (!hit) {
      ++missed;
      continue;
    }
    const glm::dvec3 expected = origin + glm::dvec3(direction) * ((1 - origin.z) / static_cast<double>(direction.z));
    // The point keeps off edges and corners by some roundings of its coordinates.
    if (!(glm::length(glm::dvec3(hit->point.position) - expected) < 44 * 2.6 * 1.2e-7 * 1.5 * (half + 16))) ++elsewhere;
    if (!(std::abs(hit->point.position.z - 1) < hit->point.position_error / 2)) ++elsewhere;
    const Vec3<float> away = direction_on_side(hit->point.geometric_normal, i % 2 == 0 ? 1.0F : -1.0F, source);
    met_again += scene.intersect(leave(hit->point, away)) ? 1 : 0;
  }
  CHECK(missed == 0);
  CHECK(elsewhere == 0);
  CHECK(met_again == 0);
}

TEST_CASE("hostile: many triangles in one plane", "[hostile][geometry]") {
  check_plane(100);
}
TEST_CASE("hostile: a million triangles in one plane", "[.][slow]") {
  check_plane(708);
}

TEST_CASE("hostile: what is not finite is refused, and the message says what it is", "[hostile][geometry]") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  struct Refusal {
    const char* says;
    std::function<void(SceneBuilder<float>&, std::size_t material, double bad)> act;
  };
  const auto mesh_of = [](const glm::dvec3& corner, const glm::dvec3& normal) {
    Mesh mesh = box({0, 0, 0}, {1, 1, 1});
    mesh.positions[5] = corner;
    std::vector<glm::dvec3> normals(mesh.positions.size(), {0, 0, 1});
    normals[2] = normal;
    return std::pair(mesh, normals);
  };
  const Refusal refusals[] = {
      {"coordinate",
       [&](auto& b, std::size_t m, double bad) {
         b.add_mesh(mesh_of({1, bad, 1}, {0, 0, 1}).first.shape(), m);
       }},
      {"coordinate",
       [&](auto& b, std::size_t m, double bad) {
         const auto [mesh, normals] = mesh_of({1, 0, 1}, {0, bad, 1});
         b.add_mesh({mesh.positions, mesh.triangles, normals}, m);
       }},
      {"coordinate",
       [](auto& b, std::size_t m, double bad) {
         b.add_sphere({0, 0, bad}, 1, m);
       }},
      {"radius",
       [](auto& b, std::size_t m, double bad) {
         b.add_sphere({0, 0, 0}, bad, m);
       }},
      {"colour",
       [](auto& b, std::size_t m, double bad) {
         b.add_sphere({0, 0, 0}, 1, m, AreaEmission{{1, bad, 1}, false});
       }},
      {"coordinate",
       [](auto& b, std::size_t, double bad) {
         b.add_point_light({bad, 0, 0}, {1, 1, 1});
       }},
      {"colour",
       [](auto& b, std::size_t, double bad) {
         b.add_point_light({0, 0, 0}, {1, bad, 1});
       }},
      {"coordinate",
       [](auto& b, std::size_t, double bad) {
         b.add_directional_light({bad, 0, 1}, {1, 1, 1});
       }},
      {"colour",
       [](auto& b, std::size_t, double bad) {
         b.add_directional_light({0, 0, 1}, {bad, 1, 1});
       }},
      {"colour",
       [](auto& b, std::size_t, double bad) {
         b.add_environment({bad, 1, 1});
       }},
      {"spot",
       [](auto& b, std::size_t, double bad) {
         b.add_spot_light({0, 0, 0}, {0, 0, 1}, {1, 1, 1}, bad, 1);
       }},
      {"spot",
       [](auto& b, std::size_t, double bad) {
         b.add_spot_light({0, 0, 0}, {0, 0, 1}, {1, 1, 1}, 0, bad);
       }},
      {"environment image",
       [](auto& b, std::size_t, double bad) {
         b.add_environment(EnvironmentImage{
             {1, 2}, {glm::vec3(1), glm::vec3(static_cast<float>(bad))}, SkyMapping::latitude_longitude});
       }},
      {"environment image",
       [](auto& b, std::size_t, double bad) {
         b.add_environment(EnvironmentImage{{1, 1}, {glm::vec3(1)}}, glm::dmat3(1, 0, 0, 0, bad, 0, 0, 0, 1));
       }},
      {"camera",
       [](auto& b, std::size_t, double bad) {
         auto camera = camera_at({0, 0, 0});
         camera.world_from_camera[1][1] = bad;
         b.set_camera(camera);
       }},
      {"",
       [](auto& b, std::size_t, double bad) {
         b.set_camera(camera_at({0, bad, 0}));
       }},
      {"camera",
       [](auto& b, std::size_t, double bad) {
         auto camera = camera_at({0, 0, 0});
         camera.window[1] = bad;
         b.set_camera(camera);
       }},
      {"lens",
       [](auto& b, std::size_t, double bad) {
         auto camera = camera_at({0, 0, 0});
         camera.lens_radius = bad;
         b.set_camera(camera);
       }},
  };
  for (std::size_t i = 0; i < std::size(refusals); ++i)
    for (const double bad : {nan, infinity, -infinity}) {
      SceneBuilder<float> builder;
      const auto material = builder.add_material(make_diffuse<float>({.5, .5, .5}));
      const std::string message = gmis_test::message_of([&] { refusals[i].act(builder, material, bad); });
      CAPTURE(i, bad, message);
      CHECK_FALSE(message.empty());
      CHECK(message.find(refusals[i].says) != std::string::npos);
    }
  // Too far for the arithmetic of the scene, though finite: said when it is built around the
  // camera.
  SceneBuilder<float> builder;
  builder.add_sphere({1e13, 0, 0}, 1, builder.add_material(make_diffuse<float>({.5, .5, .5})));
  builder.set_camera(camera_at({0, 0, 0}));
  CHECK_THROWS_AS(static_cast<void>(builder.build()), std::invalid_argument);
  builder.set_camera(camera_at({1e13, 0, -5}));
  const auto scene = builder.build();
  CHECK(scene.intersect({{0, 0, 0}, {0, 0, 1}}));
}

}  // namespace
