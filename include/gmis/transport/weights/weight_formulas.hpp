#pragma once

#include <concepts>

#include "gmis/core/extended.hpp"
#include "gmis/transport/state/technique.hpp"

/// \file
/// The recursive weights of vertex connection and merging: pure arithmetic on densities; no scene
/// type is seen here and nothing is mutated to evaluate a weight. docs/weights.md derives every
/// line.
///
/// Notation, for a path x_0 (light) … x_k (camera): a_i is the expected density per area with which
/// light trees make x_i, b_i that with which camera subpaths do; U(s) = Π_{i<s} a_i Π_{i≥s} b_i.
/// Connecting s light and k+1−s camera vertices has the density κ_s U(s), with κ_s the count of its
/// technique; merging at x_i has μ b_i U(i+1), μ = n_L π r².
///
/// L_i = the densities of all techniques to the left of the connection s = i+1, over U(i+1):
///     L_i = b_i (μ_i + κ_i / a_i + L_{i−1} / a_i)                       [Liu, w_{i,VC}, corrected]
/// The count of merging may be local: photons at x_i count only when s(x_{i−1}) = 1, with s a
/// function of the surface alone, so that μ_i = s(x_{i−1}) μ stands in place of μ. s(x_0) is the
/// same for all lights; s ≡ 1 is plain merging. Absolute counts (μ and κ, not their quotient η) let
/// the two partial sums w_VC and w_VM of the paper become one: w_{i,VC} = L_i / ρ and w_{i,VM} =
/// (L_i / b_i − μ) / μ where μ_i = μ.
///
/// b_i is not known before the path goes on from x_i, so a subpath carries
///     shared_i = κ_i / a_i,   chain_i = g_{i−1} (L_{i−1} / b_{i−1}) / a_i,
/// with b_{i−1} = reverse_i g_{i−1}: `reverse` per steradian at x_i, g the change from solid angle
/// to area. Then L_i = b_i (μ_i + shared_i + reverse_i · chain_i). The camera side is the mirror
/// image.

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

/// The two partial sums that a vertex carries about the path behind it. Every weight of a technique
/// that ends at the vertex follows from them. `Shared` is a plain number on the camera side and a
/// sum over techniques on the light side.
template <class Shared, class Sum>
struct PartialSums {
  Shared shared;  ///< κ_i / a_i, or 0 when the edge behind cannot be a connection (a delta event at either end)
  Sum chain;  ///< g_{i−1} (L_{i−1} / b_{i−1}) / a_i: times the reverse density per steradian, it is L_{i−1} / a_i
};

/// Partial sums with one number per sum, as `ReplayedVertex` records them.
template <std::floating_point T>
using PartialWeights = PartialSums<Extended<T>, Extended<T>>;

/// The density of a technique and the sum of the densities of all others; its weight is the density
/// over the sum of both.
template <class Sum>
struct OwnAndOthers {
  Sum own;     ///< density of the technique
  Sum others;  ///< sum of the densities of all others
};

/// The start x_0 of a path on a light, with two densities in one measure, both with the probability
/// of choosing the light.
template <std::floating_point T>
struct LightStart {
  T origin;      ///< a_0: density of x_0 by emission
  T next_event;  ///< e_0: density of x_0 by next event
  T first;       ///< a_1, or the density of the emitted direction where a factor g_1 is known elsewhere
};

/// One step of a light subpath, from x_i to x_{i+1}.
template <std::floating_point T>
struct LightStep {
  bool is_photon;  ///< s(x_{i−1}) = 1: merging gathers x_i
  bool is_delta;   ///< the event at x_i is a delta event
  T reverse;       ///< density per steradian at x_i of going back to x_{i−1}
  T to_area;       ///< g_i at x_i, for a ray from x_{i+1}
  T density;       ///< a_{i+1}, per area
};

/// One step of a camera subpath, from x_j to x_{j−1}.
template <std::floating_point T>
struct CameraStep {
  bool is_next_to_camera;  ///< x_j is x_{k−1}
  bool makes_photons;      ///< s(x_{j−1}) = 1: light subpaths that come to x_j from there leave photons at x_j
  bool is_delta;           ///< the event at x_j is a delta event
  T reverse;               ///< density per steradian at x_j of going back to x_{j+1}
  T to_area;               ///< g_j at x_j, for a ray from x_{j−1}
  T density;               ///< b_{j−1}, per area
};

/// The last vertex of a light subpath, x_{s−1}, where the subpath is joined with a camera subpath.
template <std::floating_point T>
struct LightEnd {
  bool is_photon;      ///< s(x_{s−2}) = 1: merging gathers x_{s−1}
  bool makes_photons;  ///< s(x_{s−1}) = 1: merging at x_s could make the path
  T reverse;           ///< density per steradian at x_{s−1} of going back to x_{s−2}
  T density;           ///< b_{s−1}: with which the camera subpath makes x_{s−1}, per area
};

/// The last vertex of a camera subpath, x_s, where the subpath is joined with a light subpath.
template <std::floating_point T>
struct CameraEnd {
  bool is_next_to_camera;  ///< x_s is x_{k−1}
  T reverse;               ///< density per steradian at x_s of going back to x_{s+1}
  T density;               ///< a_s: with which the light subpath makes x_s, per area
};

/// The formulas of partial sums and weights. `Heuristic` is applied to every density and count.
/// `Number` is the type of a density, `Sum_` that of a sum over techniques: arithmetic is done in
/// these, without a check of their range.
///
/// All densities are nominal, positive and finite, except where 0 is named. Below, n_0 and n_1 are
/// the counts of emitter hits and next events (1 or 0), so κ_0 = n_0 and κ_1 = n_1 e_0 / a_0; C_i
/// is the mirror image of L_i.
template <std::floating_point T, class Heuristic, class Number, class Sum_>
class WeightFormulas {
 public:
  using Sum = Sum_;
  using Weight = OwnAndOthers<Sum>;
  using LightPartial = PartialSums<Sum, Sum>;
  using CameraPartial = PartialSums<Number, Sum>;

  /// `Terms::of<technique>(count)` is a sum with one term. The counts are nominal: functions of the
  /// path alone, constant while weights are formed.
  template <class Terms>
  constexpr WeightFormulas(const TechniqueCounts<T>& counts, Terms) noexcept
      : emitter_hit_(Terms::template of<Technique::emitter_hit>(h(counts.emitter_hit))),
        next_event_(Terms::template of<Technique::next_event>(h(counts.next_event))),
        connect_(Terms::template of<Technique::connect>(h(counts.connect))),
        splat_(Terms::template of<Technique::splat>(h(counts.splat))),
        merge_(Terms::template of<Technique::merge>(h(counts.merge))),
        first_merge_(counts.merges_first ? merge_ : Sum()) {}

  // ---- light side -------------------------------------------------------------------------------

  /// Partial sums at x_1: shared = n_1 e_0 / (a_0 a_1), chain = n_0 g_0 / (a_0 a_1) [Georgiev TR
  /// 31–33]. `start.first` is a_1; `to_origin` is g_0 (0 for a light that no ray can hit).
  [[nodiscard]] constexpr LightPartial first_light_vertex(LightStart<T> start, T to_origin) const noexcept {
    const Number inverse = Number(T(1)) / (h(start.origin) * h(start.first));
    return {next_event_ * h(start.next_event) * inverse, emitter_hit_ * h(to_origin) * inverse};
  }

  /// Partial sums at x_{i+1} of a light subpath: shared = ρ / a_{i+1}, chain = g_i (L_i / b_i) /
  /// a_{i+1} [Georgiev TR 34–36; Liu, w_{i,VC}, corrected].
  [[nodiscard]] constexpr LightPartial extend_light(const LightPartial& at, LightStep<T> step) const noexcept {
    return extend(at, step, connect_);
  }

  // ---- camera side ------------------------------------------------------------------------------
  // A camera vertex keeps shared = 1 / b_j without the count. The count is that of a splat, a next
  // event or a connection; which one is known only where `shared` is used.

  /// Partial sums at x_{k−1}, the first vertex after the camera: shared = 1 / b_{k−1}, chain = 0
  /// (no technique has a light subpath that hits the lens) [Georgiev TR 31–33]. `density` is
  /// b_{k−1}.
  [[nodiscard]] constexpr CameraPartial first_camera_vertex(T density) const noexcept {
    return {Number(T(1)) / h(density), Sum()};
  }

  /// Partial sums at x_{j−1} of a camera subpath, from those at x_j: shared = 1 / b_{j−1}, chain =
  /// g_j (C_j / a_j) / b_{j−1} [Georgiev TR 34–36].
  [[nodiscard]] constexpr CameraPartial extend_camera(const CameraPartial& at, CameraStep<T> step) const noexcept {
    return extend(counted(at, step.is_next_to_camera),
                  {step.makes_photons, step.is_delta, step.reverse, step.to_area, step.density}, Number(T(1)));
  }

  // ---- weights ----------------------------------------------------------------------------------

  /// k = 1, light seen directly: only an emitter hit makes it, so the weight is 1 (0 when emitter
  /// hits are off).
  [[nodiscard]] constexpr Weight seen_directly() const noexcept { return {emitter_hit_, Sum()}; }

  /// s = 0: n_0 / (n_0 + n_1 e_0 shared_0 + a_0 · `first` · chain_0) [Georgiev TR 37, 42, 43]. `at`
  /// is the camera vertex on the light, with k ≥ 2. `start.first` is the density of the emitted
  /// direction, so that a_1 = `first` · g_1, with the g_1 that `extend_camera` had as `to_area`;
  /// `makes_photons` there must have been s(x_0).
  [[nodiscard]] constexpr Weight emitter_hit(const CameraPartial& at, LightStart<T> start) const noexcept {
    const Sum others = next_event_ * h(start.next_event) * at.shared + h(start.origin) * h(start.first) * at.chain;
    return {emitter_hit_, others};
  }

  /// s = 1: n_1 e_0 / (n_1 e_0 + n_0 b_0 + a_0 C_1), with C_1 = a_1 (s(x_0) μ + shared_1 +
  /// `reverse` · chain_1) [Georgiev TR 37, 44, 45]. `hit` is b_0, the density with which the camera
  /// subpath makes x_0 (0 for a light that no ray can hit); `end.density` is a_1, and `start.first`
  /// is not read.
  [[nodiscard]] constexpr Weight next_event(LightStart<T> start, T hit, const CameraPartial& camera,
                                            CameraEnd<T> end) const noexcept {
    const Sum others =
        emitter_hit_ * h(hit) +
        h(start.origin) * h(end.density) * side(counted(camera, end.is_next_to_camera), first_merge_, end.reverse);
    return {next_event_ * h(start.next_event), others};
  }

  /// s, t ≥ 2: ρ / (ρ + L_{s−1} + C_s), with L_i = b_i (μ_i + shared_i + r_i chain_i), C_i = a_i
  /// (μ_i + shared_i + r_i chain_i) [Georgiev TR 37, 40, 41; Liu, w_{i,VC}, corrected].
  [[nodiscard]] constexpr Weight connect(const LightPartial& light, LightEnd<T> light_end, const CameraPartial& camera,
                                         CameraEnd<T> camera_end) const noexcept {
    const Sum before = side(light, merge_if(light_end.is_photon), light_end.reverse);
    const Sum after =
        side(counted(camera, camera_end.is_next_to_camera), merge_if(light_end.makes_photons), camera_end.reverse);
    return {connect_, h(light_end.density) * before + h(camera_end.density) * after};
  }

  /// t = 1: n_L / (n_L + L_{k−1}) [Georgiev TR 37, 46, 47]. `end.density` is b_{k−1}, of the vertex
  /// made by a camera ray; `end.makes_photons` is not read.
  [[nodiscard]] constexpr Weight splat(const LightPartial& light, LightEnd<T> end) const noexcept {
    return {splat_, h(end.density) * side(light, merge_if(end.is_photon), end.reverse)};
  }

  /// Merging at a photon x_i (s(x_{i−1}) = 1), which both subpaths made: μ / (μ + shared_i + r_i
  /// chain_i, of the light side and of the camera side) [Georgiev TR 37–39; Liu, w_{i,VM},
  /// corrected]. `light_reverse` is the density per steradian at x_i of going back along the light
  /// subpath; `end.density` is not read.
  [[nodiscard]] constexpr Weight merge(const LightPartial& light, T light_reverse, const CameraPartial& camera,
                                       CameraEnd<T> end) const noexcept {
    const LightPartial camera_counted = counted(camera, end.is_next_to_camera);
    return {merge_, light.shared + h(light_reverse) * light.chain + camera_counted.shared +
                        h(end.reverse) * camera_counted.chain};
  }

 private:
  /// A density with the heuristic applied.
  [[nodiscard]] static constexpr Number h(T density) noexcept { return Heuristic::of(Number(density)); }

  /// The partial sums of a camera vertex with κ in `shared`: n_L for x_{k−1} (a splat), else ρ (a
  /// connection).
  [[nodiscard]] constexpr LightPartial counted(const CameraPartial& camera, bool is_next_to_camera) const noexcept {
    return {(is_next_to_camera ? splat_ : connect_) * camera.shared, camera.chain};
  }

  /// L_i / b_i = μ_i + shared_i + r_i chain_i, at a vertex where the path goes on by a non-delta
  /// event; C_i / a_i likewise.
  [[nodiscard]] static constexpr Sum side(const LightPartial& at, const Sum& merge, T reverse) noexcept {
    return merge + at.shared + h(reverse) * at.chain;
  }
  /// μ_i: μ at a photon, else 0.
  [[nodiscard]] constexpr Sum merge_if(bool is_photon) const noexcept { return is_photon ? merge_ : Sum(); }

  /// Partial sums at the next vertex [Georgiev TR 34–36; at a delta event 53–55].
  template <class Shared>
  [[nodiscard]] constexpr PartialSums<Shared, Sum> extend(const LightPartial& at, LightStep<T> step,
                                                          const Shared& count) const noexcept {
    const Number inverse = Number(T(1)) / h(step.density);
    // A delta event at x_i: no merging at x_i and no connection over either of its edges, so μ_i
    // and `shared` drop out.
    if (step.is_delta) return {Shared(), h(step.to_area) * h(step.reverse) * at.chain * inverse};
    return {count * inverse, h(step.to_area) * side(at, merge_if(step.is_photon), step.reverse) * inverse};
  }

  Sum emitter_hit_, next_event_, connect_, splat_, merge_;
  Sum first_merge_;  // s(x_0) μ
};

}  // namespace gmis
