#pragma once

#include <bit>

#include "gmis/core/attributes.hpp"
#include "gmis/core/axis_lanes.hpp"
#include "gmis/core/interaction.hpp"
#include "gmis/scene/lanes.hpp"

/// \file
/// Eight triangles or eight spheres against one ray.

namespace gmis::scene {

namespace detail {

using AxisTriple = std::array<std::size_t, 3>;

/// Where the planes begin in `BvhNode::planes` through which a ray enters a box, by axis, for each
/// `AxisLanes::signs`.
inline constexpr std::array<AxisTriple, 8> near_planes = [] {
  std::array<AxisTriple, 8> planes{};
  for (std::size_t signs = 0; signs < 8; ++signs)
    for (std::size_t axis = 0; axis < 3; ++axis) planes[signs][axis] = (2 * axis + ((signs >> axis) & 1U)) * lane_count;
  return planes;
}();

/// The axes in an order that ends with one along which the direction is longest, for each
/// `AxisLanes::descents`.
inline constexpr std::array<AxisTriple, 8> axes_to_longest = [] {
  std::array<AxisTriple, 8> orders{};
  for (std::size_t descents = 0; descents < 8; ++descents) {
    const bool x_to_y = (descents & 1U) != 0, y_to_z = (descents & 2U) != 0, z_to_x = (descents & 4U) != 0;
    const std::size_t longest = x_to_y ? (z_to_x ? 2U : 0U) : (y_to_z ? 1U : 2U);
    orders[descents] = {(longest + 1) % 3, (longest + 2) % 3, longest};
  }
  return orders;
}();

}  // namespace detail

/// A ray by coordinates, which boxes and triangles ask for by number.
template <std::floating_point T>
struct RayAxes {
  AxisArray<T> origin, direction, inverse;
};

/// The properties of a ray that tests need beside its coordinates, computed once. They are kept
/// apart from the coordinates, so that a compiler can keep them in registers.
template <std::floating_point T>
struct PreparedRay {
  const detail::AxisTriple* near_plane;  ///< see `near_planes`; the far plane is the other one
  std::size_t kx, ky, kz;                ///< z is the axis along which the direction is longest
  T shear_x, shear_y, shear_z;           ///< moves the direction onto z, with length 1

  /// Writes the coordinates of the ray into `axes`.
  GMIS_ALWAYS_INLINE PreparedRay(const Ray<T>& ray, RayAxes<T>& axes) noexcept {
    const auto direction = AxisLanes<T>::of(ray.direction);
    AxisLanes<T>::of(ray.origin).store(axes.origin);
    direction.store(axes.direction);
    direction.inverse().store(axes.inverse);
    near_plane = &detail::near_planes[direction.signs()];
    const detail::AxisTriple& order = detail::axes_to_longest[direction.descents()];
    kx = order[0];
    ky = order[1];
    kz = order[2];
    shear_z = axes.inverse[kz];
    shear_x = axes.direction[kx] * shear_z;
    shear_y = axes.direction[ky] * shear_z;
  }
};

/// A hit within a packet: `t`, and for a triangle the weights of its corners, not normalised.
template <std::floating_point T>
struct PacketHit {
  T t;
  std::size_t lane;
  std::array<T, 3> corner_weights{};
};

template <std::floating_point T>
struct alignas(32) TrianglePacket {
  std::array<std::array<LaneArray<T>, 3>, 3> corners{};  ///< by corner, axis, lane; empty lanes are all zero

  /// Lanes hit with 0 < t < t_max, from either side. No ray slips between two triangles that share
  /// an edge: the edge functions have the right sign always [Woop, Benthin, Wald 2013, with
  /// products that do not cancel].
  template <bool any>
  [[nodiscard]] GMIS_ALWAYS_INLINE LaneMask test(const RayAxes<T>& axes, const PreparedRay<T>& ray, T t_max,
                                                 PacketHit<T>& hit) const noexcept {
    using L = Lanes<T>;
    const L ox = L::all(axes.origin[ray.kx]), oy = L::all(axes.origin[ray.ky]), oz = L::all(axes.origin[ray.kz]);
    const L sx = L::all(ray.shear_x), sy = L::all(ray.shear_y);
    const L az = L::load(corners[0][ray.kz].data()) - oz;
    const L bz = L::load(corners[1][ray.kz].data()) - oz;
    const L cz = L::load(corners[2][ray.kz].data()) - oz;
    const L ax = subtract_product(L::load(corners[0][ray.kx].data()) - ox, sx, az);
    const L ay = subtract_product(L::load(corners[0][ray.ky].data()) - oy, sy, az);
    const L bx = subtract_product(L::load(corners[1][ray.kx].data()) - ox, sx, bz);
    const L by = subtract_product(L::load(corners[1][ray.ky].data()) - oy, sy, bz);
    const L cx = subtract_product(L::load(corners[2][ray.kx].data()) - ox, sx, cz);
    const L cy = subtract_product(L::load(corners[2][ray.ky].data()) - oy, sy, cz);

    const L u = product_difference(cx, by, cy, bx);
    const L v = product_difference(ax, cy, ay, cx);
    const L w = product_difference(bx, ay, by, ax);
    const L zero = L::all(T(0));
    LaneMask mask = less_or_equal(zero, minimum(u, minimum(v, w))) | less_or_equal(maximum(u, maximum(v, w)), zero);
    if (mask == 0) return 0;

    const L determinant = u + v + w;
    const L height = multiply_add(u, az, multiply_add(v, bz, w * cz)) * L::all(ray.shear_z);
    // A triangle seen edge-on, or an empty lane, has t = ±infinity or NaN and fails both
    // comparisons.
    const L t = divide(height, determinant);
    mask &= less(zero, t) & less(t, L::all(t_max));
    if (any || mask == 0) return mask;

    alignas(32) LaneArray<T> ts, us, vs, ws;
    t.store(ts);
    u.store(us);
    v.store(vs);
    w.store(ws);
    const std::size_t lane = nearest_lane(mask, ts);
    hit = {ts[lane], lane, {us[lane], vs[lane], ws[lane]}};
    return mask;
  }

  [[nodiscard]] static std::size_t nearest_lane(LaneMask mask, const LaneArray<T>& ts) noexcept {
    auto nearest = static_cast<std::size_t>(std::countr_zero(mask));
    for (mask &= mask - 1; mask != 0; mask &= mask - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(mask));
      if (ts[lane] < ts[nearest]) nearest = lane;
    }
    return nearest;
  }
};

template <std::floating_point T>
struct alignas(32) SpherePacket {
  std::array<LaneArray<T>, 3> center{};
  LaneArray<T> radius_squared{};  ///< −1 in an empty lane

  /// Lanes hit with 0 < t < t_max, from outside or inside [Haines, Günther, Akenine-Möller 2019:
  /// the discriminant from the distance between centre and ray, so that far or large spheres do not
  /// cancel].
  template <bool any>
  [[nodiscard]] GMIS_ALWAYS_INLINE LaneMask test(const RayAxes<T>& ray, T t_max, PacketHit<T>& hit) const noexcept {
    using L = Lanes<T>;
    const L dx = L::all(ray.direction[0]), dy = L::all(ray.direction[1]), dz = L::all(ray.direction[2]);
    const L fx = L::load(center[0].data()) - L::all(ray.origin[0]);
    const L fy = L::load(center[1].data()) - L::all(ray.origin[1]);
    const L fz = L::load(center[2].data()) - L::all(ray.origin[2]);
    const L along = multiply_add(fx, dx, multiply_add(fy, dy, fz * dz));
    const L lx = subtract_product(fx, along, dx);
    const L ly = subtract_product(fy, along, dy);
    const L lz = subtract_product(fz, along, dz);
    const L r2 = L::load(radius_squared.data());
    const L zero = L::all(T(0));
    const L discriminant = r2 - multiply_add(lx, lx, multiply_add(ly, ly, lz * lz));
    // A sphere that is only touched is not met, as a triangle seen edge-on is not. The discriminant
    // of rays that all but touch is often rounded to 0: their cosine at the surface, and the
    // density of the point, would be 0.
    LaneMask mask = less(zero, discriminant);
    if (mask == 0) return 0;

    // The two roots are q and c/q: neither loses digits, and the sign of c alone says whether the
    // origin is inside.
    const L q = along + with_sign_of(root(discriminant), along);
    const L c = multiply_add(fx, fx, multiply_add(fy, fy, fz * fz)) - r2;
    const L other = divide(c, q);
    const L t = positive_or(minimum(q, other), maximum(q, other));
    mask &= less(zero, t) & less(t, L::all(t_max));
    if (any || mask == 0) return mask;

    alignas(32) LaneArray<T> ts;
    t.store(ts);
    const std::size_t lane = TrianglePacket<T>::nearest_lane(mask, ts);
    hit = {ts[lane], lane, {}};
    return mask;
  }
};

}  // namespace gmis::scene
