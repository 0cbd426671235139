#pragma once

/// \file
/// Names for what a type lacks that is to meet a concept (core/concept_diagnostics.hpp). They are
/// never defined: a compiler that has to use one names it, and quotes its line, which ends with the
/// declaration that is wanted. T stands for the scalar of the spectrum.

/// \cond
namespace gmis {

// clang-format off
namespace spectrum_lacks {
template <class S> struct traits;      // a specialisation gmis::SpectrumTraits<S>: Scalar, channel_count, channel(s, i)
template <class S> struct copies;      // copy construction and assignment
template <class S> struct sum;         // S operator+(S, S)
template <class S> struct addition;    // s += s
template <class S> struct product;     // S operator*(S, S), channel by channel
template <class S> struct scaling;     // S operator*(S, T)
template <class S> struct from_scalar; // explicit S(T): all channels alike
}
namespace bsdf_lacks {
template <class B> struct copies; // copy construction and assignment
template <class B> struct Spectrum; // using Spectrum = glm::vec3; (or another type that meets gmis::Spectrum)
template <class B>
struct evaluate; // BsdfValue<Spectrum> evaluate(Vec3<T> to_prev, Vec3<T> to_next, TransportMode) const
template <class B>
struct sample; // std::optional<ScatterSample<Spectrum>> sample(Vec3<T> to_prev, T u, Vec2<T> uv, TransportMode) const
template <class B> struct is_purely_delta; // bool is_purely_delta() const
template <class B> struct albedo; // Spectrum albedo() const
template <class B> struct max_lobes; // static constexpr int max_lobes
template <class B> struct lobe_count; // int lobe_count() const
template <class B> struct lobe_weight; // T lobe_weight(int) const
template <class B>
struct sample_lobe; // std::optional<Vec3<T>> sample_lobe(int, Vec3<T> to_prev, Vec2<T> uv, TransportMode) const
template <class B> struct lobe_pdfs; // void lobe_pdfs(Vec3<T> to_prev, Vec3<T> to_next, T* pdfs) const
template <class B> struct has_delta_lobes; // bool has_delta_lobes() const
template <class B> struct lobes_have_full_support; // bool lobes_have_full_support() const
}
namespace light_lacks {
template <class L> struct Spectrum; // using Spectrum = glm::vec3; (or another type that meets gmis::Spectrum)
template <class L> struct is_delta; // bool is_delta() const
template <class L> struct is_infinite; // bool is_infinite() const
template <class L>
struct sample_next_event; // std::optional<NextEventSample<Spectrum>> sample_next_event(SurfacePoint<T>, Vec2<T>) const
template <class L>
struct sample_emission; // std::optional<EmissionSample<Spectrum>> sample_emission(Vec2<T>, Vec2<T>) const
template <class L> struct emitted; // Emitted<Spectrum> emitted(SurfacePoint<T> origin, Vec3<T> direction) const
template <class L>
struct next_event_density; // T next_event_density(SurfacePoint<T> origin, Vec3<T>, SurfacePoint<T> from) const
}
namespace camera_lacks {
template <class C> struct Spectrum; // using Spectrum = glm::vec3; (or another type that meets gmis::Spectrum)
template <class C> struct resolution; // glm::ivec2 resolution() const
template <class C>
struct sample_ray; // std::optional<CameraSample<Spectrum>> sample_ray(glm::ivec2, Vec2<T>, Vec2<T>) const
template <class C>
struct project; // std::optional<CameraProjection<Spectrum>> project(Vec3<T> point, Vec2<T> uv_lens) const
template <class C> struct has_parallel_rays; // bool has_parallel_rays() const
}
namespace scene_lacks {
template <class S> struct Spectrum; // using Spectrum = glm::vec3; (or another type that meets gmis::Spectrum)
template <class S> struct Bsdf; // using Bsdf = …
template <class S> struct Light; // using Light = …
template <class S> struct Camera; // using Camera = …
template <class S> struct one_spectrum; // Bsdf, Light and Camera with the Spectrum of the scene
template <class S> struct intersect; // std::optional<Hit<T, Bsdf, Light>> intersect(Ray<T>) const
template <class S> struct visible; // bool visible(Ray<T>) const
template <class S> struct sample_light; // LightChoice<T, Light> sample_light(T u) const
template <class S> struct selection_probability; // T selection_probability(const Light&) const
template <class S> struct infinite_lights; // a range of const Light* infinite_lights() const
template <class S> struct camera; // const Camera& camera() const
}
namespace executor_lacks {
template <class E> struct parallel_for; // template <class Work> void parallel_for(std::size_t count, Work&& work)
}
namespace source_lacks {
template <class S> struct call; // result_type operator()(), with an unsigned result_type
template <class S> struct min;  // static constexpr result_type min()
template <class S> struct max;  // static constexpr result_type max(), above min()
}
// clang-format on

}  // namespace gmis
/// \endcond
