#pragma once

#include <concepts>

#include "gmis/transport/weights/weight_recursion.hpp"

namespace gmis {

/// The weights where nothing is traced from the lights: emitter hits against next events, each once a camera vertex. It
/// is what `WeightRecursion` comes to when the other counts are 0, with none of the sums that are then 0 kept along; the
/// members are called as there. A weight is formed from one ratio of densities, which may round to 0 or to infinity
/// without harm.
template <std::floating_point T, class Heuristic>
class CameraWeightRecursion {
 public:
  using Weight = T;
  struct LightPartial {};
  struct CameraPartial {
    T density;  ///< with which the vertex was made, per area; 0 where next event cannot make it: after a delta event

    /// As `WeightRecursion` keeps it.
    [[nodiscard]] constexpr operator PartialWeights<T>() const noexcept {
      if (density == T(0)) return {};
      return {Extended<T>(T(1)) / Heuristic::of(Extended<T>(density)), {}};
    }
  };

  constexpr explicit CameraWeightRecursion(const TechniqueCounts<T>& counts) noexcept
      : hits_emitters_(counts.emitter_hit > T(0)), samples_next_events_(counts.next_event > T(0)) {}

  [[nodiscard]] static constexpr Weight seen_directly() noexcept { return T(1); }

  [[nodiscard]] static constexpr CameraPartial first_camera_vertex(T density) noexcept { return {density}; }
  [[nodiscard]] static constexpr CameraPartial extend_camera(const CameraPartial&, bool, bool is_delta, T, T,
                                                             T density) noexcept {
    return {is_delta ? T(0) : density};
  }

  [[nodiscard]] constexpr Weight emitter_hit(const CameraPartial& at, T, T next_event, T) const noexcept {
    if (!samples_next_events_ || at.density == T(0)) return T(1);
    return T(1) / (T(1) + Heuristic::of(next_event / at.density));
  }
  [[nodiscard]] constexpr Weight next_event(const CameraPartial&, bool, T, T next_event, T hit, T, T) const noexcept {
    if (!hits_emitters_) return T(1);
    if (!(next_event > T(0))) return T(0);
    return T(1) / (T(1) + Heuristic::of(hit / next_event));
  }

 private:
  bool hits_emitters_, samples_next_events_;
};

}  // namespace gmis
