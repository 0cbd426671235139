#include "scene/shapes.hpp"
#include "support/catch.hpp"

using namespace gmis;
using namespace gmis::scene;
using namespace scene_test;

namespace {

std::vector<PinholeDescription> cameras() {
  PinholeDescription wide = look_at({1, 2, 3}, {0, 0.5, -2}, {0, 1, 0}, 70, {40, 17});
  PinholeDescription mirrored = wide;
  mirrored.world_from_camera[0] *= -1;  // as pbrt's `Scale -1 1 1`
  PinholeDescription scaled = look_at({1e5, -2e5, 3e5}, {1e5, -2e5, 3e5 + 1}, {1, 1, 0}, 25, {9, 31});
  scaled.world_from_camera[0] *= 3.0;
  PinholeDescription shifted = wide;
  shifted.window = {0.1, 0.5, -0.3, -0.1};
  return {wide, mirrored, scaled, shifted};
}

TEMPLATE_TEST_CASE("a point along a ray of a pixel is seen by that pixel, with the same density", "[camera]", float,
                   double) {
  using T = TestType;
  Philox source(61);
  for (const auto& description : cameras()) {
    const Pinhole<T> camera(description, glm::dvec3(description.world_from_camera[3]));
    const auto size = camera.resolution();
    int wrong = 0;
    double worst = 0;
    for (int i = 0; i < 4000; ++i) {
      const glm::ivec2 pixel(static_cast<int>(uniform_index(source, static_cast<std::uint32_t>(size.x))),
                             static_cast<int>(uniform_index(source, static_cast<std::uint32_t>(size.y))));
      // Away from the border of the pixel, where rounding may decide.
      const Vec2<T> inside = Vec2<T>(T(0.01)) + random_square<T>(source) * T(0.98);
      const auto ray = camera.sample_ray(pixel, inside, {T(0), T(0)});
      REQUIRE(ray);
      const T distance = static_cast<T>(random_magnitude(source, -2, 3));
      const auto seen = camera.project(ray->origin.position + ray->direction * distance, {T(0), T(0)});
      if (!seen || seen->pixel != pixel) {
        ++wrong;
        continue;
      }
      worst = std::max({worst, std::abs(1 - double(seen->density / ray->density)),
                        static_cast<double>(glm::length(seen->to_camera + ray->direction)),
                        std::abs(1 - static_cast<double>(glm::length(ray->direction)))});
      wrong += camera.project(ray->origin.position - ray->direction * distance, {T(0), T(0)}) ? 1 : 0;
    }
    CHECK(wrong == 0);
    CHECK(worst < (std::same_as<T, float> ? 1e-5 : 1e-12));
  }
}

TEST_CASE("the density of a pixel's rays integrates to one over the pixel", "[camera]") {
  using T = double;
  for (const auto& description : cameras()) {
    const Pinhole<T> camera(description, glm::dvec3(description.world_from_camera[3]));
    const glm::ivec2 pixel(camera.resolution().x - 1, 0);
    // Solid angle of a small patch from the directions of its corners, independent of the density's formula.
    double integral = 0;
    constexpr int steps = 64;
    const auto direction = [&](double x, double y) { return camera.sample_ray(pixel, {x, y}, {0, 0})->direction; };
    for (int i = 0; i < steps; ++i)
      for (int j = 0; j < steps; ++j) {
        const double x = double(i) / steps, y = double(j) / steps, h = 1.0 / steps;
        const auto a = direction(x, y), b = direction(x + h, y), c = direction(x, y + h);
        integral +=
            glm::length(glm::cross(b - a, c - a)) * camera.sample_ray(pixel, {x + h / 2, y + h / 2}, {})->density;
      }
    CHECK(integral == Approx(1).epsilon(1e-3));
  }
}

TEST_CASE("left is left and up is up", "[camera]") {
  const auto description = look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 90, {100, 100});
  const Pinhole<double> camera(description, {0, 0, 0});
  CHECK(camera.project({0.5, 0, -1}, {})->pixel.x == 75);  // right of a viewer that looks along −z with y up is +x
  CHECK(camera.project({0, 0.505, -1}, {})->pixel.y == 24);
  CHECK_FALSE(camera.project({1.01, 0, -1}, {}));
  CHECK_FALSE(camera.project({0, 0, 1}, {}));
  CHECK_FALSE(camera.project({0, 0, 0}, {}));
  // 90 degrees span the shorter side.
  const Pinhole<double> wide(look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 90, {200, 100}), {0, 0, 0});
  CHECK(wide.project({0, 0.999, -1}, {})->pixel.y == 0);
  CHECK_FALSE(wide.project({0, 1.001, -1}, {}));
  CHECK(wide.project({1.999, 0, -1}, {})->pixel.x == 199);
}

TEST_CASE("what is no camera is refused", "[camera]") {
  PinholeDescription bad = camera_at({0, 0, 0});
  bad.world_from_camera[0] = glm::dvec4(0);
  CHECK_THROWS_AS(Pinhole<float>(bad, glm::dvec3(0)), std::invalid_argument);
  bad = camera_at({0, 0, 0});
  bad.world_from_camera[1][0] += 0.2;
  CHECK_THROWS_AS(Pinhole<float>(bad, glm::dvec3(0)), std::invalid_argument);
  bad = camera_at({0, 0, 0});
  bad.window = {0, 0, -1, 1};
  CHECK_THROWS_AS(Pinhole<float>(bad, glm::dvec3(0)), std::invalid_argument);
  bad = camera_at({0, 0, 0});
  bad.resolution = {0, 5};
  CHECK_THROWS_AS(Pinhole<float>(bad, glm::dvec3(0)), std::invalid_argument);
}

}  // namespace
