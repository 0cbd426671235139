#pragma once

#include <bit>
#include <type_traits>

#include "gmis/core/interaction.hpp"
#include "gmis/scene/lanes.hpp"

/// \file
/// Eight triangles or eight spheres against one ray.

namespace gmis::scene {

/// What the tests need of a ray, computed once: the inverse direction for boxes, the shear for triangles.
template <std::floating_point T>
struct PreparedRay {
  std::array<T, 3> origin, direction, inverse;
  std::array<std::size_t, 3> near_plane;  ///< into `BvhNode::planes`, by axis; the far plane is the other one
  std::size_t kx, ky, kz;                 ///< z is the axis along which the direction is longest
  T shear_x, shear_y, shear_z;

  explicit PreparedRay(const Ray<T>& ray) noexcept
      : origin{ray.origin.x, ray.origin.y, ray.origin.z},
        direction{ray.direction.x, ray.direction.y, ray.direction.z},
        inverse{ieee_divide(T(1), ray.direction.x), ieee_divide(T(1), ray.direction.y),
                ieee_divide(T(1), ray.direction.z)} {
    for (std::size_t axis = 0; axis < 3; ++axis) near_plane[axis] = 2 * axis + sign_bit(direction[axis]);
    const T x = std::abs(direction[0]), y = std::abs(direction[1]), z = std::abs(direction[2]);
    kz = x > y ? (x > z ? 0U : 2U) : (y > z ? 1U : 2U);
    kx = kz == 2 ? 0U : kz + 1;
    ky = kx == 2 ? 0U : kx + 1;
    shear_z = inverse[kz];
    shear_x = direction[kx] * shear_z;
    shear_y = direction[ky] * shear_z;
  }

 private:
  /// 1 also for −0, whose inverse is −∞. In integers: shorter than by `std::signbit`.
  [[nodiscard]] static std::size_t sign_bit(T x) noexcept {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    return std::bit_cast<Bits>(x) >> (8 * sizeof(T) - 1);
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

  /// Lanes hit with 0 < t < t_max, from either side. No ray slips between two triangles that share an edge: the edge
  /// functions have the right sign always [Woop, Benthin, Wald 2013, with products that do not cancel].
  template <bool any>
  [[nodiscard]] LaneMask test(const PreparedRay<T>& ray, T t_max, PacketHit<T>& hit) const noexcept {
    using L = Lanes<T>;
    const L ox = L::all(ray.origin[ray.kx]), oy = L::all(ray.origin[ray.ky]), oz = L::all(ray.origin[ray.kz]);
    const L sx = L::all(ray.shear_x), sy = L::all(ray.shear_y);
    const L az = L::load(corners[0][ray.kz]) - oz;
    const L bz = L::load(corners[1][ray.kz]) - oz;
    const L cz = L::load(corners[2][ray.kz]) - oz;
    const L ax = subtract_product(L::load(corners[0][ray.kx]) - ox, sx, az);
    const L ay = subtract_product(L::load(corners[0][ray.ky]) - oy, sy, az);
    const L bx = subtract_product(L::load(corners[1][ray.kx]) - ox, sx, bz);
    const L by = subtract_product(L::load(corners[1][ray.ky]) - oy, sy, bz);
    const L cx = subtract_product(L::load(corners[2][ray.kx]) - ox, sx, cz);
    const L cy = subtract_product(L::load(corners[2][ray.ky]) - oy, sy, cz);

    const L u = product_difference(cx, by, cy, bx);
    const L v = product_difference(ax, cy, ay, cx);
    const L w = product_difference(bx, ay, by, ax);
    const L zero = L::all(T(0));
    LaneMask mask = less_or_equal(zero, minimum(u, minimum(v, w))) | less_or_equal(maximum(u, maximum(v, w)), zero);
    if (mask == 0) return 0;

    const L determinant = u + v + w;
    const L height = multiply_add(u, az, multiply_add(v, bz, w * cz)) * L::all(ray.shear_z);
    // A triangle seen edge-on, or an empty lane, has t = ±infinity or NaN and fails both comparisons.
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

  /// Lanes hit with 0 < t < t_max, from outside or inside [Haines, Günther, Akenine-Möller 2019: the discriminant from
  /// the distance between centre and ray, so that far or large spheres do not cancel].
  template <bool any>
  [[nodiscard]] LaneMask test(const PreparedRay<T>& ray, T t_max, PacketHit<T>& hit) const noexcept {
    using L = Lanes<T>;
    const L dx = L::all(ray.direction[0]), dy = L::all(ray.direction[1]), dz = L::all(ray.direction[2]);
    const L fx = L::load(center[0]) - L::all(ray.origin[0]);
    const L fy = L::load(center[1]) - L::all(ray.origin[1]);
    const L fz = L::load(center[2]) - L::all(ray.origin[2]);
    const L along = multiply_add(fx, dx, multiply_add(fy, dy, fz * dz));
    const L lx = subtract_product(fx, along, dx);
    const L ly = subtract_product(fy, along, dy);
    const L lz = subtract_product(fz, along, dz);
    const L r2 = L::load(radius_squared);
    const L zero = L::all(T(0));
    const L discriminant = r2 - multiply_add(lx, lx, multiply_add(ly, ly, lz * lz));
    // A sphere that is only touched is not met, as a triangle seen edge-on is not. The discriminant of rays that all but
    // touch is often rounded to 0: their cosine at the surface, and the density of the point, would be 0.
    LaneMask mask = less(zero, discriminant);
    if (mask == 0) return 0;

    // The two roots are q and c/q: neither loses digits, and the sign of c alone says whether the origin is inside.
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
