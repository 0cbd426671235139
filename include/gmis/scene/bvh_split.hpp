#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "gmis/core/executor_ref.hpp"
#include "gmis/scene/bvh_bins.hpp"

namespace gmis::scene {

/// A node of the binary tree that `BvhSplitter` makes: 32 bytes in float.
template <std::floating_point T>
struct BvhSplit {
  std::array<T, 3> lower, upper;
  std::uint32_t first;      ///< of a leaf its first item, else its left child; the right one is next to it
  std::uint16_t count = 0;  ///< items of a leaf
  std::uint16_t kind = BvhChild::node;

  void set_box(const Bounds<T>& box) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower[axis] = box.lower[axis];
      upper[axis] = box.upper[axis];
    }
  }
  [[nodiscard]] bool is_leaf() const noexcept { return kind != BvhChild::node; }
  [[nodiscard]] T half_area() const noexcept {
    const T x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
    return x * y + y * z + z * x;
  }
};

/// Sorts items into a binary tree by the surface area heuristic. A leaf is a packet, so a leaf of
/// eight items costs the same as a leaf of one. Large ranges are cut one level at a time, their
/// bins filled by all threads; the ranges that remain are trees of their own, one work item each.
/// The cuts depend on the items alone: the tree has the same bits for any number of threads.
template <std::floating_point T>
class BvhSplitter {
 public:
  using Node = BvhSplit<T>;

  /// `items` are reordered. The root is the first node.
  [[nodiscard]] static std::vector<Node> split(std::span<BvhItem<T>> items, ExecutorRef executor) {
    std::vector<Range> large, small;
    std::vector<Node> nodes(1);
    Range whole{0, static_cast<std::uint32_t>(items.size()), 0, 0, {}, {}};
    std::vector<Range> of_chunks(chunks_of(items.size()));
    executor.parallel_for(of_chunks.size(), [&](std::size_t i) {
      for (const BvhItem<T>& item : chunk(items, i)) of_chunks[i].add(item);
    });
    for (const Range& part : of_chunks) {
      whole.box.add(part.box);
      whole.centroids.add(part.centroids);
    }
    nodes[0].set_box(whole.box);
    const std::size_t grain = std::max<std::size_t>(items.size() / 64, 4096);
    (whole.count() > grain ? large : small).push_back(whole);

    while (!large.empty()) {
      const std::vector<BvhBins<T>> bins = fill_bins(items, large, executor);
      std::vector<std::array<Range, 2>> halves(large.size());
      executor.parallel_for(large.size(), [&](std::size_t i) { halves[i] = *cut(items, large[i], bins[i]); });
      std::vector<Range> next;
      for (std::size_t i = 0; i < large.size(); ++i) {
        nodes[large[i].node].first = static_cast<std::uint32_t>(nodes.size());
        for (Range& half : halves[i]) {
          half.node = static_cast<std::uint32_t>(nodes.size());
          nodes.emplace_back().set_box(half.box);
          (half.count() > grain ? next : small).push_back(half);
        }
      }
      large = std::move(next);
    }

    std::vector<std::vector<Node>> trees(small.size());
    executor.parallel_for(small.size(), [&](std::size_t i) {
      std::vector<Node> tree(1);
      tree.reserve(small[i].count());
      tree[0].set_box(small[i].box);
      grow(items, small[i], tree, 0);
      trees[i].assign(tree.begin(), tree.end());  // no larger than it is
    });
    return joined(std::move(nodes), small, std::move(trees), executor);
  }

 private:
  struct Range {
    std::uint32_t begin, end;
    std::uint32_t node;
    int depth;
    Bounds<T> box, centroids;

    [[nodiscard]] std::uint32_t count() const noexcept { return end - begin; }
    void add(const BvhItem<T>& item) noexcept {
      const Bounds<T> added = item.bounds();
      box.add(added);
      centroids.add(doubled_centroid(added));
    }
  };

  /// Cost of one cut relative to one packet; a node of eight is one test for seven cuts.
  static constexpr T cut_cost = T(0.3);
  static constexpr int heuristic_depth = 40;  ///< deeper down, halves: 2^30 items need no more than 30 further levels
  static constexpr std::size_t chunk_size = 16384;

  [[nodiscard]] static std::size_t chunks_of(std::size_t count) noexcept {
    return (count + chunk_size - 1) / chunk_size;
  }
  [[nodiscard]] static std::span<const BvhItem<T>> chunk(std::span<const BvhItem<T>> items, std::size_t i) noexcept {
    return items.subspan(i * chunk_size, std::min(chunk_size, items.size() - i * chunk_size));
  }

  [[nodiscard]] static std::vector<BvhBins<T>> fill_bins(std::span<const BvhItem<T>> items,
                                                         const std::vector<Range>& ranges, ExecutorRef executor) {
    struct Piece {
      std::size_t range, chunk;
    };
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < ranges.size(); ++i)
      for (std::size_t k = 0; k < chunks_of(ranges[i].count()); ++k) pieces.push_back({i, k});
    std::vector<BvhBins<T>> of_pieces(pieces.size()), result(ranges.size());
    executor.parallel_for(pieces.size(), [&](std::size_t i) {
      const Range& range = ranges[pieces[i].range];
      of_pieces[i].add(chunk(items.subspan(range.begin, range.count()), pieces[i].chunk),
                       BvhBinGrid<T>(range.centroids));
    });
    for (std::size_t i = 0; i < pieces.size(); ++i) result[pieces[i].range].add(of_pieces[i]);
    return result;
  }

  /// The two parts, or none when the range is to be a leaf.
  [[nodiscard]] static std::optional<std::array<Range, 2>> cut(std::span<BvhItem<T>> items, const Range& range,
                                                               const BvhBins<T>& bins) {
    const BvhCut<T> best = range.depth < heuristic_depth ? bins.best_cut() : BvhCut<T>{};
    const auto first = items.begin() + range.begin, last = items.begin() + range.end;
    const auto is_triangle = [](const BvhItem<T>& item) { return item.kind == BvhChild::triangles; };
    const bool is_small = range.count() <= lane_count;
    const bool is_mixed =
        is_small && !std::all_of(first, last, [&](const BvhItem<T>& i) { return i.kind == first->kind; });
    if (is_small && !is_mixed && !(best.cost < range.box.half_area() * (T(1) - cut_cost))) return std::nullopt;

    std::array<Range, 2> parts{Range{range.begin, range.end, 0, range.depth + 1, {}, {}},
                               Range{range.begin, range.end, 0, range.depth + 1, {}, {}}};
    auto middle = first + range.count() / 2;  // where nothing tells them apart, or the tree is deep
    if (best.axis >= 0) {
      const BvhBinGrid<T> grid(range.centroids);
      middle = partition(first, last, grid, best, parts);
      const auto boxes = bins.boxes(best);
      parts[0].box = boxes[0];
      parts[1].box = boxes[1];
    } else {
      if (is_mixed) middle = std::partition(first, last, is_triangle);
      for (auto item = first; item != last; ++item) parts[item < middle ? 0 : 1].add(*item);
    }
    parts[0].end = parts[1].begin = static_cast<std::uint32_t>(middle - items.begin());
    return parts;
  }

  /// Brings the items left of the cut to the front and finds the centroids of both sides.
  template <class Iterator>
  [[nodiscard]] static Iterator partition(Iterator first, Iterator last, const BvhBinGrid<T>& grid,
                                          const BvhCut<T>& cut, std::array<Range, 2>& parts) noexcept {
    const auto axis = static_cast<std::size_t>(cut.axis);
    const auto last_bin = static_cast<std::int32_t>(cut.last_bin);
    Bounds<T> left, right;
    const auto goes_left = [&](const BvhItem<T>& item) {
      const Bounds<T> box = item.bounds();
      const bool result = grid.bins_of(box)[axis] <= last_bin;
      (result ? left : right).add(doubled_centroid(box));
      return result;
    };
    for (;;) {
      while (first != last && goes_left(*first)) ++first;
      if (first == last) break;
      do {
        --last;
      } while (first != last && !goes_left(*last));
      if (first == last) break;
      std::swap(*first, *last);
      ++first;
    }
    parts[0].centroids = left;
    parts[1].centroids = right;
    return first;
  }

  static void grow(std::span<BvhItem<T>> items, const Range& range, std::vector<Node>& nodes, std::uint32_t number) {
    BvhBins<T> bins;
    bins.add(items.subspan(range.begin, range.count()), BvhBinGrid<T>(range.centroids));
    const auto parts = cut(items, range, bins);
    if (!parts) {
      nodes[number].first = range.begin;
      nodes[number].count = static_cast<std::uint16_t>(range.count());
      nodes[number].kind = static_cast<std::uint16_t>(items[range.begin].kind);
      return;
    }
    const auto child = static_cast<std::uint32_t>(nodes.size());
    nodes[number].first = child;
    for (const Range& part : *parts) nodes.emplace_back().set_box(part.box);
    grow(items, (*parts)[0], nodes, child);
    grow(items, (*parts)[1], nodes, child + 1);
  }

  /// One array: the root of each tree takes the place that was kept for it, the rest follows.
  [[nodiscard]] static std::vector<Node> joined(std::vector<Node> nodes, const std::vector<Range>& roots,
                                                std::vector<std::vector<Node>> trees, ExecutorRef executor) {
    std::vector<std::size_t> places;
    std::size_t count = nodes.size();
    for (const auto& tree : trees) {
      places.push_back(count);
      count += tree.size() - 1;
    }
    nodes.resize(count);
    executor.parallel_for(trees.size(), [&](std::size_t i) {
      for (std::size_t k = 0; k < trees[i].size(); ++k) {
        Node& node = nodes[k == 0 ? roots[i].node : places[i] + k - 1];
        node = trees[i][k];
        if (!node.is_leaf()) node.first += static_cast<std::uint32_t>(places[i]) - 1;
      }
      trees[i] = {};
    });
    return nodes;
  }
};

}  // namespace gmis::scene
