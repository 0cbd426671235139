#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "gmis/core/spectrum.hpp"

namespace gmis {

/// A table of numbers of samples that a run learns from its first iterations, or is given. From then on it stays as it is:
/// numbers of samples must not depend on the samples that they count. `Learner` sees an iteration at a time and makes the table after
/// `Learner::iterations` of them, or none when that would gain little.
template <class Learner, class Table>
class LearnedTable {
 public:
  /// Nothing is learned.
  LearnedTable() = default;
  /// This learner is to make the table.
  explicit LearnedTable(Learner learner) : learner_(std::move(learner)), is_on_(true), is_learning_(true) {}

  /// True when there is a table, or none because it would gain little, or one is still being learned.
  [[nodiscard]] bool is_on() const noexcept { return is_on_; }
  /// True while the table is learned.
  [[nodiscard]] bool is_learning() const noexcept { return is_learning_; }
  /// What learns, while it does.
  [[nodiscard]] Learner& learner() noexcept { return learner_; }
  /// The table; null before it is known, and when it would gain little.
  [[nodiscard]] const Table* table() const noexcept { return table_.is_empty() ? nullptr : &table_; }
  /// Iterations of the run before the table was known.
  [[nodiscard]] std::uint32_t known_after() const noexcept { return known_after_; }

  /// Takes this table, after so many iterations; nothing is learned from now on.
  void use(Table table, std::uint32_t iterations) {
    table_ = std::move(table);
    known_after_ = iterations;
    learner_ = {};
    is_learning_ = false;
  }

  /// Learns from an iteration (its number, from 1) with this picture and this cost of all its work.
  template <Spectrum S>
  void end_iteration(std::span<const S> frame, double cost, std::uint32_t iteration) {
    learner_.end_iteration(frame, cost);
    if (learner_.seen() < Learner::iterations) return;
    auto table = learner_.table();
    use(table ? std::move(*table) : Table(), iteration);
  }

  /// The state for a later run (`core/state_archive.hpp`), between two iterations; of a frame of so many pixels.
  template <class Archive>
  void exchange_state(Archive& archive, std::size_t pixels) {
    if (!is_on_) return;
    archive(learner_, is_learning_, table_, known_after_);
    if (!table_.fits(pixels)) table_ = {};  // a broken archive
  }

 private:
  Learner learner_;
  Table table_;
  std::uint32_t known_after_ = 0;
  bool is_on_ = false, is_learning_ = false;
};

}  // namespace gmis
