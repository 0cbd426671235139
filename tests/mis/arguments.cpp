#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "gmis/core/density_tests.hpp"
#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/seed.hpp"

// Every argument that cannot serve is rejected before the first sample, and every one that should
// serve does.

namespace {

using gmis::Scheme;
using Numbers = std::vector<double>;
using Counts = std::vector<std::uint32_t>;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

const std::vector<test::Ramp> ramps{{-1.0}, {0.3}, {1.0}};
double f(double x) {
  return 2.0 * x;
}

#define REJECTED(...) CHECK_THROWS_AS((__VA_ARGS__), std::invalid_argument)

/// Runs `estimate` in all its pairs; `is_rejected(selection)` says which must throw.
template <class P, class Allocation, class IsRejected>
void check_pairs(const P& proposals, const Allocation& allocation, IsRejected is_rejected) {
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings) {
      CAPTURE(name_of(selection), name_of(weighting));
      gmis::Philox source(1);
      if (is_rejected(selection))
        REJECTED(gmis::estimate(selection, weighting, f, proposals, 2, source, allocation));
      else
        CHECK_NOTHROW(gmis::estimate(selection, weighting, f, proposals, 2, source, allocation));
    }
}
const auto always = [](gmis::Selection) { return true; };
const auto never = [](gmis::Selection) { return false; };

/// Claims room for two proposals and has three.
struct TooLarge {
  using Value = double;
  using Density = double;
  static constexpr std::size_t capacity = 2;
  std::size_t size() const { return 3; }
  double sample(std::size_t k, gmis::UniformSource auto& source) const { return ramps[k].sample(source); }
  double pdf(std::size_t k, double x) const { return ramps[k].pdf(x); }
};

/// Draws from one engine and no other.
struct MersenneOnly {
  double sample(std::mt19937& source) const { return gmis::uniform<double>(source); }
  double pdf(double) const { return 1.0; }
};
static_assert(!gmis::Proposals<std::vector<MersenneOnly>>);
static_assert(gmis::Proposals<std::vector<MersenneOnly>, std::mt19937>);

/// Sets refer to their proposals: temporaries are refused, spans are not.
template <class S>
concept TakesTemporary = requires(S&& s) {
  gmis::as_proposal_set(std::forward<S>(s));
};
static_assert(!TakesTemporary<std::vector<test::Ramp>>);
static_assert(!TakesTemporary<const std::vector<test::Ramp>>);
static_assert(!TakesTemporary<std::array<test::Ramp, 2>>);
static_assert(!TakesTemporary<std::tuple<test::Ramp>>);
static_assert(!TakesTemporary<TooLarge>);
static_assert(TakesTemporary<std::vector<test::Ramp>&>);
static_assert(TakesTemporary<const std::array<test::Ramp, 2>&>);
static_assert(TakesTemporary<std::span<const test::Ramp>>);
static_assert(!std::is_constructible_v<gmis::ProposalTuple<double, test::Ramp>, std::tuple<test::Ramp>>);
template <class G>
concept GivesMembers = requires(G&& groups) {
  std::forward<G>(groups).members(0);
};
static_assert(GivesMembers<gmis::Groups<>&> && !GivesMembers<gmis::Groups<>>);

/// Uniform on [0, 1), with `sign` for its density above one half.
struct Signed {
  double sign;
  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  double pdf(double x) const { return x > 0.5 ? sign : 1.0; }
};

/// A ramp that states the logarithm of the density of another.
struct LogRamp {
  test::Ramp ramp;
  double stated;
  double sample(gmis::UniformSource auto& source) const { return ramp.sample(source); }
  double log_pdf(double x) const { return std::log(test::Ramp{stated}.pdf(x)); }
};

/// Uniform on [0, 2), of which it makes what is below 2 · chance and fails otherwise.
struct Half {
  double chance;
  std::optional<double> sample(gmis::UniformSource auto& source) const {
    const double x = 2.0 * gmis::uniform<double>(source);
    if (x >= 2.0 * chance) return std::nullopt;
    return x;
  }
  double pdf(double x) const { return x < 2.0 * chance ? 0.5 : 0.0; }
};

/// No more than `SpectrumTraits` asks for.
struct Bare {
  float low, high;
};

}  // namespace

template <>
struct gmis::SpectrumTraits<Bare> {
  using Scalar = float;
  static constexpr int channel_count = 2;
  static float channel(const Bare& value, int i) { return i == 0 ? value.low : value.high; }
};

TEST_CASE("weights that make no allocation are rejected", "[mis]") {
  for (const Numbers& weights : {Numbers{}, Numbers{0.0, 0.0}, Numbers{1.0, -1.0}, Numbers{-1.0, -1.0},
                                 Numbers{not_a_number, 1.0}, Numbers{infinity, 1.0}}) {
    CAPTURE(weights);
    REJECTED(gmis::SampleAllocation<double>(weights, 4));
    REJECTED(gmis::SampleAllocation<float, 8>(std::vector<float>(weights.begin(), weights.end()), 4));
    Counts counts(weights.size());
    REJECTED(gmis::apportion<double>(weights, 4, counts));
  }
  REJECTED(gmis::SampleAllocation({0.5, 0.5}, 0));
  REJECTED(gmis::SampleAllocation(Counts{}));
  REJECTED(gmis::SampleAllocation(Counts{0, 0}));
  REJECTED(gmis::SampleAllocation(std::vector<int>{1, -1}));
  REJECTED(gmis::SampleAllocation(std::vector<std::int64_t>{std::int64_t{1} << 33}));
  REJECTED(gmis::SampleAllocation<double, 2>({1.0, 1.0, 1.0}, 2));  // three proposals where two fit
  REJECTED(gmis::SampleAllocation<double, 2>({1.0, 1.0}, 3));       // three samples
  REJECTED(gmis::SampleAllocation<double, 2>(Counts{2, 1}));
  Counts too_few(1);
  REJECTED(gmis::apportion<double>(Numbers{1.0, 1.0}, 4, too_few));
  Counts three(3);
  REJECTED(gmis::apportion_to_all<double>(Numbers{1.0, 1.0, 1.0}, 2, three));
  // Weights near the ends of the range are weights.
  const gmis::SampleAllocation huge({1e308, 1e308, 1e308}, 6), tiny({5e-324, 5e-324}, 4);
  for (std::size_t k = 0; k < 3; ++k) CHECK(huge.count(k) == 2);
  CHECK(tiny.weight(0) == 0.5);
}

TEST_CASE("an allocation is made of any range of numbers", "[mis]") {
  const auto check = [](const auto& allocation) {
    CHECK(allocation.proposal_count() == 2);
    CHECK(allocation.sample_count(2) == 4);
    CHECK(allocation.count(0) == 3);
    CHECK(allocation.weight(1) == Approx(0.25));
  };
  check(gmis::SampleAllocation(Numbers{0.75, 0.25}, 4));
  check(gmis::SampleAllocation(std::array<float, 2>{0.75F, 0.25F}, 4));
  check(gmis::SampleAllocation({3.0, 1.0}, 4));
  check(gmis::SampleAllocation<double>({3.0, 1.0}, 4));
  check(gmis::SampleAllocation(std::vector<int>{3, 1}, 4));
  check(gmis::SampleAllocation(std::vector<int>{3, 1}));
  check(gmis::SampleAllocation(Counts{3, 1}));
  check(gmis::SampleAllocation({3, 1}));
  const Numbers numbers{0.75, 0.25};
  check(gmis::SampleAllocation<double, 4>(std::span<const double>(numbers), 4));
}

TEST_CASE("a positive weight gets a sample or an error", "[mis]") {
  const gmis::SampleAllocation allocation({0.96, 0.04}, 10);
  CHECK(allocation.count(0) == 9);
  CHECK(allocation.count(1) == 1);
  // Each covers one half: without a sample of the second, N3 is 1 ± 0.
  const std::array<test::Uniform, 2> halves{{{0.0, 1.0}, {1.0, 2.0}}};
  gmis::Philox source(gmis_test::seed(1));
  CHECK(gmis::estimate<Scheme::N3>([](double) { return 1.0; }, halves, 10, source, allocation).mean == Approx(2.0));

  const gmis::SampleAllocation single({0.6, 0.3, 0.1}, 1);
  check_pairs(ramps, single, [](gmis::Selection selection) { return selection != gmis::Selection::S1; });
  REJECTED(gmis::estimate_weighted(gmis::Power{}, f, ramps, 2, source, single));
  REJECTED(gmis::check_coverage(f, ramps, single, Numbers{0.5}));
  check_pairs(ramps, gmis::SampleAllocation({0.6, 0.0, 0.4}, 2), never);  // a weight of 0 asks for no sample

  gmis::Philox numbers(gmis_test::seed(2));
  for (int trial = 0; trial < 500; ++trial) {
    Numbers weights(1 + gmis::uniform_index(numbers, 9));
    std::size_t positive = 0;
    for (double& weight : weights) {
      weight = gmis::uniform_index(numbers, 4) == 0 ? 0.0 : std::pow(gmis::uniform<double>(numbers), 8.0);
      if (weight > 0.0) ++positive;
    }
    if (positive == 0) continue;
    const std::size_t total = positive + gmis::uniform_index(numbers, 30);
    Counts counts(weights.size());
    gmis::apportion_to_all<double>(weights, total, counts);
    std::size_t given = 0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      given += counts[k];
      CHECK((counts[k] > 0) == (weights[k] > 0.0));
    }
    CHECK(given == total);
  }
}

TEST_CASE("an allocation or groups for another number of proposals are rejected", "[mis]") {
  gmis::Philox source(1);
  gmis::Workspace<double, gmis::dynamic_capacity> workspace;
  const auto set = gmis::as_proposal_set(ramps);
  const auto ignore = [](double, double, std::size_t) {};
  for (const std::size_t wrong : {std::size_t{2}, std::size_t{4}}) {
    const gmis::SampleAllocation allocation(Counts(wrong, 2));
    check_pairs(ramps, allocation, always);
    REJECTED(gmis::sample_round<Scheme::N3>(set, allocation, source, workspace, ignore));
    REJECTED(gmis::estimate_weighted(gmis::Power{}, f, ramps, 2, source, allocation));
    REJECTED(gmis::sample_weighted_round(gmis::Balance{}, set, allocation, source, workspace, ignore));
    REJECTED(gmis::check_coverage(f, ramps, allocation, Numbers{0.5}));

    const gmis::Groups<> groups(wrong, 2);
    REJECTED(gmis::estimate_partial(f, ramps, groups, 2, source));
    REJECTED(gmis::sample_partial_round(set, groups, source, workspace, ignore));
    REJECTED(gmis::check_coverage(f, ramps, groups, Numbers{0.5}));
    const std::array<double, 2> ends{0.0, 1.0};
    const gmis::TabulatedProblem table(f, ramps, gmis::composite_gauss_legendre(ends, 4));
    REJECTED(exact_moments(groups, table));
    REJECTED(has_full_support(groups, table));
  }
}

TEST_CASE("partitions that are none are rejected", "[mis]") {
  REJECTED(gmis::Groups<>(2, 0));
  REJECTED(gmis::Groups<>(0, 1));
  REJECTED(gmis::Groups<>(2, 3));
  REJECTED(gmis::Groups<4>(5, 2));
  REJECTED(gmis::Groups<>(Counts{}));
  REJECTED(gmis::Groups<>(Counts{0, 2, 2}));  // no group 1
  REJECTED(gmis::Groups<>(Counts{0, 0xFFFFFFFFU}));
  CHECK(gmis::Groups<4>(4, 4).size() == 1);
  const gmis::Groups<> listed(Counts{1, 0, 1});
  CHECK(listed.members(0).size() == 1);
}

TEST_CASE("empty sets, no rounds and buffers that are too small are rejected", "[mis]") {
  const std::vector<test::Ramp> none;
  gmis::Philox source(1);
  check_pairs(none, gmis::EqualAllocation{}, always);
  check_pairs(TooLarge{}, gmis::EqualAllocation{}, always);
  REJECTED(gmis::estimate_weighted(gmis::Balance{}, f, none, 2, source));
  REJECTED(gmis::check_coverage(f, none, Numbers{0.5}));
  REJECTED(gmis::PilotSamples(f, none, 10, source));
  REJECTED(gmis::estimate<Scheme::N3>(f, ramps, 0, source));
  REJECTED(gmis::estimate<Scheme::N3>(f, ramps, static_cast<std::uint64_t>(-1), source));
  REJECTED(gmis::estimate_partial(f, ramps, gmis::Groups<>(3, 2), 0, source));
  REJECTED(gmis::estimate_weighted(gmis::Balance{}, f, ramps, 0, source));
  REJECTED(gmis::PilotSamples(f, ramps, 0, source));
  REJECTED(gmis::check_coverage(f, ramps, test::Uniform{}, 0, source));
  gmis::Workspace<double, 2> small;
  const auto ignore = [](double, double, std::size_t) {};
  REJECTED(
      gmis::sample_round<Scheme::N3>(gmis::as_proposal_set(ramps), gmis::EqualAllocation{}, source, small, ignore));
  REJECTED(gmis::sample_round<Scheme::N3>(TooLarge{}, source, ignore));
  gmis::Workspace<double, 3> for_three;
  REJECTED(gmis::sample_round<Scheme::N2>(gmis::as_proposal_set(ramps), gmis::SampleAllocation({2, 1, 1}), source,
                                          for_three, ignore));
  gmis::EstimateAccumulator<double> accumulator;
  REJECTED(gmis::add_rounds<Scheme::N3>(accumulator, f, none, 1, source));
}

TEST_CASE("heuristics and their arguments are checked", "[mis]") {
  gmis::Philox source(1);
  REJECTED(gmis::estimate_weighted(gmis::Cutoff{1.5}, f, ramps, 2, source));
  REJECTED(gmis::estimate_weighted(gmis::Cutoff{-1.0}, f, ramps, 2, source));
  REJECTED(gmis::estimate_weighted(gmis::Cutoff{not_a_number}, f, ramps, 2, source));
  REJECTED(gmis::estimate_weighted(gmis::Power{not_a_number}, f, ramps, 2, source));
  REJECTED(gmis::estimate_weighted(gmis::Power{-infinity}, f, ramps, 2, source));
  REJECTED(gmis::estimate_weighted(gmis::Power{-1.0}, f, ramps, 2, source));
  CHECK_NOTHROW(gmis::estimate_weighted(gmis::Cutoff{1.0}, f, ramps, 2, source));
  CHECK_NOTHROW(gmis::estimate_weighted(gmis::Power{0.0}, f, ramps, 2, source));
  const Numbers densities{1.0, 2.0};
  Numbers weights(2), one(1);
  const Counts counts{1, 1}, three{1, 1, 1};
  const std::span<const double> in(densities);
  REJECTED(gmis::heuristic_weights(gmis::Balance{}, three, in, std::span<double>(weights)));
  REJECTED(gmis::heuristic_weights(gmis::Balance{}, counts, in, std::span<double>(one)));
  REJECTED(gmis::heuristic_weights_from_logs(gmis::Balance{}, counts, in, std::span<double>(one)));
  // Without an allocation, one sample of each: Veach's multi-sample form.
  gmis::Philox a(5), b(5);
  CHECK(gmis::estimate_weighted(gmis::Balance{}, f, ramps, 50, a).mean ==
        Approx(gmis::estimate<Scheme::N3>(f, ramps, 50, b).mean).epsilon(1e-13));
}

TEST_CASE("tables, rules and pilots of nothing are rejected", "[mis]") {
  const Numbers ones(3, 1.0);
  REJECTED(gmis::gauss_legendre(0));
  REJECTED(gmis::composite_gauss_legendre(Numbers{}, 4));
  REJECTED(gmis::composite_gauss_legendre(Numbers{0.0}, 4));
  REJECTED(gmis::composite_gauss_legendre(Numbers{1.0, 0.0}, 4));
  REJECTED(gmis::composite_gauss_legendre(Numbers{0.0, infinity}, 4));
  REJECTED(gmis::composite_gauss_legendre(Numbers{0.0, 1.0}, 0));
  REJECTED(gmis::composite_gauss_legendre(Numbers{0.0, 1.0}, 1, 0));
  REJECTED(gmis::TabulatedProblem(Numbers{}, Numbers{}, Numbers{}));
  REJECTED(gmis::TabulatedProblem(ones, ones, Numbers{}));
  REJECTED(gmis::TabulatedProblem(ones, ones, Numbers{1.0, 1.0}));
  REJECTED(gmis::TabulatedProblem(ones, std::span(ones).first(2), ones));
  REJECTED(gmis::TabulatedProblem(ones, ones, Numbers{1.0, -1.0, 1.0}));
  REJECTED(gmis::TabulatedProblem(Numbers{not_a_number, 1.0, 1.0}, ones, ones));
  REJECTED(gmis::TabulatedProblem(f, ramps, std::span<const gmis::QuadratureNode>{}));
  const gmis::TabulatedProblem table(ones, ones, ones);
  gmis::Philox source(1);
  REJECTED(gmis::averaged_variance(Scheme::N3, table, 10, source));
  REJECTED(gmis::averaged_variance(Scheme::N2, table, 1, source));
  REJECTED(gmis::best_scheme(table, {-1.0, 1.0}, source));
  REJECTED(gmis::best_scheme(table, {1.0, not_a_number}, source));
  REJECTED(gmis::best_scheme(table, {1.0, 1.0}, source, 1));
  REJECTED(gmis::check_proposal(test::Uniform{}, 1.0, 0.0, source));
  REJECTED(gmis::check_proposal(test::Uniform{}, 0.0, infinity, source));
  REJECTED(gmis::check_proposal(test::Uniform{}, 0.0, 1.0, source, {.samples = 0}));
  REJECTED(gmis::check_proposal(test::Uniform{}, 0.0, 1.0, source, {.bins = 0}));
  // Ten samples pass whatever the density says.
  REJECTED(gmis::check_proposal(test::Uniform{}, 0.0, 1.0, source, {.samples = 10}));
  REJECTED(gmis::check_proposal(test::Uniform{}, 0.0, 1.0, source, {.samples = 999, .bins = 1}));
  REJECTED(gmis::check_proposal(test::Uniform{}, 0.0, 1.0, source, {.samples = 1999, .bins = 400}));
  CHECK(gmis::check_proposal(test::Uniform{}, 0.0, 1.0, source, {.samples = 2000, .bins = 400}).passes(1e-6));
}

TEST_CASE("coverage goes by the proposals that an allocation gives samples", "[mis]") {
  const std::array<test::Uniform, 3> thirds{{{0.0, 0.5}, {0.5, 1.0}, {0.0, 1.0}}};
  Numbers grid;
  for (int i = 0; i < 100; ++i) grid.push_back((i + 0.5) / 100.0);
  const auto one = [](double) { return 1; };
  CHECK(gmis::check_coverage(one, thirds, gmis::SampleAllocation({1, 0, 0}), grid).uncovered == 50);
  const auto halves = gmis::check_coverage(one, thirds, gmis::SampleAllocation({1, 1, 0}), grid);
  CHECK(halves.uncovered == 0);
  CHECK(halves.partly_uncovered == 100);
  CHECK(halves.allows(Scheme::N3));
  CHECK_FALSE(halves.allows(Scheme::N1));
  CHECK(gmis::check_coverage(one, thirds, gmis::SampleAllocation({0, 0, 2}), grid).allows(Scheme::N1));
  gmis::Philox source(1);
  CHECK(gmis::check_coverage(one, thirds, gmis::SampleAllocation({1, 0, 0}), test::Uniform{}, 100, source).uncovered >
        0);
}

TEST_CASE("a negative density of any proposal is counted", "[mis]") {
  for (const std::size_t n : {std::size_t{2}, std::size_t{3}, std::size_t{20}}) {
    std::vector<Signed> proposals(n, Signed{1.0});
    proposals[n / 2].sign = -0.25;  // the mixture stays positive
    for (const Scheme scheme : {Scheme::R3, Scheme::N3}) {
      CAPTURE(n, name_of(scheme));
      gmis::Philox source(gmis_test::seed(4));
      std::uint64_t above = 0;
      const auto estimate = gmis::estimate(
          scheme, [&](double x) { return above += x > 0.5, x; }, proposals, 200, source);
      CHECK(estimate.rejected.non_finite_density > 0);
      CHECK(above == 0);  // none of those is divided by a mixture that is too small
    }
    gmis::Philox source(gmis_test::seed(4));
    const std::size_t last = n;
    const auto grouped = gmis::estimate_partial(f, proposals, gmis::Groups<>(n, last), 200, source);
    CHECK(grouped.rejected.non_finite_density > 0);
    const gmis::SampleAllocation allocation(Counts(n, 2));
    CHECK(gmis::estimate<Scheme::N3>(f, proposals, 200, source, allocation).rejected.non_finite_density > 0);
  }
}

TEST_CASE("integers and bools are numbers; SpectrumTraits alone is enough", "[mis]") {
  gmis::Philox a(3), b(3), c(3), d(3);
  const auto whole = gmis::estimate<Scheme::N3>([](double x) { return x > 0.5 ? 2 : 0; }, ramps, 500, a);
  const auto real = gmis::estimate<Scheme::N3>([](double x) { return x > 0.5 ? 2.0 : 0.0; }, ramps, 500, b);
  const auto truth = gmis::estimate<Scheme::N3>([](double x) { return x > 0.5; }, ramps, 500, c);
  CHECK(whole.mean == real.mean);
  CHECK(truth.mean == Approx(real.mean / 2.0).epsilon(1e-14));
  const auto bare = gmis::estimate<Scheme::N3>(
      [](double x) {
        return Bare{x > 0.5 ? 2.0F : 0.0F, x < 0.1 ? std::nanf("") : 1.0F};
      },
      ramps, 500, d);
  CHECK(bare.rejected.non_finite_integrand > 0);
  CHECK(bare.mean[0] == Approx(real.mean).epsilon(1e-6));
  gmis::Philox e(3);
  CHECK(gmis::PilotSamples([](double x) { return x > 0.5 ? 2 : 0; }, ramps, 50, e).problem().node_count() == 150);
  CHECK(gmis::estimate_partial([](double) { return 1U; }, ramps, gmis::Groups<>(3, 2), 5, e).rounds == 5);
  CHECK(gmis::estimate_weighted(
            gmis::Power{}, [](double) { return 1L; }, ramps, 5, e)
            .rounds == 5);
}

TEST_CASE("every engine of the standard library is a source", "[mis]") {
  const auto check = [&](auto source, std::size_t words) {
    CAPTURE(source.min(), source.max());
    const auto estimate = gmis::estimate<Scheme::R2>(f, ramps, 4000, source);
    CHECK(test::normal_p_value((estimate.mean - 1.0) / estimate.standard_error.value()) > test::sidak_level(1e-4, 12));
    // Each bit of a word is set in half of them: the largest of 32 deviations, with its own
    // false-alarm rate.
    std::array<double, 32> set{};
    for (std::size_t i = 0; i < words; ++i) {
      const std::uint32_t word = gmis::uniform_word(source);
      for (unsigned bit = 0; bit < 32; ++bit) set[bit] += (word >> bit) & 1U;
    }
    for (const double count : set) {
      const double z = (count - 0.5 * static_cast<double>(words)) / (0.5 * std::sqrt(static_cast<double>(words)));
      CHECK(test::normal_p_value(z) > test::sidak_level(1e-4, 32 * 12));
    }
  };
  const auto seed = static_cast<std::uint32_t>(gmis_test::seed(1)) | 1U;
  check(std::default_random_engine(seed), 10000);
  check(std::minstd_rand0(seed), 10000);
  check(std::minstd_rand(seed), 10000);
  check(std::mt19937(seed), 10000);
  check(std::mt19937_64(seed), 10000);
  check(std::ranlux24_base(seed), 10000);
  check(std::ranlux48_base(seed), 10000);
  check(std::ranlux24(seed), 2000);
  check(std::ranlux48(seed), 2000);
  check(std::knuth_b(seed), 10000);
  check(gmis::Philox(seed), 10000);
  check(std::independent_bits_engine<std::mt19937, 7, std::uint32_t>(seed), 10000);
  static_assert(gmis::UniformSource<std::random_device>);
  static_assert(!gmis::UniformSource<const gmis::Philox>);
  static_assert(!gmis::UniformSource<int>);
  // A temporary engine, as the algorithms of the standard library take it.
  CHECK(gmis::estimate<Scheme::N3>(f, ramps, 5, gmis::Philox(1)).rounds == 5);
}

TEST_CASE("a set is checked for the source that it is used with", "[mis]") {
  const std::vector<MersenneOnly> proposals(2);
  std::mt19937 source(static_cast<std::uint32_t>(gmis_test::seed(1)));
  const auto estimate = gmis::estimate<Scheme::N3>(f, proposals, 1000, source);
  CHECK(test::normal_p_value((estimate.mean - 1.0) / estimate.standard_error.value()) > 1e-5);
  CHECK(gmis::estimate_partial(f, proposals, gmis::Groups<>(2, 1), 10, source).rounds == 10);
  CHECK(gmis::estimate_weighted(gmis::Power{}, f, proposals, 10, source).rounds == 10);
  CHECK(gmis::PilotSamples(f, proposals, 10, source).problem().node_count() == 20);
  CHECK(gmis::check_coverage(f, proposals, MersenneOnly{}, 10, source).probes == 10);
  CHECK(gmis::check_coverage<std::mt19937>(f, proposals, Numbers{0.5}).allows(Scheme::N1));
}

TEST_CASE("a proposal of logarithms is checked against its density", "[mis]") {
  gmis::Philox source(gmis_test::seed(8));
  CHECK(gmis::check_proposal(LogRamp{{1.0}, 1.0}, 0.0, 1.0, source).passes(1e-5));
  CHECK_FALSE(gmis::check_proposal(LogRamp{{1.0}, 0.7}, 0.0, 1.0, source).passes(1e-5));
}

// A failed sample is done with like any other: its proposal no longer counts as undrawn. Two
// uniform proposals on [0, 2), of which the first fails half the time: it makes samples on [0, 1)
// alone, with density 1/2 there.
TEST_CASE("N2 with an unequal allocation discards the index of a failed sample", "[mis]") {
  const std::array<Half, 2> proposals{{{0.5}, {1.0}}};
  const gmis::SampleAllocation allocation({2, 1});
  // On [0, 1) both are 1/2, so every mixture of the remaining proposals is 1/2; on [1, 2) it is 1/2
  // times the share of the second in it. N2 is biased there, and by how much follows from the three
  // places of the second in the order.
  gmis::Philox source(gmis_test::seed(6));
  const auto estimate =
      gmis::estimate<Scheme::N2>([](double x) { return x < 1.0 ? 1.0 : 0.0; }, proposals, 20000, source, allocation);
  CHECK(test::normal_p_value((estimate.mean - 1.0) / estimate.standard_error.value()) > 1e-5);
  // ∫ over [1, 2): the second is drawn in place 0, 1 or 2 (1/3 each), when its share of the
  // remaining proposals is 1/3, 1/2 or 1; a sample falls there with probability 1/2 and adds (1/3)
  // / (share / 2). The mean is (3 + 2 + 1)/9 = 2/3.
  const auto far =
      gmis::estimate<Scheme::N2>([](double x) { return x < 1.0 ? 0.0 : 1.0; }, proposals, 20000, source, allocation);
  CHECK(test::normal_p_value((far.mean - 2.0 / 3.0) / far.standard_error.value()) > 1e-5);
}

TEST_CASE("a number that is no enumerator is rejected", "[mis]") {
  gmis::Philox source(1);
  const auto scheme = static_cast<Scheme>(6);
  const auto selection = static_cast<gmis::Selection>(3);
  const auto weighting = static_cast<gmis::Weighting>(5);
  REJECTED(gmis::estimate(scheme, f, ramps, 2, source));
  REJECTED(gmis::estimate(selection, gmis::Weighting::W1, f, ramps, 2, source));
  REJECTED(gmis::estimate(gmis::Selection::S1, weighting, f, ramps, 2, source));
  REJECTED((void)gmis::name_of(scheme));
  REJECTED((void)gmis::name_of(selection));
  REJECTED((void)gmis::name_of(weighting));
  REJECTED((void)gmis::cheapest_pair(scheme));
  REJECTED((void)gmis::density_evaluations_per_round(scheme, 3));
  const std::array<double, 2> ends{0.0, 1.0};
  const gmis::TabulatedProblem problem(f, ramps, gmis::composite_gauss_legendre(ends, 1));
  REJECTED((void)gmis::exact_variance(scheme, problem));
}

TEST_CASE("too many rounds are told so", "[mis]") {
  gmis::Philox source(1);
  const auto message = [&](std::uint64_t rounds) {
    return gmis_test::message_of([&] { return gmis::estimate(Scheme::N3, f, ramps, rounds, source); });
  };
  CHECK(message(0) == "the number of rounds must be at least 1");
  CHECK(message(~std::uint64_t{0} >> 1U).find("2^62") != std::string::npos);
}

// What lies in an object is not handed out by one that is about to end.
template <class T>
concept HandsOutFromTemporary = requires {
  std::declval<T>().values();
}
|| requires {
  std::declval<T>().weights();
}
|| requires {
  std::declval<T>().densities(0);
};
static_assert(!HandsOutFromTemporary<gmis::TabulatedProblem>);
static_assert(!HandsOutFromTemporary<const gmis::TabulatedProblem>);
static_assert(HandsOutFromTemporary<gmis::TabulatedProblem&>);
static_assert(std::same_as<decltype(std::declval<gmis::PilotSamples>().problem()), gmis::TabulatedProblem>);
static_assert(std::same_as<decltype(std::declval<gmis::SchemeChoice>().chosen()), gmis::SchemeCandidate>);
static_assert(std::same_as<decltype(std::declval<const gmis::SchemeChoice>().chosen()), gmis::SchemeCandidate>);
