#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/core/state_archive.hpp"
#include "gmis/render/ranks.hpp"
#include "gmis/render/run_identity.hpp"
#include "gmis/result/error_of_rows.hpp"
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

/// The bytes of each rank at rank 0, whatever their sizes; empty elsewhere.
[[nodiscard]] inline std::vector<std::vector<std::byte>> gathered(const RanksRef& ranks,
                                                                  std::span<const std::byte> bytes) {
  const std::size_t count = ranks.is_first() ? static_cast<std::size_t>(ranks.count()) : 0, size = bytes.size();
  std::vector<std::size_t> sizes(count), of_sizes(count, sizeof size);
  ranks.gather(std::as_bytes(std::span(&size, 1)), std::as_writable_bytes(std::span(sizes)), of_sizes);
  std::vector<std::byte> all(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}));
  ranks.gather(bytes, all, sizes);
  std::vector<std::vector<std::byte>> parts;
  std::size_t first = 0;
  for (const std::size_t part : sizes) {
    const std::byte* const begin = all.data() + first;
    parts.emplace_back(begin, begin + part);
    first += part;
  }
  return parts;
}

/// An archive that completes the sums of a picture at rank 0, whose own rows are in place already:
/// all ranks call `sums.exchange_state(gatherer)` together, rank 0 with the sums of the whole
/// picture, the others with those of their rows. Each vector of numbers holds values by rows.
class RowGatherer {
 public:
  /// It only reads on ranks other than 0.
  static constexpr bool is_reading = false;

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
    const std::size_t row = rows.size() / rows_between(picture_);
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

/// Completes the estimate of the error by rows at rank 0. `rows`: those of this rank, with room for
/// all at rank 0.
template <Spectrum S>
GMIS_RARE void gather_rows(const RanksRef& ranks, const PixelBounds& picture, ErrorOfRows<S>& rows) {
  if (ranks.count() == 1) return;
  const std::vector<std::vector<std::byte>> rare = gathered(ranks, std::as_bytes(std::span(rows.rare())));
  RowGatherer gatherer(ranks, picture);
  rows.exchange_state(gatherer);
  for (std::size_t rank = 1; rank < rare.size(); ++rank) {
    const std::size_t first = rows.rare().size();
    rows.rare().resize(first + rare[rank].size() / sizeof(RareSample));
    std::copy(rare[rank].begin(), rare[rank].end(),
              std::as_writable_bytes(std::span(rows.rare()).subspan(first)).begin());
  }
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
  int rank = 0;
  for (const std::vector<std::byte>& bytes : gathered(ranks, mine.bytes())) {
    RunIdentity other;
    StateReader reader(bytes);
    reader(other);
    const std::string differs = reader.is_broken() ? "it has another version" : other.difference_to(identity);
    if (difference.empty() && !differs.empty())
      difference = "rank " + std::to_string(rank) + " has another run than rank 0: " + differs;
    ++rank;
  }
  difference = text_of_first(ranks, std::move(difference));
  if (!difference.empty()) reject_argument(difference.c_str());
}

}  // namespace gmis::detail
