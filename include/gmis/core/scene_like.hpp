#pragma once

#include "gmis/core/effects.hpp"
#include "gmis/core/light_choice.hpp"
#include "gmis/core/light_groups.hpp"
#include "gmis/core/transmittance.hpp"

namespace gmis {

/// Base of scene decorators: forwards every member to a scene, which must outlive it.
template <Scene Sc>
class SceneLike {
 public:
  using Spectrum = typename Sc::Spectrum;
  using T = ScalarOf<Spectrum>;
  using Bsdf = typename Sc::Bsdf;
  using Light = typename Sc::Light;
  using Camera = typename Sc::Camera;

  /// `scene` must outlive this.
  explicit SceneLike(const Sc& scene) : scene_(scene) {}

  /// The scene that members are forwarded to.
  [[nodiscard]] const Sc& own() const noexcept { return scene_; }

  // The members of the scene.
  /// The first hit of `ray` with the scene.
  [[nodiscard]] auto intersect(const Ray<T>& ray) const { return scene_.intersect(ray); }
  [[nodiscard]] bool visible(const Ray<T>& ray) const { return scene_.visible(ray); }
  [[nodiscard]] LightChoice<T, Light> sample_light(T u) const { return scene_.sample_light(u); }
  [[nodiscard]] T selection_probability(const Light& light) const { return scene_.selection_probability(light); }
  [[nodiscard]] LightChoice<T, Light> sample_light(const SurfacePoint<T>& from,
                                                   T u) const requires SceneWithReceiverChoice<Sc> {
    return scene_.sample_light(from, u);
  }
  [[nodiscard]] T selection_probability(const Light& light,
                                        const SurfacePoint<T>& from) const requires SceneWithReceiverChoice<Sc> {
    return scene_.selection_probability(light, from);
  }
  /// The runs that use the choice for the receiver.
  [[nodiscard]] ReceiverChoice receiver_choice() const requires SceneWithOptionalReceiverChoice<Sc> {
    return scene_.receiver_choice();
  }
  [[nodiscard]] decltype(auto) infinite_lights() const { return scene_.infinite_lights(); }
  /// The group of the light, for pictures by light.
  [[nodiscard]] std::uint16_t light_group(const Light& light) const requires SceneWithLightGroups<Sc> {
    return scene_.light_group(light);
  }
  [[nodiscard]] const Camera& camera() const { return scene_.camera(); }
  /// The effects that the scene states, where it states them.
  [[nodiscard]] Effects effects() const requires SceneWithEffects<Sc> { return scene_.effects(); }
  /// False when the scene promises that its transmittance is 1 along every segment.
  [[nodiscard]] bool has_absorption() const requires SceneWithAbsorption<Sc> { return scene_.has_absorption(); }
  /// Transmittance of the scene along `ray`, per channel, from 0 to `t_max`.
  [[nodiscard]] Spectrum transmittance(const Ray<T>& ray) const
      requires(SceneWithAbsorption<Sc> && !SceneWithAbsorptionBetween<Sc>) {
    return scene_.transmittance(ray);
  }
  /// Transmittance along `ray` from one point to another, per channel.
  [[nodiscard]] Spectrum transmittance(const Ray<T>& ray, const SurfacePoint<T>& from,
                                       const SurfacePoint<T>& to) const requires SceneWithAbsorptionBetween<Sc> {
    return scene_.transmittance(ray, from, to);
  }

 private:
  const Sc& scene_;
};

}  // namespace gmis
