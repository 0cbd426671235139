#include <sys/stat.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "program/scratch_folder.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/pbrt/reader.hpp"
#include "support/seed.hpp"

using namespace gmis::tools;
namespace fs = std::filesystem;
using gmis_test::message_of;
using gmis_test::ScratchFolder;

namespace {

const std::string triangle =
    "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"integer indices\" [ 0 1 2 ]\n";

/// The message with which reading `text` fails, or nothing when it succeeds.
std::string error_of(const std::string& text) {
  Diagnostics diagnostics;
  return message_of<InputError>([&] { return read_pbrt_text(text, "t.pbrt", ".", diagnostics); });
}

struct Case {
  const char* text;
  const char* start;  ///< of the message
  const char* part;   ///< found in it
};

void check(const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    CAPTURE(c.text);
    const std::string error = error_of(c.text);
    CAPTURE(error);
    CHECK(error.find(c.start) == 0);
    CHECK(error.find(c.part) != std::string::npos);
    CHECK(error.find('\n') == std::string::npos);
  }
}

}  // namespace

TEST_CASE("Errors of syntax name the line") {
  check({
      {"", "t.pbrt:1: ", "WorldBegin"},
      {"WorldBegin", "t.pbrt:1: ", "no shape"},
      {"WorldBegin LightSource \"infinite\"", "t.pbrt:1: ", "add a Shape after WorldBegin"},
      {"\n\n42", "t.pbrt:3: ", "no pbrt-v4 scene"},
      {"Sampler \"a\"\n\n42", "t.pbrt:3: ", "\"42\""},
      {"\n\x01\x02\x7f", "t.pbrt:2: ", "pbrt-v4"},
      {"\"Film\"", "t.pbrt:1: ", "directive"},
      {"Film", "t.pbrt:1: ", "the file ends after Film"},
      {"Film rgb", "t.pbrt:1: ", "quotation marks"},
      {"WorldBegin\nReverseOrientatio", "t.pbrt:2: ", "cut off"},
      {"WorldBegin\nMediumThing \"a\" [ 1 2", "t.pbrt:2: ", "cut off"},
      {"Film \"rgb\"\n\"integer xresolution\" [ 1", "t.pbrt:2: ", "the file ends inside"},
      {"Film \"rgb\"\n\"integer xresolution", "t.pbrt:2: ", "not closed"},
      {"Film \"rgb\" \"xresolution\" 5", "t.pbrt:1: ", "no parameter"},
      {"Film \"rgb\" \"int xresolution\" 5", "t.pbrt:1: ", "unknown type"},
      {"Film \"rgb\" \"integer xresolution\" 5 \"integer xresolution\" 6", "t.pbrt:1: ", "twice"},
      {"Film \"rgb\" \"integer xresolution\" \"five\"", "t.pbrt:1: ", "needs a number"},
      {"Film \"rgb\" \"integer xresolution\" nan", "t.pbrt:1: ", "needs a number"},
      {"Film \"rgb\" \"integer xresolution\" [ [ 5 ] ]", "t.pbrt:1: ", "needs a number"},
      {"Film \"rgb\" \"string filename\" 5", "t.pbrt:1: ", "quotation marks"},
      {"LookAt 1 2 3\n4 5", "t.pbrt:2: ", "9 numbers"},
      {"LookAt 1 2 3 4 5 x", "t.pbrt:1: ", "\"x\""},
      {"Transform [ 1 2 3 ]", "t.pbrt:1: ", "16 numbers"},
      {"Translate 1 2 1e999", "t.pbrt:1: ", "too large"},
  });
}

TEST_CASE("Errors of structure name the line") {
  check({
      {"Material \"diffuse\"", "t.pbrt:1: ", "after WorldBegin"},
      {"WorldBegin\nFilm \"rgb\"", "t.pbrt:2: ", "before WorldBegin"},
      {"WorldBegin WorldBegin", "t.pbrt:1: ", "before WorldBegin"},
      {"WorldBegin\nAttributeEnd", "t.pbrt:2: ", "closes nothing"},
      {"WorldBegin\nAttributeBegin\n", "t.pbrt:2: ", "AttributeEnd"},
      {"WorldBegin\nTransformBegin\nObjectEnd", "t.pbrt:3: ", "AttributeEnd"},
      {"WorldBegin\nObjectBegin \"a\"\n", "t.pbrt:2: ", "ObjectEnd"},
      {"WorldBegin ObjectBegin \"a\"\nObjectBegin \"b\"", "t.pbrt:2: ", "inside the object"},
      {"WorldBegin ObjectBegin \"a\" ObjectEnd\nObjectBegin \"a\"", "t.pbrt:2: ", "twice"},
      {"WorldBegin ObjectBegin \"a\"\nObjectInstance \"a\"", "t.pbrt:2: ", "inside an object"},
      {"WorldBegin\nObjectInstance \"a\"", "t.pbrt:2: ", "not defined above this line: add ObjectBegin \"a\""},
      {"WorldBegin\nObjectEnd", "t.pbrt:2: ", "closes nothing"},
      {"WorldBegin\nNamedMaterial \"a\"", "t.pbrt:2: ", "not defined"},
      {"CoordSysTransform \"a\"", "t.pbrt:1: ", "not defined"},
      {"Include \"no such file\"", "t.pbrt:1: ", "is missing"},
      {"Include \".\"", "t.pbrt:1: ", "no regular file"},
      {"TransformBegin WorldBegin", "t.pbrt:1: ", "after WorldBegin"},
  });
}

TEST_CASE("An error of the whole file is at its first line") {
  for (const char* text : {"", "WorldBegin"}) {
    CAPTURE(text);
    std::string where;
    try {
      Diagnostics diagnostics;
      (void)read_pbrt_text(text, "t.pbrt", ".", diagnostics);
    } catch (const InputError& error) {
      if (error.where()) where = error.where()->to_string();
    }
    CHECK(where == "t.pbrt:1");
  }
}

TEST_CASE("Values that cannot be meant are refused") {
  check({
      {"Film \"rgb\" \"integer xresolution\" 0", "t.pbrt:1: ", "from 1 to 32768"},
      {"Film \"rgb\" \"integer xresolution\" -5", "t.pbrt:1: ", "from 1 to 32768"},
      {"Film \"rgb\" \"integer xresolution\" 1e9", "t.pbrt:1: ", "from 1 to 32768"},
      {"Film \"rgb\" \"integer xresolution\" 1.5", "t.pbrt:1: ", "whole numbers"},
      {"Film \"rgb\" \"integer xresolution\" 1e300", "t.pbrt:1: ", "whole numbers"},
      {"Film \"rgb\" \"float xresolution\" 5", "t.pbrt:1: ", "declare it as integer"},
      {"Film \"rgb\" \"integer xresolution\" [ 5 6 ]", "t.pbrt:1: ", "give it 1"},
      {"Camera \"spherical\"", "t.pbrt:1: ", "use perspective or orthographic"},
      {"Camera \"perspective\" \"float lensradius\" -1", "t.pbrt:1: ", "lensradius"},
      {"Camera \"perspective\" \"float lensradius\" 1 \"float focaldistance\" 0", "t.pbrt:1: ", "focaldistance"},
      {"Camera \"perspective\" \"float fov\" 0", "t.pbrt:1: ", "degrees"},
      {"Camera \"perspective\" \"float fov\" 180", "t.pbrt:1: ", "degrees"},
      {"Camera \"perspective\" \"float screenwindow\" [ 1 -1 -1 1 ]", "t.pbrt:1: ", "screenwindow"},
      {"Scale 1 2 1 Camera \"perspective\"", "t.pbrt:1: ", "stretch"},
      {"Transform [ 1 0 0 1  0 1 0 0  0 0 1 0  0 0 0 1 ]", "t.pbrt:1: ", "the transform is not affine"},
      {"Scale 1e200 1e200 1e200", "t.pbrt:1: ", "range"},
      {"Rotate 30 0 0 0", "t.pbrt:1: ", "axis"},
      {"LookAt 1 1 1  1 1 1  0 1 0", "t.pbrt:1: ", "LookAt"},
      {"LookAt 0 0 0  0 1 0  0 1 0", "t.pbrt:1: ", "LookAt"},
      {"Transform [ 1 0 0 .5  0 1 0 0  0 0 1 0  0 0 0 1 ]", "t.pbrt:1: ", "0 0 0 1"},
      {"WorldBegin Material \"velvet\"", "t.pbrt:1: ", "\"velvet\" is not understood"},
      {"WorldBegin Material \"diffuse\" \"rgb reflectance\" [ .5 .5 ]", "t.pbrt:1: ", "give it 3"},
      {"WorldBegin Material \"diffuse\" \"rgb reflectance\" .5",
       "t.pbrt:1: ", "has 1 value: give it 3, as in [ .5 .5 .5 ]"},
      {"WorldBegin Material \"diffuse\" \"spectrum reflectance\" [ 500 .5 ]", "t.pbrt:1: ", "has one pair"},
      {"WorldBegin Material \"diffuse\" \"spectrum reflectance\" [ 500 .5 600 -.5 ]", "t.pbrt:1: ", "negative value"},
      {"WorldBegin Texture \"w\" \"float\" \"constant\"\nMaterial \"diffuse\" \"texture reflectance\" \"w\"",
       "t.pbrt:2: ", "needs a spectrum texture, but \"w\" is a float texture"},
      {"WorldBegin Texture \"w\" \"spectrum\" \"constant\"\nMaterial \"conductor\" \"texture roughness\" \"w\"",
       "t.pbrt:2: ", "needs a float texture, but \"w\" is a spectrum texture"},
      {"WorldBegin Material \"diffuse\" \"rgb reflectance\" [ -1 0 0 ]", "t.pbrt:1: ", "negative"},
      {"WorldBegin Material \"diffuse\" \"float reflectance\" .5", "t.pbrt:1: ", "declare it as rgb"},
      {"WorldBegin Material \"diffuse\" \"spectrum reflectance\" [ 700 .1 400 .2 ]", "t.pbrt:1: ", "low to high"},
      {"WorldBegin Material \"diffuse\" \"spectrum reflectance\" \"stuff\"", "t.pbrt:1: ", "not known"},
      {"WorldBegin Material \"diffuse\" \"texture reflectance\" \"wood\"",
       "t.pbrt:1: ", "not defined above it: add Texture \"wood\" \"spectrum\""},
      {"WorldBegin Material \"conductor\" \"spectrum eta\" \"metal-Xx-eta\"", "t.pbrt:1: ", "not known"},
      {"WorldBegin Material \"conductor\" \"rgb eta\" [ 1 1 1 ] \"rgb reflectance\" [ 1 1 1 ]",
       "t.pbrt:1: ", "one or the other"},
      {"WorldBegin Material \"conductor\" \"float roughness\" -1", "t.pbrt:1: ", "negative"},
      {"WorldBegin Material \"dielectric\" \"float eta\" 0", "t.pbrt:1: ", "between"},
      {"WorldBegin Material \"phong\" \"float exponent\" -2", "t.pbrt:1: ", "exponent"},
      {"WorldBegin MakeNamedMaterial \"a\"", "t.pbrt:1: ", "string type"},
      {"WorldBegin Texture \"a\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\"", "t.pbrt:1: ", "is missing"},
      {"WorldBegin Texture \"a\" \"color\" \"constant\"", "t.pbrt:1: ", "float or spectrum"},
      {"WorldBegin Shape \"curve\"", "t.pbrt:1: ", "\"curve\" is not understood"},
      {"WorldBegin Shape \"sphere\" \"float radius\" 0", "t.pbrt:1: ", "above 0"},
      {"WorldBegin Shape \"sphere\" \"float zmax\" -2", "t.pbrt:1: ", "below zmax"},
      {"WorldBegin Shape \"trianglemesh\"", "t.pbrt:1: ", "point3 P"},
      {"WorldBegin Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 ]", "t.pbrt:1: ", "threes"},
      {"WorldBegin Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ]\n\"integer indices\" [ 0 1 3 ]",
       "t.pbrt:2: ", "holds 3"},
      {"WorldBegin Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ]\n\"integer indices\" [ 0 1 -1 ]",
       "t.pbrt:2: ", "holds -1"},
      {"WorldBegin Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"integer indices\" [ 0 1 ]",
       "t.pbrt:1: ", "groups of 3"},
      {"WorldBegin Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"normal N\" [ 0 0 1 ]",
       "t.pbrt:1: ", "give one each"},
      {"WorldBegin Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1e30 0 ]", "t.pbrt:1: ", "1e9"},
      {"WorldBegin Shape \"plymesh\"", "t.pbrt:1: ", "filename"},
      {"WorldBegin Shape \"plymesh\" \"string filename\" \"absent.ply\"", "t.pbrt:1: ", "absent.ply"},
      {"WorldBegin LightSource \"laser\"", "t.pbrt:1: ", "\"laser\" is not understood"},
      {"WorldBegin LightSource \"spot\" \"float coneangle\" 0", "t.pbrt:1: ", "coneangle"},
      {"WorldBegin LightSource \"spot\" \"float conedeltaangle\" 31", "t.pbrt:1: ", "conedeltaangle"},
      {"WorldBegin LightSource \"spot\" \"point3 to\" [ 0 0 0 ]", "t.pbrt:1: ", "direction"},
      {"WorldBegin Scale 1 2 1 LightSource \"spot\"", "t.pbrt:1: ", "stretch"},
      {"WorldBegin LightSource \"point\" \"rgb I\" [ -1 1 1 ]", "t.pbrt:1: ", "negative"},
      {"WorldBegin LightSource \"point\" \"blackbody I\" 5", "t.pbrt:1: ", "kelvins"},
      {"WorldBegin LightSource \"point\" \"rgb I\" [ 1 1 1 ] \"float scale\" 1e300", "t.pbrt:1: ", "1e20"},
      {"WorldBegin LightSource \"distant\" \"point3 to\" [ 0 0 0 ]", "t.pbrt:1: ", "direction"},
      {"WorldBegin LightSource \"infinite\" \"string filename\" \"absent.pfm\"", "t.pbrt:1: ", "absent.pfm"},
      {"WorldBegin LightSource \"infinite\" \"string filename\" \"a.pfm\" \"rgb L\" [ 1 1 1 ]", "t.pbrt:1: ", "scale"},
      {"WorldBegin AreaLightSource \"spot\"", "t.pbrt:1: ", "use diffuse"},
      {"WorldBegin AreaLightSource \"diffuse\" \"bool twosided\" \"maybe\"", "t.pbrt:1: ", "true or false"},
      {"WorldBegin Attribute \"planet\"", "t.pbrt:1: ", "shape, light, material, medium or texture"},
  });
}

TEST_CASE("An include that includes itself ends in an error") {
  const ScratchFolder folder;
  std::ofstream(folder.path / "loop.pbrt") << "\nInclude \"loop.pbrt\"\n";
  Diagnostics diagnostics;
  const std::string message =
      message_of<InputError>([&] { return read_pbrt_scene(folder.path / "loop.pbrt", diagnostics); });
  CHECK(message.find((folder.path / "loop.pbrt").string() + ":2: ") == 0);
  CHECK(message.find("include") != std::string::npos);
  CHECK_THROWS_AS(read_pbrt_scene(folder.path / "absent.pbrt", diagnostics), InputError);
  CHECK_THROWS_AS(read_pbrt_scene(folder.path, diagnostics), InputError);
}

TEST_CASE("An error in an included file names the line that includes it, once") {
  const ScratchFolder folder;
  std::ofstream(folder.path / "outer.pbrt") << "# a\nInclude \"inner.pbrt\"\n";
  std::ofstream(folder.path / "inner.pbrt") << "AttributeBegin\n\nMaterial \"diffuse\" \"rgb reflectance\" .5\n";
  const std::string text = "WorldBegin\n" + triangle + "Include \"outer.pbrt\"\n";
  const std::string tail = " (included by " + (folder.path / "outer.pbrt").string() + ":2)";
  Diagnostics strict, check(Strictness::check);
  CHECK_THROWS_WITH(read_pbrt_text(text, "t.pbrt", folder.path, strict),
                    Catch::StartsWith((folder.path / "inner.pbrt").string() + ":3: ") && Catch::EndsWith("]" + tail));
  try {
    (void)read_pbrt_text(text, "t.pbrt", folder.path, check);
  } catch (const InputError&) {  // of the block that is not closed
  }
  REQUIRE(!check.all().empty());
  CHECK_THAT(check.all().front().to_string(), Catch::EndsWith("]" + tail));
}

TEST_CASE("A scene cut short anywhere gives an error or a scene, never a crash") {
  const std::string text = gmis_test::text_of(fs::path(GMIS_REFERENCE_FOLDER) / "tung2.pbrt");
  REQUIRE(text.size() > 2000);
  int whole = 0;
  for (std::size_t length = 0; length < text.size(); length += 3) {
    const std::string error = error_of(text.substr(0, length));
    if (error.empty()) {
      ++whole;
    } else {
      CAPTURE(error);
      CHECK(error.find("t.pbrt:") == 0);
    }
  }
  // Between two blocks of the world, a cut scene is a smaller scene.
  CHECK(whole > 0);
}

TEST_CASE("A scene with bytes changed at random gives an error or a scene, never a crash") {
  const std::string text = gmis_test::text_of(fs::path(GMIS_REFERENCE_FOLDER) / "tung1.pbrt");
  std::mt19937 random(gmis_test::seed(1));
  for (int round = 0; round < 1000; ++round) {
    std::string broken = text;
    const int changes = 1 + static_cast<int>(random() % 8U);
    for (int i = 0; i < changes; ++i) broken[random() % broken.size()] = static_cast<char>(random() % 256U);
    const std::string error = error_of(broken);
    if (!error.empty()) CHECK(error.find("t.pbrt:") == 0);
  }
}

TEST_CASE("When lenient, an unknown directive is only a warning while its statement is whole") {
  Diagnostics diagnostics(Strictness::lenient);
  const std::string whole = "WorldBegin\n" + triangle + "MediumThing \"a\" [ 1 2 ]";
  CHECK_NOTHROW(read_pbrt_text(whole, "t.pbrt", ".", diagnostics));
  CHECK_THROWS_AS(read_pbrt_text(whole.substr(0, whole.size() - 1), "t.pbrt", ".", diagnostics), InputError);
}

TEST_CASE("What is no scene is refused without a word of it") {
  const ScratchFolder folder;
  const std::string secrets[] = {"root:s3cret:1:2:::\n", "machine s3cret login s3cret\n", "\"s3cret\n",
                                 "s3cret 1e999\n",       "# a comment\n\n[s3cret]\n",     "Film:s3cret\n",
                                 "1e999999s3cret\n"};
  for (const std::string& secret : secrets) {
    CAPTURE(secret);
    std::ofstream(folder.path / "key", std::ios::binary) << secret;
    for (const std::string& directive : {std::string("Include"), std::string("Import")}) {
      Diagnostics diagnostics;
      const std::string text = "WorldBegin\n" + triangle + directive + " \"key\"\n";
      const std::string message =
          message_of<InputError>([&] { return read_pbrt_text(text, "t.pbrt", folder.path, diagnostics); });
      CHECK(message.find("no pbrt-v4 scene") != std::string::npos);
      CHECK(message.find("s3cret") == std::string::npos);
      for (const Diagnostic& diagnostic : diagnostics.all())
        CHECK(diagnostic.to_string().find("s3cret") == std::string::npos);
    }
  }
  // Directives of pbrt-v4 that this reader passes over may come first all the same, and so may
  // nothing at all.
  for (const char* start :
       {"Option \"bool disablepixeljitter\" true\n", "MakeNamedMedium \"fog\"\n", "", "# nothing\n"}) {
    std::ofstream(folder.path / "part", std::ios::binary) << start;
    Diagnostics diagnostics;
    CHECK_NOTHROW(read_pbrt_text("WorldBegin\n" + triangle + "Include \"part\"\n", "t.pbrt", folder.path, diagnostics));
  }
}

TEST_CASE("Files that are no regular files are refused, and never waited for") {
  const ScratchFolder folder;
  const std::string pipe = (folder.path / "pipe.pfm").string();
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  const auto error_in_world = [&](const std::string& statement) {
    Diagnostics diagnostics;
    return message_of<InputError>(
        [&] { return read_pbrt_text("WorldBegin\n" + triangle + statement, "t.pbrt", folder.path, diagnostics); });
  };
  for (const char* name : {"pipe.pfm", "/dev/zero"}) {
    CAPTURE(name);
    const std::string file = "\"" + std::string(name) + "\"";
    CHECK(error_in_world("Include " + file).find("no regular file") != std::string::npos);
    CHECK(error_in_world("Import " + file).find("no regular file") != std::string::npos);
    CHECK(!error_in_world("Shape \"plymesh\" \"string filename\" " + file).empty());
  }
  CHECK(error_in_world("LightSource \"infinite\" \"string filename\" \"pipe.pfm\"").find("no regular file") !=
        std::string::npos);
  Diagnostics diagnostics;
  CHECK_THROWS_AS(read_pbrt_scene("/dev/zero", diagnostics), InputError);
}

TEST_CASE("Deep nesting is bounded") {
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 20000; ++i) text += "AttributeBegin\n";
  CHECK(error_of(text).find("nested") != std::string::npos);
}
