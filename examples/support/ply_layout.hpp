#pragma once

#include <filesystem>

namespace gmis::tools {

/// True when a PLY file, text or binary in either byte order, is as long as it says: its header is whole and names every
/// element and property once, every element is there, and every list has the entries that its length promises (as text:
/// each element has a line of its own, with exactly its values). Values themselves are not looked at.
///
/// A reader that believes what it reads needs this first: assimp loops for ever over a header that does not end, asks for
/// as much memory as a length says, and reads past the end of what there is.
[[nodiscard]] bool is_whole_ply(const std::filesystem::path& file);

}  // namespace gmis::tools
