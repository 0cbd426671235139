#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "gmis/core/density_tests.hpp"
#include "gmis/mis.hpp"
#include "gmis/mis/batched_round.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/mis/location_scale.hpp"
#include "gmis/testing/seeded.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// The code of docs/mis.md, verbatim, and checks that it does what the text says.

namespace {

struct Exponential {
  double rate;
  double sample(gmis::UniformSource auto& source) const {
    return -std::log(1.0 - gmis::uniform<double>(source)) / rate;
  }
  double pdf(double x) const { return x >= 0.0 ? rate * std::exp(-rate * x) : 0.0; }
};
static_assert(gmis::IsProposal<Exponential, double>());

struct BelowTen {
  Exponential exponential;
  std::optional<double> sample(gmis::UniformSource auto& source) const {
    const double x = exponential.sample(source);
    if (x >= 10.0) return std::nullopt;
    return x;
  }
  double pdf(double x) const { return x < 10.0 ? exponential.pdf(x) : 0.0; }
};
static_assert(gmis::Proposal<BelowTen, double>);

struct LogExponential {
  double rate;
  double sample(gmis::UniformSource auto& source) const { return Exponential{rate}.sample(source); }
  double log_pdf(double x) const { return x >= 0.0 ? std::log(rate) - rate * x : -INFINITY; }
};

class Lobes {
 public:
  using Value = double;
  using Density = float;
  static constexpr std::size_t capacity = 4;  // the largest number of proposals

  explicit Lobes(std::span<const float> rates) : size_(rates.size()) {
    for (std::size_t i = 0; i < size_; ++i) rates_[i] = rates[i];
  }
  std::size_t size() const { return size_; }
  double sample(std::size_t i, gmis::UniformSource auto& source) const {
    return Exponential{static_cast<double>(rates_[i])}.sample(source);
  }
  void pdfs(double x, std::span<float> out) const {
    for (std::size_t i = 0; i < size_; ++i) out[i] = rates_[i] * std::exp(-rates_[i] * static_cast<float>(x));
  }

 private:
  std::size_t size_;
  std::array<float, 4> rates_{};
};

double estimate_moment() {
  const std::array<Exponential, 2> proposals{{{0.5}, {2.0}}};
  gmis::Philox source(42);
  const auto f = [](double x) { return x * std::exp(-x); };
  const auto estimate = gmis::estimate<gmis::Scheme::N3>(f, proposals, 10'000, source);
  return estimate.mean;  // about 1
}

auto estimate_with_pair(gmis::Selection selection, gmis::Weighting weighting) {
  const auto proposals = std::make_tuple(Exponential{0.5}, BelowTen{{0.2}});
  gmis::Philox source(42);
  const auto f = [](double x) { return glm::vec3(std::exp(-x), x * std::exp(-x), 0.0); };
  return gmis::estimate(selection, weighting, f, proposals, 10'000, source);
}

auto estimate_with_allocation() {
  const std::vector<Exponential> proposals{{0.5}, {1.0}, {2.0}};
  const gmis::SampleAllocation allocation({0.6, 0.3, 0.1}, 10);  // 6, 3 and 1 samples
  gmis::Philox source(42);
  const auto f = [](double x) { return x * std::exp(-x); };
  return gmis::estimate<gmis::Scheme::N3>(f, proposals, 10'000, source, allocation);
}

auto estimate_with_power_heuristic() {
  const std::vector<Exponential> proposals{{0.5}, {1.0}, {2.0}};
  const gmis::SampleAllocation allocation({6, 3, 1});
  gmis::Philox source(42);
  const auto f = [](double x) { return x * std::exp(-x); };
  return gmis::estimate_weighted(gmis::Power{2.0}, f, proposals, 10'000, source, allocation);
}

double own_loop() {
  const std::array<Exponential, 2> proposals{{{0.5}, {2.0}}};
  gmis::Philox source(42);
  std::array<double, 2> part{};
  gmis::sample_round<gmis::Scheme::N2>(proposals, source, [&](double x, double denominator, std::size_t index) {
    part[index] += x * std::exp(-x) / denominator;  // x was made by proposals[index]
  });
  return (part[0] + part[1]) / 2.0;
}

double own_loop_of_any_size(const std::vector<Exponential>& proposals, std::uint64_t rounds) {
  const auto set = gmis::as_proposal_set(proposals);
  gmis::Workspace<double, gmis::dynamic_capacity> workspace;  // grows once, is used by all rounds
  gmis::Philox source(42);
  double sum = 0.0;
  for (std::uint64_t round = 0; round < rounds; ++round)
    gmis::sample_round<gmis::Scheme::R2>(
        set, gmis::EqualAllocation{}, source, workspace,
        [&](double x, double denominator, std::size_t) { sum += x * std::exp(-x) / denominator; });
  return sum / static_cast<double>(rounds * proposals.size());
}

bool all_schemes_are_unbiased() {
  const auto proposals = std::make_tuple(Exponential{0.5}, BelowTen{{0.2}});
  const auto f = [](double x) { return x * std::exp(-x); };
  gmis::Philox source(1);
  const auto coverage = gmis::check_coverage(f, proposals, Exponential{0.1}, 1000, source);
  return coverage.allows(gmis::Scheme::R1);  // no: the second proposal is zero from 10 on
}

double variance_of_n3() {
  const std::array<Exponential, 2> proposals{{{0.5}, {2.0}}};
  const auto f = [](double x) { return x * std::exp(-x); };
  const std::array<double, 3> breakpoints{0.0, 5.0, 60.0};  // the ends, and every jump
  const auto nodes = gmis::composite_gauss_legendre(breakpoints, 16);
  return gmis::exact_variance(gmis::Scheme::N3, {f, proposals, nodes});
}

auto estimate_in_groups(const std::vector<Exponential>& proposals) {
  const gmis::Groups<> groups(proposals.size(), 4);  // of 4: a sample costs 4 densities
  gmis::Philox source(42);
  const auto f = [](double x) { return x * std::exp(-x); };
  return gmis::estimate_partial(f, proposals, groups, 10'000, source);
}

auto estimate_side_by_side() {
  std::vector<double> locations, scales;
  for (int i = 0; i < 64; ++i) {
    locations.push_back(0.1 * i - 3.2);
    scales.push_back(0.7);
  }
  const gmis::LocationScaleSet<gmis::shapes::Normal> set(locations, scales);
  gmis::Philox source(42);
  const auto f = [](double x) { return x * x * std::exp(-x * x); };
  return gmis::estimate<gmis::Scheme::N3>(f, set, 1'000, source);  // all densities at a point in one loop
}

auto estimate_of_batches(const std::vector<Exponential>& proposals) {
  gmis::Philox source(42);
  const auto f = [](double x) { return x * std::exp(-x); };
  return gmis::estimate_in_batches(f, proposals, 10'000, source);  // one density at 16 points in one loop
}

gmis::SchemeChoice which_scheme(const std::vector<Exponential>& proposals) {
  gmis::Philox source(7);
  const auto f = [](double x) { return x * std::exp(-x); };
  const gmis::PilotSamples pilot(f, proposals, 100, source);  // 100 samples of each proposal, with all densities
  const gmis::CostModel costs{.per_density = 8.0, .per_sample = 40.0};  // nanoseconds, as you measured them
  return gmis::best_scheme(pilot.problem(), costs, source);
}

}  // namespace

TEST_CASE("your own proposal is checked", "[mis][docs]") {
  auto source = gmis::seeded("my proposal");
  const gmis::DensityCheck check = gmis::check_proposal(Exponential{2.0}, 0.0, 10.0, source);
  CHECK(check.passes(1e-6));
  CHECK(check.integral == Approx(1.0).margin(1e-4));
}

TEST_CASE("the guide's code does what the guide says", "[mis][docs]") {
  CHECK(std::abs(estimate_moment() - 1.0) < 0.02);
  CHECK(std::abs(own_loop() - 1.0) < 2.0);
  CHECK(std::abs(own_loop_of_any_size({{0.5}, {2.0}}, 10'000) - 1.0) < 0.05);
  CHECK_FALSE(all_schemes_are_unbiased());

  std::vector<Exponential> eight;
  for (int k = 0; k < 8; ++k) eight.push_back({0.4 + 0.2 * k});
  const auto grouped = estimate_in_groups(eight);
  CHECK(grouped.density_evaluations == 10'000 * 8 * 4);
  CHECK(test::normal_p_value((grouped.mean - 1.0) / grouped.standard_error.value()) > 1e-4);
  const auto wide = estimate_side_by_side();
  CHECK(test::normal_p_value((wide.mean - 0.5 * std::sqrt(std::acos(-1.0))) / wide.standard_error.value()) > 1e-4);
  const auto in_batches = estimate_of_batches(eight);
  CHECK(test::normal_p_value((in_batches.mean - 1.0) / in_batches.standard_error.value()) > 1e-4);
  const auto choice = which_scheme(eight);
  for (const auto& candidate : choice.candidates)
    CHECK(choice.chosen().variance_times_cost() <= candidate.variance_times_cost());

  const auto allocated = estimate_with_allocation();
  CHECK(allocated.samples == 100'000);
  CHECK(test::normal_p_value((allocated.mean - 1.0) / allocated.standard_error.value()) > 1e-4);
  const auto power = estimate_with_power_heuristic();
  CHECK(test::normal_p_value((power.mean - 1.0) / power.standard_error.value()) > 1e-4);
  const auto pair = estimate_with_pair(gmis::Selection::S2, gmis::Weighting::W4);
  CHECK(test::normal_p_value((pair.mean.x - 1.0) / pair.standard_error->x) > 1e-4);
  CHECK(test::normal_p_value((pair.mean.y - 1.0) / pair.standard_error->y) > 1e-4);
  CHECK(pair.failed_samples > 0);

  const std::array<Exponential, 2> proposals{{{0.5}, {2.0}}};
  gmis::Philox source(3);
  const auto measured =
      gmis::estimate<gmis::Scheme::N3>([](double x) { return x * std::exp(-x); }, proposals, 100'000, source);
  CHECK(measured.variance.value() == Approx(variance_of_n3()).epsilon(0.05));

  const std::array<float, 3> rates{0.5F, 1.0F, 2.0F};
  const Lobes lobes(rates);
  const auto batched =
      gmis::estimate<gmis::Scheme::N3>([](double x) { return x * std::exp(-x); }, lobes, 10'000, source);
  CHECK(test::normal_p_value((batched.mean - 1.0) / batched.standard_error.value()) > 1e-4);
  const std::array<LogExponential, 2> logs{{{0.5}, {2.0}}};
  const auto from_logs = gmis::estimate<gmis::Scheme::N3>(
      [](double x) { return gmis::LogValue<double>{std::log(x) - x}; }, logs, 10'000, source);
  CHECK(test::normal_p_value((from_logs.mean - 1.0) / from_logs.standard_error.value()) > 1e-4);
}
