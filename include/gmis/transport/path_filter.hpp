#pragma once

#include "gmis/transport/path_class.hpp"

/// \file
/// What an integrator that classifies paths keeps with its subpaths and asks before it works for a contribution, and the
/// nothing that every other one keeps instead.

namespace gmis {

/// In place of `HalfPath` where nobody asks for classes.
struct NoHalfPath {
  [[nodiscard]] friend constexpr PathClass class_of(NoHalfPath, NoHalfPath) noexcept { return PathClass::unclassified; }
};

/// The events up to and with those of a vertex at which a path goes on by other than a delta event.
template <Bsdf B>
[[nodiscard]] constexpr HalfPath after_scattering(HalfPath path, const B& bsdf) noexcept {
  return path.then(scattering_event(bsdf));
}
template <Bsdf B>
[[nodiscard]] constexpr NoHalfPath after_scattering(NoHalfPath path, const B&) noexcept {
  return path;
}
/// The same where it goes on by this event.
template <Bsdf B>
[[nodiscard]] constexpr HalfPath after_event(HalfPath path, const B& bsdf, bool is_delta) noexcept {
  return path.then(is_delta ? PathEvent::specular : scattering_event(bsdf));
}
template <Bsdf B>
[[nodiscard]] constexpr NoHalfPath after_event(NoHalfPath path, const B&, bool) noexcept {
  return path;
}

/// Which classes are wanted.
class PathFilter {
 public:
  constexpr explicit PathFilter(PathClassSet wanted) noexcept : wanted_(wanted) {}
  [[nodiscard]] constexpr bool keeps(PathClass path_class) const noexcept { return wanted_.contains(path_class); }
  /// Whether a light subpath, a camera subpath, can still become part of a path that is wanted.
  [[nodiscard]] constexpr bool keeps_light(HalfPath light) const noexcept {
    return wanted_.intersects(classes_from_light(light));
  }
  [[nodiscard]] constexpr bool keeps_camera(HalfPath camera) const noexcept {
    return wanted_.intersects(classes_from_camera(camera));
  }

 private:
  PathClassSet wanted_;
};

/// Lets everything through.
struct NoPathFilter {
  constexpr explicit NoPathFilter(PathClassSet) noexcept {}
  [[nodiscard]] static constexpr bool keeps(PathClass) noexcept { return true; }
  [[nodiscard]] static constexpr bool keeps_light(NoHalfPath) noexcept { return true; }
  [[nodiscard]] static constexpr bool keeps_camera(NoHalfPath) noexcept { return true; }
};

}  // namespace gmis
