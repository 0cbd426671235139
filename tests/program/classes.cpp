#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "gmis/transport/plan/class_costs.hpp"
#include "gmis/transport/replay/replay.hpp"
#include "program.hpp"
#include "support/build_scene.hpp"
#include "support/catch.hpp"
#include "support/image/formats.hpp"
#include "support/load_scene.hpp"
#include "support/pbrt/reader.hpp"
#include "support/render.hpp"
#include "support/seed.hpp"
#include "support/session.hpp"
#include "support/technique_sheet.hpp"

// The images of path classes. Contributions are classified anew from the events of replayed paths,
// by regular expressions over what happens from the light to the eye; only the names are those of
// the library.

using namespace program;
using namespace gmis::tools;
using Json = nlohmann::json;

namespace {

// Walls and a floor, a mirror, a ball of glass, and one that scatters without a diffuse part; an
// area light and a point light.
constexpr const char* scene_text = R"(
LookAt 0 0 -3.4  0 0 0  0 1 0
Camera "perspective" "float fov" [50]
Film "rgb" "integer xresolution" [20] "integer yresolution" [20]
WorldBegin
LightSource "point" "rgb I" [0.5 0.4 0.3] "point3 from" [0.5 0.9 -0.5]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [9 9 9]
  Material "diffuse" "rgb reflectance" [0 0 0]
  Shape "trianglemesh" "point3 P" [-0.9 1.19 -0.9  0.9 1.19 -0.9  0.9 1.19 0.9  -0.9 1.19 0.9]
    "integer indices" [0 1 2 0 2 3]
AttributeEnd
Material "diffuse" "rgb reflectance" [0.7 0.6 0.5]
Shape "trianglemesh" "point3 P" [-1.5 -1 -1.5  1.5 -1 -1.5  1.5 -1 1.5  -1.5 -1 1.5] "integer indices" [0 2 1 0 3 2]
Shape "trianglemesh" "point3 P" [-1.5 -1 1.5  1.5 -1 1.5  1.5 1.2 1.5  -1.5 1.2 1.5] "integer indices" [0 2 1 0 3 2]
Shape "trianglemesh" "point3 P" [-1.5 1.2 -1.5  1.5 1.2 -1.5  1.5 1.2 1.5  -1.5 1.2 1.5] "integer indices" [0 1 2 0 2 3]
Material "conductor" "float roughness" [0]
Shape "trianglemesh" "point3 P" [-1.5 -1 -1.5  -1.5 -1 1.5  -1.5 1.2 1.5  -1.5 1.2 -1.5] "integer indices" [0 2 1 0 3 2]
AttributeBegin
  Material "dielectric" "float eta" [1.5]
  Translate 0.6 -0.3 -0.4
  Shape "sphere" "float radius" [0.4]
AttributeEnd
AttributeBegin
  Material "conductor" "float roughness" [0.4]
  Translate -0.5 -0.4 0.3
  Shape "sphere" "float radius" [0.5]
AttributeEnd
)";
const glm::vec3 glossy_centre(-0.5F, -0.4F, 0.3F), camera_position(0.0F, 0.0F, -3.4F);
constexpr float glossy_radius = 0.5F;

std::unique_ptr<BuiltScene> make_scene() {
  Diagnostics diagnostics;
  return build_scene(read_pbrt_text(scene_text, "test", ".", diagnostics), diagnostics);
}

using Path = gmis::ReplayedPath<glm::vec3>;

/// D or G, by where the point is: rendering space has its origin at the camera, and may be turned
/// by nothing here.
char scattering_at(const glm::vec3& point) {
  const float distance = glm::length(point + camera_position - glossy_centre);
  return std::abs(distance - glossy_radius) < 1e-3F ? 'G' : 'D';
}

/// The events from the start of the subpath to vertex `last`, which itself scatters or (`ends`) is
/// the end and has none.
std::string events(const Path& path, std::size_t last, bool ends) {
  std::string reversed = ends ? "" : std::string(1, scattering_at(path.vertices[last].point.position));
  for (std::size_t at = last; path.vertices[at].depth > 1; at = path.vertices[at].parent) {
    const glm::vec3& point = path.vertices[path.vertices[at].parent].point.position;
    reversed += path.vertices[at].is_delta ? 'S' : scattering_at(point);
  }
  return {reversed.rbegin(), reversed.rend()};
}

std::string backward(const std::string& text) {
  return {text.rbegin(), text.rend()};
}

/// The one class whose paths have these events. G stands for every D of a path that has any.
std::string class_named(std::string path) {
  static const std::vector<std::pair<std::string, std::regex>> patterns = [] {
    std::vector<std::pair<std::string, std::regex>> all{{"LE", std::regex("LE")}, {"LS+E", std::regex("LS+E")}};
    for (const std::string x : {"D", "G"})
      for (const std::string light : {"", "S+"})
        for (const std::string eye : {"", "S+"}) {
          all.emplace_back("L" + light + x + eye + "E", std::regex("L" + light + x + eye + "E"));
          all.emplace_back("L" + light + x + x + "+" + eye + "E", std::regex("L" + light + x + x + "+" + eye + "E"));
          const std::string any = "[" + x + "S]*";
          all.emplace_back("L" + light + x + "S+" + x + eye + "E",
                           std::regex("L" + light + x + any + "S" + any + x + eye + "E"));
        }
    return all;
  }();
  if (path.find('G') != std::string::npos)
    for (char& event : path)
      if (event == 'D') event = 'G';
  std::string name;
  for (const auto& [candidate, pattern] : patterns)
    if (std::regex_match(path, pattern)) {
      INFO(path);
      REQUIRE(name.empty());
      name = candidate;
    }
  INFO(path);
  REQUIRE_FALSE(name.empty());
  return name;
}

Json statistics(const ScratchFolder& folder, const std::string& arguments) {
  const Outcome outcome = run(folder, arguments + " --quiet --out a.pfm --stats s.json");
  INFO(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  return Json::parse(text_of(folder / "s.json"));
}

/// The images of path classes, by the names of their files.
std::map<std::string, Image> class_images(const ScratchFolder& folder) {
  std::map<std::string, Image> images;
  for (const auto& entry : fs::directory_iterator(folder.path / "a_classes"))
    if (entry.path().stem() != "sheet") images[entry.path().stem().string()] = read_image(entry.path());
  return images;
}

double largest_difference(const Image& a, const Image& b) {
  REQUIRE(a.rgb.size() == b.rgb.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i)
    largest = std::max(largest, static_cast<double>(std::abs(a.rgb[i] - b.rgb[i])));
  return largest;
}

}  // namespace

TEST_CASE("Every contribution is of the class that a walk along its path finds") {
  const auto scene = make_scene();
  RenderRequest request;
  request.integrator = IntegratorChoice::vcm;
  request.class_pictures = true;
  request.settings.path_classes = gmis::PathClassSet::all();
  request.settings.max_depth = 7;
  request.settings.radius = 0.2;
  request.settings.seed = gmis_test::seed(12);
  request.settings.counts.connections = 3;
  request.budget.iterations = 1;
  ThreadedExecutor executor(1);
  const RenderResult result = render(*scene, request, executor);
  const glm::ivec2 resolution = scene->scene().camera().resolution();
  const auto pixels = static_cast<std::uint32_t>(resolution.x * resolution.y);

  gmis::Engine<SceneType> replayed(scene->scene(), request.settings);
  replayed.prepare_replay(executor, 1);
  std::vector<Path> trees;
  for (std::uint32_t tree = 0; tree < pixels; ++tree)
    trees.push_back(gmis::replay(replayed, gmis::PathKind::light, tree));

  std::map<std::string, std::vector<double>> sums;
  std::array<int, 5> counts{};
  int differences = 0;
  const auto check = [&](const Path& path) {
    for (const auto& made : path.contributions) {
      const auto& contribution = made.contribution;
      const bool is_camera = path.name.kind == gmis::PathKind::camera;
      std::string name = "L";
      if (made.light_vertex) {
        const Path& tree = trees[made.light_vertex->first];
        name += events(tree, static_cast<std::size_t>(made.light_vertex->second),
                       contribution.id.technique == gmis::Technique::merge);
      }
      if (is_camera)
        name += backward(events(path, made.vertex, contribution.id.technique == gmis::Technique::emitter_hit));
      else
        name += events(path, made.vertex, false);
      const std::string found = class_named(name + "E");
      differences += found != gmis::name_of(contribution.id.path_class);
      ++counts[static_cast<std::size_t>(contribution.id.technique)];
      std::vector<double>& sum = sums[found];
      sum.resize(3 * pixels);
      for (int c = 0; c < 3; ++c)
        sum[3 * contribution.pixel + static_cast<std::size_t>(c)] +=
            static_cast<double>(contribution.value[c] * contribution.weight);
    }
  };
  for (const Path& tree : trees) check(tree);
  for (std::uint32_t pixel = 0; pixel < pixels; ++pixel) check(gmis::replay(replayed, gmis::PathKind::camera, pixel));
  CHECK(differences == 0);
  CAPTURE(counts[0], counts[1], counts[2], counts[3], counts[4]);
  for (const int count : counts) CHECK(count > 20);

  // And so are the images.
  CHECK(sums.size() > 16);
  REQUIRE(sums.size() == result.classes.classes.size());
  for (const ClassImage& one : result.classes.classes) {
    const auto& sum = sums[std::string(gmis::name_of(one.path_class))];
    REQUIRE(sum.size() == one.image.rgb.size());
    for (std::size_t i = 0; i < sum.size(); ++i)
      REQUIRE(static_cast<double>(one.image.rgb[i]) == Approx(sum[i]).epsilon(1e-6).margin(1e-12));
  }
}

TEST_CASE("The images of all classes add up to the image, which is what it is without them") {
  const ScratchFolder folder;
  for (const char* integrator :
       {"pt", "bpt --connections 2", "vcm --connections 2 --radius 1", "auto --connections 2 --radius 1"}) {
    CAPTURE(integrator);
    const std::string common =
        "paper2 --size 20x14 --iterations 3 --max-depth 8 --crop 2,1,19,13 --integrator " + std::string(integrator);
    const Json json = statistics(folder, common + " --aov classes");
    const Image whole = read_image(folder / "a.pfm");
    Image sum(17, 12);
    double mean = 0, cost = json["classes"]["unattributed"]["cost"];
    const auto images = class_images(folder);
    REQUIRE(images.size() + 1 == json["classes"].size());
    for (const auto& [name, image] : images) {
      CAPTURE(name);
      REQUIRE(image.width == 17);
      REQUIRE(image.height == 12);
      for (std::size_t i = 0; i < sum.rgb.size(); ++i) sum.rgb[i] += image.rgb[i];
      const Json& entry = json["classes"][name];
      CHECK(entry["mean"] == Approx(mean_of(image)).epsilon(1e-6));
      CHECK(entry["contributions"] > 0);
      mean += entry["mean"].get<double>();
      cost += entry["cost"].get<double>();
    }
    CHECK(images.count("LDE") + images.count("LS+DE") > 0);
    CHECK(largest_difference(sum, whole) < 1e-5);
    CHECK(mean == Approx(json["estimate"]["mean"].get<double>()).epsilon(1e-5));
    CHECK(cost == Approx(1));
    CHECK((fs::exists(folder / "a_classes/sheet.png") || fs::exists(folder / "a_classes/sheet.pfm")));
    // By itself, auto measures what pays; with classes the plan alone decides.
    if (!std::string(integrator).starts_with("auto"))
      CHECK(statistics(folder, common)["image_hash"] == json["image_hash"]);
    fs::remove_all(folder.path / "a_classes");
  }
}

TEST_CASE("A class image is the image of a run for that class alone") {
  const ScratchFolder folder;
  std::ofstream(folder / "s.pbrt") << scene_text;
  const std::string common = "s.pbrt --size 16x16 --iterations 4 --max-depth 6 --connections paired --integrator bpt ";
  (void)statistics(folder, common + "--aov classes");
  const auto images = class_images(folder);
  REQUIRE(images.size() > 5);
  for (const char* name : {"LE", "LDE", "LS+DE", "LDD+E", "LDS+E"}) {
    CAPTURE(name);
    REQUIRE(images.count(name) == 1);
    (void)statistics(folder, common + "--effects " + name + "-only");
    CHECK(largest_difference(read_image(folder / "a.pfm"), images.at(name)) < 1e-6);
  }
}

TEST_CASE("Scenes with few classes have few images") {
  const ScratchFolder folder;
  const auto names_of = [&](const char* materials, const char* options) {
    std::ofstream(folder / "s.pbrt") << R"(
LookAt 0 0 -3  0 0 0  0 1 0
Camera "perspective" "float fov" [60]
Film "rgb" "integer xresolution" [12] "integer yresolution" [12]
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
)" << materials << "Shape \"sphere\" \"float radius\" [1]\n";
    (void)statistics(folder, "s.pbrt --iterations 2 --max-depth 6 --aov classes " + std::string(options));
    std::set<std::string> names;
    for (const auto& [name, image] : class_images(folder)) names.insert(name);
    return names;  // and no image of the run before
  };
  using Names = std::set<std::string>;
  CHECK(names_of("Material \"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]\n", "") == Names{"LE", "LDE"});
  CHECK(names_of("Material \"conductor\" \"float roughness\" [0]\n", "") == Names{"LE", "LS+E"});
  CHECK(names_of("Material \"conductor\" \"float roughness\" [0.3]\n", "--integrator pt") == Names{"LE", "LGE"});
  CHECK(names_of("Material \"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]\n", "--effects no-emission") == Names{"LDE"});
}

TEST_CASE("A picture by light holds that light alone, and all of them add up to the picture") {
  // Each light has a channel of its own, nothing else has a colour: what is in a wrong picture
  // shows.
  const auto lights = [](const std::string& third) {
    return R"(
LookAt 0 0 -3.4  0 0 0  0 1 0
Camera "perspective" "float fov" [50]
Film "rgb" "integer xresolution" [16] "integer yresolution" [16]
WorldBegin
)" + third +
           R"(
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [9 0 0]
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-0.3 0.9 -0.3 0.3 0.9 -0.3 0.3 0.9 0.3 -0.3 0.9 0.3]
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [0 9 0]
  Translate -0.6 0 0.2
  Shape "sphere" "float radius" [0.15]
AttributeEnd
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 2 1 0 3 2] "point3 P" [-1 -1 -1 1 -1 -1 1 -1 1 -1 -1 1]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -1 1 1 -1 1 1 1 1 -1 1 1]
AttributeBegin
  Material "dielectric" "float eta" [1.5]
  Translate 0.4 -0.5 -0.2
  Shape "sphere" "float radius" [0.35]
AttributeEnd
Material "conductor" "float roughness" [0.1] "rgb reflectance" [0.9 0.9 0.9]
Translate -0.4 -0.6 0.2
Shape "sphere" "float radius" [0.35]
)";
  };
  const std::string point = "LightSource \"point\" \"rgb I\" [0 0 1] \"point3 from\" [0.5 0.9 -0.5]";
  const std::string sky = "LightSource \"infinite\" \"rgb L\" [0 0 0.5]";
  using gmis::Technique;
  for (const std::string& third : {point, sky})
    for (const IntegratorChoice integrator : {IntegratorChoice::pt, IntegratorChoice::lt, IntegratorChoice::bpt,
                                              IntegratorChoice::vcm, IntegratorChoice::gmis}) {
      CAPTURE(third, name_of(integrator));
      const ScratchFolder folder;
      std::ofstream(folder / "s.pbrt") << lights(third);
      const LoadedScene loaded = load_scene(folder / "s.pbrt", {});
      Options options;
      options.integrator = integrator;
      options.light_layers = options.technique_layers = true;
      options.iterations = 4;
      options.seed = gmis_test::seed(31);
      options.split = integrator == IntegratorChoice::gmis ? SplitChoice::budgeted : SplitChoice::none;
      RenderRequest request = request_of(options, *loaded.built);
      request.candidates.clear();
      ThreadedExecutor executor(1);
      const RenderResult result = render(*loaded.built, request, executor);
      REQUIRE(result.by_light.size() == 3);
      for (std::size_t light = 0; light < 3; ++light) {
        const LightImage& one = result.by_light[light];
        CHECK(one.group == light);
        double sum = 0;
        for (std::size_t i = 0; i < one.image.rgb.size(); ++i) {
          const float expected = i % 3 == light ? result.image.rgb[i] : 0.0F;
          REQUIRE(one.image.rgb[i] == Approx(expected).epsilon(1e-5).margin(i % 3 == light ? 1e-7 : 0));
          sum += static_cast<double>(expected);
        }
        CHECK(sum > 0);
      }
      // All techniques of the integrator have made a part.
      std::set<Technique> techniques;
      for (const TechniqueImage& one : result.techniques) techniques.insert(one.id.technique);
      for (const Technique technique : gmis::all_techniques)
        CHECK(techniques.count(technique) == (request.settings.counts.has(technique) ? 1 : 0));
    }
}

TEST_CASE("The sheet has a cell for every class") {
  ClassImage one;
  one.path_class = gmis::class_with({1, false, false, false, false});
  one.image = Image(100, 50);
  for (float& value : one.image.rgb) value = 1.0F;
  const Image single = class_sheet({one});
  const Image six = class_sheet(std::vector<ClassImage>(6, one));
  CHECK(single.width == 108);
  CHECK(six.width == 4 + 5 * 104);
  CHECK(six.height - 4 == 2 * (single.height - 4));
  int white = 0;
  for (const float value : six.rgb) white += value == 1.0F;
  CHECK(white == 6 * 3 * 100 * 50);
}

TEST_CASE("Costs of classes are all the costs there are, by what contributions rest on") {
  std::array<gmis::ClassWork, gmis::path_class_count> classes{};
  using gmis::Technique;
  classes[2].add({Technique::next_event, 1, 2});
  classes[2].add({Technique::next_event, 1, 3});
  classes[2].add({Technique::splat, 3, 1});
  classes[5].add({Technique::emitter_hit, 0, 4});
  classes[5].add({Technique::merge, 3, 2});
  gmis::Counters work, light;
  work.rays = 140;
  light.rays = 40;
  work.shadow_rays = 20;
  light.shadow_rays = 5;
  work.connections = 8;
  work.connection_rays = 3;
  work.merges = 10;
  work.merge_queries = 2;
  work.photons_stored = 30;
  work.projections = light.projections = 50;
  constexpr gmis::OperationCosts by;
  const auto costs = gmis::costs_of_classes(classes, work, light);
  // Camera edges 1 + 2 and 3 + 1; light edges 2 and 2. Nothing came of the connections.
  const double first = 100.0 * 3 / 7 + 20 + by.shadow_ray * (12 + 5) + by.projection * 50;
  const double second = 100.0 * 4 / 7 + 20 + by.merge_query * 2 + by.merge * 10 + by.photon_stored * 30;
  CHECK(costs.classes[2] == Approx(first));
  CHECK(costs.classes[5] == Approx(second));
  CHECK(costs.unattributed == Approx(by.connection * 8 + by.shadow_ray * 3));
  CHECK(first + second + costs.unattributed == Approx(gmis::cost_of(work)));

  // With one connection: camera edges 4 and 4, light edges 3 and 2, half of the photons each.
  classes[2].add({Technique::connect, 2, 2});
  const auto connected = gmis::costs_of_classes(classes, work, light);
  CHECK(connected.classes[2] == Approx(100.0 / 2 + 40.0 * 3 / 5 + by.shadow_ray * (12 + 5 + 3) + by.connection * 8 +
                                       by.photon_stored * 15 + by.projection * 50));
  CHECK(connected.classes[5] ==
        Approx(100.0 / 2 + 40.0 * 2 / 5 + by.merge_query * 2 + by.merge * 10 + by.photon_stored * 15));
  CHECK(connected.unattributed == 0.0);
}

TEST_CASE("What --aov does not do: exit code 2 and one line") {
  const ScratchFolder folder;
  for (const auto& [arguments, part] : std::map<std::string, std::string>{
           {"cornell --aov depth", "use classes"}, {"cornell --aov albedo --integrator lt", "use classes"}}) {
    CAPTURE(arguments);
    const Outcome outcome = run(folder, arguments);
    CHECK(outcome.exit_code == 2);
    CHECK(line_count(outcome.err) == 1);
    CHECK(outcome.err.find(part) != std::string::npos);
  }
}
