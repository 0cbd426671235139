#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "gmis/core/concepts.hpp"
#include "gmis/core/random.hpp"

namespace gmis {

/// The cosine that belongs to f at `point`: |cos| with the shading normal, and for importance Veach's correction, which
/// keeps the two kinds of transport adjoint when the shading normal is not the geometric one [Veach 1997, eq. 5.19].
template <std::floating_point T>
[[nodiscard]] inline T scattering_cosine(const SurfacePoint<T>& point, const Vec3<T>& to_prev, const Vec3<T>& to_next,
                                         TransportMode mode) noexcept {
  if (mode == TransportMode::radiance || point.shading_normal == point.geometric_normal)
    return std::abs(glm::dot(point.shading_normal, to_next));
  const T prev_geometric = std::abs(glm::dot(point.geometric_normal, to_prev));
  if (prev_geometric == T(0)) return T(0);
  return std::abs(glm::dot(point.geometric_normal, to_next) * glm::dot(point.shading_normal, to_prev)) / prev_geometric;
}

/// The chance of going on from here, a function of the vertex alone, so that nominal densities can contain it.
template <Bsdf B>
[[nodiscard]] inline ScalarOf<typename B::Spectrum> survival_probability(const B& bsdf) noexcept {
  using T = ScalarOf<typename B::Spectrum>;
  return std::clamp(max_channel(typename B::Spectrum(bsdf.albedo())), T(0), T(1));
}

/// A step of a subpath. `weight` is what the throughput is multiplied by: f |cos| over everything that was really done
/// (density, survival, number of siblings). The densities are the nominal ones for the path weights, per steradian,
/// with the nominal number of children; for a delta event they are selection probability · |cos| · index² (of each
/// side), whose ratio is that of the two delta functions (docs/weights.md).
template <Spectrum S>
struct Step {
  Vec3<ScalarOf<S>> to_next;
  S weight;
  ScalarOf<S> forward;
  ScalarOf<S> reverse;
  bool is_delta;
};

/// The nominal numbers of children at one vertex, survival included: of the subpath at hand and of one from the other
/// end.
template <std::floating_point T>
struct NominalChildren {
  T forward, reverse;
};

/// A vertex at which a subpath is about to go on. The numbers of children may differ for delta events: a camera subpath
/// that is to stop at diffuse surfaces goes on through their delta lobes.
template <Bsdf B>
struct ScatteringVertex {
  using T = ScalarOf<typename B::Spectrum>;
  const B& bsdf;
  const SurfacePoint<T>& point;
  const Vec3<T>& to_prev;
  TransportMode mode;
  T survival;
  NominalChildren<T> children;
  NominalChildren<T> delta_children;
};

/// Draws one child from the mixture of all lobes.
template <Bsdf B>
[[nodiscard, gnu::always_inline]] inline std::optional<Step<typename B::Spectrum>> scatter(
    const ScatteringVertex<B>& at, UniformSource auto& source) {
  using T = ScalarOf<typename B::Spectrum>;
  const T u_survival = uniform<T>(source);
  const T u = uniform<T>(source);
  const Vec2<T> uv{uniform<T>(source), uniform<T>(source)};
  if (u_survival >= at.survival) return std::nullopt;
  const auto sample = at.bsdf.sample(at.to_prev, u, uv, at.mode);
  if (!sample) return std::nullopt;

  const SurfacePoint<T>& point = at.point;
  const T cos_next = std::abs(glm::dot(point.shading_normal, sample->to_next));
  T adjoint = T(1);
  if (at.mode == TransportMode::importance && point.shading_normal != point.geometric_normal)
    adjoint = cos_next > T(0) ? scattering_cosine(point, at.to_prev, sample->to_next, at.mode) / cos_next : T(0);
  const auto weight = sample->weight * (adjoint / at.survival);
  const T forward = sample->pdf.forward.value;
  const T reverse = sample->pdf.reverse.value;
  if (!sample->is_delta)
    return Step<typename B::Spectrum>{sample->to_next, weight, at.children.forward * forward,
                                      at.children.reverse * reverse, false};
  const T cos_prev = std::abs(glm::dot(point.shading_normal, at.to_prev));
  return Step<typename B::Spectrum>{sample->to_next, weight,
                                    at.delta_children.forward * forward * cos_next * square(sample->eta),
                                    at.delta_children.reverse * reverse * cos_prev, true};
}

}  // namespace gmis
