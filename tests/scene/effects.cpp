#include "gmis/core/effects.hpp"

#include <cmath>

#include "gmis/core/random.hpp"
#include "gmis/scene/scene_builder.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"

// What the built-in scene says of itself, surface by surface and light by light.

using namespace gmis::scene;
using gmis::Effects;

namespace {

SceneBuilder<> builder_with_camera(double lens_radius = 0) {
  SceneBuilder<> builder;
  CameraDescription camera = look_at({0, 0, -5}, {0, 0, 0}, {0, 1, 0}, 40, {4, 4});
  camera.lens_radius = lens_radius;
  builder.set_camera(camera);
  return builder;
}

Effects effects_of_material(const Material<float>& material) {
  SceneBuilder<> builder = builder_with_camera();
  builder.add_sphere({0, 0, 0}, 1, builder.add_material(material));
  return builder.build().effects();
}

Effects diffuse() {
  Effects effects;
  effects.diffuse = true;
  return effects;
}

Effects glossy(double roughness, bool has_diffuse) {
  Effects effects;
  effects.add_glossy_lobe(static_cast<double>(static_cast<float>(roughness)));
  (has_diffuse ? effects.diffuse : effects.purely_glossy) = true;
  return effects;
}

Effects specular(bool transmits, bool has_diffuse = false) {
  Effects effects;
  effects.specular_reflection = true;
  effects.specular_transmission = transmits;
  effects.diffuse = has_diffuse;
  return effects;
}

}  // namespace

TEST_CASE("every material's effects") {
  CHECK(effects_of_material(make_diffuse({.5, .5, .5})) == diffuse());
  CHECK(effects_of_material(make_diffuse({0, 0, 0})) == Effects());
  CHECK(effects_of_material(make_mirror({.9, .9, .9})) == specular(false));
  CHECK(effects_of_material(make_mirror({0, 0, 0})) == Effects());
  CHECK(effects_of_material(make_dielectric(1.5)) == specular(true));
  CHECK(effects_of_material(make_dielectric(1.5, .3)) == glossy(.3, false));
  CHECK(effects_of_material(make_conductor({.2, .9, 1}, {4, 2, 2}, 0)) == specular(false));
  CHECK(effects_of_material(make_conductor({.2, .9, 1}, {4, 2, 2}, .2)) == glossy(.2, false));
  CHECK(effects_of_material(make_coated_diffuse({.5, .5, .5}, 1.5, 0)) == specular(false, true));
  CHECK(effects_of_material(make_coated_diffuse({0, 0, 0}, 1.5, 0)) == specular(false));
  CHECK(effects_of_material(make_coated_diffuse({.5, .5, .5}, 1.5, .1)) == glossy(.1, true));
  CHECK(effects_of_material(make_coated_diffuse({0, 0, 0}, 1.5, .1)) == glossy(.1, false));

  const Effects phong = effects_of_material(make_phong({.3, .3, .3}, {.4, .4, .4}, 98));
  CHECK(phong.diffuse);
  CHECK_FALSE(phong.purely_glossy);
  CHECK(phong.least_roughness == Approx(std::sqrt(2.0 / 100.0)));
  CHECK(effects_of_material(make_phong({0, 0, 0}, {.4, .4, .4}, 98)).purely_glossy);
}

TEST_CASE("a lobe of roughness 1e-4 is a mirror, and said to be one") {
  CHECK(effects_of_material(make_conductor({.2, .9, 1}, {4, 2, 2}, 1e-4)) == specular(false));
  CHECK(effects_of_material(make_dielectric(1.5, 1e-4)) == specular(true));
  CHECK(effects_of_material(make_coated_diffuse({.5, .5, .5}, 1.5, 1e-4)) == specular(false, true));
}

TEST_CASE("what a surface is called is what its delta lobes are") {
  // The class of a path depends on this: what the BSDF draws must be what the scene said.
  for (const Material<float>& material :
       {make_diffuse({.5, .5, .5}), make_phong({.3, .3, .3}, {.4, .4, .4}, 29.0),
        make_phong({.3, .3, .3}, {.4, .4, .4}, 31.0), make_phong({0, 0, 0}, {.4, .4, .4}, 30.0),
        make_mirror({.9, .9, .9}), make_dielectric(1.5), make_dielectric(1.5, .3),
        make_conductor({.2, .9, 1}, {4, 2, 2}, .2), make_coated_diffuse({.5, .5, .5}, 1.5, 0),
        make_coated_diffuse({0, 0, 0}, 1.5, 0), make_coated_diffuse({.5, .5, .5}, 1.5, .2),
        make_coated_diffuse({0, 0, 0}, 1.5, .2)}) {
    const Effects effects = effects_of_material(material);
    const SurfaceBsdf<float> bsdf(material, {0, 0, 1}, {0, 0, 1});
    CHECK(bsdf.is_glossy() == effects.purely_glossy);
    CHECK(bsdf.has_narrow_lobe() == effects.has_narrow_lobes());
    CHECK(bsdf.is_purely_delta() == !effects.has_scattering());
    gmis::Philox source(gmis_test::seed(7));
    const glm::vec3 to_prev = glm::normalize(glm::vec3(.3F, .2F, .8F));
    bool reflects = false, transmits = false;
    for (int i = 0; i < 1000; ++i) {
      const float u = gmis::uniform<float>(source);
      const glm::vec2 uv(gmis::uniform<float>(source), gmis::uniform<float>(source));
      const auto sample = bsdf.sample(to_prev, u, uv, gmis::TransportMode::radiance);
      if (sample && sample->is_delta) (sample->to_next.z > 0 ? reflects : transmits) = true;
    }
    CHECK(reflects == effects.specular_reflection);
    CHECK(transmits == effects.specular_transmission);
  }
}

TEST_CASE("roughness is the range of all lobes; what no shape uses does not count") {
  SceneBuilder<> builder = builder_with_camera();
  builder.add_sphere({0, 0, 0}, 1, builder.add_material(make_conductor({.2, .9, 1}, {4, 2, 2}, .5)));
  builder.add_sphere({3, 0, 0}, 1, builder.add_material(make_coated_diffuse({.5, .5, .5}, 1.5, .125)));
  builder.add_sphere({6, 0, 0}, 1, builder.add_material(make_conductor({.2, .9, 1}, {4, 2, 2}, .25)));
  builder.add_material(make_dielectric(1.5));
  // A triangle without area is left out, and its mirror with it.
  const glm::dvec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const std::array<int, 3> triangles[] = {{0, 1, 2}};
  builder.add_mesh({corners, triangles}, builder.add_material(make_mirror({.9, .9, .9})));
  const Effects effects = builder.build().effects();
  CHECK(effects.glossy);
  CHECK(effects.purely_glossy);
  CHECK(effects.diffuse);
  CHECK(effects.least_roughness == Approx(.125));
  CHECK(effects.greatest_roughness == Approx(.5));
  CHECK_FALSE(effects.has_specular());
}

TEST_CASE("lights that shine, by kind") {
  const auto with = [](auto&& add) {
    SceneBuilder<> builder = builder_with_camera();
    add(builder);
    return builder.build().effects();
  };
  Effects expected;
  expected.point_lights = true;
  CHECK(with([](auto& b) { b.add_point_light({0, 3, 0}, {1, 1, 1}); }) == expected);
  CHECK(with([](auto& b) { b.add_point_light({0, 3, 0}, {0, 0, 0}); }) == Effects());
  expected = {};
  expected.spot_lights = true;
  CHECK(with([](auto& b) { b.add_spot_light({0, 3, 0}, {0, -1, 0}, {1, 1, 1}, .2, .4); }) == expected);
  expected = {};
  expected.directional_lights = true;
  CHECK(with([](auto& b) { b.add_directional_light({0, 1, 0}, {1, 1, 1}); }) == expected);
  expected = {};
  expected.environment_lights = true;
  CHECK(with([](auto& b) { b.add_environment({1, 1, 1}); }) == expected);
  CHECK(with([](auto& b) { b.add_environment(glm::dvec3(0)); }) == Effects());
  expected = {};
  expected.area_lights = true;
  const auto black_ball = [](const glm::dvec3& radiance) {
    return [radiance](auto& b) {
      b.add_sphere({0, 3, 0}, 1, b.add_material(make_diffuse({0, 0, 0})), AreaEmission{radiance, false});
    };
  };
  CHECK(with(black_ball({1, 1, 1})) == expected);
  CHECK(with(black_ball({0, 0, 0})) == Effects());
}

TEST_CASE("a lens, and normals for shading") {
  Effects expected;
  expected.thin_lens = true;
  CHECK(builder_with_camera(.1).build().effects() == expected);
  SceneBuilder<> builder = builder_with_camera();
  const glm::dvec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const glm::dvec3 normals[] = {{0, 0, 1}, {.1, 0, 1}, {0, 0, 1}};
  const std::array<int, 3> triangles[] = {{0, 1, 2}};
  builder.add_mesh({corners, triangles, normals}, builder.add_material(make_diffuse({.5, .5, .5})));
  builder.add_mesh({corners, triangles}, builder.add_material(make_diffuse({.5, .5, .5})));
  expected = diffuse();
  expected.shading_normals = true;
  CHECK(builder.build().effects() == expected);
}

TEST_CASE("a scene that says nothing may have everything") {
  const gmis_test::FurnaceScene<float> furnace(.5F, 1.0F, 4);
  static_assert(!gmis::SceneWithEffects<gmis_test::FurnaceScene<float>>);
  CHECK(gmis::effects_of(furnace) == Effects::everything());
  const Effects all = Effects::everything();
  for (const bool effect : {all.diffuse, all.glossy, all.purely_glossy, all.specular_reflection,
                            all.specular_transmission, all.shading_normals, all.area_lights, all.point_lights,
                            all.spot_lights, all.directional_lights, all.environment_lights, all.thin_lens})
    CHECK(effect);
  CHECK(all.least_roughness == 0);
  CHECK(all.greatest_roughness == 1);
  const BvhScene<> scene = builder_with_camera().build();
  CHECK(gmis::effects_of(scene) == scene.effects());
}
