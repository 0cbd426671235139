#include "support/pbrt/reader.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>

#include "program/read_scene.hpp"
#include "program/scratch_folder.hpp"
#include "support/catch.hpp"
#include "support/image/image.hpp"
#include "support/message_of.hpp"

#if GMIS_HAS_ZLIB
#include <zlib.h>
#endif

using namespace gmis::tools;
namespace fs = std::filesystem;
using gmis_test::Read;

namespace {

Read read(const std::string& text, const fs::path& folder = ".") {
  Read result;
  result.scene = read_pbrt_text(text, "t.pbrt", folder, result.diagnostics);
  return result;
}

/// A world with one triangle, so that the scene counts as one.
const std::string triangle =
    "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"integer indices\" [ 0 1 2 ]\n";

Read read_world(const std::string& world) {
  return read("WorldBegin\n" + world + triangle);
}

MaterialDescription material_of(const std::string& directive) {
  const Read result = read_world(directive + "\n");
  return result.scene.materials.at(result.scene.shapes.at(0).material);
}

const MeshDescription& mesh(const Read& result, std::size_t shape = 0) {
  return std::get<MeshDescription>(result.scene.shapes.at(shape).geometry);
}

const SphereDescription& sphere(const Read& result, std::size_t shape = 0) {
  return std::get<SphereDescription>(result.scene.shapes.at(shape).geometry);
}

glm::dvec3 normal_of(const MeshDescription& m, std::size_t triangle_index = 0) {
  const auto& t = m.triangles.at(triangle_index);
  const auto at = [&](std::size_t k) { return m.positions.at(static_cast<std::size_t>(t[k])); };
  return glm::normalize(glm::cross(at(1) - at(0), at(2) - at(0)));
}

bool near(const glm::dvec3& a, const glm::dvec3& b, double tolerance = 1e-12) {
  return glm::length(a - b) <= tolerance * (1 + glm::length(b));
}

struct ScratchFolder : gmis_test::ScratchFolder {
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((path / name).parent_path());
    std::ofstream(path / name, std::ios::binary) << text;
  }
};

}  // namespace

TEST_CASE("The picture: film, filter, camera") {
  const Read result = read(
      "Film \"rgb\" \"integer xresolution\" [ 320 ] \"integer yresolution\" 200 \"string filename\" [ \"x.exr\" ]\n"
      "Sampler \"halton\" \"integer pixelsamples\" 16\nIntegrator \"path\"\nColorSpace \"srgb\"\n"
      "PixelFilter \"box\" \"float xradius\" .5\n"
      "LookAt 0 0 -5  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 60\nWorldBegin\n" +
      triangle);
  CHECK(result.scene.film.width == 320);
  CHECK(result.scene.film.height == 200);
  CHECK(result.scene.film.file_name == "x.exr");
  CHECK(result.scene.camera.field_of_view == 60.0);
  const auto& m = result.scene.camera.world_from_camera;
  CHECK(near(glm::dvec3(m[3]), {0, 0, -5}));
  CHECK(near(glm::dvec3(m[2]), {0, 0, 1}));  // forward
  CHECK(near(glm::dvec3(m[1]), {0, 1, 0}));  // up
  CHECK(near(glm::dvec3(m[0]), {1, 0, 0}));  // right: camera space is left-handed
  CHECK(result.says("t.pbrt:2: note: Sampler"));
  CHECK(result.says("t.pbrt:3: note: Integrator"));
  CHECK(result.says("t.pbrt:4: note: ColorSpace"));
  CHECK_FALSE(result.says("warning: PixelFilter"));
}

TEST_CASE("Scale -1 1 1 before LookAt mirrors the picture, and WorldBegin forgets it") {
  const Read result =
      read("Scale -1 1 1 LookAt 0 1 6.8  0 1 5.8  0 1 0 Camera \"perspective\"\nWorldBegin\n" + triangle);
  const auto& m = result.scene.camera.world_from_camera;
  CHECK(near(glm::dvec3(m[3]), {0, 1, 6.8}));
  CHECK(near(glm::dvec3(m[2]), {0, 0, -1}));
  CHECK(near(glm::dvec3(m[0]), {1, 0, 0}));  // without the Scale it is -1 0 0
  CHECK(near(normal_of(mesh(result)), {0, 0, 1}));
}

TEST_CASE("The window of the picture on the plane at distance 1") {
  CameraDescription camera;
  camera.field_of_view = 90;
  const auto wide = picture_window(camera, 200, 100);
  CHECK(wide[1] == Approx(2));
  CHECK(wide[2] == Approx(-1));
  const auto tall = picture_window(camera, 100, 200);
  CHECK(tall[0] == Approx(-1));
  CHECK(tall[3] == Approx(2));
  camera.frame_aspect_ratio = 1;
  CHECK(picture_window(camera, 200, 100)[1] == Approx(1));
  camera.screen_window = std::array{-0.5, 1.0, -0.25, 0.75};
  CHECK(picture_window(camera, 200, 100)[0] == Approx(-0.5));
  CHECK(picture_window(camera, 200, 100)[3] == Approx(0.75));
  camera.field_of_view = 30;
  camera.is_orthographic = true;
  CHECK(picture_window(camera, 200, 100)[3] == Approx(0.75));
}

TEST_CASE("Lenses and parallel rays") {
  const auto lens =
      read("Camera \"perspective\" \"float lensradius\" .25 \"float focaldistance\" 7\nWorldBegin\n" + triangle);
  CHECK_FALSE(lens.scene.camera.is_orthographic);
  CHECK(lens.scene.camera.lens_radius == 0.25);
  CHECK(lens.scene.camera.focal_distance == 7);
  CHECK_FALSE(lens.says("Camera"));
  const auto parallel = read("Camera \"orthographic\" \"float screenwindow\" [ -3 3 -2 2 ]\nWorldBegin\n" + triangle);
  CHECK(parallel.scene.camera.is_orthographic);
  CHECK(picture_window(parallel.scene.camera, 600, 400)[1] == 3);
  CHECK_FALSE(parallel.says("Camera"));
}

TEST_CASE("Transforms compose as pbrt's do") {
  SECTION("the last one acts first") {
    const Read result = read_world("Translate 10 0 0 Rotate 90 0 0 1 Scale 2 3 4\n");
    // (1,0,0) is scaled to (2,0,0), turned to (0,2,0), moved to (10,2,0).
    CHECK(near(mesh(result).positions[1], {10, 2, 0}));
    CHECK(near(mesh(result).positions[2], {7, 0, 0}));
  }
  SECTION("matrices are written by columns") {
    const Read moved = read_world("Translate 1 1 1 ConcatTransform [ 1 0 0 0  0 1 0 0  0 0 1 0  5 6 7 1 ]\n");
    CHECK(near(mesh(moved).positions[0], {6, 7, 8}));
    const Read set = read_world("Translate 1 1 1 Transform [ 0 1 0 0  -1 0 0 0  0 0 1 0  5 6 7 1 ]\n");
    CHECK(near(mesh(set).positions[0], {5, 6, 7}));
    CHECK(near(mesh(set).positions[1], {5, 7, 7}));
    CHECK(near(mesh(read_world("Translate 1 1 1 Identity\n")).positions[0], {0, 0, 0}));
  }
  SECTION("named coordinate systems") {
    const Read result =
        read_world("Translate 1 2 3 CoordinateSystem \"here\" Translate 9 9 9 CoordSysTransform \"here\"\n");
    CHECK(near(mesh(result).positions[0], {1, 2, 3}));
    const Read camera =
        read("LookAt 3 4 5  3 4 6  0 1 0 Camera \"perspective\" WorldBegin CoordSysTransform \"camera\"\n" + triangle);
    CHECK(near(mesh(camera).positions[0], {3, 4, 5}));
    CHECK(near(mesh(read_world("Translate 1 1 1 CoordSysTransform \"world\"\n")).positions[0], {0, 0, 0}));
  }
  SECTION("blocks restore") {
    const Read result = read_world(
        "AttributeBegin Translate 5 0 0 ReverseOrientation Material \"mirror\" AttributeEnd\n"
        "TransformBegin Translate 5 0 0 TransformEnd\n");
    CHECK(near(mesh(result).positions[0], {0, 0, 0}));
    CHECK(near(normal_of(mesh(result)), {0, 0, 1}));
    CHECK(std::holds_alternative<DiffuseDescription>(result.scene.materials[result.scene.shapes[0].material].kind));
    // The older pair is the same: pbrt-v4 calls AttributeBegin and AttributeEnd.
    const Read older =
        read_world("TransformBegin Translate 5 0 0 ReverseOrientation Material \"mirror\" TransformEnd\n");
    CHECK(near(normal_of(mesh(older)), {0, 0, 1}));
    CHECK(std::holds_alternative<DiffuseDescription>(older.scene.materials[older.scene.shapes[0].material].kind));
    CHECK(near(mesh(read_world("TransformBegin Translate 5 0 0 AttributeEnd\n")).positions[0], {0, 0, 0}));
  }
}

TEST_CASE("The side of a surface") {
  CHECK(near(normal_of(mesh(read_world(""))), {0, 0, 1}));
  CHECK(near(normal_of(mesh(read_world("ReverseOrientation\n"))), {0, 0, -1}));
  CHECK(near(normal_of(mesh(read_world("ReverseOrientation ReverseOrientation\n"))), {0, 0, 1}));
  // A mirroring transform keeps the side: the surface's normal is carried along, whatever its
  // winding becomes.
  CHECK(near(normal_of(mesh(read_world("Scale -1 1 1\n"))), {0, 0, 1}));
  CHECK(near(normal_of(mesh(read_world("Scale 1 1 -1\n"))), {0, 0, -1}));
  CHECK(near(normal_of(mesh(read_world("Scale -1 1 1 ReverseOrientation\n"))), {0, 0, -1}));
  SECTION("vertex normals decide it") {
    const std::string with_normals =
        "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"normal N\" [ 0 0 -2  0 .1 -1  .1 0 -1 ]\n";
    const Read result = read("WorldBegin " + with_normals);
    CHECK(near(normal_of(mesh(result)), {0, 0, -1}));
    CHECK(near(mesh(result).normals[0], {0, 0, -1}));
    const Read reversed = read("WorldBegin ReverseOrientation " + with_normals);
    CHECK(near(normal_of(mesh(reversed)), {0, 0, 1}));
    CHECK(near(mesh(reversed).normals[0], {0, 0, 1}));
    // Normals go with the inverse transpose: stretching x by 2 halves their x.
    const Read stretched = read("WorldBegin Scale 2 1 1 " + with_normals);
    CHECK(near(mesh(stretched).normals[2], glm::normalize(glm::dvec3(0.05, 0, -1))));
  }
  SECTION("spheres face outwards unless reversed") {
    CHECK_FALSE(sphere(read_world("Shape \"sphere\"\n")).normal_points_inward);
    CHECK_FALSE(sphere(read_world("Scale -1 1 1 Shape \"sphere\"\n")).normal_points_inward);
    CHECK(sphere(read_world("ReverseOrientation Shape \"sphere\"\n")).normal_points_inward);
  }
}

TEST_CASE("Shapes") {
  SECTION("a sphere under a similarity") {
    const Read result =
        read_world("Translate 1 2 3 Rotate 30 1 1 0 Scale -2 2 2 Shape \"sphere\" \"float radius\" 1.5\n");
    CHECK(near(sphere(result).center, {1, 2, 3}));
    CHECK(sphere(result).radius == Approx(3));
  }
  SECTION("bilinear patches become triangles of the same side") {
    const Read result = read("WorldBegin Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0  1 1 0 ]");
    REQUIRE(mesh(result).triangles.size() == 2);
    CHECK(near(normal_of(mesh(result), 0), {0, 0, 1}));
    CHECK(near(normal_of(mesh(result), 1), {0, 0, 1}));
    CHECK_FALSE(result.says("not flat"));
    CHECK(read("WorldBegin Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0  1 1 1 ]").says("not flat"));
  }
  SECTION("PLY meshes") {
    const ScratchFolder folder;
    folder.write("meshes/square.ply",
                 "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                 "0 0 0\n2 0 0\n2 2 0\n0 2 0\n4 0 1 2 3\n");
    {
      const Read result =
          read("WorldBegin Translate 0 0 1 Shape \"plymesh\" \"string filename\" \"meshes/square.ply\"", folder.path);
      REQUIRE(mesh(result).triangles.size() == 2);
      CHECK(near(normal_of(mesh(result), 0), {0, 0, 1}));
      double area = 0;
      for (const auto& [a, b, c] : mesh(result).triangles) {
        const auto at = [&](int i) { return mesh(result).positions.at(static_cast<std::size_t>(i)); };
        CHECK(at(a).z == 1.0);
        area += glm::length(glm::cross(at(b) - at(a), at(c) - at(a))) / 2;
      }
      CHECK(area == Approx(4));
    }
  }
}

TEST_CASE("Objects are copied at their instances") {
  const Read result = read(
      "WorldBegin ObjectBegin \"pair\" Translate 1 0 0 Material \"mirror\" Shape \"sphere\" \"float radius\" .5\n" +
      triangle +
      "ObjectEnd\nAttributeBegin Scale 2 2 2 ObjectInstance \"pair\" AttributeEnd\n"
      "Translate 0 0 7 Scale 1 1 -1 ObjectInstance \"pair\"\n");
  REQUIRE(result.scene.shapes.size() == 4);
  CHECK(near(sphere(result, 0).center, {2, 0, 0}));
  CHECK(sphere(result, 0).radius == Approx(1));
  CHECK(near(mesh(result, 1).positions[1], {4, 0, 0}));
  CHECK(near(sphere(result, 2).center, {1, 0, 7}));
  CHECK(near(normal_of(mesh(result, 3)), {0, 0, -1}));
  CHECK(std::holds_alternative<MirrorDescription>(result.scene.materials[result.scene.shapes[3].material].kind));
  // Lights inside objects do not shine, here as in pbrt, and that is said.
  const Read dark =
      read("WorldBegin ObjectBegin \"o\" AreaLightSource \"diffuse\" " + triangle + "ObjectEnd ObjectInstance \"o\"");
  CHECK_FALSE(dark.scene.shapes[0].emission.has_value());
  CHECK(dark.says("does not shine"));
}

TEST_CASE("Materials") {
  const auto diffuse =
      std::get<DiffuseDescription>(material_of("Material \"diffuse\" \"rgb reflectance\" [ .1 .2 .3 ]").kind);
  CHECK(diffuse.reflectance == Rgb(0.1, 0.2, 0.3));
  CHECK(std::get<DiffuseDescription>(material_of("").kind).reflectance == Rgb(0.5));
  const auto constant = material_of("Material \"diffuse\" \"spectrum reflectance\" [ 400 .25  700 .25 ]");
  CHECK(std::get<DiffuseDescription>(constant.kind).reflectance == Rgb(0.25));
  CHECK(std::get<MirrorDescription>(material_of("Material \"mirror\" \"rgb reflectance\" [ .9 .8 .7 ]").kind)
            .reflectance == Rgb(0.9, 0.8, 0.7));
  const auto phong = std::get<PhongDescription>(
      material_of(
          "Material \"phong\" \"rgb reflectance\" [ .1 .1 .1 ] \"rgb specular\" [ .7 .6 .5 ] \"float exponent\" 90")
          .kind);
  CHECK(phong.specular == Rgb(0.7, 0.6, 0.5));
  CHECK(phong.exponent == 90.0);

  SECTION("roughness maps to GGX alpha") {
    const auto alpha = [](const std::string& parameters) {
      return std::get<ConductorDescription>(material_of("Material \"conductor\" " + parameters).kind).alpha;
    };
    CHECK(alpha("") == 0.0);
    CHECK(alpha("\"float roughness\" .25") == Approx(0.5));
    CHECK(alpha("\"float roughness\" .25 \"bool remaproughness\" false") == Approx(0.25));
    CHECK(alpha("\"float roughness\" .25 \"bool remaproughness\" [ \"false\" ]") == Approx(0.25));
    CHECK(alpha("\"float uroughness\" .04 \"float vroughness\" .04") == Approx(0.2));
    CHECK(alpha("\"float uroughness\" .04 \"float vroughness\" .12") == Approx(std::sqrt(0.08)));
    CHECK(alpha("\"float roughness\" 9.9e-7") == 0.0);  // alpha just below 1e-3
    CHECK(alpha("\"float roughness\" 1.1e-6") > 0.0);
  }
  SECTION("metals") {
    const auto copper = std::get<ConductorDescription>(
        material_of("Material \"conductor\" \"spectrum eta\" \"metal-Cu-eta\" \"spectrum k\" \"metal-Cu-k\"").kind);
    CHECK(copper.eta == Rgb(0.1697, 0.9709, 1.213));
    CHECK(copper.k == Rgb(3.236, 2.594, 2.355));
    CHECK(std::get<ConductorDescription>(material_of("Material \"conductor\"").kind).k == copper.k);  // the default
    // With eta = 1, reflectance head on is k²/(4 + k²).
    const auto given =
        std::get<ConductorDescription>(material_of("Material \"conductor\" \"rgb reflectance\" [ .9 .5 0 ]").kind);
    CHECK(given.eta == Rgb(1));
    CHECK(given.k.x * given.k.x / (4 + given.k.x * given.k.x) == Approx(0.9));
    CHECK(given.k.y * given.k.y / (4 + given.k.y * given.k.y) == Approx(0.5));
    CHECK(given.k.z == 0.0);
  }
  SECTION("glass") {
    CHECK(std::get<DielectricDescription>(material_of("Material \"dielectric\"").kind).eta == 1.5);
    CHECK(std::get<DielectricDescription>(material_of("Material \"dielectric\" \"float eta\" 1.6").kind).eta == 1.6);
    CHECK(std::get<DielectricDescription>(material_of("Material \"dielectric\"").kind).alpha == 0);
    CHECK(std::get<DielectricDescription>(material_of("Material \"dielectric\" \"float roughness\" .09").kind).alpha ==
          Approx(0.3));
    CHECK(std::get<DielectricDescription>(material_of("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"").kind)
              .eta == Approx(1.5168));
    CHECK_FALSE(std::get<DielectricDescription>(material_of("Material \"dielectric\"").kind).is_thin);
    const auto pane =
        std::get<DielectricDescription>(material_of("Material \"thindielectric\" \"spectrum eta\" \"glass-BK7\"").kind);
    CHECK(pane.is_thin);
    CHECK(pane.alpha == 0);
    CHECK(pane.eta == Approx(1.5168));
    CHECK(std::get<DielectricDescription>(material_of("Material \"thindielectric\"").kind).eta == 1.5);
  }
  SECTION("coateddiffuse") {
    const auto coated = std::get<CoatedDiffuseDescription>(
        material_of("Material \"coateddiffuse\" \"rgb reflectance\" [ .2 .4 .6 ] \"float roughness\" .01").kind);
    CHECK(coated.reflectance == Rgb(0.2, 0.4, 0.6));
    CHECK(coated.alpha == Approx(0.1));
    CHECK(coated.eta == 1.5);
  }
  SECTION("named materials and constant textures") {
    const auto named = material_of(
        "Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [ .3 .2 .1 ]\nTexture \"r\" \"float\" \"constant\" "
        "\"float value\" .16\n"
        "MakeNamedMaterial \"m\" \"string type\" \"coateddiffuse\" \"texture reflectance\" \"t\" \"texture roughness\" "
        "\"r\"\n"
        "Material \"mirror\" NamedMaterial \"m\"");
    const auto coated = std::get<CoatedDiffuseDescription>(named.kind);
    CHECK(coated.reflectance == Rgb(0.3, 0.2, 0.1));
    CHECK(coated.alpha == Approx(0.4));
  }
  SECTION("Attribute sets what is not given") {
    const auto set = material_of("Attribute \"material\" \"rgb reflectance\" [ .1 .1 .1 ]\nMaterial \"diffuse\"");
    CHECK(std::get<DiffuseDescription>(set.kind).reflectance == Rgb(0.1));
    const auto given = material_of(
        "Attribute \"material\" \"rgb reflectance\" [ .1 .1 .1 ]\nMaterial \"diffuse\" \"rgb reflectance\" [ 0 0 1 ]");
    CHECK(std::get<DiffuseDescription>(given.kind).reflectance == Rgb(0, 0, 1));
  }
}

TEST_CASE("Lights") {
  const auto light_of = [](const std::string& text) { return read_world(text + "\n").scene.lights.at(0).kind; };
  SECTION("point") {
    const auto light = std::get<PointLightDescription>(light_of(
        "Translate 1 0 0 LightSource \"point\" \"rgb I\" [ 1 2 3 ] \"float scale\" 2 \"point3 from\" [ 0 5 0 ]"));
    CHECK(near(light.position, {1, 5, 0}));
    CHECK(light.intensity == Rgb(2, 4, 6));
    // Power over the whole sphere, as luminance.
    const auto powered =
        std::get<PointLightDescription>(light_of("LightSource \"point\" \"rgb I\" [ 2 2 2 ] \"float power\" 100"));
    CHECK(powered.intensity.y == Approx(100 / (4 * std::numbers::pi)));
  }
  SECTION("distant") {
    const auto light =
        std::get<DistantLightDescription>(light_of("Rotate 90 0 0 1 LightSource \"distant\" \"rgb L\" [ 1 1 1 ] "
                                                   "\"point3 from\" [ 3 0 0 ] \"point3 to\" [ 1 0 0 ]"));
    CHECK(near(light.to_light, {0, 1, 0}));
    const auto standard = std::get<DistantLightDescription>(light_of("LightSource \"distant\""));
    CHECK(near(standard.to_light, {0, 0, -1}));
    const auto set = std::get<DistantLightDescription>(light_of("LightSource \"distant\" \"float illuminance\" 7"));
    CHECK(set.irradiance.x == Approx(7));
  }
  SECTION("spot") {
    const auto spot = std::get<SpotLightDescription>(light_of(
        "Translate 1 0 0 Scale 2 2 2 LightSource \"spot\" \"rgb I\" [ 1 2 3 ] \"float scale\" 2 \"point3 from\" "
        "[ 0 1 0 ] \"point3 to\" [ 0 0 0 ] \"float coneangle\" 60 \"float conedeltaangle\" 15"));
    CHECK(near(spot.position, {1, 2, 0}));
    CHECK(near(spot.direction, {0, -1, 0}));
    CHECK(near(spot.intensity, {2, 4, 6}));
    CHECK(spot.outer == Approx(std::acos(0.5)));
    CHECK(spot.inner == Approx(std::acos(std::sqrt(0.5))));
    const auto standard = std::get<SpotLightDescription>(light_of("LightSource \"spot\""));
    CHECK(near(standard.direction, {0, 0, 1}));
    CHECK(standard.inner == Approx(25 * std::acos(-1.0) / 180));
    // A sharp cone of 60 degrees is a quarter of the sphere.
    const auto powered = std::get<SpotLightDescription>(
        light_of("LightSource \"spot\" \"float power\" 10 \"float coneangle\" 60 \"float conedeltaangle\" 0"));
    CHECK(powered.intensity.x == Approx(10 / std::acos(-1.0)));
  }
  SECTION("an image of the sky") {
    const ScratchFolder scratch;
    const fs::path& folder = scratch.path;
    Image image(2, 2);
    for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<float>(i) - 1;
    write_image(image, folder / "square.pfm");
    write_image(Image(6, 3), folder / "wide.pfm");
    write_image(Image(5, 3), folder / "odd.pfm");
    const auto lit_by = [&](const std::string& parameters) {
      return read("WorldBegin Rotate 90 0 0 1 LightSource \"infinite\" \"string filename\" " + parameters + triangle,
                  folder);
    };
    const Read square = lit_by("\"square.pfm\" \"float scale\" 3\n");
    REQUIRE(square.scene.lights.size() == 1);
    const auto& sky = std::get<EnvironmentLightDescription>(square.scene.lights[0].kind);
    CHECK(sky.image.mapping == gmis::scene::SkyMapping::equal_area);
    REQUIRE(sky.image.radiance.size() == 4);
    CHECK(sky.image.radiance[0] == glm::vec3(0, 0, 3));
    CHECK(sky.image.radiance[3] == glm::vec3(24, 27, 30));
    CHECK(square.says("negative"));
    CHECK(near(sky.world_from_sky[0], {0, 1, 0}));
    CHECK(lit_by("\"wide.pfm\"\n").scene.lights.empty());  // black
    CHECK(lit_by("\"wide.pfm\"\n").says("latitude"));
    const std::string message = gmis_test::message_of<InputError>([&] { return lit_by("\"odd.pfm\"\n"); });
    CHECK(message.find("t.pbrt:1: ") == 0);
    CHECK(message.find("5 by 3") != std::string::npos);
  }
  SECTION("infinite") {
    CHECK(
        std::get<InfiniteLightDescription>(light_of("LightSource \"infinite\" \"rgb L\" [ 1 0 0 ] \"float scale\" .5"))
            .radiance == Rgb(0.5, 0, 0));
    CHECK(std::get<InfiniteLightDescription>(light_of("LightSource \"infinite\" \"float illuminance\" 3")).radiance.x ==
          Approx(3 / std::numbers::pi));
  }
  SECTION("area") {
    const Read result =
        read_world("AreaLightSource \"diffuse\" \"rgb L\" [ 4 5 6 ] \"float scale\" .5 \"bool twosided\" true\n");
    CHECK(result.scene.shapes[0].emission.value().radiance == Rgb(2, 2.5, 3));
    CHECK(result.scene.shapes[0].emission.value().is_two_sided);
    // Flux of a Lambertian emitter: π · area · radiance; this triangle, scaled by 2, has area 2.
    const Read powered = read_world("Scale 2 2 2 AreaLightSource \"diffuse\" \"rgb L\" [ 3 3 3 ] \"float power\" 10\n");
    CHECK(powered.scene.shapes[0].emission.value().radiance.x == Approx(10 / (std::numbers::pi * 2)));
    const Read ball =
        read("WorldBegin AreaLightSource \"diffuse\" \"float power\" 8 Shape \"sphere\" \"float radius\" 2");
    CHECK(ball.scene.shapes[0].emission.value().radiance.x == Approx(8 / (16 * std::numbers::pi * std::numbers::pi)));
  }
  SECTION("power and illuminance of 0 or less are as if they were not given, as in pbrt") {
    for (const std::string value : {"0", "-1"}) {
      CAPTURE(value);
      CHECK(std::get<PointLightDescription>(light_of("LightSource \"point\" \"float power\" " + value)).intensity ==
            Rgb(1));
      CHECK(std::get<SpotLightDescription>(light_of("LightSource \"spot\" \"float power\" " + value)).intensity ==
            Rgb(1));
      for (const std::string kind : {"distant", "infinite"})
        CHECK(read_world("LightSource \"" + kind + "\" \"float illuminance\" " + value + "\n").scene.lights.size() ==
              1);
      const Read area = read_world("AreaLightSource \"diffuse\" \"float power\" " + value + "\n");
      CHECK(area.scene.shapes[0].emission.value().radiance == Rgb(1));
    }
  }
  SECTION("black ones are left out") {
    const Read result =
        read_world("LightSource \"point\" \"rgb I\" [ 0 0 0 ]\nAreaLightSource \"diffuse\" \"float scale\" 0\n");
    CHECK(result.scene.lights.empty());
    CHECK_FALSE(result.scene.shapes[0].emission.has_value());
    CHECK(result.says("no light"));
  }
}

TEST_CASE("Files include others, found beside the scene") {
  const ScratchFolder folder;
  folder.write("main.pbrt", "WorldBegin\nInclude \"parts/a.pbrt\"\nImport \"parts/c.pbrt\"\n" + triangle);
  folder.write("parts/a.pbrt", "Translate 1 0 0\nInclude \"parts/b.pbrt\"\n");
  folder.write("parts/b.pbrt", "Translate 0 1 0\n");
  folder.write("parts/c.pbrt", "Translate 0 0 100\n" + triangle);
  Diagnostics diagnostics;
  const SceneDescription scene = read_pbrt_scene(folder.path / "main.pbrt", diagnostics);
  REQUIRE(scene.shapes.size() == 2);
  CHECK(near(std::get<MeshDescription>(scene.shapes[0].geometry).positions[0], {1, 1, 100}));
  CHECK(near(std::get<MeshDescription>(scene.shapes[1].geometry).positions[0], {1, 1, 0}));
  CHECK(scene.shapes[0].where.to_string() == (folder.path / "parts/c.pbrt").string() + ":2");
  CHECK(scene.shapes[1].where.to_string() == (folder.path / "main.pbrt").string() + ":4");
}

#if GMIS_HAS_ZLIB
TEST_CASE("Scenes and what they include may be packed") {
  const ScratchFolder folder;
  const auto pack = [&](const std::string& name, const std::string& text) {
    const gzFile file = gzopen((folder.path / name).c_str(), "wb");
    gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
    gzclose(file);
  };
  pack("main.pbrt.gz", "WorldBegin\nInclude \"a.pbrt.gz\"\nImport \"b.pbrt.gz\"\n" + triangle);
  pack("a.pbrt.gz", "Translate 1 0 0\n");
  pack("b.pbrt.gz", "Translate 0 2 0\n" + triangle);
  Diagnostics diagnostics;
  const SceneDescription scene = read_pbrt_scene(folder.path / "main.pbrt.gz", diagnostics);
  REQUIRE(scene.shapes.size() == 2);
  CHECK(near(std::get<MeshDescription>(scene.shapes[0].geometry).positions[0], {1, 2, 0}));
  CHECK(near(std::get<MeshDescription>(scene.shapes[1].geometry).positions[0], {1, 0, 0}));
  CHECK(scene.shapes[0].where.to_string() == (folder.path / "b.pbrt.gz").string() + ":2");
  CHECK(scene.files.size() == 3);
  folder.write("no.pbrt.gz", "Translate 1 0 0\n");
  const std::string message =
      gmis_test::message_of<InputError>([&] { return read("WorldBegin\nInclude \"no.pbrt.gz\"\n", folder.path); });
  CHECK(message.find("t.pbrt:2: ") == 0);
  CHECK(message.find("no whole gzip") != std::string::npos);
}
#endif

TEST_CASE("What is not understood but harmless is said once, with its place") {
  const Read result = read_world("\nShape \"sphere\" \"float radious\" 2\nShape \"sphere\" \"float radious\" 3\n");
  const auto count = [&](const std::string& part) {
    return std::count_if(result.diagnostics.all().begin(), result.diagnostics.all().end(),
                         [&](const Diagnostic& d) { return d.to_string().find(part) != std::string::npos; });
  };
  CHECK(count("t.pbrt:3: warning: Shape \"sphere\": parameter \"radious\"") == 1);
  CHECK(count("radious") == 1);
  CHECK(read("PixelFilter \"gaussian\" WorldBegin " + triangle).says("t.pbrt:1: warning: PixelFilter"));
  CHECK(read("Camera \"orthographic\" \"float lensradius\" .1 WorldBegin " + triangle).says("a lens is not supported"));
}

TEST_CASE("The reference scenes and the example scenes are read without a warning") {
  int scenes = 0;
  for (const char* folder : {GMIS_REFERENCE_FOLDER, GMIS_SCENE_FOLDER})
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() != ".pbrt") continue;
      CAPTURE(entry.path().string());
      Diagnostics diagnostics;
      const SceneDescription scene = read_pbrt_scene(entry.path(), diagnostics);
      for (const Diagnostic& diagnostic : diagnostics.all())
        CHECK(diagnostic.to_string().find("warning") == std::string::npos);
      CHECK(scene.shapes.size() >= 6);
      ++scenes;
    }
  CHECK(scenes >= 4);
}

TEST_CASE("Facts of the reference scenes") {
  Diagnostics diagnostics;
  const SceneDescription tung1 = read_pbrt_scene(fs::path(GMIS_REFERENCE_FOLDER) / "tung1.pbrt", diagnostics);
  CHECK(tung1.shapes.size() == 12);
  const ShapeDescription& lamp = tung1.shapes[5];
  REQUIRE(lamp.emission.has_value());
  CHECK(lamp.emission->radiance == Rgb(40));
  CHECK(near(normal_of(std::get<MeshDescription>(lamp.geometry)), {0, -1, 0}));  // it shines down
  const SceneDescription svcm0 = read_pbrt_scene(fs::path(GMIS_REFERENCE_FOLDER) / "svcm0.pbrt", diagnostics);
  REQUIRE(svcm0.lights.size() == 1);
  const auto sun = std::get<DistantLightDescription>(svcm0.lights[0].kind);
  CHECK(near(sun.to_light, glm::normalize(glm::dvec3(1, -1.5, 1))));
  CHECK(sun.irradiance == Rgb(10, 4, 0));
  CHECK(svcm0.film.width == 128);
}
