#pragma once

#include "gmis/core/extended.hpp"
#include "gmis/transport/techniques/technique.hpp"

/// \file
/// The recursive weights of vertex connection and merging: pure arithmetic on densities; no scene type is seen here and
/// nothing is mutated to evaluate a weight. docs/weights.md derives every line.
///
/// Notation, for a path x_0 (light) … x_k (camera): a_i is the expected density per area with which light trees make
/// x_i, b_i that with which camera subpaths do; U(s) = Π_{i<s} a_i Π_{i≥s} b_i. Connecting s light and k+1−s camera
/// vertices has the density κ_s U(s), with κ_s the count of its technique; merging at x_i has μ b_i U(i+1), μ = n_L π
/// r².
///
/// L_i = the densities of all techniques to the left of the connection s = i+1, over U(i+1):
///     L_i = b_i (μ + κ_i / a_i + L_{i−1} / a_i)                          [Liu, w_{i,VC}, corrected]
/// Absolute counts (μ and κ, not their quotient η) let the two partial sums w_VC and w_VM of the paper become one:
/// w_{i,VC} = L_i / ρ and w_{i,VM} = (L_i / b_i − μ) / μ.
///
/// b_i is not known before the path goes on from x_i, so a subpath carries
///     shared_i = κ_i / a_i,   chain_i = g_{i−1} (L_{i−1} / b_{i−1}) / a_i,
/// with b_{i−1} = reverse_i g_{i−1}: `reverse` per steradian at x_i, g the change from solid angle to area. Then
/// L_i = b_i (μ + shared_i + reverse_i · chain_i). The camera side is the mirror image.

namespace gmis {

/// The balance heuristic: each ratio of densities as it is.
struct BalanceRatio {
  template <class X>
  static constexpr X of(X ratio) noexcept {
    return ratio;
  }
};

/// The power heuristic with exponent 2.
struct PowerRatio {
  template <class X>
  static constexpr X of(X ratio) noexcept {
    return ratio * ratio;
  }
};

/// What a vertex must know of the path behind it to weight any technique that ends there. `Shared` is a plain number on
/// the camera side, a sum over techniques on the light side.
template <class Shared, class Sum>
struct PartialSums {
  Shared shared;  ///< κ_i / a_i, or 0 where the edge behind cannot be a connection (a delta event at either end)
  Sum chain;      ///< times the reverse density per steradian: L_{i−1} / a_i
};

template <std::floating_point T>
using PartialWeights = PartialSums<Extended<T>, Extended<T>>;

/// The whole sum over techniques as one number; a weight is a technique's share of it.
template <std::floating_point T>
struct WholeSum {
  using Sum = Extended<T>;
  using Weight = T;

  /// The sum in which only one technique occurs, with that density.
  template <Technique technique>
  [[nodiscard]] static constexpr Sum of(Extended<T> density) noexcept {
    return density;
  }
  /// own / (own + others), in [0, 1].
  [[nodiscard]] static constexpr Weight weight(const Sum& own, const Sum& others) noexcept {
    return own.is_zero() ? T(0) : (own / (own + others)).value();
  }
};

/// `Sums` says what is summed over the techniques: `WholeSum`, or sums kept apart (weights_by_technique.hpp).
template <std::floating_point T, class Heuristic = BalanceRatio, class Sums = WholeSum<T>>
class WeightRecursion {
 public:
  using Number = Extended<T>;
  using Sum = typename Sums::Sum;
  using Weight = typename Sums::Weight;
  using LightPartial = PartialSums<Sum, Sum>;
  using CameraPartial = PartialSums<Number, Sum>;

  constexpr explicit WeightRecursion(const TechniqueCounts<T>& counts) noexcept
      : emitter_hit_(Sums::template of<Technique::emitter_hit>(h(counts.emitter_hit))),
        next_event_(Sums::template of<Technique::next_event>(h(counts.next_event))),
        connect_(Sums::template of<Technique::connect>(h(counts.connect))),
        splat_(Sums::template of<Technique::splat>(h(counts.splat))),
        merge_(Sums::template of<Technique::merge>(h(counts.merge))) {}

  // ---- light side -------------------------------------------------------------------------------------------------

  /// At x_1. `origin` is a_0 and `next_event` e_0, the densities of x_0 by emission and by next event, both with the
  /// probability of choosing the light and in one measure; `first` is a_1; `to_origin` is g_0 (0 for a light that no
  /// ray can hit).
  [[nodiscard]] constexpr LightPartial first_light_vertex(T origin, T next_event, T first, T to_origin) const noexcept {
    const Number inverse = Number(T(1)) / (h(origin) * h(first));
    return {next_event_ * h(next_event) * inverse, emitter_hit_ * h(to_origin) * inverse};
  }

  /// From x_i to x_{i+1} of a light subpath: `reverse` is the density per steradian at x_i of going back to x_{i−1},
  /// `to_area` is g_i at x_i for a ray from x_{i+1}, `density` is a_{i+1}.
  [[nodiscard]] constexpr LightPartial extend_light(const LightPartial& at, bool is_delta, T reverse, T to_area,
                                                    T density) const noexcept {
    return extend(at, is_delta, reverse, to_area, density, connect_);
  }

  // ---- camera side ------------------------------------------------------------------------------------------------
  // A camera vertex keeps shared = 1 / b_j without the count: the count depends on what the vertex turns out to be.

  /// At the first vertex seen from the camera, `density` is b_{k−1}.
  [[nodiscard]] constexpr CameraPartial first_camera_vertex(T density) const noexcept {
    return {Number(T(1)) / h(density), Sum()};
  }

  /// From x_j to x_{j−1} of a camera subpath; arguments as in `extend_light`. `is_next_to_camera`: x_j is x_{k−1}.
  [[nodiscard]] constexpr CameraPartial extend_camera(const CameraPartial& at, bool is_next_to_camera, bool is_delta,
                                                      T reverse, T to_area, T density) const noexcept {
    return extend(counted(at, is_next_to_camera), is_delta, reverse, to_area, density, Number(T(1)));
  }

  // ---- weights ----------------------------------------------------------------------------------------------------

  /// Light seen directly can be made in no other way.
  [[nodiscard]] constexpr Weight seen_directly() const noexcept { return Sums::weight(emitter_hit_, Sum()); }

  /// s = 0. `at` is the camera vertex on the light, not the first one; `origin` a_0, `next_event` e_0 as above, `first`
  /// the density of the emitted direction (in the measure whose change to area was `to_area` of the edge before).
  [[nodiscard]] constexpr Weight emitter_hit(const CameraPartial& at, T origin, T next_event, T first) const noexcept {
    const Sum others = next_event_ * h(next_event) * at.shared + h(origin) * h(first) * at.chain;
    return Sums::weight(emitter_hit_, others);
  }

  /// s = 1. `hit` is b_0, the density of the camera subpath making x_0 itself (0 for a light that no ray can hit);
  /// `first` is a_1, `reverse` the density per steradian at x_1 of going back to x_2.
  [[nodiscard]] constexpr Weight next_event(const CameraPartial& camera, bool is_next_to_camera, T origin, T next_event,
                                            T hit, T first, T reverse) const noexcept {
    const Sum others = emitter_hit_ * h(hit) + h(origin) * h(first) * side(counted(camera, is_next_to_camera), reverse);
    return Sums::weight(next_event_ * h(next_event), others);
  }

  /// s, t ≥ 2. `light_density` is a of the camera vertex, `camera_density` is b of the light vertex (made from the
  /// other end); the reverse densities are per steradian, each back along its own subpath.
  [[nodiscard]] constexpr Weight connect(const LightPartial& light, T light_reverse, T camera_density,
                                         const CameraPartial& camera, bool is_next_to_camera, T camera_reverse,
                                         T light_density) const noexcept {
    return Sums::weight(connect_, h(camera_density) * side(light, light_reverse) +
                                      h(light_density) * side(counted(camera, is_next_to_camera), camera_reverse));
  }

  /// t = 1. `camera_density` is b of the light vertex, made by a camera ray.
  [[nodiscard]] constexpr Weight splat(const LightPartial& light, T light_reverse, T camera_density) const noexcept {
    return Sums::weight(splat_, h(camera_density) * side(light, light_reverse));
  }

  /// Merging at one vertex that both subpaths made.
  [[nodiscard]] constexpr Weight merge(const LightPartial& light, T light_reverse, const CameraPartial& camera,
                                       bool is_next_to_camera, T camera_reverse) const noexcept {
    const LightPartial camera_counted = counted(camera, is_next_to_camera);
    return Sums::weight(merge_, light.shared + h(light_reverse) * light.chain + camera_counted.shared +
                                    h(camera_reverse) * camera_counted.chain);
  }

 private:
  [[nodiscard]] static constexpr Number h(T density) noexcept { return Heuristic::of(Number(density)); }

  [[nodiscard]] constexpr LightPartial counted(const CameraPartial& camera, bool is_next_to_camera) const noexcept {
    return {(is_next_to_camera ? splat_ : connect_) * camera.shared, camera.chain};
  }

  /// L_i / b_i at a vertex where the path goes on by a non-delta event.
  [[nodiscard]] constexpr Sum side(const LightPartial& at, T reverse) const noexcept {
    return merge_ + at.shared + h(reverse) * at.chain;
  }

  template <class Shared>
  [[nodiscard]] constexpr PartialSums<Shared, Sum> extend(const LightPartial& at, bool is_delta, T reverse, T to_area,
                                                          T density, const Shared& count) const noexcept {
    const Number inverse = Number(T(1)) / h(density);
    // A delta event at x_i: no merging there, and neither edge of it can be a connection.
    if (is_delta) return {Shared(), h(to_area) * h(reverse) * at.chain * inverse};
    return {count * inverse, h(to_area) * side(at, reverse) * inverse};
  }

  Sum emitter_hit_, next_event_, connect_, splat_, merge_;
};

}  // namespace gmis
