#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "gmis/core/effects.hpp"
#include "gmis/transport/effects/path_class.hpp"
#include "gmis/transport/techniques/technique.hpp"

/// \file
/// Which techniques a scene calls for, by rules that look at what it has, not at any sample. A rule may only leave out a
/// technique without which every path that all of them make is still made.

namespace gmis {

/// The classes of the paths that carry light in a scene with these effects, of at most `max_depth` edges.
[[nodiscard]] constexpr PathClassSet classes_of(const Effects& effects, int max_depth) noexcept {
  return PathClassSet::where([&](const PathFeatures& f) {
    if (least_depth(class_with(f)) > max_depth) return false;
    if ((f.specular_at_light || f.specular_between || f.specular_at_camera) && !effects.has_specular()) return false;
    if (f.scatterings == 0) return effects.has_extended_lights();
    // A name with D alone is that of paths without any G.
    const bool has_diffuse = effects.diffuse || (effects.glossy && !effects.purely_glossy);
    return effects.has_lights() && (f.glossy ? effects.purely_glossy : has_diffuse);
  });
}

/// Whether the technique makes some of the paths with these features; `is_delta`: those of lights that no ray can meet.
[[nodiscard]] constexpr bool makes_some(Technique technique, const PathFeatures& f, bool is_delta) noexcept {
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
      return f.scatterings > 0;
  }
  return false;
}

/// Those of `classes` of which the technique makes some paths.
[[nodiscard]] constexpr PathClassSet classes_made_by(Technique technique, PathClassSet classes,
                                                     const Effects& effects) noexcept {
  return classes & PathClassSet::where([&](const PathFeatures& f) {
           return (effects.has_extended_lights() && makes_some(technique, f, false)) ||
                  (effects.has_delta_lights() && makes_some(technique, f, true));
         });
}

/// What rules look at: the scene, and the classes that are to be rendered.
struct PlanFacts {
  Effects effects;
  PathClassSet classes;

  template <class Predicate>
  [[nodiscard]] constexpr bool all_classes(Predicate&& holds) const {
    return (classes - PathClassSet::where(holds)).is_empty();
  }
};

/// Why a technique is off, or on. Of several reasons to leave one out, the first counts.
enum class PlanRule : std::uint8_t {
  no_light,
  no_scattering,
  no_light_to_hit,
  makes_nothing,
  direct_light_only,
  nothing_to_merge,
  needed,
  helps,
  goes_along
};

/// The rules that leave techniques out. Each is a function of a technique and the facts; `sentence_of` says it in words.
namespace plan_rules {

constexpr bool no_light(Technique, const PlanFacts& facts) {
  return !facts.effects.has_lights();
}

constexpr bool no_scattering(Technique technique, const PlanFacts& facts) {
  return technique != Technique::emitter_hit && !facts.effects.has_scattering();
}

constexpr bool no_light_to_hit(Technique technique, const PlanFacts& facts) {
  return technique == Technique::emitter_hit && !facts.effects.has_extended_lights();
}

constexpr bool makes_nothing(Technique technique, const PlanFacts& facts) {
  return classes_made_by(technique, facts.classes, facts.effects).is_empty();
}

/// Next event makes every path that scatters once, lit by no mirror or glass; emitter hits make those that do not scatter.
constexpr bool direct_light_only(Technique technique, const PlanFacts& facts) {
  if (technique == Technique::emitter_hit || technique == Technique::next_event) return false;
  return facts.all_classes(
      [](const PathFeatures& f) { return f.scatterings == 0 || (f.scatterings == 1 && !f.specular_at_light); });
}

/// Lobes rougher than this are connected well.
inline constexpr double narrow_lobe = 0.25;

/// Where the light's end of a path is not specular, next event makes it; where the camera's is not, splats do. Paths with
/// both ends specular, and those between narrow lobes, are what merging is for.
constexpr bool nothing_to_merge(Technique technique, const PlanFacts& facts) {
  if (technique != Technique::merge) return false;
  if (facts.effects.glossy && facts.effects.least_roughness < narrow_lobe) return false;
  return facts.all_classes(
      [](const PathFeatures& f) { return f.scatterings == 0 || !f.specular_at_light || !f.specular_at_camera; });
}

}  // namespace plan_rules

[[nodiscard]] constexpr std::string_view sentence_of(PlanRule rule) noexcept {
  switch (rule) {
    case PlanRule::no_light:
      return "there is no light";
    case PlanRule::no_scattering:
      return "no surface scatters: there are only mirrors, glass and black ones";
    case PlanRule::no_light_to_hit:
      return "no ray can hit a point, spot or directional light";
    case PlanRule::makes_nothing:
      return "it makes none of the paths that are rendered";
    case PlanRule::direct_light_only:
      return "direct light is all there is to make, and next events make all of it";
    case PlanRule::nothing_to_merge:
      return "every path can be connected at one of its ends, and no lobe is so narrow that this would be hard";
    case PlanRule::needed:
      return "nothing else makes some of its paths";
    case PlanRule::helps:
      return "others make its paths too, not always as well";
    case PlanRule::goes_along:
      return "light subpaths are traced anyway";
  }
  return "";
}

/// One technique of a plan.
struct TechniquePlan {
  Technique technique;
  bool is_on;
  PlanRule rule;       ///< why
  PathClassSet makes;  ///< the classes of which it makes paths, whether it is on or off
};

/// What is to be done in a scene, and why.
struct Plan {
  Effects effects;
  PathClassSet occurring;                                 ///< the classes that carry light
  PathClassSet classes;                                   ///< those of them that are rendered
  std::array<TechniquePlan, technique_count> techniques;  ///< in the order of `Technique`

  [[nodiscard]] constexpr const TechniquePlan& operator[](Technique technique) const noexcept {
    return techniques[static_cast<std::size_t>(technique)];
  }
  [[nodiscard]] constexpr bool has(Technique technique) const noexcept { return (*this)[technique].is_on; }
  [[nodiscard]] constexpr bool traces_light() const noexcept {
    return has(Technique::connect) || has(Technique::splat) || has(Technique::merge);
  }
  /// Whether classes that carry light are left out, so that paths must be classified.
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

/// The classes that are rendered of which this technique, and no other that is on, makes some paths: for one kind of light
/// at least.
[[nodiscard]] constexpr PathClassSet classes_only_by(Technique technique, const Plan& plan) noexcept {
  return plan.classes & PathClassSet::where([&](const PathFeatures& f) {
           for (const bool is_delta : {false, true}) {
             if (!(is_delta ? plan.effects.has_delta_lights() : plan.effects.has_extended_lights())) continue;
             bool only = makes_some(technique, f, is_delta);
             for (const TechniquePlan& other : plan.techniques)
               if (other.technique != technique && other.is_on && makes_some(other.technique, f, is_delta))
                 only = false;
             if (only) return true;
           }
           return false;
         });
}

/// The plan for a scene with these effects, for paths of at most `max_depth` edges of the classes `wanted`.
[[nodiscard]] constexpr Plan plan_for(const Effects& effects, int max_depth,
                                      PathClassSet wanted = PathClassSet::all()) noexcept {
  Plan plan{effects, classes_of(effects, max_depth), {}, {}};
  plan.classes = plan.occurring & wanted;
  const PlanFacts facts{effects, plan.classes};
  for (std::size_t i = 0; i < technique_count; ++i) {
    const auto technique = static_cast<Technique>(i);
    const PlanRule rule = detail::first_rule(technique, facts);
    plan.techniques[i] = {technique, rule == PlanRule::helps, rule,
                          classes_made_by(technique, plan.occurring, effects)};
  }
  // One more visibility query at a vertex that is there anyway.
  TechniquePlan& splat = plan.techniques[static_cast<std::size_t>(Technique::splat)];
  if (!splat.is_on && (plan.has(Technique::connect) || plan.has(Technique::merge)))
    splat.is_on = true, splat.rule = PlanRule::goes_along;
  for (TechniquePlan& technique : plan.techniques)
    if (technique.rule == PlanRule::helps && !classes_only_by(technique.technique, plan).is_empty())
      technique.rule = PlanRule::needed;
  return plan;
}

}  // namespace gmis
