#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>

#include "gmis/core/effects.hpp"
#include "gmis/core/light_choice.hpp"
#include "gmis/core/transmittance.hpp"
#include "gmis/transport/lights/light_table.hpp"

namespace gmis {

/// A scene like another one, in which next events choose their light by a `LightTable` with the share that the table has at the
/// receiver, and as the scene does otherwise. Meets `gmis::Scene` and `SceneWithReceiverChoice`, so that every integrator renders it,
/// with right weights. Lights are known by their addresses, which must not change. Both the scene and the table must outlive it, and the table must not change.
/// With a table that knows nothing its pictures have the bits of the scene's own.
template <Scene Sc>
class LightTableScene {
 public:
  using Spectrum = typename Sc::Spectrum;
  using T = ScalarOf<Spectrum>;
  using Bsdf = typename Sc::Bsdf;
  using Light = typename Sc::Light;
  using Camera = typename Sc::Camera;
  /// The table of this scene's lights.
  using Table = LightTable<T, Light>;

  /// Both must outlive this.
  LightTableScene(const Sc& scene, const Table& table) : scene_(scene), table_(table) {}

  /// The scene without the table.
  [[nodiscard]] const Sc& own() const noexcept { return scene_; }

  /// A light for a next event at `from`. `u` is uniform in [0, 1); what is left of it after the choice of the way chooses the light.
  [[nodiscard]] LightChoice<T, Light> sample_light(const SurfacePoint<T>& from, T u) const {
    const std::size_t cell = table_.cell(from.position, from.geometric_normal);
    const T share = table_.share(cell);
    if (share == T(0)) return sample_light_for(scene_, from, u);
    if (u < share) {
      const Light* const light = table_.sample(cell, std::min(u / share, below_one));
      return {light, mixed(share, cell, *light, from)};
    }
    LightChoice<T, Light> choice = sample_light_for(scene_, from, std::min((u - share) / (T(1) - share), below_one));
    if (choice.light != nullptr) choice.selection_probability = mixed(share, cell, *choice.light, from);
    return choice;
  }
  /// The probability with which `sample_light(from, u)` chooses `light`: positive wherever the scene's own is.
  [[nodiscard]] T selection_probability(const Light& light, const SurfacePoint<T>& from) const {
    const std::size_t cell = table_.cell(from.position, from.geometric_normal);
    return mixed(table_.share(cell), cell, light, from);
  }

  // The rest is the scene's own.
  [[nodiscard]] auto intersect(const Ray<T>& ray) const { return scene_.intersect(ray); }
  [[nodiscard]] bool visible(const Ray<T>& ray) const { return scene_.visible(ray); }
  [[nodiscard]] LightChoice<T, Light> sample_light(T u) const { return scene_.sample_light(u); }
  [[nodiscard]] T selection_probability(const Light& light) const { return scene_.selection_probability(light); }
  [[nodiscard]] decltype(auto) infinite_lights() const { return scene_.infinite_lights(); }
  [[nodiscard]] const Camera& camera() const { return scene_.camera(); }
  [[nodiscard]] Effects effects() const requires SceneWithEffects<Sc> { return scene_.effects(); }
  [[nodiscard]] bool has_absorption() const requires SceneWithAbsorption<Sc> { return scene_.has_absorption(); }
  [[nodiscard]] Spectrum transmittance(const Ray<T>& ray) const requires SceneWithAbsorption<Sc> {
    return scene_.transmittance(ray);
  }

 private:
  static constexpr T below_one = T(1) - std::numeric_limits<T>::epsilon() / T(2);

  [[nodiscard]] T own_probability(const Light& light, const SurfacePoint<T>& from) const {
    if constexpr (chooses_for_receiver<Sc>())
      return scene_.selection_probability(light, from);
    else
      return scene_.selection_probability(light);
  }
  [[nodiscard]] T mixed(T share, std::size_t cell, const Light& light, const SurfacePoint<T>& from) const {
    const T own = own_probability(light, from);
    return share == T(0) ? own : share * table_.probability(cell, &light) + (T(1) - share) * own;
  }

  const Sc& scene_;
  const Table& table_;
};

}  // namespace gmis
