#include "support/gltf/document.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

#include "support/read_file.hpp"

#if GMIS_HAS_MESHOPT
#include <meshoptimizer.h>
#endif

namespace gmis::tools::gltf {
namespace {

constexpr double most_bytes = 1e15;
constexpr std::size_t nowhere = std::size_t{1} << 50U;  ///< a number that no list has

/// How deep brackets are nested, strings left out.
int depth_of(std::string_view json) {
  int depth = 0, deepest = 0;
  bool is_text = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (is_text) {
      if (c == '\\') ++i;
      if (c == '"') is_text = false;
    } else if (c == '"') {
      is_text = true;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest;
}

/// The message of the library in one short line, with the place of a number that is too large,
/// which the library leaves out.
std::string reason_of(const Json::exception& thrown, std::string_view json) {
  constexpr std::size_t longest = 150;
  std::string reason = thrown.what();
  if (const auto bracket = reason.find("] "); bracket != std::string::npos) reason = reason.substr(bracket + 2);
  if (const std::size_t open = reason.find('\''); reason.starts_with("number overflow") && open != std::string::npos) {
    const std::string number = reason.substr(open + 1, reason.find('\'', open + 1) - open - 1);
    if (const std::size_t place = json.find(number); !number.empty() && place != std::string_view::npos) {
      const std::string_view before = json.substr(0, place);
      const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
      reason = "the number at line " + std::to_string(1 + std::count(before.begin(), before.end(), '\n')) +
               ", column " + std::to_string(1 + place - line_start) + " is too large: write one below 1e308";
    }
  }
  std::string result;
  for (const char c : reason.substr(0, longest)) result += (c >= ' ' && c < '\x7f') ? c : c == '\n' ? ' ' : '?';
  return result + (reason.size() > longest ? "…" : "");
}

std::uint32_t word_at(std::string_view bytes, std::size_t offset) {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i-- > 0;) word = word << 8U | static_cast<unsigned char>(bytes[offset + i]);
  return word;
}

/// %20 and its like resolved.
std::string unescaped(const std::string& uri) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned char code = 0;
    const bool is_escape = uri[i] == '%' && i + 2 < uri.size() &&
                           std::from_chars(&uri[i + 1], &uri[i + 1] + 2, code, 16).ptr == &uri[i + 1] + 2;
    name += is_escape ? static_cast<char>(code) : uri[i];
    if (is_escape) i += 2;
  }
  return name;
}

std::optional<std::string> from_base64(std::string_view text) {
  std::array<int, 256> values{};
  values.fill(-1);
  const std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < letters.size(); ++i) values[static_cast<unsigned char>(letters[i])] = static_cast<int>(i);
  values['-'] = 62;
  values['_'] = 63;
  std::string result;
  result.reserve(text.size() / 4 * 3);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    if (c == '\n' || c == '\r' || c == ' ') continue;
    const int value = values[static_cast<unsigned char>(c)];
    if (value < 0) return {};
    bits = (bits << 6U | static_cast<std::uint32_t>(value)) & 0xFFFFFFU;
    if ((count += 6) >= 8) {
      count -= 8;
      result += static_cast<char>(bits >> static_cast<unsigned>(count) & 0xFFU);
    }
  }
  return result;
}

struct ComponentType {
  std::size_t size;
  double largest;  ///< of a normalised integer
};
std::optional<ComponentType> component_of(double code) {
  switch (static_cast<int>(code)) {
    case 5120:
      return ComponentType{1, 127};
    case 5121:
      return ComponentType{1, 255};
    case 5122:
      return ComponentType{2, 32767};
    case 5123:
      return ComponentType{2, 65535};
    case 5125:
      return ComponentType{4, 4294967295.0};
    case 5126:
      return ComponentType{4, 1};
    default:
      return {};
  }
}

double value_at(const char* place, int code) {
  const auto as = [&](auto value) {
    std::memcpy(&value, place, sizeof value);
    return static_cast<double>(value);
  };
  switch (code) {
    case 5120:
      return as(std::int8_t{});
    case 5121:
      return as(std::uint8_t{});
    case 5122:
      return as(std::int16_t{});
    case 5123:
      return as(std::uint16_t{});
    case 5125:
      return as(std::uint32_t{});
    default:
      return as(float{});
  }
}

}  // namespace

Document::Document(const std::filesystem::path& file, LoadBudget& budget,
                   std::function<void(const std::filesystem::path&)> used)
    : Document(read_file(file, "the file", budget, {std::make_shared<const std::string>(file.string()), 0}), file,
               budget, std::move(used)) {}

Document::Document(std::string bytes, const std::filesystem::path& file, LoadBudget& budget,
                   std::function<void(const std::filesystem::path&)> used)
    : file_(file),
      where_{std::make_shared<const std::string>(file.string()), 0},
      budget_(budget),
      used_(std::move(used)) {
  parse(std::move(bytes));
}

void Document::parse(std::string bytes) {
  std::string_view json = bytes;
  constexpr std::size_t header = 12, chunk_header = 8;
  if (bytes.starts_with("glTF")) {
    if (bytes.size() < header + chunk_header) throw error("this .glb file ends too early");
    if (word_at(bytes, 4) != 2)
      throw error("this is a file of glTF " + std::to_string(word_at(bytes, 4)) + ": only glTF 2.0 is read");
    const std::size_t length = word_at(bytes, header);
    if (word_at(bytes, header + 4) != 0x4E4F534AU || length > bytes.size() - header - chunk_header)
      throw error("this .glb file ends too early, or does not begin with JSON");
    json = json.substr(header + chunk_header, length);
    const std::size_t next = header + chunk_header + (length + 3) / 4 * 4;
    if (next + chunk_header <= bytes.size() && word_at(bytes, next + 4) == 0x004E4942U)
      chunk_ = bytes.substr(next + chunk_header, word_at(bytes, next));
  } else {
    if (json.starts_with("\xEF\xBB\xBF")) json.remove_prefix(3);
    const std::size_t first = json.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos || json[first] != '{')
      throw error("this is no glTF file: it begins with neither \"{\" nor the mark of a .glb file");
  }
  constexpr int deepest = 256;
  if (depth_of(json) > deepest) throw error("its JSON is nested more than 256 deep");
  budget_.take(json.size(), 24, "the JSON of this file", where_);
  try {
    json_ = Json::parse(json);
  } catch (const Json::exception& thrown) {
    throw error("its JSON cannot be read: " + reason_of(thrown, json));
  }
  if (!json_.is_object()) throw error("this is no glTF file: its JSON is no object");
  const Json& stated = member(member(json_, "asset"), "version");  // a number in some files of 1.0
  const std::string version = stated.is_number() ? stated.dump() : text(member(json_, "asset"), "version");
  if (version.starts_with("1.") || member(json_, "techniques").is_object())
    throw error("this is a file of glTF 1.0: convert it to glTF 2.0");
  if (!version.starts_with("2.")) throw error("this file names no version of glTF: \"asset\" must hold \"version\"");
}

const Json& Document::member(const Json& object, const char* name) {
  static const Json nothing;
  if (!object.is_object()) return nothing;
  const auto found = object.find(name);
  return found == object.end() ? nothing : *found;
}

const Json& Document::extension(const Json& object, const char* name) {
  return member(member(object, "extensions"), name);
}

double Document::number(const Json& object, const char* name, double otherwise) const {
  const Json& found = member(object, name);
  if (found.is_null()) return otherwise;
  if (!found.is_number()) throw error(std::string(name) + " must be a number");
  return found.get<double>();
}

std::string Document::text(const Json& object, const char* name, const std::string& otherwise) const {
  const Json& found = member(object, name);
  if (found.is_null()) return otherwise;
  if (!found.is_string()) throw error(std::string(name) + " must be text");
  return found.get<std::string>();
}

std::vector<double> Document::numbers(const Json& object, const char* name, std::vector<double> otherwise) const {
  const Json& found = member(object, name);
  if (found.is_null()) return otherwise;
  const auto refuse = [&] {
    return error(std::string(name) + " must be a list of " + std::to_string(otherwise.size()) + " numbers");
  };
  if (!found.is_array() || found.size() != otherwise.size()) throw refuse();
  for (std::size_t i = 0; i < otherwise.size(); ++i) {
    if (!found[i].is_number()) throw refuse();
    otherwise[i] = found[i].get<double>();
  }
  return otherwise;
}

std::optional<std::size_t> Document::index(const Json& object, const char* name, const std::string& owner) const {
  const Json& found = member(object, name);
  if (found.is_null()) return {};
  const double value = found.is_number() ? found.get<double>() : -1;
  if (!(value >= 0 && value < most_bytes && value == std::floor(value)))
    throw error((owner.empty() ? "" : owner + ": ") + name + " must be a whole number of at least 0");
  return static_cast<std::size_t>(value);
}

std::size_t Document::count(const char* list) const {
  const Json& found = member(json_, list);
  return found.is_array() ? found.size() : 0;
}

const Json& Document::entry(const char* list, std::size_t number, const std::string& owner) const {
  const std::string start = owner.empty() ? "" : owner + ": ";
  if (number >= nowhere) throw error(start + "it names none of \"" + list + "\": add its number");
  if (number >= count(list))
    throw error(start + "number " + std::to_string(number) + " of \"" + list + "\" is not there: there are " +
                std::to_string(count(list)) + ", counted from 0");
  return member(json_, list)[number];
}

std::string Document::named(const char* kind, const Json& object, std::size_t number) const {
  const Json& name = member(object, "name");
  return std::string(kind) + " " +
         (name.is_string() && !name.get<std::string>().empty() ? in_quotes(name.get<std::string>())
                                                               : std::to_string(number));
}

std::string Document::content(const std::string& uri, const std::string& what) const {
  if (uri.starts_with("data:")) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string::npos || uri.substr(0, comma).find(";base64") == std::string::npos)
      throw error(what + " has data that are not base64");
    budget_.take(uri.size(), what, where_);
    auto bytes = from_base64(std::string_view(uri).substr(comma + 1));
    if (!bytes) throw error(what + " has data that are not base64");
    return std::move(*bytes);
  }
  const std::filesystem::path name(unescaped(uri)), plain = name.lexically_normal();
  if (uri.find("://") != std::string::npos) throw error(what + " is a network address: copy the file beside this one");
  if (name.is_absolute() || plain.begin() == plain.end() || *plain.begin() == "..")
    throw error(what + " names " + file_in_quotes(uri) + ", which is outside the folder of this file");
  const std::filesystem::path file = file_.parent_path() / name;
  std::string bytes = read_file(file, what, budget_, where_);
  used_(file);
  return bytes;
}

const std::string& Document::buffer(std::size_t number, const std::string& owner) const {
  if (const auto found = buffers_.find(number); found != buffers_.end()) return found->second;
  const Json& json = entry("buffers", number, owner);
  const std::string what = "buffer " + std::to_string(number);
  if (const std::string uri = text(json, "uri"); !uri.empty()) return buffers_[number] = content(uri, what);
  if (number != 0 || !chunk_) throw error(what + " has no data: neither a uri nor a binary part of a .glb file");
  return buffers_[number] = *chunk_;
}

std::string_view Document::part(std::size_t number, double offset, double length, const std::string& what) const {
  const std::string& bytes = buffer(number, what);
  if (!(offset >= 0 && length >= 0 && offset + length <= static_cast<double>(bytes.size())))
    throw error(what + " goes beyond the end of its buffer");
  return std::string_view(bytes).substr(static_cast<std::size_t>(offset), static_cast<std::size_t>(length));
}

std::string_view Document::view(std::size_t number, const std::string& owner) const {
  const Json& json = entry("bufferViews", number, owner);
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
    if (const Json& packed = extension(json, name); packed.is_object()) return unpacked_view(number, packed);
  const std::string what = "buffer view " + std::to_string(number);
  return part(index(json, "buffer", what).value_or(nowhere), this->number(json, "byteOffset", 0),
              this->number(json, "byteLength", -1), what);
}

#if GMIS_HAS_MESHOPT

const std::string& Document::unpacked_view(std::size_t number, const Json& packed) const {
  if (const auto found = unpacked_.find(number); found != unpacked_.end()) return found->second;
  const std::string what = "buffer view " + std::to_string(number);
  const std::string_view data =
      part(index(packed, "buffer", what).value_or(nowhere), this->number(packed, "byteOffset", 0),
           this->number(packed, "byteLength", -1), what);
  const std::size_t count = index(packed, "count", what).value_or(0),
                    stride = index(packed, "byteStride", what).value_or(0);
  if (count == 0 || stride == 0 || stride > 256) throw error(what + " has a wrong count or stride");
  budget_.take(count, stride, what, where_);
  const std::string mode = text(packed, "mode"), filter = text(packed, "filter", "NONE");
  std::string bytes(count * stride, '\0');
  const auto* from = reinterpret_cast<const unsigned char*>(data.data());
  int code = -1;
  if (mode == "ATTRIBUTES" && stride % 4 == 0)
    code = meshopt_decodeVertexBuffer(bytes.data(), count, stride, from, data.size());
  else if (mode == "TRIANGLES" && count % 3 == 0 && (stride == 2 || stride == 4))
    code = meshopt_decodeIndexBuffer(bytes.data(), count, stride, from, data.size());
  else if (mode == "INDICES" && (stride == 2 || stride == 4))
    code = meshopt_decodeIndexSequence(bytes.data(), count, stride, from, data.size());
  if (code != 0) throw error(what + " cannot be unpacked by the library meshoptimizer");
  if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
    meshopt_decodeFilterOct(bytes.data(), count, stride);
  else if (filter == "QUATERNION" && stride == 8)
    meshopt_decodeFilterQuat(bytes.data(), count, stride);
  else if (filter == "EXPONENTIAL" && stride % 4 == 0)
    meshopt_decodeFilterExp(bytes.data(), count, stride);
  else if (filter != "NONE")
    throw error(what + " has an unknown filter");
  return unpacked_[number] = std::move(bytes);
}

#else

const std::string& Document::unpacked_view(std::size_t number, const Json&) const {
  throw error("buffer view " + std::to_string(number) +
              " is packed, and this program was built without the library meshoptimizer");
}

#endif

std::size_t Document::components_of(std::size_t number, const std::string& owner) const {
  const std::string type = text(entry("accessors", number, owner), "type");
  for (const auto& [name, count] : {std::pair{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}})
    if (type == name) return static_cast<std::size_t>(count);
  throw error("accessor " + std::to_string(number) + " has a type that is not supported");
}

void Document::read_values(std::vector<double>& result, const Json& accessor, std::string_view data, std::size_t stride,
                           std::size_t offset, std::size_t count, std::size_t components,
                           const std::string& what) const {
  const double code = number(accessor, "componentType", 0);
  const auto type = component_of(code);
  if (!type) throw error(what + " has a component type that is not known");
  const std::size_t element = type->size * components, step = stride == 0 ? element : stride;
  if (offset > data.size() || count > data.size() || step > data.size() ||
      (count > 0 && (count - 1) * step + element > data.size() - offset))
    throw error(what + " goes beyond the end of its data");
  const Json& normalized = member(accessor, "normalized");
  const bool is_normalized = normalized.is_boolean() && normalized.get<bool>() && code != 5126;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < components; ++c) {
      const double value = value_at(data.data() + offset + i * step + c * type->size, static_cast<int>(code));
      result.push_back(is_normalized ? std::max(value / type->largest, -1.0) : value);
    }
}

std::vector<double> Document::accessor(std::size_t number, std::size_t components, const std::string& owner) const {
  const std::string what = "accessor " + std::to_string(number);
  const Json& json = entry("accessors", number, owner);
  if (components_of(number) != components) throw error(what + " has the wrong type");
  const std::size_t count = index(json, "count", what).value_or(0);
  budget_.take(count, components * sizeof(double), what, where_);
  std::vector<double> result;
  if (const auto found = index(json, "bufferView", what)) {
    const Json& view_json = entry("bufferViews", *found, what);
    const std::size_t offset = index(json, "byteOffset", what).value_or(0),
                      stride = index(view_json, "byteStride", what).value_or(0);
    read_values(result, json, view(*found, what), stride, offset, count, components, what);
  } else {
    result.assign(count * components, 0.0);
  }
  if (member(json, "sparse").is_object()) replace_sparse(result, json, components, what);
  for (const double value : result)
    if (!std::isfinite(value)) throw error(what + " has a value that is no number");
  return result;
}

void Document::replace_sparse(std::vector<double>& result, const Json& accessor, std::size_t components,
                              const std::string& what) const {
  const Json& sparse = member(accessor, "sparse");
  const Json &places = member(sparse, "indices"), &values = member(sparse, "values");
  const std::size_t count = index(sparse, "count", what).value_or(0);
  budget_.take(count, (components + 1) * sizeof(double), what, where_);
  std::vector<double> numbers, replaced;
  const auto view_of = [&](const Json& json) { return view(index(json, "bufferView", what).value_or(nowhere), what); };
  read_values(numbers, places, view_of(places), 0, index(places, "byteOffset", what).value_or(0), count, 1, what);
  Json of_values = accessor;
  read_values(replaced, of_values, view_of(values), 0, index(values, "byteOffset", what).value_or(0), count, components,
              what);
  for (std::size_t i = 0; i < count; ++i) {
    if (!(numbers[i] >= 0 && numbers[i] * static_cast<double>(components) < static_cast<double>(result.size())))
      throw error(what + " replaces a value that is not there");
    std::copy_n(replaced.begin() + static_cast<std::ptrdiff_t>(i * components), components,
                result.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(numbers[i]) * components));
  }
}

Document::ImageFile Document::image(std::size_t number) const {
  const Json& json = entry("images", number);
  const std::string uri = text(json, "uri");
  std::string name = text(json, "name", "number " + std::to_string(number));
  if (!uri.empty()) {
    if (!uri.starts_with("data:")) name = uri;
    return {name, content(uri, "the image")};
  }
  const std::string what = "image " + std::to_string(number);
  const auto found = index(json, "bufferView", what);
  if (!found) throw error(what + " has neither a uri nor data");
  const std::string_view bytes = view(*found, what);
  budget_.take(bytes.size(), "the image " + in_quotes(name), where_);
  return {name, std::string(bytes)};
}

}  // namespace gmis::tools::gltf
