#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/executor_ref.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/core/state_archive.hpp"
#include "gmis/render/ranks.hpp"
#include "gmis/render/run_identity.hpp"
#include "gmis/result/batch_means.hpp"
#include "gmis/result/error_estimate.hpp"
#include "gmis/result/error_of_rows.hpp"
#include "gmis/result/rare_samples.hpp"
#include "gmis/result/row_copy.hpp"
#include "gmis/result/run_parts.hpp"
#include "gmis/transport/state/pixel_bounds.hpp"

/// \file
/// Data of several ranks at rank 0, and how the rows of a picture are divided among ranks.

namespace gmis::detail {

/// The rows of a picture that a rank adds up: stripes of nearly equal height, the first on top.
/// Where there are more ranks than rows, rank 0 has one.
[[nodiscard]] inline PixelBounds stripe_of(const PixelBounds& picture, int rank, int count) noexcept {
  const auto row = [&](int at) {
    const auto height = static_cast<std::int64_t>(picture.upper.y - picture.lower.y);
    return picture.lower.y + static_cast<int>((height * at + count - 1) / count);
  };
  return {{picture.lower.x, row(rank)}, {picture.upper.x, row(rank + 1)}};
}

/// Calls `use(rank, bytes)` at rank 0 with the bytes of each rank in turn, whatever their sizes;
/// never elsewhere.
template <class Use>
GMIS_RARE void for_each_rank(const RanksRef& ranks, std::span<const std::byte> bytes, Use&& use) {
  const std::size_t count = ranks.is_first() ? static_cast<std::size_t>(ranks.count()) : 0, size = bytes.size();
  std::vector<std::size_t> sizes(count), of_sizes(count, sizeof size);
  ranks.gather(std::as_bytes(std::span(&size, 1)), std::as_writable_bytes(std::span(sizes)), of_sizes);
  std::vector<std::byte> all(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}));
  ranks.gather(bytes, all, sizes);
  std::span<const std::byte> rest = all;
  for (std::size_t rank = 0; rank < count; ++rank)
    use(rank, std::exchange(rest, rest.subspan(sizes[rank])).first(sizes[rank]));
}

/// An archive that completes the sums of a picture at rank 0, whose own rows are in place already:
/// all ranks call `sums.exchange_state(gatherer)` together, rank 0 with the sums of the whole
/// picture, the others with those of their rows. Each vector of numbers holds values by rows.
class RowGatherer {
 public:
  /// `picture`: the rows of all ranks.
  RowGatherer(const RanksRef& ranks, const PixelBounds& picture) noexcept : ranks_(ranks), picture_(picture) {}

  template <class... Values>
  GMIS_RARE void operator()(Values&... values) {
    (exchange(values), ...);
  }

 private:
  /// Numbers that are no rows are the same on all ranks.
  template <class V>
  void exchange(V& value) {
    if constexpr (requires { value.exchange_state(*this); }) value.exchange_state(*this);
  }
  template <class V>
  void exchange(std::vector<V>& values) {
    if constexpr (!std::is_trivially_copyable_v<V>)
      for (V& value : values) exchange(value);
    else
      gather(std::as_writable_bytes(std::span(values)));
  }
  /// `rows`: bytes of the whole picture at rank 0, elsewhere of the rows there.
  GMIS_RARE void gather(std::span<std::byte> rows) {
    if (!ranks_.is_first()) return ranks_.gather(rows, {}, {});
    const std::size_t row = rows.size() / std::max<std::size_t>(1, rows_between(picture_));
    std::vector<std::size_t> sizes(static_cast<std::size_t>(ranks_.count()));
    for (std::size_t rank = 0; rank < sizes.size(); ++rank)
      sizes[rank] = row * rows_between(stripe_of(picture_, static_cast<int>(rank), ranks_.count()));
    const std::span<std::byte> of_others = rows.subspan(std::exchange(sizes[0], 0));
    ranks_.gather({}, of_others, sizes);
  }

  [[nodiscard]] static std::size_t rows_between(const PixelBounds& bounds) noexcept {
    return static_cast<std::size_t>(bounds.upper.y - bounds.lower.y);
  }

  const RanksRef& ranks_;
  PixelBounds picture_;
};

/// The rows of rank `from` that are around those of rank `to`, as far as neighbourhoods reach.
GMIS_RARE [[nodiscard]] inline RowCopy shared_rows(const PixelBounds& picture, int count, int from, int to) noexcept {
  const PixelBounds there = stripe_of(picture, from, count), here = stripe_of(picture, to, count);
  const int first = std::max(there.lower.y, here.lower.y - neighbourhood_reaches.back());
  const int end = std::min(there.upper.y, here.upper.y + neighbourhood_reaches.back());
  return from == to || end <= first ? RowCopy{} : RowCopy{first - there.lower.y, end - first};
}

/// The rows around those of this rank, from the ranks that have them. `own`: the rows of this rank.
template <Spectrum S>
GMIS_RARE [[nodiscard]] RowsAround rows_around(const RanksRef& ranks, const PixelBounds& picture,
                                               const BatchMeans<S>& own) {
  const std::size_t row_length = static_cast<std::size_t>(own.resolution().x) * BatchMeans<S>::channel_count;
  RowsAround around;
  std::vector<std::size_t> sent, sizes, received;  // indices of values that are sent; bytes by rank
  for (int rank = 0; rank < ranks.count(); ++rank) {
    const RowCopy to = shared_rows(picture, ranks.count(), ranks.rank(), rank);
    const RowCopy from = shared_rows(picture, ranks.count(), rank, ranks.rank());
    for (std::size_t k = 0; k < static_cast<std::size_t>(to.count) * row_length; ++k)
      sent.push_back(static_cast<std::size_t>(to.from) * row_length + k);
    sizes.push_back(static_cast<std::size_t>(to.count) * row_length * sizeof(double));
    received.push_back(static_cast<std::size_t>(from.count) * row_length * sizeof(double));
    (rank < ranks.rank() ? around.above : around.below) += from.count;
  }
  const RunParts<S> parts(own);
  std::vector<double> values(sent.size());
  around.part_values.resize(parts.count());
  for (std::size_t b = 0; b < parts.count(); ++b) {
    around.part_values[b].resize(static_cast<std::size_t>(around.above + around.below) * row_length);
    for (std::size_t k = 0; k < sent.size(); ++k) values[k] = parts.value(b, sent[k]);
    ranks.exchange(std::as_bytes(std::span(values)), sizes, std::as_writable_bytes(std::span(around.part_values[b])),
                   received);
  }
  return around;
}

/// The error of a picture from the rows of all ranks (`estimate_error`), on all of them. `own`: the
/// rows of this rank.
template <Spectrum S>
GMIS_RARE [[nodiscard]] std::optional<ErrorEstimate> error_over_ranks(const RanksRef& ranks, const PixelBounds& picture,
                                                                      const BatchMeans<S>& own, ExecutorRef executor) {
  if (ranks.count() == 1) return estimate_error(own, executor);
  ErrorOfRows<S> rows(own, executor, rows_around(ranks, picture, own));
  if (ranks.is_first()) rows.make_room(static_cast<std::size_t>(picture.upper.y - picture.lower.y));
  RowGatherer gatherer(ranks, picture);
  gatherer(rows.brightness_by_row());
  rows.add_rare(ranks.of_first(rows.brightness()), executor);
  gatherer(rows);
  return ranks.of_first(ranks.is_first() ? estimate_error(rows) : std::nullopt);
}

/// The text of rank 0, on all ranks.
[[nodiscard]] inline std::string text_of_first(const RanksRef& ranks, std::string text) {
  text.resize(ranks.of_first(text.size()));
  ranks.broadcast(std::as_writable_bytes(std::span(text)));
  return text;
}

/// Rejects ranks whose run is another one than that of rank 0, on all ranks, with a message that
/// names the first of them and what differs.
GMIS_RARE inline void require_same_run(const RanksRef& ranks, RunIdentity identity) {
  if (ranks.count() == 1) return;
  StateWriter mine;
  mine(identity);
  std::string difference;
  for_each_rank(ranks, mine.bytes(), [&](std::size_t rank, std::span<const std::byte> bytes) {
    RunIdentity other;
    StateReader reader(bytes);
    reader(other);
    const std::string differs = reader.is_broken() ? "it has another version" : other.difference_to(identity);
    if (difference.empty() && !differs.empty())
      difference = "rank " + std::to_string(rank) + " has another run than rank 0: " + differs;
  });
  difference = text_of_first(ranks, std::move(difference));
  if (!difference.empty()) reject_argument(difference.c_str());
}

}  // namespace gmis::detail
