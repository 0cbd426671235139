#include "support/gltf/reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "program/read_scene.hpp"
#include "program/scratch_folder.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// glTF as it is read; features.cpp renders it.

using namespace gmis::tools;
using gmis_test::Read;
using gmis_test::ScratchFolder;
using gmis_test::text_of;
using Json = nlohmann::json;
namespace fs = std::filesystem;

namespace {

const fs::path features = GMIS_FEATURE_FOLDER;

/// A folder with the images that the scenes below name.
struct Scratch : ScratchFolder {
  Scratch() {
    for (const char* name : {"colors.png", "tilted.png", "cutout.png"}) fs::copy_file(features / name, path / name);
  }
};

Read read_file(const fs::path& file, Strictness strictness = Strictness::strict) {
  return gmis_test::reading(strictness, [&](Diagnostics& diagnostics) { return read_gltf_scene(file, diagnostics); });
}

/// metal.gltf, changed.
Read read_changed(const std::function<void(Json&)>& change, Strictness strictness = Strictness::strict) {
  const Scratch folder;
  Json json = Json::parse(text_of(features / "metal.gltf"));
  change(json);
  std::ofstream(folder.path / "a.gltf") << json;
  return read_file(folder.path / "a.gltf", strictness);
}

const MeshDescription& mesh(const Read& result) {
  return std::get<MeshDescription>(result.scene.shapes.at(0).geometry);
}

bool near(const glm::dvec3& a, const glm::dvec3& b) {
  return glm::length(a - b) < 1e-6 * (1 + glm::length(b));
}

}  // namespace

TEST_CASE("A mesh, its coordinates, its node and the camera") {
  const Read result = read_changed([](Json& json) {
    json["nodes"][0]["rotation"] = {0, 0, std::sqrt(.5), std::sqrt(.5)};  // a quarter turn about z
    json["nodes"][0]["scale"] = {1, 2, 1};
    json["nodes"][0]["translation"] = {0, 0, -3};
    json["cameras"][0] = {{"type", "perspective"},
                          {"perspective", {{"yfov", 0.8}, {"aspectRatio", 0.5}, {"znear", 0.1}}}};
  });
  CAPTURE(result.error);
  REQUIRE(result.scene.shapes.size() == 1);
  CHECK(near(mesh(result).positions.at(0), {2, -1, -3}));
  CHECK(near(mesh(result).positions.at(2), {-2, 1, -3}));
  CHECK(mesh(result).triangles.size() == 2);
  CHECK(mesh(result).uv.at(0) == glm::dvec2(0, 0));
  CHECK(mesh(result).uv.at(2) == glm::dvec2(1, 1));
  const glm::dmat4& m = result.scene.camera.world_from_camera;
  CHECK(near(glm::dvec3(m[3]), {0, 0, 5}));
  CHECK(near(glm::dvec3(m[2]), {0, 0, -1}));
  CHECK(near(glm::dvec3(m[0]), {1, 0, 0}));
  CHECK(result.scene.film.width == result.scene.film.height / 2);
  CHECK(std::tan(result.scene.camera.field_of_view * 3.14159265358979 / 360) == Approx(std::tan(0.4) / 2));
  CHECK(result.says("a white sky"));
  const Read parented = read_changed([](Json& json) {
    json["nodes"].push_back({{"children", {0}}, {"translation", {1, 0, 0}}});
    json["scenes"][0]["nodes"] = {1, 2};
  });
  CHECK(near(mesh(parented).positions.at(0), {0, -1, 0}));
}

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
      {{"pbrMetallicRoughness", {{"roughnessFactor", 0}}},
       {"extensions",
        {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}, {"KHR_materials_ior", {{"ior", 1.33}}}}}});
  CHECK(std::get<DielectricDescription>(kind(glass).kind).eta == Approx(1.33));
  const Read light = read_file(features / "glow.gltf");
  REQUIRE(light.scene.shapes.at(0).emission);
  CHECK(near(light.scene.shapes[0].emission->radiance, {.5, 1, 2}));
  CHECK_FALSE(light.says("a white sky"));
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
          {"pbrMetallicRoughness", {{"roughnessFactor", 0}}},
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

TEST_CASE("Punctual lights are where their nodes are, and point along -z") {
  const Read result = read_changed([](Json& json) {
    json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "directional"}, {"intensity", 2}, {"color", {1, .5, 0}}},
        {{"type", "point"}, {"intensity", 3}},
        {{"type", "spot"}, {"intensity", 4}, {"spot", {{"innerConeAngle", .2}, {"outerConeAngle", .5}}}}};
    for (int i = 0; i < 3; ++i) {
      json["nodes"].push_back({{"translation", {0, 7, 0}},
                               {"rotation", {-std::sqrt(.5), 0, 0, std::sqrt(.5)}},
                               {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
      json["scenes"][0]["nodes"].push_back(2 + i);
    }
  });
  CAPTURE(result.error);
  REQUIRE(result.scene.lights.size() == 3);
  const auto& sun = std::get<DistantLightDescription>(result.scene.lights[0].kind);
  CHECK(near(sun.to_light, {0, 1, 0}));
  CHECK(near(sun.irradiance, {2, 1, 0}));
  CHECK(near(std::get<PointLightDescription>(result.scene.lights[1].kind).position, {0, 7, 0}));
  const auto& spot = std::get<SpotLightDescription>(result.scene.lights[2].kind);
  CHECK(near(spot.direction, {0, -1, 0}));
  CHECK(spot.inner == Approx(.2));
  CHECK(spot.outer == Approx(.5));
}

TEST_CASE("What glTF has and this does not is said") {
  const auto error = [](const std::function<void(Json&)>& change) {
    const Read strict = read_changed(change);
    CHECK(read_changed(change, Strictness::lenient).error.empty());
    return strict.error;
  };
  CHECK(error([](Json& j) {
          j["meshes"][0]["primitives"].push_back(j["meshes"][0]["primitives"][0]);
          j["meshes"][0]["primitives"][1]["mode"] = 1;
        }).find("lines") != std::string::npos);
  CHECK(error([](Json& j) {
          j["materials"][0]["extensions"]["KHR_materials_clearcoat"]["clearcoatFactor"] = 1;
        }).find("clearcoat") != std::string::npos);
  CHECK(error([](Json& j) {
          j["extensionsRequired"] = {"EXT_something"};
          j["extensionsUsed"] = {"EXT_something"};
        }).find("EXT_something") != std::string::npos);
  CHECK(error([](Json& j) { j["meshes"][0]["weights"] = {1.0}; }).find("morph") != std::string::npos);
}

TEST_CASE("Files that are missing are named") {
  const auto error = [](const std::function<void(Json&)>& change) { return read_changed(change).error; };
  CHECK(error([](Json& j) {
          j["images"] = {{{"uri", "nowhere.png"}}};
          j["textures"] = {{{"source", 0}}};
          j["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
        }).find("the image \"nowhere.png\" is missing") != std::string::npos);
  CHECK(error([](Json& j) { j["buffers"][0]["uri"] = "nowhere.bin"; }).find("nowhere.bin") != std::string::npos);
}

TEST_CASE("Files that are damaged are refused in one line, or read") {
  CHECK(read_changed([](Json& j) { j["accessors"][0]["count"] = 5; }).error.find("beyond the end") !=
        std::string::npos);
  CHECK(read_changed([](Json& j) {
          j["accessors"][2]["componentType"] = 5121;
          j["accessors"][2]["count"] = 12;
        }).error.find("vertex") == std::string::npos);
  CHECK_FALSE(read_changed([](Json& j) { j["nodes"][0]["mesh"] = 7; }).error.empty());
  CHECK_FALSE(read_changed([](Json& j) { j["nodes"][0]["children"] = {0}; }).error.empty());
  CHECK_FALSE(read_changed([](Json& j) { j["bufferViews"][0]["byteOffset"] = 1000000; }).error.empty());
  const Scratch folder;
  std::mt19937 random(static_cast<std::mt19937::result_type>(gmis_test::seed(331)));
  const std::string whole = text_of(features / "metal_texture.gltf");
  for (int i = 0; i < 300; ++i) {
    std::string broken = whole;
    if (i % 3 == 0) broken.resize(random() % whole.size());
    if (i % 3 != 0)
      for (int k = 0; k < 2; ++k) broken[random() % broken.size()] = "0123456789,-{}[]\"a"[random() % 18];
    std::ofstream(folder.path / "b.gltf", std::ios::binary | std::ios::trunc) << broken;
    const Read result = read_file(folder.path / "b.gltf");
    CHECK(result.error.find('\n') == std::string::npos);
    if (result.error.empty()) CHECK_FALSE(result.scene.shapes.empty());
  }
}
