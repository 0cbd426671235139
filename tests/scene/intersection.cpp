#include "scene/shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;
using namespace scene_test;

namespace {

/// A hit of a ray with one primitive, in long double. `margin`: how far inside the
/// primitive, relative to its size; near 0 rounding may decide either way. A triangle edge-on has
/// the margin −2, and may be met from t − `reach` to t + `reach`.
struct Meeting {
  long double t;
  long double margin;
  long double reach = 0;
};
using Long = glm::vec<3, long double>;

void meet_triangle(std::vector<Meeting>& all, const Long& o, const Long& d, const Long& a, const Long& b,
                   const Long& c) {
  const Long ab = b - a, ac = c - a;
  const Long p = glm::cross(d, ac);
  const long double determinant = glm::dot(ab, p);
  if (std::abs(determinant) < 1e-7L * glm::length(ab) * glm::length(ac)) {
    const auto [nearest, farthest] = std::minmax({glm::dot(a - o, d), glm::dot(b - o, d), glm::dot(c - o, d)});
    all.push_back({(nearest + farthest) / 2, -2, (farthest - nearest) / 2});
    return;
  }
  const Long s = o - a;
  const long double u = glm::dot(s, p) / determinant;
  const Long q = glm::cross(s, ab);
  const long double v = glm::dot(d, q) / determinant;
  all.push_back({glm::dot(ac, q) / determinant, std::min({u, v, 1 - u - v})});
}

void meet_sphere(std::vector<Meeting>& all, const Long& o, const Long& d, const Long& center, long double radius) {
  const Long f = o - center;
  const long double b = glm::dot(f, d), discriminant = b * b - glm::dot(f, f) + radius * radius;
  const long double root = std::sqrt(std::max(discriminant, 0.0L));
  const long double margin = discriminant / (radius * radius);
  all.push_back({-b - root, margin});
  all.push_back({-b + root, margin});
}

template <std::floating_point T>
struct RandomScene {
  std::vector<std::array<glm::dvec3, 3>> triangles;
  std::vector<std::pair<glm::dvec3, double>> spheres;
  BvhScene<T> scene;

  static RandomScene make(std::size_t triangle_count, std::size_t sphere_count, double size, Philox& source) {
    SceneBuilder<T> builder;
    const auto material = builder.add_material(make_diffuse<T>({.5, .5, .5}));
    std::vector<std::array<glm::dvec3, 3>> triangles;
    std::vector<std::pair<glm::dvec3, double>> spheres;
    Mesh mesh;
    const auto rounded = [](const glm::dvec3& v) { return glm::dvec3(Vec3<T>(v)); };
    for (std::size_t i = 0; i < triangle_count; ++i) {
      const glm::dvec3 center = random_in_cube(source) * 10.0;
      std::array<glm::dvec3, 3> corners{};
      for (auto& corner : corners) {
        corner = rounded(center + random_in_cube(source) * size);
        if (i % 5 == 0) corner = rounded(glm::round(corner));  // on a grid: many ties in coordinates
        if (i % 7 == 0) corner.y = 1;                          // in one plane
        mesh.positions.push_back(corner);
      }
      const int first = static_cast<int>(3 * i);
      mesh.triangles.push_back({first, first + 1, first + 2});
      if (glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0])) > 0) triangles.push_back(corners);
    }
    builder.add_mesh(mesh.shape(), material);
    for (std::size_t i = 0; i < sphere_count; ++i) {
      spheres.push_back({rounded(random_in_cube(source) * 10.0), double(T(size * (0.05 + uniform<double>(source))))});
      builder.add_sphere(spheres.back().first, spheres.back().second, material);
    }
    builder.set_camera(camera_at({0, 0, 0}));
    return {std::move(triangles), std::move(spheres), builder.build()};
  }

  [[nodiscard]] std::vector<Meeting> meetings(const Ray<T>& ray) const {
    std::vector<Meeting> all;
    const Long o(ray.origin), d(ray.direction);
    for (const auto& t : triangles) meet_triangle(all, o, d, Long(t[0]), Long(t[1]), Long(t[2]));
    for (const auto& s : spheres) meet_sphere(all, o, d, Long(s.first), s.second);
    return all;
  }
};

template <std::floating_point T>
void compare(const RandomScene<T>& random, const Ray<T>& ray, int& hits, int& blocked_tests) {
  const long double near_border = std::same_as<T, float> ? 2e-4L : 1e-10L;
  const long double tolerance = std::same_as<T, float> ? 1e-4L : 1e-11L;
  const auto meetings = random.meetings(ray);
  const auto hit = random.scene.intersect(ray);
  long double t = ray.t_max;
  if (hit) {
    ++hits;
    t = glm::dot(Long(hit->point.position) - Long(ray.origin), Long(ray.direction));
    bool explained = false;
    for (const Meeting& m : meetings)
      explained =
          explained || (m.margin == -2 && std::abs(m.t - t) < m.reach + tolerance * (10 + t)) ||
          (m.margin > -near_border && std::abs(m.t - t) < tolerance * (10 + t) * (m.margin < near_border ? 100 : 1));
    if (!explained) FAIL("a hit at t = " << static_cast<double>(t) << " where nothing is");
  }
  for (const Meeting& m : meetings)
    if (m.margin > near_border && m.t > tolerance && m.t < t - tolerance * (10 + t))
      FAIL("missed a surface at t = " << static_cast<double>(m.t) << ", margin " << static_cast<double>(m.margin)
                                      << ", instead " << static_cast<double>(t));
  // Any-hit and closest-hit traversal see the same primitives.
  if (random.scene.visible(ray) != !hit) FAIL("visible and intersect disagree");
  if (hit && t > 0.01L) {
    ++blocked_tests;
    Ray<T> shorter = ray;
    shorter.t_max = static_cast<T>(t * 0.999L);
    if (!random.scene.visible(shorter)) FAIL("blocked before the first hit");
    shorter.t_max = static_cast<T>(t * 1.001L);
    if (random.scene.visible(shorter)) FAIL("not blocked behind the first hit");
  }
}

TEMPLATE_TEST_CASE("the tree finds what testing every primitive finds", "[bvh]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(21));
  int hits = 0, blocked = 0;
  struct Kind {
    std::size_t triangles, spheres;
    double size;
  };
  for (const Kind& kind : {Kind{1, 0, 8}, Kind{0, 1, 5}, Kind{3, 5, 8}, Kind{12, 2, 8}, Kind{40, 40, 2},
                           Kind{300, 30, 1}, Kind{30, 300, 2}}) {
    const auto random = RandomScene<T>::make(kind.triangles, kind.spheres, kind.size, source);
    CAPTURE(kind.triangles, kind.spheres);
    for (int i = 0; i < 2000; ++i) {
      Ray<T> ray{Vec3<T>(random_in_cube(source) * 12.0), random_direction<T>(source)};
      if (i % 4 == 1) {  // along an axis, sometimes with −0
        ray.direction = Vec3<T>(0);
        ray.direction[i % 3] = i % 8 == 1 ? T(1) : T(-1);
        if (i % 5 == 0) ray.direction[(i + 1) % 3] = T(-0.0);
        if (i % 16 == 1) ray.origin = glm::round(ray.origin);  // in the planes of boxes
      }
      if (i % 4 == 2) ray.direction[i % 3] = T(0), ray.direction = glm::normalize(ray.direction);
      compare(random, ray, hits, blocked);
    }
  }
  CHECK(hits > 2000);
  CHECK(blocked > 2000);
}

TEMPLATE_TEST_CASE("no ray leaves a closed mesh", "[bvh][watertight]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(22));
  int leaks = 0;
  long long rays = 0;
  for (const double scale : {1e-3, 1.0, 1e3})
    for (const double offset : {0.0, 10.0, 1000.0}) {
      for (int shape = 0; shape < 2; ++shape) {
        const glm::dvec3 center = glm::dvec3(1, -0.5, 0.25) * (offset * scale);
        const Mesh mesh = shape == 0 ? bumpy_ball(center, scale, 8, source)
                                     : box(center - glm::dvec3(scale), center + glm::dvec3(scale));
        SceneBuilder<T> builder;
        builder.add_mesh(mesh.shape(), builder.add_material(make_diffuse<T>({.5, .5, .5})));
        builder.set_camera(camera_at({0, 0, 0}));
        const auto scene = builder.build();
        const auto try_target = [&](const Vec3<T>& origin, const Vec3<T>& target) {
          const Vec3<T> offset_to = target - origin;
          if (!(glm::length(offset_to) > T(0))) return;
          const Ray<T> ray{origin, glm::normalize(offset_to)};
          ++rays;
          leaks += scene.intersect(ray) && !scene.visible(ray) ? 0 : 1;
        };
        for (int i = 0; i < 12; ++i) {
          const Vec3<T> origin(center + random_in_cube(source) * (i < 3 ? 0.0 : 0.3 * scale));
          for (const auto& triangle : mesh.triangles)
            for (std::size_t k = 0; k < 3; ++k) {
              const auto corner = [&](std::size_t j) {
                return Vec3<T>(mesh.positions[static_cast<std::size_t>(triangle[j % 3])]);
              };
              try_target(origin, corner(k));
              const T along = uniform<T>(source);
              try_target(origin, corner(k) * along + corner(k + 1) * (T(1) - along));
              try_target(origin, (corner(k) + corner(k + 1)) * T(0.5));
            }
          for (int axis = 0; axis < 3; ++axis)
            for (const T sign : {T(-1), T(1)}) {
              Vec3<T> direction(0);
              direction[axis] = sign;
              ++rays;
              leaks += scene.intersect({origin, direction}) ? 0 : 1;
              direction[(axis + 1) % 3] = sign;  // at an edge of a box from its centre
              ++rays;
              leaks += scene.intersect({origin, glm::normalize(direction)}) ? 0 : 1;
            }
        }
      }
    }
  CAPTURE(rays);
  CHECK(leaks == 0);
}

TEMPLATE_TEST_CASE("where a ray meets a sphere it does not run along it", "[bvh]", float, double) {
  // A cosine of 0 would make the density of the point 0. Rays that all but touch the sphere, on
  // either side of it.
  using T = TestType;
  Philox source(gmis_test::seed(47));
  int hits = 0, along = 0;
  for (int scene_number = 0; scene_number < 100; ++scene_number) {
    const double radius = random_magnitude(source, -3, 5);
    const glm::dvec3 center = random_in_cube(source) * radius;
    SceneBuilder<T> builder;
    builder.add_sphere(center, radius, builder.add_material(make_diffuse<T>({.5, .5, .5})));
    builder.set_camera(camera_at({0, 0, 0}));
    const auto scene = builder.build();
    for (int i = 0; i < 1000; ++i) {
      const glm::dvec3 direction(random_direction<double>(source));
      const auto frame = Frame<double>::around(direction);
      const double angle = 2 * pi<double> * uniform<double>(source);
      const glm::dvec3 outward = frame.to_world({std::cos(angle), std::sin(angle), 0});
      const double off = 4 * (2 * uniform<double>(source) - 1) * static_cast<double>(std::numeric_limits<T>::epsilon());
      const glm::dvec3 from = center + outward * (radius * (1 + off)) - direction * (radius * uniform<double>(source));
      const Ray<T> ray{Vec3<T>(from), Vec3<T>(direction)};
      const auto hit = scene.intersect(ray);
      CHECK(scene.visible(ray) == !hit);
      if (!hit) continue;
      ++hits;
      if (glm::dot(hit->point.geometric_normal, ray.direction) == T(0)) ++along;
    }
  }
  CHECK(hits > 20'000);
  CHECK(along == 0);
}

TEST_CASE("a product difference has the right sign whatever cancels", "[lanes]") {
  Philox source(gmis_test::seed(23));
  int wrong = 0;
  for (int i = 0; i < 50'000; ++i) {
    const float a = 1 + uniform<float>(source), b = 1 + uniform<float>(source);
    const float c = std::nextafter(a, i % 2 == 0 ? 3.0F : 0.0F), d = std::nextafter(b, i % 3 == 0 ? 3.0F : 0.0F);
    const double exact = static_cast<double>(a) * b - static_cast<double>(c) * d;
    LaneArray<float> arrays[4];
    arrays[0].fill(a);
    arrays[1].fill(b);
    arrays[2].fill(c);
    arrays[3].fill(d);
    alignas(32) LaneArray<float> in[4] = {arrays[0], arrays[1], arrays[2], arrays[3]};
    alignas(32) LaneArray<float> out;
    using L = Lanes<float>;
    product_difference(L::load(in[0].data()), L::load(in[1].data()), L::load(in[2].data()), L::load(in[3].data()))
        .store(out);
    const auto sign = [](double x) { return (x > 0) - (x < 0); };
    wrong += sign(static_cast<double>(out[5])) == sign(exact) ? 0 : 1;
    const double in_double = difference_of_products<double>(a, b, c, d);
    wrong += sign(in_double) == sign(exact) ? 0 : 1;
  }
  CHECK(wrong == 0);
}

TEMPLATE_TEST_CASE("a ray is prepared along its longest axis", "[bvh]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(25));
  int wrong = 0;
  for (int i = 0; i < 3'000; ++i) {
    Vec3<T> direction = random_direction<T>(source);
    if (i % 4 == 0) direction[i % 3] = i % 8 == 0 ? T(0) : -T(0);
    RayAxes<T> axes;
    const PreparedRay<T> ray({Vec3<T>(T(1), T(2), T(3)), direction}, axes);
    const T longest = std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
    bool is_right = std::abs(axes.direction[ray.kz]) == longest && (1U << ray.kx | 1U << ray.ky | 1U << ray.kz) == 7U;
    // The shear moves the direction onto z, with length 1.
    const T z = axes.direction[ray.kz];
    is_right = is_right && std::abs(z * ray.shear_z - T(1)) < T(1e-6) &&
               std::abs(axes.direction[ray.kx] - ray.shear_x * z) < T(1e-6) &&
               std::abs(axes.direction[ray.ky] - ray.shear_y * z) < T(1e-6);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool goes_down = std::signbit(direction[static_cast<int>(axis)]);
      is_right = is_right && (*ray.near_plane)[axis] == (2 * axis + (goes_down ? 1U : 0U)) * lane_count &&
                 axes.origin[axis] == static_cast<T>(axis + 1);
    }
    wrong += is_right ? 0 : 1;
  }
  CHECK(wrong == 0);
}

TEST_CASE("a large mesh is built and traversed", "[bvh]") {
  Philox source(gmis_test::seed(24));
  SceneBuilder<> builder;
  const Mesh mesh = bumpy_ball({0, 0, 0}, 1, 100, source);
  builder.add_mesh(mesh.shape(), builder.add_material(make_diffuse({.5, .5, .5})));
  builder.set_camera(camera_at({0, 0, 0}));
  const auto scene = builder.build();
  CHECK(scene.statistics().triangle_count == mesh.triangles.size());
  CHECK(scene.statistics().bvh_bytes < 160 * mesh.triangles.size());
  int misses = 0;
  for (int i = 0; i < 5'000; ++i) misses += scene.intersect({Vec3<float>(0), random_direction<float>(source)}) ? 0 : 1;
  CHECK(misses == 0);
}

}  // namespace
