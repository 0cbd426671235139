#pragma once

#include <optional>
#include <utility>

#include "gmis/core/attributes.hpp"
#include "gmis/render/run_record.hpp"

namespace gmis {

/// The record of a rank while it has other pixels, those of all ranks, in place of its own rows.
/// Batches are lent only where `pixels` have them.
/// The record gets its own rows back at the end, so that nothing else of it is copied; there is one
/// such loan at a time. Without other pixels it keeps its own.
template <Spectrum S>
class WholeRecord {
 public:
  /// Lends `pixels` to `record`, which must outlive this.
  WholeRecord(RunRecord<S>& record, std::optional<PixelSums<S>> pixels) : record_(record), pixels_(std::move(pixels)) {
    exchange_pixels();
  }
  ~WholeRecord() { exchange_pixels(); }
  WholeRecord(const WholeRecord&) = delete;
  WholeRecord& operator=(const WholeRecord&) = delete;

  /// The record, with the pixels.
  [[nodiscard]] RunRecord<S>* operator->() const noexcept { return &record_; }
  /// The record likewise.
  [[nodiscard]] RunRecord<S>& operator*() const noexcept { return record_; }

 private:
  GMIS_RARE void exchange_pixels() {
    if (pixels_) record_.swap_with(*pixels_);
  }

  RunRecord<S>& record_;
  std::optional<PixelSums<S>> pixels_;
};

}  // namespace gmis
