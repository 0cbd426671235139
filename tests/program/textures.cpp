#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <memory>
#include <random>
#include <string>

#include "program/read_scene.hpp"
#include "program/scratch_folder.hpp"
#include "support/catch.hpp"
#include "support/image/formats.hpp"
#include "support/image/texture_image.hpp"
#include "support/pbrt/elements.hpp"
#include "support/pbrt/reader.hpp"
#include "support/pbrt/smooth_shapes.hpp"
#include "support/pbrt/spectra.hpp"
#include "support/seed.hpp"

#if GMIS_HAS_PNG
#include <png.h>
#endif

#if GMIS_HAS_OPENEXR
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#endif

// Textures, spectra and curved shapes as they are read; features.cpp renders them.

using namespace gmis::tools;
using gmis_test::Read;
using gmis_test::ScratchFolder;
using gmis_test::text_of;
namespace fs = std::filesystem;

namespace {

const fs::path features = GMIS_FEATURE_FOLDER;
const std::string triangle =
    "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"integer indices\" [ 0 1 2 ]\n";

Read read(const std::string& world, Strictness strictness = Strictness::strict) {
  return gmis_test::reading(strictness, [&](Diagnostics& diagnostics) {
    return read_pbrt_text("WorldBegin\n" + world + triangle, "t.pbrt", features, diagnostics);
  });
}

double area_of(const MeshDescription& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const auto p = [&](std::size_t k) { return mesh.positions.at(static_cast<std::size_t>(t[k])); };
    area += glm::length(glm::cross(p(1) - p(0), p(2) - p(0))) / 2;
  }
  return area;
}

/// Chromaticity x, y of a colour in linear sRGB.
glm::dvec2 chromaticity(const Rgb& c) {
  const glm::dvec3 xyz(0.4124564 * c.x + 0.3575761 * c.y + 0.1804375 * c.z,
                       0.2126729 * c.x + 0.7151522 * c.y + 0.0721750 * c.z,
                       0.0193339 * c.x + 0.1191920 * c.y + 0.9503041 * c.z);
  return glm::dvec2(xyz.x, xyz.y) / (xyz.x + xyz.y + xyz.z);
}

}  // namespace

TEST_CASE("Black bodies and spectra have the colours of the CIE") {
  // The Planckian locus, from CIE 15 (illuminant A; 4000 K; 6500 K). The fit of the matching
  // functions is that good.
  for (const auto& [kelvins, x, y] :
       {std::tuple{2855.5, 0.4476, 0.4074}, {4000.0, 0.3805, 0.3768}, {6500.0, 0.3135, 0.3237}}) {
    CAPTURE(kelvins);
    const Rgb color = pbrt::blackbody(kelvins);
    CHECK(glm::dot(color, Rgb(0.2126, 0.7152, 0.0722)) == Approx(1));
    CHECK(chromaticity(color).x == Approx(x).margin(0.004));
    CHECK(chromaticity(color).y == Approx(y).margin(0.004));
  }
  CHECK(pbrt::blackbody(1000).z == 0.0);  // outside the gamut
  const double grey[] = {360, 0.3, 830, 0.3};
  CHECK(glm::length(pbrt::rgb_of_spectrum(grey) - Rgb(0.3)) < 1e-12);
  const double red[] = {599, 0, 600, 1, 830, 1}, blue[] = {360, 1, 489, 1, 490, 0};
  CHECK(pbrt::rgb_of_spectrum(red).x > 5 * std::abs(pbrt::rgb_of_spectrum(red).y));
  CHECK(pbrt::rgb_of_spectrum(blue).z > 5 * std::abs(pbrt::rgb_of_spectrum(blue).x));
  // Spectra add up, and are 0 beyond their ends.
  const double whole[] = {400, 1, 700, 1}, left[] = {400, 1, 549, 1, 550, 0}, right[] = {549, 0, 550, 1, 700, 1};
  CHECK(glm::length(pbrt::rgb_of_spectrum(left) + pbrt::rgb_of_spectrum(right) - pbrt::rgb_of_spectrum(whole)) < 1e-9);
  const double line[] = {549, 1, 551, 1}, edged[] = {548.999, 0, 549, 1, 551, 1, 551.001, 0};
  CHECK(pbrt::rgb_of_spectrum(line).y < 0.03);
  CHECK(glm::length(pbrt::rgb_of_spectrum(line) - pbrt::rgb_of_spectrum(edged)) < 1e-9);
}

TEST_CASE("Light of a spectrum has the colour of the CIE, by its name and by its pairs, inside sRGB") {
  const auto light = [](const std::string& intensity) {
    const Read result = read("LightSource \"point\" " + intensity + "\n");
    CAPTURE(result.error);
    REQUIRE(result.error.empty());
    CHECK(result.diagnostics.all().empty());
    return std::get<PointLightDescription>(result.scene.lights.at(0).kind).intensity;
  };
  // Illuminant A by the formula of CIE 15, 100 at 560 nm.
  std::string pairs = "\"spectrum I\" [";
  for (int nm = 360; nm <= 830; nm += 5) {
    const auto part = [](double wavelength) { return std::expm1(1.435e7 / (2848 * wavelength)); };
    pairs += " " + std::to_string(nm) + " " + std::to_string(100 * std::pow(560.0 / nm, 5) * part(560) / part(nm));
  }
  const Rgb by_pairs = light(pairs + " ]"), by_name = light("\"spectrum I\" \"stdillum-A\"");
  CHECK(glm::length(by_pairs / pbrt::luminance(by_pairs) - by_name) < 0.01);
  CHECK(light("\"spectrum I\" \"stdillum-D65\"") == Rgb(1));
  CHECK(pbrt::luminance(light("\"spectrum I\" [ 400 2 700 2 ]")) == Approx(2).epsilon(1e-4));
  // A line of light is outside sRGB: it has no channel below 0, and keeps its luminance.
  const double line[] = {548, 0, 549, 1, 551, 1, 552, 0};
  const Rgb raw = pbrt::rgb_of_spectrum(line, pbrt::SpectrumOf::light),
            cut = light("\"spectrum I\" [ 548 0 549 1 551 1 552 0 ]");
  CHECK(raw.x < 0);
  CHECK(std::min({cut.x, cut.y, cut.z}) == 0);
  CHECK(pbrt::luminance(cut) == Approx(pbrt::luminance(raw)));
}

TEST_CASE("Named metals reflect about as much head on as tables for artists say, named glasses have their order") {
  // Linear sRGB, from Hoffman, Physically-Based Shading Models in Film and Game Production (2010);
  // those of gold come from another measurement.
  const std::pair<const char*, Rgb> table[] = {
      {"Au", {1, .71, .29}}, {"Ag", {.95, .93, .88}}, {"Cu", {.95, .64, .54}}, {"Al", {.91, .92, .92}}};
  for (const auto& [name, reflectance] : table) {
    const std::string start = "metal-" + std::string(name);
    const Rgb eta = *pbrt::named_spectrum(start + "-eta"), k = *pbrt::named_spectrum(start + "-k");
    for (int c = 0; c < 3; ++c) {
      const double r = ((eta[c] - 1) * (eta[c] - 1) + k[c] * k[c]) / ((eta[c] + 1) * (eta[c] + 1) + k[c] * k[c]);
      CAPTURE(name, c, r);
      CHECK(std::abs(r - reflectance[c]) < (std::string(name) == "Au" ? .11 : .04));
    }
  }
  double before = 1.4;
  for (const char* glass : {"FK51A", "BK7", "BAF10", "SF5", "SF10", "SF11", "LASF9"}) {
    const double index = pbrt::named_spectrum("glass-" + std::string(glass))->x;
    CAPTURE(glass);
    CHECK(index > before);
    before = index;
  }
  CHECK(pbrt::named_spectrum("glass-F11") == pbrt::named_spectrum("glass-SF11"));
}

TEST_CASE("Spectra by name, by file and by pairs; an unknown name lists the known ones") {
  const Read named = read("Material \"conductor\" \"spectrum eta\" \"metal-Ag-eta\" \"spectrum k\" \"metal-Ag-k\"\n");
  CHECK(named.error.empty());
  CHECK(std::get<ConductorDescription>(named.scene.materials.back().kind).eta.x == Approx(0.1288));
  const Read unknown = read("Material \"conductor\" \"spectrum eta\" \"metal-Xx-eta\"\n");
  for (const char* part :
       {"t.pbrt:2: ", "\"metal-Xx-eta\"", "metal-Cu-eta and -k", "metal-CuZn", "glass-BK7", "stdillum-D65"}) {
    CAPTURE(part);
    CHECK(unknown.error.find(part) != std::string::npos);
  }
  const ScratchFolder folder;
  std::ofstream(folder.path / "s.spd") << "# a comment\n400 .25\n700 .25\n";
  const Read file =
      read("Material \"diffuse\" \"spectrum reflectance\" \"" + (folder.path / "s.spd").string() + "\"\n");
  CHECK(file.error.empty());
  CHECK(std::get<DiffuseDescription>(file.scene.materials.back().kind).reflectance == Rgb(.25));
  const Read falling = read("Material \"diffuse\" \"spectrum reflectance\" [ 500 .1 400 .2 ]\n");
  CHECK(falling.error.find("from low to high") != std::string::npos);
  CHECK(read("LightSource \"point\" \"blackbody I\" [ 3000 2 ]\n").error.empty());
  CHECK(read("LightSource \"point\" \"blackbody I\" 1\n").error.find("kelvins") != std::string::npos);
}

TEST_CASE("Textures that are constant leave no trace, others stay textures") {
  const Read constant = read(
      "Texture \"a\" \"float\" \"constant\" \"float value\" .25\nTexture \"c\" \"spectrum\" \"constant\" \"rgb value\" "
      "[ .8 .4 0 ]\n"
      "Texture \"d\" \"spectrum\" \"scale\" \"texture tex\" \"c\" \"texture scale\" \"a\"\n"
      "Material \"diffuse\" \"texture reflectance\" \"d\"\n");
  CHECK(constant.error.empty());
  const MaterialDescription& plain = constant.scene.materials.back();
  CHECK(plain.textures.is_empty());
  CHECK(glm::length(std::get<DiffuseDescription>(plain.kind).reflectance - Rgb(.2, .1, 0)) < 1e-7);
  const Read varying = read(
      "Texture \"r\" \"float\" \"imagemap\" \"string filename\" \"ramp.png\" \"string encoding\" \"linear\"\n"
      "Material \"coateddiffuse\" \"texture roughness\" \"r\" \"bool remaproughness\" false\n");
  CHECK(varying.error.empty());
  const MaterialTexturesDescription& textures = varying.scene.materials.back().textures;
  REQUIRE(textures.roughness);
  CHECK_FALSE(textures.is_remapped);
  CHECK(textures.roughness->lower().x == 0.0F);
  CHECK(textures.roughness->upper().x == 1.0F);
}

TEST_CASE("What of textures is not supported is said, and its mean stands in for it when lenient") {
  for (const std::string kind : {"fbm", "marble", "wrinkled", "ptex", "windy", "dots"}) {
    const std::string world = "Texture \"t\" \"spectrum\" \"" + kind +
                              "\" \"float roughness\" .5\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\n";
    CHECK(read(world).error.find("t.pbrt:2: ") == 0);
    const Read lenient = read(world, Strictness::lenient);
    CHECK(lenient.error.empty());
    CHECK(std::get<DiffuseDescription>(lenient.scene.materials.back().kind).reflectance == Rgb(.5));
  }
  const std::string image = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"colors.png\" ";
  CHECK(read(image + "\"string mapping\" \"spherical\"\n").error.find("mapping") != std::string::npos);
  CHECK(read(image + "\"string wrap\" \"octahedralsphere\"\n").error.find("wrap") != std::string::npos);
  CHECK(read(image + "\"string encoding\" \"gamma x\"\n").error.find("encoding") != std::string::npos);
  const std::string use = image + "\n LightSource \"point\" \"texture I\" \"t\"\n";
  CHECK(read(use).error.find("varies over the surface") != std::string::npos);
  CHECK(read(use, Strictness::lenient).says("its mean is used"));
  // A texture that cannot be read is reported once, not at each use, too.
  const Read check = read(
      "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"none.png\"\nMaterial \"diffuse\" \"texture "
      "reflectance\" \"t\"\n",
      Strictness::check);
  CHECK(check.diagnostics.error_count() == 1);
  CHECK(check.says("none.png\" is missing"));
  const Read lamp = read("AreaLightSource \"diffuse\"\nShape \"sphere\" \"float alpha\" .5\n");
  CHECK(lamp.error.find("a sphere with alpha cannot be a light") != std::string::npos);
}

#if GMIS_HAS_PNG && GMIS_HAS_STB
TEST_CASE("A number of an image is its alpha where it has one, as in pbrt") {
  // pbrt's MIPMap: the mean of three channels, the last of four, and four only where alpha is not 1
  // everywhere; its .png decodes all four alike, and drops the alpha of grey.
  const ScratchFolder folder;
  const auto write = [&](const std::string& name, int type, int bits, const std::vector<int>& codes) {
    std::FILE* stream = std::fopen((folder.path / name).c_str(), "wb");
    REQUIRE(stream != nullptr);
    png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(writer);
    png_init_io(writer, stream);
    png_set_IHDR(writer, info, 2, 1, bits, type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(writer, info);
    std::vector<png_byte> row;
    for (const int code : codes)
      for (int byte = 0; byte < bits / 8; ++byte) row.push_back(static_cast<png_byte>(code));  // 257 · code
    png_write_row(writer, row.data());
    png_write_end(writer, info);
    png_destroy_write_struct(&writer, &info);
    std::fclose(stream);
  };
  const auto values = [&](const std::string& name, const std::string& encoding) {
    const Read result = read("Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"" + (folder / name) +
                             "\" \"string filter\" \"point\" \"string encoding\" \"" + encoding +
                             "\"\nMaterial \"conductor\" \"texture roughness\" \"t\"\n");
    CAPTURE(result.error);
    const TextureHandle texture = result.scene.materials.back().textures.roughness;
    REQUIRE(texture);
    return glm::dvec2(texture->at({0.25F, 0.5F}).x, texture->at({0.75F, 0.5F}).x);
  };
  const auto srgb = [](int code) { return std::pow((code / 255.0 + 0.055) / 1.055, 2.4); };
  const auto near = [](const glm::dvec2& a, const glm::dvec2& b) { return glm::length(a - b) < 1e-6; };
  for (const int bits : {8, 16}) {
    CAPTURE(bits);
    write("a.png", PNG_COLOR_TYPE_RGB_ALPHA, bits, {20, 30, 40, 128, 50, 60, 70, 255});
    CHECK(near(values("a.png", "sRGB"), {srgb(128), 1}));
    CHECK(near(values("a.png", "linear"), {128 / 255.0, 1}));
    write("a.png", PNG_COLOR_TYPE_RGB_ALPHA, bits, {20, 30, 40, 255, 50, 60, 70, 255});
    CHECK(near(values("a.png", "linear"), {30 / 255.0, 60 / 255.0}));
    write("a.png", PNG_COLOR_TYPE_GRAY_ALPHA, bits, {20, 128, 50, 255});
    CHECK(near(values("a.png", "linear"), {20 / 255.0, 50 / 255.0}));
  }
  // Colours stay colours.
  write("a.png", PNG_COLOR_TYPE_RGB_ALPHA, 8, {20, 30, 40, 128, 50, 60, 70, 255});
  LoadBudget budget;
  const auto colors =
      read_texture_image(folder.path / "a.png", {TextureEncoding::Curve::linear}, TexturePart::color, budget, {});
  CHECK(colors->texel(0, 0).y == Approx(30 / 255.0));
}
#endif

#if GMIS_HAS_OPENEXR
TEST_CASE("A number of an .exr is its alpha where it has one") {
  const ScratchFolder folder;
  const auto values = [&](const std::vector<float>& rgba) {
    Imf::Header header(2, 1);
    Imf::FrameBuffer frame;
    std::vector<float> pixels = rgba;
    const char* const names[] = {"R", "G", "B", "A"};
    for (std::size_t c = 0; c < 4; ++c) {
      header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
      frame.insert(names[c], {Imf::FLOAT, reinterpret_cast<char*>(&pixels[c]), 4 * sizeof(float), 8 * sizeof(float)});
    }
    {
      Imf::OutputFile file((folder / "a.exr").c_str(), header);
      file.setFrameBuffer(frame);
      file.writePixels(1);
    }
    LoadBudget budget;
    const auto image = read_texture_image(folder.path / "a.exr", {}, TexturePart::number, budget, {});
    return glm::vec2(image->texel(0, 0).x, image->texel(1, 0).x);
  };
  CHECK(values({1, 2, 3, 0.25F, 4, 5, 6, 1}) == glm::vec2(0.25F, 1));
  CHECK(values({1, 2, 3, 1, 4, 5, 6, 1}) == glm::vec2(2, 5));
}
#endif

TEST_CASE("What is inverted is scaled before, and is not below 0") {
  const ScratchFolder folder;
  Image image(2, 1);
  image.rgb = {0.1F, 0.2F, 0.3F, 0.4F, 0.6F, 1};
  write_image(image, folder.path / "a.pfm");
  const auto texture = [&](const std::string& type, const std::string& rest) {
    const Read result = read("Texture \"t\" \"" + type + "\" \"imagemap\" \"string filename\" \"" + (folder / "a.pfm") +
                             "\" \"bool invert\" true " + rest + "\nMaterial \"conductor\" \"texture " +
                             (type == "float" ? "roughness" : "reflectance") + "\" \"t\"\n");
    CAPTURE(result.error);
    REQUIRE(result.error.empty());
    const MaterialTexturesDescription& textures = result.scene.materials.back().textures;
    return type == "float" ? textures.roughness : textures.color;
  };
  // max(0, 1 − scale · value), in pbrt's textures.h and textures.cpp.
  const auto colors = texture("spectrum", "\"float scale\" 2 \"string wrap\" \"clamp\"");
  CHECK(glm::length(colors->at({0, 0.5F}) - glm::vec3(0.8F, 0.6F, 0.4F)) < 1e-6F);
  CHECK(glm::length(colors->at({1, 0.5F}) - glm::vec3(0.2F, 0, 0)) < 1e-6F);
  CHECK(glm::length(colors->at({0.5F, 0.5F}) - glm::vec3(0.5F, 0.2F, 0)) < 1e-6F);  // in between, then cut
  CHECK(texture("float", "\"float scale\" .5")->at({0.25F, 0.5F}).x == Approx(1 - 0.5 * 0.2));
  CHECK(texture("float", "")->at({0.25F, 0.5F}).x == Approx(0.8));
}

TEST_CASE("A normal map that cannot be used is an error with its place, and left out when lenient") {
  const ScratchFolder folder;
  Image image(1, 1);
  image.rgb = {0.5F, std::nanf(""), 1};
  write_image(image, folder.path / "nan.pfm");
  for (const char* name : {"nan.pfm", "none.png"}) {
    CAPTURE(name);
    const std::string world = "Material \"diffuse\"\n\"string normalmap\" \"" + (folder / name) + "\"\n";
    CHECK(read(world).error.find("t.pbrt:3: ") == 0);
    const Read lenient = read(world, Strictness::lenient);
    CHECK(lenient.error.empty());
    CHECK(lenient.count("t.pbrt:3: warning: ") == 1);
    CHECK(lenient.scene.materials.back().textures.is_empty());
    CHECK(read(world, Strictness::check).diagnostics.error_count() == 1);
  }
}

TEST_CASE("Images of every kind have the values that were written") {
  const ScratchFolder folder;
  LoadBudget budget;
  Image image(3, 2);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<float>(i) * 0.5F;
  std::vector<std::string> names{"a.pfm"};
  if (has_exr()) names.emplace_back("a.exr");
  for (const std::string& name : names) {
    write_image(image, folder.path / name);
    const auto read_back = read_texture_image(folder.path / name, {}, TexturePart::color, budget, {});
    CHECK(read_back->resolution == glm::ivec2(3, 2));
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 3; ++x)
        for (int c = 0; c < 3; ++c)
          CHECK(read_back->texel(x, y)[c] == image.rgb[image.index(x, y) + static_cast<std::size_t>(c)]);
    for (const TexturePart part : {TexturePart::grey, TexturePart::number})
      CHECK(read_texture_image(folder.path / name, {}, part, budget, {})->texel(1, 0).x == Approx(2));
  }
  const auto png =
      read_texture_image(features / "colors.png", {TextureEncoding::Curve::linear}, TexturePart::color, budget, {});
  const auto tga =
      read_texture_image(features / "colors.tga", {TextureEncoding::Curve::linear}, TexturePart::color, budget, {});
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      CHECK(png->texel(x, y) == tga->texel(x, y));
      CHECK(png->texel(x, y).x == Approx((60 * x + 20) / 255.0));
      CHECK(png->texel(x, y).y == Approx((60 * y + 20) / 255.0));
    }
  CHECK(read_texture_image(features / "colors.png", {}, TexturePart::alpha, budget, {})->texel(1, 1).x == 1.0F);
  std::ofstream(folder.path / "half.hdr", std::ios::binary)
      << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x80";  // 1/2 in each channel
  CHECK(read_texture_image(folder.path / "half.hdr", {}, TexturePart::grey, budget, {})->texel(0, 0).x == Approx(0.5));
  CHECK(read_texture_image(folder.path / "half.hdr", {}, TexturePart::alpha, budget, {})->texel(0, 0).x == 1.0F);
  CHECK(read_texture_image(features / "ramp.png", {}, TexturePart::color, budget, {})->channels == 1);
}

TEST_CASE("Images cut short or with bytes changed are read or refused, and never more") {
  const ScratchFolder folder;
  LoadBudget budget;
  std::mt19937 random(static_cast<std::mt19937::result_type>(gmis_test::seed(321)));
  int refused = 0;
  for (const char* name : {"colors.png", "colors.tga", "flat.jpg"}) {
    const std::string whole = text_of(features / name);
    for (int i = 0; i < 300; ++i) {
      std::string broken = whole;
      if (i % 2 == 0) broken.resize(random() % whole.size());
      for (int k = 0; k < 3 && !broken.empty(); ++k) broken[random() % broken.size()] = static_cast<char>(random());
      const fs::path file = folder.path / name;
      std::ofstream(file, std::ios::binary | std::ios::trunc) << broken;
      try {
        const auto image = read_texture_image(file, {}, TexturePart::color, budget, {});
        CHECK(image->resolution.x > 0);
        CHECK_NOTHROW(gmis::scene::Texture<float>::image(image));
      } catch (const InputError& error) {
        CHECK(std::string(error.what()).find(name) != std::string::npos);
        ++refused;
      }
    }
  }
  CHECK(refused > 100);
  std::ofstream(folder.path / "text.png") << "no image";
  CHECK_THROWS_AS(read_texture_image(folder.path / "text.png", {}, TexturePart::color, budget, {}), InputError);
  CHECK_THROWS_AS(read_texture_image(folder.path, {}, TexturePart::color, budget, {}), InputError);
}

TEST_CASE("A JPEG without its Huffman tables is grey, whatever was in memory before") {
  std::string jpeg = text_of(features / "flat.jpg");
  for (std::size_t at; (at = jpeg.find("\xff\xc4")) != std::string::npos;) jpeg[at + 1] = '\xe2';  // of an application
  std::fill_n(std::make_unique<char[]>(1U << 16U).get(), 1U << 16U, '\x5a');
  LoadBudget budget;
  const auto image = read_texture_image(reinterpret_cast<const unsigned char*>(jpeg.data()), jpeg.size(), "a.jpg",
                                        {TextureEncoding::Curve::linear}, TexturePart::color, budget, {});
  for (int c = 0; c < 3; ++c) CHECK(image->texel(1, 1)[c] == Approx(128 / 255.0));
}

TEST_CASE("A pixel that unpacks to 4 MiB is refused where there is 1 MiB, and read where there is more") {
  const auto read_with = [](std::uintmax_t memory) {
    LoadBudget budget(memory);
    return read_texture_image(features / "unpacks.png", {}, TexturePart::color, budget, {})->resolution;
  };
  CHECK_THROWS_WITH(read_with(1U << 20U), Catch::Contains("unpacks.png") && Catch::Contains("--max-memory"));
  CHECK(read_with(1U << 24U) == glm::ivec2(1, 1));
}

TEST_CASE("Disks, cylinders and parts of spheres have the areas and sides of the curved shapes") {
  using namespace gmis::tools::pbrt;
  constexpr double pi = 3.14159265358979323846;
  CHECK(area_of(mesh_of(DiskShape{2, 1.5, 0, 360})) == Approx(pi * 1.5 * 1.5));
  CHECK(area_of(mesh_of(DiskShape{2, 1.5, 0.5, 90})) == Approx(pi * (1.5 * 1.5 - 0.25) / 4));
  CHECK(area_of(mesh_of(CylinderShape{0.5, -1, 2, 180})) == Approx(pi * 0.5 * 3));
  CHECK(area_of(mesh_of(PartialSphere{2, 0, 2, 360})) == Approx(2 * pi * 4).epsilon(1e-3));
  const auto is_turned = [](const MeshDescription& mesh, const auto& outward) {
    for (const auto& t : mesh.triangles) {
      const auto p = [&](std::size_t k) { return mesh.positions.at(static_cast<std::size_t>(t[k])); };
      if (!(glm::dot(glm::cross(p(1) - p(0), p(2) - p(0)), outward(p(0) + p(1) + p(2))) > 0)) return false;
    }
    return true;
  };
  CHECK(is_turned(mesh_of(DiskShape{1, 1.5, 0.5, 300}), [](const Point&) { return glm::dvec3(0, 0, 1); }));
  CHECK(is_turned(mesh_of(CylinderShape{0.5, -1, 2, 360}), [](const Point& p) { return glm::dvec3(p.x, p.y, 0); }));
  CHECK(is_turned(mesh_of(PartialSphere{2, -1, 2, 270}), [](const Point& p) { return p; }));
  CHECK(read("Shape \"disk\" \"float innerradius\" 2\n").error.find("innerradius") != std::string::npos);
  CHECK(read("Shape \"cylinder\" \"float zmin\" 2\n").error.find("zmin") != std::string::npos);
}

TEST_CASE("Loop's subdivision goes to its limit") {
  using namespace gmis::tools::pbrt;
  // A flat grid stays flat, an octahedron becomes round and symmetric, and more levels change no
  // vertex of the coarse mesh.
  MeshDescription octahedron;
  octahedron.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  const auto coarse = loop_subdivided(octahedron, 1), fine = loop_subdivided(octahedron, 4);
  REQUIRE(coarse);
  REQUIRE(fine);
  CHECK(fine->triangles.size() == 8U << 8U);
  CHECK(fine->positions.size() == fine->triangles.size() / 2 + 2);  // Euler
  for (std::size_t i = 0; i < coarse->positions.size(); ++i)
    CHECK(glm::length(coarse->positions[i] - fine->positions[i]) < 1e-12);
  // The limit of a vertex of valence 4 whose ring has its middle at 0: (1 − 4 w) p, w = 1 / (4 + 3
  // / (8 · 3/32)).
  CHECK(fine->positions[4].z == Approx(1 - 4 / (4 + 4.0)));
  for (std::size_t i = 0; i < fine->positions.size(); ++i) {
    CHECK(glm::length(fine->normals[i]) == Approx(1));
    CHECK(glm::dot(fine->normals[i], glm::normalize(fine->positions[i])) > 0.9);
  }
  MeshDescription wrong = octahedron;
  wrong.triangles.push_back({0, 2, 5});
  CHECK_FALSE(loop_subdivided(wrong, 2));
  wrong = octahedron;
  std::swap(wrong.triangles[3][0], wrong.triangles[3][1]);
  CHECK_FALSE(loop_subdivided(wrong, 2));
  CHECK(read("Shape \"loopsubdiv\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 1 ]\n")
            .error.find("indices") != std::string::npos);
}

TEST_CASE("A packed mesh is read with its coordinates, a damaged one refused") {
  const Read whole = read("Shape \"plymesh\" \"string filename\" \"quad.ply.gz\"\n");
  CHECK(whole.error.empty());
  const auto& mesh = std::get<MeshDescription>(whole.scene.shapes.at(0).geometry);
  CHECK(mesh.triangles.size() == 2);
  REQUIRE(mesh.uv.size() == 4);
  for (std::size_t i = 0; i < 4; ++i)
    CHECK(mesh.uv[i] == glm::dvec2((mesh.positions[i].x + 1) / 2, (mesh.positions[i].y + 1) / 2));
  const ScratchFolder folder;
  const std::string bytes = text_of(features / "quad.ply.gz");
  for (const std::size_t length : {std::size_t{0}, std::size_t{5}, bytes.size() / 2, bytes.size() - 9}) {
    CAPTURE(length);
    std::ofstream(folder.path / "cut.ply.gz", std::ios::binary | std::ios::trunc) << bytes.substr(0, length);
    CHECK_FALSE(read("Shape \"plymesh\" \"string filename\" \"" + (folder.path / "cut.ply.gz").string() + "\"\n")
                    .error.empty());
  }
}
