// Checks the fenced blocks and the links of Markdown files. What a reader copies must be what is
// built and run here:
// - `cpp`: stands, line for line, in a file that this build compiles (or in a consumer project);
// - `python`: stands, line for line, in a program of examples/python;
// - `cmake`: stands, line for line, in a CMakeLists.txt of tests/consumer;
// - `sh`, `console`: every command is one of a few tools; `./run` knows its own, gmis-render the
//   options it is given;
// - `text` and no name: anything; any other name is an error;
// - a link to a file of the project leads somewhere.
// Usage: check_snippets PROJECT_DIR COMPILE_COMMANDS GMIS_RENDER|- FILE.md…
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Lines = std::vector<std::string>;

struct Block {
  std::string language;
  std::size_t first_line = 0;
  Lines lines;
};

std::string read(const fs::path& path) {
  const std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

Lines split(const std::string& text) {
  Lines lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string output_of(const std::string& command) {
  std::string output;
  if (std::FILE* pipe = popen(command.c_str(), "r")) {
    std::array<char, 4096> buffer;
    while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe))
      output.append(buffer.data(), count);
    pclose(pipe);
  }
  return output;
}

std::vector<Block> fenced_blocks(const Lines& document) {
  std::vector<Block> blocks;
  bool inside = false;
  for (std::size_t i = 0; i < document.size(); ++i) {
    if (document[i].starts_with("```")) {
      if (!inside) blocks.push_back({document[i].substr(3), i + 2, {}});
      inside = !inside;
    } else if (inside) {
      blocks.back().lines.push_back(document[i]);
    }
  }
  return blocks;
}

// Whether `snippet` stands in `file` as consecutive lines, all of them indented by the same amount.
bool contains(const Lines& file, const Lines& snippet) {
  if (snippet.empty() || snippet.size() > file.size()) return false;
  for (std::size_t start = 0; start + snippet.size() <= file.size(); ++start) {
    const std::string& first = file[start];
    if (!first.ends_with(snippet[0])) continue;
    const std::string indent = first.substr(0, first.size() - snippet[0].size());
    if (indent.find_first_not_of(' ') != std::string::npos) continue;
    const auto matches = [&](const std::string& shown, const std::string& written) {
      return shown.empty() ? written.empty() : written == indent + shown;
    };
    if (std::equal(snippet.begin(), snippet.end(), file.begin() + static_cast<std::ptrdiff_t>(start), matches))
      return true;
  }
  return false;
}

class Checker {
 public:
  Checker(fs::path project, const fs::path& compile_commands, const std::string& gmis_render)
      : project_(std::move(project)) {
    if (gmis_render != "-") gmis_render_help_ = output_of("'" + gmis_render + "' --help");
    const std::string commands = read(compile_commands);
    for (const char* folder : {"examples", "tests", "bench"}) {
      for (const fs::directory_entry& entry : fs::recursive_directory_iterator(project_ / folder)) {
        const fs::path& path = entry.path();
        const bool in_consumer = path.string().find("tests/consumer/") != std::string::npos;
        const bool is_compiled = commands.find('"' + path.string() + '"') != std::string::npos;
        if (path.extension() == ".cpp" && (is_compiled || in_consumer)) add_compiled(path);
        if (path.extension() == ".py" && path.parent_path() == project_ / "examples/python")
          python_files_.push_back(split(read(path)));
        if (path.filename() == "CMakeLists.txt" && in_consumer) cmake_files_.push_back(split(read(path)));
      }
    }
  }

  // The number of faults, each of which it prints.
  int check(const fs::path& document) {
    document_ = document;
    faults_ = 0;
    const Lines lines = split(read(document));
    for (const Block& block : fenced_blocks(lines)) check(block);
    check_links(lines);
    return faults_;
  }

 private:
  // A compiled file, and what it includes of the project's own programs: that is compiled with it.
  void add_compiled(const fs::path& path) {
    if (!seen_.insert(path.string()).second) return;
    compiled_files_.push_back(split(read(path)));
    const Lines lines = compiled_files_.back();
    constexpr std::string_view directive = "#include \"";
    for (const std::string& line : lines) {
      if (!line.starts_with(directive)) continue;
      const std::string name = line.substr(directive.size(), line.rfind('"') - directive.size());
      for (const char* folder : {"tests", "examples"})
        if (const fs::path included = project_ / folder / name; fs::exists(included)) add_compiled(included);
    }
  }

  void check(const Block& block) {
    if (block.language == "cpp")
      require_in(compiled_files_, block, "stands in no compiled file of examples/, tests/ or bench/");
    else if (block.language == "python")
      require_in(python_files_, block, "stands in no program of examples/python");
    else if (block.language == "cmake")
      require_in(cmake_files_, block, "stands in no CMakeLists.txt of tests/consumer/");
    else if (block.language == "sh" || block.language == "console")
      check_commands(block);
    else if (!block.language.empty() && block.language != "text")
      report(block.first_line, "a block of an unknown kind: " + block.language);
  }

  void check_links(const Lines& lines) {
    constexpr std::string_view opening = "](";
    bool inside_block = false;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i].starts_with("```")) inside_block = !inside_block;
      if (inside_block) continue;
      for (std::size_t at = lines[i].find(opening); at != std::string::npos; at = lines[i].find(opening, at + 1)) {
        const std::size_t begin = at + opening.size();
        const std::string target = lines[i].substr(begin, lines[i].find_first_of("#)", begin) - begin);
        const bool is_elsewhere = target.empty() || target.find("://") != std::string::npos;
        if (!is_elsewhere && !fs::exists(document_.parent_path() / target))
          report(i + 1, "a link that leads nowhere: " + target);
      }
    }
  }

  void require_in(const std::vector<Lines>& files, const Block& block, std::string_view fault) {
    if (std::none_of(files.begin(), files.end(), [&](const Lines& file) { return contains(file, block.lines); }))
      report(block.first_line, "this block " + std::string(fault));
  }

  // In a `console` block the commands start with "$ " and the rest is output; in `sh` every line is
  // a command.
  void check_commands(const Block& block) {
    for (std::size_t i = 0; i < block.lines.size(); ++i) {
      std::string command = block.lines[i];
      if (block.language == "console") {
        if (!command.starts_with("$ ")) continue;
        command.erase(0, 2);
      }
      if (!command.empty()) check_command(block.first_line + i, command);
    }
  }

  void check_command(std::size_t line, const std::string& command) {
    constexpr std::array<std::string_view, 4> other_tools = {"cmake", "ctest", "git", "cd"};
    std::istringstream words(command);
    std::string tool;
    words >> tool;
    if (tool == "./run") {
      const std::string dry = "cd '" + project_.string() + "' && GMIS_NO_INSTALL=1 ./run --dry-run" + command.substr(5);
      if (std::system((dry + " >/dev/null 2>&1").c_str()) != 0) report(line, "./run refuses: " + command);
    } else if (tool == "gmis-render" || tool == "mpirun") {
      // The options before the program are those of mpirun.
      while (tool != "gmis-render" && tool != "gmis-render-mpi" && words) words >> tool;
      if (!words) report(line, "mpirun of another program: " + command);
      for (std::string word; words >> word;) {
        if (word.starts_with("--") && !knows_option(word)) report(line, "gmis-render does not know " + word);
      }
    } else if (std::find(other_tools.begin(), other_tools.end(), tool) == other_tools.end()) {
      report(line, "an unknown tool: " + command);
    }
  }

  // True without a program that could be asked.
  bool knows_option(const std::string& option) const {
    if (gmis_render_help_.empty()) return true;
    for (std::size_t at = gmis_render_help_.find(option); at != std::string::npos;
         at = gmis_render_help_.find(option, at + 1)) {
      const std::size_t end = at + option.size();
      if (end == gmis_render_help_.size() ||
          std::string_view(" \n,=").find(gmis_render_help_[end]) != std::string::npos)
        return true;
    }
    return false;
  }

  void report(std::size_t line, const std::string& fault) {
    std::cerr << document_.string() << ':' << line << ": " << fault << '\n';
    ++faults_;
  }

  fs::path project_;
  std::string gmis_render_help_;
  fs::path document_;
  std::set<std::string> seen_;
  std::vector<Lines> compiled_files_;
  std::vector<Lines> cmake_files_;
  std::vector<Lines> python_files_;
  int faults_ = 0;
};

}  // namespace

int main(int argc, char* argv[]) {
  if (argc < 5) {
    std::cerr << "Usage: check_snippets PROJECT_DIR COMPILE_COMMANDS GMIS_RENDER|- FILE.md...\n";
    return EXIT_FAILURE;
  }
  Checker checker(argv[1], argv[2], argv[3]);
  int faults = 0;
  for (int i = 4; i < argc; ++i) faults += checker.check(argv[i]);
  std::cout << argc - 4 << " documents, " << faults << " faults\n";
  return faults == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
