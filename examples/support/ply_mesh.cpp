#include "support/ply_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "support/ply_layout.hpp"

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
    throw InputError(where, "the mesh " + in_quotes(file.string()) +
                                (std::filesystem::exists(file) ? " is no regular file" : " is missing") +
                                ": check its name");
  if (!is_whole_ply(file))
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
