#include <limits>

#include "gmis/core/random.hpp"
#include "gmis/scene/lanes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;

namespace {

template <class T>
struct alignas(32) Operands {
  LaneArray<T> a, b, c, d;
};

/// Ordinary numbers, and in every place now and then one that comparisons and signs stumble over.
template <class T>
Operands<T> random_operands(Philox& source) {
  using Limits = std::numeric_limits<T>;
  const T special[] = {T(0), -T(0), Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN(), T(1), T(-1)};
  const auto number = [&] {
    const T u = uniform<T>(source);
    if (u < T(0.15)) return special[static_cast<std::size_t>(uniform<T>(source) * T(6.999))];
    return (u - T(0.5)) * T(20);
  };
  Operands<T> result;
  for (LaneArray<T>* lanes : {&result.a, &result.b, &result.c, &result.d})
    for (T& x : *lanes) x = number();
  return result;
}

/// The same bits, but for the sign and the payload of a number that is none; or within `tolerance`,
/// where a compiler may round a product and a sum at once.
template <class T>
bool are_equal(T x, T y, T tolerance = T(0)) {
  if (std::isnan(x) || std::isnan(y)) return std::isnan(x) && std::isnan(y);
  return (x == y && std::signbit(x) == std::signbit(y)) || std::abs(x - y) <= tolerance;
}

template <class T>
LaneArray<T> stored(const Lanes<T>& lanes) {
  alignas(32) LaneArray<T> result;
  lanes.store(result);
  return result;
}

}  // namespace

TEMPLATE_TEST_CASE("each lane does what one number does", "[lanes]", float, double) {
  using T = TestType;
  using L = Lanes<T>;
  Philox source(gmis_test::seed(25));
  int wrong = 0;
  for (int round = 0; round < 20'000; ++round) {
    const Operands<T> of = random_operands<T>(source);
    const L a = L::load(of.a.data()), b = L::load(of.b.data()), c = L::load(of.c.data()), d = L::load(of.d.data());
    const auto sum = stored<T>(a + b), difference = stored<T>(a - b), product = stored<T>(a * b);
    const auto quotient = stored<T>(divide(a, b));
    const auto fused = stored<T>(multiply_add(a, b, c)), taken = stored<T>(subtract_product(c, a, b));
    const auto crossed = stored<T>(product_difference(a, b, c, d));
    const auto smaller = stored<T>(minimum(a, b)), larger = stored<T>(maximum(a, b));
    const auto roots = stored<T>(root(a)), signed_like = stored<T>(with_sign_of(a, b));
    const auto first_positive = stored<T>(positive_or(a, b)),
               same = stored<T>(L::all(of.a[static_cast<std::size_t>(round % 8)]));
    const LaneMask is_less = less(a, b), is_not_above = less_or_equal(a, b);
    for (std::size_t i = 0; i < lane_count; ++i) {
      const T x = of.a[i], y = of.b[i], z = of.c[i], w = of.d[i];
      // Of numbers up to 10: two roundings of up to 100 and 110.
      const T tolerance = T(128) * std::numeric_limits<T>::epsilon();
      const bool right[] = {
          are_equal(sum[i], x + y),
          are_equal(difference[i], x - y),
          are_equal(product[i], x * y),
          are_equal(quotient[i], ieee_divide(x, y)),
          are_equal(fused[i], x * y + z, tolerance),
          are_equal(taken[i], z - x * y, tolerance),
          !std::isfinite(x * y - z * w) || are_equal(crossed[i], x * y - z * w, 2 * tolerance),
          are_equal(smaller[i], x < y ? x : y),
          are_equal(larger[i], x > y ? x : y),
          std::isnan(x) || are_equal(std::abs(roots[i]), x > T(0) ? std::sqrt(x) : T(0)),
          std::isnan(x) || std::isnan(y) || are_equal(signed_like[i], std::copysign(x, y)),
          are_equal(first_positive[i], x > T(0) ? x : y),
          are_equal(same[i], of.a[static_cast<std::size_t>(round % 8)]),
          ((is_less >> i) & 1U) == (x < y ? 1U : 0U),
          ((is_not_above >> i) & 1U) == (x <= y ? 1U : 0U),
      };
      for (const bool is_right : right) wrong += is_right ? 0 : 1;
    }
    wrong += (is_less | is_not_above) >> lane_count == 0 ? 0 : 1;
  }
  CHECK(wrong == 0);
}
