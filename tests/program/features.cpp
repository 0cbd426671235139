#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <string>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/scene/fresnel.hpp"
#include "support/build_scene.hpp"
#include "support/catch.hpp"
#include "support/choices.hpp"
#include "support/fewer.hpp"
#include "support/pbrt/reader.hpp"
#include "support/pbrt/spectra.hpp"
#include "support/read_scene.hpp"
#include "support/render.hpp"
#include "support/seed.hpp"
#include "support/series.hpp"

// One small scene for each feature of the scene format, rendered by paths from the camera alone and
// by paths from both ends. The picture of nearly all of them is known: a surface that fills the
// picture, under light of radiance 1 from everywhere, is seen with its albedo; a light of radiance
// 1 shows the shape that it has.

using namespace gmis::tools;
namespace fs = std::filesystem;

namespace {

const fs::path folder = GMIS_FEATURE_FOLDER;
constexpr int resolution = 16;

/// The radiance that is seen at x to the right and y up, both from −1 to 1.
using Picture = std::function<Rgb(double x, double y)>;

double from_srgb(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

/// colors.png and colors.tga: 4×4 texels, (s, t) from the lower left.
Rgb colors_at(double s, double t, const std::function<double(double)>& decode) {
  const auto texel = [](double x) { return std::clamp(static_cast<int>(std::floor((x - std::floor(x)) * 4)), 0, 3); };
  const int column = texel(s), row = 3 - texel(t);
  return {decode((60 * column + 20) / 255.0), decode((60 * row + 20) / 255.0), decode(128 / 255.0)};
}
double linear(double code) {
  return code;
}
/// cutout.png: texels whose column and row, from the top, differ in parity are there.
bool is_there(double x, double y) {
  const int column = static_cast<int>((x + 1) * 2), row = 3 - static_cast<int>((y + 1) * 2);
  return (column + row) % 2 != 0;
}
Picture colored(const std::function<double(double)>& decode) {
  return [=](double x, double y) { return colors_at((x + 1) / 2, (y + 1) / 2, decode); };
}
Picture flat(const Rgb& color) {
  return [=](double, double) { return color; };
}
Picture where(const std::function<bool(double, double)>& is_seen) {
  return [=](double x, double y) { return Rgb(is_seen(x, y) ? 1 : 0); };
}
Rgb metal(const char* name, double outside = 1) {
  const std::string start = "metal-" + std::string(name);
  const Rgb eta = *pbrt::named_spectrum(start + "-eta"), k = *pbrt::named_spectrum(start + "-k");
  return gmis::scene::fresnel_conductor(1.0, eta / outside, k / outside);
}
/// Distance from a closed uniform cubic B-spline around the square's corners, by its polygon of 400
/// points.
bool is_in_spline(double x, double y) {
  const glm::dvec2 corners[] = {{-.9, -.9}, {.9, -.9}, {.9, .9}, {-.9, .9}};
  bool is_inside = false;
  glm::dvec2 before(0);
  for (int i = 0; i <= 400; ++i) {
    const int span = i / 100 % 4;
    const double t = (i % 100) / 100.0;
    const auto corner = [&](int k) { return corners[(span + k) % 4]; };
    const glm::dvec2 now = (corner(0) * std::pow(1 - t, 3) + corner(1) * (3 * t * t * t - 6 * t * t + 4) +
                            corner(2) * (-3 * t * t * t + 3 * t * t + 3 * t + 1) + corner(3) * (t * t * t)) /
                           6.0;
    if (i > 0 && (before.y > y) != (now.y > y) &&
        x < before.x + (now.x - before.x) * (y - before.y) / (now.y - before.y))
      is_inside = !is_inside;
    before = now;
  }
  return is_inside;
}

/// 2 · 0.5/π · max(0, n · l) of a lambertian surface under the light of bump.pbrt and
/// normal_map.pbrt.
double lit(const glm::dvec3& normal) {
  return 2 * 0.5 / gmis::pi<double> * glm::dot(glm::normalize(normal), glm::normalize(glm::dvec3(3, 0, -4)));
}

/// A slab of glass of index 1.5 through which `transmittance` passes, in light of radiance 1 from
/// everywhere, seen head on: what both faces reflect and let through, to and fro.
Picture slab(const Rgb& transmittance) {
  const double r = 0.04;
  const Rgb within = (1 - r) * (1 - r) / (1.0 - r * r * transmittance * transmittance);
  return flat(r + within * r * transmittance * transmittance + within * transmittance);
}

/// A pane of index 1.5 in light of radiance 1 from everywhere, seen head on: both faces together
/// reflect 2 R / (1 + R), and what passes is coloured.
Rgb pane(const Rgb& tint) {
  const double reflected = 2 * 0.04 / (1 + 0.04);
  return reflected + (1 - reflected) * tint;
}

/// A diffuse base under a smooth coat of index 1.5 in that light, seen head on: what the coat
/// reflects, and what comes through it from the base, with the light that goes to and fro.
Rgb coated(const Rgb& base) {
  const double r = 0.04, from_outside = gmis::scene::fresnel_diffuse_reflectance(1.5);
  const double from_inside = 1 - (1 - from_outside) / (1.5 * 1.5);
  return r + (1 - r) * (1 - from_outside) * base / (1.5 * 1.5 * (1.0 - base * from_inside));
}

const std::map<std::string, Picture> pictures{
    {"imagemap_png", colored(from_srgb)},
    {"imagemap_tga", colored(linear)},
    {"imagemap_gamma", colored([](double code) { return code * code; })},
    {"imagemap_jpeg", flat({from_srgb(200 / 255.0), from_srgb(120 / 255.0), from_srgb(40 / 255.0)})},
    {"imagemap_bilinear", [](double x, double) { return Rgb(std::clamp((x + 1) - 0.5, 0.0, 1.0)); }},
    {"imagemap_repeat", [](double x, double y) { return colors_at(x + 1 + 0.25, y + 1, linear); }},
    {"imagemap_black", [](double x, double y) { return x < 0 && y < 0 ? colors_at(x + 1, y + 1, linear) : Rgb(0); }},
    {"imagemap_invert", [](double x, double y) { return 1.0 - 0.5 * colors_at((x + 1) / 2, (y + 1) / 2, linear); }},
    {"one_pixel", flat(Rgb(from_srgb(188 / 255.0)))},
    {"scale", [](double x, double y) { return 0.5 * colors_at((x + 1) / 2, (y + 1) / 2, linear); }},
    {"mix_texture", [](double x, double) { return x < 0 ? Rgb(.8, .4, .2) : Rgb(.2, .4, .6); }},
    {"checkerboard",
     [](double x, double y) {
       return (static_cast<int>((x + 1) * 2) + static_cast<int>((y + 1) * 2)) % 2 == 0 ? Rgb(.8, .8, .2)
                                                                                       : Rgb(.1, .1, .4);
     }},
    {"constant", flat({.3, .5, .7})},
    {"alpha_constant", flat(Rgb(.5, .3, .1) * .4 + .6)},
    {"alpha_texture", [](double x, double y) { return is_there(x, y) ? Rgb(.5, .3, .1) : Rgb(1); }},
    {"alpha_layers", flat(Rgb(.7 * .7 * .7))},
    {"alpha_zero", flat(Rgb(1))},
    {"diffuse_transmission", flat({.4, .6, .7})},
    {"leaf", [](double x, double y) { return is_there(x, y) ? colored(linear)(x, y) : Rgb(1); }},
    {"mix_material", flat(Rgb(.8, .1, .1) * .75 + Rgb(0, .5, .9) * .25)},
    {"coated_conductor", flat([] {
       const Rgb within = metal("Cu", 1.5);
       const double coat = 0.04;
       return Rgb(coat) + within * 0.96 * 0.96 / (1.0 - within * coat);
     }())},
    {"brass", flat(metal("CuZn"))},
    {"blackbody", flat(pbrt::blackbody(3000) * .5)},
    {"disk", where([](double x, double y) { return y > 0 && std::hypot(x, y) < .8 && std::hypot(x, y) > .4; })},
    {"cylinder", where([](double x, double y) { return std::abs(y) < .5 && x > -.75 && x < .5; })},
    {"sphere_part", where([](double x, double y) { return std::hypot(x, y) < .8 && y < 0; })},
    {"ellipsoid", where([](double x, double y) { return std::hypot(x / .9, y / .4) < 1; })},
    {"tiny_disk", flat(Rgb(1))},
    {"loopsubdiv", where(is_in_spline)},
    {"plymesh_gz", colored(linear)},
    // A height of 0.3 over the middle half of a width of 2, towards the light's side of the
    // surface.
    {"bump", [](double x, double) { return Rgb(lit(glm::dvec3(std::abs(x) < .5 ? -.3 : 0., 0, -1))); }},
    {"normal_map", flat(Rgb(lit({.6, .003922, -.80392})))},
    {"absorption", slab(glm::exp(-Rgb(.1, .35, .8)))},
    {"absorption_rough", {}},
    {"volume", slab(Rgb(.9, .6, .25) * Rgb(.9, .6, .25))},
    {"normal_map_inside", {}},
    {"coated_texture", {}},
    {"coated_conductor_rough", {}},
    {"roughness_texture", {}},
    {"glow", flat({.5, 1, 2})},
    {"metal", flat({.9, .6, .3})},
    {"metal_texture", colored(from_srgb)},
    {"pane", flat(pane({.9, .6, .3}))},
    {"pane_metal", flat(Rgb(.9, .6, .3) * .25 + pane({.9, .6, .3}) * .75)},
    {"coat", flat(coated({.2, .5, .8}))},
    {"unlit_colors",
     [](double x, double y) {
       const double s = (x + 1) / 2, t = (y + 1) / 2;  // red, green, blue and yellow at the corners
       return Rgb(1 - s, std::abs(s - t), std::min(s, t));
     }},
    {"mask", flat(Rgb(.9, .6, .3) * .25 + .75)},
    {"crop", flat(Rgb(.25, .15, .05))},
    {"camera_off", flat({.5, .3, .1})},
    {"bright_pixel", {}},
};

/// The scene of this name: pbrt's text or glTF.
fs::path file_of(const std::string& name) {
  const fs::path text = folder / (name + ".pbrt");
  return fs::exists(text) ? text : folder / (name + ".gltf");
}

// 31 degrees of freedom: the quantile of the comparisons below is 6.3, and was 16 with the same
// work in eight runs.
constexpr int runs = 32, iterations = 4 / gmis_test::fewer;

std::vector<gmis_test::Series> measured(const std::string& name, IntegratorChoice integrator) {
  Diagnostics diagnostics;
  const bool is_gltf = file_of(name).extension() == ".gltf";
  LoadOptions load;
  if (is_gltf) load.sky = "white";  // none of these files has a light
  SceneDescription description = read_scene(file_of(name), diagnostics, load);
  if (is_gltf) description.film.width = description.film.height = resolution;
  const auto scene = build_scene(description, diagnostics);
  for (const Diagnostic& diagnostic : diagnostics.all()) {
    CAPTURE(diagnostic.to_string());
    CHECK(diagnostic.severity == Severity::note);
  }
  Options options;
  options.connections = 1;
  RenderRequest request;
  request.integrator = options.integrator = integrator;
  request.split = options.split = SplitChoice::none;
  request.expected_iterations = iterations;
  request.settings.max_depth = 6;
  request.crop = scene->film_crop();
  set_counts(request, options, *scene);
  request.budget.iterations = iterations;
  ThreadedExecutor executor(1);
  std::vector<gmis_test::Series> means(12);  // of quarters and channels
  for (std::uint64_t run = 0; run < runs; ++run) {
    request.settings.seed = gmis_test::seed(500 + run);
    const RenderResult result = render(*scene, request, executor);
    CHECK(result.counters.rejected() == 0);
    const Image& image = result.image;
    std::vector<double> sums(12);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (std::size_t c = 0; c < 3; ++c) {
          const std::size_t quarter = (x >= image.width / 2 ? 1U : 0U) + (y >= image.height / 2 ? 2U : 0U);
          sums[quarter * 3 + c] += double(image.rgb[image.index(x, y) + c]) * 4 / (image.width * image.height);
        }
    for (std::size_t i = 0; i < 12; ++i) means[i].add(sums[i]);
  }
  return means;
}

/// The means of the expected picture, by quarters and channels.
std::vector<double> expected(const Picture& picture) {
  std::vector<double> means(12);
  constexpr int steps = 400;
  for (int row = 0; row < steps; ++row)
    for (int column = 0; column < steps; ++column) {
      const Rgb value = picture(-1 + 2 * (column + 0.5) / steps, 1 - 2 * (row + 0.5) / steps);
      const std::size_t quarter = (column >= steps / 2 ? 1U : 0U) + (row >= steps / 2 ? 2U : 0U);
      for (std::size_t c = 0; c < 3; ++c) means[quarter * 3 + c] += value[static_cast<int>(c)] * 4 / (steps * steps);
    }
  return means;
}

/// Both ways with each other, and each with the picture where that is known; four quarters of three
/// channels.
std::size_t comparison_count() {
  std::size_t count = 0;
  for (const auto& [name, picture] : pictures) count += 12 * (picture ? 3U : 1U);
  return count;
}
// A false alarm in a thousandth of the seeds, over all comparisons.
const double level = gmis::sidak_level(1e-3, comparison_count());

}  // namespace

TEST_CASE("every small scene shows what it must, by paths from the camera and from both ends") {
  const double quantile = gmis::student_t_quantile(1 - level / 2, runs - 1);
  std::size_t comparisons = 0;
  for (const auto& [name, picture] : pictures) {
    CAPTURE(name);
    const std::vector<gmis_test::Series> camera = measured(name, IntegratorChoice::pt),
                                         both = measured(name, IntegratorChoice::bpt);
    std::vector<double> known;
    if (picture) known = expected(picture);
    for (std::size_t i = 0; i < 12; ++i) {
      comparisons += known.empty() ? 1 : 3;
      CAPTURE(i, camera[i].mean(), camera[i].standard_error(), both[i].mean(), both[i].standard_error());
      const double both_errors = std::hypot(camera[i].standard_error(), both[i].standard_error());
      CHECK(std::abs(camera[i].mean() - both[i].mean()) <= quantile * both_errors + 1e-5 * (1 + both[i].mean()));
      // So that 6 % would show, 12 % under the sanitizers; the one pixel that has all of the light
      // has it all or not at all.
      if (name != "bright_pixel")
        CHECK(quantile * both_errors < 0.06 * std::sqrt(gmis_test::fewer) * (1 + both[i].mean()));
      if (known.empty()) continue;
      CAPTURE(known[i]);
      // Quadrature, polygons for circles, and the codes of a JPEG.
      const double slack = name == "imagemap_jpeg" ? 0.01 : 0.002;
      CHECK(std::abs(camera[i].mean() - known[i]) <= quantile * camera[i].standard_error() + slack);
      CHECK(std::abs(both[i].mean() - known[i]) <= quantile * both[i].standard_error() + slack);
    }
  }
  CHECK(comparisons == comparison_count());
}

TEST_CASE("there is a picture to expect for every small scene") {
  std::size_t scenes = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().stem().string();
    const fs::path ending = entry.path().extension();
    if ((ending != ".pbrt" && ending != ".gltf") || name == "view") continue;
    CAPTURE(name);
    CHECK(pictures.contains(name));
    ++scenes;
  }
  CHECK(scenes == pictures.size());
  CHECK(scenes >= 30);
}

TEST_CASE("the crop window of a film") {
  Diagnostics diagnostics;
  const auto scene = build_scene(read_scene(folder / "crop.pbrt", diagnostics), diagnostics);
  REQUIRE(scene->film_crop());
  CHECK(scene->film_crop()->lower == glm::ivec2(8, 0));
  CHECK(scene->film_crop()->upper == glm::ivec2(16, 4));
}

TEST_CASE("pixel bounds are the pixels that they say, for every side and whatever the rounding") {
  for (const int size : {10, 49, 100, 1280, 32768}) {
    Diagnostics diagnostics;
    const auto bounds_of = [&](int from, int to) {
      const std::string numbers = std::to_string(from) + " " + std::to_string(to);
      return build_scene(read_pbrt_text("Film \"rgb\" \"integer xresolution\" " + std::to_string(size) +
                                            " \"integer yresolution\" 3 \"integer pixelbounds\" [ " + numbers +
                                            " 1 2 ]\nWorldBegin\nShape \"sphere\"\n",
                                        "t.pbrt", ".", diagnostics),
                         diagnostics)
          ->film_crop()
          .value();
    };
    const int step = size < 200 ? 1 : size / 100;
    for (int from = 0; from + step < size; from += step) {
      const auto bounds = bounds_of(from, from + step);
      CAPTURE(size, from);
      CHECK(bounds.lower == glm::ivec2(from, 1));
      CHECK(bounds.upper == glm::ivec2(from + step, 2));
    }
  }
}
