#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/scene/packets.hpp"

namespace gmis::scene {

/// Where a child of a node leads: to another node, or to one packet of primitives.
struct BvhChild {
  enum Kind : std::uint32_t { node = 0, triangles = 1, spheres = 2, nothing = 3 };
  std::uint32_t code = std::uint32_t{nothing} << 30U;

  [[nodiscard]] static constexpr BvhChild to(Kind kind, std::size_t index) noexcept {
    return {(std::uint32_t{kind} << 30U) | static_cast<std::uint32_t>(index)};
  }
  [[nodiscard]] constexpr Kind kind() const noexcept { return static_cast<Kind>(code >> 30U); }
  [[nodiscard]] constexpr std::size_t index() const noexcept { return code & 0x3FFFFFFFU; }
};

/// Up to eight children with their boxes: 28 bytes a child in float.
template <std::floating_point T>
struct alignas(32) BvhNode {
  std::array<T, 6 * lane_count> planes;  ///< lower x of all lanes, upper x, lower y, …; an empty lane is an empty box
  std::array<BvhChild, lane_count> children;

  BvhNode() noexcept {
    for (std::size_t side = 0; side < 6; ++side)
      for (std::size_t lane = 0; lane < lane_count; ++lane)
        plane(side, lane) = side % 2 == 0 ? std::numeric_limits<T>::infinity() : -std::numeric_limits<T>::infinity();
  }
  /// `side`: 0 is lower x, 1 upper x, 2 lower y, …
  [[nodiscard]] T& plane(std::size_t side, std::size_t lane) noexcept { return planes[side * lane_count + lane]; }
  [[nodiscard]] T plane(std::size_t side, std::size_t lane) const noexcept { return planes[side * lane_count + lane]; }
};

/// The nearest hit so far: `slot` = packet · 8 + lane.
template <std::floating_point T>
struct BvhHit {
  T t;
  BvhChild::Kind kind = BvhChild::nothing;
  std::size_t slot = 0;
  std::array<T, 3> corner_weights{};
};

/// A tree of eight-way nodes over packets of eight primitives; `BvhBuilder` makes it.
template <std::floating_point T>
struct Bvh {
  /// Bounds the depth of the tree, hence the stack; `BvhSplitter` keeps within it.
  static constexpr int max_depth = 72;

  BvhChild root;
  std::vector<BvhNode<T>> nodes;
  std::vector<TrianglePacket<T>> triangles;
  std::vector<SpherePacket<T>> spheres;

  [[nodiscard]] BvhHit<T> closest(const Ray<T>& ray) const noexcept {
    BvhHit<T> hit{ray.t_max};
    is_large() ? traverse<false, true>(ray, hit) : traverse<false, false>(ray, hit);
    return hit;
  }
  [[nodiscard]] bool is_blocked(const Ray<T>& ray) const noexcept {
    BvhHit<T> hit{ray.t_max};
    return traverse<true, false>(ray, hit);
  }
  [[nodiscard]] std::size_t byte_count() const noexcept {
    return nodes.size() * sizeof(BvhNode<T>) + triangles.size() * sizeof(TrianglePacket<T>) +
           spheres.size() * sizeof(SpherePacket<T>);
  }

 private:
  /// A child to visit later and, in the upper half, where the ray enters it: one number, so that
  /// sorting moves one register. Left uninitialised on the stack: hundreds of entries, of which a
  /// ray uses a few.
  using Entry = std::uint64_t;
  [[nodiscard]] static Entry entry_of(BvhChild child, T near) noexcept {
    // Not above the true value; and since it is not negative, its bits are ordered as the numbers
    // are.
    const auto rounded = static_cast<float>(std::same_as<T, float> ? near : near * T(0.9999999));
    return (Entry{std::bit_cast<std::uint32_t>(rounded)} << 32U) | child.code;
  }
  [[nodiscard]] static T near_of(Entry entry) noexcept {
    return static_cast<T>(std::bit_cast<float>(static_cast<std::uint32_t>(entry >> 32U)));
  }

  /// Whether a ray is likely to wait for memory: this many nodes and their packets are 2 MB, as
  /// large as the caches of one core.
  [[nodiscard]] bool is_large() const noexcept { return nodes.size() > 1024; }

  /// Asks for the memory of a child that a ray will visit later: the first of each of its pairs of
  /// cache lines, which processors fetch together. Without branches on the kind of the child, which
  /// would be mispredicted.
  void prefetch(BvhChild child) const noexcept {
#if defined(__GNUC__)
    const auto address_in = [&](const auto& array) {
      return reinterpret_cast<std::uintptr_t>(array.data()) + child.index() * sizeof(array[0]);
    };
    std::uintptr_t at = address_in(nodes);
    if (child.kind() == BvhChild::triangles) at = address_in(triangles);
    if (child.kind() == BvhChild::spheres) at = address_in(spheres);
    GMIS_PREFETCH(reinterpret_cast<const void*>(at));
    GMIS_PREFETCH(reinterpret_cast<const void*>(at + 128));
#else
    static_cast<void>(child);
#endif
  }

  /// `any`: stops at the first hit that it finds, which says nothing else. `prefetches`: asks early
  /// for what it will visit.
  template <bool any, bool prefetches>
  bool traverse(const Ray<T>& unprepared, BvhHit<T>& best) const noexcept {
    if (root.kind() == BvhChild::nothing) return false;
    RayAxes<T> axes;
    const PreparedRay<T> ray(unprepared, axes);
    std::array<Entry, max_depth*(lane_count - 1) + 1> stack;
    std::size_t size = 0;
    BvhChild current = root;
    for (;;) {
      if (current.kind() == BvhChild::node) {
        const BvhNode<T>& node = nodes[current.index()];
        alignas(32) LaneArray<T> near;
        LaneMask mask = enter(node, axes, *ray.near_plane, best.t, near);
        if (mask != 0) {
          const auto first = static_cast<std::size_t>(std::countr_zero(mask));
          current = node.children[first];
          mask &= mask - 1;
          if (mask == 0) continue;
          if constexpr (any) {
            for (; mask != 0; mask &= mask - 1)
              stack[size++] = node.children[static_cast<std::size_t>(std::countr_zero(mask))].code;
          } else {
            // The nearest child comes next, the others wait in order, the nearest of them on top.
            Entry nearest = entry_of(current, near[first]);
            const std::size_t base = size;
            for (; mask != 0; mask &= mask - 1) {
              const auto lane = static_cast<std::size_t>(std::countr_zero(mask));
              const Entry entry = entry_of(node.children[lane], near[lane]);
              const Entry waiting = std::max(entry, nearest);
              if constexpr (prefetches) prefetch(node.children[lane]);
              nearest = std::min(entry, nearest);
              std::size_t place = size++;
              for (; place > base && stack[place - 1] < waiting; --place) stack[place] = stack[place - 1];
              stack[place] = waiting;
            }
            current = {static_cast<std::uint32_t>(nearest)};
          }
          continue;
        }
      } else {
        PacketHit<T> hit;
        const bool is_triangle = current.kind() == BvhChild::triangles;
        const LaneMask mask = is_triangle ? triangles[current.index()].template test<any>(axes, ray, best.t, hit)
                                          : spheres[current.index()].template test<any>(axes, best.t, hit);
        if (mask != 0) {
          if constexpr (any) return true;
          best = {hit.t, current.kind(), current.index() * lane_count + hit.lane, hit.corner_weights};
        }
      }
      do {
        if (size == 0) return false;
        --size;
      } while (!any && near_of(stack[size]) >= best.t);
      current = {static_cast<std::uint32_t>(stack[size])};
    }
  }

  /// The children whose boxes the ray meets at 0 ≤ t ≤ t_max, and where it enters them. A plane
  /// that the ray lies in makes 0 · ∞ = NaN, which never narrows the interval; the end is moved out
  /// by what rounding can make of three operations, twice over [Ize 2013].
  [[nodiscard]] GMIS_ALWAYS_INLINE static LaneMask enter(const BvhNode<T>& node, const RayAxes<T>& ray,
                                                         const detail::AxisTriple& near_plane, T t_max,
                                                         LaneArray<T>& near) noexcept {
    using L = Lanes<T>;
    constexpr T unit = std::numeric_limits<T>::epsilon() / 2;
    constexpr T widening = 1 + 2 * (3 * unit / (1 - 3 * unit));
    L enter_t = L::all(T(0));
    L leave_t = L::all(t_max);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const L origin = L::all(ray.origin[axis]);
      const L inverse = L::all(ray.inverse[axis]);
      const L near_t = (L::load(&node.planes[near_plane[axis]]) - origin) * inverse;
      const L far_t = (L::load(&node.planes[near_plane[axis] ^ lane_count]) - origin) * inverse;
      enter_t = maximum(near_t, enter_t);
      leave_t = minimum(far_t, leave_t);
    }
    enter_t.store(near);
    return less_or_equal(enter_t, leave_t * L::all(widening));
  }
};

}  // namespace gmis::scene
