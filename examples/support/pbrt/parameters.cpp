#include "support/pbrt/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gmis::tools::pbrt {

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
  if (found != count)
    fail(parameter.name, "has " + std::to_string(found) + " values: give it " + std::to_string(count));
}

std::optional<double> Parameters::number(const std::string& name) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  if (parameter->type == "texture") {
    require_count(*parameter, 1);
    const auto texture = textures_->numbers.find(parameter->strings[0]);
    if (texture == textures_->numbers.end())
      fail(name, "uses the float texture " + in_quotes(parameter->strings[0]) + ", which is not defined above it");
    return texture->second;
  }
  require_type(*parameter, {"float", "integer"});
  require_count(*parameter, 1);
  return parameter->numbers[0];
}

std::optional<int> Parameters::integer(const std::string& name) {
  const std::vector<int> values = integers(name);
  if (!has(name)) return {};
  if (values.size() != 1) fail(name, "has " + std::to_string(values.size()) + " values: give it 1");
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

std::optional<Rgb> Parameters::color(const std::string& name, const NamedSpectra& named) {
  const Parameter* parameter = find(name);
  if (!parameter) return {};
  if (parameter->type == "texture") {
    require_count(*parameter, 1);
    const auto texture = textures_->colors.find(parameter->strings[0]);
    if (texture == textures_->colors.end())
      fail(name, "uses the spectrum texture " + in_quotes(parameter->strings[0]) + ", which is not defined above it");
    return texture->second;
  }
  require_type(*parameter, {"rgb", "spectrum", "color"});
  const Rgb value = parameter->type == "spectrum" ? spectrum(*parameter, named) : Rgb(0);
  if (parameter->type == "spectrum") return value;
  require_count(*parameter, 3);
  return Rgb(parameter->numbers[0], parameter->numbers[1], parameter->numbers[2]);
}

Rgb Parameters::spectrum(const Parameter& parameter, const NamedSpectra& named) const {
  if (!parameter.strings.empty()) {
    require_count(parameter, 1);
    const std::optional<Rgb> value = named ? named(parameter.strings[0]) : std::nullopt;
    if (!value)
      fail(parameter.name,
           "names the spectrum " + in_quotes(parameter.strings[0]) + ", which is not known: give it as rgb");
    return *value;
  }
  // Pairs of wavelength and value: a constant is a colour, anything else would need the colour-matching functions.
  if (parameter.numbers.size() < 2 || parameter.numbers.size() % 2 != 0)
    fail(parameter.name, "must list pairs of wavelength and value");
  for (std::size_t i = 1; i < parameter.numbers.size(); i += 2)
    if (parameter.numbers[i] != parameter.numbers[1])
      fail(parameter.name, "is a spectrum that varies with the wavelength: give it as rgb");
  return Rgb(parameter.numbers[1]);
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
