#pragma once

#include <filesystem>

#include "support/scene_description.hpp"

namespace gmis::tools {

/// True when this build can read PLY files.
[[nodiscard]] bool can_read_ply();

/// The triangles of a PLY file (polygons are cut up), with its vertex normals when it has them. Throws `InputError`
/// when the file cannot be read, holds no triangle, or when this build cannot read PLY; `where` names the directive.
[[nodiscard]] MeshDescription read_ply(const std::filesystem::path& file, const SourcePosition& where);

}  // namespace gmis::tools
