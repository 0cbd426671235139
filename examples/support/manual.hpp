#pragma once

#include <string>
#include <vector>

/// \file
/// A manual page and completions of shells, made from what the parser of a command line knows about
/// its options.

namespace gmis::tools {

/// One option. The words of its value are those between bars, but for names in capitals; FILE and
/// FOLDER are paths.
struct OptionSummary {
  std::string name;         ///< with its dashes
  std::string value;        ///< such as FILE, or auto|pt|lt; empty for a flag
  std::string description;  ///< one sentence or more
};

struct ProgramSummary {
  std::string name, version, description;
  std::string arguments;  ///< such as [SCENE]: a file, or a name that `list_option` prints
  std::string list_option;
  std::vector<OptionSummary> options;
};

/// The words that the value of an option may be; none where it may be anything.
[[nodiscard]] std::vector<std::string> words_of_value(const OptionSummary& option);

/// In the language of man(7).
[[nodiscard]] std::string manual_page(const ProgramSummary& program);
/// For the shell bash, zsh or fish; throws `InputError` for another.
[[nodiscard]] std::string completion_script(const ProgramSummary& program, const std::string& shell);

}  // namespace gmis::tools
