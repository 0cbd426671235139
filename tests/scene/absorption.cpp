#include "gmis/scene/absorption.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"
#include "gmis/scene.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using gmis::scene::make_dielectric;
using gmis::scene::make_diffuse;
using gmis::scene::with_absorption;
using Builder = gmis::scene::SceneBuilder<double>;
using Vec = glm::dvec3;

namespace {

/// A ball of glass of radius 2 with a ball of water of radius 1 in it, in which there is a diffuse
/// ball of radius 0.25.
template <std::floating_point T>
auto nested_balls() {
  gmis::scene::SceneBuilder<T> builder;
  const Vec glass(0.5, 1, 2), water(3, 0.25, 0);
  builder.add_sphere({0, 0, 10}, 2, builder.add_material(with_absorption(make_dielectric<T>(1.5), glass)));
  builder.add_sphere({0, 0, 10}, 1, builder.add_material(with_absorption(make_dielectric<T>(0.9), water, glass)));
  builder.add_sphere({0, 0, 10}, 0.25, builder.add_material(make_diffuse<T>(Vec(0.5))));
  builder.set_camera(gmis::scene::look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 40, {4, 4}));
  return builder.build();
}

/// The length of the segment from a to b within the ball of radius r around c.
double length_within(const Vec& a, const Vec& b, const Vec& c, double r) {
  const Vec d = glm::normalize(b - a);
  const double middle = glm::dot(c - a, d), away = glm::dot(c - a, c - a) - middle * middle;
  if (away >= r * r) return 0;
  const double half = std::sqrt(r * r - away);
  return std::max(0.0, std::min(middle + half, glm::length(b - a)) - std::max(middle - half, 0.0));
}

}  // namespace

TEST_CASE("the transmittance of a segment is that of the medium that it is in, both ways") {
  const auto scene = nested_balls<double>();
  REQUIRE(scene.has_absorption());
  gmis::Philox source(gmis_test::seed(5), 0);
  int inside_water = 0, inside_glass = 0, outside = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto offset = [&](double size) {
      const auto number = [&] { return (2 * gmis::uniform<double>(source) - 1) * size; };
      return Vec(number(), number(), number());
    };
    const Vec a = Vec(0, 0, 10) + offset(2.2), b = a + offset(0.8), direction = glm::normalize(b - a), center(0, 0, 10);
    const gmis::Ray<double> there{a, direction, glm::length(b - a)}, back{b, -direction, there.t_max};
    if (!scene.visible(there)) continue;
    const double water = length_within(a, b, center, 1), glass = length_within(a, b, center, 2) - water;
    (water > 0 ? inside_water : glass > 0 ? inside_glass : outside) += 1;
    for (const auto& ray : {there, back}) {
      const Vec found = scene.transmittance(ray);
      const Vec truth = glm::exp(-(Vec(0.5, 1, 2) * glass + Vec(3, 0.25, 0) * water));
      CAPTURE(i, water, glass);
      CHECK(glm::length(found - truth) < 1e-9);
    }
  }
  CHECK(inside_water > 100);
  CHECK(inside_glass > 100);
  CHECK(outside > 100);
}

TEST_CASE("the transmittance in float is that in double") {
  const auto coarse = nested_balls<float>();
  const auto fine = nested_balls<double>();
  gmis::Philox source(gmis_test::seed(6), 0);
  for (int i = 0; i < 2000; ++i) {
    const Vec direction =
        gmis::square_to_sphere(gmis::Vec2<double>(gmis::uniform<double>(source), gmis::uniform<double>(source)));
    const Vec start = Vec(0, 0, 10) + direction * (0.3 + 1.6 * gmis::uniform<double>(source));
    const gmis::Ray<double> ray{start, -direction, 0.01};
    const gmis::Ray<float> same{glm::vec3(start), glm::vec3(-direction), 0.01F};
    if (!fine.visible(ray) || !coarse.visible(same)) continue;
    CHECK(glm::length(Vec(coarse.transmittance(same)) - fine.transmittance(ray)) < 1e-5);
  }
}

TEST_CASE("a scene without absorption says so") {
  Builder builder;
  builder.add_sphere({0, 0, 10}, 2, builder.add_material(make_dielectric<double>(1.5)));
  // A material that no shape has is no boundary.
  (void)builder.add_material(with_absorption(make_dielectric<double>(1.5), Vec(1)));
  builder.set_camera(gmis::scene::look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 40, {4, 4}));
  CHECK_FALSE(builder.build().has_absorption());
}

TEST_CASE("what cannot be the boundary of a medium is refused") {
  CHECK_THROWS_AS(with_absorption(make_diffuse<float>(Vec(0.5)), Vec(1)), std::invalid_argument);
  CHECK_THROWS_AS(with_absorption(make_dielectric<float>(1.5), Vec(-1, 0, 0)), std::invalid_argument);
  CHECK_THROWS_AS(with_absorption(make_dielectric<float>(1.5), Vec(0), Vec(std::nan(""))), std::invalid_argument);
  CHECK_THROWS_AS(with_absorption(gmis::scene::make_thin_dielectric<float>(1.5), Vec(1)), std::invalid_argument);
  const auto glass = with_absorption(make_dielectric<float>(1.5), Vec(1));
  const auto half = gmis::scene::Texture<float>::constant(Vec(0.5));
  CHECK_THROWS_AS(make_mix(glass, make_diffuse<float>(Vec(0.5)), half), std::invalid_argument);
  gmis::scene::MaterialTextures<float> cut;
  cut.opacity = half;
  CHECK_THROWS_AS(with_textures(glass, cut), std::invalid_argument);
  CHECK_THROWS_AS(with_absorption(with_textures(make_dielectric<float>(1.5), cut), Vec(1)), std::invalid_argument);
}
