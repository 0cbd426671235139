#pragma once

#include <optional>

#include "gmis/transport/effects/path_class.hpp"

namespace gmis {

/// Which path classes a run makes. When it makes all of them without telling them apart, subpaths do not keep their events
/// and every path is `unclassified`.
class PathFilter {
 public:
  constexpr PathFilter() = default;
  constexpr explicit PathFilter(const std::optional<PathClassSet>& wanted) noexcept
      : wanted_(wanted.value_or(PathClassSet::all())), classifies_(wanted.has_value()) {}

  /// Whether paths are told apart.
  [[nodiscard]] constexpr bool classifies() const noexcept { return classifies_; }

  /// Whether a light subpath, a camera subpath, can still become part of a path that is wanted.
  [[nodiscard]] constexpr bool keeps_light(HalfPath light) const noexcept {
    return !classifies_ || wanted_.intersects(classes_from_light(light));
  }
  [[nodiscard]] constexpr bool keeps_camera(HalfPath camera) const noexcept {
    return !classifies_ || wanted_.intersects(classes_from_camera(camera));
  }

  /// The events up to and with those of a vertex at which a path goes on by other than a delta event.
  template <Bsdf B>
  [[nodiscard]] constexpr HalfPath after_scattering(HalfPath path, const B& bsdf) const noexcept {
    return classifies_ ? path.then(scattering_event(bsdf)) : path;
  }
  /// The same where it goes on by this event.
  template <Bsdf B>
  [[nodiscard]] constexpr HalfPath after_event(HalfPath path, const B& bsdf, bool is_delta) const noexcept {
    return classifies_ ? path.then(is_delta ? PathEvent::specular : scattering_event(bsdf)) : path;
  }
  /// The class of a path, as far as it is told, and whether it is wanted.
  struct Joined {
    PathClass path_class = PathClass::unclassified;
    bool is_kept = true;
  };
  /// Of the path whose two halves `light()` and `camera()` give; they are asked only where paths are told apart.
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
