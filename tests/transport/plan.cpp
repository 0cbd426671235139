#include "gmis/transport/plan/plan.hpp"

#include <array>
#include <string>
#include <vector>

#include "gmis/scene.hpp"
#include "gmis/transport/plan/effect_switches.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/ways.hpp"

// The rules, over all scenes that effects can describe, against paths enumerated event by event:
// whatever path any of the five techniques makes, one that the plan has on makes too.

namespace {

using gmis::Effects;
using gmis::PathClassSet;
using gmis::PathEvent;
using gmis::Plan;
using gmis::PlanRule;
using gmis::Technique;

constexpr Technique all_techniques[] = {Technique::emitter_hit, Technique::next_event, Technique::connect,
                                        Technique::splat, Technique::merge};

using Events = std::vector<PathEvent>;  // from the light

std::vector<Events> all_events(std::size_t longest) {
  std::vector<Events> result{{}};
  for (std::size_t begin = 0, length = 0; length < longest; ++length) {
    const std::size_t end = result.size();
    for (std::size_t i = begin; i < end; ++i)
      for (const PathEvent event : {PathEvent::diffuse, PathEvent::glossy, PathEvent::specular}) {
        Events next = result[i];
        next.push_back(event);
        result.push_back(next);
      }
    begin = end;
  }
  return result;
}

bool scatters(PathEvent event) {
  return event != PathEvent::specular;
}

/// From what a technique does: it joins two points that both scatter, or ends at one. With a local
/// count, merging joins at a point that the light reaches from a narrow lobe; in `effects` either
/// all glossy surfaces have one or none.
bool makes(Technique technique, const Events& events, bool is_delta_light, bool local_merges, const Effects& effects) {
  const auto is_narrow = [&](PathEvent event) {
    return event == PathEvent::specular || (event == PathEvent::glossy && effects.least_roughness < 0.25);
  };
  bool has_scattering = false, has_pair = false, has_photon = false;
  for (std::size_t i = 0; i < events.size(); ++i) {
    has_scattering = has_scattering || scatters(events[i]);
    has_photon = has_photon || (i > 0 && is_narrow(events[i - 1]) && scatters(events[i]));
    has_pair = has_pair || (i > 0 && scatters(events[i - 1]) && scatters(events[i]));
  }
  switch (technique) {
    case Technique::emitter_hit:
      return !is_delta_light;
    case Technique::next_event:
      return !events.empty() && scatters(events.front());
    case Technique::splat:
      return !events.empty() && scatters(events.back());
    case Technique::connect:
      return has_pair;
    case Technique::merge:
      return local_merges ? has_photon : has_scattering;
  }
  return false;
}

gmis::PathClass class_of_events(const Events& events) {
  gmis::HalfPath half;
  for (const PathEvent event : events) half = half.then(event);
  return class_of(half, gmis::HalfPath());
}

/// Whether surfaces with these effects do that.
bool can_happen(PathEvent event, const Effects& effects) {
  switch (event) {
    case PathEvent::diffuse:
      return effects.diffuse;
    case PathEvent::glossy:
      return effects.purely_glossy;
    case PathEvent::specular:
      return effects.specular_reflection || effects.specular_transmission;
  }
  return false;
}

/// Every combination of the effects that decide anything.
std::vector<Effects> all_effects() {
  std::vector<Effects> result;
  for (unsigned bits = 0; bits < 256; ++bits) {
    Effects effects;
    effects.diffuse = (bits & 1) != 0;
    effects.purely_glossy = (bits & 2) != 0;
    if (effects.purely_glossy || (bits & 4) != 0) effects.add_glossy_lobe((bits & 8) != 0 ? 0.01 : 0.6);
    if (effects.glossy && !effects.purely_glossy) effects.diffuse = true;
    (bits % 3 == 0 ? effects.specular_reflection : effects.specular_transmission) = (bits & 16) != 0;
    (bits % 5 == 0 ? effects.environment_lights : effects.area_lights) = (bits & 32) != 0;
    (bits % 7 == 0   ? effects.point_lights
     : bits % 7 == 1 ? effects.spot_lights
                     : effects.directional_lights) = (bits & 64) != 0;
    effects.thin_lens = effects.shading_normals = (bits & 128) != 0;
    result.push_back(effects);
  }
  return result;
}

std::vector<PathClassSet> wanted_sets() {
  std::vector<PathClassSet> result{PathClassSet::all(), {}};
  for (const gmis::NamedEffect& effect : gmis::named_effects) {
    result.push_back(effect.classes);
    result.push_back(PathClassSet::all() - effect.classes);
  }
  for (std::size_t i = 0; i < gmis::path_class_count; ++i) {
    PathClassSet single;
    single.add(static_cast<gmis::PathClass>(i));
    result.push_back(single);
  }
  return result;
}

Effects diffuse_room() {
  Effects effects;
  effects.diffuse = effects.area_lights = true;
  return effects;
}

void check(const Plan& plan, Technique technique, bool is_on, PlanRule rule) {
  CAPTURE(static_cast<int>(technique), std::string(sentence_of(plan[technique].rule)));
  CHECK(plan.has(technique) == is_on);
  CHECK(plan[technique].rule == rule);
}

}  // namespace

TEST_CASE("no plan loses a path that all techniques together make") {
  constexpr int deepest = 6;
  const auto paths = all_events(deepest - 1);
  std::size_t plans = 0, lost = 0, wrong_classes = 0;
  for (const bool local_merges : {false, true})
    for (const Effects& effects : all_effects()) {
      // What the paths of this scene are made by, once for all plans.
      struct Path {
        int depth;
        gmis::PathClass path_class;
        std::array<bool, 5> made;
      };
      std::vector<Path> occurring;
      for (const Events& events : paths) {
        bool can = true;
        for (const PathEvent event : events) can = can && can_happen(event, effects);
        if (!can) continue;
        for (const bool is_delta : {false, true}) {
          if (!(is_delta ? effects.has_delta_lights() && !events.empty() : effects.has_extended_lights())) continue;
          Path path{static_cast<int>(events.size()) + 1, class_of_events(events), {}};
          bool scatters_at_all = false;
          for (const PathEvent event : events) scatters_at_all = scatters_at_all || scatters(event);
          if (is_delta && !scatters_at_all) continue;  // carries no light: two delta functions that never meet
          for (const Technique technique : all_techniques)
            path.made[static_cast<std::size_t>(technique)] = makes(technique, events, is_delta, local_merges, effects);
          occurring.push_back(path);
        }
      }
      for (int depth = 1; depth <= deepest; ++depth) {
        PathClassSet classes;
        for (const Path& path : occurring)
          if (path.depth <= depth) classes.add(path.path_class);
        for (const PathClassSet& wanted : wanted_sets()) {
          const Plan plan = gmis::plan_for(effects, depth, wanted, local_merges);
          ++plans;
          wrong_classes += plan.occurring == classes && plan.classes == (classes & wanted) ? 0 : 1;
          for (const Path& path : occurring) {
            if (path.depth > depth || !wanted.contains(path.path_class)) continue;
            bool by_all = false, by_plan = false;
            for (const Technique technique : all_techniques) {
              by_all = by_all || path.made[static_cast<std::size_t>(technique)];
              by_plan = by_plan || (plan.has(technique) && path.made[static_cast<std::size_t>(technique)]);
              wrong_classes +=
                  path.made[static_cast<std::size_t>(technique)] && !plan[technique].makes.contains(path.path_class);
            }
            lost += by_all && !by_plan ? 1 : 0;
          }
        }
      }
    }
  CHECK(plans == 2 * 256 * deepest * wanted_sets().size());
  CHECK(wrong_classes == 0);
  CHECK(lost == 0);
}

TEST_CASE("a technique that makes paths which are rendered is left out by two rules alone") {
  for (const Effects& effects : all_effects())
    for (const int depth : {1, 2, 3, 4, 16}) {
      const Plan plan = gmis::plan_for(effects, depth);
      for (const Technique technique : all_techniques) {
        const auto& decision = plan[technique];
        const bool makes_something = decision.makes.intersects(plan.classes);
        if (decision.is_on != makes_something) {
          INFO(sentence_of(decision.rule));
          CHECK((decision.rule == PlanRule::direct_light_only || decision.rule == PlanRule::nothing_to_merge ||
                 decision.rule == PlanRule::goes_along));
        }
      }
    }
}

TEST_CASE(
    "With a local count merging is off where no lobe is narrow, and makes no light that comes straight from a light") {
  Effects effects = diffuse_room();
  effects.add_glossy_lobe(0.5);
  CHECK(gmis::plan_for(effects, 16, PathClassSet::all(), true)[Technique::merge].makes.is_empty());
  check(gmis::plan_for(effects, 16, PathClassSet::all(), true), Technique::merge, false, PlanRule::makes_nothing);
  effects.specular_transmission = true;
  const Plan plan = gmis::plan_for(effects, 16, PathClassSet::all(), true);
  CHECK(plan.has(Technique::merge));
  const gmis::PathClass direct = class_of_events({PathEvent::diffuse}),
                        mirrored = class_of_events({PathEvent::diffuse, PathEvent::specular}),
                        caustic = class_of_events({PathEvent::specular, PathEvent::diffuse});
  CHECK_FALSE(plan[Technique::merge].makes.contains(direct));
  CHECK_FALSE(plan[Technique::merge].makes.contains(mirrored));
  CHECK(plan[Technique::merge].makes.contains(caustic));
  CHECK(gmis::plan_for(effects, 16)[Technique::merge].makes.contains(mirrored));
}

TEST_CASE("rule: no light") {
  Effects effects = diffuse_room();
  effects.area_lights = false;
  for (const Technique technique : all_techniques)
    check(gmis::plan_for(effects, 16), technique, false, PlanRule::no_light);
}

TEST_CASE("rule: nothing scatters") {
  Effects effects;
  effects.specular_reflection = effects.area_lights = true;
  const Plan plan = gmis::plan_for(effects, 16);
  check(plan, Technique::emitter_hit, true, PlanRule::needed);
  for (const Technique technique : {Technique::next_event, Technique::connect, Technique::splat, Technique::merge})
    check(plan, technique, false, PlanRule::no_scattering);
  CHECK_FALSE(plan.traces_light());
  effects.add_glossy_lobe(0.01);
  effects.purely_glossy = true;
  CHECK(gmis::plan_for(effects, 16).has(Technique::merge));
}

TEST_CASE("rule: no light to hit") {
  Effects effects = diffuse_room();
  effects.area_lights = false;
  effects.spot_lights = true;
  check(gmis::plan_for(effects, 16), Technique::emitter_hit, false, PlanRule::no_light_to_hit);
  effects.environment_lights = true;
  check(gmis::plan_for(effects, 16), Technique::emitter_hit, true, PlanRule::needed);
}

TEST_CASE("rule: it makes nothing") {
  check(gmis::plan_for(diffuse_room(), 2), Technique::connect, false, PlanRule::makes_nothing);
  check(gmis::plan_for(diffuse_room(), 3), Technique::connect, true, PlanRule::helps);
  check(gmis::plan_for(diffuse_room(), 1), Technique::next_event, false, PlanRule::makes_nothing);
  // Caustics are beyond next event.
  Effects effects = diffuse_room();
  effects.specular_transmission = true;
  check(gmis::plan_for(effects, 16, gmis::switched_effects("caustics-only").classes), Technique::next_event, false,
        PlanRule::makes_nothing);
}

TEST_CASE("rule: direct light only") {
  Effects effects = diffuse_room();
  effects.specular_reflection = effects.point_lights = true;
  const Plan direct = gmis::plan_for(effects, 2);
  check(direct, Technique::splat, false, PlanRule::direct_light_only);
  check(direct, Technique::merge, false, PlanRule::direct_light_only);
  CHECK_FALSE(direct.traces_light());
  CHECK_FALSE(direct.leaves_out_classes());
  // A caustic of the point light has three edges.
  CHECK(gmis::plan_for(effects, 3).has(Technique::splat));
  const Plan switched = gmis::plan_for(effects, 16, gmis::switched_effects("direct-only").classes);
  CHECK_FALSE(switched.traces_light());
  CHECK(switched.leaves_out_classes());
}

TEST_CASE("rule: nothing to merge") {
  check(gmis::plan_for(diffuse_room(), 16), Technique::merge, false, PlanRule::nothing_to_merge);
  Effects effects = diffuse_room();
  effects.point_lights = effects.specular_reflection = true;
  // Caustics of the point light seen in the mirror are made by nothing else.
  check(gmis::plan_for(effects, 16), Technique::merge, true, PlanRule::needed);
  check(gmis::plan_for(effects, 3), Technique::merge, false, PlanRule::nothing_to_merge);
  check(gmis::plan_for(effects, 16, gmis::switched_effects("no-mirrored").classes), Technique::merge, false,
        PlanRule::nothing_to_merge);
  // Lobes that are nearly specular.
  Effects glossy = diffuse_room();
  glossy.add_glossy_lobe(gmis::narrow_roughness);
  check(gmis::plan_for(glossy, 16), Technique::merge, false, PlanRule::nothing_to_merge);
  glossy.add_glossy_lobe(1e-4);
  check(gmis::plan_for(glossy, 16), Technique::merge, true, PlanRule::helps);
}

TEST_CASE("on: splats go along where light is traced anyway") {
  Effects effects = diffuse_room();
  effects.specular_reflection = true;
  const Plan plan = gmis::plan_for(effects, 16, gmis::switched_effects("LS+DS+E-only").classes);
  check(plan, Technique::merge, true, PlanRule::helps);
  check(plan, Technique::splat, true, PlanRule::goes_along);
}

TEST_CASE("a scene that does not say what it has is taken to have everything") {
  const Plan plan = gmis::plan_for(Effects::everything(), 16);
  CHECK(plan.occurring == PathClassSet::all());
  for (const Technique technique : all_techniques) CHECK(plan.has(technique));
  static_assert(gmis::plan_for(Effects::everything(), 16).traces_light());
}

namespace {

using gmis::scene::Material;
using Color = glm::dvec3;

/// Materials with lobes of every kind that a surface may have, alone and as parts of others.
std::vector<std::pair<std::string, Material<float>>> surfaces() {
  using gmis::scene::Texture;
  const Color eta(0.2, 0.9, 1.2), k(3.2, 2.6, 2.3), grey(0.5);
  const auto half = Texture<float>::constant(grey);
  const auto diffuse = gmis::scene::make_diffuse(grey);
  const auto metal = gmis::scene::make_conductor(eta, k, 0.1);
  gmis::scene::MaterialTextures<float> cut, rough;
  cut.opacity = half;
  rough.roughness =
      Texture<float>::checkerboard(Texture<float>::constant(Color(0.04)), Texture<float>::constant(Color(0.8)));
  return {{"sheet", gmis::scene::make_diffuse_transmission(grey, grey)},
          {"sheet without reflection", gmis::scene::make_diffuse_transmission(Color(0), grey)},
          {"rough coat over rough metal", gmis::scene::make_coated_conductor(eta, k, 0.2, 1.5, 0.3)},
          {"smooth coat over rough metal", gmis::scene::make_coated_conductor(eta, k, 0.2, 1.5, 0)},
          {"smooth coat over smooth metal", gmis::scene::make_coated_conductor(eta, k, 0, 1.5, 0)},
          {"coat", gmis::scene::make_coated_diffuse(grey, 1.5, 0)},
          {"diffuse or a metal", gmis::scene::make_mix(diffuse, metal, half)},
          {"glass or a mirror",
           gmis::scene::make_mix(gmis::scene::make_dielectric(1.5), gmis::scene::make_mirror(grey), half)},
          {"a sheet or rough glass", gmis::scene::make_mix(gmis::scene::make_diffuse_transmission(grey, grey),
                                                           gmis::scene::make_dielectric(1.5, 0.3), half)},
          {"half of it there", with_textures(metal, cut)},
          {"glass with holes", with_textures(gmis::scene::make_dielectric(1.5), cut)},
          {"metal rough here and there", with_textures(metal, rough)},
          {"glass that absorbs", with_absorption(gmis::scene::make_dielectric(1.5), grey)}};
}

}  // namespace

TEST_CASE("plans and classes know the lobes of all materials: no path is of a class that the scene is said to lack") {
  for (const auto& [name, material] : surfaces())
    for (const bool with_floor : {false, true}) {
      CAPTURE(name, with_floor);
      gmis::scene::SceneBuilder<float> builder;
      const auto number = builder.add_material(material);
      builder.add_sphere({0, 0, 5}, 1, number);
      builder.add_sphere({1.4, 0.3, 6}, 0.8, number);
      if (with_floor) {
        const std::vector<Color> corners{{-9, -1, 0}, {9, -1, 0}, {9, -1, 20}, {-9, -1, 20}};
        builder.add_mesh({corners, std::vector<std::array<int, 3>>{{0, 2, 1}, {0, 3, 2}}},
                         builder.add_material(gmis::scene::make_diffuse(Color(0.7))));
      }
      builder.add_sphere({0, 4, 5}, 1, builder.add_material(gmis::scene::make_diffuse(Color(0))),
                         gmis::scene::AreaEmission{Color(3), false});
      builder.set_camera(gmis::scene::look_at({0, 0, 0}, {0, 0, 5}, {0, 1, 0}, 40, {24, 24}));
      const auto scene = builder.build();
      constexpr int max_depth = 5;
      const Plan plan = gmis::plan_for(scene.effects(), max_depth);
      gmis::RenderSettings settings;
      settings.max_depth = max_depth;
      settings.seed = gmis_test::seed(91);
      settings.path_classes = PathClassSet::all();
      gmis::Engine<gmis::scene::BvhScene<float>, gmis::BothSides> engine(scene,
                                                                         gmis_test::ways::Bpt::settings(settings));
      engine.keep_contributions(true);
      gmis::SerialExecutor executor;
      PathClassSet seen;
      // Where all is glass, few iterations see any light: it iterates until one does.
      for (int i = 0; i < 4 || (seen.is_empty() && i < 1000); ++i) {
        engine.iterate(executor);
        engine.for_each_contribution([&](const auto& contribution) { seen.add(contribution.id.path_class); });
      }
      CHECK((seen - plan.classes).is_empty());
      CHECK_FALSE(seen.is_empty());
    }
}
