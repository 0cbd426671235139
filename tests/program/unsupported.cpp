#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "program/read_scene.hpp"
#include "support/catch.hpp"
#include "support/pbrt/reader.hpp"
#include "support/pbrt/transform.hpp"

// Input that changes the picture and is not understood: an error, a warning with --lenient, a line
// of a list with --check.

using namespace gmis::tools;
using gmis_test::Read;

namespace {

const std::string triangle =
    "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"integer indices\" [ 0 1 2 ]\n";

Read read(const std::string& text, Strictness strictness) {
  return gmis_test::reading(strictness,
                            [&](Diagnostics& diagnostics) { return read_pbrt_text(text, "t.pbrt", ".", diagnostics); });
}

/// A medium that absorbs and does nothing else.
const std::string clear =
    "MakeNamedMedium \"ink\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 1 2 3 ] \"rgb sigma_s\" [ 0 0 0 ]\n";

/// Each is read with a triangle behind it.
const std::vector<std::string> unsupported{
    "Camera \"realistic\"\nWorldBegin\n",
    "Film \"hologram\"\nWorldBegin\n",
    "ColorSpace \"rec709\"\nWorldBegin\n",
    "Option \"bool forcediffuse\" true\nWorldBegin\n",
    "ActiveTransform EndTime Translate 1 0 0 ActiveTransform All Camera \"perspective\"\nWorldBegin\n",
    "ActiveTransform StartTime Translate 1 0 0 ActiveTransform All Camera \"perspective\"\nWorldBegin\n",
    "WorldBegin\nActiveTransform StartTime Rotate 5 0 0 1\n",
    "WorldBegin\nActiveTransform EndTime Transform [ 1 0 0 0  0 1 0 0  0 0 1 0  0 0 2 1 ]\n",
    "WorldBegin\nActiveTransform StartTime Identity Scale 2 2 2 ActiveTransform All LightSource \"point\"\n",
    "WorldBegin\nMediumInterface \"fog\" \"\"\n",
    "WorldBegin\nMediumInterface \"fog\"\n",
    "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\nWorldBegin\nMediumInterface \"fog\" \"\"\n",
    "MakeNamedMedium \"fog\" \"string type\" \"cloud\" \"rgb sigma_s\" [ 0 0 0 ]\nWorldBegin\nMediumInterface \"fog\" "
    "\"\"\n",
    "MakeNamedMedium \"fog\" \"string preset\" \"Apple\" \"rgb sigma_s\" [ 0 0 0 ]\nWorldBegin\nMediumInterface "
    "\"fog\" \"\"\n",
    "MakeNamedMedium \"fog\" \"rgb sigma_s\" [ 0 0 0 ] \"rgb Le\" [ 1 1 1 ]\nWorldBegin\nMediumInterface \"fog\" "
    "\"\"\n",
    clear + "WorldBegin\nMediumInterface \"\" \"ink\"\n",
    clear + "MediumInterface \"\" \"ink\"\nCamera \"perspective\"\nWorldBegin\nMediumInterface \"\"\n",
    clear + "WorldBegin\nMediumInterface \"ink\" \"\"\nMaterial \"diffusetransmission\"\n",
    clear + "WorldBegin\nMediumInterface \"ink\" \"\"\nMaterial \"thindielectric\"\n",
    clear +
        "WorldBegin\nMediumInterface \"ink\" \"\"\nMaterial \"dielectric\"\nShape \"sphere\" \"float alpha\" .5\n"
        "Material \"diffuse\"\n",
    clear +
        "WorldBegin\nMediumInterface \"ink\" \"\"\nMaterial \"interface\"\nShape \"sphere\"\nMaterial \"diffuse\"\n",
    "WorldBegin\nTexture \"t\" \"float\" \"fbm\"\n",
    "WorldBegin\nMaterial \"hair\"\n",
    "WorldBegin\nMaterial \"subsurface\"\n",
    "WorldBegin\nLightSource \"goniometric\"\n",
    "WorldBegin\nAreaLightSource \"diffuse\" \"string filename\" \"e.png\"\n",
    "WorldBegin\nAttributeBegin AreaLightSource \"diffuse\"\nShape \"disk\" \"float alpha\" 0\nAttributeEnd\n",
    "WorldBegin\nShape \"curve\"\n",
    "WorldBegin\nShap \"sphere\"\n",
};

}  // namespace

TEST_CASE("What changes the picture and is not understood is an error, a warning when lenient, a line when checking") {
  for (const std::string& start : unsupported) {
    CAPTURE(start);
    const Read strict = read(start + triangle, Strictness::strict);
    CHECK(strict.error.find("t.pbrt:") == 0);
    CHECK(strict.error.find('\n') == std::string::npos);
    const Read lenient = read(start + triangle, Strictness::lenient);
    CHECK(lenient.error.empty());
    CHECK(lenient.count("warning: ") == 1 + lenient.count("no light"));
    CHECK(lenient.scene.shapes.size() >= 1);
    const Read check = read(start + triangle, Strictness::check);
    CHECK(check.error.empty());
    CHECK(check.diagnostics.error_count() == 1);
    CHECK(check.count("error: " + strict.error.substr(strict.error.find(": ") + 2)) == 1);
  }
}

TEST_CASE("A check goes on behind every kind of error, and says each once at its place") {
  const Read check = read(
      "Camera \"perspective\" \"float fov\" 500\n"
      "Film \"rgb\" \"integer xresolution\" [ -5 ]\n"
      "WorldBegin\n"
      "MakeNamedMaterial \"m\" \"string type\" \"diffuse\" \"rgb reflectance\" [ 1 2 ]\n"
      "NamedMaterial \"m\"\n"
      "Include \"no-such-file.pbrt\"\n"
      "Shape \"plymesh\" \"string filename\" \"no-such-mesh.ply\"\n"
      "Mate \"diffuse\" \"rgb reflectance\" [ .1 .2 .3 ]\n"
      "Shape \"sphere\" \"float radius\" \"two\"\n"
      "MediumInterface \"a\" \"b\"\n" +
          triangle + "AttributeEnd\n",
      Strictness::check);
  CHECK(check.error.empty());
  for (const char* part :
       {"t.pbrt:1: error: ", "t.pbrt:2: error: ", "t.pbrt:4: error: ", "t.pbrt:6: error: ", "t.pbrt:7: error: ",
        "t.pbrt:8: error: ", "t.pbrt:9: error: ", "t.pbrt:10: error: ", "t.pbrt:12: error: "}) {
    CAPTURE(part);
    CHECK(check.count(part) == 1);
  }
  CHECK(check.diagnostics.error_count() == 9);
  CHECK(check.count("no-such-file.pbrt\" is missing") == 1);
  CHECK(check.count("no-such-mesh.ply\" is missing") == 1);
  CHECK(check.scene.shapes.size() == 1);
}

TEST_CASE("Input that cannot change the picture is read in silence or with a note") {
  const Read result = read(
      "Option \"integer seed\" 5\nTransformTimes 0 1\nColorSpace \"srgb\"\nActiveTransform StartTime\n"
      "Translate 0 0 1\nActiveTransform EndTime\nActiveTransform All\nWorldBegin\n"
      "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\nMediumInterface \"\" \"\"\n"
      "Material \"interface\"\nShape \"sphere\"\nMakeNamedMaterial \"i\" \"string type\" \"interface\"\n"
      "NamedMaterial \"i\"\nShape \"sphere\"\nMaterial \"diffuse\"\n" +
          triangle,
      Strictness::strict);
  CHECK(result.error.empty());
  CHECK(result.count("warning: ") == result.count("no light"));
  CHECK(result.scene.shapes.size() == 1);  // the boundaries of media are not seen
}

TEST_CASE("The same transform at the start and at the end is no motion") {
  const Read result = read(
      "WorldBegin\nActiveTransform StartTime Translate 0 0 4 ActiveTransform EndTime Translate 0 0 4 ActiveTransform "
      "All\n"
      "AttributeBegin ActiveTransform EndTime Translate 1 0 0 AttributeEnd\n" +
          triangle,
      Strictness::strict);
  CHECK(result.error.empty());
  REQUIRE(result.scene.shapes.size() == 1);
  CHECK(std::get<MeshDescription>(result.scene.shapes[0].geometry).positions.at(0) == Point(0, 0, 4));
}

TEST_CASE("Textures and mixtures that name themselves are not defined above") {
  for (const auto strictness : {Strictness::strict, Strictness::check}) {
    for (const char* text :
         {"Texture \"a\" \"spectrum\" \"scale\" \"texture tex\" \"a\"\n",
          "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [ \"m\" \"m\" ]\n"}) {
      const Read result = read("WorldBegin\n" + std::string(text) + triangle, strictness);
      CAPTURE(text, result.error);
      CHECK((result.says("not defined above") || result.error.find("not defined above") != std::string::npos));
    }
    // One that is there before may be replaced by what is made of it.
    CHECK(read("WorldBegin\nTexture \"a\" \"spectrum\" \"constant\"\nTexture \"a\" \"spectrum\" \"scale\" \"texture "
               "tex\" \"a\"\n" +
                   triangle,
               strictness)
              .diagnostics.error_count() == 0);
  }
}

TEST_CASE("A transform that flattens space makes flat meshes, and spheres vanish, as in pbrt") {
  const Read result = read(
      "WorldBegin\nMaterial \"diffuse\"\nAttributeBegin ConcatTransform [ 1 0 0 0  0 1 0 0  0 0 0 0  0 0 3 1 ]\n"
      "Shape \"trianglemesh\" \"point3 P\" [ 0 0 5  1 0 6  0 1 7 ] \"normal N\" [ 0 0 1  0 1 0  1 0 0 ]\n"
      "Shape \"sphere\"\nAttributeEnd\nScale 0 1 1\n" +
          triangle,
      Strictness::strict);
  CAPTURE(result.error);
  REQUIRE(result.scene.shapes.size() == 2);
  const auto& flat = std::get<MeshDescription>(result.scene.shapes[0].geometry);
  CHECK(flat.positions == std::vector<Point>{{0, 0, 3}, {1, 0, 3}, {0, 1, 3}});
  CHECK(flat.normals.empty());
}

TEST_CASE("Colour spaces keep white, and white balance makes white of its illuminant") {
  const auto light = [](const std::string& before, const std::string& color) {
    const Read result = read(before + "\nWorldBegin\nLightSource \"point\" \"rgb I\" [ " + color + " ]\n" + triangle,
                             Strictness::strict);
    CAPTURE(result.error);
    REQUIRE(result.scene.lights.size() == 1);
    return std::get<PointLightDescription>(result.scene.lights[0].kind).intensity;
  };
  const auto near = [](const Rgb& a, const Rgb& b, double margin) { return glm::length(a - b) < margin; };
  for (const char* space : {"srgb", "dci-p3", "rec2020", "aces2065-1"})
    CHECK(near(light(std::string("ColorSpace \"") + space + "\"", "2 2 2"), Rgb(2), 1e-9));
  // ITU-R BT.2087: linear BT.709 from BT.2020.
  CHECK(near(light("ColorSpace \"rec2020\"", "0.3 0.5 0.4"),
             Rgb(1.6605 * .3 - .5876 * .5 - .0728 * .4, -.1246 * .3 + 1.1329 * .5 - .0083 * .4,
                 -.0182 * .3 - .1006 * .5 + 1.1187 * .4),
             1e-3));
  CHECK(near(light("Film \"rgb\" \"float whitebalance\" 6504", "1 1 1"), Rgb(1), 5e-3));
  const Rgb warm = light("Film \"rgb\" \"float whitebalance\" 5000", "1 1 1");  // daylight looks blue to it
  CHECK(warm.z > 1.1);
  CHECK(warm.x < 0.95);
  CHECK(read("Film \"rgb\" \"string sensor\" \"canon_eos_100d\" \"float iso\" 200\nWorldBegin\n" + triangle,
             Strictness::strict)
            .says("is taken for"));
}

TEST_CASE("Scenes of older versions are named as such") {
  CHECK(read("LookAt 0 0 1 0 0 0 0 1 0\nWorldBegin\nMaterial \"matte\" \"rgb Kd\" [ 1 0 0 ]\n" + triangle,
             Strictness::strict)
            .error.find("pbrt-v3") != std::string::npos);
  CHECK(read("SurfaceIntegrator \"path\"\nWorldBegin\n" + triangle, Strictness::strict).error.find("pbrt-v2") !=
        std::string::npos);
}

TEST_CASE("A camera a hair off orthogonal is made orthonormal, one that is far off is refused") {
  const auto camera = [](double off) {
    return "Transform [ 2 0 0 0  " + std::to_string(2 * off) +
           " 2 0 0  0 0 2 0  1 2 3 1 ]\nCamera \"perspective\"\n"
           "WorldBegin\n" +
           triangle;
  };
  for (const double off : {1.8e-5, 1e-3}) {
    CAPTURE(off);
    const Read result = read(camera(off), Strictness::strict);
    CHECK(result.error.empty());
    CHECK(result.count("t.pbrt:2: note: the axes of the camera") == 1);
    const glm::dmat4 m = result.scene.camera.world_from_camera;
    const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
    CHECK(std::abs(glm::dot(x, y)) < 1e-12);
    CHECK(std::abs(glm::dot(y, z)) < 1e-12);
    CHECK(glm::length(x) == Approx(0.5));
    CHECK(glm::length(y) == Approx(glm::length(z)).epsilon(1e-12));
    // The nearest rotation shares the shear between the two axes.
    CHECK(y.x == Approx(-off / 4).epsilon(0.01));
    CHECK(x.y == Approx(off / 4).epsilon(0.01));
  }
  CHECK(read(camera(1e-2), Strictness::strict).error.find("stretch space") != std::string::npos);
}

TEST_CASE("ConcatTransform multiplies from the right by a matrix that is listed column by column") {
  // Transforms points by p' = T(1 2 3) · M · p, M = [ 0 -2 0; 2 0 0; 0 0 2 ] with translation 5
  // 0 0.
  for (const std::string last : {"5 0 0 1", "10 0 0 2"}) {
    const double w = last[0] == '5' ? 1 : 2;
    const auto n = [&](double v) { return std::to_string(v * w) + " "; };
    const std::string matrix = n(0) + n(2) + "0 0  " + n(-2) + n(0) + "0 0  0 0 " + n(2) + "0  " + last;
    const Read result =
        read("WorldBegin\nTranslate 1 2 3\nConcatTransform [ " + matrix + " ]\n" + triangle, Strictness::strict);
    CAPTURE(matrix, result.error);
    REQUIRE(result.scene.shapes.size() == 1);
    const auto& p = std::get<MeshDescription>(result.scene.shapes[0].geometry).positions;
    CHECK(glm::length(p.at(0) - Point(6, 2, 3)) < 1e-12);
    CHECK(glm::length(p.at(1) - Point(6, 4, 3)) < 1e-12);
    CHECK(glm::length(p.at(2) - Point(4, 2, 3)) < 1e-12);
  }
}

TEST_CASE("The film's crop window and exposure") {
  const Read result = read(
      "Film \"rgb\" \"float iso\" 200 \"float imagingratio\" .25 \"float cropwindow\" [ .25 .5 0 .75 ]\n"
      "Camera \"perspective\" \"float shutterclose\" 3\nWorldBegin\n"
      "LightSource \"point\" \"rgb I\" [ 1 2 4 ]\nAreaLightSource \"diffuse\" \"rgb L\" [ 2 2 2 ]\n" +
          triangle,
      Strictness::strict);
  CHECK(result.error.empty());
  CHECK(result.scene.film.crop_window == std::array{.25, .5, 0., .75});
  CHECK(std::get<PointLightDescription>(result.scene.lights.at(0).kind).intensity == Rgb(1.5, 3, 6));
  CHECK(result.scene.shapes.at(0).emission->radiance == Rgb(3));
  CHECK(read("Film \"rgb\" \"float cropwindow\" [ .5 .5 0 1 ]", Strictness::strict).error.find("cropwindow") !=
        std::string::npos);
  CHECK(read("Film \"rgb\" \"float iso\" 0", Strictness::strict).error.find("iso") != std::string::npos);
  const Read bounds = read(
      "Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100 "
      "\"integer pixelbounds\" [ 50 100 0 25 ] WorldBegin\n" +
          triangle,
      Strictness::strict);
  CHECK(bounds.scene.film.crop_window == std::array{.25, .5, 0., .25});
  // As in pbrt's film.cpp.
  const Read both =
      read("Film \"rgb\" \"float cropwindow\" [ .25 .5 0 .75 ] \"integer pixelbounds\" [ 50 100 0 25 ] WorldBegin\n" +
               triangle,
           Strictness::strict);
  CHECK(both.scene.film.crop_window == std::array{.25, .5, 0., .75});
  CHECK(both.says("t.pbrt:1: warning: Film: cropwindow is used"));
}

TEST_CASE("Light above 1e20 is refused, whatever makes it that bright") {
  for (const char* light :
       {"LightSource \"point\" \"float power\" 1e30", "LightSource \"spot\" \"float power\" 1e30",
        "LightSource \"distant\" \"float illuminance\" 1e30", "LightSource \"infinite\" \"float illuminance\" 1e30",
        "LightSource \"point\" \"rgb I\" [ 1e-20 0 0 ] \"float power\" 1e10 \"float scale\" 1e20",
        "AreaLightSource \"diffuse\" \"float power\" 1e30"}) {
    CAPTURE(light);
    const Read result = read("WorldBegin\n" + std::string(light) + "\n" + triangle, Strictness::strict);
    CHECK(result.error.find("t.pbrt:2: ") == 0);
    CHECK(result.error.find("makes light above 1e20") != std::string::npos);
  }
  for (const char* light :
       {"LightSource \"point\" \"rgb I\" [ 1e15 1e15 1e15 ]", "LightSource \"spot\" \"rgb I\" [ 1e15 1e15 1e15 ]",
        "LightSource \"distant\" \"rgb L\" [ 1e15 1 1 ]", "LightSource \"infinite\" \"rgb L\" [ 1 1 1e15 ]"}) {
    CAPTURE(light);
    const std::string exposed = "Film \"rgb\" \"float iso\" 1e9\nWorldBegin\n" + std::string(light) + "\n" + triangle;
    CHECK(read(exposed, Strictness::strict).error.find("t.pbrt:3: this light times the exposure") == 0);
    CHECK(read(exposed.substr(exposed.find("WorldBegin")), Strictness::strict).error.empty());
  }
  const Read lamp = read(
      "Film \"rgb\" \"float iso\" 1e9\nWorldBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 1e15 0 0 ]\n" + triangle,
      Strictness::strict);
  CHECK(lamp.error.find("t.pbrt:4: this light times the exposure") == 0);
}

TEST_CASE("A sheet reflects and lets through at most all, however large its scale is") {
  // pbrt has clamp(scale · value, 0, 1).
  const Read result = read(
      "WorldBegin\nMaterial \"diffusetransmission\" \"rgb reflectance\" [ .5 .25 .1 ] \"rgb transmittance\" [ .1 .1 .2 "
      "] "
      "\"float scale\" 4\n" +
          triangle,
      Strictness::strict);
  CHECK(result.error.empty());
  const auto& sheet = std::get<DiffuseTransmissionDescription>(result.scene.materials.at(1).kind);
  CHECK(glm::length(sheet.reflectance - Rgb(1, 1, .4)) < 1e-12);
  CHECK(glm::length(sheet.transmittance - Rgb(.4, .4, .8)) < 1e-12);
  CHECK(result.count("warning: ") == 1 + result.count("no light"));
  CHECK(result.says("t.pbrt:2: warning: Material \"diffusetransmission\": parameter \"reflectance\" times \"scale\""));
}

TEST_CASE("Both layers of a coated conductor say where they are not anisotropic") {
  for (const std::string layer : {"conductor", "interface"}) {
    const Read result = read("WorldBegin\nMaterial \"coatedconductor\" \"float " + layer +
                                 ".uroughness\" .04 \"float " + layer + ".vroughness\" .12\n" + triangle,
                             Strictness::strict);
    CHECK(result.error.empty());
    CHECK(result.count("t.pbrt:2: warning: Material \"coatedconductor\": anisotropic roughness is not supported") == 1);
    const auto& metal = std::get<CoatedConductorDescription>(result.scene.materials.at(1).kind);
    const double alpha = layer == "conductor" ? metal.alpha : metal.coat_alpha;
    CHECK(std::abs(alpha - std::sqrt(.08)) < 1e-12);
  }
}

TEST_CASE("A roughness above 1 is cut to 1") {
  const Read result = read("WorldBegin\nMaterial \"conductor\" \"float roughness\" 3\n" + triangle, Strictness::strict);
  CHECK(result.count("t.pbrt:2: warning: Material \"conductor\": a roughness above 1") == 1);
  CHECK(std::get<ConductorDescription>(result.scene.materials.at(1).kind).alpha == 1.0);
}

TEST_CASE("What absorbs inside of a dielectric is read, with its scale, and belongs to its boundary") {
  const Read result = read(clear + "WorldBegin\nMaterial \"dielectric\"\nMediumInterface \"ink\" \"\"\n" + triangle +
                               "MediumInterface \"ink\"\nMaterial \"diffuse\"\n" + triangle +
                               "MakeNamedMedium \"wine\" \"rgb sigma_s\" [ 0 0 0 ] \"float scale\" 1000\n"
                               "Material \"dielectric\"\nMediumInterface \"wine\" \"ink\"\n" +
                               triangle,
                           Strictness::strict);
  CAPTURE(result.error);
  REQUIRE(result.scene.shapes.size() == 3);
  REQUIRE(result.scene.shapes[0].absorption);
  CHECK(result.scene.shapes[0].absorption->inside == Rgb(1, 2, 3));
  CHECK(result.scene.shapes[0].absorption->outside == Rgb(0));
  CHECK_FALSE(result.scene.shapes[1].absorption);  // the medium goes on behind it
  REQUIRE(result.scene.shapes[2].absorption);
  CHECK(glm::length(result.scene.shapes[2].absorption->inside - Rgb(1000)) < 1e-9);  // of pbrt's usual 1
  CHECK(result.scene.shapes[2].absorption->outside == Rgb(1, 2, 3));
  CHECK(read("MakeNamedMedium \"m\" \"rgb sigma_s\" [ 0 0 0 ] \"rgb sigma_a\" [ -1 0 0 ]", Strictness::strict)
            .error.find("sigma_a") != std::string::npos);
}

TEST_CASE("Attribute sets what a medium does not say itself") {
  const Read result = read(
      "Attribute \"medium\" \"rgb sigma_a\" [ 1 2 3 ] \"rgb sigma_s\" [ 0 0 0 ]\nMakeNamedMedium \"ink\"\n"
      "MakeNamedMedium \"wine\" \"rgb sigma_a\" [ 5 5 5 ]\nWorldBegin\nMaterial \"dielectric\"\n"
      "MediumInterface \"ink\" \"\"\n" +
          triangle + "MediumInterface \"wine\" \"\"\n" + triangle,
      Strictness::strict);
  CAPTURE(result.error);
  REQUIRE(result.scene.shapes.size() == 2);
  CHECK(result.scene.shapes[0].absorption.value().inside == Rgb(1, 2, 3));
  CHECK(result.scene.shapes[1].absorption.value().inside == Rgb(5));
}
