#include "support/manual.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "support/diagnostics.hpp"

namespace gmis::tools {
namespace {

/// Text as roff reads it: no line begins with a control character, dashes are dashes.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else if ((c == '.' || c == '\'') && (result.empty() || result.back() == '\n'))
      result += std::string("\\&") + c;
    else
      result += c;
  }
  return result;
}

std::string joined(const std::vector<std::string>& words) {
  std::string result;
  for (const std::string& word : words) result += (result.empty() ? "" : " ") + word;
  return result;
}

/// Inside single quotation marks of a shell.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

bool takes_file(const OptionSummary& option) {
  return option.value.find("FILE") != std::string::npos;
}
bool takes_folder(const OptionSummary& option) {
  return option.value.find("FOLDER") != std::string::npos;
}

std::string function_name(const ProgramSummary& program) {
  std::string name = "_" + program.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::string bash_completion(const ProgramSummary& program) {
  std::ostringstream text;
  const std::string function = function_name(program);
  std::vector<std::string> names;
  for (const OptionSummary& option : program.options) names.push_back(option.name);
  text << "# bash completion of " << program.name << "\n"
       << function << "() {\n"
       << "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
       << "  case $before in\n";
  for (const OptionSummary& option : program.options) {
    if (option.value.empty()) continue;
    text << "    " << option.name << ") ";
    if (const auto words = words_of_value(option); !words.empty())
      text << "mapfile -t COMPREPLY < <(compgen -W " << quoted(joined(words)) << " -- \"$word\"); ";
    else if (takes_file(option) || takes_folder(option))
      text << "mapfile -t COMPREPLY < <(compgen -" << (takes_file(option) ? "f" : "d") << " -- \"$word\"); ";
    text << "return ;;\n";
  }
  text << "  esac\n"
       << "  if [[ $word == -* ]]; then\n"
       << "    mapfile -t COMPREPLY < <(compgen -W " << quoted(joined(names)) << " -- \"$word\")\n"
       << "  else\n"
       << "    mapfile -t COMPREPLY < <(compgen -f -- \"$word\"\n"
       << "      compgen -W \"$(" << program.name << " " << program.list_option
       << " 2>/dev/null | cut -d' ' -f1)\" -- \"$word\")\n"
       << "  fi\n"
       << "}\n"
       << "complete -o filenames -F " << function << " " << program.name << "\n";
  return text.str();
}

std::string zsh_completion(const ProgramSummary& program) {
  std::ostringstream text;
  text << "#compdef " << program.name << "\n_arguments \\\n";
  for (const OptionSummary& option : program.options) {
    std::string description;
    for (const char c : option.description)
      description += c == '[' || c == ']' || c == ':' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    std::string action;
    if (!option.value.empty()) {
      const auto words = words_of_value(option);
      action = ":value:";
      action += !words.empty()         ? std::string("(").append(joined(words)).append(")")
                : takes_folder(option) ? "_files -/"
                : takes_file(option)   ? "_files"
                                       : "";
    }
    text << "  " << quoted(option.name + "[" + description + "]" + action) << " \\\n";
  }
  text << "  '*:scene:_files'\n";
  return text.str();
}

std::string fish_completion(const ProgramSummary& program) {
  std::ostringstream text;
  text << "# fish completion of " << program.name << "\n"
       << "complete -c " << program.name << " -a "
       << quoted("(" + program.name + " " + program.list_option + " | string replace -r ' .*' '')") << "\n";
  for (const OptionSummary& option : program.options) {
    text << "complete -c " << program.name << " -l " << option.name.substr(2) << " -d " << quoted(option.description);
    if (const auto words = words_of_value(option); !words.empty())
      text << " -x -a " << quoted(joined(words));
    else if (!option.value.empty())
      text << (takes_file(option) || takes_folder(option) ? " -r" : " -x");
    text << "\n";
  }
  return text.str();
}

}  // namespace

std::vector<std::string> words_of_value(const OptionSummary& option) {
  std::vector<std::string> words;
  if (option.value.find('|') == std::string::npos) return words;
  std::stringstream stream(option.value);
  for (std::string word; std::getline(stream, word, '|');)
    if (!std::all_of(word.begin(), word.end(), [](unsigned char c) { return std::isupper(c) != 0; }))
      words.push_back(word);
  return words;
}

std::string manual_page(const ProgramSummary& program) {
  std::ostringstream text;
  std::string title = program.name;
  std::transform(title.begin(), title.end(), title.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  text << ".TH " << escaped(title) << " 1 \"\" \"" << escaped(program.name + " " + program.version)
       << "\" \"User Commands\"\n"
       << ".SH NAME\n"
       << escaped(program.name) << " \\- " << escaped(program.description) << "\n"
       << ".SH SYNOPSIS\n.B " << escaped(program.name) << "\n.I " << escaped(program.arguments) << "\n.RI [ OPTIONS ]\n"
       << ".SH DESCRIPTION\n"
       << "Renders a scene file (.pbrt, .gltf, .glb) or a built\\-in scene to images. A number in parentheses "
          "is the default.\n"
       << ".SH OPTIONS\n";
  for (const OptionSummary& option : program.options) {
    text << ".TP\n\\fB" << escaped(option.name) << "\\fR";
    if (!option.value.empty()) text << " \\fI" << escaped(option.value) << "\\fR";
    text << "\n" << escaped(option.description) << "\n";
  }
  text << ".SH \"EXIT STATUS\"\n"
       << ".TP\n0\nThe work was done.\n"
       << ".TP\n1\nIt failed: a file could not be written, or too large a share of the contributions was rejected.\n"
       << ".TP\n2\nThe command line or the scene is not understood: one line on standard error says what to change.\n";
  return text.str();
}

std::string completion_script(const ProgramSummary& program, const std::string& shell) {
  if (shell == "bash") return bash_completion(program);
  if (shell == "zsh") return zsh_completion(program);
  if (shell == "fish") return fish_completion(program);
  throw InputError("--completion " + in_quotes(shell) + " is not known: use bash, zsh or fish");
}

}  // namespace gmis::tools
