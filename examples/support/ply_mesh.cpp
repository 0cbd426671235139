#include "support/ply_mesh.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "support/file_ending.hpp"
#include "support/read_file.hpp"

namespace gmis::tools {

namespace {

/// Thrown by what finds the file broken; `parse_ply` says which file.
struct Broken {
  std::string reason = " is not a PLY file, or is incomplete: export or copy it again";
};

enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };

std::optional<Type> type_of(const std::string& name) {
  constexpr std::pair<std::string_view, Type> types[] = {
      {"char", Type::i8},   {"uchar", Type::u8},   {"short", Type::i16},   {"ushort", Type::u16},
      {"int", Type::i32},   {"uint", Type::u32},   {"float", Type::f32},   {"double", Type::f64},
      {"int8", Type::i8},   {"uint8", Type::u8},   {"int16", Type::i16},   {"uint16", Type::u16},
      {"int32", Type::i32}, {"uint32", Type::u32}, {"float32", Type::f32}, {"float64", Type::f64}};
  for (const auto& [known, type] : types)
    if (name == known) return type;
  return {};
}

std::size_t size_of(Type type) {
  constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

struct Property {
  std::string name;
  Type type = Type::f32;            ///< of the value, or of each entry of a list
  std::optional<Type> length_type;  ///< of a list
};

struct Element {
  std::string name;
  std::uintmax_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { text, little_endian, big_endian };

struct Header {
  std::optional<Encoding> encoding;
  std::vector<Element> elements;
};

bool has(const auto& named, const std::string& name) {
  return std::any_of(named.begin(), named.end(), [&](const auto& one) { return one.name == name; });
}

/// Takes lines off the front of the bytes. They end as the first one does, by \n, \r\n or \r: what
/// comes after the header may begin with any byte.
class Lines {
 public:
  explicit Lines(std::string_view& rest) : rest_(rest) {
    const std::size_t first = rest.find_first_of("\r\n");
    if (first == std::string_view::npos) throw Broken{};
    end_ = rest.substr(first, rest[first] == '\r' && first + 1 < rest.size() && rest[first + 1] == '\n' ? 2 : 1);
  }
  [[nodiscard]] std::string next() {
    const std::size_t length = rest_.find(end_);
    if (length == std::string_view::npos) throw Broken{};
    const std::string line(rest_.substr(0, length));
    rest_.remove_prefix(length + end_.size());
    return line;
  }

 private:
  std::string_view& rest_;
  std::string_view end_;
};

/// `TYPE NAME` or `list TYPE TYPE NAME`.
Property property_of(std::istringstream& words) {
  Property property;
  std::string type, rest;
  words >> type;
  if (type == "list") {
    words >> type;
    property.length_type = type_of(type);
    if (!property.length_type || *property.length_type >= Type::f32) throw Broken{};
    words >> type;
  }
  const auto known = type_of(type);
  if (!known || !(words >> property.name) || words >> rest) throw Broken{};
  property.type = *known;
  return property;
}

Encoding encoding_of(std::istringstream& words) {
  std::string name;
  words >> name;
  if (name == "ascii") return Encoding::text;
  if (name == "binary_little_endian") return Encoding::little_endian;
  if (name == "binary_big_endian") return Encoding::big_endian;
  throw Broken{};
}

/// Takes the header off the bytes.
Header header_of(std::string_view& rest) {
  constexpr int most_lines = 1000;
  Header header;
  Lines lines(rest);
  if (!lines.next().starts_with("ply")) throw Broken{};
  for (int i = 0; i < most_lines; ++i) {
    std::istringstream words(lines.next());
    std::string first;
    words >> first;
    if (first == "end_header") {
      if (!header.encoding) throw Broken{};
      return header;
    }
    if (first == "format") {
      if (header.encoding) throw Broken{};
      header.encoding = encoding_of(words);
    } else if (first == "element") {
      Element element;
      if (!(words >> element.name >> element.count) || has(header.elements, element.name)) throw Broken{};
      header.elements.push_back(std::move(element));
    } else if (first == "property") {
      Property property = property_of(words);
      if (header.elements.empty() || has(header.elements.back().properties, property.name)) throw Broken{};
      header.elements.back().properties.push_back(std::move(property));
    } else if (!first.empty() && first != "comment" && first != "obj_info") {
      throw Broken{};
    }
  }
  throw Broken{};
}

/// Takes numbers off the front of binary data.
class BinaryNumbers {
 public:
  BinaryNumbers(std::string_view rest, bool is_big_endian) : rest_(rest), is_big_endian_(is_big_endian) {}
  void begin_row() {}
  void end_row() {}
  [[nodiscard]] std::size_t bytes_left() const { return rest_.size(); }
  [[nodiscard]] std::size_t most_numbers_left(Type type) const { return rest_.size() / size_of(type); }
  double next(Type type) {
    switch (type) {
      case Type::i8:
        return static_cast<std::int8_t>(raw<std::uint8_t>());
      case Type::u8:
        return raw<std::uint8_t>();
      case Type::i16:
        return static_cast<std::int16_t>(raw<std::uint16_t>());
      case Type::u16:
        return raw<std::uint16_t>();
      case Type::i32:
        return static_cast<std::int32_t>(raw<std::uint32_t>());
      case Type::u32:
        return raw<std::uint32_t>();
      case Type::f32:
        return static_cast<double>(std::bit_cast<float>(raw<std::uint32_t>()));
      case Type::f64:
        return std::bit_cast<double>(raw<std::uint64_t>());
    }
    throw Broken{};
  }

 private:
  template <class Word>
  Word raw() {
    if (rest_.size() < sizeof(Word)) throw Broken{};
    Word word = 0;
    for (std::size_t i = 0; i < sizeof(Word); ++i) {
      const auto byte = static_cast<unsigned char>(rest_[is_big_endian_ ? i : sizeof(Word) - 1 - i]);
      word = static_cast<Word>(static_cast<std::uint64_t>(word) << 8U | byte);
    }
    rest_.remove_prefix(sizeof(Word));
    return word;
  }
  std::string_view rest_;
  bool is_big_endian_;
};

/// Takes numbers off the front of text, whose rows are lines.
class TextNumbers {
 public:
  explicit TextNumbers(std::string_view rest) : rest_(rest) {}
  void begin_row() {
    do {
      if (rest_.empty()) throw Broken{};
      const std::size_t length = std::min(rest_.find('\n'), rest_.size());
      line_ = rest_.substr(0, length);
      rest_.remove_prefix(std::min(length + 1, rest_.size()));
      skip_blanks();
    } while (line_.empty());
  }
  void end_row() {
    skip_blanks();
    if (!line_.empty()) throw Broken{};
  }
  [[nodiscard]] std::size_t bytes_left() const { return rest_.size(); }
  [[nodiscard]] std::size_t most_numbers_left(Type) const { return line_.size(); }
  double next(Type) {
    skip_blanks();
    const std::size_t length = std::min(line_.find_first_of(" \t\r"), line_.size());
    std::string_view word = line_.substr(0, length);
    line_.remove_prefix(length);
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || end != word.data() + word.size()) throw Broken{};
    if (error == std::errc{}) return value;
    if (word.find("e-") == std::string_view::npos && word.find("E-") == std::string_view::npos) throw Broken{};
    return 0;  // too small for a double
  }

 private:
  void skip_blanks() { line_.remove_prefix(std::min(line_.find_first_not_of(" \t\r"), line_.size())); }
  std::string_view rest_, line_;
};

/// The meaning of a property of a vertex.
enum class Role { x, y, z, nx, ny, nz, u, v, none };

Role role_of(const std::string& name) {
  constexpr std::pair<std::string_view, Role> roles[] = {
      {"x", Role::x},         {"y", Role::y},         {"z", Role::z},         {"nx", Role::nx},      {"ny", Role::ny},
      {"nz", Role::nz},       {"u", Role::u},         {"v", Role::v},         {"s", Role::u},        {"t", Role::v},
      {"texture_u", Role::u}, {"texture_v", Role::v}, {"texture_s", Role::u}, {"texture_t", Role::v}};
  for (const auto& [known, role] : roles)
    if (name == known) return role;
  return Role::none;
}

/// Memory that is counted for one mesh.
struct Memory {
  LoadBudget& budget;
  const std::string& name;
  const SourcePosition& where;
  void take(std::uintmax_t count, std::uintmax_t bytes_each) const { budget.take(count, bytes_each, name, where); }
};

/// Memory of one triangle while it is read.
constexpr std::uintmax_t bytes_of_face = 44;

/// The entries of a list, which takes them from `numbers`.
template <class Numbers>
void read_list(const Property& property, Numbers& numbers, std::vector<double>& entries, const Memory& memory) {
  const double length = numbers.next(*property.length_type);
  if (!(length >= 0) || length != std::floor(length) ||
      length > static_cast<double>(numbers.most_numbers_left(property.type)))
    throw Broken{};
  entries.clear();
  const auto size = static_cast<std::size_t>(length);
  if (size > entries.capacity()) {
    memory.take(size, sizeof(double));
    entries.reserve(size);
  }
  for (std::size_t i = 0; i < size; ++i) entries.push_back(numbers.next(property.type));
}

template <class Numbers>
void read_vertices(const Element& element, Numbers& numbers, MeshDescription& mesh, const Memory& memory) {
  std::vector<Role> roles;
  for (const Property& property : element.properties)
    roles.push_back(property.length_type ? Role::none : role_of(property.name));
  const auto has_role = [&](Role role) { return std::find(roles.begin(), roles.end(), role) != roles.end(); };
  const bool has_normals = has_role(Role::nx) && has_role(Role::ny) && has_role(Role::nz);
  const bool has_uv = has_role(Role::u) && has_role(Role::v);
  std::vector<double> list;
  for (std::uintmax_t i = 0; i < element.count; ++i) {
    std::array<double, 9> values{};
    numbers.begin_row();
    for (std::size_t p = 0; p < roles.size(); ++p) {
      if (element.properties[p].length_type)
        read_list(element.properties[p], numbers, list, memory);
      else
        values[static_cast<std::size_t>(roles[p])] = numbers.next(element.properties[p].type);
    }
    numbers.end_row();
    mesh.positions.emplace_back(values[0], values[1], values[2]);
    if (has_normals) mesh.normals.emplace_back(values[3], values[4], values[5]);
    if (has_uv) mesh.uv.emplace_back(values[6], values[7]);
  }
}

/// A triangle of a face; faces are counted from 0.
struct FacePart {
  std::uintmax_t face;
  std::array<double, 3> corners;
};

template <class Numbers>
void read_faces(const Element& element, Numbers& numbers, std::vector<FacePart>& faces, const Memory& memory) {
  std::vector<double> list;
  for (std::uintmax_t i = 0; i < element.count; ++i) {
    numbers.begin_row();
    for (const Property& property : element.properties) {
      if (!property.length_type) {
        (void)numbers.next(property.type);
        continue;
      }
      read_list(property, numbers, list, memory);
      if (property.name != "vertex_indices" && property.name != "vertex_index") continue;
      if (list.size() > 3) memory.take(list.size() - 3, bytes_of_face);  // the first one is counted
      for (std::size_t k = 2; k < list.size(); ++k) faces.push_back({i, {list[0], list[k - 1], list[k]}});
    }
    numbers.end_row();
  }
}

template <class Numbers>
MeshDescription mesh_of(const Header& header, Numbers numbers, const std::string& name, LoadBudget& budget,
                        const SourcePosition& where) {
  MeshDescription mesh;
  const Memory memory{budget, name, where};
  std::vector<FacePart> faces;
  for (const Element& element : header.elements) {
    const bool is_vertex = element.name == "vertex", is_empty = element.properties.empty();
    if (element.count > numbers.bytes_left() && !is_empty) throw Broken{};
    if (is_empty) continue;
    memory.take(element.count, is_vertex ? 64 : bytes_of_face);
    if (is_vertex)
      read_vertices(element, numbers, mesh, memory);
    else
      read_faces(element, numbers, faces, memory);
  }
  mesh.triangles.reserve(faces.size());
  for (const auto& [face, given] : faces) {
    std::array<int, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(given[k] >= 0 && given[k] < static_cast<double>(mesh.positions.size()) && given[k] == std::floor(given[k])))
        throw Broken{": its face " + std::to_string(face) +
                     " (counted from 0) refers to a vertex that is not there, of " +
                     std::to_string(mesh.positions.size()) + ": export it again"};
      corners[k] = static_cast<int>(given[k]);
    }
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

}  // namespace

MeshDescription parse_ply(std::string_view bytes, const std::string& name, LoadBudget& budget,
                          const SourcePosition& where) {
  try {
    std::string_view rest = bytes;
    const Header header = header_of(rest);
    MeshDescription mesh =
        *header.encoding == Encoding::text
            ? mesh_of(header, TextNumbers(rest), name, budget, where)
            : mesh_of(header, BinaryNumbers(rest, *header.encoding == Encoding::big_endian), name, budget, where);
    const bool is_finite = std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const Point& p) {
      return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    });
    if (!is_finite) throw Broken{" has a coordinate that is no number: export it again"};
    if (mesh.triangles.empty())
      throw Broken{" holds no triangle: export it with its faces (element face, list vertex_indices)"};
    return mesh;
  } catch (const Broken& broken) {
    throw InputError(where, name + broken.reason);
  }
}

MeshDescription read_ply(const std::filesystem::path& file, LoadBudget& budget, const SourcePosition& where) {
  const std::string name = "the mesh " + file_in_quotes(file.string());
  std::string bytes = read_file(file, "the mesh", budget, where);
  if (ending_of(file) == ".gz") bytes = unpacked_gzip(bytes, name, budget, where);
  return parse_ply(bytes, name, budget, where);
}

}  // namespace gmis::tools
