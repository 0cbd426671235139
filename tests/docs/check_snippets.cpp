// Checks the fenced blocks of Markdown files. What a reader copies must be what is built and run here:
// - `cpp`: stands, line for line, in a file that this build compiles (or in a consumer project);
// - `cmake`: stands, line for line, in a CMakeLists.txt of tests/consumer;
// - `sh`, `console`: every command is one of a few tools, and `./run` knows those that are its own;
// - `text` and no name: anything; any other name is an error.
// Usage: check_snippets PROJECT_DIR COMPILE_COMMANDS FILE.md…
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
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
  Checker(fs::path project, const fs::path& compile_commands) : project_(std::move(project)) {
    const std::string commands = read(compile_commands);
    for (const char* folder : {"examples", "tests", "bench"}) {
      for (const fs::directory_entry& entry : fs::recursive_directory_iterator(project_ / folder)) {
        const fs::path& path = entry.path();
        const bool in_consumer = path.string().find("tests/consumer/") != std::string::npos;
        const bool is_compiled = commands.find('"' + path.string() + '"') != std::string::npos;
        if (path.extension() == ".cpp" && (is_compiled || in_consumer)) compiled_files_.push_back(split(read(path)));
        if (path.filename() == "CMakeLists.txt" && in_consumer) cmake_files_.push_back(split(read(path)));
      }
    }
  }

  // The number of faults, each of which it prints.
  int check(const fs::path& document) {
    document_ = document;
    faults_ = 0;
    for (const Block& block : fenced_blocks(split(read(document)))) check(block);
    return faults_;
  }

 private:
  void check(const Block& block) {
    if (block.language == "cpp")
      require_in(compiled_files_, block, "stands in no compiled file of examples/, tests/ or bench/");
    else if (block.language == "cmake")
      require_in(cmake_files_, block, "stands in no CMakeLists.txt of tests/consumer/");
    else if (block.language == "sh" || block.language == "console")
      check_commands(block);
    else if (!block.language.empty() && block.language != "text")
      report(block.first_line, "a block of an unknown kind: " + block.language);
  }

  void require_in(const std::vector<Lines>& files, const Block& block, std::string_view fault) {
    if (std::none_of(files.begin(), files.end(), [&](const Lines& file) { return contains(file, block.lines); }))
      report(block.first_line, "this block " + std::string(fault));
  }

  // In a `console` block the commands start with "$ " and the rest is output; in `sh` every line is a command.
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
    constexpr std::array<std::string_view, 5> other_tools = {"cmake", "ctest", "git", "cd", "gmis-render"};
    std::string tool;
    std::istringstream(command) >> tool;
    if (tool == "./run") {
      const std::string dry = "cd '" + project_.string() + "' && GMIS_NO_INSTALL=1 ./run --dry-run" + command.substr(5);
      if (std::system((dry + " >/dev/null 2>&1").c_str()) != 0) report(line, "./run refuses: " + command);
    } else if (std::find(other_tools.begin(), other_tools.end(), tool) == other_tools.end()) {
      report(line, "an unknown tool: " + command);
    }
  }

  void report(std::size_t line, const std::string& fault) {
    std::cerr << document_.string() << ':' << line << ": " << fault << '\n';
    ++faults_;
  }

  fs::path project_;
  fs::path document_;
  std::vector<Lines> compiled_files_;
  std::vector<Lines> cmake_files_;
  int faults_ = 0;
};

}  // namespace

int main(int argc, char* argv[]) {
  if (argc < 4) {
    std::cerr << "Usage: check_snippets PROJECT_DIR COMPILE_COMMANDS FILE.md...\n";
    return EXIT_FAILURE;
  }
  Checker checker(argv[1], argv[2]);
  int faults = 0;
  for (int i = 3; i < argc; ++i) faults += checker.check(argv[i]);
  std::cout << argc - 3 << " documents, " << faults << " faults\n";
  return faults == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
