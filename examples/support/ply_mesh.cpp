#include "support/ply_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "support/ply_layout.hpp"

#if GMIS_HAS_ZLIB
#include <zlib.h>
#endif
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
    if (from.HasTextureCoords(0)) to.uv.emplace_back(from.mTextureCoords[0][i].x, from.mTextureCoords[0][i].y);
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

namespace {

/// `name` is what messages call the file.
MeshDescription read_plain_ply(const std::filesystem::path& file, const std::filesystem::path& name,
                               const SourcePosition& where) {
  if (!is_whole_ply(file))
    throw InputError(where, "the mesh " + file_in_quotes(name.string()) + " is no PLY file, or is not whole");
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  if (scene == nullptr)
    throw InputError(where,
                     "the mesh " + file_in_quotes(name.string()) + " cannot be read: " + importer.GetErrorString());
  MeshDescription mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i)
    if (!append(*scene->mMeshes[i], mesh))
      throw InputError(where,
                       "a face of the mesh " + file_in_quotes(name.string()) + " refers to a vertex that is not there");
  if (mesh.normals.size() != mesh.positions.size()) mesh.normals.clear();
  if (mesh.uv.size() != mesh.positions.size()) mesh.uv.clear();
  const bool is_finite = std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const Point& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  });
  if (!is_finite)
    throw InputError(where, "the mesh " + file_in_quotes(name.string()) + " has a coordinate that is no number");
  if (mesh.triangles.empty())
    throw InputError(where, "the mesh " + file_in_quotes(name.string()) + " holds no triangle");
  return mesh;
}

#if GMIS_HAS_ZLIB

/// The unpacked bytes of a file, in a file of this process that goes away with this.
class Unpacked {
 public:
  Unpacked(const std::filesystem::path& file, const SourcePosition& where) {
    const auto fail = [&](const char* what) {
      return InputError(where, "the mesh " + file_in_quotes(file.string()) + what);
    };
    std::string name = (std::filesystem::temp_directory_path() / "gmis-XXXXXX.ply").string();
    const int descriptor = mkstemps(name.data(), 4);
    if (descriptor < 0) throw fail(" cannot be unpacked: there is no folder for temporary files");
    file_.path = name;
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(fdopen(descriptor, "wb"), std::fclose);
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(file.c_str(), "rb"), gzclose);
    if (!out || !in) throw fail(" cannot be unpacked");
    std::vector<char> buffer(1 << 20);
    constexpr std::uintmax_t most = std::uintmax_t{1} << 36;
    std::uintmax_t total = 0;
    while (true) {
      const int count = gzread(in.get(), buffer.data(), static_cast<unsigned>(buffer.size()));
      if (count < 0) throw fail(" cannot be unpacked: it is no whole gzip file");
      if (count == 0) break;
      total += static_cast<std::uintmax_t>(count);
      if (total > most ||
          std::fwrite(buffer.data(), 1, static_cast<std::size_t>(count), out.get()) != static_cast<std::size_t>(count))
        throw fail(" cannot be unpacked: there is no room for it");
    }
    int code = Z_OK;
    (void)gzerror(in.get(), &code);
    if (code != Z_OK) throw fail(" cannot be unpacked: it is no whole gzip file");
  }
  [[nodiscard]] const std::filesystem::path& path() const { return file_.path; }

 private:
  struct Temporary {
    std::filesystem::path path;
    Temporary() = default;
    Temporary(const Temporary&) = delete;
    Temporary& operator=(const Temporary&) = delete;
    ~Temporary() {
      std::error_code ignored;
      std::filesystem::remove(path, ignored);
    }
  } file_;
};

#endif

}  // namespace

MeshDescription read_ply(const std::filesystem::path& file, const SourcePosition& where) {
  if (!std::filesystem::is_regular_file(file))
    throw InputError(where, "the mesh " + file_in_quotes(file.string()) +
                                (std::filesystem::exists(file) ? " is no regular file" : " is missing") +
                                ": check its name");
  if (file.extension() == ".gz") {
#if GMIS_HAS_ZLIB
    const Unpacked unpacked(file, where);
    return read_plain_ply(unpacked.path(), file, where);
#else
    throw InputError(where, "the mesh " + file_in_quotes(file.string()) +
                                " cannot be read: this program was built without the library zlib, which unpacks it");
#endif
  }
  return read_plain_ply(file, file, where);
}

#else

bool can_read_ply() {
  return false;
}

MeshDescription read_ply(const std::filesystem::path& file, const SourcePosition& where) {
  throw InputError(where, "the mesh " + file_in_quotes(file.string()) +
                              " cannot be read: this program was built without the library assimp, which reads PLY");
}

#endif

}  // namespace gmis::tools
