#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <string>

#include "program/gltf_files.hpp"
#include "support/catch.hpp"

// The materials of glTF as they are read; features.cpp renders some.

using namespace gmis_test;

TEST_CASE("Metallic-roughness, glass, emission and alpha as materials") {
  const auto material = [](const Json& description) {
    return read_changed([&](Json& json) {
      json["materials"][0] = description;
      json["images"] = {{{"uri", "colors.png"}}, {{"uri", "tilted.png"}}};
      json["textures"] = {{{"source", 0}}, {{"source", 1}}};
    });
  };
  const auto kind = [](const Read& result) { return result.scene.materials.at(result.scene.shapes.at(0).material); };
  const Read diffuse =
      material({{"pbrMetallicRoughness",
                 {{"metallicFactor", 0}, {"roughnessFactor", 0.5}, {"baseColorTexture", {{"index", 0}}}}},
                {"normalTexture", {{"index", 1}}}});
  CAPTURE(diffuse.error);
  CHECK(std::get<CoatedDiffuseDescription>(kind(diffuse).kind).alpha == Approx(0.25));
  CHECK(kind(diffuse).textures.color);
  CHECK(kind(diffuse).textures.normal_map);
  CHECK(diffuse.says("metallic-roughness becomes"));
  const Read mixed = material({{"pbrMetallicRoughness", {{"metallicFactor", 0.25}}}});
  CHECK(std::get<MixDescription>(kind(mixed).kind).amount->mean().x == Approx(0.25));
  const Read layers = material({{"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", 0}}}}}});
  CHECK(std::get<MixDescription>(kind(layers).kind).amount->mean().x == Approx(128 / 255.0));
  // The square of the green channel: 20/255 to 200/255.
  const auto part = layers.scene.materials.at(std::get<MixDescription>(kind(layers).kind).second);
  CHECK(double(part.textures.roughness->upper().x) == Approx(std::pow(200 / 255.0, 2)));
  const Read glass = material(
      {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
       {"extensions",
        {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}, {"KHR_materials_ior", {{"ior", 1.33}}}}}});
  CHECK(std::get<DielectricDescription>(kind(glass).kind).eta == Approx(1.33));
  const Read light = read_file(features / "glow.gltf");
  REQUIRE(light.scene.shapes.at(0).emission);
  CHECK(near(light.scene.shapes[0].emission->radiance, {.5, 1, 2}));
  CHECK(light.says("the sky \"studio\" is added"));  // a material that shines is no reason to be in the dark
  const Read blend =
      material({{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.25}}}}});
  REQUIRE(blend.scene.shapes.at(0).opacity);
  CHECK(blend.scene.shapes[0].opacity->mean().x == Approx(0.25));
  const Read mask = material({{"alphaMode", "MASK"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.25}}}}});
  CHECK(mask.scene.shapes.at(0).opacity->mean().x == 0.0);
}

TEST_CASE("A volume absorbs by its colour and distance, a thin wall nothing") {
  const auto glass = [](const Json& volume, double transmission = 1) {
    return read_changed([&](Json& json) {
      json["materials"][0] = {
          {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
          {"extensions",
           {{"KHR_materials_transmission", {{"transmissionFactor", transmission}}}, {"KHR_materials_volume", volume}}}};
    });
  };
  const Read tinted = glass({{"thicknessFactor", 1}, {"attenuationDistance", 2}, {"attenuationColor", {0.25, 1, 0}}});
  CAPTURE(tinted.error);
  REQUIRE(tinted.scene.shapes.at(0).absorption);
  const Rgb sigma = tinted.scene.shapes[0].absorption->inside;
  CHECK(std::exp(-2 * sigma.x) == Approx(0.25));
  CHECK(sigma.y == 0);
  CHECK(std::exp(-2 * sigma.z) < 1e-11);
  CHECK_FALSE(glass({{"attenuationDistance", 2}, {"attenuationColor", {0.25, 1, 0}}}).scene.shapes.at(0).absorption);
  CHECK_FALSE(glass({{"thicknessFactor", 1}, {"attenuationColor", {0.25, 1, 0}}}).scene.shapes.at(0).absorption);
  CHECK(glass({{"thicknessFactor", 1}, {"attenuationDistance", 2}, {"attenuationColor", {0.25, 1, 0}}}, 0.5)
            .error.find("a volume behind") != std::string::npos);
}

TEST_CASE("Specular-glossiness, unlit, coloured glass, a coat and a texture of emission") {
  const auto material = [](const Json& description) {
    return read_changed([&](Json& json) {
      add_image(json);
      json["materials"][0] = description;
    });
  };
  const auto kind = [](const Read& result) {
    return result.scene.materials.at(result.scene.shapes.at(0).material).kind;
  };
  const auto extended = [](const char* name, const Json& value) { return Json{{"extensions", {{name, value}}}}; };
  // No specular: all of it diffuse. Specular as of a metal: all of it metal.
  const Read plastic = material(extended(
      "KHR_materials_pbrSpecularGlossiness",
      {{"diffuseFactor", {0.5, 0.25, 0, 1}}, {"specularFactor", {0.04, 0.04, 0.04}}, {"glossinessFactor", 0.5}}));
  CAPTURE(plastic.error);
  const auto coated = std::get<CoatedDiffuseDescription>(kind(plastic));
  CHECK(near(coated.reflectance, {0.5, 0.25, 0}));
  CHECK(coated.alpha == Approx(0.25));
  const Read gold = material(extended("KHR_materials_pbrSpecularGlossiness",
                                      {{"diffuseFactor", {0, 0, 0, 1}}, {"specularFactor", {1, 0.7, 0.3}}}));
  const auto metal = std::get<ConductorDescription>(kind(gold));
  for (int c = 0; c < 3; ++c) {
    const double k2 = metal.k[c] * metal.k[c];
    CHECK(k2 / (4 + k2) == Approx(std::min(Rgb(1, 0.7, 0.3)[c], 0.9999)));  // head on, with eta 1
  }
  const Read flat = material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                              {"extensions", {{"KHR_materials_unlit", Json::object()}}}});
  REQUIRE(flat.scene.shapes.at(0).emission);
  CHECK(flat.scene.shapes[0].emission->texture);
  CHECK(std::get<DiffuseDescription>(kind(flat)).reflectance == Rgb(0));
  const Read glass =
      material({{"pbrMetallicRoughness",
                 {{"baseColorFactor", {0.2, 0.9, 0.4, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0}}},
                {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}}});
  CHECK(std::get<DielectricDescription>(kind(glass)).tint == Rgb(0.2, 0.9, 0.4));
  const Read coat = material(
      {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
       {"extensions", {{"KHR_materials_clearcoat", {{"clearcoatFactor", 1}, {"clearcoatRoughnessFactor", 0.5}}}}}});
  CHECK(std::get<CoatedDiffuseDescription>(kind(coat)).alpha == Approx(0.25));
  const Read screen = material({{"emissiveFactor", {1, 2, 0.5}}, {"emissiveTexture", {{"index", 0}}}});
  REQUIRE(screen.scene.shapes.at(0).emission);
  CHECK(screen.scene.shapes[0].emission->texture);
  CHECK(screen.scene.shapes[0].emission->radiance == Rgb(1, 2, 0.5));
}

namespace {

/// The square with this material, whose colors.png is texture 0.
Read read_material(const Json& description, Strictness strictness = Strictness::strict) {
  return read_changed(
      [&](Json& json) {
        add_image(json);
        json["materials"][0] = description;
      },
      strictness);
}

std::size_t material_of(const Read& result) {
  return result.scene.shapes.at(0).material;
}
template <class Description>
Description only(const Read& result) {
  return std::get<Description>(result.scene.materials.at(material_of(result)).kind);
}

/// The share of the points that have this description, where all mixtures are as at `uv`.
template <class Description>
double share_of(const Read& result, std::size_t material, const glm::vec2& uv) {
  const auto& kind = result.scene.materials.at(material).kind;
  if (const auto* mix = std::get_if<MixDescription>(&kind)) {
    const double second = double(mix->amount->at(uv).x);
    return (1 - second) * share_of<Description>(result, mix->first, uv) +
           second * share_of<Description>(result, mix->second, uv);
  }
  return std::holds_alternative<Description>(kind) ? 1 : 0;
}

/// Glass with a metalness, without roughness or thickness.
Json glass(const Json& metallic, const Json& transmission) {
  Json model = metallic;
  model["roughnessFactor"] = 0;
  return {{"pbrMetallicRoughness", model}, {"extensions", {{"KHR_materials_transmission", transmission}}}};
}

/// The reflectance of a coat head on.
Rgb head_on(const CoatedDiffuseDescription& coated) {
  return std::pow((coated.eta - 1) / (coated.eta + 1), 2) * coated.specular;
}

}  // namespace

TEST_CASE("The share of glass is transmission (1 - metalness), that of metal the metalness") {
  const auto check = [](const Json& metallic, const Json& transmission,
                        const std::function<double(const glm::vec2&)>& metalness,
                        const std::function<double(const glm::vec2&)>& transmitted) {
    const Read result = read_material(glass(metallic, transmission));
    CAPTURE(metallic, transmission, result.error);
    REQUIRE(result.error.empty());
    for (const glm::vec2 uv : {glm::vec2(0.125F), glm::vec2(0.375F, 0.625F), glm::vec2(0.875F, 0.125F)}) {
      const double m = metalness(uv), t = transmitted(uv);
      CHECK(share_of<DielectricDescription>(result, material_of(result), uv) == Approx(t * (1 - m)));
      CHECK(share_of<ConductorDescription>(result, material_of(result), uv) == Approx(m));
      CHECK(share_of<CoatedDiffuseDescription>(result, material_of(result), uv) == Approx((1 - t) * (1 - m)));
    }
  };
  const auto always = [](double value) { return [value](const glm::vec2&) { return value; }; };
  // colors.png has 60 · column + 20 in its red channel, and 128 in its blue one.
  const auto red = [](const glm::vec2& uv) { return (60 * std::floor(uv.x * 4) + 20) / 255.0; };
  const Json metal_texture = {{"metallicFactor", 0.5}, {"metallicRoughnessTexture", {{"index", 0}}}};
  const Json clear_texture = {{"transmissionFactor", 0.75}, {"transmissionTexture", {{"index", 0}}}};
  for (const double m : {0.0, 0.25, 1.0})
    for (const double t : {0.0, 0.75, 1.0})
      check({{"metallicFactor", m}}, {{"transmissionFactor", t}}, always(m), always(t));
  check({{"metallicFactor", 0.25}}, clear_texture, always(0.25), [&](const auto& uv) { return 0.75 * red(uv); });
  check(metal_texture, {{"transmissionFactor", 0.75}}, always(64 / 255.0), always(0.75));
  check(metal_texture, clear_texture, always(64 / 255.0), [&](const auto& uv) { return 0.75 * red(uv); });
}

TEST_CASE("Glass without a thickness is a pane, which is smooth") {
  const auto read = [](const Json& model, const Json& extensions, Strictness strictness = Strictness::strict) {
    Json material = glass({{"metallicFactor", 0}}, {{"transmissionFactor", 1}});
    material["pbrMetallicRoughness"].update(model);
    material["extensions"].update(extensions);
    return read_material(material, strictness);
  };
  const auto volume = [](double thickness) { return Json{{"KHR_materials_volume", {{"thicknessFactor", thickness}}}}; };
  const Json none = Json::object(), rough = {{"roughnessFactor", 0.5}},
             faint = {{"roughnessFactor", 0.03}},  // alpha 0.0009
      texture = {{"roughnessFactor", 1}, {"metallicRoughnessTexture", {{"index", 0}}}};
  CHECK(only<DielectricDescription>(read(none, none)).is_thin);
  CHECK(only<DielectricDescription>(read(none, volume(0))).is_thin);
  CHECK_FALSE(only<DielectricDescription>(read(none, volume(0.1))).is_thin);
  CHECK(only<DielectricDescription>(read(rough, volume(0.1))).alpha == Approx(0.25));
  CHECK(read(faint, none).error.empty());
  for (const Json& model : {rough, texture}) {
    CHECK_THAT(read(model, none).error, Catch::Contains("rough glass without a thickness"));
    const Read smooth = read(model, none, Strictness::lenient);
    CHECK(smooth.says("rough glass without a thickness"));
    CHECK(only<DielectricDescription>(smooth).is_thin);
    CHECK(only<DielectricDescription>(smooth).alpha == 0);
    CHECK_FALSE(smooth.scene.materials.at(material_of(smooth)).textures.roughness);
  }
}

TEST_CASE("KHR_materials_specular scales what the base reflects, above 1 too, but no clear coat") {
  const auto read = [](const Json& specular, double ior, double coat) {
    return only<CoatedDiffuseDescription>(
        read_material({{"pbrMetallicRoughness", {{"metallicFactor", 0}}},
                       {"extensions",
                        {{"KHR_materials_specular", specular},
                         {"KHR_materials_ior", {{"ior", ior}}},
                         {"KHR_materials_clearcoat", {{"clearcoatFactor", coat}}}}}}));
  };
  // min(F color, 1) · factor, F = 0.04 of the index 1.5, and 1/9 of the index 2.
  CHECK(near(head_on(read({{"specularColorFactor", {2, 1, 0.5}}, {"specularFactor", 0.5}}, 1.5, 0)), {.04, .02, .01}));
  CHECK(near(head_on(read({{"specularColorFactor", {2, 1, 0.5}}}, 2, 0)), {2 / 9., 1 / 9., 1 / 18.}));
  CHECK(near(head_on(read({{"specularColorFactor", {1, 0.5, 0}}}, 1.5, 0)), {.04, .02, 0}));
  const Rgb mirror = head_on(read({{"specularColorFactor", {1000, 2, 1}}}, 1.5, 0));
  CHECK(near(mirror, {.98 * .98, .08, .04}));  // the largest index is 99
  CHECK(read({{"specularColorFactor", {2, 1, 1}}}, 1, 0).eta == 1);
  // A coat of the index 1.5 reflects 0.04, whatever the base reflects.
  CHECK(near(head_on(read({{"specularFactor", 0}}, 1.5, 1)), Rgb(.04)));
  CHECK(near(head_on(read({{"specularFactor", 0}}, 2, 1)), Rgb(.04)));
  CHECK(near(head_on(read({{"specularColorFactor", {1, 0, 0}}}, 1.5, 1)), Rgb(.04)));
}

TEST_CASE("What of a clear coat is left out is said") {
  const auto read = [](const Json& coat, double transmission = 0, Strictness strictness = Strictness::strict) {
    return read_material(
        {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
         {"extensions",
          {{"KHR_materials_clearcoat", coat}, {"KHR_materials_transmission", {{"transmissionFactor", transmission}}}}}},
        strictness);
  };
  for (const char* name : {"clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"}) {
    const Json coat = {{"clearcoatFactor", 1}, {name, {{"index", 0}}}}, no_coat = {{name, {{"index", 0}}}};
    CHECK_THAT(read(coat).error, Catch::Contains(std::string(name) + " of KHR_materials_clearcoat"));
    CHECK(only<CoatedDiffuseDescription>(read(coat, 0, Strictness::lenient)).specular == Rgb(1));
    CHECK(read(no_coat).error.empty());
  }
  for (const double transmission : {0.5, 1.0}) {
    CHECK_THAT(read({{"clearcoatFactor", 1}}, transmission).error, Catch::Contains("a clear coat over glass"));
    CHECK(read({{"clearcoatFactor", 0}}, transmission).error.empty());
  }
  CHECK(only<DielectricDescription>(read({{"clearcoatFactor", 1}}, 1, Strictness::lenient)).is_thin);
}
