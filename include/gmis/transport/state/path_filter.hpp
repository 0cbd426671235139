#pragma once

#include <optional>

#include "gmis/transport/state/path_class.hpp"

namespace gmis {

/// Decides which path classes a run makes. A filter without a set of wanted classes keeps every
/// path, leaves all paths `unclassified` and does not track the events of subpaths.
class PathFilter {
 public:
  constexpr PathFilter() = default;
  /// Keeps the classes of `wanted`, or all.
  constexpr explicit PathFilter(const std::optional<PathClassSet>& wanted) noexcept
      : wanted_(wanted.value_or(PathClassSet::all())), classifies_(wanted.has_value()) {}

  /// True when the run classifies paths.
  [[nodiscard]] constexpr bool classifies() const noexcept { return classifies_; }

  /// True when a light subpath with these events can still become part of a wanted path.
  [[nodiscard]] constexpr bool keeps_light(HalfPath light) const noexcept {
    return !classifies_ || wanted_.intersects(classes_from_light(light));
  }
  /// True when a camera subpath with these events can still become part of a wanted path.
  [[nodiscard]] constexpr bool keeps_camera(HalfPath camera) const noexcept {
    return !classifies_ || wanted_.intersects(classes_from_camera(camera));
  }

  /// The events `path` before a vertex, plus the non-delta event of the vertex itself.
  template <Bsdf B>
  [[nodiscard]] constexpr HalfPath after_scattering(HalfPath path, const B& bsdf) const noexcept {
    return classifies_ ? path.then(scattering_event(bsdf)) : path;
  }
  /// The events `path` before a vertex, plus the event by which the path goes on there.
  template <Bsdf B>
  [[nodiscard]] constexpr HalfPath after_event(HalfPath path, const B& bsdf, bool is_delta) const noexcept {
    return classifies_ ? path.then(is_delta ? PathEvent::specular : scattering_event(bsdf)) : path;
  }
  /// The class of a path (`unclassified` when the run does not classify paths), and whether paths
  /// of this class are wanted.
  struct Joined {
    PathClass path_class = PathClass::unclassified;  ///< of the whole path
    bool is_kept = true;                             ///< whether it is wanted
  };
  /// The class of the path with the subpaths `light()` and `camera()`. Both are called only when
  /// the run classifies paths.
  template <class Light, class Camera>
  [[nodiscard]] constexpr Joined join(Light&& light, Camera&& camera) const noexcept {
    if (!classifies_) [[likely]]
      return {};
    const PathClass path_class = class_of(light(), camera());
    return {path_class, wanted_.contains(path_class)};
  }

 private:
  PathClassSet wanted_ = PathClassSet::all();
  bool classifies_ = false;
};

}  // namespace gmis
