#include "gmis/core/cos_sin.hpp"

#include <limits>

#include "gmis/core/random.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;

namespace {

/// Bound of the rounding error of a polynomial in Horner's form whose last sum is at most 1: half a
/// unit for the sum, half a unit for the last product (at most 0.79), less for those before; the
/// sine has one product more. In double the C library computes both.
template <std::floating_point T>
constexpr T bound = T(2) * std::numeric_limits<T>::epsilon();

template <std::floating_point T>
void check_near(const CosSin<T>& found, long double angle) {
  const auto cosine = static_cast<long double>(found.cos) - std::cos(angle);
  const auto sine = static_cast<long double>(found.sin) - std::sin(angle);
  if (!(std::abs(cosine) <= static_cast<long double>(bound<T>) &&
        std::abs(sine) <= static_cast<long double>(bound<T>))) {
    CAPTURE(angle, cosine, sine);
    FAIL("a cosine or a sine is too far off");
  }
}

TEMPLATE_TEST_CASE("cosines and sines of eighths of a turn", "[cos_sin]", float, double) {
  using T = TestType;
  constexpr int steps = 1 << 17;
  for (int i = -steps; i <= steps; ++i) {
    const T t = static_cast<T>(i) / static_cast<T>(steps);
    check_near(cos_sin_of_eighths(t), std::numbers::pi_v<long double> / 4 * static_cast<long double>(t));
  }
  // A sine keeps its digits where it is small.
  for (T t = T(1e-3); t > T(1e-30); t *= T(0.37)) {
    const auto sine = static_cast<long double>(cos_sin_of_eighths(t).sin);
    const long double exact = std::sin(std::numbers::pi_v<long double> / 4 * static_cast<long double>(t));
    CHECK(std::abs(sine / exact - 1) <= static_cast<long double>(bound<T>));
  }
}

TEMPLATE_TEST_CASE("cosines and sines of turns", "[cos_sin]", float, double) {
  using T = TestType;
  constexpr int steps = 1 << 17;
  Philox source(gmis_test::seed(1));
  for (int i = 0; i <= steps; ++i) {
    const T grid = static_cast<T>(i) / static_cast<T>(steps);
    for (const T turns : {grid, uniform<T>(source)})
      check_near(cos_sin_of_turns(turns), 2 * std::numbers::pi_v<long double> * static_cast<long double>(turns));
  }
  // Quarters are exact.
  for (int quarter = 0; quarter <= 4; ++quarter) {
    const auto [cosine, sine] = cos_sin_of_turns(static_cast<T>(quarter) / T(4));
    CHECK(cosine == (quarter % 2 == 1 ? T(0) : quarter == 2 ? T(-1) : T(1)));
    CHECK(sine == (quarter % 2 == 0 ? T(0) : quarter == 3 ? T(-1) : T(1)));
  }
}

}  // namespace
