#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "program/read_scene.hpp"
#include "program/scratch_folder.hpp"
#include "support/gltf/reader.hpp"

/// \file
/// Files of glTF that tests make out of one of a square, and read.

namespace gmis_test {

using namespace gmis::tools;
using Json = nlohmann::json;
namespace fs = std::filesystem;

inline const fs::path features = GMIS_FEATURE_FOLDER;

/// A folder with the images that the scenes below name.
struct Scratch : ScratchFolder {
  Scratch() {
    for (const char* name : {"colors.png", "tilted.png", "cutout.png"}) fs::copy_file(features / name, path / name);
  }
};

inline Read read_file(const fs::path& file, Strictness strictness = Strictness::strict) {
  return reading(strictness, [&](Diagnostics& diagnostics) { return read_gltf_scene(file, diagnostics); });
}

/// metal.gltf, changed.
inline Read read_changed(const std::function<void(Json&)>& change, Strictness strictness = Strictness::strict) {
  const Scratch folder;
  Json json = Json::parse(text_of(features / "metal.gltf"));
  change(json);
  std::ofstream(folder.path / "a.gltf") << json;
  return read_file(folder.path / "a.gltf", strictness);
}

inline const MeshDescription& mesh(const Read& result) {
  return std::get<MeshDescription>(result.scene.shapes.at(0).geometry);
}

inline bool near(const glm::dvec3& a, const glm::dvec3& b) {
  return glm::length(a - b) < 1e-6 * (1 + glm::length(b));
}

inline std::string base64_of(const std::string& bytes) {
  const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : letters[word >> (18 - 6 * k) & 63U];
  }
  return text;
}

/// Adds bytes as a view with a buffer of its own; its number.
inline std::size_t add_view(Json& json, const std::string& bytes) {
  json["buffers"].push_back(
      {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64_of(bytes)}});
  json["bufferViews"].push_back({{"buffer", json["buffers"].size() - 1}, {"byteLength", bytes.size()}});
  return json["bufferViews"].size() - 1;
}

template <class Number>
inline std::string bytes_of(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

/// Adds an accessor of floats; its number.
inline std::size_t add_floats(Json& json, const std::vector<float>& numbers, const std::string& type,
                              std::size_t width) {
  const std::size_t view = add_view(json, bytes_of(numbers));
  json["accessors"].push_back(
      {{"bufferView", view}, {"componentType", 5126}, {"count", numbers.size() / width}, {"type", type}});
  return json["accessors"].size() - 1;
}

inline Json& attributes(Json& json) {
  return json["meshes"][0]["primitives"][0]["attributes"];
}

inline void add_image(Json& json, const char* file = "colors.png") {
  json["images"] = {{{"uri", file}}};
  json["textures"] = {{{"source", 0}}};
  json["materials"][0] = {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"baseColorTexture", {{"index", 0}}}}}};
}

}  // namespace gmis_test
