#include "support/pbrt/parser.hpp"

#include <algorithm>
#include <glm/common.hpp>
#include <utility>

#include "support/read_file.hpp"

namespace gmis::tools::pbrt {

Parser::Parser(std::filesystem::path folder, SceneDescription& scene, Diagnostics& diagnostics, LoadBudget& budget)
    : folder_(std::move(folder)), scene_(scene), diagnostics_(diagnostics), budget_(budget) {
  scene_.materials.push_back({DiffuseDescription{}, {}, {}});  // for shapes before the first Material
  files_ = {[this](const std::string& file) { return find(file); }, &budget_};
  textures_.find = files_.find;
  mix_sizes_.push_back(1);
}

const std::map<std::string, Parser::Directive>& Parser::directives() {
  using Place = Directive::Place;
  static const std::map<std::string, Directive> table{
      {"Accelerator", {&Parser::accelerator, Place::before_world}},
      {"ActiveTransform", {&Parser::active_transform}},
      {"AreaLightSource", {&Parser::area_light_source, Place::in_world}},
      {"Attribute", {&Parser::attribute}},
      {"AttributeBegin", {&Parser::attribute_begin, Place::in_world}},
      {"AttributeEnd", {&Parser::attribute_end, Place::in_world}},
      {"Camera", {&Parser::camera, Place::before_world}},
      {"ColorSpace", {&Parser::color_space}},
      {"ConcatTransform", {&Parser::concat_transform}},
      {"CoordSysTransform", {&Parser::coord_sys_transform}},
      {"CoordinateSystem", {&Parser::coordinate_system, Place::anywhere, true}},
      {"Film", {&Parser::film, Place::before_world}},
      {"Identity", {&Parser::identity}},
      {"Import", {&Parser::import, Place::in_world}},
      {"Include", {&Parser::include}},
      {"Integrator", {&Parser::accelerator, Place::before_world}},
      {"LightSource", {&Parser::light_source, Place::in_world, true}},
      {"LookAt", {&Parser::look_at_directive}},
      {"MakeNamedMaterial", {&Parser::make_named_material, Place::in_world, true}},
      {"MakeNamedMedium", {&Parser::make_named_medium, Place::anywhere, true}},
      {"Material", {&Parser::material, Place::in_world, true}},
      {"MediumInterface", {&Parser::medium_interface}},
      {"NamedMaterial", {&Parser::named_material, Place::in_world}},
      {"ObjectBegin", {&Parser::object_begin, Place::in_world, true}},
      {"ObjectEnd", {&Parser::object_end, Place::in_world}},
      {"ObjectInstance", {&Parser::object_instance, Place::in_world}},
      {"Option", {&Parser::option}},
      {"PixelFilter", {&Parser::pixel_filter, Place::before_world}},
      {"ReverseOrientation", {&Parser::reverse_orientation, Place::in_world}},
      {"Rotate", {&Parser::rotate}},
      {"Sampler", {&Parser::accelerator, Place::before_world}},
      {"Scale", {&Parser::scale}},
      {"Shape", {&Parser::shape, Place::in_world}},
      {"Texture", {&Parser::texture, Place::in_world, true}},
      {"Transform", {&Parser::transform}},
      {"TransformBegin", {&Parser::attribute_begin, Place::in_world}},
      {"TransformEnd", {&Parser::attribute_end, Place::in_world}},
      {"TransformTimes", {&Parser::transform_times, Place::before_world}},
      {"Translate", {&Parser::translate}},
      {"WorldBegin", {&Parser::world_begin, Place::before_world}},
  };
  return table;
}

void Parser::parse_file(const std::filesystem::path& file) {
  const SourcePosition where = lexer_ == nullptr ? SourcePosition{} : directive_.where;
  std::string text = read_file(file, "the file", budget_, where);
  if (file.extension() == ".gz")
    text = unpacked_gzip(text, "the file " + file_in_quotes(file.string()), budget_, where);
  add_file(scene_, file);
  parse_text(std::move(text), file.string());
}

void Parser::parse_text(std::string text, const std::string& name) {
  Lexer lexer(std::move(text), name);
  parse_nested(lexer);
}

void Parser::parse_nested(Lexer& lexer) {
  constexpr int deepest = 32;
  if (++include_depth_ > deepest)
    throw InputError(directive_.where, "files include each other more than 32 deep: does one include itself?");
  const int depth = include_depth_;
  Lexer* const outer = lexer_;
  const std::string included = outer == nullptr ? "" : " (included by " + directive_.where.to_string() + ")";
  // A file that it includes in turn has said by whom.
  const auto message_of = [&](const InputError& error) {
    return error.message() + (include_depth_ == depth ? included : "");
  };
  try {
    require_scene(lexer);
    lexer_ = &lexer;
    for (Token token = lexer.next(); token.kind != Token::Kind::end; token = lexer.next()) {
      if (!diagnostics_.is_check()) {
        parse_directive(token);
        continue;
      }
      try {
        parse_directive(token);
      } catch (const InputError& error) {
        diagnostics_.error(error.where().value_or(token.where), message_of(error));
        lexer_ = &lexer;
        include_depth_ = depth;
        skip_to_directive();
      }
    }
  } catch (const InputError& error) {
    if (include_depth_ != depth || included.empty() || !error.where()) throw;
    throw InputError(*error.where(), message_of(error));
  }
  lexer_ = outer;
  --include_depth_;
}

void Parser::require_scene(const Lexer& lexer) {
  const std::string_view word = lexer.first_word();
  if (lexer.is_at_end() || directives().contains(std::string(word))) return;
  static const std::set<std::string_view> older{"Renderer", "SurfaceIntegrator", "VolumeIntegrator", "SearchPath"};
  if (older.contains(word))
    throw InputError(lexer.here(),
                     "this is a scene of pbrt-v2 or older: bring it to v3, and that to v4 by pbrt --upgrade");
  throw InputError(lexer.here(),
                   "this is no pbrt-v4 scene: it does not begin with a directive like Film or WorldBegin");
}

void Parser::parse_directive(const Token& word) {
  if (word.kind != Token::Kind::word)
    throw InputError(word.where,
                     "found " + in_quotes(word.text) + " where a directive like Shape or Material must stand");
  directive_ = word;
  const auto found = directives().find(word.text);
  if (found == directives().end()) return skip_unknown(word);
  using Place = Directive::Place;
  if (found->second.place == Place::before_world && in_world_)
    throw InputError(word.where, word.text + " must stand before WorldBegin");
  if (found->second.place == Place::in_world && !in_world_)
    throw InputError(word.where, word.text + " must stand after WorldBegin");
  if (found->second.is_kept) budget_.take(bytes_of_element, word.text, word.where);
  (this->*found->second.handler)();
}

void Parser::skip_to_directive() {
  const auto begins_directive = [](const Token& token) {
    return token.kind == Token::Kind::word && token.text != "true" && token.text != "false";
  };
  while (lexer_->peek().kind != Token::Kind::end && !begins_directive(lexer_->peek())) (void)lexer_->next();
}

void Parser::skip_unknown(const Token& word) {
  const bool could_be_directive = std::all_of(word.text.begin(), word.text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  });
  if (!could_be_directive)
    throw InputError(word.where,
                     "found " + in_quotes(word.text) + ", which no scene file holds: is this a pbrt-v4 scene?");
  diagnostics_.unsupported(word.where, "the directive " + in_quotes(word.text) +
                                           " is not understood, or cut off: correct it, or use --lenient");
  bool in_brackets = false;
  for (bool is_first = true;; is_first = false) {
    const Token& token = lexer_->peek();
    if (token.kind == Token::Kind::end) {
      if (is_first || in_brackets)
        throw InputError(token.where,
                         "the file ends after " + in_quotes(word.text) + ", which is no directive: is it cut off?");
      return;
    }
    const bool is_value = token.kind != Token::Kind::word || token.text == "true" || token.text == "false";
    if (!is_value && !in_brackets) return;
    if (token.kind == Token::Kind::open_bracket) in_brackets = true;
    if (token.kind == Token::Kind::close_bracket) in_brackets = false;
    (void)lexer_->next();
  }
}

std::string Parser::expect_string(const char* what) {
  const Token token = lexer_->next();
  if (token.kind == Token::Kind::end)
    throw InputError(token.where, "the file ends after " + directive_.text + ", where " + what + " must stand");
  if (token.kind != Token::Kind::string)
    throw InputError(token.where, "found " + in_quotes(token.text) + " after " + directive_.text + ", where " + what +
                                      " must stand in quotation marks");
  return token.text;
}

std::vector<double> Parser::expect_numbers(std::size_t count) {
  const bool has_brackets = lexer_->peek().kind == Token::Kind::open_bracket;
  if (has_brackets) (void)lexer_->next();
  std::vector<double> numbers;
  while (numbers.size() < count) {
    const Token token = lexer_->next();
    if (token.kind != Token::Kind::number)
      throw InputError(token.where,
                       directive_.text + " needs " + std::to_string(count) + " numbers, found " +
                           (token.kind == Token::Kind::end ? "the end of the file" : in_quotes(token.text)) +
                           " after " + std::to_string(numbers.size()));
    numbers.push_back(token.number);
  }
  if (has_brackets) {
    const Token token = lexer_->next();
    if (token.kind != Token::Kind::close_bracket)
      throw InputError(token.where, directive_.text + " needs " + std::to_string(count) + " numbers and then a \"]\"");
  }
  return numbers;
}

Parameters Parser::parse_parameters(const std::string& kind, const char* defaults_of) {
  std::vector<Parameter> parameters;
  while (lexer_->peek().kind == Token::Kind::string) {
    parameters.push_back(parse_parameter());
    for (std::size_t i = 0; i + 1 < parameters.size(); ++i)
      if (parameters[i].name == parameters.back().name)
        throw InputError(parameters.back().where, "parameter " + in_quotes(parameters.back().name) + " is given twice");
  }
  const auto defaults = defaults_of == nullptr ? nullptr : state_.defaults[defaults_of];
  if (defaults != nullptr) {
    for (const Parameter& otherwise : *defaults) {
      const bool is_set = std::any_of(parameters.begin(), parameters.end(),
                                      [&](const Parameter& p) { return p.name == otherwise.name; });
      if (is_set) continue;
      parameters.push_back(otherwise);
      parameters.back().is_used = true;  // it may be meant for another kind
    }
  }
  textures_.to_srgb = state_.to_srgb;
  return {named_directive(kind), directive_.where, std::move(parameters), textures_, diagnostics_};
}

std::string Parser::named_directive(const std::string& kind) const {
  return kind.empty() ? directive_.text : directive_.text + " " + in_quotes(kind);
}

Parameter Parser::parse_parameter() {
  const Token declaration = lexer_->next();
  Parameter parameter;
  parameter.where = declaration.where;
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  const auto& text = declaration.text;
  const auto type_begin = std::find_if_not(text.begin(), text.end(), is_blank);
  const auto type_end = std::find_if(type_begin, text.end(), is_blank);
  const auto name_begin = std::find_if_not(type_end, text.end(), is_blank);
  const auto name_end = std::find_if(name_begin, text.end(), is_blank);
  parameter.type.assign(type_begin, type_end);
  parameter.name.assign(name_begin, name_end);
  if (parameter.name.empty() || std::find_if_not(name_end, text.end(), is_blank) != text.end())
    throw InputError(declaration.where, in_quotes(text) + " is no parameter: write \"type name\" and then its value");
  if (!is_parameter_type(parameter.type))
    throw InputError(declaration.where, in_quotes(text) + " has the unknown type " + in_quotes(parameter.type) +
                                            ": use float, integer, bool, string, point3, normal, rgb or spectrum");
  if (lexer_->peek().kind != Token::Kind::open_bracket) {
    parse_value(parameter);
    return parameter;
  }
  (void)lexer_->next();
  while (lexer_->peek().kind != Token::Kind::close_bracket) parse_value(parameter);
  (void)lexer_->next();
  return parameter;
}

void Parser::parse_value(Parameter& parameter) {
  const Token token = lexer_->next();
  if (token.kind == Token::Kind::end)
    throw InputError(token.where, "the file ends inside parameter " + in_quotes(parameter.name));
  const bool takes_both = parameter.is_of({"spectrum", "blackbody"});
  const bool takes_text = parameter.is_of({"string", "bool", "texture"});
  const bool is_truth = token.kind == Token::Kind::word && (token.text == "true" || token.text == "false");
  if (token.kind == Token::Kind::number && !takes_text) {
    // Where the list grows there is room for the old one, the new one and what is made of it.
    if (parameter.numbers.size() == parameter.numbers.capacity())
      LoadBudget(budget_).take(parameter.numbers.size(), 4 * sizeof(double), "parameter " + in_quotes(parameter.name),
                               token.where);
    parameter.numbers.push_back(token.number);
  } else if ((token.kind == Token::Kind::string && (takes_text || takes_both)) ||
             (is_truth && parameter.type == "bool")) {
    parameter.strings.push_back(token.text);
  } else {
    throw InputError(token.where, "found " + in_quotes(token.text) + " where parameter " + in_quotes(parameter.name) +
                                      " needs " +
                                      (parameter.type == "bool" ? "true or false"
                                       : takes_text             ? "text in quotation marks"
                                                                : "a number"));
  }
  if (!parameter.numbers.empty() && !parameter.strings.empty())
    throw InputError(token.where, "parameter " + in_quotes(parameter.name) + " mixes numbers and text");
}

std::filesystem::path Parser::resolve(const std::string& file) const {
  // First in the folder of the main scene, as pbrt-v4 does; else in the folder of the file that
  // names it, which scenes written for older readers mean.
  const std::filesystem::path beside_scene = folder_ / file;
  std::error_code error;
  if (std::filesystem::exists(beside_scene, error) || !directive_.where.file) return beside_scene;
  const std::filesystem::path beside_this = std::filesystem::path(*directive_.where.file).parent_path() / file;
  return std::filesystem::exists(beside_this, error) ? beside_this : beside_scene;
}

std::filesystem::path Parser::find(const std::string& name) {
  std::filesystem::path file = resolve(name);
  add_file(scene_, file);
  return file;
}

void Parser::finish(const std::string& name) {
  const SourcePosition begin{std::make_shared<const std::string>(name), 1};
  if (!saved_.empty()) throw InputError(saved_.back().where, "this is never closed: add " + saved_.back().closed_by);
  if (!open_object_.empty()) throw InputError(open_object_where_, "this is never closed: add ObjectEnd");
  if (!in_world_) throw InputError(begin, "there is no WorldBegin: is this a whole pbrt-v4 scene?");
  copy_instances();
  require_closed_media();
  const glm::dmat3 exposure = white_balance_ * (film_exposure_ * camera_exposure_);
  for (LightDescription& light : scene_.lights) expose(light, exposure);
  for (ShapeDescription& one : scene_.shapes)
    if (one.emission) {
      one.emission->radiance = glm::max(exposure * one.emission->radiance, Rgb(0));
      if (is_too_bright(one.emission->radiance)) throw InputError(one.where, too_bright_film);
    }
  if (scene_.shapes.empty())
    throw InputError(begin,
                     "the scene holds no shape, and lights alone are not rendered: add a Shape after WorldBegin, "
                     "such as Shape \"sphere\"");
  const bool has_light = !scene_.lights.empty() || std::any_of(scene_.shapes.begin(), scene_.shapes.end(),
                                                               [](const auto& s) { return s.emission.has_value(); });
  if (!has_light) diagnostics_.warning(begin, "the scene has no light: it will be black");
}

}  // namespace gmis::tools::pbrt
