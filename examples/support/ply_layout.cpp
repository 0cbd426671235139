#include "support/ply_layout.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gmis::tools {

namespace {

struct Property {
  std::string name;
  std::size_t size = 0;     ///< bytes of a value, or of each entry of a list
  std::string length_type;  ///< of a list; empty: it is none
};

struct Element {
  std::string name;
  std::uintmax_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { text, little_endian, big_endian };

struct Layout {
  Encoding encoding = Encoding::text;
  std::vector<Element> elements;
};

/// Bytes of a number of this type; 0 for what is no type.
std::size_t size_of(const std::string& type) {
  constexpr std::pair<std::string_view, std::size_t> types[] = {
      {"char", 1},  {"uchar", 1},  {"short", 2},   {"ushort", 2}, {"int", 4},   {"uint", 4},
      {"float", 4}, {"double", 8}, {"int8", 1},    {"uint8", 1},  {"int16", 2}, {"uint16", 2},
      {"int32", 4}, {"uint32", 4}, {"float32", 4}, {"float64", 8}};
  for (const auto& [name, size] : types)
    if (type == name) return size;
  return 0;
}

bool is_integer(const std::string& type) {
  return size_of(type) > 0 && !type.starts_with("float") && type != "double";
}

/// `TYPE NAME` or `list TYPE TYPE NAME`.
std::optional<Property> property_of(std::istringstream& words) {
  Property property;
  std::string type, rest;
  words >> type;
  if (type == "list" && !(words >> property.length_type >> type && is_integer(property.length_type))) return {};
  property.size = size_of(type);
  if (property.size == 0 || !(words >> property.name) || words >> rest) return {};
  return property;
}

std::optional<Encoding> encoding_of(std::istringstream& words) {
  std::string name;
  words >> name;
  if (name == "ascii") return Encoding::text;
  if (name == "binary_little_endian") return Encoding::little_endian;
  if (name == "binary_big_endian") return Encoding::big_endian;
  return {};
}

bool has(const auto& named, const std::string& name) {
  return std::any_of(named.begin(), named.end(), [&](const auto& one) { return one.name == name; });
}

/// Reads up to the first byte after the header.
std::optional<Layout> read_header(std::istream& stream) {
  constexpr int most_lines = 1000;
  Layout layout;
  std::string line;
  bool has_encoding = false;
  if (!std::getline(stream, line) || !line.starts_with("ply")) return {};
  for (int i = 0; i < most_lines && std::getline(stream, line); ++i) {
    std::istringstream words(line);
    std::string first;
    words >> first;
    if (first == "end_header") return has_encoding ? std::optional(std::move(layout)) : std::nullopt;
    if (first == "format") {
      const auto encoding = encoding_of(words);
      if (!encoding || std::exchange(has_encoding, true)) return {};
      layout.encoding = *encoding;
    } else if (first == "element") {
      Element element;
      if (!(words >> element.name >> element.count) || has(layout.elements, element.name)) return {};
      layout.elements.push_back(std::move(element));
    } else if (first == "property") {
      auto property = property_of(words);
      if (!property || layout.elements.empty() || has(layout.elements.back().properties, property->name)) return {};
      layout.elements.back().properties.push_back(std::move(*property));
    } else if (first != "comment" && first != "obj_info") {
      return {};
    }
  }
  return {};
}

/// Whether a line has exactly the values of an element, list entries included.
bool fits(std::string_view line, const Element& element) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  const auto next_word = [&] {
    const auto begin = std::find_if_not(line.begin(), line.end(), is_blank);
    const auto end = std::find_if(begin, line.end(), is_blank);
    const std::string_view word(begin, end);
    line = std::string_view(end, line.end());
    return word;
  };
  for (const Property& property : element.properties) {
    std::uintmax_t values = 1;
    if (!property.length_type.empty()) {
      const std::string_view word = next_word();
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), values);
      if (error != std::errc{} || end != word.data() + word.size() || values > line.size()) return false;
    }
    for (; values > 0; --values)
      if (next_word().empty()) return false;
  }
  return next_word().empty();
}

bool is_whole_text(std::istream& stream, const Layout& layout) {
  std::string line;
  const auto is_empty = [&] { return line.find_first_not_of(" \t\r") == std::string::npos; };
  for (const Element& element : layout.elements)
    for (std::uintmax_t i = 0; i < element.count; ++i) {
      do {
        if (!std::getline(stream, line)) return false;
      } while (is_empty());
      if (!fits(line, element)) return false;
    }
  return true;
}

/// The length of a list, from the bytes that say it; nothing when it is negative.
std::optional<std::uint64_t> length_of(std::array<unsigned char, 8> bytes, const std::string& type, Encoding encoding) {
  const std::size_t size = size_of(type);
  std::uint64_t length = 0;
  const bool is_big_endian = encoding == Encoding::big_endian;
  for (std::size_t i = 0; i < size; ++i) length = length << 8U | bytes[is_big_endian ? i : size - 1 - i];
  const bool has_sign = type.front() != 'u';
  if (has_sign && (bytes[is_big_endian ? 0 : size - 1] & 0x80U) != 0) return {};
  return length;
}

bool is_whole_binary(std::istream& stream, std::uintmax_t rest, const Layout& layout) {
  const auto skip = [&](std::uintmax_t bytes) {
    if (bytes > rest) return false;
    rest -= bytes;
    constexpr std::uintmax_t buffered = 4096;  // below this, seeking costs more than reading
    if (bytes < buffered) return static_cast<bool>(stream.ignore(static_cast<std::streamsize>(bytes)));
    return static_cast<bool>(stream.seekg(static_cast<std::streamoff>(bytes), std::ios::cur));
  };
  for (const Element& element : layout.elements) {
    std::uintmax_t fixed = 0;
    bool has_list = false;
    for (const Property& property : element.properties) {
      has_list = has_list || !property.length_type.empty();
      if (property.length_type.empty()) fixed += property.size;
    }
    if (!has_list) {
      if (fixed > 0 && element.count > rest / fixed) return false;
      if (!skip(fixed * element.count)) return false;
      continue;
    }
    for (std::uintmax_t i = 0; i < element.count; ++i)
      for (const Property& property : element.properties) {
        if (property.length_type.empty()) {
          if (!skip(property.size)) return false;
          continue;
        }
        std::array<unsigned char, 8> bytes{};
        const std::size_t size = size_of(property.length_type);
        if (size > rest || !stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
          return false;
        rest -= size;
        const auto length = length_of(bytes, property.length_type, layout.encoding);
        if (!length || *length > rest / property.size || !skip(*length * property.size)) return false;
      }
  }
  return true;
}

}  // namespace

bool is_whole_ply(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  std::ifstream stream(file, std::ios::binary);
  if (error || !stream) return false;
  const std::optional<Layout> layout = read_header(stream);
  if (!layout) return false;
  const auto is_too_many = [&](const Element& element) { return element.count > size; };
  if (std::any_of(layout->elements.begin(), layout->elements.end(), is_too_many)) return false;
  if (layout->encoding == Encoding::text) return is_whole_text(stream, *layout);
  const auto begin = stream.tellg();
  return begin >= 0 && is_whole_binary(stream, size - static_cast<std::uintmax_t>(begin), *layout);
}

}  // namespace gmis::tools
