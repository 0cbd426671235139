#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "gmis/core/attributes.hpp"
#include "gmis/core/concepts.hpp"

/// \file
/// Path classes in Heckbert's notation [Heckbert 1990]: L is the light, E the eye, and each vertex
/// between them has one event. D scatters at a surface with a diffuse part, G scatters at a surface
/// without one, S is a delta event. The class of a path depends on the path alone, not on the
/// technique that made it.
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
/// S+ before E means seen in a mirror or through glass. Where a name has S+ between two D, the path
/// may have any number of S and D there, in any order, with at least one S. A name with G in place
/// of D (LGE, LS+GG+E) stands for the paths in which at least one D is a G.

namespace gmis {

/// The event at a vertex of a path: D, G or S.
enum class PathEvent : std::uint8_t { diffuse, glossy, specular };

/// A BSDF with the optional member `is_glossy()`: true for a surface without a diffuse part.
/// Without this member every non-delta event is D.
template <class B>
concept BsdfThatTellsGlossy = Bsdf<B> && requires(const B& bsdf) {
  { bsdf.is_glossy() } -> std::same_as<bool>;
};

/// The event of a vertex with this BSDF when the path goes on by a non-delta event: D or G.
template <Bsdf B>
[[nodiscard]] constexpr PathEvent scattering_event(const B& bsdf) noexcept {
  if constexpr (BsdfThatTellsGlossy<B>)
    if (bsdf.is_glossy()) return PathEvent::glossy;
  return PathEvent::diffuse;
}

/// The properties that all paths of a class share.
struct PathFeatures {
  int scatterings = 0;              ///< number of events D or G; 2 stands for two or more
  bool specular_at_light = false;   ///< S before the first D or G, seen from the light
  bool specular_between = false;    ///< S between two events D or G
  bool specular_at_camera = false;  ///< S after the last D or G; equals `specular_at_light` when there is no D and no G
  bool glossy = false;              ///< at least one G

  friend constexpr bool operator==(const PathFeatures&, const PathFeatures&) = default;
};

/// The number of a class, below `path_class_count`; `unclassified` when a run does not classify
/// paths.
enum class PathClass : std::uint8_t { unclassified = 255 };
/// How many classes there are, without `unclassified`.
inline constexpr std::size_t path_class_count = 26;

/// The class of all paths with these properties.
[[nodiscard]] constexpr PathClass class_with(const PathFeatures& f) noexcept {
  const int ends = (f.specular_at_light ? 1 : 0) + (f.specular_at_camera ? 2 : 0);
  if (f.scatterings == 0) return static_cast<PathClass>(ends > 0 ? 1 : 0);
  if (f.scatterings == 1) return static_cast<PathClass>(2 + ends + (f.glossy ? 4 : 0));
  return static_cast<PathClass>(10 + ends + (f.specular_between ? 4 : 0) + (f.glossy ? 8 : 0));
}

/// The properties of a class; the inverse of `class_with`.
[[nodiscard]] constexpr PathFeatures features_of(PathClass path_class) noexcept {
  const int number = static_cast<int>(path_class);
  if (number < 2) return {0, number == 1, false, number == 1, false};
  const bool is_single = number < 10;
  const int bits = number - (is_single ? 2 : 10);
  return {is_single ? 1 : 2, (bits & 1) != 0, !is_single && (bits & 4) != 0, (bits & 2) != 0,
          (bits & (is_single ? 4 : 8)) != 0};
}

/// The name of a class as in the table above.
[[nodiscard]] constexpr std::string_view name_of(PathClass path_class) noexcept {
  constexpr std::array<std::string_view, path_class_count> names{
      "LE",      "LS+E",    "LDE",     "LS+DE",     "LDS+E",     "LS+DS+E",  "LGE",      "LS+GE",     "LGS+E",
      "LS+GS+E", "LDD+E",   "LS+DD+E", "LDD+S+E",   "LS+DD+S+E", "LDS+DE",   "LS+DS+DE", "LDS+DS+E",  "LS+DS+DS+E",
      "LGG+E",   "LS+GG+E", "LGG+S+E", "LS+GG+S+E", "LGS+GE",    "LS+GS+GE", "LGS+GS+E", "LS+GS+GS+E"};
  const auto number = static_cast<std::size_t>(path_class);
  return number < path_class_count ? names[number] : "unclassified";
}

/// The smallest number of edges that a path of this class can have.
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
  /// Every class.
  [[nodiscard]] static constexpr PathClassSet all() noexcept { return PathClassSet((1U << path_class_count) - 1U); }
  /// The set of all classes for whose properties `is_in(features)` is true.
  template <class Predicate>
  [[nodiscard]] static constexpr PathClassSet where(Predicate&& is_in) noexcept {
    PathClassSet result;
    for (std::size_t i = 0; i < path_class_count; ++i)
      if (is_in(features_of(static_cast<PathClass>(i)))) result.add(static_cast<PathClass>(i));
    return result;
  }

  /// Adds a class; `unclassified` changes nothing.
  constexpr void add(PathClass path_class) noexcept {
    if (static_cast<std::size_t>(path_class) < path_class_count) bits_ |= 1U << static_cast<unsigned>(path_class);
  }
  /// Whether the class is in the set; `unclassified` is in none.
  [[nodiscard]] constexpr bool contains(PathClass path_class) const noexcept {
    // `unclassified` looks at bit 31, which no set has: cheaper than a comparison for each path.
    return (bits_ >> (static_cast<unsigned>(path_class) % 32U) & 1U) != 0;
  }
  /// No class is in the set.
  [[nodiscard]] constexpr bool is_empty() const noexcept { return bits_ == 0; }
  /// How many classes are in the set.
  [[nodiscard]] constexpr int size() const noexcept { return std::popcount(bits_); }
  /// Whether both have a class in common.
  [[nodiscard]] constexpr bool intersects(PathClassSet other) const noexcept { return (bits_ & other.bits_) != 0; }

  friend constexpr PathClassSet operator|(PathClassSet a, PathClassSet b) noexcept {
    return PathClassSet(a.bits_ | b.bits_);
  }
  friend constexpr PathClassSet operator&(PathClassSet a, PathClassSet b) noexcept {
    return PathClassSet(a.bits_ & b.bits_);
  }
  /// The classes that are in `a` and not in `b`.
  friend constexpr PathClassSet operator-(PathClassSet a, PathClassSet b) noexcept {
    return PathClassSet(a.bits_ & ~b.bits_);
  }
  friend constexpr bool operator==(PathClassSet, PathClassSet) = default;

  /// Calls `visit(PathClass)` for each class of the set, in the order of the class numbers.
  template <class Visit>
  constexpr void for_each(Visit&& visit) const {
    for (std::size_t i = 0; i < path_class_count; ++i)
      if (contains(static_cast<PathClass>(i))) visit(static_cast<PathClass>(i));
  }

 private:
  explicit constexpr PathClassSet(std::uint32_t bits) noexcept : bits_(bits) {}
  static_assert(path_class_count <= static_cast<std::size_t>(PathClass::unclassified) % 32U);
  std::uint32_t bits_ = 0;
};

/// Summary of the events of a subpath, from its start on the light or the camera: one byte. A
/// vertex stores the summary of the events before that vertex.
class HalfPath {
 public:
  constexpr HalfPath() = default;
  /// States that a half can be in.
  static constexpr std::size_t state_count = 64;

  /// The summary after one more event at the far end.
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

  /// The class of the path that two subpaths form when an edge joins their far ends. At a merged
  /// vertex, which both subpaths have, exactly one of the two summaries must include its event.
  GMIS_NEVER_INLINE [[nodiscard]] friend constexpr PathClass class_of(HalfPath light, HalfPath camera) noexcept {
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
  /// A number below `state_count` that identifies the summary.
  [[nodiscard]] constexpr std::size_t number() const noexcept { return bits_; }
  /// The summary with this number.
  [[nodiscard]] static constexpr HalfPath with_number(std::size_t number) noexcept {
    return HalfPath(static_cast<unsigned>(number));
  }

 private:
  enum : unsigned { count_mask = 3, starts_specular = 4, ends_specular = 8, specular_between = 16, is_glossy = 32 };

  explicit constexpr HalfPath(unsigned bits) noexcept : bits_(static_cast<std::uint8_t>(bits)) {}
  [[nodiscard]] constexpr unsigned scatterings() const noexcept { return bits_ & count_mask; }
  [[nodiscard]] constexpr bool has(unsigned bit) const noexcept { return (bits_ & bit) != 0; }

  std::uint8_t bits_ = 0;
};

namespace detail {

struct ReachableClasses {
  std::array<PathClassSet, HalfPath::state_count> from_light{}, from_camera{};
};

/// The classes of all paths through each summary that a subpath can have. Plain arrays and no
/// std::optional: every file that includes this pays for its evaluation.
[[nodiscard]] constexpr ReachableClasses reachable_classes() noexcept {
  HalfPath found[HalfPath::state_count]{};
  bool is_found[HalfPath::state_count]{};
  std::size_t count = 1;
  is_found[0] = true;
  for (std::size_t i = 0; i < count; ++i)
    for (const PathEvent event : {PathEvent::diffuse, PathEvent::glossy, PathEvent::specular}) {
      const HalfPath next = found[i].then(event);
      if (is_found[next.number()]) continue;
      is_found[next.number()] = true;
      found[count++] = next;
    }
  ReachableClasses result;
  for (std::size_t light = 0; light < count; ++light)
    for (std::size_t camera = 0; camera < count; ++camera) {
      const PathClass path_class = class_of(found[light], found[camera]);
      result.from_light[found[light].number()].add(path_class);
      result.from_camera[found[camera].number()].add(path_class);
    }
  return result;
}

inline constexpr ReachableClasses reachable = reachable_classes();

}  // namespace detail

/// The classes of all paths that begin with this light subpath.
[[nodiscard]] constexpr PathClassSet classes_from_light(HalfPath light) noexcept {
  return detail::reachable.from_light[light.number()];
}
/// The classes of all paths that end with this camera subpath.
[[nodiscard]] constexpr PathClassSet classes_from_camera(HalfPath camera) noexcept {
  return detail::reachable.from_camera[camera.number()];
}

}  // namespace gmis
