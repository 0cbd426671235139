#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "support/pbrt/lexer.hpp"
#include "support/pbrt/spectra.hpp"
#include "support/scene_description.hpp"

namespace gmis::tools::pbrt {

/// One `"type name" [ values ]` of a directive.
struct Parameter {
  std::string type, name;
  std::vector<double> numbers;
  std::vector<std::string> strings;
  SourcePosition where;
  bool is_used = false;

  [[nodiscard]] bool is_of(std::initializer_list<const char*> types) const;
};

/// The textures known so far, and where files are.
struct Textures {
  std::map<std::string, TextureHandle> numbers, colors;
  std::function<std::filesystem::path(const std::string&)> find;
  glm::dmat3 to_srgb{1};  ///< of colours given as rgb, where ColorSpace names another space
};

/// The parameters of one directive, with typed access. A getter marks its parameter as understood,
/// and throws `InputError` when it has the wrong type, the wrong number of values, or an invalid
/// value.
class Parameters {
 public:
  /// `directive` is what messages call it, e.g. `Shape "sphere"`.
  /// A texture that varies where only a constant is supported is reported to `diagnostics`.
  Parameters(std::string directive, SourcePosition where, std::vector<Parameter> parameters, const Textures& textures,
             Diagnostics& diagnostics)
      : directive_(std::move(directive)),
        where_(std::move(where)),
        parameters_(std::move(parameters)),
        textures_(&textures),
        to_srgb_(textures.to_srgb),
        diagnostics_(&diagnostics) {}

  [[nodiscard]] const SourcePosition& where() const { return where_; }
  [[nodiscard]] const std::string& directive() const { return directive_; }

  [[nodiscard]] bool has(const std::string& name) const;
  /// There, and given as a spectrum or a colour.
  [[nodiscard]] bool is_spectrum(const std::string& name) const;
  [[nodiscard]] std::optional<double> number(const std::string& name);
  [[nodiscard]] double number_or(const std::string& name, double otherwise) { return number(name).value_or(otherwise); }
  [[nodiscard]] std::optional<int> integer(const std::string& name);
  [[nodiscard]] bool boolean_or(const std::string& name, bool otherwise);
  [[nodiscard]] std::vector<std::string> strings(const std::string& name);
  [[nodiscard]] std::optional<std::string> string(const std::string& name);
  [[nodiscard]] std::optional<Point> point(const std::string& name);
  [[nodiscard]] std::vector<Point> points(const std::string& name);
  [[nodiscard]] std::vector<glm::dvec2> pairs(const std::string& name);
  [[nodiscard]] std::vector<Point> normals(const std::string& name);
  [[nodiscard]] std::vector<int> integers(const std::string& name);
  [[nodiscard]] std::vector<double> numbers(const std::string& name);

  /// A colour given as `rgb`, `spectrum` (named, a file, or pairs), `blackbody` or `texture`; of a
  /// texture that varies, its mean, which is reported as not supported.
  [[nodiscard]] std::optional<Rgb> color(const std::string& name, SpectrumOf of = SpectrumOf::surface);
  /// A colour, or a number, as a texture that is constant or not.
  [[nodiscard]] std::optional<TextureHandle> color_texture(const std::string& name);
  [[nodiscard]] std::optional<TextureHandle> number_texture(const std::string& name);
  /// Whether a texture is given that is not the same everywhere.
  [[nodiscard]] bool varies(const std::string& name) const;

  /// Understood, without effect.
  void ignore(std::initializer_list<const char*> names);
  void ignore_all();
  [[nodiscard]] const std::vector<Parameter>& all() const { return parameters_; }
  /// A warning for every parameter that nobody asked for.
  void warn_of_unused(Diagnostics& diagnostics) const;

  [[noreturn]] void fail(const std::string& name, const std::string& message) const;
  /// Where the parameter stands, or the directive without it.
  [[nodiscard]] const SourcePosition& where(const std::string& name) const;
  /// For `Diagnostics::unsupported`: the parameter is understood, and can have no effect.
  void unsupported(const std::string& name, const std::string& message, Diagnostics& diagnostics) const;

 private:
  [[nodiscard]] Parameter* find(const std::string& name);
  [[nodiscard]] std::vector<Point> triples(const std::string& name, std::initializer_list<const char*> types);
  [[nodiscard]] Rgb spectrum(const Parameter& parameter, SpectrumOf of) const;
  /// The texture that the parameter names, of one of the two types.
  [[nodiscard]] const TextureHandle& texture(const Parameter& parameter, bool is_color) const;
  void require_type(const Parameter& parameter, std::initializer_list<const char*> types) const;
  void require_count(const Parameter& parameter, std::size_t count) const;

  std::string directive_;
  SourcePosition where_;
  std::vector<Parameter> parameters_;
  const Textures* textures_;
  glm::dmat3 to_srgb_;
  Diagnostics* diagnostics_;
};

/// True when `type` is one that pbrt-v4 knows for parameters.
[[nodiscard]] bool is_parameter_type(const std::string& type);

}  // namespace gmis::tools::pbrt
