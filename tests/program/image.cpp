#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "gmis/result/image_error.hpp"
#include "program/scratch_folder.hpp"
#include "support/catch.hpp"
#include "support/diagnostics.hpp"
#include "support/image/formats.hpp"
#include "support/seed.hpp"

#if GMIS_HAS_PNG
#include <png.h>
#endif

#if GMIS_HAS_OPENEXR
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#endif

using namespace gmis::tools;
namespace fs = std::filesystem;
using gmis_test::ScratchFolder;
using gmis_test::text_of;

namespace {

Image noise(int width, int height) {
  Image image(width, height);
  std::mt19937 random(gmis_test::seed(7));
  for (float& value : image.rgb)
    value = std::ldexp(static_cast<float>(random()), static_cast<int>(random() % 60U) - 60);
  return image;
}

bool same_bits(const Image& a, const Image& b) {
  return a.width == b.width && a.height == b.height && a.rgb.size() == b.rgb.size() &&
         std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof(float)) == 0;
}

#if GMIS_HAS_PNG
/// The values of a .png, three bytes a pixel.
std::vector<unsigned char> png_bytes(const fs::path& file) {
  png_image read{};
  read.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&read, file.c_str()) != 0);
  read.format = PNG_FORMAT_RGB;
  std::vector<unsigned char> bytes(PNG_IMAGE_SIZE(read));
  REQUIRE(png_image_finish_read(&read, nullptr, bytes.data(), 0, nullptr) != 0);
  return bytes;
}

/// The texts in a .png, name and content.
std::vector<std::pair<std::string, std::string>> png_texts(const fs::path& file) {
  const auto fail = [](png_structp, png_const_charp message) { throw std::runtime_error(message); };
  png_structp reader = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, fail);  // warnings fail, too
  png_infop info = png_create_info_struct(reader);
  std::FILE* stream = std::fopen(file.c_str(), "rb");
  REQUIRE(stream != nullptr);
  png_init_io(reader, stream);
  png_read_info(reader, info);
  png_textp texts = nullptr;
  int count = 0;
  png_get_text(reader, info, &texts, &count);
  std::vector<std::pair<std::string, std::string>> result;
  for (int i = 0; i < count; ++i) result.emplace_back(texts[i].key, texts[i].text);
  png_destroy_read_struct(&reader, &info, nullptr);
  std::fclose(stream);
  return result;
}
#endif

}  // namespace

TEST_CASE("A reduced image has the means of blocks") {
  const Image image = noise(6, 4);
  const Image small = reduced(image, 2);
  REQUIRE(small.width == 3);
  REQUIRE(small.height == 2);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 3; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto at = [&](int i, int j) { return static_cast<long double>(image.rgb[image.index(i, j) + c]); };
        const long double sum =
            at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1);
        CHECK(small.rgb[small.index(x, y) + c] == static_cast<float>(sum / 4));
      }
}

TEST_CASE("PFM and EXR give back every bit") {
  const ScratchFolder folder;
  const Image image = noise(7, 5);
  for (const char* name : {"a.pfm", "a.PFM", "a.exr"}) {
    CAPTURE(name);
    if (std::string(name) == "a.exr" && !has_exr()) continue;
    write_image(image, folder.path / name);
    CHECK(same_bits(read_image(folder.path / name), image));
  }
}

TEST_CASE("PFM holds rows from the bottom, little-endian") {
  const ScratchFolder folder;
  Image image(1, 2);
  image.rgb = {1, 2, 3, 4, 5, 6};
  write_pfm(image, folder.path / "a.pfm");
  const std::string text = text_of(folder.path / "a.pfm");
  const std::string header = "PF\n1 2\n-1.0\n";
  REQUIRE(text.size() == header.size() + 24);
  CHECK(text.substr(0, header.size()) == header);
  // 4.0f is 0x40800000.
  CHECK(text.substr(header.size(), 4) == std::string("\x00\x00\x80\x40", 4));
}

TEST_CASE("PFM in the other byte order, and grey") {
  const ScratchFolder folder;
  std::ofstream(folder.path / "big.pfm", std::ios::binary) << "Pf\n2 1\n1.0\n"
                                                           << std::string("\x40\x80\x00\x00\x3f\x80\x00\x00", 8);
  const Image image = read_pfm(folder.path / "big.pfm");
  CHECK(image.rgb == std::vector<float>{4, 4, 4, 1, 1, 1});
}

TEST_CASE("The size of a PFM's scale is a factor of its values") {
  const ScratchFolder folder;
  const auto values = [&](const std::string& kind_and_scale, const std::string& bytes) {
    const std::size_t space = kind_and_scale.find(' ');
    std::ofstream(folder.path / "a.pfm", std::ios::binary) << kind_and_scale.substr(0, space) << "\n1 1\n"
                                                           << kind_and_scale.substr(space + 1) << "\n"
                                                           << bytes;
    return read_pfm(folder.path / "a.pfm").rgb;
  };
  CHECK(values("Pf 2.5", std::string("\x40\x80\x00\x00", 4)) == std::vector<float>{10, 10, 10});
  CHECK(values("Pf -0.5", std::string("\x00\x00\x80\x40", 4)) == std::vector<float>{2, 2, 2});
  CHECK(values("PF 2", std::string("\x40\x80\x00\x00\x3f\x80\x00\x00\xbf\x80\x00\x00", 12)) ==
        std::vector<float>{8, 2, -2});
}

TEST_CASE("Files that are no images are refused") {
  const ScratchFolder folder;
  for (const char* text :
       {"", "P6\n1 1\n255\n", "PF\n0 1\n-1\n", "PF\n99999999 99999999\n-1\n", "PF\n2 2\n-1\nabc", "PF\n1 1\nnan\n"}) {
    CAPTURE(text);
    std::ofstream(folder.path / "a.pfm", std::ios::binary) << text;
    CHECK_THROWS_AS(read_image(folder.path / "a.pfm"), InputError);
    if (!has_exr()) continue;
    std::ofstream(folder.path / "a.exr", std::ios::binary) << text;
    CHECK_THROWS_AS(read_image(folder.path / "a.exr"), InputError);
  }
  CHECK_THROWS_AS(read_image(folder.path / "absent.pfm"), InputError);
  CHECK_THROWS_AS(read_image(folder.path / "a.jpg"), InputError);
  CHECK_THROWS_AS(require_writable_format("a.jpg"), InputError);
  CHECK_THROWS_AS(write_image(Image(1, 1), folder.path / "no_such_folder" / "a.pfm"), OutputError);
}

#if GMIS_HAS_PNG
TEST_CASE("PNG holds the sRGB curve and survives any value") {
  const ScratchFolder folder;
  Image image(4, 1);
  const float infinity = std::numeric_limits<float>::infinity();
  // 0.21404114 is the linear value of sRGB 0.5; 0.002 lies on the straight part: 12.92 * 0.002 *
  // 255 = 6.6.
  image.rgb = {0, 1, 0.21404114F, 0.002F, -1, 7, infinity, -infinity, std::numeric_limits<float>::quiet_NaN(), 0.5F,
               0, 0};
  write_png(image, folder.path / "a.png");
  const std::vector<unsigned char> bytes = png_bytes(folder.path / "a.png");
  CHECK(bytes == std::vector<unsigned char>{0, 255, 128, 7, 0, 255, 255, 0, 0, 188, 0, 0});
}

TEST_CASE("PNG holds the notes, and the same pixels") {
  const ScratchFolder folder;
  ImageExtras extras;
  extras.notes = {{"gmis:exposure", "-1.5"}, {"gmis:commandLine", "gmis-render \u03bb.pbrt"}, {"empty", ""}};
  const Image image = noise(5, 3);
  write_png(image, folder.path / "plain.png");
  write_png(image, folder.path / "notes.png", extras);
  CHECK(png_texts(folder.path / "notes.png") == extras.notes);
  CHECK(png_texts(folder.path / "plain.png").empty());
  CHECK(png_bytes(folder.path / "notes.png") == png_bytes(folder.path / "plain.png"));
}

TEST_CASE("The tone curves are those that are stated") {
  const ScratchFolder folder;
  Image image(4, 1);
  const float infinity = std::numeric_limits<float>::infinity();
  image.rgb = {0.5F, 2, 0.25F, 0, 0, 0, 40, 1, 0.1F, infinity, -1, std::numeric_limits<float>::quiet_NaN()};
  const auto code = [](double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    return std::lround(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055));
  };
  const double exposure = 2;
  for (const ToneCurve tone : {ToneCurve::clamp, ToneCurve::reinhard, ToneCurve::filmic}) {
    ImageExtras extras;
    extras.exposure = static_cast<float>(exposure);
    extras.tone = tone;
    write_image(image, folder.path / "a.png", extras);
    const std::vector<unsigned char> bytes = png_bytes(folder.path / "a.png");
    for (std::size_t pixel = 0; pixel < 3; ++pixel) {
      const auto x = [&](std::size_t c) { return exposure * double(image.rgb[3 * pixel + c]); };
      const double luminance = 0.2126 * x(0) + 0.7152 * x(1) + 0.0722 * x(2);
      for (std::size_t c = 0; c < 3; ++c) {
        const double expected = tone == ToneCurve::clamp ? x(c)
                                : tone == ToneCurve::reinhard
                                    ? x(c) / (1 + luminance)
                                    : x(c) * (2.51 * x(c) + 0.03) / (x(c) * (2.43 * x(c) + 0.59) + 0.14);
        CAPTURE(static_cast<int>(tone), pixel, c);
        CHECK(std::abs(int{bytes[3 * pixel + c]} - code(expected)) <= (tone == ToneCurve::clamp ? 0 : 1));
      }
    }
    CHECK(int{bytes[9]} == 255);
    CHECK(int{bytes[10]} == 0);
    CHECK(int{bytes[11]} == 0);
  }
}
#endif

TEST_CASE("The hash sees every bit and the shape") {
  Image image = noise(6, 4);
  const std::string before = image_hash(image);
  CHECK(before.size() == 16);
  CHECK(image_hash(noise(6, 4)) == before);
  image.rgb[5] = std::bit_cast<float>(std::bit_cast<std::uint32_t>(image.rgb[5]) ^ 1U);
  CHECK(image_hash(image) != before);
  Image turned = noise(6, 4);
  std::swap(turned.width, turned.height);
  CHECK(image_hash(turned) != before);
}

TEST_CASE("A crop is the pixels of its rectangle") {
  const Image image = noise(6, 4);
  const Image part = cropped(image, 2, 1, 5, 3);
  REQUIRE(part.width == 3);
  REQUIRE(part.height == 2);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 3; ++x) CHECK(part.rgb[part.index(x, y)] == image.rgb[image.index(x + 2, y + 1)]);
}

TEST_CASE("Image errors, by hand") {
  SECTION("two pixels of one channel") {
    const std::vector<float> image{1.5F, 0.0F};
    const std::vector<float> reference{1.0F, 0.1F};
    const auto error = gmis::image_error(std::span<const float>(image), std::span<const float>(reference), 1);
    CHECK(error.relmse == Approx((0.25 / 1.01 + 0.01 / 0.02) / 2).epsilon(1e-6));
    CHECK(error.rmse == Approx(std::sqrt((0.25 + 0.01) / 2)).epsilon(1e-6));
    CHECK(error.relmse_trimmed == error.relmse);  // 0.1 % of 2 pixels is none
  }
  SECTION("the worst pixels are dropped whole") {
    std::vector<double> image(3 * 2000, 1.1);
    const std::vector<double> reference(3 * 2000, 1.0);
    image[300] = 1000.0;
    image[3001] = 500.0;
    const auto error = gmis::image_error(std::span<const double>(image), std::span<const double>(reference), 3);
    CHECK(error.relmse_trimmed == Approx(0.01 / 1.01));
    CHECK(error.relmse == Approx(((6000 - 2) * 0.01 + 999.0 * 999.0 + 499.0 * 499.0) / 1.01 / 6000));
  }
  SECTION("NaN shows in the full error and is trimmed as the worst") {
    std::vector<float> image(1000, 1.0F);
    const std::vector<float> reference(1000, 1.0F);
    image[3] = std::numeric_limits<float>::quiet_NaN();
    const auto error = gmis::image_error(std::span<const float>(image), std::span<const float>(reference), 1);
    CHECK(std::isnan(error.relmse));
    CHECK(error.relmse_trimmed == 0.0);
  }
  SECTION("nothing to compare") {
    const std::vector<float> none;
    CHECK(gmis::image_error(std::span<const float>(none), std::span<const float>(none), 3).relmse == 0.0);
  }
}

#if GMIS_HAS_OPENEXR

TEST_CASE("An .exr is colours, or grey, or refused with the names of its channels") {
  const ScratchFolder folder;
  const auto write_with = [&](const std::vector<const char*>& channels) {
    Imf::Header header(2, 1);
    Imf::FrameBuffer frame;
    std::vector<float> values(2 * channels.size());
    for (std::size_t c = 0; c < channels.size(); ++c) {
      header.channels().insert(channels[c], Imf::Channel(Imf::FLOAT));
      frame.insert(channels[c],
                   {Imf::FLOAT, reinterpret_cast<char*>(&values[2 * c]), sizeof(float), 2 * sizeof(float)});
      values[2 * c] = static_cast<float>(c + 1);
      values[2 * c + 1] = -static_cast<float>(c + 1);
    }
    const std::string name = (folder.path / "a.exr").string();
    Imf::OutputFile file(name.c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(1);
  };
  const auto pixels_of = [&](const std::vector<const char*>& channels) {
    write_with(channels);
    return read_image(folder.path / "a.exr").rgb;
  };
  CHECK(pixels_of({"B", "R", "G", "Z"}) == std::vector<float>{2, 3, 1, -2, -3, -1});
  CHECK(pixels_of({"Z", "Y"}) == std::vector<float>{2, 2, 2, -2, -2, -2});
  CHECK(pixels_of({"height"}) == std::vector<float>{1, 1, 1, -1, -1, -1});  // as pbrt has one channel
  CHECK_THROWS_WITH(pixels_of({"albedo.R", "Z"}),
                    Catch::Contains("a.exr: ") && Catch::Contains("\"Z\", \"albedo.R\":"));
  CHECK_THROWS_WITH(pixels_of({"R", "G"}), Catch::Contains("has the channels \"G\", \"R\""));
}

TEST_CASE("An .exr keeps layers and notes beside the picture") {
  const ScratchFolder folder;
  Image picture(2, 1), albedo(2, 1), depth(2, 1);
  picture.rgb = {1, 2, 3, 4, 5, 6};
  albedo.rgb = {.1F, .2F, .3F, .4F, .5F, .6F};
  depth.rgb = {7, 0, 0, 8, 0, 0};
  ImageExtras extras;
  extras.notes = {{"gmis:seed", "42"}};
  extras.layers = {{"albedo", "RGB", albedo}, {"depth", "Z", depth}};
  write_image(picture, folder.path / "a.exr", extras);
  CHECK(read_image(folder.path / "a.exr").rgb == picture.rgb);
  Imf::InputFile file((folder.path / "a.exr").string().c_str());
  CHECK(file.header().typedAttribute<Imf::StringAttribute>("gmis:seed").value() == "42");
  float found[2][4] = {};
  Imf::FrameBuffer frame;
  const char* const names[] = {"albedo.R", "albedo.G", "albedo.B", "depth.Z"};
  for (std::size_t c = 0; c < 4; ++c)
    frame.insert(names[c], {Imf::FLOAT, reinterpret_cast<char*>(&found[0][c]), sizeof found[0], sizeof found});
  file.setFrameBuffer(frame);
  file.readPixels(0, 0);
  for (std::size_t x = 0; x < 2; ++x) {
    for (std::size_t c = 0; c < 3; ++c) CHECK(found[x][c] == albedo.rgb[3 * x + c]);
    CHECK(found[x][3] == depth.rgb[3 * x]);
  }
}

#endif
