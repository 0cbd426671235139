#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>

#include "gmis/core/light_choice.hpp"
#include "gmis/core/scene_like.hpp"
#include "gmis/transport/lights/light_table.hpp"

namespace gmis {

/// A scene like another one, in which next events choose their light by a `LightTable` with the share that the table has at the
/// receiver, and as the scene does otherwise. Meets `gmis::Scene` and `SceneWithReceiverChoice`, so that every integrator renders it,
/// with right weights. Lights are known by their addresses, which must not change. Both the scene and the table must outlive it, and the table must not change.
/// With a table that knows nothing its pictures have the bits of the scene's own.
template <Scene Sc>
class LightTableScene : public SceneLike<Sc> {
 public:
  using T = ScalarOf<typename Sc::Spectrum>;
  using Light = typename Sc::Light;
  /// The table of this scene's lights.
  using Table = LightTable<T, Light>;

  /// Both must outlive this.
  LightTableScene(const Sc& scene, const Table& table) : SceneLike<Sc>(scene), table_(table) {}

  /// A light for a next event at `from`. `u` is uniform in [0, 1); what is left of it after the choice of the way chooses the light.
  [[nodiscard]] LightChoice<T, Light> sample_light(const SurfacePoint<T>& from, T u) const {
    const std::size_t cell = table_.cell(from.position, from.geometric_normal);
    const T share = table_.share(cell);
    if (share == T(0)) return sample_light_for(this->own(), from, u);
    if (u < share) {
      const Light* const light = table_.sample(cell, std::min(u / share, below_one));
      return {light, mixed(share, cell, *light, from)};
    }
    LightChoice<T, Light> choice =
        sample_light_for(this->own(), from, std::min((u - share) / (T(1) - share), below_one));
    if (choice.light != nullptr) choice.selection_probability = mixed(share, cell, *choice.light, from);
    return choice;
  }
  /// The probability with which `sample_light(from, u)` chooses `light`: positive wherever the scene's own is.
  [[nodiscard]] T selection_probability(const Light& light, const SurfacePoint<T>& from) const {
    const std::size_t cell = table_.cell(from.position, from.geometric_normal);
    return mixed(table_.share(cell), cell, light, from);
  }

  // Light subpaths choose as in the scene. A using-declaration would bring its choice for a receiver along.
  [[nodiscard]] LightChoice<T, Light> sample_light(T u) const { return this->own().sample_light(u); }
  [[nodiscard]] T selection_probability(const Light& light) const { return this->own().selection_probability(light); }

 private:
  static constexpr T below_one = T(1) - std::numeric_limits<T>::epsilon() / T(2);

  [[nodiscard]] T own_probability(const Light& light, const SurfacePoint<T>& from) const {
    if constexpr (chooses_for_receiver<Sc>())
      return this->own().selection_probability(light, from);
    else
      return this->own().selection_probability(light);
  }
  [[nodiscard]] T mixed(T share, std::size_t cell, const Light& light, const SurfacePoint<T>& from) const {
    const T own = own_probability(light, from);
    return share == T(0) ? own : share * table_.probability(cell, &light) + (T(1) - share) * own;
  }

  const Table& table_;
};

}  // namespace gmis
