#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/result/row_copy.hpp"

namespace gmis {

/// The iterations of a progressive image, cut into batches of equal length: independent estimates
/// of the same image, nearly normal where single iterations are not.
///
/// There are never more than `capacity` batches, however long the run: when one more would be
/// needed, neighbours are joined and the batches are twice as long from then on. So, once it has
/// been reached, between capacity/2 and capacity batches are complete. Memory: capacity + 2 floats
/// per pixel and channel.
///
/// Where iterations depend on each other but form independent replications (`Sampler::sobol`),
/// iteration i belongs to batch (i − 1) mod `replications`, all batches are complete from the first
/// iteration on, and their lengths differ by one at most. Memory: 2 floats per pixel, channel and
/// replication.
///
/// Runs that are independent of each other can be joined (`join`). Their parts (replications, or
/// batches and the iterations since the last batch) then become the batches, at most `capacity` of
/// them, none less than half as long as the longest.
template <Spectrum S>
class BatchMeans {
 public:
  static constexpr int channel_count = SpectrumTraits<S>::channel_count;
  static constexpr std::size_t capacity = 16;

  /// Pixels are stored by rows. `replications`: 0 for independent iterations, else from 2 to
  /// `capacity`; throws std::invalid_argument for another number.
  explicit BatchMeans(glm::ivec2 resolution, std::size_t replications = 0)
      : resolution_(resolution),
        replication_count_(replications),
        current_(static_cast<std::size_t>(resolution.x) * static_cast<std::size_t>(resolution.y) * channel_count, 0.0) {
    require_argument(replications == 0 || (replications >= 2 && replications <= capacity),
                     "the number of replications must be 0, or from 2 to BatchMeans::capacity");
  }

  /// Adds one iteration, as `Film::add_iteration` does.
  void add_iteration(std::span<const S> frame) {
    if (replication_count_ > 0) {
      const std::size_t replication = static_cast<std::size_t>(iterations_ % replication_count_);
      if (replication == replications_.size()) replications_.emplace_back(current_.size(), 0.0);
      ++iterations_;
      add(frame, replications_[replication], iterations_of(replication));
      return;
    }
    if (batches_.size() == capacity) join_neighbours();
    ++iterations_;
    add(frame, current_, ++current_iterations_);
    if (current_iterations_ < length_) return;
    batches_.emplace_back(current_.begin(), current_.end());
    current_.assign(current_.size(), 0.0);
    current_iterations_ = 0;
  }

  /// Takes in all iterations of another run of the same size, which must be independent of those
  /// here. No iterations can be added here afterwards. The shortest parts of both are put together,
  /// by their lengths alone, until there are few enough and none is short.
  void join(const BatchMeans& other) {
    std::vector<Part> parts;
    take_parts(parts);
    other.take_parts(parts);
    const auto shorter = [](const Part& a, const Part& b) { return a.iterations < b.iterations; };
    std::stable_sort(parts.begin(), parts.end(), shorter);
    while (parts.size() > capacity || (parts.size() > 1 && 2 * parts.front().iterations < parts.back().iterations)) {
      Part joined = std::move(parts[0]);
      const Part& next = parts[1];
      joined.iterations += next.iterations;
      const double share = static_cast<double>(next.iterations) / static_cast<double>(joined.iterations);
      for (std::size_t i = 0; i < joined.mean.size(); ++i) joined.mean[i] += (next.mean[i] - joined.mean[i]) * share;
      parts.erase(parts.begin(), parts.begin() + 2);
      parts.insert(std::upper_bound(parts.begin(), parts.end(), joined, shorter), std::move(joined));
    }
    iterations_ += other.iterations_;
    current_.assign(current_.size(), 0.0);
    current_iterations_ = 0;
    batches_.clear();
    replications_.clear();
    lengths_.clear();
    for (Part& part : parts) {
      lengths_.push_back(part.iterations);
      replications_.push_back(std::move(part.mean));
    }
    replication_count_ = replications_.size();
  }

  /// Takes rows over from the same iterations of a picture of the same width.
  void copy_rows(const BatchMeans& other, const RowCopy& rows) {
    iterations_ = other.iterations_;
    length_ = other.length_;
    current_iterations_ = other.current_iterations_;
    const std::size_t row_length = static_cast<std::size_t>(resolution_.x) * channel_count;
    const auto copy = [&](const auto& from, auto& to) {
      to.resize(from.size());
      for (std::size_t i = 0; i < from.size(); ++i) {
        to[i].resize(current_.size());
        rows(from[i], to[i], row_length);
      }
    };
    rows(other.current_, current_, row_length);
    copy(other.batches_, batches_);
    copy(other.replications_, replications_);
  }

  /// True when the complete batches are equally long, or their lengths differ by one at most.
  [[nodiscard]] bool has_equal_batches() const noexcept { return lengths_.empty(); }

  /// In pixels.
  [[nodiscard]] glm::ivec2 resolution() const noexcept { return resolution_; }
  /// All that were added.
  [[nodiscard]] std::uint64_t iterations() const noexcept { return iterations_; }
  /// Complete batches; what has been added since the last of them is not part of any, but
  /// `unfinished`.
  [[nodiscard]] std::size_t batch_count() const noexcept {
    return replication_count_ > 0 ? replications_.size() : batches_.size();
  }
  /// Iterations in a batch.
  [[nodiscard]] std::uint64_t iterations_of(std::size_t batch) const noexcept {
    if (!lengths_.empty()) return lengths_[batch];
    if (replication_count_ == 0) return length_;
    return iterations_ / replication_count_ + (batch < iterations_ % replication_count_ ? 1 : 0);
  }
  /// Pixels times channels.
  [[nodiscard]] std::size_t value_count() const noexcept { return current_.size(); }
  /// One value of the mean image of a batch of either kind.
  [[nodiscard]] double value(std::size_t batch, std::size_t index) const noexcept {
    return replication_count_ > 0 ? replications_[batch][index] : static_cast<double>(batches_[batch][index]);
  }
  /// Calls `use(values)` with the mean image of a batch of either kind: a span of double for
  /// replications, else of float.
  template <class Use>
  void with_values(std::size_t batch, Use&& use) const {
    if (replication_count_ > 0)
      use(std::span<const double>(replications_[batch]));
    else
      use(std::span<const float>(batches_[batch]));
  }
  /// The iterations since the last complete batch, and their mean image.
  [[nodiscard]] std::uint64_t unfinished_iterations() const noexcept { return current_iterations_; }
  /// The mean image of the iterations since the last complete batch.
  [[nodiscard]] std::span<const double> unfinished() const noexcept { return current_; }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(iterations_, length_, current_iterations_, current_, batches_, replications_);
  }

 private:
  /// The mean of some iterations, and their number.
  struct Part {
    std::uint64_t iterations = 0;
    std::vector<double> mean;
  };

  void take_parts(std::vector<Part>& parts) const {
    for (std::size_t b = 0; b < batch_count(); ++b) {
      Part& part = parts.emplace_back(Part{iterations_of(b), std::vector<double>(value_count())});
      for (std::size_t i = 0; i < part.mean.size(); ++i) part.mean[i] = value(b, i);
    }
    if (current_iterations_ > 0) parts.push_back({current_iterations_, current_});
  }

  /// Makes `mean` that of `count` frames, this one being the last.
  static void add(std::span<const S> frame, std::vector<double>& mean, std::uint64_t count) {
    const double weight = 1.0 / static_cast<double>(count);
    std::size_t i = 0;
    for (const S& pixel : frame)
      for (int c = 0; c < channel_count; ++c, ++i)
        mean[i] += (static_cast<double>(SpectrumTraits<S>::channel(pixel, c)) - mean[i]) * weight;
  }

  void join_neighbours() {
    for (std::size_t b = 0; b < capacity / 2; ++b) {
      std::vector<float>& joined = batches_[2 * b];
      const std::vector<float>& other = batches_[2 * b + 1];
      for (std::size_t i = 0; i < joined.size(); ++i) joined[i] += (other[i] - joined[i]) / 2;
      if (b > 0) batches_[b] = std::move(joined);
    }
    batches_.resize(capacity / 2);
    length_ *= 2;
  }

  glm::ivec2 resolution_;
  std::size_t replication_count_;
  std::uint64_t iterations_ = 0;
  std::uint64_t length_ = 1;
  std::uint64_t current_iterations_ = 0;
  std::vector<double> current_;
  std::vector<std::vector<float>> batches_;
  std::vector<std::vector<double>> replications_;  ///< of joined runs: all parts
  std::vector<std::uint64_t> lengths_;             ///< of joined runs: iterations of each part
};

}  // namespace gmis
