#pragma once

#include <concepts>

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
///     L_i = b_i (μ_i + κ_i / a_i + L_{i−1} / a_i)                        [Liu, w_{i,VC}, corrected]
/// The count of merging may be local: photons at x_i count only when s(x_{i−1}) = 1, with s a function of the surface
/// alone, so that μ_i = s(x_{i−1}) μ stands in place of μ. s(x_0) is the same for all lights; s ≡ 1 is plain merging.
/// Absolute counts (μ and κ, not their quotient η) let the two partial sums w_VC and w_VM of the paper become one:
/// w_{i,VC} = L_i / ρ and w_{i,VM} = (L_i / b_i − μ) / μ where μ_i = μ.
///
/// b_i is not known before the path goes on from x_i, so a subpath carries
///     shared_i = κ_i / a_i,   chain_i = g_{i−1} (L_{i−1} / b_{i−1}) / a_i,
/// with b_{i−1} = reverse_i g_{i−1}: `reverse` per steradian at x_i, g the change from solid angle to area. Then
/// L_i = b_i (μ_i + shared_i + reverse_i · chain_i). The camera side is the mirror image.

namespace gmis {

/// The balance heuristic: each ratio of densities enters a weight as it is.
struct BalanceRatio {
  /// The ratio as it enters a weight.
  template <class X>
  static constexpr X of(X ratio) noexcept {
    return ratio;
  }
};

/// The power heuristic with exponent 2: each ratio of densities enters a weight squared.
struct PowerRatio {
  /// The ratio as it enters a weight.
  template <class X>
  static constexpr X of(X ratio) noexcept {
    return ratio * ratio;
  }
};

/// The two partial sums that a vertex carries about the path behind it. Every weight of a technique that ends at the
/// vertex follows from them. `Shared` is a plain number on the camera side and a sum over techniques on the light side.
template <class Shared, class Sum>
struct PartialSums {
  Shared shared;  ///< κ_i / a_i, or 0 when the edge behind cannot be a connection (a delta event at either end)
  Sum chain;  ///< g_{i−1} (L_{i−1} / b_{i−1}) / a_i: times the reverse density per steradian, it is L_{i−1} / a_i
};

/// Partial sums with one number per sum, as `ReplayedVertex` records them.
template <std::floating_point T>
using PartialWeights = PartialSums<Extended<T>, Extended<T>>;

/// A technique's own density and the sum of those of all others; a weight is the share of the first in both.
template <class Sum>
struct OwnAndOthers {
  Sum own;     ///< density of the technique
  Sum others;  ///< sum of the densities of all others
};

/// The formulas of partial sums and weights. `Heuristic` is applied to every density and count. `Number` is the type of a
/// density, `Sum_` that of a sum over techniques: arithmetic is done in these, without a check of their range.
///
/// All densities are nominal, positive and finite, except where 0 is named. Below, n_0 and n_1 are the counts of
/// emitter hits and next events (1 or 0), so κ_0 = n_0 and κ_1 = n_1 e_0 / a_0; C_i is the mirror image of L_i.
template <std::floating_point T, class Heuristic, class Number, class Sum_>
class WeightFormulas {
 public:
  using Sum = Sum_;
  using Weight = OwnAndOthers<Sum>;
  using LightPartial = PartialSums<Sum, Sum>;
  using CameraPartial = PartialSums<Number, Sum>;

  /// `Terms::of<technique>(count)` is a sum with one term. The counts are nominal: functions of the path alone, constant
  /// while weights are formed.
  template <class Terms>
  constexpr WeightFormulas(const TechniqueCounts<T>& counts, Terms) noexcept
      : emitter_hit_(Terms::template of<Technique::emitter_hit>(h(counts.emitter_hit))),
        next_event_(Terms::template of<Technique::next_event>(h(counts.next_event))),
        connect_(Terms::template of<Technique::connect>(h(counts.connect))),
        splat_(Terms::template of<Technique::splat>(h(counts.splat))),
        merge_(Terms::template of<Technique::merge>(h(counts.merge))),
        first_merge_(counts.merges_first ? merge_ : Sum()) {}

  // ---- light side -------------------------------------------------------------------------------------------------

  /// Partial sums at x_1: shared = n_1 e_0 / (a_0 a_1), chain = n_0 g_0 / (a_0 a_1) [Georgiev TR 31–33].
  /// `origin` is a_0 and `next_event` is e_0: the densities of x_0 by emission and by next event, in one measure, both
  /// with the probability of choosing the light. `first` is a_1; `to_origin` is g_0 (0 for a light that no ray can
  /// hit).
  [[nodiscard]] constexpr LightPartial first_light_vertex(T origin, T next_event, T first, T to_origin) const noexcept {
    const Number inverse = Number(T(1)) / (h(origin) * h(first));
    return {next_event_ * h(next_event) * inverse, emitter_hit_ * h(to_origin) * inverse};
  }

  /// Partial sums at x_{i+1} of a light subpath: shared = ρ / a_{i+1}, chain = g_i (L_i / b_i) / a_{i+1}
  /// [Georgiev TR 34–36; Liu, w_{i,VC}, corrected]. `reverse` is the density per steradian at x_i of going back to
  /// x_{i−1}, `to_area` is g_i at x_i for a ray from x_{i+1}, `density` is a_{i+1}. `is_photon`: s(x_{i−1}) = 1.
  [[nodiscard]] constexpr LightPartial extend_light(const LightPartial& at, bool is_photon, bool is_delta, T reverse,
                                                    T to_area, T density) const noexcept {
    return extend(at, is_photon, is_delta, reverse, to_area, density, connect_);
  }

  // ---- camera side ------------------------------------------------------------------------------------------------
  // A camera vertex keeps shared = 1 / b_j without the count. The count is that of a splat, a next event or a
  // connection; which one is known only where `shared` is used.

  /// Partial sums at x_{k−1}, the first vertex after the camera: shared = 1 / b_{k−1}, chain = 0 (no technique has a
  /// light subpath that hits the lens) [Georgiev TR 31–33]. `density` is b_{k−1}.
  [[nodiscard]] constexpr CameraPartial first_camera_vertex(T density) const noexcept {
    return {Number(T(1)) / h(density), Sum()};
  }

  /// Partial sums at x_{j−1} of a camera subpath, from those at x_j: shared = 1 / b_{j−1}, chain = g_j (C_j / a_j) /
  /// b_{j−1} [Georgiev TR 34–36]. Arguments as in `extend_light`; `is_next_to_camera`: x_j is x_{k−1};
  /// `makes_photons`: s(x_{j−1}) = 1, so that light subpaths which come to x_j from there leave photons at x_j.
  [[nodiscard]] constexpr CameraPartial extend_camera(const CameraPartial& at, bool is_next_to_camera,
                                                      bool makes_photons, bool is_delta, T reverse, T to_area,
                                                      T density) const noexcept {
    return extend(counted(at, is_next_to_camera), makes_photons, is_delta, reverse, to_area, density, Number(T(1)));
  }

  // ---- weights ----------------------------------------------------------------------------------------------------

  /// k = 1, light seen directly: only an emitter hit makes it, so the weight is 1 (0 when emitter hits are off).
  [[nodiscard]] constexpr Weight seen_directly() const noexcept { return {emitter_hit_, Sum()}; }

  /// s = 0: n_0 / (n_0 + n_1 e_0 shared_0 + a_0 · `first` · chain_0) [Georgiev TR 37, 42, 43].
  /// `at` is the camera vertex on the light, with k ≥ 2; `origin` is a_0 and `next_event` is e_0, as in
  /// `first_light_vertex`. `first` is the density of the emitted direction, so that a_1 = `first` · g_1, with the g_1
  /// that `extend_camera` had as `to_area`; `makes_photons` there must have been s(x_0).
  [[nodiscard]] constexpr Weight emitter_hit(const CameraPartial& at, T origin, T next_event, T first) const noexcept {
    const Sum others = next_event_ * h(next_event) * at.shared + h(origin) * h(first) * at.chain;
    return {emitter_hit_, others};
  }

  /// s = 1: n_1 e_0 / (n_1 e_0 + n_0 b_0 + a_0 C_1), with C_1 = a_1 (s(x_0) μ + shared_1 + `reverse` · chain_1)
  /// [Georgiev TR 37, 44, 45]. `hit` is b_0, the density with which the camera subpath makes x_0 (0 for a light that no
  /// ray can hit); `first` is a_1, `reverse` the density per steradian at x_1 of going back to x_2.
  [[nodiscard]] constexpr Weight next_event(const CameraPartial& camera, bool is_next_to_camera, T origin, T next_event,
                                            T hit, T first, T reverse) const noexcept {
    const Sum others =
        emitter_hit_ * h(hit) + h(origin) * h(first) * side(counted(camera, is_next_to_camera), first_merge_, reverse);
    return {next_event_ * h(next_event), others};
  }

  /// s, t ≥ 2: ρ / (ρ + L_{s−1} + C_s), with L_i = b_i (μ_i + shared_i + r_i chain_i), C_i = a_i (μ_i + shared_i + r_i
  /// chain_i) [Georgiev TR 37, 40, 41; Liu, w_{i,VC}, corrected]. `camera_density` is b_{s−1} of the light vertex and
  /// `light_density` is a_s of the camera vertex, each made from the other end. The reverse densities r are per
  /// steradian, each back along its own subpath. `is_photon`: s(x_{s−2}) = 1; `makes_photons`: s(x_{s−1}) = 1, so that
  /// merging at x_s could make the path.
  [[nodiscard]] constexpr Weight connect(const LightPartial& light, bool is_photon, T light_reverse, T camera_density,
                                         const CameraPartial& camera, bool is_next_to_camera, bool makes_photons,
                                         T camera_reverse, T light_density) const noexcept {
    const Sum before = side(light, merge_if(is_photon), light_reverse);
    const Sum after = side(counted(camera, is_next_to_camera), merge_if(makes_photons), camera_reverse);
    return {connect_, h(camera_density) * before + h(light_density) * after};
  }

  /// t = 1: n_L / (n_L + L_{k−1}) [Georgiev TR 37, 46, 47]. `camera_density` is b_{k−1} of the light vertex, made by a
  /// camera ray; `light_reverse` is the density per steradian there of going back to x_{k−2}. `is_photon`: s(x_{k−2})
  /// = 1.
  [[nodiscard]] constexpr Weight splat(const LightPartial& light, bool is_photon, T light_reverse,
                                       T camera_density) const noexcept {
    return {splat_, h(camera_density) * side(light, merge_if(is_photon), light_reverse)};
  }

  /// Merging at a photon x_i (s(x_{i−1}) = 1), which both subpaths made: μ / (μ + shared_i + r_i chain_i, of the light side and of the camera
  /// side) [Georgiev TR 37–39; Liu, w_{i,VM}, corrected]. The reverse densities r are per steradian, each back along
  /// its own subpath.
  [[nodiscard]] constexpr Weight merge(const LightPartial& light, T light_reverse, const CameraPartial& camera,
                                       bool is_next_to_camera, T camera_reverse) const noexcept {
    const LightPartial camera_counted = counted(camera, is_next_to_camera);
    return {merge_, light.shared + h(light_reverse) * light.chain + camera_counted.shared +
                        h(camera_reverse) * camera_counted.chain};
  }

 private:
  /// A density with the heuristic applied.
  [[nodiscard]] static constexpr Number h(T density) noexcept { return Heuristic::of(Number(density)); }

  /// The partial sums of a camera vertex with κ in `shared`: n_L for x_{k−1} (a splat), else ρ (a connection).
  [[nodiscard]] constexpr LightPartial counted(const CameraPartial& camera, bool is_next_to_camera) const noexcept {
    return {(is_next_to_camera ? splat_ : connect_) * camera.shared, camera.chain};
  }

  /// L_i / b_i = μ_i + shared_i + r_i chain_i, at a vertex where the path goes on by a non-delta event; C_i / a_i
  /// likewise.
  [[nodiscard]] static constexpr Sum side(const LightPartial& at, const Sum& merge, T reverse) noexcept {
    return merge + at.shared + h(reverse) * at.chain;
  }
  /// μ_i: μ at a photon, else 0.
  [[nodiscard]] constexpr Sum merge_if(bool is_photon) const noexcept { return is_photon ? merge_ : Sum(); }

  /// Partial sums at the next vertex, which has the density `density` [Georgiev TR 34–36; at a delta event 53–55].
  template <class Shared>
  [[nodiscard]] constexpr PartialSums<Shared, Sum> extend(const LightPartial& at, bool is_photon, bool is_delta,
                                                          T reverse, T to_area, T density,
                                                          const Shared& count) const noexcept {
    const Number inverse = Number(T(1)) / h(density);
    // A delta event at x_i: no merging at x_i and no connection over either of its edges, so μ_i and `shared` drop out.
    if (is_delta) return {Shared(), h(to_area) * h(reverse) * at.chain * inverse};
    return {count * inverse, h(to_area) * side(at, merge_if(is_photon), reverse) * inverse};
  }

  Sum emitter_hit_, next_event_, connect_, splat_, merge_;
  Sum first_merge_;  // s(x_0) μ
};

}  // namespace gmis
