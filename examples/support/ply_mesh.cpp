#include "support/ply_mesh.hpp"

#if GMIS_HAS_ASSIMP
#include <assimp/mesh.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#endif

namespace gmis::tools {

#if GMIS_HAS_ASSIMP

bool can_read_ply() {
  return true;
}

namespace {

void append(const aiMesh& from, MeshDescription& to) {
  const int first = static_cast<int>(to.positions.size());
  for (unsigned i = 0; i < from.mNumVertices; ++i) {
    const aiVector3D& p = from.mVertices[i];
    to.positions.emplace_back(p.x, p.y, p.z);
    if (from.HasNormals()) to.normals.emplace_back(from.mNormals[i].x, from.mNormals[i].y, from.mNormals[i].z);
  }
  for (unsigned i = 0; i < from.mNumFaces; ++i) {
    const aiFace& face = from.mFaces[i];
    if (face.mNumIndices != 3) continue;  // points and lines have no area
    to.triangles.push_back({first + static_cast<int>(face.mIndices[0]), first + static_cast<int>(face.mIndices[1]),
                            first + static_cast<int>(face.mIndices[2])});
  }
}

}  // namespace

MeshDescription read_ply(const std::filesystem::path& file, const SourcePosition& where) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_ValidateDataStructure);
  if (scene == nullptr)
    throw InputError(where, "the mesh " + in_quotes(file.string()) + " cannot be read: " + importer.GetErrorString());
  MeshDescription mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) append(*scene->mMeshes[i], mesh);
  if (mesh.normals.size() != mesh.positions.size()) mesh.normals.clear();
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
