#include "support/gltf/primitive.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <memory>
#include <utility>

#if GMIS_HAS_DRACO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wextra"
#include <draco/compression/decode.h>
#pragma GCC diagnostic pop
#endif

namespace gmis::tools::gltf {

Primitive::Primitive(const Document& document, const Json& json, std::string name)
    : document_(document), json_(json), name_(std::move(name)) {
  const double mode = document.number(json, "mode", 4);
  if (!(mode >= 0 && mode <= 6 && mode == std::floor(mode))) throw document.error(name_ + " has an unknown mode");
  mode_ = static_cast<int>(mode);
  if (const Json& packed = Document::extension(json, "KHR_draco_mesh_compression"); packed.is_object()) unpack(packed);
}

#if GMIS_HAS_DRACO

void Primitive::unpack(const Json& packed) {
  const std::string_view bytes = document_.view(document_.index(packed, "bufferView").value_or(std::size_t{1} << 50U));
  document_.budget().take(bytes.size(), 20, name_ + ", unpacked,", document_.where());
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto result = decoder.DecodeMeshFromBuffer(&buffer);
  if (!result.ok()) throw document_.error(name_ + " cannot be unpacked by the library draco");
  const std::unique_ptr<draco::Mesh> mesh = std::move(result).value();
  document_.budget().take(mesh->num_points(), 100, name_ + ", unpacked,", document_.where());
  unpacked_.emplace();
  for (const auto& [attribute, id] : Document::member(packed, "attributes").items()) {
    if (!id.is_number_unsigned()) throw document_.error(name_ + " has a packed attribute without a number");
    const draco::PointAttribute* found = mesh->GetAttributeByUniqueId(id.get<std::uint32_t>());
    if (found == nullptr) throw document_.error(name_ + " lacks its packed " + in_quotes(attribute));
    const auto components = static_cast<std::size_t>(found->num_components());
    if (components < 1 || components > 4) throw document_.error(name_ + " has a packed attribute of a wrong type");
    std::vector<double> values;
    for (draco::PointIndex point(0); point < mesh->num_points(); ++point) {
      std::array<float, 4> value{};
      if (!found->ConvertValue<float>(found->mapped_index(point), static_cast<std::int8_t>(components), value.data()))
        throw document_.error(name_ + " has a packed attribute that cannot be read");
      for (std::size_t c = 0; c < components; ++c) values.push_back(static_cast<double>(value[c]));
    }
    // draco converts normalised integers to fractions; other integers, such as joints, stay as they
    // are.
    unpacked_->attributes[attribute] = {components, std::move(values)};
  }
  for (draco::FaceIndex face(0); face < mesh->num_faces(); ++face)
    for (const auto& corner : mesh->face(face)) unpacked_->indices.push_back(static_cast<double>(corner.value()));
}

#else

void Primitive::unpack(const Json&) {
  throw document_.error(name_ + " is packed, and this program was built without the library draco, which unpacks it");
}

#endif

bool Primitive::has(const std::string& attribute) const {
  if (unpacked_ && unpacked_->attributes.contains(attribute)) return true;
  return Document::member(Document::member(json_, "attributes"), attribute.c_str()).is_number();
}

std::size_t Primitive::components_of(const std::string& attribute) const {
  if (unpacked_)
    if (const auto found = unpacked_->attributes.find(attribute); found != unpacked_->attributes.end())
      return found->second.first;
  return document_.components_of(*document_.index(Document::member(json_, "attributes"), attribute.c_str(), name_),
                                 name_ + ": " + attribute);
}

std::vector<double> Primitive::numbers(const std::string& attribute, std::size_t components) const {
  if (!has(attribute)) return {};
  if (unpacked_)
    if (const auto found = unpacked_->attributes.find(attribute); found != unpacked_->attributes.end()) {
      if (found->second.first != components) throw document_.error(name_ + ": " + attribute + " has the wrong type");
      return found->second.second;
    }
  return document_.accessor(*document_.index(Document::member(json_, "attributes"), attribute.c_str(), name_),
                            components, name_ + ": " + attribute);
}

std::vector<glm::dvec3> Primitive::triples(const std::string& attribute) const {
  const std::vector<double> values = numbers(attribute, 3);
  std::vector<glm::dvec3> result;
  for (std::size_t i = 0; i + 2 < values.size(); i += 3) result.emplace_back(values[i], values[i + 1], values[i + 2]);
  return result;
}

std::vector<std::array<int, 3>> Primitive::triangles(std::size_t vertices) const {
  std::vector<int> corners;
  std::vector<double> indices;
  if (unpacked_)
    indices = unpacked_->indices;
  else if (const auto number = document_.index(json_, "indices", name_))
    indices = document_.accessor(*number, 1, name_ + ": indices");
  else
    for (std::size_t i = 0; i < vertices; ++i) indices.push_back(static_cast<double>(i));
  corners.reserve(indices.size());
  for (const double index : indices) {
    if (!(index >= 0 && index < static_cast<double>(vertices)))
      throw document_.error(name_ + " refers to a vertex that is not there");
    corners.push_back(static_cast<int>(index));
  }
  constexpr int strip = 5, fan = 6;
  std::vector<std::array<int, 3>> result;
  const bool is_list = unpacked_ || (mode_ != strip && mode_ != fan);
  for (std::size_t i = 0; i + 2 < corners.size(); i += is_list ? 3 : 1) {
    if (!is_list && mode_ == fan)
      result.push_back({corners[0], corners[i + 1], corners[i + 2]});
    else if (!is_list && i % 2 == 1)
      result.push_back({corners[i + 1], corners[i], corners[i + 2]});
    else
      result.push_back({corners[i], corners[i + 1], corners[i + 2]});
  }
  return result;
}

TriangleCharts::TriangleCharts(std::size_t triangles, const std::vector<glm::dvec2>& corners)
    : side_(std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(triangles)))))) {
  constexpr double margin = 0.05;  // so that rounding never leads to the patch beside
  const double texels = 2.0 * side_;
  for (std::size_t k = 0; k < triangles; ++k) {
    std::array<glm::dvec2, 3> place{glm::dvec2(margin), {1 - margin, margin}, {margin, 1 - margin}};
    if (!corners.empty()) {
      const glm::dvec2 &a = corners[3 * k], &b = corners[3 * k + 1], &c = corners[3 * k + 2];
      const glm::dvec2 low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
      const double size = std::max(high.x - low.x, high.y - low.y);
      const double area = std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
      if (area > 1e-4 * size * size) {
        const double scale = (1 - 2 * margin) / size;
        const glm::dvec2 from[] = {a, b, c};
        for (std::size_t i = 0; i < 3; ++i)
          place[i] = {(from[i].x - low.x) * scale + margin, (high.y - from[i].y) * scale + margin};
      }
    }
    const double column = 2.0 * static_cast<double>(k % static_cast<std::size_t>(side_));
    const double row = 2.0 * static_cast<double>(k / static_cast<std::size_t>(side_));
    for (const glm::dvec2& at : place) {
      places_.push_back(at);
      uv_.emplace_back((column + 0.5 + at.x) / texels, 1 - (row + 0.5 + at.y) / texels);
    }
  }
}

TextureHandle TriangleCharts::function(const std::vector<glm::dvec3>& values, LoadBudget& budget,
                                       const SourcePosition& where) const {
  const auto width = static_cast<std::size_t>(2 * side_);
  budget.take(width * width, 3 * sizeof(float), "colours or coordinates at vertices", where);
  auto image = std::make_shared<scene::TextureImage>();
  image->resolution = {2 * side_, 2 * side_};
  image->floats.assign(3 * width * width, 0.0F);
  for (std::size_t k = 0; 3 * k < values.size(); ++k) {
    const glm::dvec2 along_b = places_[3 * k + 1] - places_[3 * k], along_c = places_[3 * k + 2] - places_[3 * k];
    const double area = along_b.x * along_c.y - along_b.y * along_c.x;
    const glm::dvec3 by_b = values[3 * k + 1] - values[3 * k], by_c = values[3 * k + 2] - values[3 * k];
    const glm::dvec3 by_x = (by_b * along_c.y - by_c * along_b.y) / area;
    const glm::dvec3 by_y = (by_c * along_b.x - by_b * along_c.x) / area;
    const std::size_t column = 2 * (k % static_cast<std::size_t>(side_)),
                      row = 2 * (k / static_cast<std::size_t>(side_));
    for (std::size_t texel = 0; texel < 4; ++texel) {
      const glm::dvec2 at(static_cast<double>(texel % 2), static_cast<double>(texel / 2));
      const glm::dvec3 value = values[3 * k] + by_x * (at.x - places_[3 * k].x) + by_y * (at.y - places_[3 * k].y);
      for (std::size_t c = 0; c < 3; ++c)
        image->floats[3 * ((row + texel / 2) * width + column + texel % 2) + c] =
            static_cast<float>(value[static_cast<int>(c)]);
    }
  }
  return scene::Texture<float>::image(std::move(image), {}, scene::TextureWrap::clamp);
}

TextureHandle TriangleCharts::fractions(const std::vector<glm::dvec3>& values, LoadBudget& budget,
                                        const SourcePosition& where) const {
  TextureHandle result;
  for (int c = 0; c < 3; ++c) {
    std::vector<glm::dvec3> channel;
    for (const glm::dvec3& value : values) channel.emplace_back(value[c]);
    glm::dvec3 none(1);
    none[c] = 0;
    // The amount of a mixture is cut to [0, 1] where it is looked up.
    const TextureHandle part =
        scene::Texture<float>::mix(scene::Texture<float>::constant(none),
                                   scene::Texture<float>::constant(glm::dvec3(1)), function(channel, budget, where));
    result = result ? scene::Texture<float>::product(result, part) : part;
  }
  return result;
}

}  // namespace gmis::tools::gltf
