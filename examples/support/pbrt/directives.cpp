#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <utility>

#include "support/pbrt/color_spaces.hpp"
#include "support/pbrt/parser.hpp"

namespace gmis::tools::pbrt {
namespace {

/// Beyond this, squares and volumes leave the range of float.
constexpr double farthest = 1e9;

Transform matrix_of(const std::vector<double>& numbers) {
  Transform m(1);
  for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = numbers[static_cast<std::size_t>(i)];
  // Written with few digits the last column may be a hair off; a common factor is divided out, as
  // pbrt does.
  const double w = m[3][3];
  if (w == 0 || !(std::abs(m[0][3]) + std::abs(m[1][3]) + std::abs(m[2][3]) <= 1e-9 * std::abs(w))) return m;
  m /= w;
  m[0][3] = m[1][3] = m[2][3] = 0;
  m[3][3] = 1;
  return m;
}

bool is_within_range(const ShapeDescription& shape) {
  const auto near = [](const Point& p) {
    return std::abs(p.x) <= farthest && std::abs(p.y) <= farthest && std::abs(p.z) <= farthest;
  };
  if (const auto* sphere = std::get_if<SphereDescription>(&shape.geometry))
    return near(sphere->center) && sphere->radius <= farthest;
  const auto& positions = std::get<MeshDescription>(shape.geometry).positions;
  return std::all_of(positions.begin(), positions.end(), near);
}

std::uintmax_t bytes_of(const std::vector<Parameter>& parameters) {
  std::uintmax_t bytes = 0;
  for (const Parameter& parameter : parameters) {
    bytes += sizeof parameter + parameter.numbers.size() * sizeof parameter.numbers[0];
    for (const std::string& text : parameter.strings) bytes += sizeof text + text.size();
  }
  return bytes;
}

}  // namespace

void Parser::ignored_with_note() {
  const std::string kind = expect_string("a name");
  Parameters parameters = parse_parameters(kind);
  parameters.ignore_all();
  diagnostics_.note(directive_.where, named_directive(kind) + " is ignored");
}

// ---- transforms ---------------------------------------------------------------------------------

namespace {

/// Affine, and of finite numbers. It may flatten space: meshes are then flat, as pbrt has them, and
/// other shapes vanish.
bool is_affine(const Transform& m) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row)
      if (!(std::abs(m[column][row]) < 1e100)) return false;
  return m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1;
}

}  // namespace

template <class Change>
void Parser::change_transforms(const Change& change) {
  for (const auto& [is_active, transform] :
       {std::pair{state_.is_start_active, &state_.transform}, std::pair{state_.is_end_active, &state_.end_transform}}) {
    if (!is_active) continue;
    const Transform next = change(*transform);
    if (!is_affine(next))
      throw InputError(directive_.where,
                       directive_.text +
                           ": the result is out of range, or the transform is not affine (its last column "
                           "must be 0 0 0 1)");
    *transform = next;
  }
}

void Parser::require_rest() {
  if (state_.transform != state_.end_transform)
    diagnostics_.unsupported(directive_.where,
                             "motion is not supported: what ActiveTransform moves stays where it starts");
}

void Parser::concat(const Transform& m) {
  change_transforms([&](const Transform& before) { return before * m; });
}

void Parser::identity() {
  change_transforms([](const Transform&) { return Transform(1); });
}

void Parser::translate() {
  const auto n = expect_numbers(3);
  concat(translation({n[0], n[1], n[2]}));
}

void Parser::scale() {
  const auto n = expect_numbers(3);
  concat(scaling({n[0], n[1], n[2]}));
}

void Parser::rotate() {
  const auto n = expect_numbers(4);
  const glm::dvec3 axis(n[1], n[2], n[3]);
  if (!(glm::length(axis) > 0)) throw InputError(directive_.where, "Rotate needs an axis that is not 0 0 0");
  concat(rotation(n[0], axis));
}

void Parser::look_at_directive() {
  const auto n = expect_numbers(9);
  const auto m = look_at({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]});
  if (!m)
    throw InputError(directive_.where,
                     "LookAt needs an eye apart from its target and an up that is not along the view");
  concat(*m);
}

void Parser::transform() {
  const Transform m = matrix_of(expect_numbers(16));
  change_transforms([&](const Transform&) { return m; });
}

void Parser::concat_transform() {
  concat(matrix_of(expect_numbers(16)));
}

void Parser::active_transform() {
  const Token which = lexer_->next();
  if (which.text != "All" && which.text != "StartTime" && which.text != "EndTime")
    throw InputError(which.where,
                     "ActiveTransform " + in_quotes(which.text) + " is not understood: use All, StartTime or EndTime");
  state_.is_start_active = which.text != "EndTime";
  state_.is_end_active = which.text != "StartTime";
}

void Parser::transform_times() {
  (void)expect_numbers(2);  // without a motion there is nothing that they change
}

// ---- media --------------------------------------------------------------------------------------

void Parser::make_named_medium() {
  const std::string name = expect_string("the name of a medium");
  Parameters parameters = parse_parameters(name, "medium");
  std::optional<Rgb>& sigma = media_[name];
  sigma.reset();
  const auto is_black = [&](const char* what, bool otherwise) {
    return parameters.has(what) ? parameters.color(what) == Rgb(0) : otherwise;
  };
  // pbrt's own defaults scatter.
  const bool absorbs_only = parameters.string("type").value_or("homogeneous") == "homogeneous" &&
                            !parameters.has("preset") && is_black("sigma_s", false) && is_black("Le", true);
  if (absorbs_only) {
    sigma = parameters.color("sigma_a").value_or(Rgb(1)) * parameters.number_or("scale", 1);
    for (int c = 0; c < 3; ++c)
      if (!((*sigma)[c] >= 0 && (*sigma)[c] <= 1e12)) parameters.fail("sigma_a", "must be from 0 to 1e12");
  }
  parameters.ignore_all();  // MediumInterface reports an unsupported medium, where one is used
}

void Parser::medium_interface() {
  const std::string inside = expect_string("the name of a medium");
  const std::string outside =
      lexer_->peek().kind == Token::Kind::string ? expect_string("the name of a medium") : inside;
  bool is_reported = false;
  const auto medium = [&](const std::string& name) {
    if (name.empty()) return Medium{};
    const auto found = media_.find(name);
    if (found != media_.end() && found->second) return Medium{name, *found->second};
    if (!std::exchange(is_reported, true))
      diagnostics_.unsupported(directive_.where,
                               found == media_.end()
                                   ? "the medium " + in_quotes(name) + " is not defined above this line"
                                   : "the medium " + in_quotes(name) +
                                         " is not supported: only one that absorbs and does not scatter or shine is, "
                                         "of \"string type\" \"homogeneous\" with \"rgb sigma_s\" [ 0 0 0 ]");
    return Medium{};
  };
  state_.inside = medium(inside);
  state_.outside = medium(outside);
}

std::optional<AbsorptionDescription> Parser::media_of(const ShapeDescription& shape) {
  const Medium &inside = state_.inside, &outside = state_.outside;
  if (!outside.name.empty()) outside_media_.try_emplace(outside.name, directive_.where);
  if (inside.name == outside.name) return {};  // no boundary: the medium goes on behind the shape
  const auto& kind = scene_.materials.at(shape.material).kind;
  const auto* dielectric = std::get_if<DielectricDescription>(&kind);
  if (dielectric != nullptr && !dielectric->is_thin) {
    if (shape.opacity) {
      diagnostics_.unsupported(shape.where, "the boundary of a medium cannot have alpha: leave out one of the two");
      return {};
    }
    if (!inside.name.empty()) enclosed_media_.insert(inside.name);
    return AbsorptionDescription{inside.sigma, outside.sigma};
  }
  if (dielectric != nullptr || std::holds_alternative<DiffuseTransmissionDescription>(kind) ||
      std::holds_alternative<MixDescription>(kind))
    diagnostics_.unsupported(shape.where, "a medium is understood inside of the material \"dielectric\" alone");
  return {};  // no light gets inside
}

void Parser::require_closed_media() {
  for (const auto& [name, where] : outside_media_)
    if (!enclosed_media_.contains(name))
      diagnostics_.unsupported(
          where, "the medium " + in_quotes(name) + " is not supported without an end: put it inside of a dielectric");
}

// ---- settings that only sometimes change the picture --------------------------------------------

void Parser::color_space() {
  const std::string name = expect_string("the name of a colour space");
  const auto matrix = srgb_from(name);
  if (!matrix)
    diagnostics_.unsupported(directive_.where, "the colour space " + in_quotes(name) +
                                                   " is not known: use srgb, dci-p3, rec2020 or aces2065-1");
  else if (name == "srgb")
    diagnostics_.note(directive_.where, "ColorSpace \"srgb\" is what all colours are in");
  else
    diagnostics_.note(directive_.where, "colours given as rgb are brought from " + name + " to srgb, images are not");
  state_.to_srgb = matrix.value_or(glm::dmat3(1));
}

void Parser::option() {
  const Parameter parameter = parse_parameter();
  if (parameter.name == "forcediffuse" && parameter.strings == std::vector<std::string>{"true"})
    diagnostics_.unsupported(directive_.where, "Option \"forcediffuse\" is not supported: leave it out");
  else
    diagnostics_.note(directive_.where, "Option " + in_quotes(parameter.name) + " is ignored");
}

void Parser::coordinate_system() {
  coordinate_systems_[expect_string("the name of a coordinate system")] = {state_.transform, state_.end_transform};
}

void Parser::coord_sys_transform() {
  const std::string name = expect_string("the name of a coordinate system");
  const auto found = coordinate_systems_.find(name);
  if (found == coordinate_systems_.end())
    throw InputError(directive_.where, "the coordinate system " + in_quotes(name) + " is not defined above this line");
  const auto& [start, end] = found->second;
  if (state_.is_start_active) state_.transform = start;
  if (state_.is_end_active) state_.end_transform = end;
}

// ---- blocks -------------------------------------------------------------------------------------

void Parser::save(const std::string& closed_by) {
  constexpr std::size_t deepest = 10000;
  if (saved_.size() >= deepest) throw InputError(directive_.where, "blocks are nested more than 10000 deep");
  budget_.take(state_.inside.name.size() + state_.outside.name.size(), directive_.text, directive_.where);
  saved_.push_back({state_, closed_by, directive_.where});
}

void Parser::restore(const std::string& closed_by) {
  if (saved_.empty()) throw InputError(directive_.where, directive_.text + " closes nothing: take it out");
  if (saved_.back().closed_by != closed_by)
    throw InputError(directive_.where, directive_.text + " comes where " + saved_.back().closed_by +
                                           " must close the block of " + saved_.back().where.to_string());
  state_ = std::move(saved_.back().state);
  saved_.pop_back();
}

void Parser::attribute() {
  const std::string target = expect_string("shape, light, material, medium or texture");
  Parameters unused = parse_parameters(target);
  if (target != "shape" && target != "light" && target != "material" && target != "texture" && target != "medium")
    throw InputError(directive_.where, "Attribute " + in_quotes(target) +
                                           " is not understood: use shape, light, material, medium or texture");
  auto& defaults = state_.defaults[target];
  budget_.take(bytes_of(unused.all()) + (defaults ? bytes_of(*defaults) : 0), directive_.text, directive_.where);
  std::vector<Parameter> list = defaults ? *defaults : std::vector<Parameter>();
  for (const Parameter& parameter : unused.all()) {
    std::erase_if(list, [&](const Parameter& p) { return p.name == parameter.name; });
    list.push_back(parameter);
  }
  defaults = std::make_shared<const std::vector<Parameter>>(std::move(list));
}

void Parser::include() {
  const std::string file = expect_string("a file name");
  parse_file(resolve(file));
}

void Parser::import() {
  const std::string file = expect_string("a file name");
  save("the end of the imported file");
  const std::size_t depth = saved_.size();
  try {
    parse_file(resolve(file));
  } catch (const InputError&) {
    saved_.resize(depth - 1);
    throw;
  }
  if (saved_.size() > depth)
    throw InputError(saved_.back().where, "this is never closed: add " + saved_.back().closed_by);
  state_ = std::move(saved_.back().state);
  saved_.pop_back();
}

void Parser::world_begin() {
  in_world_ = true;
  state_.transform = state_.end_transform = Transform(1);
  state_.is_start_active = state_.is_end_active = true;
  coordinate_systems_["world"] = {Transform(1), Transform(1)};
}

// ---- the picture --------------------------------------------------------------------------------

void Parser::film() {
  const std::string kind = expect_string("a kind of film");
  Parameters parameters = parse_parameters(kind);
  if (kind != "rgb" && kind != "gbuffer" && kind != "spectral" && kind != "image")
    diagnostics_.unsupported(directive_.where, "the film " + in_quotes(kind) + " is not understood: use \"rgb\"");
  else if (kind != "rgb")
    diagnostics_.warning(directive_.where, "the film " + in_quotes(kind) + " is taken for \"rgb\"");
  FilmDescription& film = scene_.film;
  film.width = parameters.integer("xresolution").value_or(film.width);
  film.height = parameters.integer("yresolution").value_or(film.height);
  for (const auto& [name, size] : {std::pair{"xresolution", film.width}, std::pair{"yresolution", film.height}})
    if (size < 1 || size > 32768) parameters.fail(name, "must be from 1 to 32768");
  film.file_name = parameters.string("filename").value_or(film.file_name);
  film.where = directive_.where;
  read_crop(parameters);
  if (const auto sensor = parameters.string("sensor"); sensor && *sensor != "cie1931")
    diagnostics_.warning(directive_.where, "the sensor " + in_quotes(*sensor) +
                                               " is taken for \"cie1931\": colours differ a little from the camera's");
  if (const double kelvins = parameters.number_or("whitebalance", 0); kelvins != 0) {
    if (!(kelvins >= 1000 && kelvins <= 25000))
      parameters.fail("whitebalance", "must be 0, or from 1000 to 25000 kelvins");
    white_balance_ = white_balance(kelvins);
    diagnostics_.note(directive_.where, "whitebalance is applied to the colours of lights");
  }
  // As pbrt has it, with a shutter that is open for a second unless Camera says otherwise.
  film_exposure_ = parameters.number_or("iso", 100) / 100 * parameters.number_or("exposuretime", 1) *
                   parameters.number_or("imagingratio", 1);
  if (!(film_exposure_ > 0 && film_exposure_ <= 1e12)) parameters.fail("iso", "must be above 0, and at most 1e12");
  if (parameters.has("maxcomponentvalue"))
    diagnostics_.note(directive_.where, "Film: maxcomponentvalue is ignored, no sample is cut");
  parameters.ignore({"maxcomponentvalue", "diagonal", "savefp16"});
  parameters.warn_of_unused(diagnostics_);
}

void Parser::read_crop(Parameters& parameters) {
  FilmDescription& film = scene_.film;
  if (parameters.has("pixelbounds")) {
    const auto bounds = parameters.integers("pixelbounds");
    if (bounds.size() != 4 || bounds[0] < 0 || bounds[2] < 0 || bounds[0] >= bounds[1] || bounds[2] >= bounds[3])
      parameters.fail("pixelbounds", "must be four numbers x0 x1 y0 y1 with x0 < x1 and y0 < y1");
    const double w = film.width, h = film.height;
    film.crop_window = std::array{std::min(bounds[0] / w, 1.0), std::min(bounds[1] / w, 1.0),
                                  std::min(bounds[2] / h, 1.0), std::min(bounds[3] / h, 1.0)};
  }
  if (!parameters.has("cropwindow")) return;
  const auto window = parameters.numbers("cropwindow");
  if (window.size() != 4 || !(window[0] >= 0 && window[0] < window[1] && window[1] <= 1) ||
      !(window[2] >= 0 && window[2] < window[3] && window[3] <= 1))
    parameters.fail("cropwindow", "must be four numbers x0 x1 y0 y1 from 0 to 1 with x0 < x1 and y0 < y1");
  if (parameters.has("pixelbounds"))
    diagnostics_.warning(directive_.where, "Film: cropwindow is used, and pixelbounds is ignored, as in pbrt");
  film.crop_window = std::array{window[0], window[1], window[2], window[3]};
}

void Parser::pixel_filter() {
  const std::string kind = expect_string("a kind of filter");
  Parameters parameters = parse_parameters(kind);
  const double x = parameters.number_or("xradius", 0.5), y = parameters.number_or("yradius", 0.5);
  parameters.ignore_all();
  if (kind != "box" || x != 0.5 || y != 0.5)
    diagnostics_.warning(directive_.where, named_directive(kind) + ": a box filter of radius 0.5 is used instead");
}

void Parser::camera() {
  const std::string kind = expect_string("a kind of camera");
  Parameters parameters = parse_parameters(kind);
  if (kind != "perspective" && kind != "orthographic")
    diagnostics_.unsupported(directive_.where,
                             "the camera " + in_quotes(kind) + " is not understood: use perspective or orthographic");
  CameraDescription& camera = scene_.camera;
  camera.where = directive_.where;
  if (!state_.outside.name.empty()) outside_media_.try_emplace(state_.outside.name, directive_.where);
  camera.is_orthographic = kind == "orthographic";
  camera.field_of_view = parameters.number_or("fov", 90);
  if (!(camera.field_of_view >= 1e-3 && camera.field_of_view <= 179))
    parameters.fail("fov", "must be from 0.001 to 179 degrees");
  camera.frame_aspect_ratio = parameters.number("frameaspectratio");
  if (camera.frame_aspect_ratio && !(*camera.frame_aspect_ratio > 1e-3 && *camera.frame_aspect_ratio < 1e3))
    parameters.fail("frameaspectratio", "must be between 0.001 and 1000");
  if (parameters.has("screenwindow")) {
    const auto window = parameters.numbers("screenwindow");
    if (window.size() != 4 || !(window[0] < window[1]) || !(window[2] < window[3]))
      parameters.fail("screenwindow", "must be four numbers x0 x1 y0 y1 with x0 < x1 and y0 < y1");
    camera.screen_window = std::array{window[0], window[1], window[2], window[3]};
  }
  camera.lens_radius = parameters.number_or("lensradius", 0);
  if (!(camera.lens_radius >= 0 && camera.lens_radius <= farthest))
    parameters.fail("lensradius", "must be from 0 to 1e9");
  camera.focal_distance = parameters.number_or("focaldistance", 1e6);
  if (!(camera.focal_distance > 0)) parameters.fail("focaldistance", "must be above 0");
  if (camera.is_orthographic && camera.lens_radius > 0) {
    diagnostics_.warning(directive_.where,
                         "a lens is not supported with an orthographic camera: everything is in focus");
    camera.lens_radius = 0;
  }
  camera_exposure_ = parameters.number_or("shutterclose", 1) - parameters.number_or("shutteropen", 0);
  if (!(camera_exposure_ > 0 && camera_exposure_ <= 1e12))
    parameters.fail("shutterclose", "must be above \"shutteropen\": the shutter never opens");
  if (kind != "perspective" && kind != "orthographic") parameters.ignore_all();
  parameters.warn_of_unused(diagnostics_);
  require_rest();
  Transform camera_from_world = state_.transform;
  constexpr double of_camera = 2e-7;  // well below the 1e-6 that scene::Camera asks for
  if (!similarity_scale(camera_from_world, of_camera)) {
    const std::optional<Transform> upright = made_similarity(camera_from_world);
    if (!upright) throw InputError(directive_.where, "the transforms above Camera stretch space: scale all axes alike");
    if (!similarity_scale(camera_from_world))
      diagnostics_.note(directive_.where, "the axes of the camera are a little off: they are made perpendicular");
    camera_from_world = *upright;
  }
  camera.world_from_camera = glm::inverse(camera_from_world);
  coordinate_systems_["camera"] = {camera.world_from_camera, camera.world_from_camera};
}

// ---- surfaces and light -------------------------------------------------------------------------

void Parser::texture() {
  const std::string name = expect_string("the name of a texture");
  const std::string type = expect_string("float or spectrum");
  const std::string kind = expect_string("a kind of texture");
  Parameters parameters = parse_parameters(name, "texture");
  if (type != "float" && type != "spectrum")
    throw InputError(directive_.where, "a texture is of type float or spectrum, not " + in_quotes(type));
  const bool is_color = type == "spectrum";
  auto& textures = is_color ? textures_.colors : textures_.numbers;
  try {
    const TextureHandle made = make_texture(kind, is_color, parameters, files_, diagnostics_);
    // Each lookup evaluates every part, once for each reference to it.
    if (made->size() > 10'000)
      throw InputError(directive_.where, "the texture " + in_quotes(name) + " has more than 10000 parts");
    textures[name] = made;
  } catch (const InputError&) {
    // So that one with an error is not reported at each use, too.
    textures.try_emplace(name, scene::Texture<float>::constant(glm::dvec3(0.5)));
    throw;
  }
  parameters.warn_of_unused(diagnostics_);
}

MaterialDescription Parser::any_material(const std::string& kind, Parameters& parameters) {
  if (kind != "mix") return make_material(kind, parameters, files_, diagnostics_);
  MixDescription mix;
  const std::vector<std::string> names = parameters.strings("materials");
  if (names.size() != 2)
    throw InputError(parameters.where(), parameters.directive() + ": add \"string materials\" with two names");
  for (const std::string& part : names) {
    const auto found = named_materials_.find(part);
    if (found == named_materials_.end())
      parameters.fail("materials",
                      "names " + in_quotes(part) + ", which is not defined above this line: add MakeNamedMaterial");
    if (interfaces_.contains(part))
      parameters.unsupported("materials", "names an interface, which a mixture cannot have here", diagnostics_);
    (part == names[0] ? mix.first : mix.second) = found->second;
  }
  if (names[0] == names[1]) mix.second = mix.first;
  mix.amount = parameters.number_texture("amount").value_or(scene::Texture<float>::constant(glm::dvec3(0.5)));
  return {mix, parameters.where(), {}};
}

void Parser::material() {
  const std::string kind = expect_string("a material");
  Parameters parameters = parse_parameters(kind, "material");
  state_.is_interface = kind == "interface" || kind == "none" || kind.empty();
  if (state_.is_interface) return;
  scene_.materials.push_back(any_material(kind, parameters));
  count_material();
  parameters.warn_of_unused(diagnostics_);
  state_.material = scene_.materials.size() - 1;
}

void Parser::make_named_material() {
  const std::string name = expect_string("the name of a material");
  Parameters parameters = parse_parameters(name, "material");
  const auto kind = parameters.string("type");
  if (!kind) throw InputError(directive_.where, "MakeNamedMaterial " + in_quotes(name) + ": add \"string type\"");
  if (named_materials_.contains(name))
    throw InputError(directive_.where, "the material " + in_quotes(name) + " is defined twice: rename one");
  if (*kind == "interface" || *kind == "none" || kind->empty()) {
    named_materials_[name] = 0;
    interfaces_.insert(name);
    return;
  }
  try {
    scene_.materials.push_back(any_material(*kind, parameters));
    count_material();
  } catch (const InputError&) {
    named_materials_[name] = 0;  // so that a material with an error is not reported at each use, too
    throw;
  }
  parameters.warn_of_unused(diagnostics_);
  named_materials_[name] = scene_.materials.size() - 1;
}

void Parser::count_material() {
  constexpr double most = 10'000;
  const auto* mix = std::get_if<MixDescription>(&scene_.materials.back().kind);
  mix_sizes_.push_back(mix == nullptr ? 1 : 1 + mix_sizes_.at(mix->first) + mix_sizes_.at(mix->second));
  if (mix_sizes_.back() <= most) return;
  scene_.materials.pop_back();
  mix_sizes_.pop_back();
  throw InputError(directive_.where, "a mixture of more than 10000 materials, those within its parts counted");
}

void Parser::named_material() {
  const std::string name = expect_string("the name of a material");
  const auto found = named_materials_.find(name);
  if (found == named_materials_.end())
    throw InputError(directive_.where,
                     "the material " + in_quotes(name) + " is not defined above this line: add MakeNamedMaterial");
  state_.is_interface = interfaces_.contains(name);
  state_.material = found->second;
}

void Parser::light_source() {
  const std::string kind = expect_string("a kind of light");
  Parameters parameters = parse_parameters(kind, "light");
  require_rest();
  if (auto light = make_light(kind, parameters, state_.transform, files_, diagnostics_))
    scene_.lights.push_back(std::move(*light));
  parameters.warn_of_unused(diagnostics_);
}

void Parser::area_light_source() {
  const std::string kind = expect_string("a kind of area light");
  Parameters parameters = parse_parameters(kind, "light");
  state_.area_light = make_area_light(kind, parameters, diagnostics_);
  parameters.warn_of_unused(diagnostics_);
}

void Parser::shape() {
  const std::string kind = expect_string("a kind of shape");
  Parameters parameters = parse_parameters(kind, "shape");
  std::optional<ShapeDescription> made = make_shape(kind, parameters, state_.reverse_orientation, files_, diagnostics_);
  parameters.warn_of_unused(diagnostics_);
  if (!made || is_unseen_interface()) return;
  require_rest();
  ShapeDescription& shape = *made;
  shape.material = state_.material;
  shape.absorption = media_of(shape);
  if (shape.opacity && state_.area_light && open_object_.empty()) {
    const bool is_unseen = shape.opacity->is_constant() && shape.opacity->mean().x <= 0;
    if (is_unseen || std::holds_alternative<SphereDescription>(shape.geometry)) {
      diagnostics_.unsupported(
          shape.where,
          is_unseen ? "a light with an alpha of 0, which in pbrt shines and is not seen, is not supported: leave "
                      "out one of the two"
                    : "a sphere with alpha cannot be a light here: leave out one of the two");
      shape.opacity = nullptr;
    }
  }
  if (open_object_.empty()) return place_shape(std::move(shape), state_.transform, directive_.where);
  if (state_.area_light)
    diagnostics_.warning(shape.where, "a shape inside ObjectBegin cannot be a light: it does not shine");
  auto placed = transformed(std::move(shape), state_.transform);
  if (!placed) return;
  budget_.take(bytes_of(*placed), "this shape", directive_.where);
  objects_[open_object_].push_back(std::move(*placed));
}

bool Parser::is_unseen_interface() {
  if (state_.is_interface && state_.area_light)
    diagnostics_.unsupported(directive_.where,
                             "a light of the material \"interface\" is not supported: give it another material");
  if (state_.is_interface && state_.inside.name != state_.outside.name)
    diagnostics_.unsupported(
        directive_.where,
        "a medium behind the material \"interface\" is not supported: it must be behind \"dielectric\"");
  return state_.is_interface;
}

void Parser::place_shape(ShapeDescription shape, const Transform& world_from_shape, const SourcePosition& where) {
  auto placed = transformed(std::move(shape), world_from_shape);  // which may make a mesh of a sphere
  if (!placed) return;
  budget_.take(built_bytes_of(*placed), "this shape", where);
  if (!is_within_range(*placed)) throw InputError(where, "a coordinate is above 1e9 scene units: use larger units");
  if (state_.area_light && open_object_.empty()) placed->emission = emission_of(*state_.area_light, *placed);
  scene_.shapes.push_back(std::move(*placed));
}

void Parser::copy_instances() {
  std::uintmax_t triangles = 0, bytes = 0;
  for (const Instance& instance : instances_)
    for (const ShapeDescription& shape : *instance.shapes) {
      triangles += triangle_count(shape);
      bytes += built_bytes_of(shape);
    }
  if (triangles == 0) return;
  LoadBudget all = budget_;
  all.take(bytes, "the " + std::to_string(triangles) + " triangles of all instances", instances_.back().where);
  state_.area_light.reset();  // what is inside of an object does not shine
  for (const Instance& instance : instances_)
    for (const ShapeDescription& shape : *instance.shapes)
      place_shape(shape, instance.world_from_object, instance.where);
}

void Parser::object_begin() {
  const std::string name = expect_string("the name of an object");
  if (!open_object_.empty())
    throw InputError(directive_.where, "ObjectBegin stands inside the object of " + open_object_where_.to_string());
  if (name.empty()) throw InputError(directive_.where, "an object needs a name");
  if (objects_.contains(name))
    throw InputError(directive_.where, "the object " + in_quotes(name) + " is defined twice: rename one");
  save("ObjectEnd");
  open_object_ = name;
  open_object_where_ = directive_.where;
  objects_[name];
}

void Parser::object_end() {
  restore("ObjectEnd");
  open_object_.clear();
}

void Parser::object_instance() {
  const std::string name = expect_string("the name of an object");
  if (!open_object_.empty())
    throw InputError(directive_.where,
                     "ObjectInstance cannot stand inside an object: end that of " + open_object_where_.to_string());
  const auto found = objects_.find(name);
  if (found == objects_.end())
    throw InputError(directive_.where, "the object " + in_quotes(name) +
                                           " is not defined above this line: add ObjectBegin " + in_quotes(name));
  require_rest();
  budget_.take(sizeof(Instance), "an instance", directive_.where);
  instances_.push_back({&found->second, state_.transform, directive_.where});
}

}  // namespace gmis::tools::pbrt
