#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <utility>

#include "gmis/core/interaction.hpp"

/// \file
/// The interface that a renderer supplies. Put `static_assert(gmis::IsBsdf<MyBsdf>())` (and so on,
/// core/concept_diagnostics.hpp) beside your type: the compiler's first line then names the member
/// that it lacks. Directions, units and the values that members return are described in
/// core/interaction.hpp; the arguments `u` and `uv` are uniform on [0, 1).

namespace gmis {

/// How a surface scatters at one point. The object holds all data that it needs. It is copied into
/// the vertices of light subpaths, so keep it small.
///
/// - `evaluate(to_prev, to_next, mode)`: f [1/sr] without the cosine, and both densities per
///   steradian; delta lobes count as zero.
/// - `sample(to_prev, u, uv, mode)`: a direction, with `u` free to choose a lobe; nothing when no
///   light is scattered.
/// - `is_purely_delta()`: `evaluate` is zero everywhere, so that connections and merging are
///   impossible here.
/// - `albedo()`: approximate share of the light that is scattered, a function of the surface point
///   alone. Russian roulette takes its continuation probability from the largest channel; 0 ends
///   subpaths of both kinds.
template <class B>
concept Bsdf = std::copyable<B> && requires {
  typename B::Spectrum;
  requires Spectrum<typename B::Spectrum>;
} && requires(const B& bsdf, Vec3<ScalarOf<typename B::Spectrum>> w, ScalarOf<typename B::Spectrum> u,
              Vec2<ScalarOf<typename B::Spectrum>> uv, TransportMode mode) {
  { bsdf.evaluate(w, w, mode) } -> std::same_as<BsdfValue<typename B::Spectrum>>;
  { bsdf.sample(w, u, uv, mode) } -> std::same_as<std::optional<ScatterSample<typename B::Spectrum>>>;
  { bsdf.is_purely_delta() } -> std::same_as<bool>;
  { bsdf.albedo() } -> std::convertible_to<typename B::Spectrum>;
};

/// A BSDF that offers its non-delta lobes as separate proposals, so that one vertex can draw from
/// several lobes.
///
/// - `B::max_lobes`: the greatest number of lobes of any point, a constant expression.
/// - `lobe_count()`: the number of non-delta lobes at this point; 0 on a purely delta surface.
/// - `lobe_weight(k)`: α_k, which sums to one over the lobes. It is the probability with which
///   `sample` chooses lobe k, given that it chooses no delta lobe. Where that probability depends
///   on the directions (Fresnel), α_k is a fixed share; the densities of `sample` then come from
///   `evaluate` alone.
/// - `sample_lobe(k, to_prev, uv, mode)`: a direction from lobe k alone; nothing when the direction
///   goes under the surface.
/// - `lobe_pdfs(to_prev, to_next, pdfs)`: writes the density of every lobe at `to_next`, per
///   steradian, to `pdfs`. A BSDF whose lobes depend on the transport mode takes `mode` as a last
///   argument, with a default.
/// - `has_delta_lobes()`: `sample` may also choose a delta lobe here. Children are then drawn by
///   `sample` alone.
/// - `lobes_have_full_support()`: every lobe has a positive density wherever f is not zero.
template <class B>
concept BsdfWithLobes = Bsdf<B> &&
    requires(const B& bsdf, int k, Vec3<ScalarOf<typename B::Spectrum>> w, Vec2<ScalarOf<typename B::Spectrum>> uv,
             TransportMode mode, ScalarOf<typename B::Spectrum>* pdfs) {
  { B::max_lobes } -> std::convertible_to<int>;
  { bsdf.lobe_count() } -> std::convertible_to<int>;
  { bsdf.lobe_weight(k) } -> std::convertible_to<ScalarOf<typename B::Spectrum>>;
  { bsdf.sample_lobe(k, w, uv, mode) } -> std::same_as<std::optional<Vec3<ScalarOf<typename B::Spectrum>>>>;
  {bsdf.lobe_pdfs(w, w, pdfs)};
  { bsdf.has_delta_lobes() } -> std::same_as<bool>;
  { bsdf.lobes_have_full_support() } -> std::same_as<bool>;
};

/// A BSDF with the optional member `has_narrow_lobe()`: true when the surface has a lobe that is
/// delta or narrower than `narrow_roughness` (core/effects.hpp). It is a function of the surface
/// point alone.
template <class B>
concept BsdfWithNarrowLobes = Bsdf<B> && requires(const B& bsdf) {
  { bsdf.has_narrow_lobe() } -> std::same_as<bool>;
};

/// `bsdf.has_narrow_lobe()`, or true for a BSDF without this member. A local count of merging
/// (docs/weights.md) is right with any answer; an answer of true without need costs time.
template <Bsdf B>
[[nodiscard]] constexpr bool has_narrow_lobe(const B& bsdf) noexcept {
  if constexpr (BsdfWithNarrowLobes<B>)
    return bsdf.has_narrow_lobe();
  else
    return true;
}

/// A BSDF with the optional type `Compact`: what it holds beside the normals of its `SurfacePoint`,
/// so that a light vertex need not keep them twice. `bsdf.compact()` gives it, `B(compact, point)`
/// is the BSDF again; it must not read `point.tag`. `Compact::Whole` is `B` itself, so that a class
/// derived from `B` is not mistaken for it.
template <class B>
concept BsdfWithCompactForm = Bsdf<B> && std::same_as<typename B::Compact::Whole, B> &&
    requires(const B& bsdf, const SurfacePoint<ScalarOf<typename B::Spectrum>>& point) {
  { bsdf.compact() } -> std::same_as<typename B::Compact>;
  {B(bsdf.compact(), point)};
};

/// `bsdf.evaluate(…)` and `bsdf.sample(…)`, or with `needs_reverse` false the optional members
/// `evaluate_forward` and `sample_forward` with the same arguments and results, where a BSDF has
/// them: their reverse densities are not read, so they need not be computed. Path tracing calls
/// these.
template <bool needs_reverse, Bsdf B, class V>
[[nodiscard]] constexpr auto evaluate_bsdf(const B& bsdf, const V& to_prev, const V& to_next, TransportMode mode) {
  if constexpr (!needs_reverse && requires { bsdf.evaluate_forward(to_prev, to_next, mode); })
    return bsdf.evaluate_forward(to_prev, to_next, mode);
  else
    return bsdf.evaluate(to_prev, to_next, mode);
}
/// `bsdf.sample(…)`, or with `needs_reverse` false `sample_forward`: see `evaluate_bsdf`.
template <bool needs_reverse, Bsdf B, class V, std::floating_point T>
[[nodiscard]] constexpr auto sample_bsdf(const B& bsdf, const V& to_prev, T u, const Vec2<T>& uv, TransportMode mode) {
  if constexpr (!needs_reverse && requires { bsdf.sample_forward(to_prev, u, uv, mode); })
    return bsdf.sample_forward(to_prev, u, uv, mode);
  else
    return bsdf.sample(to_prev, u, uv, mode);
}

/// `bsdf.reflects_only()`, an optional member, or false for a BSDF without it. True promises that
/// `evaluate` is zero unless the cosines of both directions with the shading normal have one sign.
/// Connections that would be zero then end before the BSDF is evaluated.
template <Bsdf B>
[[nodiscard]] constexpr bool reflects_only(const B& bsdf) noexcept {
  if constexpr (requires {
                  { bsdf.reflects_only() } -> std::same_as<bool>;
                })
    return bsdf.reflects_only();
  else
    return false;
}

/// A light source. No density includes the probability of choosing this light.
///
/// - `is_delta()`: no ray can hit the light (point, spot, directional).
/// - `is_infinite()`: the light has directions but no position (directional, environment).
/// - `sample_next_event(from, uv)`: a sample of the light that arrives at `from`; nothing when no
///   light arrives.
/// - `sample_emission(uv_origin, uv_direction)`: the start of a light subpath, with the point made
///   from `uv_origin` and the direction from `uv_direction`; nothing when the sample fails.
/// - `emitted(origin, direction)`: the radiance that leaves `origin` along `direction`, and the
///   densities with which `sample_emission` makes this start; all 0 for a delta light, which no ray
///   hits. An infinite light ignores `origin`; `direction` is the one in which its light
///   propagates, into the scene.
/// - `next_event_density(origin, direction, from)`: the density with which
///   `sample_next_event(from, …)` makes `origin` (for an infinite light: the direction), in the
///   measure of `EmissionDensity::origin`; 1 for a delta light.
template <class L>
concept Light = requires {
  typename L::Spectrum;
  requires Spectrum<typename L::Spectrum>;
}
&&requires(const L& light, SurfacePoint<ScalarOf<typename L::Spectrum>> point, Vec3<ScalarOf<typename L::Spectrum>> w,
           Vec2<ScalarOf<typename L::Spectrum>> uv) {
  { light.is_delta() } -> std::same_as<bool>;
  { light.is_infinite() } -> std::same_as<bool>;
  { light.sample_next_event(point, uv) } -> std::same_as<std::optional<NextEventSample<typename L::Spectrum>>>;
  { light.sample_emission(uv, uv) } -> std::same_as<std::optional<EmissionSample<typename L::Spectrum>>>;
  { light.emitted(point, w) } -> std::same_as<Emitted<typename L::Spectrum>>;
  { light.next_event_density(point, w, point) } -> std::same_as<ScalarOf<typename L::Spectrum>>;
};

/// A camera.
///
/// - `resolution()`: width and height in pixels.
/// - `sample_ray(pixel, uv_pixel, uv_lens)`: a ray through a pixel (x to the right, y *down*, from
///   the upper left); nothing when the sample fails.
/// - `project(point, uv_lens)`: the pixel that sees `point`, without a test of visibility; nothing
///   when no pixel does.
/// - `has_parallel_rays()`: densities are per area perpendicular to the rays, not per steradian.
/// - `has_lens()`, optional: false when `uv_lens` is not read. No numbers are then drawn for it.
/// - `filter_radius()`, optional: the reach of a reconstruction filter h in pixels; without it 0.5,
///   a box. A wider filter follows this rule: `sample_ray` draws the point x of the film with the
///   density h(x − c_p), c_p the centre of its pixel; `project` returns pixel p with the
///   probability h(x − c_p) / H(x), H(x) = Σ_p h(x − c_p) over the pixels inside and outside of the
///   picture (`uv_lens` may choose it), and nothing for a pixel outside; both state H(x) times the
///   density of a box. The factor h / H is then common to all techniques, and cancels in their
///   weights.
template <class C>
concept Camera = requires {
  typename C::Spectrum;
  requires Spectrum<typename C::Spectrum>;
}
&&requires(const C& camera, glm::ivec2 pixel, Vec3<ScalarOf<typename C::Spectrum>> point,
           Vec2<ScalarOf<typename C::Spectrum>> uv) {
  { camera.resolution() } -> std::convertible_to<glm::ivec2>;
  { camera.sample_ray(pixel, uv, uv) } -> std::same_as<std::optional<CameraSample<typename C::Spectrum>>>;
  { camera.project(point, uv) } -> std::same_as<std::optional<CameraProjection<typename C::Spectrum>>>;
  { camera.has_parallel_rays() } -> std::same_as<bool>;
};

/// `camera.filter_radius()`, or 0.5 for a camera without it.
template <Camera C>
[[nodiscard]] constexpr double filter_radius_of(const C& camera) noexcept {
  if constexpr (requires {
                  { camera.filter_radius() } -> std::convertible_to<double>;
                })
    return static_cast<double>(camera.filter_radius());
  else
    return 0.5;
}

/// False when the camera says that it has no lens.
template <Camera C>
[[nodiscard]] constexpr bool reads_lens_numbers(const C& camera) noexcept {
  if constexpr (requires {
                  { camera.has_lens() } -> std::same_as<bool>;
                })
    return camera.has_lens();
  else
    return true;
}

namespace detail {
template <class S>
concept OneSpectrum = std::same_as<typename S::Bsdf::Spectrum, typename S::Spectrum> &&
    std::same_as<typename S::Light::Spectrum, typename S::Spectrum> &&
    std::same_as<typename S::Camera::Spectrum, typename S::Spectrum>;
}  // namespace detail

/// Everything that the engine requires of a scene. Its BSDF, light and camera have its spectrum.
///
/// - `intersect(ray)`: the nearest hit with 0 < t < t_max, or nothing.
/// - `visible(ray)`: true when nothing blocks 0 < t < t_max.
/// - `sample_light(u)`: a light, chosen with a probability that does not depend on the receiver; a
///   null light when the scene has none.
/// - `selection_probability(light)`: the probability with which `sample_light` chooses this light.
/// - `sample_light(from, u)`, `selection_probability(light, from)`, optional: the choice of next
///   events at the surface point `from` (`SceneWithReceiverChoice`, core/light_choice.hpp).
/// - `infinite_lights()`: a range of `const Light*` with the infinite lights, which rays that leave
///   the scene hit. Delta lights may be left out.
/// - `camera()`: the camera.
template <class S>
concept Scene = requires {
  typename S::Spectrum;
  typename S::Bsdf;
  typename S::Light;
  typename S::Camera;
}
&&Spectrum<typename S::Spectrum>&& Bsdf<typename S::Bsdf>&& Light<typename S::Light>&& Camera<typename S::Camera>&&
    detail::OneSpectrum<S>&& requires(const S& scene, Ray<ScalarOf<typename S::Spectrum>> ray,
                                      ScalarOf<typename S::Spectrum> u, const typename S::Light& light) {
  {
    scene.intersect(ray)
    } -> std::same_as<std::optional<Hit<ScalarOf<typename S::Spectrum>, typename S::Bsdf, typename S::Light>>>;
  { scene.visible(ray) } -> std::same_as<bool>;
  { scene.sample_light(u) } -> std::same_as<LightChoice<ScalarOf<typename S::Spectrum>, typename S::Light>>;
  { scene.selection_probability(light) } -> std::same_as<ScalarOf<typename S::Spectrum>>;
  { *scene.infinite_lights().begin() } -> std::convertible_to<const typename S::Light*>;
  {scene.infinite_lights().end()};
  { scene.camera() } -> std::convertible_to<const typename S::Camera&>;
};

namespace detail {
/// A lambda with captures, like the work that the engine passes. It does not convert to a function
/// pointer.
inline auto work_with_captures(std::size_t& sum) {
  return [&sum](std::size_t i) { sum += i; };
}
using WorkWithCaptures = decltype(work_with_captures(std::declval<std::size_t&>()));
}  // namespace detail

/// Runs loops for the engine, which never starts a thread itself. `parallel_for(count, work)` calls
/// `work(i)` once for each i from 0 to count − 1, in any order and possibly concurrently, and
/// returns when all calls are done. `work` is a temporary lambda with captures.
template <class E>
concept Executor = requires(E& executor, std::size_t count, detail::WorkWithCaptures work) {
  executor.parallel_for(count, std::move(work));
};

/// An executor that runs all work in order on the calling thread.
struct SerialExecutor {
  /// Calls `work(0)` to `work(count - 1)` in order.
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) const {
    for (std::size_t i = 0; i < count; ++i) work(i);
  }
};

}  // namespace gmis
