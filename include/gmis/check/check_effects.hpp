#pragma once

#include <cmath>
#include <cstddef>

#include "gmis/check/findings.hpp"
#include "gmis/check/surface_points.hpp"
#include "gmis/core/effects.hpp"

namespace gmis::detail {

/// Checks that `effects()` of a scene names what its surfaces and lights show. The engine leaves
/// out techniques by it.
template <Scene Sc>
class EffectsCheck {
 public:
  using T = ScalarOf<typename Sc::Spectrum>;

  EffectsCheck(const Sc& scene, Philox& source, Findings& findings)
      : effects_(effects_of(scene)), source_(source), findings_(findings) {}

  void check(const CheckedHit<Sc>& at) {
    const auto& point = at.hit.point;
    findings_.look_at(at.group, {Vec3<double>(point.position), -Vec3<double>(at.ray.direction)});
    const bool is_smoothed = glm::dot(point.geometric_normal, point.shading_normal) < T(0.9999);
    if (is_smoothed) findings_.count(Convention::effects, effects_.shading_normals);
    if (at.hit.light != nullptr && !is_black(at.hit.light->emitted(point, -at.ray.direction).radiance))
      findings_.count(Convention::effects, effects_.area_lights);
    const T u = uniform<T>(source_), v = uniform<T>(source_);
    const auto drawn = at.hit.bsdf.sample(-at.ray.direction, u, {v, uniform<T>(source_)}, TransportMode::radiance);
    if (!drawn || is_black(drawn->weight)) return;
    const bool is_through =
        glm::dot(point.shading_normal, drawn->to_next) * glm::dot(point.shading_normal, -at.ray.direction) < T(0);
    if (!drawn->is_delta)
      findings_.count(Convention::effects, effects_.has_scattering());
    else
      findings_.count(Convention::effects, is_through ? effects_.specular_transmission : effects_.specular_reflection);
  }
  /// `group`: of the findings.
  void check(const typename Sc::Light& light, const SurfacePoint<T>& receiver, std::size_t group) {
    findings_.look_at(group, {Vec3<double>(receiver.position)});
    const T u = uniform<T>(source_);
    const auto sample = light.sample_next_event(receiver, {u, uniform<T>(source_)});
    if (!sample || is_black(sample->weight)) return;
    const bool is_named = !light.is_delta() ? (light.is_infinite() ? effects_.environment_lights : effects_.area_lights)
                          : light.is_infinite() ? effects_.directional_lights
                                                : effects_.point_lights || effects_.spot_lights;
    findings_.judge(Convention::effects, is_named);
  }

 private:
  Effects effects_;
  Philox& source_;
  Findings& findings_;
};

}  // namespace gmis::detail
