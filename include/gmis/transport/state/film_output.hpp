#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/transport/state/path_output.hpp"

namespace gmis {

/// Collects the contributions of one chunk of paths for the film. Chunks share nothing, so that the
/// order of execution changes no bit of the result. Models `ChunkOutput`.
template <Spectrum S>
class FilmOutput : public PathObserver {
 public:
  /// A weighted contribution to any pixel; `pixel` is an index in the frame.
  struct Splat {
    std::uint32_t pixel;
    S value;
  };

  /// Begins an iteration.
  void clear() {
    counters_ = {};
    rejections_.clear();
    splats_.clear();
    records_.clear();
    merged_light_ = 0.0;
    merged_ = 0.0F;
  }

  /// Sets whether each contribution is kept for `records()`; initially none is.
  constexpr void keep_contributions(bool keep) noexcept { is_recording_ = keep; }

  [[nodiscard]] constexpr Counters& counters() noexcept { return counters_; }
  [[nodiscard]] constexpr const Counters& counters() const noexcept { return counters_; }
  /// Rejected paths of this chunk; their iteration is not filled in.
  [[nodiscard]] constexpr const RejectionLog& rejections() const noexcept { return rejections_; }

  /// Begins the camera subpath of this pixel (its index in the frame).
  constexpr void begin_pixel(std::uint32_t pixel) noexcept {
    kind_ = PathKind::camera;
    pixel_ = pixel;
    pixel_sum_ = S(ScalarOf<S>(0));
    merged_light_ += static_cast<double>(merged_);
    merging_change_ = merged_ = 0.0F;
  }
  /// Sum of the weighted contributions to the pixel since `begin_pixel`, without splats. A sum that
  /// overflows is counted as a non-finite rejection and replaced by 0.
  [[nodiscard]] const S& take_pixel() {
    if (!is_finite(pixel_sum_)) [[unlikely]] {
      reject(RejectionCause::non_finite, {});
      pixel_sum_ = S(ScalarOf<S>(0));
    }
    return pixel_sum_;
  }

  /// Notes the squared distance of the vertices that are merged next, divided by the squared
  /// radius. In a disk of half the radius a photon counts four times or not at all.
  constexpr void on_merge(ScalarOf<S> relative_distance_squared) noexcept {
    kernel_change_ = ScalarOf<S>(4) * relative_distance_squared <= ScalarOf<S>(1) ? -3.0F : 1.0F;
  }
  /// The light that was merged since `begin_pixel` minus the light that a disk of half the radius
  /// would have merged from the same photons: mean over channels.
  [[nodiscard]] constexpr float merging_change() const noexcept { return merging_change_; }
  /// The light that was merged since `clear`: mean over channels, summed over the pixels.
  [[nodiscard]] constexpr double merged_light() const noexcept { return merged_light_ + static_cast<double>(merged_); }

  /// Begins light trees. The trees are numbered from `first` on, in the order in which
  /// `Counters::light_subpaths` counts them.
  constexpr void begin_trees(std::uint32_t first) noexcept {
    kind_ = PathKind::light;
    first_tree_ = first;
  }

  [[nodiscard]] constexpr const std::vector<Splat>& splats() const noexcept { return splats_; }
  [[nodiscard]] constexpr const std::vector<Contribution<S>>& records() const noexcept { return records_; }

  /// Adds `value` × `weight` to the pixel whose camera subpath is being traced. A non-finite or
  /// negative product is counted and left out.
  GMIS_ALWAYS_INLINE void add(TechniqueId id, const S& value, ScalarOf<S> weight) {
    const S weighted = value * weight;
    if (!accept(id, weighted)) return;
    pixel_sum_ += weighted;
    if (id.technique == Technique::merge) {
      const auto merged = static_cast<float>(mean_channel(weighted));
      merging_change_ += kernel_change_ * merged;
      merged_ += merged;
    }
    if (is_recording_) [[unlikely]]
      record({pixel_, id, value, weight});
  }

  /// Adds `value` × `weight` to any pixel. A non-finite or negative product is counted and left
  /// out.
  void add_splat(std::uint32_t pixel, TechniqueId id, const S& value, ScalarOf<S> weight) {
    const S weighted = value * weight;
    if (!accept(id, weighted)) return;
    splats_.push_back({pixel, weighted});
    if (is_recording_) [[unlikely]]
      record({pixel, id, value, weight});
  }

  /// Counts a rejection on the current path. `technique` is empty when the subpath itself ended.
  GMIS_RARE void reject(RejectionCause cause, const std::optional<TechniqueId>& technique) {
    switch (cause) {
      case RejectionCause::non_finite:
        ++counters_.rejected_non_finite;
        break;
      case RejectionCause::negative:
        ++counters_.rejected_negative;
        break;
      case RejectionCause::zero_pdf:
        ++counters_.rejected_zero_pdf;
        break;
    }
    const bool is_camera = kind_ == PathKind::camera;
    const auto tree = static_cast<std::uint32_t>(counters_.light_subpaths) - 1;
    rejections_.add({kind_, 0, is_camera ? pixel_ : first_tree_ + tree}, cause, technique);
  }

 private:
  /// Counts a contribution. Returns true when it is finite and not negative; otherwise counts a
  /// rejection.
  [[nodiscard]] bool accept(const TechniqueId& id, const S& weighted) {
    ++counters_.contributions;
    // One sum tests all channels at once: it is NaN or infinite when a channel is.
    if (min_channel(weighted) >= ScalarOf<S>(0) && channel_sum(weighted) <= std::numeric_limits<ScalarOf<S>>::max())
        [[likely]]
      return true;
    return examine(id, weighted);
  }
  GMIS_RARE bool examine(const TechniqueId& id, const S& weighted) {
    if (!is_finite(weighted)) {
      reject(RejectionCause::non_finite, id);
      return false;
    }
    if (min_channel(weighted) < ScalarOf<S>(0)) {
      reject(RejectionCause::negative, id);
      return false;
    }
    return true;
  }
  GMIS_RARE void record(const Contribution<S>& contribution) { records_.push_back(contribution); }

  Counters counters_;
  RejectionLog rejections_;
  bool is_recording_ = false;
  PathKind kind_ = PathKind::camera;
  std::uint32_t pixel_ = 0;
  std::uint32_t first_tree_ = 0;
  S pixel_sum_{ScalarOf<S>(0)};
  float kernel_change_ = 0.0F, merging_change_ = 0.0F, merged_ = 0.0F;  // of the pixel
  double merged_light_ = 0.0;
  std::vector<Splat> splats_;
  std::vector<Contribution<S>> records_;
};

}  // namespace gmis
