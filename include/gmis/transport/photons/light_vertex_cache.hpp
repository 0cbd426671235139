#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "gmis/core/concepts.hpp"
#include "gmis/transport/photons/resize_for_overwrite.hpp"

namespace gmis {

/// The light vertices of one iteration as `Vertex`, in the order of their trees. Each chunk holds
/// consecutive trees and is written by one thread at a time; different chunks may be written
/// concurrently. Memory is reused from one iteration to the next.
template <class Vertex>
class LightVertexCache {
 public:
  /// The vertices of consecutive trees.
  class Chunk {
   public:
    constexpr void clear() noexcept {
      vertices_.clear();
      tree_ends_.clear();
      photon_count_ = 0;
    }
    void add(const auto& vertex) {
      // An eighth more at a time, not twice as much: what is reserved is held for the whole run.
      if (vertices_.size() == vertices_.capacity()) [[unlikely]]
        vertices_.reserve(vertices_.size() + vertices_.size() / 8 + 64);
      vertices_.emplace_back(vertex);
      photon_count_ += vertex.is_photon ? 1U : 0U;
    }
    /// Ends the current tree; call it once per tree, also for a tree without vertices.
    void end_tree() { tree_ends_.push_back(static_cast<std::uint32_t>(vertices_.size())); }
    [[nodiscard]] constexpr std::size_t size() const noexcept { return vertices_.size(); }

   private:
    friend LightVertexCache;
    std::vector<Vertex> vertices_;
    std::vector<std::uint32_t> tree_ends_;
    std::size_t photon_count_ = 0;
  };

  /// Tree t belongs to chunk t / `trees_per_chunk`.
  void resize(std::size_t chunk_count, std::size_t trees_per_chunk) {
    chunks_.resize(chunk_count);
    trees_per_chunk_ = trees_per_chunk;
  }
  [[nodiscard]] constexpr Chunk& chunk(std::size_t index) noexcept { return chunks_[index]; }

  /// Numbers all vertices in the order of their trees, for `operator[]` and `photons`. Call it when
  /// all chunks are complete.
  template <Executor E>
  void gather(E& executor) {
    struct Place {
      std::size_t vertex = 0, photon = 0;
    };
    std::vector<Place> places(chunks_.size() + 1);  // where each chunk begins
    for (std::size_t i = 0; i < chunks_.size(); ++i)
      places[i + 1] = {places[i].vertex + chunks_[i].size(), places[i].photon + chunks_[i].photon_count_};
    detail::resize_for_overwrite(vertices_, places.back().vertex);
    detail::resize_for_overwrite(photons_, places.back().photon);
    executor.parallel_for(chunks_.size(), [&](std::size_t i) {
      auto [vertex, photon] = places[i];
      for (const Vertex& one : chunks_[i].vertices_) {
        if (one.is_photon()) photons_[photon++] = static_cast<std::uint32_t>(vertex);
        vertices_[vertex++] = &one;
      }
    });
  }
  /// Number of vertices at the last `gather`.
  [[nodiscard]] constexpr std::size_t size() const noexcept { return vertices_.size(); }
  /// The numbers of the vertices that merging gathers, at the last `gather`.
  [[nodiscard]] constexpr std::span<const std::uint32_t> photons() const noexcept { return photons_; }
  /// Vertex `index` in the order of the trees.
  [[nodiscard]] const Vertex& operator[](std::size_t index) const noexcept { return *vertices_[index]; }

  /// The vertices of one tree; needs no `gather`.
  [[nodiscard]] constexpr std::span<const Vertex> tree(std::size_t number) const noexcept {
    const Chunk& chunk = chunks_[number / trees_per_chunk_];
    const std::size_t local = number % trees_per_chunk_;
    const std::size_t begin = local == 0 ? 0 : chunk.tree_ends_[local - 1];
    return {chunk.vertices_.data() + begin, chunk.tree_ends_[local] - begin};
  }

  /// Number of the tree that holds `vertex`, a reference into this cache; the largest `std::size_t`
  /// when no tree holds it. Takes time proportional to the number of chunks.
  [[nodiscard]] constexpr std::size_t tree_of(const Vertex& vertex) const noexcept {
    for (std::size_t i = 0; i < chunks_.size(); ++i) {
      const std::vector<Vertex>& vertices = chunks_[i].vertices_;
      const std::vector<std::uint32_t>& ends = chunks_[i].tree_ends_;
      if (vertices.empty() || std::less<>{}(&vertex, &vertices.front()) || std::less<>{}(&vertices.back(), &vertex))
        continue;
      const auto place = static_cast<std::uint32_t>(&vertex - vertices.data());
      const auto tree = std::upper_bound(ends.begin(), ends.end(), place) - ends.begin();
      return i * trees_per_chunk_ + static_cast<std::size_t>(tree);
    }
    return static_cast<std::size_t>(-1);
  }

  /// Bytes of memory held.
  [[nodiscard]] constexpr std::size_t byte_count() const noexcept {
    std::size_t bytes = vertices_.capacity() * sizeof(vertices_[0]) + photons_.capacity() * sizeof(photons_[0]);
    for (const Chunk& chunk : chunks_)
      bytes += chunk.vertices_.capacity() * sizeof(Vertex) + chunk.tree_ends_.capacity() * sizeof(std::uint32_t);
    return bytes;
  }

 private:
  std::vector<Chunk> chunks_;
  std::size_t trees_per_chunk_ = 1;
  std::vector<const Vertex*> vertices_;
  std::vector<std::uint32_t> photons_;
};

}  // namespace gmis
