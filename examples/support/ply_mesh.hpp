#pragma once

#include <filesystem>
#include <string_view>

#include "support/load_budget.hpp"
#include "support/scene_description.hpp"

namespace gmis::tools {

/// The triangles of a PLY file, .ply or .ply.gz (polygons are cut into fans), with its vertex
/// normals and coordinates when it has them. Throws `InputError` when the file cannot be read;
/// `where` names the directive.
[[nodiscard]] MeshDescription read_ply(const std::filesystem::path& file, LoadBudget& budget,
                                       const SourcePosition& where);

/// `read_ply`, for the bytes of such a file; `name` is what messages call it. The file must be as
/// long as it says: its header whole, every element and property named once, every list with the
/// entries that its length promises. As text each element has a line of its own, with exactly its
/// values.
[[nodiscard]] MeshDescription parse_ply(std::string_view bytes, const std::string& name, LoadBudget& budget,
                                        const SourcePosition& where);

}  // namespace gmis::tools
