#include "gmis/core/extended.hpp"

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/synthetic_path.hpp"

// Numbers with an extended exponent against 200 bits with an unbounded one.

namespace {

using Wide = boost::multiprecision::number<
    boost::multiprecision::cpp_bin_float<200, boost::multiprecision::digit_base_2, void, std::int64_t>>;

}  // namespace

TEST_CASE("an extended number keeps any value of its scalar") {
  for (const float value :
       {0.0F, 1.0F, 0x1p-149F, 1.17549435e-38F, 3.402823e38F, 0x1p32F, 0x1p-32F, 0.3F, 1e20F, 1e-20F})
    CHECK(gmis::Extended<float>(value).value() == value);
  for (const double value : {0.0, 1.0, 4.94e-324, 2.3e-308, 1.797e308, 0x1p256, 0x1p-256, 0.3})
    CHECK(gmis::Extended<double>(value).value() == value);
}

TEST_CASE("extended numbers add, multiply and divide with the accuracy of their scalar, far outside its range") {
  std::mt19937_64 source(gmis_test::seed(3));
  std::uniform_real_distribution<double> exponent(-38.0, 38.0);
  double worst = 0.0;
  for (int run = 0; run < 2000; ++run) {
    gmis::Extended<float> sum, product(1.0F);
    Wide wide_sum = 0, wide_product = 1;
    for (int i = 0; i < 64; ++i) {
      const auto factor = static_cast<float>(std::pow(10.0, exponent(source)));
      const bool divide = source() % 3 == 0;
      product = divide ? product / gmis::Extended<float>(factor) : product * gmis::Extended<float>(factor);
      wide_product = divide ? Wide(wide_product / factor) : Wide(wide_product * factor);
      sum = sum + product;
      wide_sum += wide_product;
    }
    // The quotient is near 1, so it can be read back.
    const gmis::Extended<float> quotient = sum / product;
    const Wide expected = wide_sum / wide_product;
    if (expected < 1e37 && expected > 1e-37)
      worst = std::max(worst, std::abs(static_cast<double>(Wide(quotient.value() / expected)) - 1.0));
  }
  CAPTURE(worst);
  CHECK(worst < 260.0 * std::numeric_limits<float>::epsilon());  // one rounding an operation, some 200 of them
}

TEST_CASE("out of range, an extended number reads as 0 or infinity") {
  const gmis::Extended<float> huge = gmis::Extended<float>(1e30F) * gmis::Extended<float>(1e30F);
  CHECK(huge.value() == std::numeric_limits<float>::infinity());
  CHECK((huge / huge).value() == 1.0F);
  const gmis::Extended<float> tiny = gmis::Extended<float>(1.0F) / huge;
  CHECK(tiny.value() == 0.0F);
  CHECK((tiny * huge).value() == Approx(1.0F));
  CHECK((tiny + huge + tiny).value() == std::numeric_limits<float>::infinity());
  CHECK((gmis::Extended<float>() + tiny).is_zero() == false);
}

namespace {

template <class Heuristic>
void check_long_paths(double tolerance) {
  std::mt19937_64 source(gmis_test::seed(11));
  for (int n = 0; n < 40; ++n) {
    const int edges = n % 4 == 0 ? 256 : 24 + 6 * n;
    const double delta_chance = n % 5 == 0 ? 1.0 : (n % 5 == 1 ? 0.0 : 0.5);
    const auto path = gmis_test::random_path<float>(source, edges, 10.0, delta_chance);
    const gmis::TechniqueCounts<float> counts{1.0F, 1.0F, 1.0F, 16384.0F,
                                              std::pow(10.0F, static_cast<float>(n) - 24.0F)};
    const gmis_test::RecursiveWeights<float, Heuristic> recursion(path, counts);
    const auto densities = gmis::technique_densities(gmis_test::path_densities<Wide>(path), counts);
    Wide total = 0;
    for (const auto& technique : densities) total += Heuristic::of(technique.density);
    if (total == 0) continue;
    Wide sum = 0;
    double worst = 0.0;
    for (const auto& technique : densities) {
      if (technique.density == 0) continue;
      const float weight = recursion.weight(technique.technique);
      REQUIRE(std::isfinite(weight));
      REQUIRE(weight >= 0.0F);
      REQUIRE(weight <= 1.0F);
      const Wide expected = Heuristic::of(technique.density) / total;
      sum += weight;
      if (expected > 1e-30) worst = std::max(worst, std::abs(static_cast<double>(Wide(weight / expected)) - 1.0));
    }
    CAPTURE(n, edges, worst, static_cast<double>(sum));
    CHECK(worst < tolerance);
    CHECK(std::abs(static_cast<double>(sum) - 1.0) < tolerance);
  }
}

}  // namespace

TEST_CASE("recursive weights in float hold on paths of 256 edges with area densities from 1e-20 to 1e20") {
  SECTION("balance") {
    check_long_paths<gmis::BalanceRatio>(4e-5);
  }
  SECTION("power") {
    check_long_paths<gmis::PowerRatio>(8e-5);
  }
}
