#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <utility>

#include "gmis/core/interaction.hpp"

/// \file
/// The interface that a renderer supplies. Put `static_assert(gmis::Bsdf<MyBsdf>)` (and so on) beside a type of yours:
/// the compiler's message then quotes the line that it misses.

namespace gmis {

/// How a surface scatters at one point. Holds all it needs (copied into the vertices of light subpaths, so keep it
/// small).
///
/// - `evaluate(to_prev, to_next, mode)`: f without the cosine and both densities, per steradian; zero for delta lobes.
/// - `sample(to_prev, u, uv, mode)`: a direction, with `u` free to choose a lobe; nothing when no light goes on.
/// - `is_purely_delta()`: `evaluate` is zero everywhere: no connecting, no merging here.
/// - `albedo()`: about the share of light scattered on, a function of the surface point alone: survival in Russian
/// roulette.
template <class B>
concept Bsdf = std::copyable<B> && requires {
  typename B::Spectrum;
} && requires(const B& bsdf, Vec3<ScalarOf<typename B::Spectrum>> w, ScalarOf<typename B::Spectrum> u,
              Vec2<ScalarOf<typename B::Spectrum>> uv, TransportMode mode) {
  { bsdf.evaluate(w, w, mode) } -> std::same_as<BsdfValue<typename B::Spectrum>>;
  { bsdf.sample(w, u, uv, mode) } -> std::same_as<std::optional<ScatterSample<typename B::Spectrum>>>;
  { bsdf.is_purely_delta() } -> std::same_as<bool>;
  { bsdf.albedo() } -> std::convertible_to<typename B::Spectrum>;
};

/// A BSDF that offers its non-delta lobes as proposals of their own, so that several can be drawn from at one vertex.
///
/// - `B::max_lobes`: the most lobes that any point has, known at compile time.
/// - `lobe_count()`: here; 0 on a purely delta surface.
/// - `lobe_weight(k)`: α_k, sums to one over the lobes: what `sample` chooses by, given that it chooses no delta lobe; a
///   fixed share where that depends on the directions (Fresnel), so that only `evaluate` has the densities of `sample`.
/// - `sample_lobe(k, to_prev, uv, mode)`: a direction from lobe k alone; nothing when it goes under the surface.
/// - `lobe_pdfs(to_prev, to_next, pdfs)`: the density of every lobe at `to_next`, per steradian, all at once.
/// - `has_delta_lobes()`: `sample` may also choose a delta lobe here; then children are drawn by `sample` alone.
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

/// A source of light. All densities leave out the probability of choosing this light.
///
/// - `is_delta()`: no ray can hit it (point, directional).
/// - `is_infinite()`: it has directions and no position (directional, environment).
/// - `sample_next_event(from, uv)`: light that arrives at `from`; nothing where none can.
/// - `sample_emission(uv_origin, uv_direction)`: the start of a light subpath.
/// - `emitted(origin, direction)`: what leaves `origin` along `direction`, and the densities with which emission starts
///   this way. An infinite light ignores `origin`; its `direction` is the way the light goes, out of the sky.
/// - `next_event_density(origin, direction, from)`: with which `sample_next_event(from, …)` makes `origin` (for an
///   infinite light: the direction), in the measure of `EmissionDensity::origin`; 1 for a delta light.
template <class L>
concept Light = requires {
  typename L::Spectrum;
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

/// - `resolution()`: width and height in pixels.
/// - `sample_ray(pixel, uv_pixel, uv_lens)`: a ray through that pixel (x to the right, y *down*, from the upper left).
/// - `project(point, uv_lens)`: the pixel that sees `point`, whatever stands between; nothing when none does.
/// - `has_parallel_rays()`: densities are per area perpendicular to the rays, not per steradian.
template <class C>
concept Camera = requires {
  typename C::Spectrum;
}
&&requires(const C& camera, glm::ivec2 pixel, Vec3<ScalarOf<typename C::Spectrum>> point,
           Vec2<ScalarOf<typename C::Spectrum>> uv) {
  { camera.resolution() } -> std::convertible_to<glm::ivec2>;
  { camera.sample_ray(pixel, uv, uv) } -> std::same_as<std::optional<CameraSample<typename C::Spectrum>>>;
  { camera.project(point, uv) } -> std::same_as<std::optional<CameraProjection<typename C::Spectrum>>>;
  { camera.has_parallel_rays() } -> std::same_as<bool>;
};

/// Everything the engine asks of a scene.
///
/// - `intersect(ray)`: the nearest hit with 0 < t < t_max, or nothing.
/// - `visible(ray)`: nothing blocks 0 < t < t_max.
/// - `sample_light(u)`: a light chosen with a probability that does not depend on the receiver; a null light when there
///   is none.
/// - `selection_probability(light)`: the same probability.
/// - `infinite_lights()`: a range of `const Light*`: what rays that leave the scene may hit (delta ones may be left
///   out).
/// - `camera()`.
template <class S>
concept Scene = requires {
  typename S::Spectrum;
  typename S::Bsdf;
  typename S::Light;
  typename S::Camera;
}
&&Spectrum<typename S::Spectrum>&& Bsdf<typename S::Bsdf>&& Light<typename S::Light>&&
    Camera<typename S::Camera>&& requires(const S& scene, Ray<ScalarOf<typename S::Spectrum>> ray,
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
/// Work of the kind that the engine passes: a lambda with captures, which no function pointer can hold.
inline auto work_with_captures(std::size_t& sum) {
  return [&sum](std::size_t i) { sum += i; };
}
using WorkWithCaptures = decltype(work_with_captures(std::declval<std::size_t&>()));
}  // namespace detail

/// Runs `work(0) … work(count − 1)`, each exactly once, in any order and possibly at the same time, and returns when
/// all are done. The engine never starts a thread: whoever calls it passes one of these. `work` is a temporary lambda with
/// captures.
template <class E>
concept Executor = requires(E& executor, std::size_t count, detail::WorkWithCaptures work) {
  executor.parallel_for(count, std::move(work));
};

/// Runs everything in order on the calling thread.
struct SerialExecutor {
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) const {
    for (std::size_t i = 0; i < count; ++i) work(i);
  }
};

}  // namespace gmis
