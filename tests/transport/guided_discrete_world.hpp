#pragma once

#include "gmis/transport/guiding/guided_scene.hpp"
#include "transport/discrete_world.hpp"
#include "transport/path_oracle.hpp"

/// \file
/// A discrete world whose surfaces have one more lobe, and what the oracle is told of it.

namespace gmis_test {

/// Any probability and any density of one lobe more at a node, by the mode and the side of the shading normal. `V`: of T or
/// of long double, for the engine and for the oracle.
template <std::floating_point T>
struct DiscreteLobeLaws {
  using Atlas = DiscreteAtlas<T>;
  using V = gmis::Vec3<T>;

  [[nodiscard]] static T share(std::size_t node, bool is_front, bool is_radiance) {
    return Atlas::law(is_radiance ? 20 : 21, node, T(0.2), T(0.7)) * (is_front ? T(1) : T(0.8));
  }
  [[nodiscard]] static T pdf(std::size_t node, bool is_front, bool is_radiance, const V& to_next) {
    return Atlas::law(is_radiance ? 22 : 23, node, T(0.05), T(0.6), to_next) * (is_front ? T(1) : T(1.3));
  }
};

/// A lobe that goes on to any node with the same chance, whatever density it claims, as `DiscreteWorld` itself does.
template <std::floating_point T>
class DiscreteLobe {
 public:
  using World = DiscreteWorld<T>;
  using V = gmis::Vec3<T>;

  DiscreteLobe() = default;
  explicit DiscreteLobe(const typename World::Bsdf& bsdf) : bsdf_(bsdf), exists_(true) {}
  [[nodiscard]] bool is_empty() const { return !exists_; }
  [[nodiscard]] T share(bool is_front, gmis::TransportMode mode) const {
    return DiscreteLobeLaws<T>::share(bsdf_.node(), is_front, mode == gmis::TransportMode::radiance);
  }
  [[nodiscard]] V sample(bool, const gmis::Vec2<T>& uv, gmis::TransportMode mode) const {
    return *bsdf_.sample_lobe(0, V(T(0)), uv, mode);
  }
  [[nodiscard]] T pdf(bool is_front, const V& to_next, gmis::TransportMode mode) const {
    return DiscreteLobeLaws<T>::pdf(bsdf_.node(), is_front, mode == gmis::TransportMode::radiance, to_next);
  }

 private:
  typename World::Bsdf bsdf_;
  bool exists_ = false;
};

/// One lobe more at all surfaces but one that scatter: at one with a delta lobe, too.
template <std::floating_point T>
struct DiscreteGuide {
  using Lobe = DiscreteLobe<T>;
  static constexpr std::size_t unguided = 1;
  [[nodiscard]] Lobe lobe_at(const gmis::SurfacePoint<T>&, const typename DiscreteWorld<T>::Bsdf& bsdf) const {
    return bsdf.node() == unguided ? Lobe() : Lobe(bsdf);
  }
};

template <std::floating_point T>
struct GuidedDiscreteParts {
  DiscreteWorld<T> world;
  DiscreteGuide<T> guide;
};

/// `DiscreteWorld` with guided surfaces.
template <std::floating_point T>
class GuidedDiscreteWorld : private GuidedDiscreteParts<T>,
                            public gmis::GuidedScene<DiscreteWorld<T>, DiscreteGuide<T>> {
 public:
  using Kind = typename DiscreteWorld<T>::Kind;

  GuidedDiscreteWorld(DiscreteAtlas<T> atlas, int size)
      : GuidedDiscreteParts<T>{{std::move(atlas), size}, {}},
        gmis::GuidedScene<DiscreteWorld<T>, DiscreteGuide<T>>(GuidedDiscreteParts<T>::world,
                                                              GuidedDiscreteParts<T>::guide) {}
  [[nodiscard]] const DiscreteAtlas<T>& atlas() const { return this->own().atlas(); }
  [[nodiscard]] const auto& lights() const { return this->own().lights(); }

  /// What the oracle must know: in long double, from the nodes alone.
  static void tell(NominalCounts& nominal, const DiscreteAtlas<long double>& atlas) {
    using V = gmis::Vec3<long double>;
    using Laws = DiscreteLobeLaws<long double>;
    const auto is_front = [&atlas](std::size_t node, const V& w) {
      return glm::dot(atlas.nodes[node].shading_normal, w) > 0.0L;
    };
    nominal.has_lobe = [&atlas](std::size_t node) {
      return node != DiscreteGuide<T>::unguided && atlas.nodes[node].smooth_lobes > 0;
    };
    nominal.lobe_share = [=](std::size_t node, const V& to_prev, bool is_camera) {
      return Laws::share(node, is_front(node, to_prev), is_camera);
    };
    nominal.lobe_pdf = [=](std::size_t node, const V& to_prev, const V& to_next, bool is_camera) {
      return Laws::pdf(node, is_front(node, to_prev), is_camera, to_next);
    };
  }
};

static_assert(gmis::Scene<GuidedDiscreteWorld<double>>);
static_assert(gmis::BsdfWithLobes<GuidedDiscreteWorld<double>::Bsdf>);

}  // namespace gmis_test
