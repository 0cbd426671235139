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

  [[nodiscard]] constexpr bool keeps(PathClass path_class) const noexcept {
    return !classifies_ || wanted_.contains(path_class);
  }
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
  /// The class of the path that the two make, as far as it is told.
  [[nodiscard]] constexpr PathClass join(HalfPath light, HalfPath camera) const noexcept {
    return classifies_ ? class_of(light, camera) : PathClass::unclassified;
  }

 private:
  PathClassSet wanted_ = PathClassSet::all();
  bool classifies_ = false;
};

}  // namespace gmis
