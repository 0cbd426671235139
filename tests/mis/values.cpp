#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <random>
#include <span>
#include <tuple>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// Samples and integrands of any type, sets of any kind.

namespace {

using gmis::Scheme;

/// A point on a triangle mesh, say: any copyable type will do as a sample.
struct SurfaceSample {
  int triangle;
  glm::vec2 barycentric;
};
struct TriangleProposal {
  std::array<float, 2> probability;
  SurfaceSample sample(gmis::UniformSource auto& source) const {
    const int triangle = gmis::uniform<float>(source) < probability[0] ? 0 : 1;
    const float u = gmis::uniform<float>(source);
    return {triangle, {u, gmis::uniform<float>(source)}};
  }
  float pdf(const SurfaceSample& x) const { return probability[static_cast<std::size_t>(x.triangle)]; }
};

/// A set that evaluates all its densities at once, and only so.
struct BatchOnly {
  using Value = double;
  using Density = double;
  static constexpr std::size_t capacity = 4;  // room for more than there are
  std::array<test::Ramp, 3> ramps;
  int* batches;
  std::size_t size() const { return ramps.size(); }
  double sample(std::size_t k, gmis::UniformSource auto& source) const { return ramps[k].sample(source); }
  void pdfs(double x, std::span<double> out) const {
    ++*batches;
    for (std::size_t k = 0; k < ramps.size(); ++k) out[k] = ramps[k].pdf(x);
  }
};
/// Both one at a time and all at once.
struct BatchToo : BatchOnly {
  double pdf(std::size_t k, double x) const { return ramps[k].pdf(x); }
};

static_assert(gmis::Proposal<test::Normal, double>);
static_assert(gmis::Proposal<test::TiltedSphere, glm::vec3>);
static_assert(gmis::Proposal<test::Normal3, glm::dvec3>);
static_assert(!gmis::Proposal<test::Normal, glm::vec3>);
static_assert(!gmis::AnyProposal<int>);
static_assert(gmis::ProposalSet<BatchOnly> && gmis::ProposalSet<BatchToo>);
static_assert(gmis::Proposals<std::vector<test::Normal>>);
static_assert(!gmis::Proposals<std::vector<int>>);

}  // namespace

TEST_CASE("a sample may be of any type", "[mis]") {
  const std::array<TriangleProposal, 2> proposals{{{{0.5F, 0.5F}}, {{0.9F, 0.1F}}}};
  gmis::Philox source(gmis_test::seed(3));
  // ∫ f over both unit squares: 1 · 1 + 3 · 1/2.
  const auto estimate = gmis::estimate<Scheme::N3>(
      [](const SurfaceSample& x) { return x.triangle == 0 ? 1.0F : 3.0F * x.barycentric.x; }, proposals, 20000, source);
  CHECK(test::normal_p_value((estimate.mean - 2.5) / estimate.standard_error.value()) > 1e-4);
  STATIC_REQUIRE(std::is_same_v<decltype(estimate.mean), double>);
}

// The weights of an allocation are double unless said otherwise.
TEST_CASE("densities in float take an allocation with weights in double", "[mis]") {
  const std::array<TriangleProposal, 2> proposals{{{{0.5F, 0.5F}}, {{0.9F, 0.1F}}}};
  const gmis::SampleAllocation allocation({0.6, 0.4}, 5);
  gmis::Philox source(gmis_test::seed(3));
  const auto f = [](const SurfaceSample& x) { return x.triangle == 0 ? 1.0F : 3.0F * x.barycentric.x; };
  const auto estimate = gmis::estimate<Scheme::R3>(f, proposals, 4000, source, allocation);
  CHECK(test::normal_p_value((estimate.mean - 2.5) / estimate.standard_error.value()) > 1e-4);
}

TEST_CASE("an integrand may have channels", "[mis]") {
  const std::array<test::Ramp, 2> ramps{{{-1.0}, {1.0}}};
  gmis::Philox source(gmis_test::seed(3));
  const auto estimate = gmis::estimate<Scheme::R2>(
      [](double x) { return glm::vec3(1.0F, static_cast<float>(2.0 * x), static_cast<float>(3.0 * x * x)); }, ramps,
      20000, source);
  STATIC_REQUIRE(std::is_same_v<std::remove_const_t<decltype(estimate.mean)>, glm::dvec3>);
  for (int c = 0; c < 3; ++c) {
    const double z = (estimate.mean[c] - 1.0) / (*estimate.standard_error)[c];
    CHECK(test::normal_p_value(z) > 1e-4 / 3.0);
  }
  // Each channel is what it would be alone.
  gmis::Philox same_source(gmis_test::seed(3));
  const auto alone =
      gmis::estimate<Scheme::R2>([](double x) { return static_cast<float>(2.0 * x); }, ramps, 20000, same_source);
  CHECK(alone.mean == estimate.mean[1]);
  CHECK(alone.variance.value() == (*estimate.variance)[1]);
}

TEST_CASE("long double integrands are summed in long double", "[mis]") {
  const std::array<test::Ramp, 2> ramps{{{-1.0}, {1.0}}};
  gmis::Philox source(gmis_test::seed(3));
  const auto estimate =
      gmis::estimate<Scheme::N3>([](double x) { return static_cast<long double>(x); }, ramps, 10, source);
  STATIC_REQUIRE(std::is_same_v<std::remove_const_t<decltype(estimate.mean)>, long double>);
}

TEST_CASE("sets of every kind give the same estimate", "[mis]") {
  const std::array<test::Ramp, 3> array{{{-1.0}, {0.3}, {1.5}}};
  const std::vector<test::Ramp> vector(array.begin(), array.end());
  const std::span<const test::Ramp> span(array);
  const auto tuple = std::make_tuple(array[0], array[1], array[2]);
  int batches = 0;
  const BatchOnly batch_only{array, &batches};
  const BatchToo batch_too{{array, &batches}};
  const auto f = [](double x) { return x * std::exp(x); };

  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings) {
      const Scheme scheme = scheme_of(selection, weighting);
      CAPTURE(name_of(selection), name_of(weighting));
      const auto run = [&](const auto& proposals) {
        gmis::Philox source(gmis_test::seed(8));
        return gmis::estimate(selection, weighting, f, proposals, 100, source);
      };
      const auto expected = run(array);
      CHECK(run(vector).mean == expected.mean);
      CHECK(run(span).mean == expected.mean);
      CHECK(run(tuple).mean == Approx(expected.mean).epsilon(1e-14));
      CHECK(run(tuple).density_evaluations == expected.density_evaluations);

      batches = 0;
      const auto all_at_once = run(batch_only);
      CHECK(all_at_once.mean == Approx(expected.mean).epsilon(1e-14));
      CHECK(batches == 300);
      CHECK(all_at_once.density_evaluations == 900);  // what is really evaluated, needed or not

      batches = 0;
      CHECK(run(batch_too).mean == Approx(expected.mean).epsilon(1e-14));
      CHECK(run(batch_too).density_evaluations == expected.density_evaluations);
      CHECK((batches > 0) == !needs_full_support(scheme));  // in batches where all are needed, else one at a time
    }
}

TEST_CASE("any full-width generator of the standard library is a source", "[mis]") {
  const std::array<test::Ramp, 2> ramps{{{-1.0}, {1.0}}};
  const auto check = [&](auto source) {
    const auto estimate = gmis::estimate<Scheme::N3>([](double x) { return 2.0 * x; }, ramps, 4000, source);
    CHECK(test::normal_p_value((estimate.mean - 1.0) / estimate.standard_error.value()) > 1e-5);
  };
  check(std::mt19937(gmis_test::seed(1)));
  check(std::mt19937_64(gmis_test::seed(1)));
  check(gmis::Philox(gmis_test::seed(1)));
}

TEST_CASE("partial sums of several threads can be merged", "[mis]") {
  const std::array<test::Ramp, 2> ramps{{{-1.0}, {1.0}}};
  const auto f = [](double x) { return x < 0.01 ? std::nan("") : x; };
  const auto set = gmis::as_proposal_set(ramps);
  gmis::Workspace<double, 2> workspace;
  gmis::EstimateAccumulator<double> first, second;
  gmis::Philox source(gmis_test::seed(1)), same_source(gmis_test::seed(1));
  for (int round = 0; round < 1000; ++round)
    (round < 300 ? first : second).add_round(f, 2, [&](auto&& visit) {
      return gmis::sample_round<Scheme::R3>(set, gmis::EqualAllocation{}, source, workspace, visit);
    });
  first.merge(second);
  const auto merged = first.result();
  const auto whole = gmis::estimate<Scheme::R3>(f, ramps, 1000, same_source);
  CHECK(merged.mean == Approx(whole.mean).epsilon(1e-14));
  CHECK(merged.variance.value() == Approx(whole.variance.value()).epsilon(1e-12));
  CHECK(merged.rounds == whole.rounds);
  CHECK(merged.samples == whole.samples);
  CHECK(merged.density_evaluations == whole.density_evaluations);
  CHECK(merged.integrand_evaluations == whole.integrand_evaluations);
  CHECK(merged.rejected == whole.rejected);
}
