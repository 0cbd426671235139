#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "gmis/core/attributes.hpp"
#include "gmis/core/effects.hpp"
#include "gmis/transport/state/path_class.hpp"
#include "gmis/transport/state/technique.hpp"

/// \file
/// Selects the techniques that a scene needs, by rules over its effects; no sample is drawn. A rule
/// may leave out a technique only when the remaining techniques still make every path that all
/// techniques together make.

namespace gmis {

/// The classes of paths that can carry light in a scene with these effects, for paths of at most
/// `max_depth` edges.
[[nodiscard]] constexpr PathClassSet classes_of(const Effects& effects, int max_depth) noexcept {
  return PathClassSet::where([&](const PathFeatures& f) {
    if (least_depth(class_with(f)) > max_depth) return false;
    if ((f.specular_at_light || f.specular_between || f.specular_at_camera) && !effects.has_specular()) return false;
    if (f.scatterings == 0) return effects.has_extended_lights();
    // A class without G needs a surface with a diffuse part.
    const bool has_diffuse = effects.diffuse || (effects.glossy && !effects.purely_glossy);
    return effects.has_lights() && (f.glossy ? effects.purely_glossy : has_diffuse);
  });
}

/// True when the technique makes at least some paths with these properties. `is_delta`: paths from
/// delta lights, which no ray can hit; else paths from all other lights. `local_merges`:
/// `SampleCounts::local_merges`, in a scene with narrow lobes; light vertices that come straight
/// from a light are then no photons.
[[nodiscard]] constexpr bool makes_some(Technique technique, const PathFeatures& f, bool is_delta,
                                        bool local_merges = false) noexcept {
  switch (technique) {
    case Technique::emitter_hit:
      return !is_delta;
    case Technique::next_event:
      return f.scatterings > 0 && !f.specular_at_light;
    case Technique::splat:
      return f.scatterings > 0 && !f.specular_at_camera;
    case Technique::connect:
      return f.scatterings > 1;
    case Technique::merge:
      return local_merges ? f.scatterings > (f.specular_at_light ? 0 : 1) : f.scatterings > 0;
  }
  return false;
}

/// The classes among `classes` of which the technique makes at least some paths.
[[nodiscard]] constexpr PathClassSet classes_made_by(Technique technique, PathClassSet classes, const Effects& effects,
                                                     bool local_merges = false) noexcept {
  if (technique == Technique::merge && local_merges && !effects.has_narrow_lobes()) return {};
  return classes & PathClassSet::where([&](const PathFeatures& f) {
           return (effects.has_extended_lights() && makes_some(technique, f, false, local_merges)) ||
                  (effects.has_delta_lights() && makes_some(technique, f, true, local_merges));
         });
}

/// The input of the rules: the effects of the scene and the path classes to render.
struct PlanFacts {
  Effects effects;            ///< what the scene has
  PathClassSet classes;       ///< that are wanted and that the scene can have
  bool local_merges = false;  ///< as in `SampleCounts`

  /// True when `holds(features)` is true for every class to render.
  template <class Predicate>
  [[nodiscard]] constexpr bool all_classes(Predicate&& holds) const {
    return (classes - PathClassSet::where(holds)).is_empty();
  }
};

/// The reason why a technique is off or on. When several rules leave a technique out, the first in
/// this order is reported.
enum class PlanRule : std::uint8_t {
  no_light,           ///< off: the scene has no light
  no_scattering,      ///< off: every surface is specular or black
  no_light_to_hit,    ///< off: every light is a delta light
  makes_nothing,      ///< off: it makes no path of the rendered classes
  direct_light_only,  ///< off: emitter hits and next events make all rendered paths
  nothing_to_merge,   ///< off: other techniques make every path that merging makes
  needed,             ///< on: it alone makes some of the rendered paths
  helps,              ///< on: other techniques make its paths too
  goes_along          ///< on: light subpaths are traced for another technique
};

/// The rules that leave techniques out. Each rule is a function of a technique and the facts and
/// returns true when the technique is to be left out. `sentence_of` gives the reason in words.
namespace plan_rules {

/// The scene has no light.
constexpr bool no_light(Technique, const PlanFacts& facts) {
  return !facts.effects.has_lights();
}

/// Nothing scatters, and the technique needs scattering.
constexpr bool no_scattering(Technique technique, const PlanFacts& facts) {
  return technique != Technique::emitter_hit && !facts.effects.has_scattering();
}

/// An emitter hit, and no light that a ray can hit.
constexpr bool no_light_to_hit(Technique technique, const PlanFacts& facts) {
  return technique == Technique::emitter_hit && !facts.effects.has_extended_lights();
}

/// The technique makes no path that the scene has and that is wanted.
constexpr bool makes_nothing(Technique technique, const PlanFacts& facts) {
  return classes_made_by(technique, facts.classes, facts.effects, facts.local_merges).is_empty();
}

/// Next event makes every path that scatters once and whose light does not pass a mirror or glass
/// first. Emitter hits make every path that does not scatter. When no other paths are rendered,
/// these two techniques suffice.
constexpr bool direct_light_only(Technique technique, const PlanFacts& facts) {
  if (technique == Technique::emitter_hit || technique == Technique::next_event) return false;
  return facts.all_classes(
      [](const PathFeatures& f) { return f.scatterings == 0 || (f.scatterings == 1 && !f.specular_at_light); });
}

/// Next event makes a path whose light end is not specular; splats make a path whose camera end is
/// not specular. Merging is needed for paths with both ends specular. It also helps paths between
/// narrow lobes.
constexpr bool nothing_to_merge(Technique technique, const PlanFacts& facts) {
  if (technique != Technique::merge) return false;
  if (facts.effects.glossy && facts.effects.least_roughness < narrow_roughness) return false;
  return facts.all_classes(
      [](const PathFeatures& f) { return f.scatterings == 0 || !f.specular_at_light || !f.specular_at_camera; });
}

}  // namespace plan_rules

/// The reason in words.
[[nodiscard]] constexpr std::string_view sentence_of(PlanRule rule) noexcept {
  switch (rule) {
    case PlanRule::no_light:
      return "there is no light";
    case PlanRule::no_scattering:
      return "no surface scatters: every surface is a mirror, glass or black";
    case PlanRule::no_light_to_hit:
      return "no ray can hit a point, spot or directional light";
    case PlanRule::makes_nothing:
      return "it makes none of the rendered paths";
    case PlanRule::direct_light_only:
      return "only direct light is rendered, and next events make all of it";
    case PlanRule::nothing_to_merge:
      return "next events or splats make every path, and no lobe is narrow";
    case PlanRule::needed:
      return "no other technique makes some of its paths";
    case PlanRule::helps:
      return "other techniques make its paths too, some with more noise";
    case PlanRule::goes_along:
      return "light subpaths are traced for another technique";
  }
  return "";
}

/// One technique of a plan.
struct TechniquePlan {
  Technique technique;  ///< which it is
  bool is_on;           ///< whether it runs
  PlanRule rule;        ///< why the technique is on or off
  PathClassSet makes;  ///< the classes that carry light and of which the technique makes paths, whether it is on or off
};

/// The techniques to run in a scene, with the reason for each.
struct Plan {
  Effects effects;                                        ///< what the scene has
  PathClassSet occurring;                                 ///< the classes that carry light
  PathClassSet classes;                                   ///< the classes that carry light and are rendered
  bool local_merges;                                      ///< as in `SampleCounts`
  std::array<TechniquePlan, technique_count> techniques;  ///< in the order of `Technique`

  /// The plan of a technique.
  [[nodiscard]] constexpr const TechniquePlan& operator[](Technique technique) const noexcept {
    return techniques[static_cast<std::size_t>(technique)];
  }
  /// True when the technique is on.
  [[nodiscard]] constexpr bool has(Technique technique) const noexcept { return (*this)[technique].is_on; }
  /// True when a technique that needs light subpaths is on.
  [[nodiscard]] constexpr bool traces_light() const noexcept {
    return has(Technique::connect) || has(Technique::splat) || has(Technique::merge);
  }
  /// True when some classes that carry light are not rendered. Paths must then be classified: set
  /// `RenderSettings::path_classes` to the classes passed to `plan_for`.
  [[nodiscard]] constexpr bool leaves_out_classes() const noexcept { return !(classes == occurring); }
};

namespace detail {

/// The first rule that leaves the technique out; `helps` when none does.
[[nodiscard]] constexpr PlanRule first_rule(Technique technique, const PlanFacts& facts) noexcept {
  using Holds = bool (*)(Technique, const PlanFacts&);
  struct Rule {
    PlanRule rule;
    Holds holds;
  };
  constexpr Rule rules[] = {{PlanRule::no_light, plan_rules::no_light},
                            {PlanRule::no_scattering, plan_rules::no_scattering},
                            {PlanRule::no_light_to_hit, plan_rules::no_light_to_hit},
                            {PlanRule::makes_nothing, plan_rules::makes_nothing},
                            {PlanRule::direct_light_only, plan_rules::direct_light_only},
                            {PlanRule::nothing_to_merge, plan_rules::nothing_to_merge}};
  for (const Rule& rule : rules)
    if (rule.holds(technique, facts)) return rule.rule;
  return PlanRule::helps;
}

}  // namespace detail

/// The rendered classes that lose paths without `technique`: no other technique that is on makes
/// these paths, for delta lights or for the other lights.
[[nodiscard]] constexpr PathClassSet classes_only_by(Technique technique, const Plan& plan) noexcept {
  return plan.classes & PathClassSet::where([&](const PathFeatures& f) {
           for (const bool is_delta : {false, true}) {
             if (!(is_delta ? plan.effects.has_delta_lights() : plan.effects.has_extended_lights())) continue;
             bool only = makes_some(technique, f, is_delta, plan.local_merges);
             for (const TechniquePlan& other : plan.techniques)
               if (other.technique != technique && other.is_on &&
                   makes_some(other.technique, f, is_delta, plan.local_merges))
                 only = false;
             if (only) return true;
           }
           return false;
         });
}

/// The plan for a scene with these effects, for paths of at most `max_depth` edges. Only classes in
/// `wanted` are rendered. `local_merges`: merging is to have a local count
/// (`SampleCounts::local_merges`).
GMIS_RARE [[nodiscard]] constexpr Plan plan_for(const Effects& effects, int max_depth,
                                                PathClassSet wanted = PathClassSet::all(),
                                                bool local_merges = false) noexcept {
  Plan plan{effects, classes_of(effects, max_depth), {}, local_merges, {}};
  plan.classes = plan.occurring & wanted;
  const PlanFacts facts{effects, plan.classes, local_merges};
  for (std::size_t i = 0; i < technique_count; ++i) {
    const auto technique = static_cast<Technique>(i);
    const PlanRule rule = detail::first_rule(technique, facts);
    plan.techniques[i] = {technique, rule == PlanRule::helps, rule,
                          classes_made_by(technique, plan.occurring, effects, local_merges)};
  }
  // When light subpaths are traced for another technique, a splat costs one more visibility query
  // per vertex.
  TechniquePlan& splat = plan.techniques[static_cast<std::size_t>(Technique::splat)];
  if (!splat.is_on && (plan.has(Technique::connect) || plan.has(Technique::merge)))
    splat.is_on = true, splat.rule = PlanRule::goes_along;
  for (TechniquePlan& technique : plan.techniques)
    if (technique.rule == PlanRule::helps && !classes_only_by(technique.technique, plan).is_empty())
      technique.rule = PlanRule::needed;
  return plan;
}

}  // namespace gmis
