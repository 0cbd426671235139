#include "report.hpp"

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace bench {
namespace {

void replace_file(const std::string& path, const std::string& text) {
  const std::string unfinished = path + ".part";
  {
    std::ofstream file(unfinished, std::ios::binary);
    file << text;
    file.flush();
    if (!file) throw std::runtime_error("cannot write " + unfinished);
  }
  std::filesystem::rename(unfinished, path);
}

/// The columns are the keys of the first row; every row has the same.
std::string as_csv(const nlohmann::ordered_json& rows) {
  std::string text;
  const auto add_line = [&](const auto& row, auto cell) {
    bool is_first = true;
    for (const auto& [key, value] : row.items()) {
      if (!is_first) text += ',';
      is_first = false;
      text += cell(key, value);
    }
    text += '\n';
  };
  add_line(rows.front(), [](const std::string& key, const auto&) { return key; });
  for (const auto& row : rows)
    add_line(row, [](const std::string&, const nlohmann::ordered_json& value) {
      if (value.is_null()) return std::string();
      return value.is_string() ? value.get<std::string>() : value.dump();
    });
  return text;
}

}  // namespace

void write_report(const nlohmann::ordered_json& report, const std::string& prefix) {
  const auto folder = std::filesystem::path(prefix).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder);
  replace_file(prefix + ".json", report.dump(1) + "\n");
  for (const auto& [name, rows] : report.items())
    if (rows.is_array() && !rows.empty() && rows.front().is_object())
      replace_file(prefix + "-" + name + ".csv", as_csv(rows));
}

}  // namespace bench
