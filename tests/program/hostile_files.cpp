#include <sys/resource.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "program/read_scene.hpp"
#include "program/scratch_folder.hpp"
#include "support/catch.hpp"
#include "support/gltf/reader.hpp"
#include "support/message_of.hpp"
#include "support/pbrt/reader.hpp"
#include "support/read_scene.hpp"

// Files that are made to take all time or all memory, or to look at what is not theirs: each is
// refused in one line that names the reason.

using namespace gmis::tools;
using gmis_test::ScratchFolder;

namespace {

void write(const ScratchFolder& folder, const std::string& name, const std::string& text) {
  std::ofstream(folder.path / name, std::ios::binary) << text;
}

/// The error that ends the reading; empty when all is read.
std::string error_of(const std::filesystem::path& file, const LoadOptions& options = {}) {
  Diagnostics diagnostics;
  return gmis_test::message_of<InputError>([&] { return read_scene(file, diagnostics, options); });
}

std::string pbrt_error(const std::string& text, const LoadOptions& options = {}) {
  Diagnostics diagnostics;
  return gmis_test::message_of<InputError>([&] { return read_pbrt_text(text, "t.pbrt", ".", diagnostics, options); });
}

const std::string triangle =
    "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"integer indices\" [ 0 1 2 ]\n";

/// A scene with this image as a texture.
std::string with_image(const ScratchFolder& folder, const std::string& name) {
  return "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"" + (folder / name) + "\"\n" +
         triangle;
}

/// A file of glTF with these members beside its version.
std::string gltf(const std::string& members) {
  return "{\"asset\":{\"version\":\"2.0\"}" + (members.empty() ? "" : "," + members) + "}";
}

/// All of these files together are held to what one may take, 10 seconds of processor time and 2
/// GB: the program is ended, or gets no memory, where they take more. The sanitizers need more of
/// both.
bool limit_program() {
#ifndef GMIS_UNDER_SANITIZERS
  const rlimit seconds{10, 10}, bytes{rlim_t{2} << 30, rlim_t{2} << 30};
  return setrlimit(RLIMIT_CPU, &seconds) == 0 && setrlimit(RLIMIT_AS, &bytes) == 0;
#else
  return true;
#endif
}
const bool is_limited = limit_program();

const LoadOptions small_memory{std::uintmax_t{64} << 20, {}, {}}, little_memory{std::uintmax_t{1} << 20, {}, {}};

/// `count` times the number 0.
std::string zeros(std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += "0 ";
  return text;
}

/// A triangle beside 30 000 vertices that it does not use, which take 720 kB as they are described.
const std::string wide_triangle =
    "Shape \"trianglemesh\" \"point3 P\" [ 1 0 0  0 1 0  0 0 1 " + zeros(90'000) + "] \"integer indices\" [ 0 1 2 ]\n";

}  // namespace

using Catch::Contains;

TEST_CASE("JSON that is nested deep is refused before it is parsed") {
  const ScratchFolder folder;
  std::string deep = "\"extras\":";
  for (int i = 0; i < 50'000; ++i) deep += "[";
  for (int i = 0; i < 50'000; ++i) deep += "]";
  write(folder, "a.gltf", gltf(deep));
  CHECK_THAT(error_of(folder.path / "a.gltf"), Contains("nested more than 256 deep"));
  write(folder, "b.gltf", gltf("\"extras\":\"" + std::string(50'000, '[') + "\\\"[\""));
  CHECK_THAT(error_of(folder.path / "b.gltf"), Contains("no triangle"));
}

TEST_CASE("Pipes, files outside of the folder and of the network are not opened") {
  const ScratchFolder folder;
  REQUIRE(mkfifo((folder.path / "pipe.bin").c_str(), 0600) == 0);
  const auto of_buffer = [&](const std::string& uri) {
    write(folder, "a.gltf",
          gltf("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
               "\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":"
               "\"VEC3\"}],"
               "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":\"" +
               uri + "\"}]"));
    return error_of(folder.path / "a.gltf");
  };
  REQUIRE(is_limited);
  CHECK_THAT(of_buffer("pipe.bin"), Contains("no regular file"));
  write(folder, "b.gltf", gltf("\"images\":[{\"uri\":\"pipe.bin\"}]"));
  CHECK_THAT(error_of(folder.path / "b.gltf"), Contains("no triangle"));
  for (const char* name : {"pipe.png", "pipe.exr", "pipe.pfm", "pipe.ply"}) {
    CAPTURE(name);
    REQUIRE(mkfifo((folder.path / name).c_str(), 0600) == 0);
    const bool is_mesh = std::string(name) == "pipe.ply";
    const std::string file = "\"string filename\" \"" + (folder / name) + "\"\n";
    const std::string text = is_mesh ? "Shape \"plymesh\" " + file
                                     : "Texture \"t\" \"spectrum\" \"imagemap\" " + file +
                                           "Material \"diffuse\" \"texture reflectance\" \"t\"\n" + triangle;
    CHECK_THAT(pbrt_error("WorldBegin " + text), Contains("no regular file"));
  }
  for (const char* uri :
       {"../../etc/passwd", "/etc/passwd", "%2e%2e/secret.bin", "sub/../../secret.bin", "..", "file:///etc/passwd"}) {
    CAPTURE(uri);
    const std::string error = of_buffer(uri);
    CHECK((error.find("outside the folder") != std::string::npos || error.find("network") != std::string::npos));
    CHECK(error.find("bytes") == std::string::npos);
  }
  CHECK_THAT(of_buffer("nowhere.bin"), Contains("is missing"));
  CHECK_THAT(of_buffer("data:application/octet-stream;base64,AAAA"), Contains("goes beyond the end"));
  CHECK_THAT(of_buffer("data:application/octet-stream;base64,A?"), Contains("not base64"));
  write(folder, "sub.bin", std::string(36, '\0'));
  std::filesystem::create_directory(folder.path / "sub");
  CHECK_THAT(of_buffer("sub/../sub.bin"), !Contains("folder"));
}

TEST_CASE("Files that include each other again and again end by their number") {
  const ScratchFolder folder;
  for (int i = 0; i < 30; ++i) {
    const std::string next = "Include \"" + std::to_string(i + 1) + ".pbrt\"\n";
    write(folder, std::to_string(i) + ".pbrt", (i == 0 ? "WorldBegin\n" : "") + next + next);
  }
  write(folder, "30.pbrt", "Translate 0 0 0\n");
  CHECK_THAT(error_of(folder.path / "0.pbrt"), Contains("opens more than 20000 files"));
}

TEST_CASE("Mixtures that double and textures that double end by their size") {
  std::string mixes = "WorldBegin MakeNamedMaterial \"m0\" \"string type\" \"diffuse\"\n";
  std::string textures = "WorldBegin Texture \"t0\" \"spectrum\" \"checkerboard\"\n";
  for (int i = 1; i <= 40; ++i) {
    const std::string n = std::to_string(i), before = std::to_string(i - 1);
    mixes += "MakeNamedMaterial \"m" + n + "\" \"string type\" \"mix\" \"string materials\" [ \"m" + before + "\" \"m" +
             before + "\" ]\n";
    textures += "Texture \"t" + n + "\" \"spectrum\" \"mix\" \"texture tex1\" \"t" + before +
                "\" \"texture tex2\" \"t" + before + "\"\n";
  }
  CHECK_THAT(pbrt_error(mixes + triangle), Contains("a mixture of more than 10000 materials"));
  CHECK_THAT(pbrt_error(textures + triangle), Contains("has more than 10000 parts"));
}

TEST_CASE("Nodes are trees") {
  const ScratchFolder folder;
  std::string nodes;
  for (int i = 0; i < 41; ++i) nodes += "{\"children\":[" + std::to_string(i + 1) + "," + std::to_string(i + 1) + "]},";
  write(folder, "a.gltf", gltf("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[" + nodes + "{}]"));
  CHECK_THAT(error_of(folder.path / "a.gltf"), Contains("two parents"));
  write(folder, "b.gltf", gltf("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[1]},{\"children\":[0]}]"));
  CHECK_THAT(error_of(folder.path / "b.gltf"), Contains("its own ancestor"));
  std::string chain;
  for (int i = 0; i < 100'000; ++i) chain += "{\"children\":[" + std::to_string(i + 1) + "]},";
  write(folder, "c.gltf", gltf("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[" + chain + "{}]"));
  CHECK_THAT(error_of(folder.path / "c.gltf"), Contains("no triangle"));
}

TEST_CASE("Instances are counted before they are copied") {
  std::string text = "WorldBegin ObjectBegin \"many\"\n";
  for (int i = 0; i < 1000; ++i) text += triangle;
  text += "ObjectEnd\n";
  for (int i = 0; i < 20'000; ++i) text += "ObjectInstance \"many\"\n";
  CHECK_THAT(pbrt_error(text, small_memory), Contains("the 20000000 triangles of all instances"));
  CHECK_THAT(pbrt_error(text, small_memory), Contains("--max-memory"));
}

TEST_CASE("Vertices count where a mesh has few triangles, and in each of its copies") {
  std::string text = "WorldBegin ObjectBegin \"wide\"\n" + wide_triangle + "ObjectEnd\n";
  for (int i = 0; i < 100; ++i) text += "ObjectInstance \"wide\"\n";
  CHECK_THAT(pbrt_error(text, small_memory),
             Contains("the 100 triangles of all instances") && Contains("--max-memory"));
  std::string meshes = "WorldBegin\n";
  for (int i = 0; i < 100; ++i) meshes += wide_triangle;
  CHECK_THAT(pbrt_error(meshes, small_memory), Contains("--max-memory"));
  const ScratchFolder folder;
  write(folder, "a.gltf",
        gltf("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{"
             "\"attributes\":{\"TRANSLATION\":1}}}}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
             "\"indices\":2}]}],\"accessors\":[{\"componentType\":5126,\"count\":30000,\"type\":\"VEC3\"},"
             "{\"componentType\":5126,\"count\":100,\"type\":\"VEC3\"},"
             "{\"componentType\":5125,\"count\":3,\"type\":\"SCALAR\"}]"));
  CHECK_THAT(error_of(folder.path / "a.gltf", small_memory), Contains("mesh 0 would take") && Contains("--max-memory"));
}

TEST_CASE("The numbers of a parameter are counted while they are read") {
  CHECK_THAT(pbrt_error("WorldBegin\n" + wide_triangle, little_memory), Contains("parameter \"P\" would take"));
}

TEST_CASE("Blocks share what Attribute sets, and each change of it is counted") {
  const std::string set = "WorldBegin Attribute \"shape\" \"point3 N\" [ " + zeros(300'000) + "]\n";
  std::string begin, change, end;
  for (int i = 0; i < 1000; ++i) {
    begin += "AttributeBegin\n";
    change += "AttributeBegin Attribute \"shape\" \"float x\" 1\n";
    end += "AttributeEnd\n";
  }
  CHECK_THAT(pbrt_error(set + begin + end, small_memory), Contains("holds no shape"));
  CHECK_THAT(pbrt_error(set + change + end, small_memory), Contains("Attribute would take"));
  const std::string name(200'000, 'n');
  CHECK_THAT(pbrt_error("MakeNamedMedium \"" + name + "\" \"rgb sigma_s\" [ 0 0 0 ]\nMediumInterface \"" + name +
                            "\" \"\" WorldBegin\n" + begin + end,
                        small_memory),
             Contains("AttributeBegin would take"));
}

TEST_CASE("What is small is counted, too, where a file has much of it") {
  for (const std::string directive :
       {"Material \"diffuse\"", "LightSource \"point\"", "Texture \"t\" \"float\" \"constant\"", "Shape \"sphere\"",
        "Scale 1 2 1 Shape \"sphere\"", "CoordinateSystem \"c\"", "MakeNamedMedium \"m\""}) {
    std::string text = "WorldBegin\n";
    for (int i = 0; i < 2000; ++i) text += directive + "\n";
    CAPTURE(directive);
    CHECK_THAT(pbrt_error(text + triangle, little_memory), Contains("would take") && Contains("--max-memory"));
  }
  std::string names = "WorldBegin\n", objects = names;
  for (int i = 0; i < 2000; ++i) {
    names += "MakeNamedMaterial \"" + std::to_string(i) + "\" \"string type\" \"interface\"\n";
    objects += "ObjectBegin \"" + std::to_string(i) + "\" ObjectEnd\n";
  }
  CHECK_THAT(pbrt_error(names + triangle, little_memory), Contains("MakeNamedMaterial would take"));
  CHECK_THAT(pbrt_error(objects + triangle, little_memory), Contains("ObjectBegin would take"));
}

TEST_CASE("Objects without an instance are counted, and subdivision before it is done", "[long]") {
  std::string objects = "WorldBegin ObjectBegin \"many\"\n";
  for (int i = 0; i < 200; ++i) objects += "Shape \"sphere\" \"float phimax\" 350\n";  // 16384 triangles each
  CHECK_THAT(pbrt_error(objects + "ObjectEnd\n" + triangle, small_memory),
             Contains("this shape would take") && Contains("--max-memory"));
  std::string spheres = "WorldBegin ObjectBegin \"many\"\n";
  for (int i = 0; i < 400'000; ++i) spheres += "Shape \"sphere\"\n";
  CHECK_THAT(pbrt_error(spheres + "ObjectEnd\n" + triangle, small_memory), Contains("this shape would take"));
  CHECK_THAT(
      pbrt_error("WorldBegin Shape \"loopsubdiv\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"integer indices\" [ 0 1 2 ] "
                 "\"integer levels\" 10\n",
                 small_memory),
      Contains("the subdivided mesh would take") && Contains("--max-memory"));
}

TEST_CASE("What a file says to be large is counted before there is memory for it") {
  const ScratchFolder folder;
  const auto error = [&](const std::string& members) {
    write(folder, "a.gltf", gltf(members));
    return error_of(folder.path / "a.gltf", small_memory);
  };
  const std::string mesh =
      "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
      "\"POSITION\":0}}]}],";
  // An accessor without data is of zeros.
  CHECK_THAT(error(mesh + "\"accessors\":[{\"componentType\":5126,\"count\":4000000000,\"type\":\"VEC3\"}]"),
             Contains("accessor 0 would take"));
  CHECK_THAT(error(mesh + "\"accessors\":[{\"componentType\":5126,\"count\":1e14,\"type\":\"VEC3\"}]"),
             Contains("accessor 0 would take"));
  CHECK_THAT(
      error(mesh + "\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"sparse\":{\"count\":4e9,"
                   "\"indices\":{\"bufferView\":0,\"componentType\":5125},\"values\":{\"bufferView\":0}}}]"),
      Contains("accessor 0 would take"));
  write(folder, "a.pfm", "PF\n30000 30000\n-1\n");
  CHECK_FALSE(error_of(folder.path / "a.pfm").empty());
}

TEST_CASE("An image that unpacks to more than there is room for is refused by its header") {
  const ScratchFolder folder;
  // The header of a PNG of 8000 × 8000 pixels, 8 bits, RGBA.
  std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x1f\x40\0\0\x1f\x40\x08\x06\0\0\0", 29);
  png += std::string(64, '\0');
  write(folder, "bomb.png", png);
  const std::string text = with_image(folder, "bomb.png");
  CHECK_THAT(pbrt_error(text, small_memory), Contains("bomb.png"));
  CHECK_THAT(pbrt_error(text, small_memory), Contains("--max-memory"));
}

TEST_CASE("A part of an image that says to be longer than the file is refused before there is memory for it") {
  const ScratchFolder folder;
  // A pixel of PNG whose data say that they have 512 MiB, and of which 40 bytes or none are there.
  std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\x08\x02\0\0\0\x90wS\xde", 33);
  png += std::string("\x20\0\0\0IDAT", 8);
  for (const std::size_t there : {std::size_t{40}, std::size_t{0}}) {
    write(folder, "long.png", png + std::string(there, 'x'));
    CHECK_THAT(pbrt_error(with_image(folder, "long.png")), Contains("goes beyond the end"));
  }
}

TEST_CASE("A JPEG with a Huffman table of more symbols than bytes have is refused") {
  const ScratchFolder folder;
  // Five lengths of 255 codes each: as codes they are possible.
  const std::string counts = std::string(11, '\0') + std::string(5, '\xff');
  const std::string jpeg = "\xff\xd8\xff\xc4" + std::string("\x05\x0e\x13", 3) + counts + std::string(1275, 'x');
  // Behind the header of a comment, too, but not in the comment.
  const std::string comment("\xff\xfe\x05\x14", 4);
  write(folder, "long.jpg", jpeg);
  CHECK_THAT(pbrt_error(with_image(folder, "long.jpg")), Contains("Huffman table of more than 256"));
  write(folder, "long.jpg", "\xff\xd8" + std::string("\xff\xfe\0\3x", 5) + jpeg.substr(2));
  CHECK_THAT(pbrt_error(with_image(folder, "long.jpg")), Contains("Huffman table of more than 256"));
  write(folder, "long.jpg", "\xff\xd8" + comment + jpeg.substr(2));
  CHECK_THAT(pbrt_error(with_image(folder, "long.jpg")), Contains("cannot be read"));
}
