#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "gmis/core/attributes.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/random.hpp"

namespace gmis {

/// The cosine factor of f at `point`: |n_s · to_next| for radiance. For importance it includes the
/// correction that keeps the two kinds of transport adjoint when shading and geometric normal
/// differ:
/// |n_g · to_next| |n_s · to_prev| / |n_g · to_prev| [Veach 1997, eq. 5.19]. It is 0 when `to_prev` is parallel to the
/// surface.
template <std::floating_point T>
[[nodiscard]] constexpr T scattering_cosine(const SurfacePoint<T>& point, const Vec3<T>& to_prev,
                                            const Vec3<T>& to_next, TransportMode mode) noexcept {
  if (mode == TransportMode::radiance || point.shading_normal == point.geometric_normal)
    return std::abs(glm::dot(point.shading_normal, to_next));
  const T prev_geometric = std::abs(glm::dot(point.geometric_normal, to_prev));
  if (prev_geometric == T(0)) return T(0);
  return std::abs(glm::dot(point.geometric_normal, to_next) * glm::dot(point.shading_normal, to_prev)) / prev_geometric;
}

/// Continuation probability of Russian roulette of a light subpath: the largest channel of the
/// albedo, in [0, 1], so that photons carry equal flux. It is a function of the vertex alone, so
/// that nominal densities can contain it. At 0 the surface absorbs everything, and subpaths of both
/// kinds end.
template <Bsdf B>
[[nodiscard]] constexpr ScalarOf<typename B::Spectrum> survival_probability(const B& bsdf) noexcept {
  using T = ScalarOf<typename B::Spectrum>;
  return std::clamp(max_channel(typename B::Spectrum(bsdf.albedo())), T(0), T(1));
}
/// Continuation probability of a camera subpath beyond its first non-specular vertex, where
/// `survival` is the one of a light subpath: these vertices contribute less for the same cost than
/// those before. Up to its first non-specular vertex and from there a camera subpath always goes
/// on, where `survival` is above 0: to end it there would waste the rays that led to it.
///
/// Path weights may tell the two apart: the first non-specular vertex is known wherever two
/// subpaths meet. Either the camera subpath contains it, or the light subpath ends there, in a
/// splat.
template <std::floating_point T>
[[nodiscard]] constexpr T camera_survival(T survival) noexcept {
  return T(0.9) * survival;
}

/// A step of a subpath.
///
/// `weight` is the factor on the throughput: f |cos| divided by the actual density, continuation
/// probability and number of siblings. `forward` and `reverse` are the nominal densities that path
/// weights use: nominal number of children × density per steradian, without the cosine. For a delta
/// event they are nominal children × selection probability ×
/// |cos| × index² (each with the values of its side); their ratio is the ratio of the two delta functions
/// (docs/weights.md).
template <Spectrum S>
struct Step {
  Vec3<ScalarOf<S>> to_next;  ///< unit direction of the step, away from the surface
  S weight;                   ///< factor on the throughput
  ScalarOf<S> forward;        ///< nominal density of this step
  ScalarOf<S> reverse;        ///< nominal density of the step in the other direction of the path
  bool is_delta;              ///< the step comes from a delta lobe
};

/// The nominal numbers of children c at one vertex, continuation probability included: of the
/// subpath that made the vertex (`forward`) and of a subpath that comes from the other end of the
/// path (`reverse`).
template <std::floating_point T>
struct NominalChildren {
  T forward;  ///< c of the subpath that made the vertex
  T reverse;  ///< c of a subpath from the other end of the path
};

/// A vertex from which a subpath continues. The nominal numbers of children may differ for delta
/// events: when camera subpaths end at the first non-specular vertex, they still go on through its
/// delta lobes.
template <Bsdf B>
struct ScatteringVertex {
  using T = ScalarOf<typename B::Spectrum>;
  const B& bsdf;                      ///< must outlive this, as the point and `to_prev` must
  const SurfacePoint<T>& point;       ///< position and normals of the surface here
  const Vec3<T>& to_prev;             ///< unit direction to the vertex before
  TransportMode mode;                 ///< radiance on camera, importance on light subpaths
  T survival;                         ///< continuation probability of Russian roulette
  NominalChildren<T> children;        ///< c for a non-delta event
  NominalChildren<T> delta_children;  ///< c for a delta event
};

/// Draws one child from the mixture of all lobes, after Russian roulette. Returns nothing when the
/// subpath is terminated or the BSDF makes no sample. `needs_reverse`: reverse densities are read.
template <bool needs_reverse = true, Bsdf B>
[[nodiscard]] GMIS_ALWAYS_INLINE inline std::optional<Step<typename B::Spectrum>> scatter(const ScatteringVertex<B>& at,
                                                                                          UniformSource auto& source) {
  using T = ScalarOf<typename B::Spectrum>;
  const auto [u_survival, u_lobe, u, v] = uniforms<T, 4>(source);
  if (u_survival >= at.survival) return std::nullopt;
  const auto sample = sample_bsdf<needs_reverse>(at.bsdf, at.to_prev, u_lobe, Vec2<T>{u, v}, at.mode);
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
  // The two delta functions: selection probability · |cos| · index², here relative to the index on
  // the side of `to_prev`.
  const T cos_prev = std::abs(glm::dot(point.shading_normal, at.to_prev));
  return Step<typename B::Spectrum>{sample->to_next, weight,
                                    at.delta_children.forward * forward * cos_next * square(sample->eta),
                                    at.delta_children.reverse * reverse * cos_prev, true};
}

}  // namespace gmis
