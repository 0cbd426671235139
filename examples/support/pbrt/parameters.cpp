#include "support/pbrt/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "support/pbrt/spectra.hpp"

namespace gmis::tools::pbrt {

namespace {

std::string counted(std::size_t count, const std::string& thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

}  // namespace

bool is_parameter_type(const std::string& type) {
  static constexpr std::array known{"integer", "float",   "point2",   "vector2", "point3",    "vector3",
                                    "point",   "vector",  "normal3",  "normal",  "bool",      "string",
                                    "rgb",     "texture", "spectrum", "color",   "blackbody", "point4"};
  return std::find(known.begin(), known.end(), type) != known.end();
}

bool Parameter::is_of(std::initializer_list<const char*> types) const {
  return std::any_of(types.begin(), types.end(), [this](const char* t) { return type == t; });
}

Parameter* Parameters::find(const std::string& name) {
  for (Parameter& parameter : parameters_) {
    if (parameter.name != name) continue;
    parameter.is_used = true;
    return &parameter;
  }
  return nullptr;
}

bool Parameters::has(const std::string& name) const {
  return std::any_of(parameters_.begin(), parameters_.end(), [&](const Parameter& p) { return p.name == name; });
}

bool Parameters::is_spectrum(const std::string& name) const {
  return std::any_of(parameters_.begin(), parameters_.end(), [&](const Parameter& p) {
    return p.name == name && p.is_of({"spectrum", "rgb", "color"});
  });
}

void Parameters::fail(const std::string& name, const std::string& message) const {
  for (const Parameter& parameter : parameters_)
    if (parameter.name == name) throw InputError(parameter.where, "parameter " + in_quotes(name) + " " + message);
  throw InputError(where_, directive_ + ": parameter " + in_quotes(name) + " " + message);
}

const SourcePosition& Parameters::where(const std::string& name) const {
  for (const Parameter& parameter : parameters_)
    if (parameter.name == name) return parameter.where;
  return where_;
}

void Parameters::unsupported(const std::string& name, const std::string& message, Diagnostics& diagnostics) const {
  diagnostics.unsupported(where(name), directive_ + ": parameter " + in_quotes(name) + " " + message);
}

void Parameters::require_type(const Parameter& parameter, std::initializer_list<const char*> types) const {
  if (parameter.is_of(types)) return;
  std::string wanted;
  for (const char* type : types) wanted += (wanted.empty() ? "" : " or ") + std::string(type);
  fail(parameter.name, "has type " + in_quotes(parameter.type) + ": declare it as " + wanted);
}

void Parameters::require_count(const Parameter& parameter, std::size_t count) const {
  const std::size_t found = std::max(parameter.numbers.size(), parameter.strings.size());
  if (found == count) return;
  std::string message = "has " + counted(found, "value") + ": give it " + std::to_string(count);
  if (count == 3 && parameter.is_of({"rgb", "color"})) message += ", as in [ .5 .5 .5 ]";
  fail(parameter.name, message);
}

std::optional<double> Parameters::number(const std::string& name) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  if (parameter->type == "texture") {
    const TextureHandle& found = texture(*parameter, false);
    if (!found->is_constant())
      unsupported(name, "varies over the surface, which is not supported here: its mean is used", *diagnostics_);
    return found->mean().x;
  }
  require_type(*parameter, {"float", "integer"});
  require_count(*parameter, 1);
  return parameter->numbers[0];
}

std::optional<int> Parameters::integer(const std::string& name) {
  const std::vector<int> values = integers(name);
  if (!has(name)) return {};
  if (values.size() != 1) fail(name, "has " + counted(values.size(), "value") + ": give it 1");
  return values[0];
}

std::vector<int> Parameters::integers(const std::string& name) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  require_type(*parameter, {"integer"});
  std::vector<int> result;
  result.reserve(parameter->numbers.size());
  for (const double value : parameter->numbers) {
    if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max())
      fail(name, "needs whole numbers below 2^31");
    result.push_back(static_cast<int>(value));
  }
  return result;
}

std::vector<double> Parameters::numbers(const std::string& name) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  require_type(*parameter, {"float", "integer"});
  return parameter->numbers;
}

bool Parameters::boolean_or(const std::string& name, bool otherwise) {
  const Parameter* parameter = find(name);
  if (!parameter) return otherwise;
  require_type(*parameter, {"bool"});
  if (parameter->strings.size() != 1 || (parameter->strings[0] != "true" && parameter->strings[0] != "false"))
    fail(name, "must be true or false");
  return parameter->strings[0] == "true";
}

std::vector<std::string> Parameters::strings(const std::string& name) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  require_type(*parameter, {"string"});
  return parameter->strings;
}

std::optional<std::string> Parameters::string(const std::string& name) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  require_type(*parameter, {"string"});
  if (parameter->strings.size() != 1) fail(name, "must be one string in quotation marks");
  return parameter->strings[0];
}

std::vector<Point> Parameters::triples(const std::string& name, std::initializer_list<const char*> types) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  require_type(*parameter, types);
  if (parameter->numbers.size() % 3 != 0)
    fail(name, "has " + std::to_string(parameter->numbers.size()) + " numbers: they must come in threes");
  std::vector<Point> result;
  result.reserve(parameter->numbers.size() / 3);
  for (std::size_t i = 0; i < parameter->numbers.size(); i += 3)
    result.emplace_back(parameter->numbers[i], parameter->numbers[i + 1], parameter->numbers[i + 2]);
  return result;
}

std::optional<Point> Parameters::point(const std::string& name) {
  const std::vector<Point> values = triples(name, {"point3", "point", "vector3", "vector"});
  if (!has(name)) return {};
  if (values.size() != 1) fail(name, "must be one point: three numbers");
  return values[0];
}

std::vector<Point> Parameters::points(const std::string& name) {
  return triples(name, {"point3", "point"});
}

std::vector<Point> Parameters::normals(const std::string& name) {
  return triples(name, {"normal", "normal3", "vector3", "vector"});
}

const TextureHandle& Parameters::texture(const Parameter& parameter, bool is_color) const {
  require_count(parameter, 1);
  const auto& textures = is_color ? textures_->colors : textures_->numbers;
  const auto& others = is_color ? textures_->numbers : textures_->colors;
  const auto found = textures.find(parameter.strings[0]);
  if (found != textures.end()) return found->second;
  const std::string type = is_color ? "spectrum" : "float", other = is_color ? "float" : "spectrum";
  const std::string quoted = in_quotes(parameter.strings[0]);
  if (others.contains(parameter.strings[0]))
    fail(parameter.name, "needs a " + type + " texture, but " + quoted + " is a " + other +
                             " texture: add one of type \"" + type + "\"");
  fail(parameter.name, "uses the " + type + " texture " + quoted + ", which is not defined above it: add Texture " +
                           quoted + " \"" + type + "\"");
}

bool Parameters::varies(const std::string& name) const {
  for (const Parameter& parameter : parameters_) {
    if (parameter.name != name || parameter.type != "texture" || parameter.strings.size() != 1) continue;
    for (const auto* textures : {&textures_->numbers, &textures_->colors})
      if (const auto found = textures->find(parameter.strings[0]); found != textures->end())
        return !found->second->is_constant();
  }
  return false;
}

std::optional<TextureHandle> Parameters::number_texture(const std::string& name) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  if (parameter->type == "texture") return texture(*parameter, false);
  return scene::Texture<float>::constant(glm::dvec3(*number(name)));
}

std::optional<TextureHandle> Parameters::color_texture(const std::string& name) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  if (parameter->type == "texture") return texture(*parameter, true);
  return scene::Texture<float>::constant(*color(name));
}

std::optional<Rgb> Parameters::color(const std::string& name, SpectrumOf of) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  if (parameter->type == "texture") {
    const TextureHandle& found = texture(*parameter, true);
    if (!found->is_constant())
      unsupported(name, "varies over the surface, which is not supported here: its mean is used", *diagnostics_);
    return found->mean();
  }
  require_type(*parameter, {"rgb", "spectrum", "color", "blackbody"});
  if (parameter->type == "spectrum") return spectrum(*parameter, of);
  if (parameter->type == "blackbody") {
    if (parameter->numbers.size() != 1 && parameter->numbers.size() != 2)
      fail(name, "must be a temperature in kelvins, and perhaps a factor");
    const double kelvins = parameter->numbers[0];
    if (!(kelvins >= 500 && kelvins <= 1e6)) fail(name, "must be a temperature from 500 to 1000000 kelvins");
    return blackbody(kelvins) * (parameter->numbers.size() == 2 ? parameter->numbers[1] : 1.0);
  }
  require_count(*parameter, 3);
  const Rgb given(parameter->numbers[0], parameter->numbers[1], parameter->numbers[2]);
  if (to_srgb_ == glm::dmat3(1)) return given;
  // Channels of a colour outside the sRGB gamut are cut to 0; a colour that is given with a
  // negative channel stays an error.
  const Rgb value = to_srgb_ * given;
  return glm::min(given.x, glm::min(given.y, given.z)) < 0 ? value : glm::max(value, Rgb(0));
}

Rgb Parameters::spectrum(const Parameter& parameter, SpectrumOf of) const {
  std::vector<double> pairs = parameter.numbers;
  if (!parameter.strings.empty()) {
    require_count(parameter, 1);
    const std::string& name = parameter.strings[0];
    if (const std::optional<Rgb> known = named_spectrum(name)) return *known;
    const auto read = textures_->find ? read_spectrum(textures_->find(name)) : std::nullopt;
    if (!read)
      fail(parameter.name, "names the spectrum " + in_quotes(name) +
                               ", which is not known and no file of pairs: known are " + known_spectra());
    pairs = *read;
  }
  if (pairs.size() < 2 || pairs.size() % 2 != 0) fail(parameter.name, "must list pairs of wavelength and value");
  if (pairs.size() == 2) fail(parameter.name, "has one pair: give it two or more, as in [ 400 .5 700 .5 ]");
  bool is_constant = true;
  for (std::size_t i = 0; i < pairs.size(); i += 2) {
    if (!std::isfinite(pairs[i]) || !std::isfinite(pairs[i + 1])) fail(parameter.name, "has a value that is no number");
    if (pairs[i + 1] < 0) fail(parameter.name, "has a negative value: use values of at least 0");
    is_constant = is_constant && pairs[i + 1] == pairs[1];
    if (i > 0 && !(pairs[i] > pairs[i - 2])) fail(parameter.name, "must list its wavelengths from low to high");
  }
  constexpr double from_violet = 400, to_red = 700;
  if (is_constant && pairs[0] <= from_violet && pairs[pairs.size() - 2] >= to_red)
    return pairs[1] * rgb_of_constant(of);
  return in_gamut(rgb_of_spectrum(pairs, of));
}

std::vector<glm::dvec2> Parameters::pairs(const std::string& name) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  require_type(*parameter, {"point2", "vector2", "float"});
  if (parameter->numbers.size() % 2 != 0)
    fail(name, "has " + std::to_string(parameter->numbers.size()) + " numbers: they must come in twos");
  std::vector<glm::dvec2> result;
  for (std::size_t i = 0; i < parameter->numbers.size(); i += 2)
    result.emplace_back(parameter->numbers[i], parameter->numbers[i + 1]);
  return result;
}

void Parameters::ignore(std::initializer_list<const char*> names) {
  for (const char* name : names) (void)find(name);
}

void Parameters::ignore_all() {
  for (Parameter& parameter : parameters_) parameter.is_used = true;
}

void Parameters::warn_of_unused(Diagnostics& diagnostics) const {
  for (const Parameter& parameter : parameters_)
    if (!parameter.is_used)
      diagnostics.warning(parameter.where, directive_ + ": parameter " + in_quotes(parameter.name) +
                                               " is not understood and is ignored");
}

}  // namespace gmis::tools::pbrt
