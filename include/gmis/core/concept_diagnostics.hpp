#pragma once

#include <concepts>
#include <type_traits>

#include "gmis/core/concepts.hpp"
#include "gmis/core/missing_members.hpp"
#include "gmis/core/random.hpp"

/// \file
/// Short messages for types that do not meet a concept. `static_assert(gmis::IsBsdf<MyBsdf>())`
/// holds where `gmis::Bsdf<MyBsdf>` does. Where it does not, the first line of the compiler's
/// message names the type and the first member that it lacks (`gmis::bsdf_lacks::sample<MyBsdf>`),
/// and the note quotes the declaration that is wanted. A member with other arguments or another
/// result counts as missing.

namespace gmis {

/// \cond
namespace detail {
template <class Missing>
using Verdict = std::type_identity<Missing>;
using Met = Verdict<std::true_type>;

template <class S>
consteval auto spectrum_verdict() {
  if constexpr (Spectrum<S>) {
    return Met();
  } else if constexpr (!std::copyable<S>) {
    return Verdict<spectrum_lacks::copies<S>>();
  } else if constexpr (!requires(const S& s) {
                         typename ScalarOf<S>;
                         { SpectrumTraits<S>::channel(s, 0) } -> std::convertible_to<ScalarOf<S>>;
                       }) {
    return Verdict<spectrum_lacks::traits<S>>();
  } else if constexpr (!requires(const S& s) {
                         { s + s } -> std::convertible_to<S>;
                       }) {
    return Verdict<spectrum_lacks::sum<S>>();
  } else if constexpr (!requires(const S& s, S m) { m += s; }) {
    return Verdict<spectrum_lacks::addition<S>>();
  } else if constexpr (!requires(const S& s) {
                         { s* s } -> std::convertible_to<S>;
                       }) {
    return Verdict<spectrum_lacks::product<S>>();
  } else if constexpr (!requires(const S& s, ScalarOf<S> scalar) {
                         { s* scalar } -> std::convertible_to<S>;
                       }) {
    return Verdict<spectrum_lacks::scaling<S>>();
  } else {
    return Verdict<spectrum_lacks::from_scalar<S>>();
  }
}

template <class B>
consteval auto bsdf_verdict() {
  if constexpr (Bsdf<B>) {
    return Met();
  } else if constexpr (!std::copyable<B>) {
    return Verdict<bsdf_lacks::copies<B>>();
  } else if constexpr (!requires { typename B::Spectrum; }) {
    return Verdict<bsdf_lacks::Spectrum<B>>();
  } else if constexpr (!Spectrum<typename B::Spectrum>) {
    return spectrum_verdict<typename B::Spectrum>();
  } else {
    using S = typename B::Spectrum;
    using T = ScalarOf<S>;
    using V = Vec3<T>;
    if constexpr (!requires(const B& b, V w, TransportMode mode) {
                    { b.evaluate(w, w, mode) } -> std::same_as<BsdfValue<S>>;
                  })
      return Verdict<bsdf_lacks::evaluate<B>>();
    else if constexpr (!requires(const B& b, V w, T u, Vec2<T> uv, TransportMode mode) {
                         { b.sample(w, u, uv, mode) } -> std::same_as<std::optional<ScatterSample<S>>>;
                       })
      return Verdict<bsdf_lacks::sample<B>>();
    else if constexpr (!requires(const B& b) {
                         { b.is_purely_delta() } -> std::same_as<bool>;
                       })
      return Verdict<bsdf_lacks::is_purely_delta<B>>();
    else
      return Verdict<bsdf_lacks::albedo<B>>();
  }
}

template <class B>
consteval auto lobes_verdict() {
  if constexpr (BsdfWithLobes<B>) {
    return Met();
  } else if constexpr (!Bsdf<B>) {
    return bsdf_verdict<B>();
  } else {
    using T = ScalarOf<typename B::Spectrum>;
    using V = Vec3<T>;
    if constexpr (!requires {
                    { B::max_lobes } -> std::convertible_to<int>;
                  })
      return Verdict<bsdf_lacks::max_lobes<B>>();
    else if constexpr (!requires(const B& b) {
                         { b.lobe_count() } -> std::convertible_to<int>;
                       })
      return Verdict<bsdf_lacks::lobe_count<B>>();
    else if constexpr (!requires(const B& b) {
                         { b.lobe_weight(0) } -> std::convertible_to<T>;
                       })
      return Verdict<bsdf_lacks::lobe_weight<B>>();
    else if constexpr (!requires(const B& b, V w, Vec2<T> uv, TransportMode mode) {
                         { b.sample_lobe(0, w, uv, mode) } -> std::same_as<std::optional<V>>;
                       })
      return Verdict<bsdf_lacks::sample_lobe<B>>();
    else if constexpr (!requires(const B& b, V w, T* pdfs) { b.lobe_pdfs(w, w, pdfs); })
      return Verdict<bsdf_lacks::lobe_pdfs<B>>();
    else if constexpr (!requires(const B& b) {
                         { b.has_delta_lobes() } -> std::same_as<bool>;
                       })
      return Verdict<bsdf_lacks::has_delta_lobes<B>>();
    else
      return Verdict<bsdf_lacks::lobes_have_full_support<B>>();
  }
}

template <class L>
consteval auto light_verdict() {
  if constexpr (Light<L>) {
    return Met();
  } else if constexpr (!requires { typename L::Spectrum; }) {
    return Verdict<light_lacks::Spectrum<L>>();
  } else if constexpr (!Spectrum<typename L::Spectrum>) {
    return spectrum_verdict<typename L::Spectrum>();
  } else {
    using S = typename L::Spectrum;
    using T = ScalarOf<S>;
    using Point = SurfacePoint<T>;
    if constexpr (!requires(const L& light) {
                    { light.is_delta() } -> std::same_as<bool>;
                  })
      return Verdict<light_lacks::is_delta<L>>();
    else if constexpr (!requires(const L& light) {
                         { light.is_infinite() } -> std::same_as<bool>;
                       })
      return Verdict<light_lacks::is_infinite<L>>();
    else if constexpr (!requires(const L& light, Point from, Vec2<T> uv) {
                         { light.sample_next_event(from, uv) } -> std::same_as<std::optional<NextEventSample<S>>>;
                       })
      return Verdict<light_lacks::sample_next_event<L>>();
    else if constexpr (!requires(const L& light, Vec2<T> uv) {
                         { light.sample_emission(uv, uv) } -> std::same_as<std::optional<EmissionSample<S>>>;
                       })
      return Verdict<light_lacks::sample_emission<L>>();
    else if constexpr (!requires(const L& light, Point origin, Vec3<T> w) {
                         { light.emitted(origin, w) } -> std::same_as<Emitted<S>>;
                       })
      return Verdict<light_lacks::emitted<L>>();
    else
      return Verdict<light_lacks::next_event_density<L>>();
  }
}

template <class C>
consteval auto camera_verdict() {
  if constexpr (Camera<C>) {
    return Met();
  } else if constexpr (!requires { typename C::Spectrum; }) {
    return Verdict<camera_lacks::Spectrum<C>>();
  } else if constexpr (!Spectrum<typename C::Spectrum>) {
    return spectrum_verdict<typename C::Spectrum>();
  } else {
    using S = typename C::Spectrum;
    using T = ScalarOf<S>;
    if constexpr (!requires(const C& camera) {
                    { camera.resolution() } -> std::convertible_to<glm::ivec2>;
                  })
      return Verdict<camera_lacks::resolution<C>>();
    else if constexpr (!requires(const C& camera, glm::ivec2 pixel, Vec2<T> uv) {
                         { camera.sample_ray(pixel, uv, uv) } -> std::same_as<std::optional<CameraSample<S>>>;
                       })
      return Verdict<camera_lacks::sample_ray<C>>();
    else if constexpr (!requires(const C& camera, Vec3<T> point, Vec2<T> uv) {
                         { camera.project(point, uv) } -> std::same_as<std::optional<CameraProjection<S>>>;
                       })
      return Verdict<camera_lacks::project<C>>();
    else
      return Verdict<camera_lacks::has_parallel_rays<C>>();
  }
}

template <class S>
consteval auto scene_verdict() {
  if constexpr (Scene<S>) {
    return Met();
  } else if constexpr (!requires { typename S::Spectrum; }) {
    return Verdict<scene_lacks::Spectrum<S>>();
  } else if constexpr (!Spectrum<typename S::Spectrum>) {
    return spectrum_verdict<typename S::Spectrum>();
  } else if constexpr (!requires { typename S::Bsdf; }) {
    return Verdict<scene_lacks::Bsdf<S>>();
  } else if constexpr (!Bsdf<typename S::Bsdf>) {
    return bsdf_verdict<typename S::Bsdf>();
  } else if constexpr (!requires { typename S::Light; }) {
    return Verdict<scene_lacks::Light<S>>();
  } else if constexpr (!Light<typename S::Light>) {
    return light_verdict<typename S::Light>();
  } else if constexpr (!requires { typename S::Camera; }) {
    return Verdict<scene_lacks::Camera<S>>();
  } else if constexpr (!Camera<typename S::Camera>) {
    return camera_verdict<typename S::Camera>();
  } else if constexpr (!OneSpectrum<S>) {
    return Verdict<scene_lacks::one_spectrum<S>>();
  } else {
    using T = ScalarOf<typename S::Spectrum>;
    using L = typename S::Light;
    if constexpr (!requires(const S& scene, Ray<T> ray) {
                    { scene.intersect(ray) } -> std::same_as<std::optional<Hit<T, typename S::Bsdf, L>>>;
                  })
      return Verdict<scene_lacks::intersect<S>>();
    else if constexpr (!requires(const S& scene, Ray<T> ray) {
                         { scene.visible(ray) } -> std::same_as<bool>;
                       })
      return Verdict<scene_lacks::visible<S>>();
    else if constexpr (!requires(const S& scene, T u) {
                         { scene.sample_light(u) } -> std::same_as<LightChoice<T, L>>;
                       })
      return Verdict<scene_lacks::sample_light<S>>();
    else if constexpr (!requires(const S& scene, const L& light) {
                         { scene.selection_probability(light) } -> std::same_as<T>;
                       })
      return Verdict<scene_lacks::selection_probability<S>>();
    else if constexpr (!requires(const S& scene) {
                         { *scene.infinite_lights().begin() } -> std::convertible_to<const L*>;
                         scene.infinite_lights().end();
                       })
      return Verdict<scene_lacks::infinite_lights<S>>();
    else
      return Verdict<scene_lacks::camera<S>>();
  }
}

template <class E>
consteval auto executor_verdict() {
  if constexpr (Executor<E>)
    return Met();
  else
    return Verdict<executor_lacks::parallel_for<E>>();
}

template <class S>
consteval auto source_verdict() {
  if constexpr (UniformSource<S>) {
    return Met();
  } else if constexpr (!requires(S & source) {
                         { source() } -> std::unsigned_integral;
                       }) {
    return Verdict<source_lacks::call<S>>();
  } else if constexpr (!requires {
                         { S::min() } -> std::same_as<std::invoke_result_t<S&>>;
                       }) {
    return Verdict<source_lacks::min<S>>();
  } else {
    return Verdict<source_lacks::max<S>>();
  }
}

}  // namespace detail
/// \endcond

/// `IsBsdf<B>()` is true where `gmis::Bsdf<B>` holds; else the compiler's first line names what is
/// missing.
template <class B>
using IsBsdf = typename decltype(detail::bsdf_verdict<B>())::type;
/// `IsBsdf`, but for `gmis::BsdfWithLobes<B>`.
template <class B>
using IsBsdfWithLobes = typename decltype(detail::lobes_verdict<B>())::type;
/// `IsBsdf`, but for `gmis::Light<L>`.
template <class L>
using IsLight = typename decltype(detail::light_verdict<L>())::type;
/// `IsBsdf`, but for `gmis::Camera<C>`.
template <class C>
using IsCamera = typename decltype(detail::camera_verdict<C>())::type;
/// `IsBsdf`, but for `gmis::Scene<S>` and for the types that the scene names.
template <class S>
using IsScene = typename decltype(detail::scene_verdict<S>())::type;
/// `IsBsdf`, but for `gmis::Executor<E>`.
template <class E>
using IsExecutor = typename decltype(detail::executor_verdict<E>())::type;
/// `IsBsdf`, but for `gmis::UniformSource<S>`.
template <class S>
using IsUniformSource = typename decltype(detail::source_verdict<S>())::type;

}  // namespace gmis
