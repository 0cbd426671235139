#pragma once

#include <filesystem>
#include <functional>
#include <string>

/// \file
/// Files that are whole at every moment: what is to be written goes into a new file beside the old
/// one, which then takes its name. When anything fails (a full disk, say) the old file stays as it
/// was.

namespace gmis::tools {

/// Where a link leads to, whether or not there is a file; the file itself where it is no link.
[[nodiscard]] std::filesystem::path target_of(std::filesystem::path file);

/// `write` writes the file whose name it gets. Throws `OutputError`, which names `file`, when that
/// or the renaming fails; the new file is then removed. A link keeps pointing where it did. What is
/// no regular file (a terminal, a pipe, /dev/null) is written directly.
void write_whole(const std::filesystem::path& file, const std::function<void(const std::filesystem::path&)>& write);

/// `write_whole`, for a text.
void write_whole(const std::string& text, const std::filesystem::path& file);

/// To be called before the work: throws `InputError` when `write_whole` could not make this file
/// now. Leaves nothing behind.
void require_writable(const std::filesystem::path& file);

}  // namespace gmis::tools
