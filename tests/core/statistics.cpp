#include "gmis/core/statistics.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "gmis/core/compensated_sum.hpp"
#include "gmis/core/density_tests.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;

namespace {

// Values computed with 30 digits by another program (mpmath).
TEST_CASE("p-values of chi-square agree with 30-digit values", "[statistics]") {
  struct Row {
    double statistic, degrees, p;
  };
  for (const Row& row :
       {Row{3.841458820694124, 1, 0.050000000000000057}, Row{0.5, 3, 0.91889141165467586},
        Row{40, 10, 1.6944743930067384e-5}, Row{1000, 1000, 0.49405285382923964}, Row{1100, 1000, 0.014614408126295194},
        Row{1300, 1000, 3.8897364994868525e-10}, Row{200, 10, 1.6139305336977305e-37},
        Row{0.01, 2, 0.99501247919268231}, Row{25, 50, 0.9988075511517683}}) {
    CAPTURE(row.statistic, row.degrees);
    CHECK(chi_square_p_value(row.statistic, row.degrees) == Approx(row.p).epsilon(1e-10));
  }
  CHECK(chi_square_p_value(0, 3) == 1.0);
  CHECK(chi_square_p_value(std::numeric_limits<double>::quiet_NaN(), 3) == 0.0);
}

TEST_CASE("p-values of Student's t agree with 30-digit values", "[statistics]") {
  struct Row {
    double t, degrees, p;
  };
  for (const Row& row :
       {Row{2.0, 1, 0.29516723530086655}, Row{2.5, 3, 0.087706647008065547}, Row{-1.0, 10, 0.34089313230205987},
        Row{6, 30, 1.3942768767204743e-6}, Row{0.1, 200, 0.92044449250432104}, Row{5, 1000, 6.7672563646486304e-7},
        Row{12.706204736432095, 1, 0.049999999998991306}}) {
    CAPTURE(row.t, row.degrees);
    CHECK(student_t_p_value(row.t, row.degrees) == Approx(row.p).epsilon(1e-10));
  }
  CHECK(student_t_p_value(0, 5) == Approx(1.0));
}

TEST_CASE("quantiles of Student's t are those of the tables", "[statistics]") {
  struct Row {
    double p, degrees, t;
  };
  for (const Row& row : {Row{0.975, 1, 12.7062}, Row{0.975, 5, 2.570582}, Row{0.995, 10, 3.169273},
                         Row{0.975, 30, 2.042272}, Row{0.9995, 2, 31.5991}}) {
    CAPTURE(row.p, row.degrees);
    // Six or seven digits are printed: half of the last one is below 4e-6 of the smallest.
    CHECK(student_t_quantile(row.p, row.degrees) == Approx(row.t).epsilon(4e-6));
    CHECK(student_t_quantile(1 - row.p, row.degrees) == Approx(-row.t).epsilon(4e-6));
  }
  // Closed forms: tan(π (p − ½)) with one degree, (2 p − 1) / √(2 p (1 − p)) with two.
  for (const double p : {0.6, 0.9, 0.999, 1 - 1e-6, 1 - 1e-12}) {
    CAPTURE(p);
    CHECK(student_t_quantile(p, 1) == Approx(1 / std::tan(std::numbers::pi * (1 - p))).epsilon(1e-10));
    CHECK(student_t_quantile(p, 2) == Approx((2 * p - 1) / std::sqrt(2 * p * (1 - p))).epsilon(1e-10));
  }
  CHECK(std::isnan(student_t_quantile(0.0, 3)));
  CHECK(std::isnan(student_t_quantile(1.0, 3)));
  CHECK(std::isnan(student_t_quantile(std::nan(""), 3)));
}

/// Chance of a t above this one, by quadrature. With t = √n tan θ Student's density is in
/// proportion to cosⁿ⁻¹ θ, which Simpson's rule integrates.
long double share_above(long double t, long double degrees) {
  constexpr int panels = 20000;
  const long double right = std::numbers::pi_v<long double> / 2;
  const auto integral = [&](long double from) {
    // cos θ = sin(π/2 − θ), which keeps its digits near the end.
    const long double width = right - from;
    const auto value = [&](int i) { return std::pow(std::sin(width * i / panels), degrees - 1); };
    long double sum = value(0) + value(panels);
    for (int i = 1; i < panels; ++i) sum += (i % 2 == 1 ? 4 : 2) * value(i);
    return sum * width / panels / 3;
  };
  // π/2 − atan(t/√n) = atan(√n/t), for t above 0.
  const long double whole = 2 * integral(0);
  return integral(right - std::atan(std::sqrt(degrees) / t)) / whole;
}

TEST_CASE("quantiles of Student's t invert the distribution, by quadrature", "[statistics]") {
  for (const double degrees : {1.0, 2.0, 3.0, 5.0, 7.5, 10.0, 23.0, 64.0, 127.0, 300.0})
    for (const double tail : {0.4, 0.1, 0.025, 1e-3, 1e-5, 1e-8}) {
      CAPTURE(degrees, tail);
      const double p = 1 - tail;
      const double t = student_t_quantile(p, degrees);
      REQUIRE(t > 0);
      // 1 − p as it is in double, which is what the quantile is of.
      const auto above = static_cast<double>(share_above(static_cast<long double>(t), degrees));
      CHECK(above == Approx(1 - p).epsilon(1e-9));
      CHECK(student_t_quantile(1 - p, degrees) == Approx(-t).epsilon(1e-12));
    }
}

TEST_CASE("normal quantiles agree with 30-digit values and invert the distribution", "[statistics]") {
  struct Row {
    double p, z;
  };
  for (const Row& row :
       {Row{0.975, 1.9599639845400542}, Row{0.025, -1.9599639845400542}, Row{1e-3, -3.0902323061678135},
        Row{1e-10, -6.3613409024040562}, Row{1e-100, -21.273453560965324}, Row{0.3, -0.52440051270804078},
        Row{0.9999, 3.7190164854556806}, Row{1e-300, -37.047096299361199}}) {
    CAPTURE(row.p);
    CHECK(normal_quantile(row.p) == Approx(row.z).epsilon(1e-12));
    CHECK(normal_cdf(normal_quantile(row.p)) == Approx(row.p).epsilon(1e-11));
  }
  CHECK(std::abs(normal_quantile(0.5)) < 1e-15);
  CHECK(std::isnan(normal_quantile(-0.1)));
  CHECK(normal_quantile(0) == -std::numeric_limits<double>::infinity());
}

TEST_CASE("the level of Sidak makes the family's level", "[statistics]") {
  CHECK(sidak_level(0.05, 1) == Approx(0.05));
  for (const std::size_t count : {2U, 10U, 1000U})
    CHECK(1 - std::pow(1 - sidak_level(1e-3, count), static_cast<double>(count)) == Approx(1e-3).epsilon(1e-9));
}

TEST_CASE("Pearson's statistic and its pooling, by hand", "[statistics]") {
  const std::array<double, 3> observed{12, 18, 30};
  const std::array<double, 3> expected{20, 20, 20};
  const auto test = chi_square_test(observed, expected);
  CHECK(test.statistic == Approx(64.0 / 20 + 4.0 / 20 + 100.0 / 20));
  CHECK(test.degrees_of_freedom == 2);

  // 1 + 2 + 3 make one bin that expects 6.
  const std::array<double, 5> counts{0, 3, 4, 10, 13};
  const std::array<double, 5> means{1, 2, 3, 12, 12};
  const auto pooled = chi_square_test(counts, means);
  CHECK(pooled.statistic == Approx(1.0 / 6 + 4.0 / 12 + 1.0 / 12));
  CHECK(pooled.degrees_of_freedom == 2);

  const std::array<double, 2> impossible{5, 1};
  const std::array<double, 2> certain{6, 0};
  CHECK(chi_square_test(impossible, certain).p_value == 0.0);
}

TEST_CASE("a mean whose standard error is no number passes no test", "[statistics]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double error : {infinity, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(z_test(0.5, error, 0.5).p_value == 0.0);
    CHECK(t_test(0.5, error, 100, 0.5).p_value == 0.0);
  }
  CHECK(z_test(0.5, 0.0, 0.5).p_value == 1.0);
  CHECK(t_test(0.5, 0.0, 100, 0.5).p_value == 1.0);
}

TEST_CASE("the chi-square test passes nothing that it cannot compare", "[statistics]") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const std::array<double, 3> counts{500, 50, 30}, expected{500, 50, 30};
  CHECK(chi_square_test(counts, expected).p_value == 1.0);
  const std::array<double, 5> more_counts{500, 50, 30, 1000, 7};
  CHECK_THROWS_AS(chi_square_test(more_counts, expected), std::invalid_argument);
  CHECK_THROWS_AS(chi_square_test(counts, more_counts), std::invalid_argument);
  for (const double wrong : {nan, infinity}) {
    CHECK_THROWS_AS(chi_square_test(counts, std::array<double, 3>{wrong, 50, 30}), std::invalid_argument);
    CHECK(chi_square_test(std::array<double, 3>{500, 50, wrong}, expected).p_value == 0.0);
  }
  CHECK(chi_square_test(std::array<double, 3>{500, 50, nan}, std::array<double, 3>{500, 50, 0}).p_value == 0.0);
}

// 2000 p-values of true hypotheses: their share below a level is the level. False-alarm rate 1e-6 a
// check.
TEST_CASE("true hypotheses have uniform p-values, false ones small ones", "[statistics]") {
  Philox source(gmis_test::seed(7));
  std::array<double, 2> below{};
  constexpr int runs = 2000;
  int rejected_false = 0;
  for (int run = 0; run < runs; ++run) {
    std::array<double, 10> counts{};
    std::array<double, 10> even{};
    std::array<double, 10> skewed{};
    even.fill(200);
    skewed.fill(200);
    skewed[0] = 150;
    skewed[1] = 250;
    double sum = 0, squares = 0;
    for (int i = 0; i < 2000; ++i) {
      const double u = uniform<double>(source);
      ++counts[static_cast<std::size_t>(10 * u)];
      sum += u;
      squares += u * u;
    }
    const double mean = sum / 2000;
    const double error = std::sqrt((squares / 2000 - mean * mean) / 1999);
    below[0] += chi_square_test(counts, even).p_value < 0.05 ? 1 : 0;
    below[1] += t_test(mean, error, 2000, 0.5).p_value < 0.05 ? 1 : 0;
    rejected_false += chi_square_test(counts, skewed).p_value < 0.01 ? 1 : 0;
  }
  for (const double count : below) CHECK(normal_p_value((count / runs - 0.05) / std::sqrt(0.05 * 0.95 / runs)) > 1e-6);
  // Noncentrality 26.7 with 9 degrees: the power at level 0.01 is about 0.9.
  CHECK(rejected_false > runs * 0.87);
}

struct Exponential {
  double rate = 1, stated_rate = 1;
  double sample(Philox& source) const { return -std::log1p(-uniform<double>(source)) / rate; }
  double pdf(double x) const { return x < 0 ? 0.0 : stated_rate * std::exp(-stated_rate * x); }
};
struct SometimesFails {
  std::optional<double> sample(Philox& source) const {
    const double u = uniform<double>(source);
    if (u < 0.25) return std::nullopt;
    return (u - 0.25) / 0.75;
  }
  double pdf(double) const { return stated; }
  double stated = 0.75;
};
struct AlwaysSucceeds {
  double sample(Philox& source) const { return uniform<double>(source); }
  double pdf(double) const { return stated; }
  double stated = 1;
};

// A rate that is off by 5 % adds 0.05² · 100,000 = 250 to a χ² with some 65 degrees of freedom, a
// share of failures that is off by 0.03 adds 520 to one with 400: either is missed in less than
// 1e-8 of the seeds. What is right fails in 1e-4.
TEST_CASE("a proposal is checked against its density", "[check][long]") {
  Philox source(gmis_test::seed(11));
  const auto right = check_proposal(Exponential{2, 2}, 0, 30, source);
  CHECK(right.passes(1e-4));
  CHECK(right.integral == Approx(1).epsilon(1e-6));
  CHECK_FALSE(check_proposal(Exponential{2, 2.1}, 0, 30, source).passes(1e-4));
  CHECK_FALSE(check_proposal(Exponential{2, -2}, 0, 30, source).passes(1e-4));

  const auto failing = check_proposal(SometimesFails{}, 0, 1, source);
  CHECK(failing.passes(1e-4));
  CHECK(failing.integral == Approx(0.75));
  CHECK_FALSE(check_proposal(SometimesFails{0.78}, 0, 1, source).passes(1e-4));
  CHECK_FALSE(check_proposal(SometimesFails{1.1}, 0, 1, source).passes(1e-4));

  for (const double stated : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    const auto no_density = check_proposal(AlwaysSucceeds{stated}, 0, 1, source);
    CHECK(no_density.test.p_value == 0.0);
    CHECK_FALSE(no_density.passes(1e-4));
  }
}

/// A diffuse surface with the albedo 0.5 and a delta lobe of a tenth that goes straight through;
/// one of its values is `wrong`.
struct WrongInOnePlace {
  using Spectrum = Vec3<double>;
  enum Place { nothing, every_value, second_channel, reverse_density, sampled_weight, delta_weight } place;
  double wrong = 0;

  [[nodiscard]] BsdfValue<Spectrum> evaluate(const Spectrum& to_prev, const Spectrum& to_next, TransportMode) const {
    if (to_prev.z * to_next.z <= 0) return {};
    BsdfValue<Spectrum> result{Spectrum(0.5 / pi<double>),
                               {{0.9 * std::abs(to_next.z) / pi<double>}, {0.9 * std::abs(to_prev.z) / pi<double>}}};
    if (place == every_value) result.value = Spectrum(wrong);
    if (place == second_channel) result.value.y = wrong;
    if (place == reverse_density) result.pdf.reverse.value = wrong;
    return result;
  }
  [[nodiscard]] std::optional<ScatterSample<Spectrum>> sample(const Spectrum& to_prev, double u, const Vec2<double>& uv,
                                                              TransportMode mode) const {
    if (u < 0.1)
      return ScatterSample<Spectrum>{-to_prev, {1.0, place == delta_weight ? wrong : 1.0, 1.0}, {{0.1}, {0.1}}, true};
    Spectrum to_next = square_to_cosine_hemisphere(uv);
    if (to_prev.z < 0) to_next.z = -to_next.z;
    const auto f = evaluate(to_prev, to_next, mode);
    Spectrum weight = f.value * std::abs(to_next.z) / f.pdf.forward.value;
    if (place == sampled_weight) weight.y = wrong;
    return ScatterSample<Spectrum>{to_next, weight, f.pdf};
  }
  [[nodiscard]] bool is_purely_delta() const { return false; }
  [[nodiscard]] Spectrum albedo() const { return Spectrum(0.6); }
};
static_assert(Bsdf<WrongInOnePlace>);

TEST_CASE("a BSDF with a value that is not finite fails its check", "[check]") {
  const Vec3<double> normal(0, 0, 1), to_prev = glm::normalize(Vec3<double>(0.3, 0.2, 0.8));
  const CheckSettings settings{2000, 50};
  const auto check = [&](const WrongInOnePlace& bsdf) {
    Philox source(gmis_test::seed(12));
    return check_bsdf(bsdf, normal, to_prev, source, settings);
  };
  const BsdfCheck sound = check({WrongInOnePlace::nothing});
  CHECK(sound.passes(1e-6));
  // The delta lobe is drawn 200 times of 2,000, with a standard deviation of 13.
  CHECK(sound.reflected_share == Approx(0.6).margin(0.04));
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), infinity}) {
    CAPTURE(wrong);
    for (const auto place : {WrongInOnePlace::every_value, WrongInOnePlace::second_channel}) {
      const BsdfCheck value = check({place, wrong});
      CHECK(value.sample_error == infinity);
      CHECK(value.reciprocity_error == infinity);
      CHECK(value.reflected_share == infinity);
      CHECK_FALSE(value.passes(1e-6));
    }
    const BsdfCheck reverse = check({WrongInOnePlace::reverse_density, wrong});
    CHECK(reverse.reverse_error == infinity);
    CHECK(reverse.sample_error == infinity);
    CHECK_FALSE(reverse.passes(1e-6));
    CHECK(check({WrongInOnePlace::sampled_weight, wrong}).sample_error == infinity);
    const WrongInOnePlace delta{WrongInOnePlace::delta_weight, wrong};
    CHECK(check(delta).reflected_share == infinity);
    Philox source(gmis_test::seed(13));
    CHECK(reflected_share(delta, normal, to_prev, source) == infinity);
  }
}

TEST_CASE("the reflected share of no samples is refused", "[check]") {
  Philox source(gmis_test::seed(14));
  const Vec3<double> normal(0, 0, 1);
  CHECK_THROWS_AS(reflected_share(WrongInOnePlace{WrongInOnePlace::nothing}, normal, normal, source, 0),
                  std::invalid_argument);
}

TEST_CASE("a compensated sum loses nothing that plain summation loses", "[sum]") {
  CompensatedSum<float> sum(1.0F);
  for (int i = 0; i < 1'000'000; ++i) sum += 1e-8F;
  CHECK(sum.value() == Approx(1.01F).epsilon(1e-6));
}

}  // namespace
