#pragma once

#include <concepts>

#include "gmis/transport/weights/weight_recursion.hpp"

namespace gmis {

/// The weights without light subpaths: emitter hits against next events, each taken once per camera
/// vertex.
///
/// The weights equal those of `WeightRecursion` with all other counts 0, but no sum that is always
/// 0 is stored. The members have the same names and arguments. Each weight has one ratio of
/// densities; it stays right when the ratio rounds to 0 or to infinity.
template <std::floating_point T, class Heuristic>
class CameraWeightRecursion {
 public:
  using Weight = T;
  struct LightPartial {};
  struct CameraPartial {
    T density;  ///< b_j, per area; 0 after a delta event, where next event cannot make the vertex

    /// The partial sums of `WeightRecursion`: shared = 1 / b_j, chain = 0.
    [[nodiscard]] constexpr operator PartialWeights<T>() const noexcept {
      if (density == T(0)) return {};
      return {Extended<T>(T(1)) / Heuristic::of(Extended<T>(density)), {}};
    }
  };

  constexpr explicit CameraWeightRecursion(const TechniqueCounts<T>& counts) noexcept
      : hits_emitters_(counts.emitter_hit > T(0)), samples_next_events_(counts.next_event > T(0)) {}

  /// k = 1: only an emitter hit makes light that is seen directly.
  [[nodiscard]] static constexpr Weight seen_directly() noexcept { return T(1); }

  /// The partial sums at x_{k−1}; `density` is b_{k−1}.
  [[nodiscard]] static constexpr CameraPartial first_camera_vertex(T density) noexcept { return {density}; }
  /// The partial sums at x_{j−1}.
  [[nodiscard]] static constexpr CameraPartial extend_camera(const CameraPartial&, CameraStep<T> step) noexcept {
    return {step.is_delta ? T(0) : step.density};
  }

  /// s = 0: 1 / (1 + e_0 / b_0)   [Georgiev TR 37, 43]; 1 when next event cannot make the path.
  [[nodiscard]] constexpr Weight emitter_hit(const CameraPartial& at, LightStart<T> start) const noexcept {
    if (!samples_next_events_ || at.density == T(0)) return T(1);
    return T(1) / (T(1) + Heuristic::of(start.next_event / at.density));
  }
  /// s = 1: 1 / (1 + b_0 / e_0)   [Georgiev TR 37, 44]; 0 when e_0 is 0.
  [[nodiscard]] constexpr Weight next_event(LightStart<T> start, T hit, const CameraPartial&,
                                            CameraEnd<T>) const noexcept {
    if (!hits_emitters_) return T(1);
    if (!(start.next_event > T(0))) return T(0);
    return T(1) / (T(1) + Heuristic::of(hit / start.next_event));
  }

 private:
  bool hits_emitters_, samples_next_events_;
};

}  // namespace gmis
