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

Imf::Slice slice_of(float* first, const Image& image) {
  return {Imf::FLOAT, reinterpret_cast<char*>(first), 3 * sizeof(float),
          3 * sizeof(float) * static_cast<std::size_t>(image.width)};
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

Image read_exr(const std::filesystem::path& file, LoadBudget* budget) {
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
    const bool is_grey = input.header().channels().findChannel("R") == nullptr;
    const char* const grey = "Y";
    Imf::FrameBuffer frame;
    const std::ptrdiff_t to_corner =
        -(window.min.x + static_cast<std::ptrdiff_t>(window.min.y) * image.width) * 3;  // where pixel (0, 0) would be
    if (is_grey) {
      frame.insert(grey, slice_of(image.rgb.data() + to_corner, image));
    } else {
      for (int c = 0; c < 3; ++c) frame.insert(channel_names[c], slice_of(image.rgb.data() + to_corner + c, image));
    }
    input.setFrameBuffer(frame);
    input.readPixels(window.min.y, window.max.y);
    if (is_grey)
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

Image read_exr(const std::filesystem::path& file, LoadBudget*) {
  throw InputError(file.string() + ": this program was built without OpenEXR: use .pfm");
}

#endif

}  // namespace gmis::tools
