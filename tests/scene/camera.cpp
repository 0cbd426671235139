#include "gmis/core/statistics.hpp"
#include "scene/shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;
using namespace scene_test;

namespace {

std::vector<CameraDescription> cameras() {
  CameraDescription wide = look_at({1, 2, 3}, {0, 0.5, -2}, {0, 1, 0}, 70, {40, 17});
  CameraDescription mirrored = wide;
  mirrored.world_from_camera[0] *= -1;  // as pbrt's `Scale -1 1 1`
  CameraDescription scaled = look_at({1e5, -2e5, 3e5}, {1e5, -2e5, 3e5 + 1}, {1, 1, 0}, 25, {9, 31});
  scaled.world_from_camera[0] *= 3.0;
  CameraDescription shifted = wide;
  shifted.window = {0.1, 0.5, -0.3, -0.1};
  CameraDescription lens = look_at({1, 2, 3}, {0, 0.5, -2}, {0, 1, 0}, 50, {21, 30});
  lens.lens_radius = 0.2;
  lens.focal_distance = 4;
  CameraDescription scaled_lens = mirrored;
  for (int i = 0; i < 3; ++i) scaled_lens.world_from_camera[i] *= 0.3;
  scaled_lens.lens_radius = 0.7;
  scaled_lens.focal_distance = 2;
  CameraDescription parallel = look_at({1, 2, 3}, {0, 0.5, -2}, {0, 1, 0}, 50, {40, 17});
  parallel.projection = Projection::orthographic;
  parallel.window = {-4, 4, -1.5, 2};
  CameraDescription scaled_parallel = parallel;
  for (int i = 0; i < 3; ++i) scaled_parallel.world_from_camera[i] *= i == 0 ? -2.0 : 2.0;
  return {wide, mirrored, scaled, shifted, lens, scaled_lens, parallel, scaled_parallel};
}

TEST_CASE("a camera has a lens where its rays and projections depend on the numbers for one", "[camera]") {
  for (const CameraDescription& description : cameras()) {
    const scene::Camera<double> camera(description, glm::dvec3(0));
    const auto one = camera.sample_ray({3, 2}, {0.25, 0.75}, {0.1, 0.9});
    const auto other = camera.sample_ray({3, 2}, {0.25, 0.75}, {0.8, 0.3});
    REQUIRE((one.has_value() && other.has_value()));
    CHECK(camera.has_lens() == (one->direction != other->direction));
    CHECK(camera.has_lens() == (one->origin.position != other->origin.position));
    CHECK(reads_lens_numbers(camera) == camera.has_lens());
  }
}

TEMPLATE_TEST_CASE("a point along a ray of a pixel is seen by that pixel, with the same density", "[camera]", float,
                   double) {
  using T = TestType;
  Philox source(gmis_test::seed(61));
  for (const auto& description : cameras()) {
    const scene::Camera<T> camera(description, glm::dvec3(description.world_from_camera[3]));
    const auto size = camera.resolution();
    int wrong = 0;
    double worst = 0;
    for (int i = 0; i < 4000; ++i) {
      const glm::ivec2 pixel(static_cast<int>(uniform_index(source, static_cast<std::uint32_t>(size.x))),
                             static_cast<int>(uniform_index(source, static_cast<std::uint32_t>(size.y))));
      // Away from the border of the pixel, where rounding may decide.
      const Vec2<T> inside = Vec2<T>(T(0.01)) + random_square<T>(source) * T(0.98);
      const Vec2<T> lens = random_square<T>(source);
      const auto ray = camera.sample_ray(pixel, inside, lens);
      REQUIRE(ray);
      // Nearer than the size of lens or window, the rounding of the point itself would be what is
      // measured.
      const bool is_pinhole = description.lens_radius == 0 && !camera.has_parallel_rays();
      const T distance = static_cast<T>(random_magnitude(source, is_pinhole ? -2 : 0.5, 3));
      const auto seen = camera.project(ray->origin.position + ray->direction * distance, lens);
      if (!seen || seen->pixel != pixel) {
        ++wrong;
        continue;
      }
      worst = std::max({worst, std::abs(1 - double(seen->density / ray->density)),
                        static_cast<double>(glm::length(seen->to_camera + ray->direction)),
                        static_cast<double>(glm::length(seen->origin.position - ray->origin.position) / distance),
                        std::abs(1 - static_cast<double>(glm::length(ray->direction)))});
      wrong += camera.project(ray->origin.position - ray->direction * distance, lens) ? 1 : 0;
    }
    CHECK(wrong == 0);
    CHECK(worst < (std::same_as<T, float> ? 1e-5 : 1e-12));
  }
}

TEST_CASE("the density of a pixel's rays integrates to one over the pixel", "[camera]") {
  using T = double;
  for (const auto& description : cameras()) {
    const scene::Camera<T> camera(description, glm::dvec3(description.world_from_camera[3]));
    const glm::ivec2 pixel(camera.resolution().x - 1, 0);
    // The size of a small patch from the rays of its corners, independent of the density's formula:
    // solid angle, or area across rays that are parallel.
    double integral = 0;
    constexpr int steps = 64;
    const Vec2<T> lens(0.9, 0.3);
    const auto direction = [&](double x, double y) {
      const auto ray = camera.sample_ray(pixel, {x, y}, lens);
      return camera.has_parallel_rays() ? ray->origin.position : ray->direction;
    };
    for (int i = 0; i < steps; ++i)
      for (int j = 0; j < steps; ++j) {
        const double x = double(i) / steps, y = double(j) / steps, h = 1.0 / steps;
        const auto a = direction(x, y), b = direction(x + h, y), c = direction(x, y + h);
        integral +=
            glm::length(glm::cross(b - a, c - a)) * camera.sample_ray(pixel, {x + h / 2, y + h / 2}, lens)->density;
      }
    CHECK(integral == Approx(1).epsilon(1e-3));
    if (!camera.has_parallel_rays()) continue;
    CHECK(std::abs(glm::dot(direction(1, 0) - direction(0, 1), camera.sample_ray(pixel, {}, {})->direction)) < 1e-12);
  }
}

TEST_CASE("the lens is sampled uniformly, and what is at the focal distance is sharp", "[camera]") {
  using T = double;
  Philox source(gmis_test::seed(62));
  CameraDescription description = look_at({1, 2, 3}, {0, 0.5, -2}, {0, 1, 0}, 50, {21, 30});
  for (int i = 0; i < 3; ++i) description.world_from_camera[i] *= 2.0;
  description.lens_radius = 0.2;   // 0.4 in the world
  description.focal_distance = 3;  // 6
  const glm::dvec3 eye(description.world_from_camera[3]);
  const scene::Camera<T> camera(description, eye);
  const auto axis = [&](int i) { return glm::dvec3(description.world_from_camera[i]) / 2.0; };

  constexpr int rings = 8, sectors = 12;
  std::vector<double> counts(rings * sectors), expected(rings * sectors, 100.0);
  const glm::ivec2 pixel(3, 25);
  const auto middle = camera.sample_ray(pixel, {0.3, 0.6}, {0.5, 0.5});
  REQUIRE(glm::length(middle->origin.position) < 1e-12);
  const double to_focus = 6 / glm::dot(middle->direction, axis(2));
  double blur = 0, farthest = 0;
  for (int i = 0; i < 100 * rings * sectors; ++i) {
    const Vec2<T> uv = random_square<T>(source);
    const auto ray = camera.sample_ray(pixel, {0.3, 0.6}, uv);
    const double x = glm::dot(ray->origin.position, axis(0)) / 0.4, y = glm::dot(ray->origin.position, axis(1)) / 0.4;
    farthest = std::max({farthest, std::abs(x), std::abs(y)});
    const auto ring = static_cast<std::size_t>(std::min((x * x + y * y) * rings, rings - 0.5));
    const auto sector = static_cast<std::size_t>((std::atan2(y, x) / (2 * pi<double>)+0.5) * sectors * 0.999999999);
    ++counts[ring * sectors + sector];
    // Every ray of this place in the pixel goes through one point of the plane of focus.
    const double t = (6 - glm::dot(ray->origin.position, axis(2))) / glm::dot(ray->direction, axis(2));
    const auto sharp = ray->origin.position + ray->direction * t;
    if (!(glm::length(sharp - middle->direction * to_focus) < 1e-12)) FAIL("the plane of focus is not sharp");
    // A point at depth z spreads over a disk of radius R |1/z − 1/f| on the plane z = 1 [thin
    // lens].
    const auto seen = camera.project(axis(2) * 2.0, uv);
    REQUIRE(seen);
    const double step = (description.window[1] - description.window[0]) / 21;
    blur = std::max(blur, (seen->pixel.x + 1) * step + description.window[0]);
    if (!(seen->pixel.x * step + description.window[0] <= 0.4 * (1.0 / 2 - 1.0 / 6))) FAIL("blurred too far");
  }
  CHECK(chi_square_test(counts, expected).passes(1e-4));
  CHECK(farthest == Approx(1).epsilon(5e-3));
  CHECK(blur >= 0.4 * (1.0 / 2 - 1.0 / 6) * 0.99);
}

TEST_CASE("parallel rays see the same size at every depth", "[camera]") {
  CameraDescription description = look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 90, {80, 40});
  description.projection = Projection::orthographic;
  description.window = {-2, 2, -1, 1};
  const scene::Camera<double> camera(description, {0, 0, 0});
  CHECK(camera.has_parallel_rays());
  for (const double depth : {0.01, 1.0, 100.0}) {
    const auto seen = camera.project({0.51, 0.26, -depth}, {});
    REQUIRE(seen);
    CHECK(seen->pixel == glm::ivec2(50, 14));
    CHECK(seen->density == Approx(400));  // pixels of 0.05 × 0.05
    CHECK(glm::length(seen->origin.position - Vec3<double>(0.51, 0.26, 0)) < 1e-12);
    CHECK_FALSE(camera.project({2.01, 0, -depth}, {}));
    CHECK_FALSE(camera.project({0, 0, depth}, {}));
  }
}

TEST_CASE("left is left and up is up", "[camera]") {
  const auto description = look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 90, {100, 100});
  const scene::Camera<double> camera(description, {0, 0, 0});
  CHECK(camera.project({0.5, 0, -1}, {})->pixel.x == 75);  // right of a viewer that looks along −z with y up is +x
  CHECK(camera.project({0, 0.505, -1}, {})->pixel.y == 24);
  CHECK_FALSE(camera.project({1.01, 0, -1}, {}));
  CHECK_FALSE(camera.project({0, 0, 1}, {}));
  CHECK_FALSE(camera.project({0, 0, 0}, {}));
  // 90 degrees span the shorter side.
  const scene::Camera<double> wide(look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 90, {200, 100}), {0, 0, 0});
  CHECK(wide.project({0, 0.999, -1}, {})->pixel.y == 0);
  CHECK_FALSE(wide.project({0, 1.001, -1}, {}));
  CHECK(wide.project({1.999, 0, -1}, {})->pixel.x == 199);
}

TEST_CASE("what is no camera is refused", "[camera]") {
  CameraDescription bad = camera_at({0, 0, 0});
  bad.world_from_camera[0] = glm::dvec4(0);
  CHECK_THROWS_AS(scene::Camera<float>(bad, glm::dvec3(0)), std::invalid_argument);
  bad = camera_at({0, 0, 0});
  bad.world_from_camera[1][0] += 0.2;
  CHECK_THROWS_AS(scene::Camera<float>(bad, glm::dvec3(0)), std::invalid_argument);
  bad = camera_at({0, 0, 0});
  bad.window = {0, 0, -1, 1};
  CHECK_THROWS_AS(scene::Camera<float>(bad, glm::dvec3(0)), std::invalid_argument);
  bad = camera_at({0, 0, 0});
  bad.resolution = {0, 5};
  CHECK_THROWS_AS(scene::Camera<float>(bad, glm::dvec3(0)), std::invalid_argument);
  bad = camera_at({0, 0, 0});
  bad.lens_radius = -1;
  CHECK_THROWS_AS(scene::Camera<float>(bad, glm::dvec3(0)), std::invalid_argument);
  bad.lens_radius = 1;
  bad.focal_distance = 0;
  CHECK_THROWS_AS(scene::Camera<float>(bad, glm::dvec3(0)), std::invalid_argument);
  bad.focal_distance = 1;
  bad.projection = Projection::orthographic;
  CHECK_THROWS_AS(scene::Camera<float>(bad, glm::dvec3(0)), std::invalid_argument);
}

}  // namespace
