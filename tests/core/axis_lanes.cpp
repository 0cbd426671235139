#include "gmis/core/axis_lanes.hpp"

#include <limits>
#include <vector>

#include "gmis/core/random.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;

namespace {

/// Numbers of all sizes and signs, many of them equal to each other or next to an integer.
template <std::floating_point T>
std::vector<Vec3<T>> vectors() {
  Philox source(gmis_test::seed(1));
  constexpr T tiny = std::numeric_limits<T>::denorm_min();
  const std::vector<T> special{T(0), -T(0), T(1), T(-1), T(-0.5), T(2.5), T(1e6), T(-1e6), T(-3), tiny, -tiny};
  const auto coordinate = [&] {
    const T u = uniform<T>(source);
    if (u < T(0.5)) return special[uniform_index(source, static_cast<std::uint32_t>(special.size()))];
    return (uniform<T>(source) - T(0.5)) * (u < T(0.75) ? T(1e-3) : T(1e3));
  };
  std::vector<Vec3<T>> result;
  for (int i = 0; i < 4000; ++i) {
    const T x = coordinate(), y = coordinate();
    result.emplace_back(x, y, coordinate());
  }
  return result;
}

template <std::floating_point T>
Vec3<T> stored(const AxisLanes<T>& lanes) {
  AxisArray<T> array;
  lanes.store(array);
  return {array[0], array[1], array[2]};
}

TEMPLATE_TEST_CASE("coordinates at once are coordinates one by one", "[axis_lanes]", float, double) {
  using T = TestType;
  const auto all = vectors<T>();
  for (std::size_t i = 1; i < all.size(); ++i) {
    const Vec3<T>&a = all[i - 1], &b = all[i];
    const auto lanes_a = AxisLanes<T>::of(a), lanes_b = AxisLanes<T>::of(b);
    bool agree = stored(lanes_a) == a && stored(lanes_a + lanes_b) == a + b && stored(lanes_a - lanes_b) == a - b &&
                 stored(lanes_a * lanes_b) == a * b && stored(AxisLanes<T>::all(a.x)) == Vec3<T>(a.x);
    std::uint32_t signs = 0, descents = 0;
    const auto floors = lanes_a.floors();
    const Vec3<T> inverse = stored(lanes_a.inverse());
    for (int axis = 0; axis < 3; ++axis) {
      const auto bit = 1U << static_cast<unsigned>(axis);
      signs |= std::signbit(a[axis]) ? bit : 0U;
      descents |= std::abs(a[axis]) > std::abs(a[(axis + 1) % 3]) ? bit : 0U;
      agree = agree && floors[static_cast<std::size_t>(axis)] == static_cast<std::int32_t>(std::floor(a[axis]));
      const T expected = a[axis] == T(0)               ? std::copysign(std::numeric_limits<T>::infinity(), a[axis])
                         : std::abs(a[axis]) < T(1e-6) ? inverse[axis]  // beyond the range of T
                                                       : T(1) / a[axis];
      agree = agree && inverse[axis] == expected;
    }
    agree = agree && lanes_a.signs() == signs && lanes_a.descents() == descents;
    for (const T bound : {T(-1), T(0), T(1), T(1e3)}) {
      const T largest = std::max({a.x, a.y, a.z, b.x, b.y, b.z});
      agree = agree && are_at_most(lanes_a, lanes_b, bound) == (largest <= bound);
    }
    if (!agree) {
      CAPTURE(a.x, a.y, a.z, b.x, b.y, b.z);
      FAIL("coordinates at once differ");
    }
  }
  constexpr T nan = std::numeric_limits<T>::quiet_NaN();
  for (int axis = 0; axis < 3; ++axis) {
    Vec3<T> broken(T(0));
    broken[axis] = nan;
    CHECK_FALSE(are_at_most(AxisLanes<T>::of(broken), AxisLanes<T>::of(broken), T(1)));
  }
}

}  // namespace
