#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "fuzz/input.hpp"
#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/mis/methods.hpp"

// Arguments of the MIS core, from bytes: every call either throws std::invalid_argument, and then
// for a reason that is found here again without the library, or does what it says.

namespace {

using gmis::Scheme;

/// Uniform on [0, 1); `fault` is the density that it states there.
struct Uniform {
  double density = 1.0;
  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  double pdf(double) const { return density; }
};

double any_number(fuzz::Input& input) {
  switch (input.below(8)) {
    case 0:
      return 0.0;
    case 1:
      return -1.0;
    case 2:
      return std::numeric_limits<double>::quiet_NaN();
    case 3:
      return std::numeric_limits<double>::infinity();
    case 4:
      return std::bit_cast<double>((std::uint64_t{input.word()} << 32U) | input.word());
    default:
      return input.between(0.0, 2.0);
  }
}

/// True when `call` threw std::invalid_argument; anything else that it throws ends the program.
template <class Call>
bool is_rejected(Call&& call) {
  try {
    call();
  } catch (const std::invalid_argument&) {
    return true;
  }
  return false;
}

template <class Allocation>
void check_estimates(const std::vector<Uniform>& proposals, const Allocation& allocation, std::uint64_t rounds,
                     bool fits, bool reaches_all) {
  const auto one = [](double) { return 1; };
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings) {
      gmis::Philox source(1);
      gmis::Estimate<double> estimate;
      const bool rejected = is_rejected(
          [&] { estimate = gmis::estimate(selection, weighting, one, proposals, rounds, source, allocation); });
      const bool can_serve =
          !proposals.empty() && fits && rounds > 0 && (reaches_all || selection == gmis::Selection::S1);
      fuzz::require(rejected == !can_serve, "an estimate is rejected when its arguments do not fit, and only then");
      if (rejected) continue;
      fuzz::require(estimate.rounds == rounds, "all rounds are drawn");
      fuzz::require(std::abs(estimate.mean - 1.0) < 1e-9, "equal proposals integrate one without error");
      fuzz::require(estimate.rejected.total() == 0, "no sample is lost");
    }
  gmis::Philox source(1);
  const bool rejected = is_rejected(
      [&] { static_cast<void>(gmis::estimate_weighted(gmis::Power{}, one, proposals, rounds, source, allocation)); });
  fuzz::require(rejected == !(!proposals.empty() && fits && rounds > 0 && reaches_all),
                "a weighted estimate is rejected when its arguments do not fit, and only then");
}

void check_weights(fuzz::Input& input) {
  const std::vector<Uniform> proposals(input.below(6));
  std::vector<double> weights(input.below(4) > 0 ? proposals.size() : input.below(6));
  for (double& weight : weights) weight = any_number(input);
  const std::size_t samples = input.below(12);
  const std::uint64_t rounds = input.below(3);

  bool are_valid = samples > 0;
  std::size_t positive = 0;
  for (const double weight : weights) {
    are_valid = are_valid && weight >= 0.0 && std::isfinite(weight);
    if (weight > 0.0) ++positive;
  }
  are_valid = are_valid && positive > 0;
  std::vector<std::uint32_t> counts(weights.size());
  const bool no_counts = is_rejected([&] { gmis::apportion<double>(weights, samples, counts); });
  fuzz::require(!are_valid || !no_counts, "weights are apportioned");
  if (!no_counts)
    fuzz::require(std::accumulate(counts.begin(), counts.end(), std::size_t{0}) == samples, "all samples are given");

  const bool rejected = is_rejected([&] {
    const gmis::SampleAllocation allocation(weights, samples);
    for (std::size_t k = 0; k < weights.size() && samples >= positive; ++k)
      fuzz::require((allocation.count(k) > 0) == (weights[k] > 0.0), "a positive weight gets a sample");
    check_estimates(proposals, allocation, rounds, weights.size() == proposals.size(), samples >= positive);
  });
  fuzz::require(rejected == !are_valid, "weights are rejected when they are none, and only then");
  const bool small = is_rejected([&] { const gmis::SampleAllocation<double, 3> allocation(weights, samples); });
  fuzz::require(small == !(are_valid && weights.size() <= 3 && samples <= 3), "a fixed capacity is kept");
}

void check_counts(fuzz::Input& input) {
  const std::vector<Uniform> proposals(input.below(6));
  std::vector<std::uint32_t> counts(input.below(4) > 0 ? proposals.size() : input.below(6));
  for (std::uint32_t& count : counts) count = input.below(4);
  const bool are_valid = std::accumulate(counts.begin(), counts.end(), 0U) > 0;
  const std::uint64_t rounds = input.below(3);
  const bool rejected = is_rejected([&] {
    check_estimates(proposals, gmis::SampleAllocation(counts), rounds, counts.size() == proposals.size(), true);
  });
  fuzz::require(rejected == !are_valid, "counts are rejected when they are none, and only then");
}

void check_groups(fuzz::Input& input) {
  const std::vector<Uniform> proposals(input.below(6));
  const std::size_t size = input.below(4) > 0 ? proposals.size() : input.below(6);
  const auto one = [](double) { return 1; };
  const auto check = [&](const gmis::Groups<>& groups) {
    std::vector<int> seen(groups.proposal_count());
    for (std::size_t g = 0; g < groups.size(); ++g) {
      fuzz::require(!groups.members(g).empty(), "no group is empty");
      for (const std::uint32_t k : groups.members(g)) ++seen[k];
    }
    for (const int times : seen) fuzz::require(times == 1, "groups are a partition");
    gmis::Philox source(1);
    gmis::Estimate<double> estimate;
    const bool rejected = is_rejected([&] { estimate = gmis::estimate_partial(one, proposals, groups, 2, source); });
    fuzz::require(rejected == (groups.proposal_count() != proposals.size()), "groups of another set are rejected");
    if (!rejected) fuzz::require(std::abs(estimate.mean - 1.0) < 1e-9, "groups integrate one without error");
  };
  if (input.below(2) == 0) {
    const std::size_t group_size = input.below(7);
    const auto order = input.below(2) == 0 ? gmis::GroupOrder::strided : gmis::GroupOrder::consecutive;
    const bool rejected = is_rejected([&] { check(gmis::Groups<>(size, group_size, order)); });
    fuzz::require(rejected == (group_size == 0 || group_size > size), "sizes that are none are rejected");
  } else {
    std::vector<std::uint32_t> group_of(size);
    for (std::uint32_t& group : group_of) group = input.below(32) == 0 ? input.word() : input.below(4);
    bool is_partition = size > 0;
    std::uint32_t last = 0;
    for (const std::uint32_t group : group_of) last = std::max(last, group);
    for (std::uint32_t group = 0; is_partition && group <= std::min(last, 64U); ++group)
      is_partition = std::count(group_of.begin(), group_of.end(), group) > 0;
    is_partition = is_partition && last < 64;
    const bool rejected = is_rejected([&] { check(gmis::Groups<>(group_of)); });
    fuzz::require(rejected == !is_partition, "numbers with gaps are rejected, and only those");
  }
}

void check_tables(fuzz::Input& input) {
  std::vector<double> f(input.below(5)), weights(input.below(8) > 0 ? f.size() : input.below(5));
  std::vector<double> densities(input.below(8) > 0 ? f.size() * input.below(4) : input.below(12));
  bool are_valid = !f.empty() && weights.size() == f.size() && !densities.empty() && densities.size() % f.size() == 0;
  for (double& value : f) are_valid = std::isfinite(value = any_number(input)) && are_valid;
  for (double& weight : weights) weight = input.between(0.0, 1.0);
  for (double& density : densities) {
    density = input.below(2) == 0 ? input.between(0.0, 2.0) : any_number(input);
    are_valid = are_valid && density >= 0.0 && std::isfinite(density);
  }
  const bool rejected = is_rejected([&] { static_cast<void>(gmis::TabulatedProblem(f, weights, densities)); });
  fuzz::require(rejected == !are_valid, "tables are rejected when they are none, and only then");
  if (rejected) return;
  const gmis::TabulatedProblem table(f, weights, densities);
  for (const Scheme scheme : gmis::all_schemes) {
    if (table.proposal_count() > gmis::max_exact_r2) break;
    if (scheme == Scheme::N2 && !table.has_full_support()) continue;
    fuzz::require(!std::isnan(exact_moments(scheme, table).variance), "no variance is NaN");
  }
  gmis::Philox source(1);
  const gmis::CostModel costs{any_number(input), any_number(input)};
  static_cast<void>(is_rejected([&] {
    const auto choice = gmis::best_scheme(table, costs, source, input.below(4));
    fuzz::require(choice.chosen().is_unbiased && choice.chosen().has_finite_variance(), "what is chosen can serve");
  }));
}

void check_rules(fuzz::Input& input) {
  std::vector<double> breakpoints(input.below(4));
  bool are_valid = breakpoints.size() >= 2;
  for (std::size_t i = 0; i < breakpoints.size(); ++i) {
    breakpoints[i] = any_number(input);
    are_valid = are_valid && std::isfinite(breakpoints[i]) && (i == 0 || breakpoints[i - 1] < breakpoints[i]);
  }
  const std::size_t panels = input.below(3), order = input.below(6);
  std::size_t size = 0;
  const bool rejected = is_rejected([&] { size = gmis::composite_gauss_legendre(breakpoints, panels, order).size(); });
  fuzz::require(rejected == !(are_valid && panels > 0 && order > 0), "rules are rejected when they are none");
  if (!rejected) fuzz::require(size == (breakpoints.size() - 1) * panels * order, "rules have all their nodes");

  const gmis::Cutoff cutoff{any_number(input)};
  const gmis::Power power{any_number(input)};
  const std::vector<Uniform> proposals(3);
  const auto check = [&](const auto& heuristic) {
    gmis::Philox source(1);
    gmis::Estimate<double> estimate;
    if (!is_rejected([&] {
          estimate = gmis::estimate_weighted(
              heuristic, [](double) { return 1; }, proposals, 2, source);
        }))
      fuzz::require(std::abs(estimate.mean - 1.0) < 1e-9, "a heuristic that is accepted is unbiased");
  };
  check(cutoff);
  check(power);
}

/// The methods that take counts: each is rejected when counts, rounds or its own arguments do not
/// fit, and only then.
void check_methods(fuzz::Input& input) {
  const std::vector<Uniform> proposals(input.below(5));
  const std::size_t n = proposals.size();
  std::vector<std::uint32_t> counts(input.below(4) > 0 ? n : input.below(5));
  for (std::uint32_t& count : counts) count = input.below(4);
  const std::uint64_t rounds = input.below(4);
  const std::size_t canonical = input.below(5);
  std::vector<double> numbers(input.below(4) > 0 ? n : input.below(5));
  for (double& number : numbers) number = any_number(input);
  const bool fit = counts.size() == n && std::accumulate(counts.begin(), counts.end(), 0U) > 0 && rounds > 0;
  const auto one = [](double) { return 1; };
  const auto check = [&](bool can_serve, double tolerance, auto method) {
    gmis::Philox source(1);
    double mean = 1.0;
    const bool rejected = is_rejected([&] { mean = method(source); });
    fuzz::require(rejected == !can_serve, "a method is rejected when its arguments do not fit, and only then");
    fuzz::require(rejected || std::abs(mean - 1.0) <= tolerance, "a method integrates one without error");
  };
  check(fit, 1e-9, [&](auto& s) { return gmis::estimate_optimal_direct(one, proposals, counts, rounds, s).mean; });
  check(fit, 1e-9, [&](auto& s) { return gmis::estimate_optimal_progressive(one, proposals, counts, rounds, s).mean; });
  check(fit, 1e-9, [&](auto& s) { return gmis::estimate_resampled(one, one, proposals, counts, rounds, s).mean; });
  check(fit && canonical < n && counts[canonical] > 0, 1e-9,
        [&](auto& s) { return gmis::estimate_pairwise(one, proposals, counts, canonical, rounds, s).mean; });
  bool are_factors = numbers.size() == n;
  for (std::size_t k = 0; k < numbers.size() && are_factors && counts.size() == n; ++k)
    are_factors = std::isfinite(numbers[k]) && (numbers[k] > 0.0 || (counts[k] == 0 && !std::isnan(numbers[k])));
  check(fit && are_factors, 1e9, [&](auto& s) {
    return gmis::estimate_with_weights(gmis::ScaledBalance{numbers}, one, proposals, counts, rounds, s).mean;
  });
  gmis::Philox source(1);
  static_cast<void>(is_rejected([&] {
    const auto result = gmis::estimate_controlled(one, proposals, counts, numbers, rounds, source);
    fuzz::require(numbers.size() == n, "one coefficient for each proposal");
    static_cast<void>(result);
  }));
  const double fraction = any_number(input);
  static_cast<void>(is_rejected([&] {
    std::vector<double> others(numbers.size());
    for (double& other : others) other = any_number(input);
    double sum = 0.0;
    for (const double p : gmis::compensated_density(numbers, others, fraction)) {
      fuzz::require(p >= 0.0, "no density is negative");
      sum += p;
    }
    fuzz::require(std::abs(sum - 1.0) < 1e-9, "a compensated density has the integral one");
  }));
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  switch (input.below(6)) {
    case 0:
      check_weights(input);
      break;
    case 1:
      check_counts(input);
      break;
    case 2:
      check_groups(input);
      break;
    case 3:
      check_tables(input);
      break;
    case 4:
      check_methods(input);
      break;
    default:
      check_rules(input);
  }
  return 0;
}
