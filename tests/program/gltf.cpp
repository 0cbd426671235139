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

#include "program/gltf_files.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

#if GMIS_HAS_DRACO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wextra"
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#pragma GCC diagnostic pop
#endif
#if GMIS_HAS_MESHOPT
#include <meshoptimizer.h>
#endif

// glTF as it is read, but for its materials (gltf_materials.cpp); features.cpp renders it.

using namespace gmis_test;

TEST_CASE("A mesh, its coordinates, its node and the camera") {
  const Read result = read_changed([](Json& json) {
    json["nodes"][0]["rotation"] = {0, 0, std::sqrt(.5), std::sqrt(.5)};  // a quarter turn about z
    json["images"] = {{{"uri", "colors.png"}}};
    json["textures"] = {{{"source", 0}}};
    json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
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
  for (const int height : {50, 100, 400}) {  // --size changes nothing about the vertical field of view
    const auto window = picture_window(result.scene.camera, 100, height);
    CHECK(window[3] == Approx(std::tan(0.4)));
    CHECK(window[1] == Approx(std::tan(0.4) * 100 / height));
    CHECK(window[0] == -window[1]);
    CHECK(window[2] == -window[3]);
  }
  CHECK(result.says("the sky \"studio\" is added"));
  const Read parented = read_changed([](Json& json) {
    json["nodes"].push_back({{"children", {0}}, {"translation", {1, 0, 0}}});
    json["scenes"][0]["nodes"] = {1, 2};
  });
  CHECK(near(mesh(parented).positions.at(0), {0, -1, 0}));
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

TEST_CASE("A hidden node hides the meshes and lights below it, but no camera") {
  const auto read = [](bool parent_is_visible, bool child_is_visible) {
    return read_changed([&](Json& json) {
      json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
      json["meshes"].push_back(json["meshes"][0]);
      const auto visible = [](bool is) { return Json{{"KHR_node_visibility", {{"visible", is}}}}; };
      json["nodes"][1]["extensions"] = visible(child_is_visible);  // the camera
      json["nodes"].push_back({{"mesh", 1}, {"extensions", visible(child_is_visible)}});
      json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
      json["nodes"].push_back({{"children", {1, 2, 3}}, {"extensions", visible(parent_is_visible)}});
      json["scenes"][0]["nodes"] = {0, 4};
    });
  };
  const Read all = read(true, true), none = read(false, true), only_the_light = read(true, false);
  CAPTURE(all.error, none.error, only_the_light.error);
  CHECK(all.scene.shapes.size() == 2);
  CHECK(none.scene.shapes.size() == 1);
  CHECK(only_the_light.scene.shapes.size() == 1);
  const auto has_point_light = [](const Read& result) {
    return std::holds_alternative<PointLightDescription>(result.scene.lights.at(0).kind);
  };
  CHECK(has_point_light(all));
  CHECK_FALSE(has_point_light(none));
  CHECK(has_point_light(only_the_light));
  for (const Read* result : {&all, &none, &only_the_light}) {
    CHECK_FALSE(result->says("no camera"));
    CHECK(near(glm::dvec3(result->scene.camera.world_from_camera[3]), {0, 0, 5}));
  }
}

TEST_CASE("What glTF has and this does not is said") {
  const auto error = [](const std::function<void(Json&)>& change) {
    const Read strict = read_changed(change);
    CHECK(read_changed(change, Strictness::lenient).error.empty());
    return strict.error;
  };
  CHECK(error([](Json& j) {
          j["materials"][0]["extensions"]["KHR_materials_sheen"]["sheenColorFactor"] = {1, 0, 0};
        }).find("sheen") != std::string::npos);
  CHECK(read_changed([](Json& j) {
          j["extensionsRequired"] = {"KHR_materials_ior", "KHR_materials_dispersion", "KHR_node_visibility"};
        }).error.empty());
  CHECK(error([](Json& j) {
          j["extensionsRequired"] = {"EXT_something"};
          j["extensionsUsed"] = {"EXT_something"};
        }).find("EXT_something") != std::string::npos);
  // Lines beside triangles are left out; alone they are nothing to render.
  const Read lines = read_changed([](Json& j) {
    j["meshes"][0]["primitives"].push_back(j["meshes"][0]["primitives"][0]);
    j["meshes"][0]["primitives"][1]["mode"] = 1;
  });
  CHECK(lines.error.empty());
  CHECK(lines.says("1 parts of points or lines are left out"));
  CHECK(read_changed([](Json& j) {
          j["meshes"][0]["primitives"][0]["mode"] = 0;
        }).error.find("points and lines alone") != std::string::npos);
}

TEST_CASE("Files that are missing are named") {
  const auto error = [](const std::function<void(Json&)>& change) { return read_changed(change).error; };
  CHECK(error([](Json& j) {
          j["images"] = {{{"uri", "nowhere.png"}}};
          j["textures"] = {{{"source", 0}}};
          j["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
        }).find("nowhere.png\" is missing") != std::string::npos);
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

namespace {

/// The texture of a material's colour.
const gmis::scene::Texture<float>& color_of(const Read& result, std::size_t shape = 0) {
  return *result.scene.materials.at(result.scene.shapes.at(shape).material).textures.color;
}

/// The mean of three corners' values, weighted.
template <class Values>
auto between(const Values& values, const std::array<int, 3>& corners, const glm::dvec3& w) {
  const auto at = [&](std::size_t k) { return values.at(static_cast<std::size_t>(corners[k])); };
  return at(0) * w.x + at(1) * w.y + at(2) * w.z;
}

}  // namespace

TEST_CASE("Colours at vertices are linear over each triangle, with and without a texture") {
  const std::vector<float> colors{1, 0, 0, 1, 0, 1, 0, 0.5F, 0, 0, 1, 1, 0.25F, 0.5F, 0.75F, 0};
  const auto wanted_at = [&](const Point& p, bool is_first) {  // by the corners of the square, from −1 to 1
    const double x = (p.x + 1) / 2, y = (p.y + 1) / 2;
    const auto c = [&](std::size_t i) { return glm::dvec3(colors[4 * i], colors[4 * i + 1], colors[4 * i + 2]); };
    return is_first ? c(0) * (1 - x) + c(1) * (x - y) + c(2) * y : c(0) * (1 - y) + c(2) * x + c(3) * (y - x);
  };
  for (const bool is_textured : {false, true}) {
    const Read result = read_changed([&](Json& json) {
      if (is_textured) add_image(json);
      attributes(json)["COLOR_0"] = add_floats(json, colors, "VEC4", 4);
    });
    CAPTURE(is_textured, result.error);
    REQUIRE(result.scene.shapes.size() == 1);
    const Read plain = read_changed([](Json& json) { add_image(json); });
    const MeshDescription& m = mesh(result);
    REQUIRE(m.triangles.size() == 2);
    std::mt19937 random(static_cast<std::mt19937::result_type>(gmis_test::seed(381)));
    std::uniform_real_distribution<double> uniform(0, 1);
    for (std::size_t k = 0; k < 2; ++k)
      for (int i = 0; i < 200; ++i) {
        double a = uniform(random), b = uniform(random);
        if (a + b > 1) a = 1 - a, b = 1 - b;
        const glm::dvec3 w(1 - a - b, a, b);
        const Point p = between(m.positions, m.triangles[k], w);
        glm::dvec3 wanted = wanted_at(p, k == 0) * (is_textured ? glm::dvec3(1) : glm::dvec3(0.9, 0.6, 0.3));
        if (is_textured) {
          const glm::dvec2 uv = between(mesh(plain).uv, mesh(plain).triangles[k], w);
          const glm::dvec2 in_texels = uv * 4.0;  // nothing is asked of the steepest places
          if (std::abs(in_texels.x - std::round(in_texels.x)) < 1e-3) continue;
          wanted *= glm::dvec3(color_of(plain).at(glm::vec2(uv)));
        }
        const glm::dvec3 found(color_of(result).at(glm::vec2(between(m.uv, m.triangles[k], w))));
        CHECK(glm::length(found - wanted) < 2e-4);
      }
  }
}

TEST_CASE("An unlit surface emits the colours at its vertices, nowhere less than nothing") {
  const std::vector<float> colors{1, 0, 0, 0, 1, 0, 0, 0, 1, 0.25F, 0.5F, 0.75F};
  const Read result = read_changed([&](Json& json) {
    json["materials"][0] = {{"extensions", {{"KHR_materials_unlit", Json::object()}}}};
    attributes(json)["COLOR_0"] = add_floats(json, colors, "VEC3", 3);
  });
  CAPTURE(result.error);
  REQUIRE(result.scene.shapes.size() == 1);
  const auto& emission = result.scene.shapes[0].emission;
  REQUIRE(emission);
  const gmis::scene::Texture<float>& radiance = *emission->texture;
  CHECK(radiance.lower() == glm::vec3(0));
  CHECK(radiance.upper() == glm::vec3(1));
  const int corners[2][3] = {{0, 1, 2}, {0, 2, 3}};
  for (std::size_t k = 0; k < 2; ++k)
    for (int i = 0; i <= 10; ++i)
      for (int j = 0; i + j <= 10; ++j) {
        const glm::dvec3 w(1 - 0.1 * (i + j), 0.1 * i, 0.1 * j);
        glm::dvec3 wanted(0);
        for (int corner = 0; corner < 3; ++corner)
          for (int c = 0; c < 3; ++c)
            wanted[c] += w[corner] * double(colors.at(static_cast<std::size_t>(3 * corners[k][corner] + c)));
        const glm::vec3 found = radiance.at(glm::vec2(between(mesh(result).uv, mesh(result).triangles[k], w)));
        CHECK(glm::length(glm::dvec3(found) - wanted) < 1e-5);
      }
}

TEST_CASE("Two sets of coordinates serve one material, and normal maps keep their tangents") {
  const std::vector<float> second{0, 0, 0.5F, 0, 0.5F, 0.5F, 0, 0.5F};
  const Read result = read_changed([&](Json& json) {
    add_image(json);
    json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
    json["images"].push_back({{"uri", "tilted.png"}});
    json["textures"].push_back({{"source", 1}});
    json["materials"][0]["normalTexture"]["index"] = 1;
    attributes(json)["TEXCOORD_1"] = add_floats(json, second, "VEC2", 2);
  });
  CAPTURE(result.error);
  REQUIRE(result.scene.shapes.size() == 1);
  const MeshDescription& m = mesh(result);
  for (std::size_t k = 0; k < 2; ++k) {
    // ∂p/∂u of the new coordinates lies along that of the normal map's, which is x here.
    const auto& [i, j, l] = m.triangles[k];
    const auto uv = [&](int corner) { return m.uv.at(static_cast<std::size_t>(corner)); };
    const auto p = [&](int corner) { return m.positions.at(static_cast<std::size_t>(corner)); };
    const glm::dvec2 a = uv(j) - uv(i), b = uv(l) - uv(i);
    const glm::dvec3 along = ((p(j) - p(i)) * b.y - (p(l) - p(i)) * a.y) / (a.x * b.y - a.y * b.x);
    CHECK(glm::length(glm::normalize(along) - glm::dvec3(1, 0, 0)) < 1e-9);
  }
  const Read plain = read_changed([](Json& json) { add_image(json); });
  const glm::dvec3 w(0.3, 0.3, 0.4);
  const Point at = between(m.positions, m.triangles[0], w);
  const glm::vec2 uv(static_cast<float>((at.x + 1) / 4), static_cast<float>(1 - (at.y + 1) / 4));
  const glm::vec3 found = color_of(result).at(glm::vec2(between(m.uv, m.triangles[0], w)));
  CHECK(glm::length(found - color_of(plain).at(uv)) < 1e-3F);
}

TEST_CASE("A texture is turned, scaled and moved counter-clockwise as it is seen, and wraps as it says") {
  const auto placed = [](const Json& transform, const Json& sampler) {
    return read_changed([&](Json& json) {
      add_image(json);
      json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] =
          transform;
      json["samplers"] = Json::array({sampler});
      json["textures"][0]["sampler"] = 0;
    });
  };
  const Json repeat{{"wrapS", 10497}, {"wrapT", 10497}};
  const Read plain = placed(Json::object(), repeat);
  const Read turned = placed({{"rotation", 0.5}, {"scale", {2, 0.5}}, {"offset", {0.1, 0.2}}}, repeat);
  CAPTURE(turned.error);
  REQUIRE(turned.scene.shapes.size() == 1);
  std::mt19937 random(static_cast<std::mt19937::result_type>(gmis_test::seed(382)));
  std::uniform_real_distribution<double> uniform(0, 1);
  int compared = 0;
  for (int i = 0; i < 300; ++i) {
    const double s = uniform(random), t = uniform(random), c = std::cos(0.5), n = std::sin(0.5);
    const double s2 = c * 2 * s + n * 0.5 * t + 0.1, t2 = -n * 2 * s + c * 0.5 * t + 0.2;
    const glm::vec3 wanted = color_of(plain).at({static_cast<float>(s2), static_cast<float>(1 - t2)});
    const glm::vec3 found = color_of(turned).at({static_cast<float>(s), static_cast<float>(1 - t)});
    if (glm::length(wanted - found) < 1e-3F) ++compared;
  }
  CHECK(compared >= 295);  // rounding beside an edge of nearest texels
  const Read mirrored = placed(Json::object(), {{"wrapS", 33648}, {"wrapT", 33071}});
  CHECK(glm::length(color_of(mirrored).at({1.2F, 0.3F}) - color_of(mirrored).at({0.8F, 0.3F})) < 1e-4F);
  CHECK(glm::length(color_of(mirrored).at({0.3F, 1.4F}) - color_of(mirrored).at({0.3F, 1.0F})) < 1e-6F);
}

TEST_CASE("A skin moves vertices with its joints, a morph target by its weight, an animation both") {
  const std::vector<float> joints_weights{1, 0, 0, 0, 1, 0, 0, 0, 0.5F, 0.5F, 0, 0, 0, 1, 0, 0};
  const std::vector<std::uint8_t> joints{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0};
  const auto change = [&](Json& json) {
    const std::size_t view = add_view(json, bytes_of(joints));
    json["accessors"].push_back({{"bufferView", view}, {"componentType", 5121}, {"count", 4}, {"type", "VEC4"}});
    attributes(json)["JOINTS_0"] = json["accessors"].size() - 1;
    attributes(json)["WEIGHTS_0"] = add_floats(json, joints_weights, "VEC4", 4);
    json["nodes"].push_back({{"translation", {0, 0, -1}}});
    json["nodes"].push_back({{"translation", {0, 0, -3}}});
    json["skins"] = {{{"joints", {2, 3}}}};
    json["nodes"][0]["skin"] = 0;
    json["nodes"][0]["translation"] = {7, 7, 7};  // of no effect on a skin
    json["meshes"][0]["primitives"][0]["targets"] = {
        {{"POSITION", add_floats(json, {1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3", 3)}}};
    json["meshes"][0]["weights"] = {0.5};
    json["animations"] = {{{"channels",
                            {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "translation"}}}},
                             {{"sampler", 1}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
                           {"samplers",
                            {{{"input", add_floats(json, {0, 2}, "SCALAR", 1)},
                              {"output", add_floats(json, {0, 0, -1, 0, 4, -1}, "VEC3", 3)}},
                             {{"input", add_floats(json, {0, 2}, "SCALAR", 1)},
                              {"output", add_floats(json, {0, 2}, "SCALAR", 1)},
                              {"interpolation", "STEP"}}}}}};
  };
  const Read rest = read_changed(change);
  CAPTURE(rest.error);
  REQUIRE(rest.scene.shapes.size() == 1);
  CHECK(near(mesh(rest).positions.at(0), {-0.5, -1, -1}));
  CHECK(near(mesh(rest).positions.at(2), {1.5, 1, -2}));
  CHECK(near(mesh(rest).positions.at(3), {-0.5, 1, -3}));
  const Scratch folder;
  Json json = Json::parse(text_of(features / "metal.gltf"));
  change(json);
  std::ofstream(folder.path / "a.gltf") << json;
  Diagnostics diagnostics;
  LoadOptions options;
  options.seconds = 1;
  const SceneDescription moved = read_gltf_scene(folder.path / "a.gltf", diagnostics, options);
  const auto& m = std::get<MeshDescription>(moved.shapes.at(0).geometry);
  CHECK(near(m.positions.at(0), {-1, 1, -1}));  // two up with its joint, and no morph before the step
  CHECK(near(m.positions.at(3), {-1, 1, -3}));
}

TEST_CASE("Sparse accessors, accessors without data and instances") {
  const Read result = read_changed([](Json& json) {
    const std::size_t places = add_view(json, bytes_of(std::vector<std::uint16_t>{1, 3}));
    const std::size_t values = add_view(json, bytes_of(std::vector<float>{5, 5, 0, 6, 7, 0}));
    json["accessors"][0]["sparse"] = {{"count", 2},
                                      {"indices", {{"bufferView", places}, {"componentType", 5123}}},
                                      {"values", {{"bufferView", values}}}};
    json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
        add_floats(json, {0, 0, 0, 0, 0, 9}, "VEC3", 3);
  });
  CAPTURE(result.error);
  REQUIRE(result.scene.shapes.size() == 2);
  CHECK(near(mesh(result).positions.at(0), {-1, -1, 0}));
  CHECK(near(mesh(result).positions.at(1), {5, 5, 0}));
  CHECK(near(std::get<MeshDescription>(result.scene.shapes[1].geometry).positions.at(3), {6, 7, 9}));
}

TEST_CASE("A scale of 0 on one axis makes a mesh flat, and one without area is left out") {
  const auto scaled = [](const std::vector<double>& scale) {
    return read_changed([&](Json& json) {
      attributes(json)["NORMAL"] = add_floats(json, {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3);
      json["nodes"].push_back({{"mesh", 0}, {"scale", scale}, {"translation", {0, 0, -3}}});
      json["scenes"][0]["nodes"].push_back(json["nodes"].size() - 1);
    });
  };
  const Read flat = scaled({2, 3, 0});
  REQUIRE(flat.scene.shapes.size() == 2);
  const auto& image = std::get<MeshDescription>(flat.scene.shapes[1].geometry);
  CHECK(near(image.positions.at(2), {2, 3, -3}));
  CHECK(image.normals.empty());
  for (const std::vector<double>& scale : {std::vector<double>{0, 1, 1}, {1, 0, 0}, {0, 0, 0}})
    CHECK(scaled(scale).scene.shapes.size() == 1);
}

TEST_CASE("An error of a damaged file names its part, and what to do") {
  const auto error = [](const std::function<void(Json&)>& change) { return read_changed(change).error; };
  CHECK_THAT(error([](Json& j) { j["accessors"][0]["count"] = -1; }),
             Catch::Contains("accessor 0: count must be a whole number"));
  CHECK_THAT(error([](Json& j) { j["accessors"][0]["bufferView"] = 99; }),
             Catch::Contains("accessor 0: number 99 of \"bufferViews\" is not there"));
  CHECK_THAT(error([](Json& j) { attributes(j)["POSITION"] = 99; }),
             Catch::Contains(": POSITION: number 99 of \"accessors\" is not there"));
  CHECK_THAT(error([](Json& j) { j["bufferViews"][0].erase("buffer"); }),
             Catch::Contains("buffer view 0: it names none of \"buffers\""));
  CHECK_THAT(error([](Json& j) {
               j["nodes"][0].erase("name");
               j["nodes"][0]["children"] = {0};
             }),
             Catch::Contains("node 0 is its own ancestor"));
  CHECK_THAT(error([](Json& j) { j["extensionsRequired"] = {"KHR_foo"}; }), Catch::Contains("export it without"));
  const auto three = [](Json& j) { return add_floats(j, {0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3); };
  CHECK_THAT(error([&](Json& j) { attributes(j)["NORMAL"] = three(j); }),
             Catch::Contains("mesh 0: NORMAL has 3 values for 4 vertices"));
  CHECK_THAT(error([&](Json& j) {
               j["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", three(j)}}};
               j["meshes"][0]["weights"] = {1};
             }),
             Catch::Contains("mesh 0: POSITION of a morph target has 3 values for 4 vertices"));
  const Scratch folder;
  const auto error_of = [&](const std::string& text) {
    std::ofstream(folder.path / "j.gltf", std::ios::binary | std::ios::trunc) << text;
    return read_file(folder.path / "j.gltf").error;
  };
  CHECK_THAT(error_of("{\n  \"a\": 1e999 }"), Catch::Contains("line 2, column 8 is too large"));
  CHECK_THAT(error_of("{\n  \"a\": ? }"), Catch::Contains("line 2, column 8") && !Catch::EndsWith("\""));
}

TEST_CASE("Numbers that make no sense are named, and cut where that can be meant") {
  const auto error = [](const std::function<void(Json&)>& change) { return read_changed(change).error; };
  const auto base = [](const Json& factor) {
    return [factor](Json& j) { j["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = factor; };
  };
  CHECK(error(base({-5, 7, 1e38, 1})).find("baseColorFactor must be from 0 to 1: correct it") != std::string::npos);
  CHECK(read_changed(base({-5, 7, 1e38, 1}), Strictness::lenient).error.empty());
  for (const double intensity : {-10.0, 1e30})
    CHECK(error([&](Json& j) {
            j["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", intensity}}};
            j["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
          }).find("intensity") != std::string::npos);
  CHECK(error([](Json& j) { j["meshes"][0]["primitives"][0]["material"] = 99; }).find("number 99 of \"materials\"") !=
        std::string::npos);
  CHECK(error([](Json& j) {
          add_image(j);
          attributes(j).erase("TEXCOORD_0");
        }).find("TEXCOORD_0, which it lacks") != std::string::npos);
  CHECK(error([](Json& j) { j["asset"]["version"] = "1.0"; }).find("glTF 1.0") != std::string::npos);
  CHECK(error([](Json& j) {
          j["materials"][0]["emissiveFactor"] = {1e300, 0, 0};
        }).find("emissiveFactor") != std::string::npos);
}

#if GMIS_HAS_MESHOPT

TEST_CASE("What meshoptimizer packs is unpacked") {
  const std::vector<float> positions{-1, -1, 0, 1, -1, 0, 1, 1, 0.5F, -1, 1, 0.25F};
  std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(4, 12));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), positions.data(), 4, 12));
  const auto change = [&](Json& json, std::size_t length) {
    const std::size_t view =
        add_view(json, std::string(packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(length)));
    json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", json["bufferViews"][view]["buffer"]},
        {"byteLength", length},
        {"byteStride", 12},
        {"count", 4},
        {"mode", "ATTRIBUTES"}};
    json["bufferViews"][view]["byteLength"] = 48;
    json["accessors"][0]["bufferView"] = view;
  };
  const Read result = read_changed([&](Json& json) { change(json, packed.size()); });
  CAPTURE(result.error);
  REQUIRE(result.scene.shapes.size() == 1);
  CHECK(near(mesh(result).positions.at(2), {1, 1, 0.5}));
  CHECK(read_changed([&](Json& json) { change(json, packed.size() / 2); }).error.find("meshoptimizer") !=
        std::string::npos);
}

#endif

#if GMIS_HAS_DRACO

TEST_CASE("What Draco packs is unpacked") {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const float corners[4][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0.5F}, {-1, 1, 0.25F}};
  builder.SetAttributeValuesForFace(position, draco::FaceIndex(0), corners[0], corners[1], corners[2]);
  builder.SetAttributeValuesForFace(position, draco::FaceIndex(1), corners[0], corners[2], corners[3]);
  const auto made = builder.Finalize();
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  REQUIRE(encoder.EncodeMeshToBuffer(*made, &buffer).ok());
  const auto id = made->attribute(0)->unique_id();
  const auto change = [&](Json& json, std::size_t length) {
    const std::size_t view = add_view(json, std::string(buffer.data(), length));
    Json& primitive = json["meshes"][0]["primitives"][0];
    primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view}, {"attributes", {{"POSITION", id}}}};
    primitive["attributes"].erase("TEXCOORD_0");
    json["accessors"][0].erase("bufferView");
    json["accessors"][2].erase("bufferView");
  };
  const Read result = read_changed([&](Json& json) { change(json, buffer.size()); });
  CAPTURE(result.error);
  REQUIRE(result.scene.shapes.size() == 1);
  REQUIRE(mesh(result).triangles.size() == 2);
  double area = 0;
  for (const auto& triangle : mesh(result).triangles) {
    const auto at = [&](std::size_t k) { return mesh(result).positions.at(static_cast<std::size_t>(triangle[k])); };
    area += glm::length(glm::cross(at(1) - at(0), at(2) - at(0))) / 2;
  }
  CHECK(area == Approx((std::sqrt(17.0) + std::sqrt(16.5)) / 2).epsilon(1e-3));
  CHECK(read_changed([&](Json& json) { change(json, buffer.size() / 2); }).error.find("draco") != std::string::npos);
}

#endif
