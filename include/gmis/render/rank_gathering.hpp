#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/state_archive.hpp"
#include "gmis/render/ranks.hpp"
#include "gmis/render/run_identity.hpp"
#include "gmis/transport/state/pixel_bounds.hpp"

/// \file
/// Data of several ranks at rank 0, and how the rows of a picture are divided among ranks.

namespace gmis::detail {

/// The rows of a picture that a rank adds up: stripes of nearly equal height, the first on top.
[[nodiscard]] inline PixelBounds stripe_of(const PixelBounds& picture, int rank, int count) noexcept {
  const auto row = [&](int at) {
    const auto height = static_cast<std::int64_t>(picture.upper.y - picture.lower.y);
    return picture.lower.y + static_cast<int>(height * at / count);
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
