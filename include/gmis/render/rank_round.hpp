#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/executor_ref.hpp"
#include "gmis/core/state_archive.hpp"
#include "gmis/render/iteration_result.hpp"
#include "gmis/render/rank_gathering.hpp"
#include "gmis/render/ranks.hpp"
#include "gmis/transport/engine/any_engine.hpp"

namespace gmis {

/// A round of a run over ranks: each renders one of the iterations to come, then each gets its rows
/// of the frames of all. Random numbers are keyed by iteration, so that it does not matter who
/// renders which.
template <Spectrum S>
class RankRound {
 public:
  /// `picture`: the rendered part of the frame.
  RankRound(RanksRef ranks, const PixelBounds& picture) : ranks_(ranks), picture_(picture) {}

  /// Renders the iterations `done` + 1 to `done` + `length`, one a rank. Afterwards
  /// the engine has no work. Returns false when the executor of any rank was stopped: the round is
  /// left out.
  [[nodiscard]] bool render(AnyEngine<S>& engine, ExecutorRef executor, std::uint32_t done, std::uint32_t length) {
    const auto rank = static_cast<std::uint32_t>(ranks_.rank());
    IterationResult<S> mine;
    bool is_stopped = false;
    if (rank < length) {
      const std::clock_t start = std::clock();
      engine.continue_after(done + rank);
      engine.iterate(executor);
      is_stopped = executor.is_stopped();
      mine = {.frame = engine.frame(),
              .merging_change = engine.merging_change(),
              .merged_light = engine.merged_light(),
              .cpu_seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC,
              .work = engine.take_work()};
    }
    if (ranks_.count() > 1) return exchange(engine, mine, is_stopped, length);
    mine.frame = part_of(engine, mine.frame, frame_);
    mine.merging_change = part_of(engine, mine.merging_change, change_);
    iterations_.assign(1, std::move(mine));
    return !is_stopped;
  }

  /// The iterations of the latest round in their order; their pixels stay until the next round.
  [[nodiscard]] std::span<const IterationResult<S>> iterations() const noexcept { return iterations_; }

 private:
  /// Room for the numbers of an iteration: with as many rejected paths as are kept.
  static constexpr std::size_t numbers_size =
      sizeof(IterationResult<S>) + RejectionLog::capacity * sizeof(RejectedPath) + 64;

  [[nodiscard]] static std::size_t pixel_count(const PixelBounds& bounds) noexcept {
    const glm::ivec2 size = bounds.upper - bounds.lower;
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  }
  /// Calls `use(pixels)` for each row of `bounds` in a frame.
  template <class Value, class Use>
  static void for_each_row(const AnyEngine<S>& engine, std::span<const Value> frame, const PixelBounds& bounds,
                           Use&& use) {
    if (frame.empty()) return;
    const auto width = static_cast<std::size_t>(engine.resolution().x);
    for (int y = bounds.lower.y; y < bounds.upper.y; ++y)
      use(frame.subspan(static_cast<std::size_t>(y) * width + static_cast<std::size_t>(bounds.lower.x),
                        static_cast<std::size_t>(bounds.upper.x - bounds.lower.x)));
  }
  /// The pixels of the picture, copied into `part` unless they are the whole frame.
  template <class Value>
  std::span<const Value> part_of(const AnyEngine<S>& engine, std::span<const Value> frame,
                                 std::vector<Value>& part) const {
    if (frame.size() == pixel_count(picture_)) return frame;
    part.clear();
    for_each_row(engine, frame, picture_,
                 [&](std::span<const Value> row) { part.insert(part.end(), row.begin(), row.end()); });
    return part;
  }

  /// Each rank sends each other one its numbers, and that one's rows of its frame.
  bool exchange(const AnyEngine<S>& engine, IterationResult<S>& mine, bool is_stopped, std::uint32_t length) {
    const auto count = static_cast<std::size_t>(ranks_.count()), rank = static_cast<std::size_t>(ranks_.rank());
    const bool merges = !engine.merging_change().empty();
    const auto size_between = [&](std::size_t from, std::size_t to) {
      const std::size_t pixels = from < length ? pixel_count(stripe(to)) : 0;
      return numbers_size + pixels * (sizeof(S) + (merges ? sizeof(float) : 0));
    };
    std::vector<std::size_t> send_sizes(count), receive_sizes(count);
    for (std::size_t r = 0; r < count; ++r) {
      send_sizes[r] = size_between(rank, r);
      receive_sizes[r] = size_between(r, rank);
    }
    StateWriter numbers;
    numbers(is_stopped);
    mine.exchange_numbers(numbers);
    send_.clear();
    const auto append = [this](auto row) {
      const auto bytes = std::as_bytes(row);
      send_.insert(send_.end(), bytes.begin(), bytes.end());
    };
    for (std::size_t r = 0; r < count; ++r) {
      const std::size_t end = send_.size() + numbers_size;
      append(std::span(numbers.bytes()));
      send_.resize(end);
      if (rank >= length) continue;
      for_each_row(engine, mine.frame, stripe(r), append);
      for_each_row(engine, mine.merging_change, stripe(r), append);
    }
    receive_.resize(std::accumulate(receive_sizes.begin(), receive_sizes.end(), std::size_t{0}));
    ranks_.exchange(send_, send_sizes, receive_, receive_sizes);

    iterations_.assign(length, {});
    const std::size_t pixels = pixel_count(stripe(rank));
    frame_.resize(length * pixels);
    change_.resize(merges ? length * pixels : 0);
    std::size_t at = 0;
    bool is_any_stopped = false;
    for (std::size_t r = 0; r < count; at += receive_sizes[r], ++r) {
      StateReader reader(std::span<const std::byte>(receive_).subspan(at, numbers_size));
      IterationResult<S> one;
      reader(is_stopped);
      one.exchange_numbers(reader);
      is_any_stopped = is_any_stopped || is_stopped;
      if (r >= length) continue;
      std::span<const std::byte> bytes = std::span<const std::byte>(receive_).subspan(at, receive_sizes[r]);
      bytes = bytes.subspan(numbers_size);
      const auto take = [&](auto& pixels_of_all) {
        const auto own = std::span(pixels_of_all).subspan(r * pixels, pixels);
        const auto target = std::as_writable_bytes(own);
        std::copy_n(bytes.begin(), target.size(), target.begin());
        bytes = bytes.subspan(target.size());
        return own;
      };
      one.frame = take(frame_);
      if (merges) one.merging_change = take(change_);
      iterations_[r] = std::move(one);
    }
    return !is_any_stopped;
  }

  [[nodiscard]] PixelBounds stripe(std::size_t rank) const noexcept {
    return detail::stripe_of(picture_, static_cast<int>(rank), ranks_.count());
  }

  RanksRef ranks_;
  PixelBounds picture_;
  std::vector<IterationResult<S>> iterations_;
  std::vector<S> frame_;
  std::vector<float> change_;
  std::vector<std::byte> send_, receive_;
};

}  // namespace gmis
