#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

using gmis::Scheme;
using gmis::Selection;
using gmis::Weighting;

/// Elvira et al., the discussion of each pair, written out pair by pair.
static_assert(scheme_of(Selection::S1, Weighting::W1) == Scheme::R3);
static_assert(scheme_of(Selection::S1, Weighting::W2) == Scheme::R1);
static_assert(scheme_of(Selection::S1, Weighting::W3) == Scheme::R3);
static_assert(scheme_of(Selection::S1, Weighting::W4) == Scheme::R2);
static_assert(scheme_of(Selection::S1, Weighting::W5) == Scheme::R3);
static_assert(scheme_of(Selection::S2, Weighting::W1) == Scheme::N2);
static_assert(scheme_of(Selection::S2, Weighting::W2) == Scheme::N1);
static_assert(scheme_of(Selection::S2, Weighting::W3) == Scheme::N3);
static_assert(scheme_of(Selection::S2, Weighting::W4) == Scheme::N3);
static_assert(scheme_of(Selection::S2, Weighting::W5) == Scheme::N3);
static_assert(scheme_of(Selection::S3, Weighting::W1) == Scheme::N1);
static_assert(scheme_of(Selection::S3, Weighting::W2) == Scheme::N1);
static_assert(scheme_of(Selection::S3, Weighting::W3) == Scheme::N1);
static_assert(scheme_of(Selection::S3, Weighting::W4) == Scheme::N3);
static_assert(scheme_of(Selection::S3, Weighting::W5) == Scheme::N3);

static_assert(!needs_full_support(Scheme::R3) && !needs_full_support(Scheme::N3));
static_assert(needs_full_support(Scheme::R1) && needs_full_support(Scheme::R2) && needs_full_support(Scheme::N1) &&
              needs_full_support(Scheme::N2));
static_assert(safe_for_partial_support(Scheme::R2) == Scheme::R3 && safe_for_partial_support(Scheme::N2) == Scheme::N3);

/// Counts every call of a density.
struct Counted {
  test::Normal normal;
  std::size_t* calls;
  double sample(gmis::UniformSource auto& source) const { return normal.sample(source); }
  double pdf(double x) const {
    ++*calls;
    return normal.pdf(x);
  }
};

/// Counts every random number.
struct CountedSource {
  using result_type = std::uint64_t;
  gmis::Philox source;
  std::size_t calls = 0;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }
  result_type operator()() {
    ++calls;
    return static_cast<result_type>(gmis::uniform<double>(source) * 0x1p53) << 11U;
  }
};

/// The random numbers of 20 rounds of `n` samples by a pair.
std::size_t random_numbers(gmis::SelectionAndWeighting pair, std::size_t n) {
  const std::vector<test::Normal> proposals(n, {0.0, 1.0});
  const auto set = gmis::as_proposal_set(proposals);
  gmis::Workspace<double, gmis::dynamic_capacity> workspace;
  CountedSource source{gmis::Philox(gmis_test::seed(6))};
  for (int round = 0; round < 20; ++round)
    gmis::dispatch(pair.selection, pair.weighting, [&](auto s, auto w) {
      (void)gmis::sample_round<decltype(s)::value, decltype(w)::value>(set, gmis::EqualAllocation{}, source, workspace,
                                                                       [](double, double, std::size_t) {});
    });
  return source.calls;
}

}  // namespace

TEST_CASE("a scheme is run as that of its pairs which draws the fewest random numbers", "[mis]") {
  // Each of its pairs is run. Choosing by a permutation and choosing in order differ from two
  // proposals on.
  for (const std::size_t n : {2U, 5U, 33U})
    for (const Scheme scheme : gmis::all_schemes) {
      std::size_t fewest = std::numeric_limits<std::size_t>::max(), most = 0;
      for (const Selection selection : gmis::all_selections)
        for (const Weighting weighting : gmis::all_weightings) {
          if (scheme_of(selection, weighting) != scheme) continue;
          const std::size_t count = random_numbers({selection, weighting}, n);
          fewest = std::min(fewest, count);
          most = std::max(most, count);
        }
      CAPTURE(n, name_of(scheme), fewest, most);
      CHECK(random_numbers(cheapest_pair(scheme), n) == fewest);
      if (scheme == Scheme::N1 || scheme == Scheme::N3) CHECK(most > fewest);  // there is a choice
    }
}

TEST_CASE("a scheme is run as one of its own pairs", "[mis]") {
  for (const Scheme scheme : gmis::all_schemes) {
    const auto pair = cheapest_pair(scheme);
    CHECK(scheme_of(pair.selection, pair.weighting) == scheme);
  }
}

TEST_CASE("the dispatchers hand over the scheme or pair that they were given", "[mis]") {
  for (const Scheme scheme : gmis::all_schemes)
    CHECK(gmis::dispatch(scheme, [](auto fixed) { return decltype(fixed)::value; }) == scheme);
  for (const Selection selection : gmis::all_selections)
    for (const Weighting weighting : gmis::all_weightings) {
      const auto seen = gmis::dispatch(selection, weighting, [](auto s, auto w) {
        return gmis::SelectionAndWeighting{decltype(s)::value, decltype(w)::value};
      });
      CHECK(seen == gmis::SelectionAndWeighting{selection, weighting});
    }
}

TEST_CASE("every pair, chosen at run time or at compile time, gives the same bits", "[mis]") {
  const std::array<test::Normal, 3> proposals{{{-1.0, 1.0}, {0.0, 2.0}, {1.0, 1.5}}};
  const auto f = [](double x) { return std::exp(-x * x); };
  for (const Selection selection : gmis::all_selections)
    for (const Weighting weighting : gmis::all_weightings) {
      gmis::Philox source(gmis_test::seed(5));
      const auto at_run_time = gmis::estimate(selection, weighting, f, proposals, 20, source);
      const auto at_compile_time = gmis::dispatch(selection, weighting, [&](auto s, auto w) {
        gmis::Philox own_source(gmis_test::seed(5));
        return gmis::estimate<decltype(s)::value, decltype(w)::value>(f, proposals, 20, own_source);
      });
      CHECK(at_run_time.mean == at_compile_time.mean);
      CHECK(at_run_time.variance == at_compile_time.variance);
      CHECK(at_run_time.density_evaluations == at_compile_time.density_evaluations);
    }
}

// What accuracy costs: the calls that really happen, and those that are reported, are those of the
// design's table.
TEST_CASE("density evaluations per round", "[mis]") {
  const std::size_t n = GENERATE(1U, 2U, 5U, 64U);
  CAPTURE(n);
  std::size_t calls = 0;
  std::vector<Counted> proposals;
  for (std::size_t k = 0; k < n; ++k) proposals.push_back({{static_cast<double>(k) * 0.01, 1.0}, &calls});
  const auto set = gmis::as_proposal_set(proposals);
  gmis::Workspace<double, gmis::dynamic_capacity> workspace;

  for (const Selection selection : gmis::all_selections)
    for (const Weighting weighting : gmis::all_weightings) {
      gmis::Philox source(gmis_test::seed(7));
      const Scheme scheme = scheme_of(selection, weighting);
      CAPTURE(name_of(selection), name_of(weighting));
      for (int round = 0; round < 4; ++round) {
        calls = 0;
        std::set<std::size_t> distinct;
        const auto counts = gmis::dispatch(selection, weighting, [&](auto s, auto w) {
          return gmis::sample_round<decltype(s)::value, decltype(w)::value>(
              set, gmis::EqualAllocation{}, source, workspace,
              [&](double, double, std::size_t index) { distinct.insert(index); });
        });
        std::size_t expected = 0;
        if (scheme == Scheme::R1 || scheme == Scheme::N1) expected = n;
        if (scheme == Scheme::R3 || scheme == Scheme::N3) expected = n * n;
        if (scheme == Scheme::N2) expected = n * (n + 1) / 2;
        if (scheme == Scheme::R2) expected = n * distinct.size();
        CHECK(calls == expected);
        CHECK(counts.density_evaluations == expected);
        CHECK(density_evaluations_per_round(scheme, n, distinct.size()) == expected);
        if (selection != Selection::S1) CHECK(distinct.size() == n);  // each index once a round
      }
    }
}
