#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "support/image/texture_image.hpp"
#include "support/pbrt/elements.hpp"

namespace gmis::tools::pbrt {
namespace {

using Tex = scene::Texture<float>;

scene::TexturePlacement placement_of(Parameters& parameters, Diagnostics& diagnostics) {
  const std::string mapping = parameters.string("mapping").value_or("uv");
  scene::TexturePlacement placement;
  if (mapping != "uv") {
    parameters.unsupported("mapping", in_quotes(mapping) + " is not supported: use uv", diagnostics);
    parameters.ignore({"v1", "v2"});
  }
  placement.scale = {parameters.number_or("uscale", 1), parameters.number_or("vscale", 1)};
  placement.offset = {parameters.number_or("udelta", 0), parameters.number_or("vdelta", 0)};
  return placement;
}

TextureEncoding encoding_of(Parameters& parameters) {
  const std::string text = parameters.string("encoding").value_or("sRGB");
  TextureEncoding encoding;
  if (text == "sRGB") return encoding;
  if (text == "linear") {
    encoding.curve = TextureEncoding::Curve::linear;
    return encoding;
  }
  const std::string word = "gamma ";
  if (text.rfind(word, 0) != 0 || !parse_number(text.substr(word.size()), parameters.where(), encoding.gamma) ||
      !(encoding.gamma > 0 && encoding.gamma < 100))
    parameters.fail("encoding", "must be sRGB, linear or \"gamma\" with a number above 0");
  encoding.curve = TextureEncoding::Curve::gamma;
  return encoding;
}

/// The image with every value times `factor`.
std::shared_ptr<const scene::TextureImage> scaled(const scene::TextureImage& image, double factor) {
  auto result = std::make_shared<scene::TextureImage>(image);
  const auto scale = [&](float& value) { value = static_cast<float>(static_cast<double>(value) * factor); };
  std::for_each(result->decoded.begin(), result->decoded.end(), scale);
  std::for_each(result->floats.begin(), result->floats.end(), scale);
  return result;
}

TextureHandle image_texture(Parameters& parameters, bool is_color, const Files& files, Diagnostics& diagnostics) {
  const std::optional<std::string> name = parameters.string("filename");
  if (!name) throw InputError(parameters.where(), parameters.directive() + ": add \"string filename\"");
  static const std::map<std::string, scene::TextureWrap> wraps{{"repeat", scene::TextureWrap::repeat},
                                                               {"clamp", scene::TextureWrap::clamp},
                                                               {"black", scene::TextureWrap::black}};
  static const std::map<std::string, scene::TextureFilter> filters{{"bilinear", scene::TextureFilter::bilinear},
                                                                   {"trilinear", scene::TextureFilter::bilinear},
                                                                   {"ewa", scene::TextureFilter::bilinear},
                                                                   {"EWA", scene::TextureFilter::bilinear},
                                                                   {"point", scene::TextureFilter::nearest}};
  const auto wrap = wraps.find(parameters.string("wrap").value_or("repeat"));
  if (wrap == wraps.end()) parameters.fail("wrap", "must be repeat, clamp or black");
  const auto filter = filters.find(parameters.string("filter").value_or("bilinear"));
  if (filter == filters.end()) parameters.fail("filter", "must be bilinear, trilinear, ewa or point");
  parameters.ignore({"maxanisotropy"});  // a picture of many samples needs no filter over the pixel
  const scene::TexturePlacement placement = placement_of(parameters, diagnostics);
  double scale = parameters.number_or("scale", 1);
  const bool is_inverted = parameters.boolean_or("invert", false);
  TextureHandle result;
  try {
    auto image =
        read_texture_image(files.find(*name), encoding_of(parameters),
                           is_color ? TexturePart::color : TexturePart::number, *files.budget, parameters.where());
    if (is_inverted && scale != 1) {  // max(0, 1 - scale · value)
      files.budget->take(image->bytes.size() + sizeof(float) * image->floats.size(),
                         "the image " + file_in_quotes(*name), parameters.where());
      image = scaled(*image, std::exchange(scale, 1));
    }
    result = Tex::image(image, placement, wrap->second, filter->second, is_inverted);
  } catch (const std::invalid_argument& error) {
    throw InputError(parameters.where(), in_quotes(*name) + ": " + error.what());
  } catch (const InputError& error) {
    diagnostics.unsupported(parameters.where(), error.message());  // ends the reading unless --lenient goes on
    result = Tex::constant(glm::dvec3(0.5));
  }
  return scale == 1 ? result : Tex::product(result, Tex::constant(glm::dvec3(scale)));
}

}  // namespace

TextureHandle make_texture(const std::string& kind, bool is_color, Parameters& parameters, const Files& files,
                           Diagnostics& diagnostics) {
  const auto part = [&](const char* name, double otherwise) {
    const std::optional<TextureHandle> given =
        is_color ? parameters.color_texture(name) : parameters.number_texture(name);
    return given.value_or(Tex::constant(glm::dvec3(otherwise)));
  };
  const auto number = [&](const char* name, double otherwise) {
    return parameters.number_texture(name).value_or(Tex::constant(glm::dvec3(otherwise)));
  };
  if (kind == "constant") return part("value", 1);
  if (kind == "imagemap") return image_texture(parameters, is_color, files, diagnostics);
  if (kind == "scale") return Tex::product(part("tex", 1), number("scale", 1));
  if (kind == "mix") return Tex::mix(part("tex1", 0), part("tex2", 1), number("amount", 0.5));
  if (kind == "checkerboard") {
    if (parameters.integer("dimension").value_or(2) != 2)
      parameters.unsupported("dimension", "of 3 is not supported: use 2", diagnostics);
    const auto placement = placement_of(parameters, diagnostics);
    return Tex::checkerboard(part("tex1", 1), part("tex2", 0), placement);
  }
  diagnostics.unsupported(parameters.where(),
                          parameters.directive() + " is of kind " + in_quotes(kind) +
                              ", which is not supported: use constant, imagemap, scale, mix or checkerboard");
  parameters.ignore_all();
  return Tex::constant(glm::dvec3(0.5));
}

}  // namespace gmis::tools::pbrt
