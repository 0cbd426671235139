#include "gmis/scene/varying_material.hpp"

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/scene/bsdf.hpp"
#include "gmis/scene/scene_builder.hpp"
#include "scene/bsdf_checks.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;

namespace {

const Vec3<double> axis = glm::normalize(Vec3<double>(0.3, -0.5, 0.7));
const glm::dvec3 copper_eta{0.2, 0.92, 1.1}, copper_k{3.9, 2.45, 2.14};

Vec3<double> at_cosine(double cosine) {
  return Frame<double>::around(axis).to_world(
      {std::sqrt(1 - cosine * cosine) * 0.6, std::sqrt(1 - cosine * cosine) * 0.8, cosine});
}

/// Red grows with u and green with v: every colour once.
template <std::floating_point T>
typename Texture<T>::Handle ramp() {
  auto image = std::make_shared<TextureImage>();
  image->resolution = {2, 2};
  image->floats = {0, 1, 0.3F, 1, 1, 0.3F, 0, 0, 0.3F, 1, 0, 0.3F};
  return Texture<T>::image(image, {{0.5, 0.5}, {0.25, 0.25}}, TextureWrap::clamp);
}

template <std::floating_point T>
MaterialTextures<T> colored() {
  MaterialTextures<T> result;
  result.color = ramp<T>();
  return result;
}

template <std::floating_point T>
MaterialTextures<T> see_through() {
  MaterialTextures<T> result;
  result.transmittance = ramp<T>();
  return result;
}

template <std::floating_point T>
MaterialTextures<T> roughened(bool is_remapped) {
  MaterialTextures<T> result;
  result.roughness = ramp<T>();
  result.is_remapped = is_remapped;
  return result;
}

SurfaceCoordinates<double> at_uv(double u, double v, const Vec3<double>& position = Vec3<double>(0)) {
  SurfaceCoordinates<double> at;
  at.uv = {u, v};
  at.position = position;
  return at;
}

/// Lobes that no other test has.
std::vector<std::pair<std::string, Material<double>>> new_lobes() {
  return {{"sheet", make_diffuse_transmission<double>({0.6, 0.3, 0.1}, {0.2, 0.5, 0.4})},
          {"sheet, no reflection", make_diffuse_transmission<double>({0, 0, 0}, {0.9, 0.5, 0.4})},
          {"coated metal", make_coated_conductor<double>(copper_eta, copper_k, 0.2, 1.5, 0.1)},
          {"coated smooth metal", make_coated_conductor<double>(copper_eta, copper_k, 0, 1.5, 0.3)},
          {"smoothly coated metal", make_coated_conductor<double>(copper_eta, copper_k, 0.3, 1.8, 0)},
          {"coated, coloured", with_textures(make_coated_diffuse<double>({1, 1, 1}, 1.5, 0.3), colored<double>())},
          {"coated, rough here and there",
           with_textures(make_coated_diffuse<double>({.7, .3, .2}, 1.5, 0.3), roughened<double>(true))},
          {"metal, rough here and there",
           with_textures(make_conductor<double>(copper_eta, copper_k, 0.3), roughened<double>(false))},
          {"glass, rough here and there", with_textures(make_dielectric<double>(1.5, 0.3), roughened<double>(true))}};
}

// False-alarm rate of all χ² tests of this file together: 1e-3.
const double level = sidak_level(1e-3, 100);

}  // namespace

TEST_CASE("sheets, coated metals and varying materials draw with the densities they state, and make no energy",
          "[long]") {
  Philox source(gmis_test::seed(311));
  for (const auto& [name, material] : new_lobes())
    for (const double u : {0.1, 0.8})
      for (const double cosine : {0.9, 0.3, -0.5}) {
        INFO(name << ", cos = " << cosine << ", u = " << u);
        const SurfaceBsdf<double> bsdf(material, axis, axis, at_uv(u, 0.6));
        scene_test::check_at_point(bsdf, axis, at_cosine(cosine), source, 1e-6, level, {5e-3, 1e-2, 2e-3});
      }
}

TEST_CASE("sheets let light through, and do not promise to reflect only; what promises it is dark from side to side") {
  Philox source(gmis_test::seed(313));
  for (const auto& [name, material] : new_lobes()) {
    INFO(name);
    const SurfaceBsdf<double> bsdf(material, axis, axis, at_uv(0.3, 0.6));
    bool lets_through = false;
    for (int i = 0; i < 500; ++i) {
      const auto [a, b, c, d] = uniforms<double, 4>(source);
      const Vec3<double> prev = square_to_sphere(Vec2<double>{a, b}), next = square_to_sphere(Vec2<double>{c, d});
      if (glm::dot(prev, axis) * glm::dot(next, axis) > 0) continue;
      lets_through = lets_through || !is_black(bsdf.evaluate(prev, next, TransportMode::radiance).value);
    }
    CHECK(reflects_only(bsdf) == !lets_through);
  }
}

TEST_CASE("each lobe of a sheet and of a coated metal makes its density") {
  Philox source(gmis_test::seed(312));
  for (const auto& [name, material] : new_lobes()) {
    const SurfaceBsdf<double> bsdf(material, axis, axis, at_uv(0.3, 0.6));
    for (const double cosine : {0.7, -0.6}) {
      INFO(name << ", cos = " << cosine);
      scene_test::check_lobes(bsdf, axis, at_cosine(cosine), source, 1e-6, level);
    }
  }
}

TEST_CASE("a sheet scatters its reflectance to one side and its transmittance to the other") {
  Philox source(gmis_test::seed(313));
  const glm::dvec3 r{0.6, 0.3, 0.1}, t{0.2, 0.5, 0.4};
  const auto material = make_diffuse_transmission<double>(r, t);
  const SurfaceBsdf<double> bsdf(material, axis, axis);
  CHECK(bsdf.albedo().x == Approx(0.8));
  Vec3<double> to_side[2]{};
  constexpr int count = 20'000;
  for (int i = 0; i < count; ++i) {
    const double u = uniform<double>(source), x = uniform<double>(source), y = uniform<double>(source);
    const auto sample = bsdf.sample(at_cosine(0.4), u, {x, y}, TransportMode::radiance);
    REQUIRE(sample);
    to_side[glm::dot(axis, sample->to_next) > 0 ? 0 : 1] += sample->weight / double(count);
  }
  // A lobe's weight is a constant, so only how often it is chosen is by chance: six standard
  // deviations.
  const double p = 0.6 / 1.1;
  const double sigma = std::sqrt(p * (1 - p) / count);
  for (int c = 0; c < 3; ++c) {
    CHECK(std::abs(to_side[0][c] - r[c]) < 6 * sigma / p * r[c]);
    CHECK(std::abs(to_side[1][c] - t[c]) < 6 * sigma / (1 - p) * t[c]);
  }
}

TEST_CASE("a smooth metal under a smooth coat reflects the sum over all ways to and fro") {
  const auto material = make_coated_conductor<double>(copper_eta, copper_k, 0, 1.5, 0);
  const SurfaceBsdf<double> bsdf(material, axis, axis);
  REQUIRE(bsdf.is_purely_delta());
  for (const double cosine : {1.0, 0.7, 0.2, 0.05}) {
    const auto sample = bsdf.sample(at_cosine(cosine), 0.5, {0.5, 0.5}, TransportMode::radiance);
    REQUIRE(sample);
    CHECK(sample->is_delta);
    const double sine2 = 1 - cosine * cosine, inner = std::sqrt(1 - sine2 / (1.5 * 1.5));
    const double coat = fresnel_dielectric(cosine, 1.5).reflectance;
    const double from_within = fresnel_dielectric(inner, 1 / 1.5).reflectance;
    for (int c = 0; c < 3; ++c) {
      const double metal = fresnel_conductor(inner, copper_eta[c] / 1.5, copper_k[c] / 1.5);
      double sum = coat, within = (1 - coat) * metal;
      for (int i = 0; i < 2000; ++i) {
        sum += within * (1 - from_within);
        within *= from_within * metal;
      }
      CHECK(sample->weight[c] == Approx(sum).epsilon(1e-9));
    }
  }
  // Rough layers that are nearly smooth reflect nearly as much.
  for (const auto& rough : {make_coated_conductor<double>(copper_eta, copper_k, 0.02, 1.5, 0.02),
                            make_coated_conductor<double>(copper_eta, copper_k, 0.02, 1.5, 0)}) {
    const SurfaceBsdf<double> near(rough, axis, axis);
    Philox source(gmis_test::seed(314));
    Vec3<double> mean(0);
    constexpr int count = 20'000;
    for (int i = 0; i < count; ++i) {
      const double u = uniform<double>(source), x = uniform<double>(source), y = uniform<double>(source);
      if (const auto sample = near.sample(at_cosine(0.8), u, {x, y}, TransportMode::radiance))
        mean += sample->weight / double(count);
    }
    const auto smooth = bsdf.sample(at_cosine(0.8), 0.5, {0.5, 0.5}, TransportMode::radiance)->weight;
    for (int c = 0; c < 3; ++c) CHECK(mean[c] == Approx(smooth[c]).epsilon(0.03));
  }
}

TEST_CASE("a material with textures is the plain material of the colour and roughness at each point") {
  struct Case {
    const char* name;
    Material<double> varying;
    Material<double> (*plain)(const glm::dvec3& color);
  };
  const std::vector<Case> cases{
      {"diffuse", with_textures(make_diffuse<double>({1, 1, 1}), colored<double>()),
       [](const glm::dvec3& c) { return make_diffuse<double>(c); }},
      {"phong", with_textures(make_phong<double>({1, 1, 1}, {.3, .2, .1}, 30), colored<double>()),
       [](const glm::dvec3& c) {
         return make_phong<double>(c, {.3, .2, .1}, 30);
       }},
      {"coated", with_textures(make_coated_diffuse<double>({1, 1, 1}, 1.5, .3), colored<double>()),
       [](const glm::dvec3& c) { return make_coated_diffuse<double>(c, 1.5, .3); }},
      {"smooth coat", with_textures(make_coated_diffuse<double>({1, 1, 1}, 1.5, 0), colored<double>()),
       [](const glm::dvec3& c) { return make_coated_diffuse<double>(c, 1.5, 0); }},
      {"metal", with_textures(make_conductor_of_reflectance<double>({.5, .5, .5}, .3), colored<double>()),
       [](const glm::dvec3& c) { return make_conductor_of_reflectance<double>(c, .3); }},
      {"sheet", with_textures(make_diffuse_transmission<double>({1, 1, 1}, {.2, .1, 0}), colored<double>()),
       [](const glm::dvec3& c) {
         return make_diffuse_transmission<double>(c, {.2, .1, 0});
       }},
      {"sheet that lets more or less through",
       with_textures(make_diffuse_transmission<double>({.3, .2, .1}, {1, 1, 1}), see_through<double>()),
       [](const glm::dvec3& c) {
         return make_diffuse_transmission<double>({.3, .2, .1}, c);
       }},
      {"rough coat", with_textures(make_coated_diffuse<double>({.7, .3, .2}, 1.5, .3), roughened<double>(true)),
       [](const glm::dvec3& c) {
         return make_coated_diffuse<double>({.7, .3, .2}, 1.5, std::sqrt(c.x));
       }},
      {"rough metal", with_textures(make_conductor<double>(copper_eta, copper_k, .3), roughened<double>(false)),
       [](const glm::dvec3& c) { return make_conductor<double>(copper_eta, copper_k, c.x); }},
      {"rough glass", with_textures(make_dielectric<double>(1.5, .3), roughened<double>(true)),
       [](const glm::dvec3& c) { return make_dielectric<double>(1.5, std::sqrt(c.x)); }}};
  for (const Case& one : cases)
    for (const double u : {0.1, 0.4, 0.9})
      for (const double v : {0.25, 0.8}) {
        CAPTURE(one.name, u, v);
        const Material<double> plain_material = one.plain({u, v, 0.3F});
        const SurfaceBsdf<double> plain(plain_material, axis, axis);
        const SurfaceBsdf<double> here(one.varying, axis, axis, at_uv(u, v));
        for (const double cosine : {0.8, -0.3})
          for (const double turn : {0.3, 2.0}) {
            const Vec3<double> to_next = Frame<double>::around(axis).to_world(
                {std::cos(turn) * 0.6, std::sin(turn) * 0.6, turn < 1 ? 0.8 : -0.8});
            const auto a = plain.evaluate(at_cosine(cosine), to_next, TransportMode::importance).value;
            const auto b = here.evaluate(at_cosine(cosine), to_next, TransportMode::importance).value;
            for (int c = 0; c < 3; ++c) CHECK(b[c] == Approx(a[c]).epsilon(1e-6).margin(1e-12));
          }
        for (int c = 0; c < 3; ++c) CHECK(here.albedo()[c] == Approx(plain.albedo()[c]).epsilon(1e-6));
      }
}

TEST_CASE("a mixture has either part at each point, in its share, and keeps it for a point seen again") {
  const auto mix = make_mix<double>(make_diffuse<double>({0.8, 0, 0}),
                                    make_coated_conductor<double>(copper_eta, copper_k, 0, 1.5, 0),
                                    Texture<double>::constant(glm::dvec3(0.3)));
  std::mt19937_64 random(gmis_test::seed(315));
  std::uniform_real_distribution<double> coordinate(-3, 3);
  constexpr int count = 100'000;
  int second = 0;
  for (int i = 0; i < count; ++i) {
    const auto at = at_uv(0, 0, {coordinate(random), coordinate(random), 0});
    const SurfaceBsdf<double> bsdf(mix, axis, axis, at);
    second += bsdf.is_purely_delta();
    CHECK(bsdf.is_purely_delta() == SurfaceBsdf<double>(mix, axis, axis, at).is_purely_delta());
  }
  // A false alarm in 1e-9 of the seeds.
  CHECK(std::abs(second / double(count) - 0.3) < 6.1 * std::sqrt(0.3 * 0.7 / count));
  // A mixture of mixtures makes its choices independently: 0.3 · 0.5 of all points.
  const auto nested =
      make_mix<double>(make_diffuse<double>({0.8, 0, 0}),
                       make_mix<double>(make_diffuse<double>({0, 0.8, 0}), make_mirror<double>({1, 1, 1}),
                                        Texture<double>::constant(glm::dvec3(0.5))),
                       Texture<double>::constant(glm::dvec3(0.3)));
  int third = 0;
  for (int i = 0; i < count; ++i)
    third += SurfaceBsdf<double>(nested, axis, axis, at_uv(0, 0, {coordinate(random), coordinate(random), 1}))
                 .is_purely_delta();
  CHECK(std::abs(third / double(count) - 0.15) < 6.1 * std::sqrt(0.15 * 0.85 / count));
  Effects effects;
  add_effects_of(nested, effects);
  CHECK(effects.diffuse);
  CHECK(effects.specular_reflection);
}

TEST_CASE("the effects of new lobes and of textures are those of all their points") {
  const auto effects_of_material = [](const Material<double>& material) {
    Effects effects;
    add_effects_of(material, effects);
    return effects;
  };
  CHECK(effects_of_material(make_diffuse_transmission<double>({0, 0, 0}, {1, 1, 1})).diffuse);
  CHECK(effects_of_material(make_coated_conductor<double>(copper_eta, copper_k, 0, 1.5, 0)).specular_reflection);
  CHECK_FALSE(effects_of_material(make_coated_conductor<double>(copper_eta, copper_k, 0, 1.5, 0)).has_scattering());
  const Effects smooth = effects_of_material(make_coated_conductor<double>(copper_eta, copper_k, 0.3, 1.5, 0));
  CHECK(smooth.specular_reflection);
  CHECK(smooth.purely_glossy);
  CHECK_FALSE(smooth.diffuse);
  CHECK(smooth.least_roughness == Approx(0.3));
  const Effects rough = effects_of_material(make_coated_conductor<double>(copper_eta, copper_k, 0.4, 1.5, 0.3));
  CHECK_FALSE(rough.has_specular());
  CHECK(rough.least_roughness == Approx(0.3));
  CHECK(rough.greatest_roughness == Approx(0.5));
  const Effects varied =
      effects_of_material(with_textures(make_conductor<double>(copper_eta, copper_k, 0.3), roughened<double>(true)));
  CHECK(varied.least_roughness == Approx(smallest_alpha));
  CHECK(varied.greatest_roughness == Approx(1));
  MaterialTextures<double> bump;
  bump.height = ramp<double>();
  CHECK(effects_of_material(with_textures(make_diffuse<double>({1, 1, 1}), bump)).shading_normals);
}

TEST_CASE("bump and normal maps turn the shading normal as the surface that they stand for is turned") {
  // z = 0.4 u on the unit square, u along x: the normal is (−0.4, 0, 1) / √1.16.
  auto image = std::make_shared<TextureImage>();
  image->resolution = {2, 1};
  image->floats = {0, 0, 0, 0.2F, 0.2F, 0.2F};
  MaterialTextures<double> textures;
  textures.height = Texture<double>::image(image, {}, TextureWrap::clamp);
  const auto bumpy = with_textures(make_diffuse<double>({1, 1, 1}), textures);
  SurfaceCoordinates<double> at = at_uv(0.5, 0.5);
  at.along_u = {1, 0, 0};
  at.along_v = {0, 1, 0};
  const Vec3<double> up(0, 0, 1);
  const Vec3<double> tilted = glm::normalize(Vec3<double>(-0.4, 0, 1));
  CHECK(glm::length(SurfaceBsdf<double>(bumpy, up, up, at).shading_normal() - tilted) < 1e-6);
  // Seen as a surface with its normal on the other side, it is pushed to that side.
  CHECK(glm::length(SurfaceBsdf<double>(bumpy, -up, -up, at).shading_normal() - Vec3<double>(tilted.x, 0, -tilted.z)) <
        1e-6);
  at.along_u = {0, 0, 0};  // no coordinates, no bump
  CHECK(SurfaceBsdf<double>(bumpy, up, up, at).shading_normal() == up);

  at.along_u = {2, 0, 0};
  for (const auto& [code, expected] :
       std::vector<std::pair<glm::dvec3, Vec3<double>>>{{{0.5, 0.5, 1}, up},
                                                        {{0.8, 0.5, 0.9}, glm::normalize(Vec3<double>(0.6, 0, 0.8))},
                                                        {{0.5, 0.8, 0.9}, glm::normalize(Vec3<double>(0, 0.6, 0.8))}}) {
    MaterialTextures<double> map;
    map.normal_map = Texture<double>::constant(code);
    const auto mapped = with_textures(make_diffuse<double>({1, 1, 1}), map);
    CHECK(glm::length(SurfaceBsdf<double>(mapped, up, up, at).shading_normal() - expected) < 1e-9);
  }
  // Normals that point inside, or nowhere, stay in the hemisphere of the surface.
  for (const glm::dvec3 code : {glm::dvec3(0.5, 0.5, 0), glm::dvec3(1, 0.5, 0.3), glm::dvec3(0.5), glm::dvec3(0)}) {
    MaterialTextures<double> map;
    map.normal_map = Texture<double>::constant(code);
    const auto mapped = with_textures(make_diffuse<double>({1, 1, 1}), map);
    const Vec3<double> normal = SurfaceBsdf<double>(mapped, up, up, at).shading_normal();
    CHECK(glm::length(normal) == Approx(1));
    CHECK(normal.z > 0);
  }
}

TEST_CASE("coordinates of triangles and spheres are those of finite differences") {
  std::mt19937_64 random(gmis_test::seed(316));
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3<double>(number(random), number(random), number(random)); };
  for (int i = 0; i < 100; ++i) {
    const std::array corners{vector(), vector(), vector()};
    const TriangleCoordinates<double> uv{Vec2<double>(vector()), Vec2<double>(vector()), Vec2<double>(vector())};
    const Vec3<double> weights(0.2, 0.3, 0.5);
    const auto place = [&](const Vec3<double>& w) { return corners[0] * w.x + corners[1] * w.y + corners[2] * w.z; };
    const auto at = triangle_coordinates(uv, corners, weights, place(weights));
    for (const Vec3<double> step : {Vec3<double>(-0.1, 0.1, 0), Vec3<double>(-0.1, 0, 0.1)}) {
      const auto moved = triangle_coordinates(uv, corners, weights + step, place(weights + step));
      const Vec2<double> by = moved.uv - at.uv;
      CHECK(glm::length(place(weights + step) - at.position - at.along_u * by.x - at.along_v * by.y) < 1e-9);
    }
    const Frame<double> frame = Frame<double>::around(glm::normalize(vector()));
    const std::array axes{frame.tangent, frame.bitangent, frame.normal};
    const Vec3<double> outward = glm::normalize(vector());
    const auto on = sphere_coordinates(axes, 2.5, outward, outward * 2.5);
    CHECK((on.uv.x >= 0 && on.uv.x <= 1 && on.uv.y >= 0 && on.uv.y <= 1));
    for (const int axis_number : {0, 1}) {
      const Vec3<double> tangent = axis_number == 0 ? on.along_u : on.along_v;
      constexpr double step = 1e-6;
      const auto moved = sphere_coordinates(axes, 2.5, glm::normalize(outward * 2.5 + tangent * step), outward);
      Vec2<double> by = (moved.uv - on.uv) / step;
      if (std::abs(by.x) > 1e4) continue;  // across the seam
      CHECK(by.x == Approx(axis_number == 0 ? 1 : 0).margin(1e-3));
      CHECK(by.y == Approx(axis_number == 1 ? 1 : 0).margin(1e-3));
    }
  }
  const auto flat = triangle_coordinates<double>({Vec2<double>(1, 1), Vec2<double>(1, 1), Vec2<double>(1, 1)},
                                                 {Vec3<double>(0), Vec3<double>(1, 0, 0), Vec3<double>(0, 1, 0)},
                                                 {0.2, 0.3, 0.5}, {0.3, 0.5, 0});
  CHECK(flat.along_u == Vec3<double>(0));
}

namespace {

TEST_CASE("a sheet that only transmits has one lobe, with holes as without") {
  const auto plain = make_diffuse_transmission<double>({0, 0, 0}, {0.8, 0.8, 0.8});
  MaterialTextures<double> textures;
  textures.opacity = Texture<double>::constant(glm::dvec3(0.5));
  const auto cut = with_textures(plain, textures);
  const Vec3<double> up(0, 0, 1), to_prev = glm::normalize(Vec3<double>(0.3, 0.2, 0.8));
  for (const auto* material : {&plain, &cut}) {
    const SurfaceBsdf<double> bsdf(*material, up, up);
    REQUIRE(bsdf.lobe_count() == 1);
    const auto to_next = bsdf.sample_lobe(0, to_prev, {0.3, 0.6}, TransportMode::radiance);
    REQUIRE(to_next);
    CHECK(to_next->z < 0);
    const auto sample = bsdf.sample(to_prev, 0.01, {0.3, 0.6}, TransportMode::radiance);
    REQUIRE(sample);
    CHECK(sample->to_next.z < 0);
  }
}

/// Squares across the z axis at these heights, with this opacity, over a lambertian floor.
BvhScene<float> stack(const std::vector<double>& heights, const Texture<float>::Handle& opacity) {
  SceneBuilder<float> builder;
  const auto floor = builder.add_material(make_diffuse<float>({0.5, 0.5, 0.5}));
  MaterialTextures<float> textures;
  textures.opacity = opacity;
  const auto cut = builder.add_material(with_textures(make_diffuse<float>({0.2, 0.2, 0.2}), textures));
  const auto add = [&](double z, std::size_t material) {
    const std::array<glm::dvec3, 4> positions{{{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}}};
    const std::array<std::array<int, 3>, 2> triangles{{{0, 1, 2}, {0, 2, 3}}};
    const std::array<glm::dvec2, 4> uv{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    builder.add_mesh({positions, triangles, {}, uv}, material);
  };
  add(-5, floor);
  for (const double z : heights) add(z, cut);
  builder.add_sphere({0, 0, 3}, 0.5, cut);
  builder.add_point_light({0, 0, 9}, {1, 1, 1});
  builder.set_camera(look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 40, {16, 16}));
  return builder.build();
}

}  // namespace

TEST_CASE("a surface with an opacity is there in that share of its points, the same for every ray to them") {
  std::mt19937_64 random(gmis_test::seed(317));
  std::uniform_real_distribution<float> place(-0.9F, 0.9F);
  const auto scene = stack({1, 2}, Texture<float>::constant(glm::dvec3(0.3)));
  constexpr int count = 50'000;
  int none = 0, first = 0, blocked = 0, differs = 0;
  for (int i = 0; i < count; ++i) {
    const float x = place(random), y = place(random);
    const Ray<float> up{{x, y, 0}, {0, 0, 1}, 2.5F};
    const auto hit = scene.intersect(up);
    none += !hit;
    first += hit && hit->point.position.z < 1.5F;
    CHECK(scene.visible(up) == !hit);
    // Straight through the same points from the other side.
    const Ray<float> down{{x, y, 2.5F}, {0, 0, -1}, 2.5F};
    const auto back = scene.intersect(down);
    differs += back.has_value() != hit.has_value();
    if (!back || !hit) continue;
    const Ray<float> between{{x, y, 0}, {0, 0, 1}, hit->point.position.z * 0.999F};
    CHECK(scene.visible(between));
    const Ray<float> slanted{{0, 0, 0}, glm::normalize(glm::vec3(x, y, 2)), 5};
    blocked += scene.visible(slanted) == scene.intersect(slanted).has_value();
  }
  const auto is_share = [&](int found, double share) {
    return std::abs(found / double(count) - share) < 6.1 * std::sqrt(share * (1 - share) / count);
  };
  CHECK(is_share(none, 0.49));
  CHECK(is_share(first, 0.3));
  CHECK(blocked == 0);
  // Rounding moves a point across the border of a cell of 2 to 4 errors, if at all; opacity differs
  // then by chance.
  CHECK(differs < count / 200);
}

TEST_CASE("a hundredth of the width of a surface with an opacity has that share of its points") {
  std::mt19937_64 random(gmis_test::seed(319));
  std::uniform_real_distribution<float> place(-0.9F, 0.9F), aside(0, 0.02F);
  const auto scene = stack({1}, Texture<float>::constant(glm::dvec3(0.3)));
  constexpr int patches = 20, count = 2000;
  // Family-wise rate 1e-6 over 20 patches, by the normal distribution: 5.5 standard deviations.
  // Cells of a tenth of a patch would add twenty times the variance of the draws.
  const double limit = 5.5 * std::sqrt(0.3 * 0.7 / count);
  for (int patch = 0; patch < patches; ++patch) {
    const float x = place(random), y = place(random);
    int found = 0;
    for (int i = 0; i < count; ++i)
      found += scene.intersect(Ray<float>{{x + aside(random), y + aside(random), 0}, {0, 0, 1}, 1.5F}).has_value();
    CHECK(std::abs(found / double(count) - 0.3) < limit);
  }
}

TEST_CASE("with opacity 0 there is no surface at all, and with opacity 1 all of it") {
  const auto nothing = stack({1, 2}, Texture<float>::constant(glm::dvec3(0)));
  const auto all = stack({1, 2}, Texture<float>::constant(glm::dvec3(1)));
  const auto board =
      stack({1, 2}, Texture<float>::checkerboard(Texture<float>::constant(glm::dvec3(0)),
                                                 Texture<float>::constant(glm::dvec3(1)), {{4, 4}, {0, 0}}));
  std::mt19937_64 random(gmis_test::seed(318));
  std::uniform_real_distribution<float> place(-0.9F, 0.9F);
  for (int i = 0; i < 2000; ++i) {
    const Ray<float> up{{place(random), place(random), 0}, {0, 0, 1}};
    CHECK_FALSE(nothing.intersect(up));
    CHECK(nothing.visible(up));
    const auto hit = all.intersect(up);
    REQUIRE(hit);
    CHECK(std::abs(hit->point.position.z - 1) < 1e-6F);
    const auto squares = board.intersect(up);
    const bool is_there =
        (static_cast<int>(std::floor((up.origin.x + 1) * 2)) + static_cast<int>(std::floor((up.origin.y + 1) * 2))) %
            2 !=
        0;
    CHECK((squares && std::abs(squares->point.position.z - 1) < 1e-6F) == is_there);
  }
}

TEST_CASE("a light cannot be cut, and textures need what they replace") {
  SceneBuilder<float> builder;
  MaterialTextures<float> textures;
  textures.opacity = Texture<float>::constant(glm::dvec3(0.5));
  const auto cut = builder.add_material(with_textures(make_diffuse<float>({1, 1, 1}), textures));
  CHECK_THROWS_AS(builder.add_sphere({0, 0, 0}, 1, cut, AreaEmission{}), std::invalid_argument);
  CHECK_THROWS_AS(with_textures(make_coated_conductor<double>({1, 1, 1}, {1, 1, 1}, 0.1, 1.5, 0.1), colored<double>()),
                  std::invalid_argument);
  CHECK_THROWS_AS(with_textures(make_diffuse<double>({1, 1, 1}), roughened<double>(true)), std::invalid_argument);
}
