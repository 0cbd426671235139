#pragma once

#include <cstdint>
#include <vector>

#include "gmis/core/spectrum.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/transport/technique.hpp"

namespace gmis {

/// One estimate of one pixel before it reaches the film: `value` is not yet multiplied by the MIS weight.
template <Spectrum S>
struct Contribution {
  std::uint32_t pixel;
  TechniqueId id;
  S value;
  ScalarOf<S> weight;
};

/// Where the work of one chunk of paths goes: nothing in it is shared with another chunk, so that no order of execution
/// can change a bit of the result.
template <Spectrum S, bool records_techniques>
class ChunkOutput {
 public:
  struct Splat {
    std::uint32_t pixel;
    S value;
  };

  Counters counters;
  bool is_recording = true;  ///< read only where `records_techniques`

  void clear() {
    counters = {};
    splats_.clear();
    records_.clear();
  }

  void begin_pixel(std::uint32_t pixel) noexcept {
    pixel_ = pixel;
    pixel_sum_ = S(ScalarOf<S>(0));
  }
  [[nodiscard]] const S& pixel_sum() const noexcept { return pixel_sum_; }
  [[nodiscard]] const std::vector<Splat>& splats() const noexcept { return splats_; }
  [[nodiscard]] const std::vector<Contribution<S>>& records() const noexcept { return records_; }

  /// A contribution to the pixel whose camera subpath is being traced.
  void add(TechniqueId id, const S& value, ScalarOf<S> weight) {
    const S weighted = value * weight;
    if (!accept(weighted)) return;
    pixel_sum_ += weighted;
    if constexpr (records_techniques)
      if (is_recording) records_.push_back({pixel_, id, value, weight});
  }

  /// A contribution to any pixel.
  void add_splat(std::uint32_t pixel, TechniqueId id, const S& value, ScalarOf<S> weight) {
    const S weighted = value * weight;
    if (!accept(weighted)) return;
    splats_.push_back({pixel, weighted});
    if constexpr (records_techniques)
      if (is_recording) records_.push_back({pixel, id, value, weight});
  }

 private:
  /// Non-finite and negative contributions never reach the film; they are counted.
  [[nodiscard]] bool accept(const S& weighted) noexcept {
    ++counters.contributions;
    if (!is_finite(weighted)) [[unlikely]] {
      ++counters.rejected_non_finite;
      return false;
    }
    if (min_channel(weighted) < ScalarOf<S>(0)) [[unlikely]] {
      ++counters.rejected_negative;
      return false;
    }
    return true;
  }

  std::uint32_t pixel_ = 0;
  S pixel_sum_{ScalarOf<S>(0)};
  std::vector<Splat> splats_;
  std::vector<Contribution<S>> records_;
};

}  // namespace gmis
