#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/guided_light.hpp"
#include "gmis/core/square_table.hpp"
#include "gmis/transport/emission/aim.hpp"

namespace gmis {

/// How guided emission starts on one light: the part that is drawn first (the point, or the
/// direction of an infinite light) by a table over its numbers, then the rest of the line by an
/// aim.
template <std::floating_point T, class L>
struct GuidedLight {
  const L* light;        ///< which
  T probability;         ///< of this light among all that are guided
  SquareTable<T> first;  ///< over `start_numbers`
  Aim<T> aim;            ///< of the direction from a point, or of the position of a line
};

/// A density of the starts of light subpaths: a mixture of the one that the lights have, with the
/// probability `own_share`, and a learned one. It is frozen while it is used. Where a light emits,
/// the density is at least `own_share` times that of the light.
template <Scene Sc>
class EmissionGuide {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  /// A light of the scene.
  using L = typename Sc::Light;
  /// A point of a path.
  using Point = SurfacePoint<T>;

  /// Emission as the lights have it.
  EmissionGuide() = default;
  /// The probabilities of `lights` must sum to 1. `own_share` is in (0, 1).
  EmissionGuide(std::vector<GuidedLight<T, L>> lights, T own_share)
      : lights_(std::move(lights)), own_share_(own_share) {
    for (const auto& guided : lights_)
      cumulative_.push_back((cumulative_.empty() ? T(0) : cumulative_.back()) + guided.probability);
    if (lights_.empty()) return;
    cumulative_.back() = T(1);
    for (std::size_t i = 0; i < lights_.size(); ++i) by_address_.emplace_back(lights_[i].light, i);
    std::sort(by_address_.begin(), by_address_.end(),
              [](const auto& a, const auto& b) { return std::less<>{}(a.first, b.first); });
  }

  /// True when nothing is guided.
  [[nodiscard]] bool is_empty() const noexcept { return lights_.empty(); }
  /// The probability of a start as the lights have it.
  [[nodiscard]] T own_share() const noexcept { return own_share_; }
  /// The lights that are guided.
  [[nodiscard]] std::span<const GuidedLight<T, L>> lights() const noexcept { return lights_; }

  /// Chooses the light of a light subpath. The probability in the result is that of
  /// `scene.sample_light(u)`. `guided` receives what `sample` needs: null for a start as the light
  /// has it.
  [[nodiscard]] LightChoice<T, L> sample_light(const Sc& scene, T u, const GuidedLight<T, L>*& guided) const {
    guided = nullptr;
    if (u < own_share_) return scene.sample_light(u / own_share_);
    const auto found =
        std::upper_bound(cumulative_.begin(), cumulative_.end() - 1, (u - own_share_) / (T(1) - own_share_));
    guided = &lights_[static_cast<std::size_t>(found - cumulative_.begin())];
    return {guided->light, scene.selection_probability(*guided->light)};
  }
  /// Draws the start of a light subpath on the light that `sample_light` chose; nothing when the
  /// sample fails. The weight and the densities are those of the light alone: they must be divided
  /// and multiplied by `ratio`.
  [[nodiscard]] std::optional<EmissionSample<S>> sample(const L& light, const GuidedLight<T, L>* guided,
                                                        const Vec2<T>& uv_origin, const Vec2<T>& uv_direction) const {
    if (guided == nullptr) return light.sample_emission(uv_origin, uv_direction);
    if (light.is_infinite()) {
      const auto drawn = light.sample_emission(uv_origin, guided->first.warp(uv_direction).point);
      if (!drawn) return std::nullopt;
      const Vec3<T> on_line = guided->aim.sample_line(drawn->direction, uv_origin);
      return light.emission_along({on_line, {}, {}, T(0)}, drawn->direction);
    }
    const auto drawn = light.sample_emission(guided->first.warp(uv_origin).point, uv_direction);
    if (!drawn) return std::nullopt;
    const auto direction = guided->aim.sample_direction(drawn->origin.position, uv_direction);
    return direction ? light.emission_along(drawn->origin, *direction) : drawn;
  }

  /// The density of a start divided by that of the lights alone. `origin` is x_0 (ignored for an
  /// infinite light), `receiver` is x_1, `direction` points from x_0 to x_1.
  /// `selection_probability` is that of `sample_light(u)` for this light, and `first` the light's
  /// own `EmissionDensity::first`.
  [[nodiscard]] GMIS_NEVER_INLINE T ratio(const L& light, T selection_probability, T first, const Point& origin,
                                          const Vec3<T>& direction, const Vec3<T>& receiver) const noexcept {
    const auto found = std::lower_bound(by_address_.begin(), by_address_.end(), &light,
                                        [](const auto& a, const L* b) { return std::less<>{}(a.first, b); });
    if (found == by_address_.end() || found->first != &light) return own_share_;
    const auto& guided = lights_[found->second];
    T aimed = light.is_infinite() ? guided.aim.line_density(direction, receiver) / first
                                  : guided.aim.direction_density(origin.position, direction, receiver) / first +
                                        guided.aim.failure(origin.position);
    if (const auto numbers = light.start_numbers(origin, direction)) aimed *= guided.first.density(*numbers);
    return own_share_ + (T(1) - own_share_) * (guided.probability / selection_probability) * aimed;
  }

 private:
  std::vector<GuidedLight<T, L>> lights_;
  std::vector<T> cumulative_;
  std::vector<std::pair<const L*, std::size_t>> by_address_;
  T own_share_ = T(1);
};

/// `EmissionDensity::first` of a start under the guide of the context: `first` without one. The
/// arguments are those of `EmissionGuide::ratio`. Without a light side nothing reads this density.
template <class Context, class L, std::floating_point T>
[[nodiscard]] constexpr T guided_first(const Context& context, const L& light, T selection_probability, T first,
                                       const SurfacePoint<T>& origin, const Vec3<T>& direction,
                                       const Vec3<T>& receiver) noexcept {
  if constexpr (Context::has_light_side && GuidableLight<L>)
    if (context.guide != nullptr) [[unlikely]] {
      // Copies, so that the originals stay in registers.
      const SurfacePoint<T> from = origin;
      const Vec3<T> along = direction, to = receiver;
      return first * context.guide->ratio(light, selection_probability, first, from, along, to);
    }
  return first;
}

}  // namespace gmis
