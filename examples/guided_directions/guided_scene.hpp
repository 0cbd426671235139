#pragma once

#include <optional>

#include "gmis/core/scene_like.hpp"
#include "guided_directions/direction_guide.hpp"
#include "guided_directions/guided_bsdf.hpp"

namespace gmis {

/// Hands out one more lobe for each surface point: `guide.lobe_at(point, bsdf)` is a function of
/// the surface point alone. It is not asked where the BSDF is purely delta.
template <class G, class Sc>
concept LobeSource = Scene<Sc> && DirectionLobe<typename G::Lobe, ScalarOf<typename Sc::Spectrum>> &&
    requires(const G& guide, const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& point,
             const typename Sc::Bsdf& bsdf) {
  { guide.lobe_at(point, bsdf) } -> std::same_as<typename G::Lobe>;
};

/// Scene decorator with guided BSDFs: meets `gmis::Scene`, so that every integrator renders it.
/// Both the scene and the guide must outlive it, and the guide must not change. With an empty
/// guide its pictures are bitwise those of the scene.
template <Scene Sc, LobeSource<Sc> Guide = DirectionGuide<ScalarOf<typename Sc::Spectrum>>>
class GuidedScene : public SceneLike<Sc> {
 public:
  using T = ScalarOf<typename Sc::Spectrum>;
  using Bsdf = Guided<typename Sc::Bsdf, typename Guide::Lobe>;
  /// The hit that `intersect` finds.
  using Hit = gmis::Hit<T, Bsdf, typename Sc::Light>;

  /// Both must outlive this.
  GuidedScene(const Sc& scene, const Guide& guide) : SceneLike<Sc>(scene), guide_(guide) {}

  [[nodiscard]] std::optional<Hit> intersect(const Ray<T>& ray) const {
    const auto hit = this->own().intersect(ray);
    if (!hit) return std::nullopt;
    using Lobe = typename Guide::Lobe;
    const Lobe lobe = hit->bsdf.is_purely_delta() ? Lobe() : guide_.lobe_at(hit->point, hit->bsdf);
    return Hit{hit->point, Bsdf(hit->bsdf, hit->point.shading_normal, lobe), hit->light};
  }

 private:
  const Guide& guide_;
};

}  // namespace gmis
