#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/executor_ref.hpp"
#include "gmis/scene/bvh.hpp"
#include "gmis/scene/bvh_split.hpp"

namespace gmis::scene {

template <std::floating_point T>
using TriangleCorners = std::array<Vec3<T>, 3>;

template <std::floating_point T>
struct SphereShape {
  Vec3<T> center;
  T radius;
};

/// The tree, and which input each slot of its packets holds (`empty_slot` for none).
template <std::floating_point T>
struct BuiltBvh {
  static constexpr std::uint32_t empty_slot = std::numeric_limits<std::uint32_t>::max();
  Bvh<T> bvh;
  std::vector<std::uint32_t> triangle_in_slot;
  std::vector<std::uint32_t> sphere_in_slot;
};

/// Builds a tree of eight-way nodes over packets: a binary tree first (`BvhSplitter`), of which
/// every three levels or so become one node. The executor's threads share the work, and the tree
/// has the same bits for any number of them. In float, building a mesh takes at most 80 bytes a
/// triangle beyond the input, the result included: 288 for each packet, of which 5 to 6 places are
/// taken. Small triangles far apart get packets of their own, and more memory.
template <std::floating_point T>
class BvhBuilder {
 public:
  BvhBuilder(std::span<const TriangleCorners<T>> triangles, std::span<const SphereShape<T>> spheres)
      : triangles_(triangles), spheres_(spheres) {}

  [[nodiscard]] BuiltBvh<T> build() const {
    const SerialExecutor serial;
    return build(serial);
  }

  [[nodiscard]] BuiltBvh<T> build(ExecutorRef executor) const {
    BuiltBvh<T> result;
    if (triangles_.empty() && spheres_.empty()) return result;
    std::vector<Node> nodes;
    {
      std::vector<BvhItem<T>> items = make_items(executor);
      nodes = BvhSplitter<T>::split(std::span<BvhItem<T>>(items), executor);
      fill_slots(nodes, items, result, executor);
    }
    result.bvh.root = emit(nodes, 0, result.bvh.nodes);
    nodes = {};
    result.bvh.nodes.shrink_to_fit();
    fill_packets(result, executor);
    return result;
  }

 private:
  using Node = BvhSplit<T>;
  static constexpr std::size_t chunk_size = 8192;

  /// Calls `work(begin, end)` for pieces of 0 … count.
  template <class Work>
  static void for_chunks(ExecutorRef executor, std::size_t count, Work&& work) {
    executor.parallel_for((count + chunk_size - 1) / chunk_size,
                          [&](std::size_t i) { work(i * chunk_size, std::min(count, (i + 1) * chunk_size)); });
  }

  [[nodiscard]] std::vector<BvhItem<T>> make_items(ExecutorRef executor) const {
    std::vector<BvhItem<T>> items(triangles_.size() + spheres_.size());
    for_chunks(executor, items.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        items[i] = i < triangles_.size() ? item_of(triangles_[i], i)
                                         : item_of(spheres_[i - triangles_.size()], i - triangles_.size());
    });
    return items;
  }
  [[nodiscard]] static BvhItem<T> item_of(const TriangleCorners<T>& corners, std::size_t index) noexcept {
    const auto& [a, b, c] = corners;
    return item_of(glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c)), BvhChild::triangles, index);
  }
  [[nodiscard]] static BvhItem<T> item_of(const SphereShape<T>& sphere, std::size_t index) noexcept {
    return item_of(sphere.center - sphere.radius, sphere.center + sphere.radius, BvhChild::spheres, index);
  }
  [[nodiscard]] static BvhItem<T> item_of(const Vec3<T>& lower, const Vec3<T>& upper, BvhChild::Kind kind,
                                          std::size_t index) noexcept {
    BvhItem<T> item;
    item.kind = kind;
    item.index = static_cast<std::uint32_t>(index);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const T low = lower[static_cast<int>(axis)], high = upper[static_cast<int>(axis)];
      // The primitive tests round relative to the coordinates, so what they hit may lie that far
      // outside.
      const T padding = 8 * std::numeric_limits<T>::epsilon() * std::max(std::abs(low), std::abs(high));
      item.lower[axis] = low - padding;
      item.upper[axis] = high + padding;
    }
    return item;
  }

  /// Numbers the packets in the order of the leaves, writes which primitive each slot holds, and
  /// lets each leaf's `first` be its packet.
  static void fill_slots(std::vector<Node>& nodes, const std::vector<BvhItem<T>>& items, BuiltBvh<T>& result,
                         ExecutorRef executor) {
    using Counts = std::array<std::size_t, 2>;  // triangle packets, sphere packets
    const auto kind_of = [](const Node& leaf) { return leaf.kind == BvhChild::triangles ? 0U : 1U; };
    std::vector<Counts> before((nodes.size() + chunk_size - 1) / chunk_size);
    for_chunks(executor, nodes.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        if (nodes[i].is_leaf()) ++before[begin / chunk_size][kind_of(nodes[i])];
    });
    Counts sum{};
    for (Counts& counts : before)
      for (std::size_t kind = 0; kind < 2; ++kind) sum[kind] += std::exchange(counts[kind], sum[kind]);
    result.triangle_in_slot.assign(sum[0] * lane_count, BuiltBvh<T>::empty_slot);
    result.sphere_in_slot.assign(sum[1] * lane_count, BuiltBvh<T>::empty_slot);
    for_chunks(executor, nodes.size(), [&](std::size_t begin, std::size_t end) {
      Counts packet = before[begin / chunk_size];
      for (std::size_t i = begin; i < end; ++i) {
        Node& node = nodes[i];
        if (!node.is_leaf()) continue;
        const unsigned kind = kind_of(node);
        auto& in_slot = kind == 0 ? result.triangle_in_slot : result.sphere_in_slot;
        for (std::size_t lane = 0; lane < node.count; ++lane)
          in_slot[packet[kind] * lane_count + lane] = items[node.first + lane].index;
        node.first = static_cast<std::uint32_t>(packet[kind]++);
      }
    });
  }

  [[nodiscard]] static BvhChild emit(const std::vector<Node>& nodes, std::uint32_t number,
                                     std::vector<BvhNode<T>>& wide) {
    const Node& top = nodes[number];
    if (top.is_leaf()) return BvhChild::to(static_cast<BvhChild::Kind>(top.kind), top.first);
    // Open the largest inner child until there are eight.
    std::array<std::uint32_t, lane_count> children{top.first, top.first + 1};
    std::array<T, lane_count> areas;  // 0 of a leaf
    const auto area = [&](std::uint32_t child) { return nodes[child].is_leaf() ? T(0) : nodes[child].half_area(); };
    areas[0] = area(children[0]);
    areas[1] = area(children[1]);
    std::size_t count = 2;
    for (; count < lane_count; ++count) {
      std::size_t largest = 0;
      for (std::size_t i = 1; i < count; ++i)
        if (areas[i] > areas[largest]) largest = i;
      if (!(areas[largest] > T(0))) {
        // Without area, and yet no leaf.
        const auto inner = std::find_if(children.begin(), children.begin() + static_cast<std::ptrdiff_t>(count),
                                        [&](std::uint32_t child) { return !nodes[child].is_leaf(); });
        largest = static_cast<std::size_t>(inner - children.begin());
        if (largest == count) break;
      }
      const std::uint32_t opened = children[largest];
      for (std::size_t i = 0; i < 2; ++i) {
        const std::size_t at = i == 0 ? largest : count;
        children[at] = nodes[opened].first + static_cast<std::uint32_t>(i);
        areas[at] = area(children[at]);
      }
    }
    const std::size_t place = wide.size();
    wide.emplace_back();
    for (std::size_t i = 0; i < count; ++i) {
      const BvhChild child = emit(nodes, children[i], wide);
      BvhNode<T>& node = wide[place];
      node.children[i] = child;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node.plane(2 * axis, i) = nodes[children[i]].lower[axis];
        node.plane(2 * axis + 1, i) = nodes[children[i]].upper[axis];
      }
    }
    return BvhChild::to(BvhChild::node, place);
  }

  void fill_packets(BuiltBvh<T>& result, ExecutorRef executor) const {
    result.bvh.triangles.resize(result.triangle_in_slot.size() / lane_count);
    for_chunks(executor, result.triangle_in_slot.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t slot = begin; slot < end; ++slot) {
        const std::uint32_t index = result.triangle_in_slot[slot];
        if (index == BuiltBvh<T>::empty_slot) continue;
        TrianglePacket<T>& packet = result.bvh.triangles[slot / lane_count];
        for (std::size_t corner = 0; corner < 3; ++corner)
          for (std::size_t axis = 0; axis < 3; ++axis)
            packet.corners[corner][axis][slot % lane_count] = triangles_[index][corner][static_cast<int>(axis)];
      }
    });
    result.bvh.spheres.resize(result.sphere_in_slot.size() / lane_count);
    for_chunks(executor, result.sphere_in_slot.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t slot = begin; slot < end; ++slot) {
        const std::uint32_t index = result.sphere_in_slot[slot];
        SpherePacket<T>& packet = result.bvh.spheres[slot / lane_count];
        const std::size_t lane = slot % lane_count;
        packet.radius_squared[lane] = T(-1);
        if (index == BuiltBvh<T>::empty_slot) continue;
        for (std::size_t axis = 0; axis < 3; ++axis)
          packet.center[axis][lane] = spheres_[index].center[static_cast<int>(axis)];
        packet.radius_squared[lane] = square(spheres_[index].radius);
      }
    });
  }

  std::span<const TriangleCorners<T>> triangles_;
  std::span<const SphereShape<T>> spheres_;
};

}  // namespace gmis::scene
