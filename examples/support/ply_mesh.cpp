#include "support/ply_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#if GMIS_HAS_ASSIMP
#include <assimp/mesh.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#endif

namespace gmis::tools {

#if GMIS_HAS_ASSIMP

bool can_read_ply() {
  return true;
}

namespace {

/// True for `TYPE NAME` or `list TYPE TYPE NAME` with types that PLY has; the name goes to `name`.
bool is_property(std::istringstream& words, std::string& name) {
  constexpr std::array types{"char", "uchar", "short", "ushort", "int",   "uint",   "float",   "double",
                             "int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};
  const auto is_type = [&](const std::string& word) {
    return std::find(types.begin(), types.end(), word) != types.end();
  };
  std::string word, rest;
  words >> word;
  if (word == "list" && !(words >> word && is_type(word) && words >> word)) return false;
  return is_type(word) && words >> name && !(words >> rest);
}

/// What assimp needs to be sure of before it reads: it loops for ever over a header that does not end, believes any
/// count of elements, and writes past the end of what it has for an element or a property that comes twice. True when
/// the header is whole, says everything once, and the file is long enough for what it promises.
bool has_sound_header(const std::filesystem::path& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  std::ifstream stream(file, std::ios::binary);
  constexpr int most_lines = 1000;
  std::string line;
  if (error || !std::getline(stream, line) || !line.starts_with("ply")) return false;
  std::set<std::string> elements, properties;
  for (int i = 0; i < most_lines && std::getline(stream, line); ++i) {
    std::istringstream words(line);
    std::string first, name;
    std::uintmax_t count = 0;
    words >> first;
    if (first == "end_header") return true;
    if (first == "element") {
      if (!(words >> name >> count) || count > size || !elements.insert(name).second) return false;
      properties.clear();
    } else if (first == "property") {
      if (elements.empty() || !is_property(words, name) || !properties.insert(name).second) return false;
    } else if (first != "format" && first != "comment" && first != "obj_info") {
      return false;
    }
  }
  return false;
}

/// False when a face refers to a vertex that there is none of.
bool append(const aiMesh& from, MeshDescription& to) {
  const int first = static_cast<int>(to.positions.size());
  for (unsigned i = 0; i < from.mNumVertices; ++i) {
    const aiVector3D& p = from.mVertices[i];
    to.positions.emplace_back(p.x, p.y, p.z);
    if (from.HasNormals()) to.normals.emplace_back(from.mNormals[i].x, from.mNormals[i].y, from.mNormals[i].z);
  }
  for (unsigned i = 0; i < from.mNumFaces; ++i) {
    const aiFace& face = from.mFaces[i];
    const auto corner = [&](unsigned k) { return first + static_cast<int>(face.mIndices[k]); };
    const bool is_sound = std::all_of(face.mIndices, face.mIndices + face.mNumIndices,
                                      [&](unsigned index) { return index < from.mNumVertices; });
    if (!is_sound) return false;
    // A fan; points and lines have no area and give nothing.
    for (unsigned k = 2; k < face.mNumIndices; ++k) to.triangles.push_back({corner(0), corner(k - 1), corner(k)});
  }
  return true;
}

}  // namespace

MeshDescription read_ply(const std::filesystem::path& file, const SourcePosition& where) {
  if (!std::filesystem::is_regular_file(file))
    throw InputError(where, "the mesh " + in_quotes(file.string()) + " cannot be read: check its name");
  if (!has_sound_header(file))
    throw InputError(where, "the mesh " + in_quotes(file.string()) + " is no PLY file, or is not whole");
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  if (scene == nullptr)
    throw InputError(where, "the mesh " + in_quotes(file.string()) + " cannot be read: " + importer.GetErrorString());
  MeshDescription mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i)
    if (!append(*scene->mMeshes[i], mesh))
      throw InputError(where,
                       "a face of the mesh " + in_quotes(file.string()) + " refers to a vertex that is not there");
  if (mesh.normals.size() != mesh.positions.size()) mesh.normals.clear();
  const bool is_finite = std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const Point& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  });
  if (!is_finite)
    throw InputError(where, "the mesh " + in_quotes(file.string()) + " has a coordinate that is no number");
  if (mesh.triangles.empty()) throw InputError(where, "the mesh " + in_quotes(file.string()) + " holds no triangle");
  return mesh;
}

#else

bool can_read_ply() {
  return false;
}

MeshDescription read_ply(const std::filesystem::path& file, const SourcePosition& where) {
  throw InputError(where, "the mesh " + in_quotes(file.string()) +
                              " cannot be read: this program was built without the library assimp, which reads PLY");
}

#endif

}  // namespace gmis::tools
