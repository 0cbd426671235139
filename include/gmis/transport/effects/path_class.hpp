#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "gmis/core/concepts.hpp"

/// \file
/// Which kinds of paths there are, in Heckbert's notation: L the light, E the eye, and what happens at each vertex on the
/// way. D scatters with a diffuse part, G scatters without one, S is a delta event. What a path is called depends on the
/// path alone, not on the technique that made it [Heckbert 1990].
///
/// | name | its events, from the light | what it shows |
/// | --- | --- | --- |
/// | LE, LS+E | none, or S alone | lights, directly or by mirrors and glass |
/// | LDE, LDS+E | one D | direct light |
/// | LS+DE, LS+DS+E | S first, then one D | caustics |
/// | LDD+E, LDD+S+E | several D, nothing between | indirect light |
/// | LS+DD+E, LS+DD+S+E | S first, then several D | light from caustics |
/// | LDS+DE, LDS+DS+E | S between two D | indirect light by mirrors and glass |
/// | LS+DS+DE, LS+DS+DS+E | both | light from caustics by mirrors and glass |
///
/// S+ before E: seen in a mirror or through glass. Where S+ stands between two D, any number of both may follow each
/// other there. A name with G for D (LGE, LS+GG+E) is that of paths of which at least one D is a G.

namespace gmis {

/// What happens at a vertex of a path.
enum class PathEvent : std::uint8_t { diffuse, glossy, specular };

/// A BSDF that tells surfaces without any diffuse part; for one that does not tell, whatever is no delta event is D.
template <class B>
concept BsdfThatTellsGlossy = Bsdf<B> && requires(const B& bsdf) {
  { bsdf.is_glossy() } -> std::same_as<bool>;
};

/// What a vertex with this BSDF is to a path that goes on by other than a delta event.
template <Bsdf B>
[[nodiscard]] constexpr PathEvent scattering_event(const B& bsdf) noexcept {
  if constexpr (BsdfThatTellsGlossy<B>)
    if (bsdf.is_glossy()) return PathEvent::glossy;
  return PathEvent::diffuse;
}

/// What a class says of its paths.
struct PathFeatures {
  int scatterings = 0;              ///< events D or G: 0, 1, or 2 for more than one
  bool specular_at_light = false;   ///< S between the light and the first of them (or the camera)
  bool specular_between = false;    ///< S between two of them
  bool specular_at_camera = false;  ///< S between the last of them and the camera; with none of them: as at the light
  bool glossy = false;              ///< one of them is G

  friend constexpr bool operator==(const PathFeatures&, const PathFeatures&) = default;
};

/// One of `path_class_count` classes, by number; `unclassified` where nobody asked.
enum class PathClass : std::uint8_t { unclassified = 255 };
inline constexpr std::size_t path_class_count = 26;

[[nodiscard]] constexpr PathClass class_with(const PathFeatures& f) noexcept {
  const int ends = (f.specular_at_light ? 1 : 0) + (f.specular_at_camera ? 2 : 0);
  if (f.scatterings == 0) return static_cast<PathClass>(ends > 0 ? 1 : 0);
  if (f.scatterings == 1) return static_cast<PathClass>(2 + ends + (f.glossy ? 4 : 0));
  return static_cast<PathClass>(10 + ends + (f.specular_between ? 4 : 0) + (f.glossy ? 8 : 0));
}

[[nodiscard]] constexpr PathFeatures features_of(PathClass path_class) noexcept {
  const int number = static_cast<int>(path_class);
  if (number < 2) return {0, number == 1, false, number == 1, false};
  const bool is_single = number < 10;
  const int bits = number - (is_single ? 2 : 10);
  return {is_single ? 1 : 2, (bits & 1) != 0, !is_single && (bits & 4) != 0, (bits & 2) != 0,
          (bits & (is_single ? 4 : 8)) != 0};
}

[[nodiscard]] constexpr std::string_view name_of(PathClass path_class) noexcept {
  constexpr std::array<std::string_view, path_class_count> names{
      "LE",      "LS+E",    "LDE",     "LS+DE",     "LDS+E",     "LS+DS+E",  "LGE",      "LS+GE",     "LGS+E",
      "LS+GS+E", "LDD+E",   "LS+DD+E", "LDD+S+E",   "LS+DD+S+E", "LDS+DE",   "LS+DS+DE", "LDS+DS+E",  "LS+DS+DS+E",
      "LGG+E",   "LS+GG+E", "LGG+S+E", "LS+GG+S+E", "LGS+GE",    "LS+GS+GE", "LGS+GS+E", "LS+GS+GS+E"};
  const auto number = static_cast<std::size_t>(path_class);
  return number < path_class_count ? names[number] : "unclassified";
}

/// The fewest edges of a path of this class.
[[nodiscard]] constexpr int least_depth(PathClass path_class) noexcept {
  const PathFeatures f = features_of(path_class);
  if (f.scatterings == 0) return f.specular_at_light ? 2 : 1;
  return 1 + f.scatterings + (f.specular_at_light ? 1 : 0) + (f.specular_between ? 1 : 0) +
         (f.specular_at_camera ? 1 : 0);
}

/// A set of path classes.
class PathClassSet {
 public:
  constexpr PathClassSet() = default;
  [[nodiscard]] static constexpr PathClassSet all() noexcept { return PathClassSet((1U << path_class_count) - 1U); }
  /// Those for which `is_in(features)`.
  template <class Predicate>
  [[nodiscard]] static constexpr PathClassSet where(Predicate&& is_in) noexcept {
    PathClassSet result;
    for (std::size_t i = 0; i < path_class_count; ++i)
      if (is_in(features_of(static_cast<PathClass>(i)))) result.add(static_cast<PathClass>(i));
    return result;
  }

  constexpr void add(PathClass path_class) noexcept { bits_ |= 1U << static_cast<unsigned>(path_class); }
  [[nodiscard]] constexpr bool contains(PathClass path_class) const noexcept {
    return (bits_ >> static_cast<unsigned>(path_class) & 1U) != 0;
  }
  [[nodiscard]] constexpr bool is_empty() const noexcept { return bits_ == 0; }
  [[nodiscard]] constexpr int size() const noexcept { return std::popcount(bits_); }
  [[nodiscard]] constexpr bool intersects(PathClassSet other) const noexcept { return (bits_ & other.bits_) != 0; }

  friend constexpr PathClassSet operator|(PathClassSet a, PathClassSet b) noexcept {
    return PathClassSet(a.bits_ | b.bits_);
  }
  friend constexpr PathClassSet operator&(PathClassSet a, PathClassSet b) noexcept {
    return PathClassSet(a.bits_ & b.bits_);
  }
  /// What is in `a` and not in `b`.
  friend constexpr PathClassSet operator-(PathClassSet a, PathClassSet b) noexcept {
    return PathClassSet(a.bits_ & ~b.bits_);
  }
  friend constexpr bool operator==(PathClassSet, PathClassSet) = default;

  /// Calls `visit(PathClass)` in the order of their numbers.
  template <class Visit>
  constexpr void for_each(Visit&& visit) const {
    for (std::size_t i = 0; i < path_class_count; ++i)
      if (contains(static_cast<PathClass>(i))) visit(static_cast<PathClass>(i));
  }

 private:
  explicit constexpr PathClassSet(std::uint32_t bits) noexcept : bits_(bits) {}
  std::uint32_t bits_ = 0;
};

/// What a subpath knows of its own events, from its end on: one byte. It holds for subpaths from the light as for those from
/// the camera; at a vertex it tells of the events before it.
class HalfPath {
 public:
  constexpr HalfPath() = default;
  static constexpr std::size_t state_count = 64;

  /// With one more event at the far end.
  [[nodiscard]] constexpr HalfPath then(PathEvent event) const noexcept {
    if (event == PathEvent::specular) {
      const unsigned start = scatterings() == 0 ? starts_specular : 0U;
      return HalfPath(bits_ | ends_specular | start);
    }
    const unsigned count = scatterings() == 0 ? 1U : 2U;
    const unsigned between = scatterings() > 0 && has(ends_specular) ? specular_between : 0U;
    const unsigned glossy = event == PathEvent::glossy ? is_glossy : 0U;
    return HalfPath((bits_ & ~(count_mask | ends_specular)) | count | between | glossy);
  }

  /// The class of the path that the two make, their far ends joined by an edge. For a merged vertex, which both subpaths
  /// made, one of the two counts its event.
  [[nodiscard]] friend constexpr PathClass class_of(HalfPath light, HalfPath camera) noexcept {
    const bool light_scatters = light.scatterings() > 0, camera_scatters = camera.scatterings() > 0;
    const int count = static_cast<int>(light.scatterings() + camera.scatterings());
    const bool joins_specular = light.has(ends_specular) || camera.has(ends_specular);
    const bool at_light = light_scatters ? light.has(starts_specular) : joins_specular;
    const bool at_camera = camera_scatters ? camera.has(starts_specular) : joins_specular;
    const bool between =
        ((light.bits_ | camera.bits_) & specular_between) != 0 || (light_scatters && camera_scatters && joins_specular);
    return class_with(
        {count < 2 ? count : 2, at_light, between, at_camera, ((light.bits_ | camera.bits_) & is_glossy) != 0});
  }

  friend constexpr bool operator==(HalfPath, HalfPath) = default;
  [[nodiscard]] constexpr std::size_t number() const noexcept { return bits_; }

 private:
  enum : unsigned { count_mask = 3, starts_specular = 4, ends_specular = 8, specular_between = 16, is_glossy = 32 };

  explicit constexpr HalfPath(unsigned bits) noexcept : bits_(static_cast<std::uint8_t>(bits)) {}
  [[nodiscard]] constexpr unsigned scatterings() const noexcept { return bits_ & count_mask; }
  [[nodiscard]] constexpr bool has(unsigned bit) const noexcept { return (bits_ & bit) != 0; }

  std::uint8_t bits_ = 0;
};

namespace detail {

/// Every state that a subpath can be in.
[[nodiscard]] constexpr std::array<std::optional<HalfPath>, HalfPath::state_count> all_half_paths() noexcept {
  std::array<std::optional<HalfPath>, HalfPath::state_count> found{};
  found[0] = HalfPath();
  for (bool grows = true; grows;) {
    grows = false;
    for (std::size_t i = 0; i < found.size(); ++i)
      for (const PathEvent event : {PathEvent::diffuse, PathEvent::glossy, PathEvent::specular}) {
        if (!found[i]) continue;
        const HalfPath next = found[i]->then(event);
        if (found[next.number()]) continue;
        found[next.number()] = next;
        grows = true;
      }
  }
  return found;
}

struct ReachableClasses {
  std::array<PathClassSet, HalfPath::state_count> from_light{}, from_camera{};
};

[[nodiscard]] constexpr ReachableClasses reachable_classes() noexcept {
  ReachableClasses result;
  const auto halves = all_half_paths();
  for (const auto& here : halves)
    for (const auto& other : halves)
      if (here && other) {
        result.from_light[here->number()].add(class_of(*here, *other));
        result.from_camera[here->number()].add(class_of(*other, *here));
      }
  return result;
}

inline constexpr ReachableClasses reachable = reachable_classes();

}  // namespace detail

/// The classes of all paths that begin with this light subpath (end with this camera subpath), however they go on.
[[nodiscard]] constexpr PathClassSet classes_from_light(HalfPath light) noexcept {
  return detail::reachable.from_light[light.number()];
}
[[nodiscard]] constexpr PathClassSet classes_from_camera(HalfPath camera) noexcept {
  return detail::reachable.from_camera[camera.number()];
}

}  // namespace gmis
