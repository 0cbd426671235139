#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/executor_ref.hpp"
#include "gmis/core/state_archive.hpp"
#include "gmis/render/iteration_result.hpp"
#include "gmis/render/rank_gathering.hpp"
#include "gmis/render/ranks.hpp"
#include "gmis/transport/engine/any_engine.hpp"

namespace gmis {

/// A round of a run over ranks: each renders some of the iterations to come, then each gets its
/// rows of the frames of all. Random numbers are keyed by iteration, so that it does not matter who
/// renders which.
template <Spectrum S>
class RankRound {
 public:
  /// `picture`: the rendered part of the frame.
  RankRound(RanksRef ranks, const PixelBounds& picture)
      : ranks_(ranks), picture_(picture), place_(static_cast<std::size_t>(ranks.count())) {}

  /// Number of iterations of the round after the first `done`, where nothing else limits it: one
  /// for one rank; one a rank for several at first, and more later. Ranks wait for each other once
  /// a round; but what an interrupt or a limit of time or error throws away stays a small part, and
  /// so does what a rank holds to send. `has_known_end`: a number of iterations alone ends the run.
  [[nodiscard]] std::uint32_t length_after(std::uint32_t done, bool has_known_end) const noexcept {
    if (rank_count() == 1) return 1;
    const std::size_t pixels = std::max<std::size_t>(1, pixel_count(picture_));
    const auto most = static_cast<std::uint32_t>(std::clamp<std::size_t>((std::size_t{1} << 22U) / pixels, 1, 8));
    return rank_count() * std::clamp(done / ((has_known_end ? 4 : 32) * rank_count()), 1U, most);
  }

  /// Renders the iterations `done` + 1 to `done` + `length`, dealt to the ranks in turn; one rank
  /// alone renders one. Afterwards the engine has no work. Returns false when the executor of any
  /// rank was stopped: the round is left out.
  GMIS_RARE [[nodiscard]] bool render(AnyEngine<S>& engine, ExecutorRef executor, std::uint32_t done,
                                      std::uint32_t length) {
    if (ranks_.count() == 1) {
      iterations_ = std::vector<IterationResult<S>>(1);
      iterations_[0] = next_of(engine, executor, done);
      iterations_[0].frame = part_of(engine, iterations_[0].frame, frame_);
      iterations_[0].merging_change = part_of(engine, iterations_[0].merging_change, change_);
      return !executor.is_stopped();
    }
    const bool merges = !engine.merging_change().empty();
    const auto rank = static_cast<std::size_t>(ranks_.rank());
    std::vector<std::size_t> send_sizes(rank_count()), receive_sizes(rank_count());
    for (std::size_t r = 0; r < rank_count(); ++r) {
      send_sizes[r] = size_between(rank, r, length, merges);
      receive_sizes[r] = size_between(r, rank, length, merges);
    }
    send_.assign(std::accumulate(send_sizes.begin(), send_sizes.end(), std::size_t{0}), std::byte{0});
    std::exclusive_scan(send_sizes.begin(), send_sizes.end(), place_.begin(), std::size_t{1});
    bool is_stopped = false;
    for (auto i = static_cast<std::uint32_t>(rank); i < length && !is_stopped; i += rank_count()) {
      pack(engine, next_of(engine, executor, done + i));
      is_stopped = executor.is_stopped();
    }
    for (std::size_t r = 0, first = 0; r < rank_count(); first += send_sizes[r], ++r)
      send_[first] = static_cast<std::byte>(is_stopped);
    receive_.resize(std::accumulate(receive_sizes.begin(), receive_sizes.end(), std::size_t{0}));
    ranks_.exchange(send_, send_sizes, receive_, receive_sizes);
    return unpack(merges, length);
  }

  /// The iterations of the latest round in their order; their pixels stay until the next round.
  [[nodiscard]] std::span<const IterationResult<S>> iterations() const noexcept { return iterations_; }

 private:
  /// Bytes reserved for the numbers of an iteration, with all rejected paths that are kept.
  static constexpr std::size_t numbers_size =
      sizeof(IterationResult<S>) + RejectionLog::capacity * sizeof(RejectedPath) + 64;

  [[nodiscard]] std::uint32_t rank_count() const noexcept { return static_cast<std::uint32_t>(ranks_.count()); }
  [[nodiscard]] PixelBounds stripe(std::size_t rank) const noexcept {
    return detail::stripe_of(picture_, static_cast<int>(rank), ranks_.count());
  }

  [[nodiscard]] static std::size_t pixel_count(const PixelBounds& bounds) noexcept {
    const glm::ivec2 size = bounds.upper - bounds.lower;
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  }
  /// Bytes that rank `from` sends to rank `to`: one that says whether `from` was stopped, then its
  /// iterations, numbers and rows of `to`.
  [[nodiscard]] std::size_t size_between(std::size_t from, std::size_t to, std::uint32_t length,
                                         bool merges) const noexcept {
    const std::size_t iterations = (length + rank_count() - 1 - from) / rank_count();
    return 1 + iterations * (numbers_size + pixel_count(stripe(to)) * (sizeof(S) + (merges ? sizeof(float) : 0)));
  }

  /// Renders the iteration after `done`; its pixels are the engine's.
  GMIS_RARE static IterationResult<S> next_of(AnyEngine<S>& engine, ExecutorRef executor, std::uint32_t done) {
    const std::clock_t start = std::clock();
    engine.continue_after(done);
    engine.iterate(executor);
    return {.frame = engine.frame(),
            .merging_change = engine.merging_change(),
            .merged_light = engine.merged_light(),
            .cpu_seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC,
            .work = engine.take_work()};
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

  /// Adds an iteration to what each rank is sent: its numbers, and the rows of that rank.
  GMIS_RARE void pack(const AnyEngine<S>& engine, IterationResult<S> one) {
    StateWriter numbers;
    one.exchange_numbers(numbers);
    for (std::size_t r = 0; r < rank_count(); ++r) {
      const auto add = [&](auto row) {
        const auto bytes = std::as_bytes(row);
        std::copy(bytes.begin(), bytes.end(), send_.begin() + static_cast<std::ptrdiff_t>(place_[r]));
        place_[r] += bytes.size();
      };
      const std::size_t end = place_[r] + numbers_size;
      add(std::span(numbers.bytes()));
      place_[r] = end;
      for_each_row(engine, one.frame, stripe(r), add);
      for_each_row(engine, one.merging_change, stripe(r), add);
    }
  }

  /// Reads what all ranks have sent. Returns false when one was stopped: what it did not render is
  /// zeros.
  GMIS_RARE bool unpack(bool merges, std::uint32_t length) {
    const std::size_t own = pixel_count(stripe(static_cast<std::size_t>(ranks_.rank())));
    iterations_ = std::vector<IterationResult<S>>(length);
    frame_.resize(length * own);
    change_.resize(merges ? length * own : 0);
    bool is_stopped = false;
    std::span<const std::byte> bytes(receive_);
    const auto next = [&bytes](std::size_t size) { return std::exchange(bytes, bytes.subspan(size)).first(size); };
    const auto pixels_of = [&](std::size_t iteration, auto& pixels_of_all) {
      const auto pixels = std::span(pixels_of_all).subspan(iteration * own, own);
      const auto from = next(pixels.size_bytes());
      std::copy(from.begin(), from.end(), std::as_writable_bytes(pixels).begin());
      return pixels;
    };
    for (std::size_t r = 0; r < rank_count(); ++r) {
      is_stopped = next(1)[0] != std::byte{0} || is_stopped;
      for (std::size_t i = r; i < length; i += rank_count()) {
        StateReader reader(next(numbers_size));
        iterations_[i].exchange_numbers(reader);
        iterations_[i].frame = pixels_of(i, frame_);
        if (merges) iterations_[i].merging_change = pixels_of(i, change_);
      }
    }
    return !is_stopped;
  }

  RanksRef ranks_;
  PixelBounds picture_;
  std::vector<IterationResult<S>> iterations_;
  std::vector<S> frame_;
  std::vector<float> change_;
  std::vector<std::byte> send_, receive_;
  std::vector<std::size_t> place_;  // by rank: where in `send_` its next bytes go
};

}  // namespace gmis
