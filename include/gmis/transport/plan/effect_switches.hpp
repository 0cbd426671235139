#pragma once

#include <array>
#include <string_view>

#include "gmis/transport/state/path_class.hpp"

/// \file
/// Effects that can be switched on and off by name. Each path belongs to exactly one of the first
/// four effects. The other effects overlap with these.

namespace gmis {

/// A set of path classes with a name and a description.
struct NamedEffect {
  std::string_view name;  ///< as `gmis-render --effects` takes it
  std::string_view what;  ///< description for users
  PathClassSet classes;   ///< that make it up
};

/// All effects that can be switched.
inline constexpr std::array named_effects{
    NamedEffect{"emission", "light sources seen directly, in mirrors or through glass",
                PathClassSet::where([](const PathFeatures& f) { return f.scatterings == 0; })},
    NamedEffect{"direct", "light that goes straight from its source to a surface and scatters once",
                PathClassSet::where([](const PathFeatures& f) { return f.scatterings == 1 && !f.specular_at_light; })},
    NamedEffect{"caustics", "light that mirrors or glass cast on a scattering surface, and its further scattering",
                PathClassSet::where([](const PathFeatures& f) { return f.scatterings > 0 && f.specular_at_light; })},
    NamedEffect{"indirect", "light that scatters more than once, without caustics",
                PathClassSet::where([](const PathFeatures& f) { return f.scatterings > 1 && !f.specular_at_light; })},
    NamedEffect{"mirrored", "everything seen in mirrors or through glass",
                PathClassSet::where([](const PathFeatures& f) { return f.specular_at_camera; })},
    NamedEffect{"specular", "light that meets a mirror or glass anywhere on its path",
                PathClassSet::where([](const PathFeatures& f) {
                  return f.specular_at_light || f.specular_between || f.specular_at_camera;
                })},
    NamedEffect{"glossy", "light that scatters at a glossy surface without a diffuse part",
                PathClassSet::where([](const PathFeatures& f) { return f.glossy; })}};

/// The result of `switched_effects`.
struct SwitchedEffects {
  PathClassSet classes;      ///< the classes that remain; empty after an error
  std::string_view unknown;  ///< the first switch with an unknown name; empty when there is none
};

/// Reads a list of switches such as "no-caustics,no-glossy" or "emission-only,direct-only". The
/// result is the union of all classes with `-only` (all classes when there is no `-only`), without
/// the classes of every `no-`. A switch may also name a single class: "no-LS+DE".
[[nodiscard]] constexpr SwitchedEffects switched_effects(std::string_view list) noexcept {
  const auto classes_named = [](std::string_view name) {
    for (const NamedEffect& effect : named_effects)
      if (effect.name == name) return effect.classes;
    PathClassSet single;
    for (std::size_t i = 0; i < path_class_count; ++i)
      if (name_of(static_cast<PathClass>(i)) == name) single.add(static_cast<PathClass>(i));
    return single;
  };
  PathClassSet kept, left_out;
  bool keeps_some = false;
  for (bool is_last = false; !is_last;) {
    const std::size_t comma = list.find(',');
    is_last = comma == std::string_view::npos;
    const std::string_view item = list.substr(0, comma);
    if (!is_last) list.remove_prefix(comma + 1);
    constexpr std::string_view no = "no-", only = "-only";
    const bool is_no = item.starts_with(no), is_only = !is_no && item.ends_with(only);
    const PathClassSet named = is_no     ? classes_named(item.substr(no.size()))
                               : is_only ? classes_named(item.substr(0, item.size() - only.size()))
                                         : PathClassSet();
    if (named.is_empty()) return {{}, item.empty() ? std::string_view("(nothing)") : item};
    (is_no ? left_out : kept) = (is_no ? left_out : kept) | named;
    keeps_some = keeps_some || is_only;
  }
  return {(keeps_some ? kept : PathClassSet::all()) - left_out, {}};
}

}  // namespace gmis
