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

TEST_CASE("a double of any size is rounded to an extended number") {
  std::mt19937_64 source(gmis_test::seed(12));
  std::uniform_real_distribution<double> exponent(-307.0, 307.0), near(-9.7, 9.7);
  double worst = 0.0;
  for (int n = 0; n < 20000; ++n) {
    const double value = std::pow(10.0, n % 2 == 0 ? exponent(source) : near(source));
    const auto rounded = gmis::Extended<float>::rounded(value);
    CHECK(rounded.has_no_exponent() == (rounded.mantissa() == static_cast<float>(value)));
    // Divided by itself as by a product of floats, so that it can be read back.
    double rest = value;
    gmis::Extended<float> product(1.0F);
    while (rest > 1e30) product = product * gmis::Extended<float>(1e30F), rest /= static_cast<double>(1e30F);
    while (rest < 1e-30) product = product * gmis::Extended<float>(1e-30F), rest /= static_cast<double>(1e-30F);
    worst = std::max(worst, std::abs(static_cast<double>((rounded / product).value()) / rest - 1.0));
  }
  CAPTURE(worst);
  CHECK(worst < 24.0 * std::numeric_limits<float>::epsilon());
  CHECK(gmis::Extended<float>::rounded(0.0).is_zero());
  // Rounding reaches the upper end of a mantissa.
  CHECK_FALSE(gmis::Extended<float>::rounded(std::nextafter(0x1p32, 0.0)).has_no_exponent());
  CHECK(gmis::Extended<float>::rounded(std::nextafter(0x1p32, 0.0)).value() == 0x1p32F);
}

namespace {

struct WideTerms {
  template <gmis::Technique>
  static Wide of(const Wide& count) {
    return count;
  }
};

/// The formulas in 200 bits, from the same partial sums.
template <class Heuristic>
void check_ends_of_the_range() {
  using Exact = gmis::WeightFormulas<float, Heuristic, Wide, Wide>;
  std::mt19937_64 source(gmis_test::seed(13));
  std::uniform_real_distribution<double> any(-149.0, 127.9), stored(-31.9, 31.9), unit(0.0, 1.0);
  // A density at either end of float's range half of the time, else anywhere in it.
  const auto density = [&] {
    const double end = unit(source);
    if (end < 0.25) return std::numeric_limits<float>::denorm_min();
    if (end < 0.5) return std::numeric_limits<float>::max();
    return static_cast<float>(std::exp2(any(source)));
  };
  const auto partial = [&] {
    const auto number = [&] { return gmis::Extended<float>(static_cast<float>(std::exp2(stored(source)))); };
    return gmis::PartialWeights<float>{number(), unit(source) < 0.1 ? gmis::Extended<float>() : number()};
  };
  const auto wide = [](const gmis::PartialWeights<float>& of) {
    return gmis::PartialSums<Wide, Wide>{Wide(of.shared.value()), Wide(of.chain.value())};
  };
  double worst = 0.0;
  const auto compare_weight = [&](float weight, const gmis::OwnAndOthers<Wide>& of) {
    const Wide expected = of.own == 0 ? Wide(0) : Wide(of.own / (of.own + of.others));
    if (expected < 1e-37) {
      CHECK(weight <= 1.0001e-37F);
      return;
    }
    worst = std::max(worst, std::abs(static_cast<double>(Wide(weight / expected)) - 1.0));
  };
  const auto compare_number = [&](const gmis::Extended<float>& number, const Wide& expected) {
    if (expected == 0) {
      CHECK(number.is_zero());
      return;
    }
    // Scaled by a power of two to where it can be read.
    int scale = 0;
    static_cast<void>(frexp(expected, &scale));
    gmis::Extended<float> read = number;
    Wide target = expected;
    for (; scale > 60; scale -= 60) read = read * gmis::Extended<float>(0x1p-60F), target *= 0x1p-60;
    for (; scale < -60; scale += 60) read = read * gmis::Extended<float>(0x1p60F), target *= 0x1p60;
    worst = std::max(worst, std::abs(static_cast<double>(Wide(read.value() / target)) - 1.0));
  };
  const auto compare = [&](const gmis::PartialWeights<float>& sums, const gmis::PartialSums<Wide, Wide>& expected) {
    compare_number(sums.shared, expected.shared);
    compare_number(sums.chain, expected.chain);
  };
  for (int n = 0; n < 20000; ++n) {
    gmis::TechniqueCounts<float> counts{1.0F, 1.0F, density(), density(), density()};
    counts.merges_first = n % 2 == 0;
    const gmis::WeightRecursion<float, Heuristic> recursion(counts);
    const Exact exact(counts, WideTerms());
    const float a = density(), b = density(), c = density(), d = density(), e = density();
    const auto light = partial(), camera = partial();
    const bool one = n % 3 == 0, two = n % 5 == 0, three = n % 7 == 0;
    compare(recursion.first_light_vertex({a, b, c}, d), exact.first_light_vertex({a, b, c}, d));
    compare(recursion.extend_light(light, {one, two, a, b, c}), exact.extend_light(wide(light), {one, two, a, b, c}));
    compare(recursion.first_camera_vertex(a), exact.first_camera_vertex(a));
    compare(recursion.extend_camera(camera, {one, two, three, a, b, c}),
            exact.extend_camera(wide(camera), {one, two, three, a, b, c}));
    compare_weight(recursion.emitter_hit(camera, {a, b, c}), exact.emitter_hit(wide(camera), {a, b, c}));
    compare_weight(recursion.next_event({a, b, 0.0F}, c, camera, {one, e, d}),
                   exact.next_event({a, b, 0.0F}, c, wide(camera), {one, e, d}));
    compare_weight(recursion.connect(light, {one, three, a, b}, camera, {two, c, d}),
                   exact.connect(wide(light), {one, three, a, b}, wide(camera), {two, c, d}));
    compare_weight(recursion.splat(light, {one, false, a, b}), exact.splat(wide(light), {one, false, a, b}));
    compare_weight(recursion.merge(light, a, camera, {one, b, 0.0F}),
                   exact.merge(wide(light), a, wide(camera), {one, b, 0.0F}));
  }
  CAPTURE(worst);
  CHECK(worst < 8.0 * std::numeric_limits<float>::epsilon());
}

}  // namespace

TEST_CASE(
    "formulas in plain double keep their digits at the ends of float's range, where the stored sums have no exponent") {
  SECTION("balance heuristic") {
    check_ends_of_the_range<gmis::BalanceRatio>();
  }
  SECTION("power heuristic") {
    check_ends_of_the_range<gmis::PowerRatio>();
  }
}
