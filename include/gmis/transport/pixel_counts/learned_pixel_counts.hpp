#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/transport/pixel_counts/pixel_count_learner.hpp"
#include "gmis/transport/pixel_counts/pixel_counts.hpp"

namespace gmis {

/// The numbers of camera subpaths by pixel that a run learns from its first iterations, or is
/// given. They stay fixed from then on, because they must not depend on the samples that they
/// count.
class LearnedPixelCounts {
 public:
  /// One camera subpath everywhere; nothing is learned.
  LearnedPixelCounts() = default;
  /// Learns the numbers for the pixels of this crop.
  explicit LearnedPixelCounts(const CropPixels& crop) : learner_(crop), is_on_(true), is_learning_(true) {}

  /// True while the numbers are learned.
  [[nodiscard]] bool is_learning() const noexcept { return is_learning_; }
  /// The learner, while `is_learning()`.
  [[nodiscard]] PixelCountLearner& learner() noexcept { return learner_; }
  /// The numbers; null before they are learned, and when they would gain little.
  [[nodiscard]] const PixelCountTable* table() const noexcept { return table_.is_empty() ? nullptr : &table_; }

  /// Uses this table, after that many iterations; nothing is learned from now on.
  void use(PixelCountTable table, std::uint32_t iterations) {
    table_ = std::move(table);
    known_after_ = iterations;
    learner_ = {};
    is_learning_ = false;
  }

  /// Learns from an iteration (its number, from 1) with this picture; `cost` is the cost of all its
  /// work.
  template <Spectrum S>
  void end_iteration(std::span<const S> frame, double cost, std::uint32_t iteration) {
    learner_.end_iteration(frame, cost);
    if (learner_.seen() < PixelCountLearner::iterations) return;
    auto table = learner_.table();
    use(table ? std::move(*table) : PixelCountTable(), iteration);
  }

  /// The camera subpaths of an iteration (from 1).
  [[nodiscard]] PixelSchedule schedule(std::uint32_t iteration) const noexcept {
    const std::uint64_t rounds = iteration > 0 ? (iteration - 1) / sobol_replications : 0;
    if (!is_on_) return {nullptr, 1, 0, rounds};
    if (is_learning_) return {nullptr, PixelCountLearner::subpaths, rounds, 0};
    // Iterations of the same replication before the numbers were known.
    const std::uint32_t first = iteration - static_cast<std::uint32_t>(rounds) * sobol_replications;
    const std::uint64_t before = first > known_after_ ? 0 : (known_after_ - first) / sobol_replications + 1;
    return {table(), 1, before, rounds - std::min(before, rounds)};
  }

  /// The state for a later run (`core/state_archive.hpp`), between two iterations, of a frame with
  /// this number of pixels.
  template <class Archive>
  void exchange_state(Archive& archive, std::size_t pixels) {
    if (!is_on_) return;
    archive(learner_, is_learning_, table_, known_after_);
    if (!table_.fits(pixels)) table_ = {};  // a broken archive
  }

 private:
  PixelCountLearner learner_;
  PixelCountTable table_;
  std::uint32_t known_after_ = 0;  // iterations of the run before the table was known
  bool is_on_ = false, is_learning_ = false;
};

}  // namespace gmis
