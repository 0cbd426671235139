#include <string>
#include <vector>

#include "support/diagnostics.hpp"
#include "support/image/formats.hpp"

#if GMIS_HAS_OPENEXR
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#endif

namespace gmis::tools {

#if GMIS_HAS_OPENEXR

bool has_exr() {
  return true;
}

namespace {

constexpr const char* channel_names[] = {"R", "G", "B"};

Imf::Slice slice_of(float* first, const Image& image, std::size_t channels = 3) {
  return {Imf::FLOAT, reinterpret_cast<char*>(first), channels * sizeof(float),
          channels * sizeof(float) * static_cast<std::size_t>(image.width)};
}

/// The name of the channel of a grey image, empty for one of colours. Throws `InputError` where
/// there is neither.
std::string grey_channel(const Imf::ChannelList& channels, const std::string& file) {
  const auto has = [&](const char* name) { return channels.findChannel(name) != nullptr; };
  if (has("R") && has("G") && has("B")) return "";
  if (has("Y")) return "Y";
  std::string names;
  int count = 0;
  constexpr int most = 8;
  for (auto channel = channels.begin(); channel != channels.end(); ++channel, ++count)
    if (count < most) names += (count == 0 ? "" : ", ") + in_quotes(channel.name());
  if (count == 1) return channels.begin().name();
  throw InputError(file + ": this OpenEXR file has the channels " + names + (count > most ? ", …" : "") +
                   ": an image needs \"R\", \"G\" and \"B\", or \"Y\"");
}

}  // namespace

void write_exr(const Image& image, const std::filesystem::path& file, const ImageExtras& extras) {
  try {
    Imf::Header header(image.width, image.height);
    Imf::FrameBuffer frame;
    std::vector<float> rgb = image.rgb;  // the library wants it writable
    for (std::size_t c = 0; c < 3; ++c) {
      header.channels().insert(channel_names[c], Imf::Channel(Imf::FLOAT));
      frame.insert(channel_names[c], slice_of(rgb.data() + c, image));
    }
    std::vector<ImageLayer> layers = extras.layers;
    for (ImageLayer& layer : layers)
      for (std::size_t c = 0; c < layer.channels.size() && c < 3; ++c) {
        const std::string name = layer.name + "." + layer.channels[c];
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        frame.insert(name, slice_of(layer.image.rgb.data() + c, layer.image));
      }
    for (const auto& [name, text] : extras.notes) header.insert(name, Imf::StringAttribute(text));
    Imf::OutputFile output(file.string().c_str(), header);
    output.setFrameBuffer(frame);
    output.writePixels(image.height);
  } catch (const std::exception&) {
    throw OutputError(file.string() + ": this file cannot be written: check that the folder exists and has space");
  }
}

Image read_exr(const std::filesystem::path& file, LoadBudget* budget, std::vector<float>* alpha) {
  try {
    Imf::InputFile input(file.string().c_str());
    const Imath::Box2i window = input.header().dataWindow();
    const double width = static_cast<double>(window.max.x) - window.min.x + 1;
    const double height = static_cast<double>(window.max.y) - window.min.y + 1;
    constexpr double largest = 32768;
    if (!(width >= 1 && width <= largest && height >= 1 && height <= largest))
      throw InputError(file.string() + ": this OpenEXR file has sides that are not from 1 to 32768 pixels");
    count_pixels(budget, file, static_cast<int>(width), static_cast<int>(height));
    Image image(static_cast<int>(width), static_cast<int>(height));
    const Imf::ChannelList& channels = input.header().channels();
    const std::string grey = grey_channel(channels, file.string());
    Imf::FrameBuffer frame;
    const std::ptrdiff_t to_corner =
        -(window.min.x + static_cast<std::ptrdiff_t>(window.min.y) * image.width);  // where pixel (0, 0) would be
    if (!grey.empty()) {
      frame.insert(grey, slice_of(image.rgb.data() + 3 * to_corner, image));
    } else {
      for (int c = 0; c < 3; ++c) frame.insert(channel_names[c], slice_of(image.rgb.data() + 3 * to_corner + c, image));
      if (alpha != nullptr && channels.findChannel("A") != nullptr) {
        if (budget != nullptr)
          budget->take(image.rgb.size() / 3, sizeof(float), "the image " + file_in_quotes(file.string()), {});
        alpha->resize(image.rgb.size() / 3);
        frame.insert("A", slice_of(alpha->data() + to_corner, image, 1));
      }
    }
    input.setFrameBuffer(frame);
    input.readPixels(window.min.y, window.max.y);
    if (!grey.empty())
      for (std::size_t i = 0; i < image.rgb.size(); i += 3) image.rgb[i + 1] = image.rgb[i + 2] = image.rgb[i];
    return image;
  } catch (const InputError&) {
    throw;
  } catch (const std::exception&) {
    throw InputError(file.string() + ": this is no OpenEXR file that can be read");
  }
}

#else

bool has_exr() {
  return false;
}

void write_exr(const Image&, const std::filesystem::path& file, const ImageExtras&) {
  throw InputError(file.string() + ": this program was built without OpenEXR: use .pfm");
}

Image read_exr(const std::filesystem::path& file, LoadBudget*, std::vector<float>*) {
  throw InputError(file.string() + ": this program was built without OpenEXR: use .pfm");
}

#endif

}  // namespace gmis::tools
