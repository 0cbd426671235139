#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "gmis/scene/bvh.hpp"

namespace gmis::scene {

/// An axis-aligned box; empty until something is added.
template <std::floating_point T>
struct Box {
  Vec3<T> lower{std::numeric_limits<T>::infinity()};
  Vec3<T> upper{-std::numeric_limits<T>::infinity()};

  void add(const Vec3<T>& point) noexcept {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], point[axis]);
      upper[axis] = std::max(upper[axis], point[axis]);
    }
  }
  /// An empty box adds nothing.
  void add(const Box& box) noexcept {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], box.lower[axis]);
      upper[axis] = std::max(upper[axis], box.upper[axis]);
    }
  }
  [[nodiscard]] bool is_empty() const noexcept { return !(lower.x <= upper.x); }
  /// Half the surface area.
  [[nodiscard]] T half_area() const noexcept {
    if (is_empty()) return T(0);
    const Vec3<T> size = upper - lower;
    return size.x * size.y + size.y * size.z + size.z * size.x;
  }
};

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

/// Builds by the surface area heuristic over bins of centroids, a binary tree first, of which every three levels or so
/// become one node of eight. Leaves are packets, so a leaf of eight costs what a leaf of one does.
template <std::floating_point T>
class BvhBuilder {
 public:
  BvhBuilder(std::span<const TriangleCorners<T>> triangles, std::span<const SphereShape<T>> spheres)
      : triangles_(triangles), spheres_(spheres) {}

  [[nodiscard]] BuiltBvh<T> build() {
    items_.reserve(triangles_.size() + spheres_.size());
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      Box<T> box;
      for (const Vec3<T>& corner : triangles_[i]) box.add(corner);
      add_item(box, BvhChild::triangles, i);
    }
    for (std::size_t i = 0; i < spheres_.size(); ++i)
      add_item({spheres_[i].center - spheres_[i].radius, spheres_[i].center + spheres_[i].radius}, BvhChild::spheres,
               i);
    if (items_.empty()) return {};
    result_.bvh.root = emit(split(0, items_.size(), 0));
    return std::move(result_);
  }

 private:
  struct Item {
    Box<T> box;
    Vec3<T> centroid;
    BvhChild::Kind kind;
    std::uint32_t index;
  };
  /// A node of the binary tree; a leaf when `left` is none.
  struct Node {
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    Box<T> box;
    std::uint32_t left = none, right = none;
    std::uint32_t begin = 0, end = 0;
  };

  static constexpr std::size_t bin_count = 16;
  /// Cost of one binary split relative to one packet; a node of eight is one test for seven splits.
  static constexpr T split_cost = T(0.3);
  static constexpr int heuristic_depth = 40;  ///< deeper down, halves: 2^30 items need no more than 30 further levels

  void add_item(Box<T> box, BvhChild::Kind kind, std::size_t index) {
    // The primitive tests round relative to the coordinates, so what they hit may lie that far outside.
    for (int axis = 0; axis < 3; ++axis) {
      const T padding =
          8 * std::numeric_limits<T>::epsilon() * std::max(std::abs(box.lower[axis]), std::abs(box.upper[axis]));
      box.lower[axis] -= padding;
      box.upper[axis] += padding;
    }
    items_.push_back({box, (box.lower + box.upper) * T(0.5), kind, static_cast<std::uint32_t>(index)});
  }

  [[nodiscard]] static T packets(std::size_t count) noexcept {
    return static_cast<T>((count + lane_count - 1) / lane_count);
  }

  [[nodiscard]] std::uint32_t split(std::size_t begin, std::size_t end, int depth) {
    const auto number = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Box<T> box;
    for (std::size_t i = begin; i < end; ++i) box.add(items_[i].box);
    nodes_[number].box = box;
    nodes_[number].begin = static_cast<std::uint32_t>(begin);
    nodes_[number].end = static_cast<std::uint32_t>(end);
    const std::size_t middle = choose_split(begin, end, box, depth);
    if (middle == begin) return number;
    const std::uint32_t left = split(begin, middle, depth + 1);
    const std::uint32_t right = split(middle, end, depth + 1);
    nodes_[number].left = left;
    nodes_[number].right = right;
    return number;
  }

  /// Reorders the items and returns where to cut them; `begin` for a leaf.
  [[nodiscard]] std::size_t choose_split(std::size_t begin, std::size_t end, const Box<T>& box, int depth) {
    const auto first = items_.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = items_.begin() + static_cast<std::ptrdiff_t>(end);
    const std::size_t count = end - begin;
    std::size_t triangle_count = 0;
    Box<T> centroids;
    for (auto item = first; item != last; ++item) {
      centroids.add(item->centroid);
      triangle_count += item->kind == BvhChild::triangles ? 1U : 0U;
    }
    const bool fits_one_packet = count <= lane_count && (triangle_count == 0 || triangle_count == count);

    struct Bin {
      Box<T> box;
      std::size_t triangles = 0, spheres = 0;
      void add(const Bin& other) {
        box.add(other.box);
        triangles += other.triangles;
        spheres += other.spheres;
      }
      [[nodiscard]] T cost() const noexcept { return box.half_area() * (packets(triangles) + packets(spheres)); }
    };
    const auto bin_of = [&](const Item& item, int axis) {
      const T extent = centroids.upper[axis] - centroids.lower[axis];
      const T scaled = (item.centroid[axis] - centroids.lower[axis]) / extent * T(bin_count);
      return std::min(static_cast<std::size_t>(scaled), bin_count - 1);
    };

    T best_cost = std::numeric_limits<T>::infinity();
    int best_axis = -1;
    std::size_t best_bin = 0;
    for (int axis = 0; axis < 3 && depth < heuristic_depth && count > 1; ++axis) {
      if (!(centroids.upper[axis] > centroids.lower[axis])) continue;
      std::array<Bin, bin_count> bins;
      for (auto item = first; item != last; ++item) {
        Bin& bin = bins[bin_of(*item, axis)];
        bin.box.add(item->box);
        ++(item->kind == BvhChild::triangles ? bin.triangles : bin.spheres);
      }
      std::array<T, bin_count> cost_above{};
      Bin above;
      for (std::size_t bin = bin_count - 1; bin > 0; --bin) {
        above.add(bins[bin]);
        cost_above[bin] = above.cost();
      }
      Bin below;
      for (std::size_t bin = 0; bin + 1 < bin_count; ++bin) {
        below.add(bins[bin]);
        const T cost = below.cost() + cost_above[bin + 1];
        const std::size_t in_below = below.triangles + below.spheres;
        if (cost < best_cost && in_below > 0 && in_below < count) {
          best_cost = cost;
          best_axis = axis;
          best_bin = bin;
        }
      }
    }
    if (fits_one_packet && (best_axis < 0 || best_cost >= box.half_area() * (T(1) - split_cost))) return begin;

    if (best_axis >= 0) {
      const auto middle =
          std::partition(first, last, [&](const Item& item) { return bin_of(item, best_axis) <= best_bin; });
      return static_cast<std::size_t>(middle - items_.begin());
    }
    if (triangle_count > 0 && triangle_count < count && count <= lane_count) {
      const auto middle = std::partition(first, last, [](const Item& i) { return i.kind == BvhChild::triangles; });
      return static_cast<std::size_t>(middle - items_.begin());
    }
    return begin + count / 2;  // nothing tells them apart, or the tree is deep
  }

  [[nodiscard]] bool is_leaf(std::uint32_t number) const noexcept { return nodes_[number].left == Node::none; }

  [[nodiscard]] BvhChild emit(std::uint32_t number) {
    if (is_leaf(number)) return emit_packet(nodes_[number]);
    // Open the largest inner child until there are eight.
    std::vector<std::uint32_t> children{nodes_[number].left, nodes_[number].right};
    while (children.size() < lane_count) {
      std::size_t largest = children.size();
      for (std::size_t i = 0; i < children.size(); ++i)
        if (!is_leaf(children[i]) && (largest == children.size() ||
                                      nodes_[children[i]].box.half_area() > nodes_[children[largest]].box.half_area()))
          largest = i;
      if (largest == children.size()) break;
      const Node opened = nodes_[children[largest]];
      children[largest] = opened.left;
      children.push_back(opened.right);
    }
    const std::size_t place = result_.bvh.nodes.size();
    result_.bvh.nodes.emplace_back();
    for (std::size_t i = 0; i < children.size(); ++i) {
      const BvhChild child = emit(children[i]);
      BvhNode<T>& node = result_.bvh.nodes[place];
      node.children[i] = child;
      const Box<T>& box = nodes_[children[i]].box;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node.planes[2 * axis][i] = box.lower[static_cast<int>(axis)];
        node.planes[2 * axis + 1][i] = box.upper[static_cast<int>(axis)];
      }
    }
    return BvhChild::to(BvhChild::node, place);
  }

  [[nodiscard]] BvhChild emit_packet(const Node& leaf) {
    const BvhChild::Kind kind = items_[leaf.begin].kind;
    const bool is_triangles = kind == BvhChild::triangles;
    auto& in_slot = is_triangles ? result_.triangle_in_slot : result_.sphere_in_slot;
    const std::size_t packet = in_slot.size() / lane_count;
    in_slot.resize(in_slot.size() + lane_count, BuiltBvh<T>::empty_slot);
    if (is_triangles)
      result_.bvh.triangles.emplace_back();
    else
      result_.bvh.spheres.emplace_back().radius_squared.fill(T(-1));
    for (std::size_t lane = 0; lane < leaf.end - leaf.begin; ++lane) {
      const std::uint32_t index = items_[leaf.begin + lane].index;
      in_slot[packet * lane_count + lane] = index;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (is_triangles) {
          for (std::size_t corner = 0; corner < 3; ++corner)
            result_.bvh.triangles[packet].corners[corner][axis][lane] =
                triangles_[index][corner][static_cast<int>(axis)];
        } else {
          result_.bvh.spheres[packet].center[axis][lane] = spheres_[index].center[static_cast<int>(axis)];
          result_.bvh.spheres[packet].radius_squared[lane] = square(spheres_[index].radius);
        }
      }
    }
    return BvhChild::to(kind, packet);
  }

  std::span<const TriangleCorners<T>> triangles_;
  std::span<const SphereShape<T>> spheres_;
  std::vector<Item> items_;
  std::vector<Node> nodes_;
  BuiltBvh<T> result_;
};

}  // namespace gmis::scene
