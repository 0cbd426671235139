#pragma once

#include <optional>

#include "gmis/core/effects.hpp"
#include "gmis/core/light_choice.hpp"
#include "gmis/core/transmittance.hpp"
#include "gmis/transport/guiding/direction_guide.hpp"
#include "gmis/transport/guiding/guided_bsdf.hpp"

namespace gmis {

/// Hands out one more lobe for each surface point: `guide.lobe_at(point, bsdf)` is a function of the surface point alone. It is
/// not asked where the BSDF is purely delta.
template <class G, class Sc>
concept LobeSource = Scene<Sc> && DirectionLobe<typename G::Lobe, ScalarOf<typename Sc::Spectrum>> &&
    requires(const G& guide, const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& point,
             const typename Sc::Bsdf& bsdf) {
  { guide.lobe_at(point, bsdf) } -> std::same_as<typename G::Lobe>;
};

/// A scene like another one, with guided BSDFs: meets `gmis::Scene`, so that every integrator renders it. Both the scene and
/// the guide must outlive it, and the guide must not change. With an empty guide its pictures have the bits of the scene's own.
template <Scene Sc, LobeSource<Sc> Guide = DirectionGuide<ScalarOf<typename Sc::Spectrum>>>
class GuidedScene {
 public:
  using Spectrum = typename Sc::Spectrum;
  using T = ScalarOf<Spectrum>;
  using Bsdf = Guided<typename Sc::Bsdf, typename Guide::Lobe>;
  using Light = typename Sc::Light;
  using Camera = typename Sc::Camera;
  /// What `intersect` finds.
  using Hit = gmis::Hit<T, Bsdf, Light>;

  /// Both must outlive this.
  GuidedScene(const Sc& scene, const Guide& guide) : scene_(scene), guide_(guide) {}

  /// The scene without the guide.
  [[nodiscard]] const Sc& own() const noexcept { return scene_; }

  [[nodiscard]] std::optional<Hit> intersect(const Ray<T>& ray) const {
    const auto hit = scene_.intersect(ray);
    if (!hit) return std::nullopt;
    using Lobe = typename Guide::Lobe;
    const Lobe lobe = hit->bsdf.is_purely_delta() ? Lobe() : guide_.lobe_at(hit->point, hit->bsdf);
    return Hit{hit->point, Bsdf(hit->bsdf, hit->point.shading_normal, lobe), hit->light};
  }
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
  [[nodiscard]] decltype(auto) infinite_lights() const { return scene_.infinite_lights(); }
  [[nodiscard]] const Camera& camera() const { return scene_.camera(); }
  /// Those of the scene, like all that follows.
  [[nodiscard]] Effects effects() const requires SceneWithEffects<Sc> { return scene_.effects(); }
  /// As the scene says.
  [[nodiscard]] bool has_absorption() const requires SceneWithAbsorption<Sc> { return scene_.has_absorption(); }
  /// As in the scene.
  [[nodiscard]] Spectrum transmittance(const Ray<T>& ray) const requires SceneWithAbsorption<Sc> {
    return scene_.transmittance(ray);
  }

 private:
  const Sc& scene_;
  const Guide& guide_;
};

}  // namespace gmis
