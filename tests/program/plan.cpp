#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/transport/plan/effect_switches.hpp"
#include "program/block_statistics.hpp"
#include "support/build_scene.hpp"
#include "support/catch.hpp"
#include "support/choices.hpp"
#include "support/pbrt/reader.hpp"
#include "support/plan_text.hpp"
#include "support/seed.hpp"

// Renderings by plan: what is off is off to the last count, what is left out by its class is left
// out and nothing else, and no light is missing in scenes that tempt a rule.

using namespace gmis::tools;
using gmis::Counters;
using gmis::PathClass;
using gmis::PathClassSet;
using gmis::Technique;
using Spectrum = SceneSpectrum;

namespace {

std::unique_ptr<BuiltScene> scene_of(const std::string& world, const std::string& camera = "pinhole",
                                     bool is_dark = false) {
  Diagnostics diagnostics;
  const std::string text = "Include \"camera_" + camera + ".pbrt\"\nWorldBegin\n" + world;
  const SceneDescription description = read_pbrt_text(text, "test", GMIS_TEST_SCENE_FOLDER, diagnostics);
  for (const Diagnostic& diagnostic : diagnostics.all()) CHECK((is_dark || diagnostic.severity == Severity::note));
  return build_scene(description, diagnostics);
}

RenderRequest request_for(IntegratorChoice integrator, const BuiltScene& scene, int max_depth) {
  Options options;
  options.connections = 1;
  RenderRequest request;
  request.integrator = options.integrator = integrator;
  request.split = options.split = SplitChoice::none;
  request.expected_iterations = 64;
  request.settings.seed = gmis_test::seed(11);
  request.settings.max_depth = max_depth;
  request.settings.radius = 0.005 * scene.half_diagonal();
  set_counts(request, options, scene);
  return request;
}

RenderRequest with_effects(RenderRequest request, const std::string& list) {
  request.settings.path_classes = gmis::switched_effects(list).classes;
  REQUIRE_FALSE(request.settings.path_classes->is_empty());
  return request;
}

/// Auto by its rules alone, before anything is measured.
std::unique_ptr<SceneEngine> started(const BuiltScene& scene, RenderRequest request) {
  if (request.integrator == IntegratorChoice::automatic) {
    const gmis::Plan plan = plan_for_scene(scene, request.settings);
    request.settings.counts = counts_of(request.integrator, plan);
    request.candidates.clear();
  }
  return start(scene, request);
}

std::unique_ptr<SceneEngine> rendered(const BuiltScene& scene, const RenderRequest& request, int iterations) {
  ThreadedExecutor executor(1);
  auto source = started(scene, request);
  for (int i = 0; i < iterations; ++i) source->iterate(executor);
  return source;
}

bool are_equal(const SceneEngine& a, const SceneEngine& b) {
  const auto x = a.engine().frame(), y = b.engine().frame();
  return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(Spectrum)) == 0;
}

bool is_black(const SceneEngine& source) {
  const auto frame = source.engine().frame();
  return std::all_of(frame.begin(), frame.end(), [](const Spectrum& s) { return gmis::is_black(s); });
}

/// Checks that the counts are 0 exactly for the techniques that are off.
void check_counts(const Counters& counts, const gmis::Plan& plan) {
  CHECK((counts.light_subpaths > 0) == plan.traces_light());
  CHECK((counts.connections > 0) == plan.has(Technique::connect));
  CHECK((counts.splats > 0) == plan.has(Technique::splat));
  CHECK((counts.projections > 0) == plan.has(Technique::splat));
  CHECK((counts.merge_queries > 0) == plan.has(Technique::merge));
  CHECK((counts.grids_built > 0) == plan.has(Technique::merge));
  CHECK((counts.photons_stored > 0) == (plan.has(Technique::merge) || plan.has(Technique::connect)));
  if (!plan.has(Technique::merge)) CHECK(counts.merges == 0);
  if (!plan.has(Technique::next_event) && !plan.traces_light()) CHECK(counts.shadow_rays == 0);
}

const std::string specular_room = "Include \"objects_specular.pbrt\"\n";
const std::string rough_room = "Include \"objects_rough.pbrt\"\n";
const std::string triangle_light = "Include \"light_triangle.pbrt\"\n";
const std::string point_light = "Include \"light_point.pbrt\"\n";
const std::string mirrors_alone =
    "AttributeBegin Material \"mirror\" \"rgb reflectance\" [ .9 .85 .8 ] Translate -.6 .6 .5 Shape \"sphere\" \"float "
    "radius\" .6 AttributeEnd\nAttributeBegin Material \"dielectric\" \"float eta\" 1.5 Translate .7 .5 -.4 Shape "
    "\"sphere\" \"float radius\" .5 AttributeEnd\n";
const std::string smooth_mesh =
    "Include \"stage.pbrt\"\nMaterial \"diffuse\" \"rgb reflectance\" [ .6 .6 .5 ]\nTranslate 0 .6 0\nShape "
    "\"trianglemesh\" \"integer indices\" [ 0 2 4  2 1 4  1 3 4  3 0 4  2 0 5  1 2 5  3 1 5  0 3 5 ] \"point3 P\" [ .6 "
    "0 0 "
    " -.6 0 0  0 .6 0  0 -.6 0  0 0 .6  0 0 -.6 ] \"normal N\" [ 1 0 0  -1 0 0  0 1 0  0 -1 0  0 0 1  0 0 -1 ]\n";

}  // namespace

TEST_CASE("with all light-side techniques off, auto is pt bit by bit") {
  struct Case {
    std::string name, world;
    int max_depth;
  };
  for (const Case& c : {Case{"direct light", rough_room + triangle_light, 2},
                        Case{"direct light among mirrors and glass", specular_room + point_light, 2},
                        Case{"nothing scatters", mirrors_alone + triangle_light, 8}, Case{"no light", rough_room, 8}}) {
    CAPTURE(c.name);
    const auto scene = scene_of(c.world, "pinhole", c.name == "no light");
    ThreadedExecutor executor(1);
    const auto by_plan = start(*scene, request_for(IntegratorChoice::automatic, *scene, c.max_depth));
    for (int i = 0; i < 3; ++i) by_plan->iterate(executor);
    const auto pt = rendered(*scene, request_for(IntegratorChoice::pt, *scene, c.max_depth), 3);
    const gmis::Plan plan =
        plan_for_scene(*scene, request_for(IntegratorChoice::automatic, *scene, c.max_depth).settings);
    CHECK_FALSE(plan.traces_light());
    CHECK(are_equal(*by_plan, *pt));
    CHECK(is_black(*pt) == (c.name == "no light"));
    // Without a light pt traces camera paths all the same; a plan without techniques traces
    // nothing.
    CHECK(by_plan->counters().rays == (c.name == "no light" ? 0 : pt->counters().rays));
    CHECK(by_plan->engine().photon_bytes() == 0);
    check_counts(by_plan->counters(), plan);
  }
}

TEST_CASE("what is off counts exactly 0, in every plan that occurs") {
  struct Case {
    std::string world, effects;
    bool connects, merges, splats;
  };
  for (const Case& c : {Case{smooth_mesh + triangle_light, "", true, false, true},
                        Case{specular_room + triangle_light, "", true, true, true},
                        Case{specular_room + triangle_light, "direct-only", false, false, false},
                        Case{specular_room + triangle_light, "emission-only", false, false, false},
                        Case{specular_room + triangle_light, "LDE-only,LS+DE-only", false, false, true},
                        Case{specular_room + point_light, "direct-only,LS+DE-only,LS+DS+E-only", false, true, true},
                        Case{specular_room + point_light, "no-mirrored", true, false, true}}) {
    CAPTURE(c.effects);
    const auto scene = scene_of(c.world);
    RenderRequest request = request_for(IntegratorChoice::automatic, *scene, 8);
    if (!c.effects.empty()) request = with_effects(request, c.effects);
    const gmis::Plan plan = plan_for_scene(*scene, request.settings);
    CHECK(plan.has(Technique::connect) == c.connects);
    CHECK(plan.has(Technique::merge) == c.merges);
    CHECK(plan.has(Technique::splat) == c.splats);
    check_counts(rendered(*scene, request, 2)->counters(), plan);
  }
}

TEST_CASE("an engine that classifies all paths makes the same bits as one that does not") {
  const auto scene = scene_of(specular_room + triangle_light);
  for (const IntegratorChoice integrator :
       {IntegratorChoice::pt, IntegratorChoice::bpt, IntegratorChoice::vcm, IntegratorChoice::gmis}) {
    CAPTURE(name_of(integrator));  // gmis without splitting
    RenderRequest request = request_for(integrator, *scene, 6);
    request.techniques = true;
    const auto plain = rendered(*scene, request, 2);
    request.settings.path_classes = PathClassSet::all();
    const auto classified = rendered(*scene, request, 2);
    CHECK(are_equal(*plain, *classified));
    CHECK(plain->counters().rays == classified->counters().rays);
    CHECK(plain->counters().shadow_rays == classified->counters().shadow_rays);
    std::size_t with_class = 0, without = 0;
    const PathClassSet occurring = plan_for_scene(*scene, request.settings).occurring;
    std::size_t unexpected = 0, wrong_depth = 0;
    classified->engine().for_each_contribution([&](const auto& contribution) {
      const gmis::TechniqueId& id = contribution.id;
      ++with_class;
      unexpected += occurring.contains(id.path_class) ? 0 : 1;
      // As many events as the path has vertices between its ends.
      const int edges = id.s + id.t - (id.technique == Technique::merge ? 2 : 1);
      const auto features = gmis::features_of(id.path_class);
      const bool has_specular = features.specular_at_light || features.specular_between || features.specular_at_camera;
      const int least = gmis::least_depth(id.path_class);
      wrong_depth += edges < least || (edges > least && !has_specular && features.scatterings < 2) ? 1 : 0;
    });
    CHECK(wrong_depth == 0);
    plain->engine().for_each_contribution(
        [&](const auto& contribution) { without += contribution.id.path_class == PathClass::unclassified ? 1 : 0; });
    CHECK(with_class > 0);
    CHECK(with_class == without);
    CHECK(unexpected == 0);
  }
}

TEST_CASE("with effects switched off the image is the sum of the class images that are left, and costs less") {
  const auto scene = scene_of(specular_room + rough_room + triangle_light);
  // Of each list with vcm, over all iterations: so few paths do not find every class each time.
  std::map<std::string, double> brightest_of;
  for (const IntegratorChoice integrator : {IntegratorChoice::pt, IntegratorChoice::vcm})
    for (std::uint64_t seed = 11; seed <= 16; ++seed) {
      RenderRequest request = request_for(integrator, *scene, 6);
      request.settings.seed = gmis_test::seed(seed);
      request.techniques = true;
      if (!request.settings.path_classes) request.settings.path_classes = PathClassSet::all();
      request.settings.counts.connects_paired_tree = true;  // drawn from fewer vertices, others would be drawn
      const auto whole = rendered(*scene, request, 1);
      std::map<PathClass, std::vector<glm::dvec3>> images;
      whole->engine().for_each_contribution([&](const auto& contribution) {
        auto& image = images[contribution.id.path_class];
        image.resize(whole->engine().frame().size(), glm::dvec3(0));
        image[contribution.pixel] += glm::dvec3(contribution.value * contribution.weight);
      });
      REQUIRE(images.size() > 5);
      for (const std::string list : {"no-caustics", "direct-only", "indirect-only", "emission-only", "no-specular",
                                     "no-mirrored", "no-glossy", "caustics-only", "LS+DE-only"}) {
        CAPTURE(name_of(integrator), list);
        const RenderRequest switched = with_effects(request, list);
        const auto part = rendered(*scene, switched, 1);
        double worst = 0, brightest = 0;
        for (std::size_t i = 0; i < part->engine().frame().size(); ++i) {
          glm::dvec3 sum(0);
          for (const auto& [path_class, image] : images)
            if (switched.settings.path_classes->contains(path_class)) sum += image[i];
          const glm::dvec3 difference = glm::abs(sum - glm::dvec3(part->engine().frame()[i]));
          worst = std::max(worst, gmis::max_channel(glm::dvec3(difference / (1e-3 + sum))));
          brightest = std::max(brightest, gmis::max_channel(sum));
        }
        CHECK(worst < 1e-5);  // sums of some hundred floats
        const Counters &less = part->counters(), &all = whole->counters();
        // What was left out may be what so few paths did not find.
        CHECK(less.contributions <= all.contributions);
        // A camera subpath goes on while it may still meet a light: of caustics, say. Few of pt's
        // do.
        const bool has_light_side = integrator == IntegratorChoice::vcm;
        if (has_light_side) brightest_of[list] = std::max(brightest_of[list], brightest);
        CHECK((has_light_side ? less.rays < all.rays : less.rays <= all.rays));
        CHECK((has_light_side ? less.shadow_rays < all.shadow_rays : less.shadow_rays <= all.shadow_rays));
      }
    }
  for (const auto& [list, brightest] : brightest_of) {
    CAPTURE(list);
    CHECK(brightest > 0);
  }
}

namespace {

/// A scene that tempts a rule: with its depth, whether light is to be traced and merged, and
/// whether path tracing lacks some of its light, so that this test is seen to notice.
struct Temptation {
  const char* name;
  std::string world;
  const char* camera;
  int max_depth;
  const char* effects;
  bool traces_light, merges;
  bool pt_lacks;
};

std::vector<Temptation> temptations() {
  const std::string stage = "Include \"stage.pbrt\"\n";
  const std::string spot_at_mirror_behind =
      "LightSource \"spot\" \"rgb I\" [ 60 55 50 ] \"point3 from\" [ 0 1.5 -5.2 ] \"point3 to\" [ 0 1.4 -7 ] \"float "
      "coneangle\" 30 \"float conedeltaangle\" 10\nMaterial \"mirror\" \"rgb reflectance\" [ .9 .9 .9 ]\nShape "
      "\"bilinearmesh\" \"point3 P\" [ -2 0 -7  2 0 -7  -2 3 -7  2 3 -7 ]\n";
  const std::string point_in_glass =
      "LightSource \"point\" \"rgb I\" [ 7 6.5 6 ] \"point3 from\" [ .3 1.6 -.6 ]\nMaterial \"dielectric\" \"float "
      "eta\" "
      "1.5\nTranslate .3 1.6 -.6\nShape \"sphere\" \"float radius\" .3\n";
  const std::string sky_through_glass =
      "Include \"light_environment.pbrt\"\nMaterial \"dielectric\" \"float eta\" 1.5\nTranslate 0 .8 0\nShape "
      "\"sphere\" "
      "\"float radius\" .8\n";
  const auto metal = [&](const char* roughness) {
    return stage + point_light + "Material \"conductor\" \"bool remaproughness\" false \"float roughness\" " +
           roughness + "\nTranslate 0 .7 0\nShape \"sphere\" \"float radius\" .7\n";
  };
  return {{"caustic of a mirror behind the camera", stage + spot_at_mirror_behind, "pinhole", 3, "", true, false, true},
          {"the same in several bounces", stage + spot_at_mirror_behind, "pinhole", 6, "", true, true, true},
          {"a light in glass alone", stage + point_in_glass, "pinhole", 3, "", true, false, true},
          {"a light in glass alone, no mirrors looked into", stage + point_in_glass, "pinhole", 6, "no-mirrored", true,
           false, true},
          {"the sky through glass", stage + sky_through_glass, "pinhole", 3, "", true, false, false},
          {"metal of roughness 1e-4", metal("1e-4"), "pinhole", 3, "", true, false, true},
          {"a lens", specular_room + point_light, "lens", 3, "", true, false, false},
          {"a mesh shaded as smooth", smooth_mesh + point_light, "pinhole", 5, "", true, false, false},
          {"rough metal", metal(".4"), "pinhole", 5, "", true, false, false},
          {"direct light among everything", specular_room + rough_room + point_light + triangle_light, "pinhole", 2, "",
           false, false, false},
          {"caustics alone, seen in a ball as well",
           stage + spot_at_mirror_behind + "Translate 0 .6 0\nShape \"sphere\" \"float radius\" .6\n", "pinhole", 4,
           "LS+DE-only,LS+DS+E-only", true, true, true}};
}

struct Estimates {
  gmis_test::BlockStatistics blocks, whole;
};

Estimates estimates_of(const BuiltScene& scene, RenderRequest request, int iterations) {
  const glm::ivec2 resolution = scene.scene().camera().resolution();
  Estimates result{gmis_test::BlockStatistics(resolution, 12), gmis_test::BlockStatistics(resolution, 24)};
  ThreadedExecutor executor(1);
  const auto source = started(scene, request);
  for (int i = 0; i < iterations; ++i) {
    source->iterate(executor);
    result.blocks.add(source->engine().frame());
    result.whole.add(source->engine().frame());
  }
  return result;
}

/// The smallest one-sided p-value of `part` being as bright as `all` anywhere, and how many there
/// are.
struct Deficit {
  double p_value = 1;
  std::size_t count = 0;
  double relative_error = 0;  ///< of the whole picture
};

Deficit deficit_of(const Estimates& part, const Estimates& all) {
  Deficit result;
  const double mean = all.whole.image_mean();
  const auto compare = [&](const gmis_test::BlockStatistics& a, const gmis_test::BlockStatistics& b) {
    for (std::size_t i = 0; i < a.count(); ++i) {
      const double error = std::hypot(a.standard_error(i), b.standard_error(i));
      // Merging's bias is below three radii over half the diagonal: the pairwise test's bound.
      const double missing = b.mean(i) - a.mean(i) - 3 * 0.005 * b.mean(i);
      if (b.mean(i) < 0.05 * mean || !(error > 0)) continue;
      ++result.count;
      if (missing > 0)
        result.p_value = std::min(result.p_value, 0.5 * gmis::student_t_p_value(missing / error, a.frames() - 1.0));
    }
  };
  compare(part.blocks, all.blocks);
  compare(part.whole, all.whole);
  result.relative_error = std::hypot(part.whole.standard_error(0), all.whole.standard_error(0)) / mean;
  return result;
}

}  // namespace

// One-sided t for the means of 12×12 blocks and of the whole picture, per channel, at the Šidák
// level of a false-alarm rate of 1e-3 for the family; fixed seeds.
TEST_CASE("in scenes that tempt a rule no light is missing") {
  constexpr int iterations = 96;
  const auto scenes = temptations();
  for (const Temptation& t : scenes) {
    CAPTURE(t.name);
    const auto scene = scene_of(t.world, t.camera);
    const auto request = [&](IntegratorChoice integrator) {
      RenderRequest r = request_for(integrator, *scene, t.max_depth);
      return *t.effects == '\0' ? r : with_effects(r, t.effects);
    };
    const gmis::Plan plan = plan_for_scene(*scene, request(IntegratorChoice::automatic).settings);
    CHECK(plan.traces_light() == t.traces_light);
    CHECK(plan.has(Technique::merge) == t.merges);
    CHECK(lacking_classes(plan, counts_of(IntegratorChoice::automatic, plan)).is_empty());

    RenderRequest all_on = request(IntegratorChoice::vcm);
    all_on.settings.seed = gmis_test::seed(12);
    const Estimates all = estimates_of(*scene, all_on, iterations);
    const Deficit by_plan = deficit_of(estimates_of(*scene, request(IntegratorChoice::automatic), iterations), all);
    const double level = gmis::sidak_level(1e-3, scenes.size() * by_plan.count);
    CAPTURE(by_plan.p_value, by_plan.relative_error, level);
    CHECK(by_plan.count > 3);
    CHECK(by_plan.relative_error < 0.05);
    CHECK(by_plan.p_value > level);
    if (!t.pt_lacks) continue;
    const Deficit by_pt = deficit_of(estimates_of(*scene, request(IntegratorChoice::pt), iterations), all);
    CAPTURE(by_pt.p_value);
    CHECK(by_pt.p_value < level);
  }
}
