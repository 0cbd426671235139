#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "fuzz/input.hpp"
#include "gmis/mis.hpp"
#include "hostile/weights_oracle.hpp"

// Weights, from bytes: those of the recursion for a path of up to 64 edges against 200 bits, and
// those of the heuristics for up to 16 densities of any positive value against long double.

namespace {

void check_recursion(fuzz::Input& input) {
  const auto deltas = static_cast<hostile::Deltas>(input.below(4));
  const bool is_power = input.below(2) == 1;
  const int edges = 2 + static_cast<int>(input.below(63));
  const auto between = [&](double low, double high) { return input.between(low, high); };
  const auto counts = hostile::hard_counts(between);
  const auto path = hostile::hard_path(between, edges, deltas);
  hostile::Tally tally;
  if (is_power)
    hostile::check_path<gmis::PowerRatio>(path, counts, tally);
  else
    hostile::check_path<gmis::BalanceRatio>(path, counts, tally);
  fuzz::require(tally.out_of_range == 0, "weights are numbers in [0, 1]");
  fuzz::require(tally.worst_weight < 1e-4, "weights equal those of 200 bits");
  fuzz::require(tally.worst_sum < 1e-5, "the weights of a path sum to one");
}

template <class H>
void check_heuristic(const H& heuristic, std::span<const std::uint32_t> counts, std::span<const float> densities) {
  std::array<float, 16> weights;
  const std::span<float> out(weights.data(), densities.size());
  gmis::heuristic_weights(heuristic, counts, densities, out);
  long double largest = 0, total = 0, sum = 0;
  for (std::size_t i = 0; i < out.size(); ++i)
    largest = std::max(largest, static_cast<long double>(counts[i]) * static_cast<long double>(densities[i]));
  if (largest == 0) {
    for (const float weight : out) fuzz::require(weight == 0.0F, "weights of nothing are zero");
    return;
  }
  const auto exact = [&](std::size_t i) {
    return heuristic.unnormalised(static_cast<long double>(counts[i]) * static_cast<long double>(densities[i]) /
                                  largest);
  };
  for (std::size_t i = 0; i < out.size(); ++i) total += exact(i);
  for (std::size_t i = 0; i < out.size(); ++i) {
    fuzz::require(out[i] >= 0.0F && out[i] <= 1.0F, "heuristic weights are in [0, 1]");
    const long double error = std::abs(static_cast<long double>(out[i]) - exact(i) / total);
    fuzz::require(error <= 1e-5L * exact(i) / total + 1e-36L, "heuristic weights equal those of long double");
    sum += static_cast<long double>(out[i]);
  }
  fuzz::require(std::abs(sum - 1) < 1e-5L, "heuristic weights sum to one");
}

/// A set whose densities at any point are given; a sample is its index.
struct Given {
  using Value = int;
  using Density = float;
  std::span<const float> densities;
  [[nodiscard]] std::size_t size() const { return densities.size(); }
  [[nodiscard]] int sample(std::size_t, gmis::UniformSource auto&) const { return 0; }
  [[nodiscard]] float pdf(std::size_t k, int) const { return densities[k]; }
};

void check_densities(fuzz::Input& input) {
  const std::size_t n = 1 + input.below(16);
  std::array<float, 16> densities;
  std::array<std::uint32_t, 16> counts;
  bool are_moderate = true;  // the mean of a round can be held by a float
  for (std::size_t i = 0; i < n; ++i) {
    const float value = std::bit_cast<float>(input.word() & 0x7FFFFFFFU);
    densities[i] = std::isfinite(value) ? value : 0.0F;
    counts[i] = input.below(8);
    are_moderate = are_moderate && densities[i] < 2e37F && densities[i] > 2e-36F;
  }
  const std::span<const float> in(densities.data(), n);
  const std::span<const std::uint32_t> times(counts.data(), n);
  check_heuristic(gmis::Balance{}, times, in);
  check_heuristic(gmis::Power{}, times, in);

  long double mean = 0;
  for (const float density : in) mean += static_cast<long double>(density) / static_cast<long double>(n);
  gmis::Workspace<float, gmis::dynamic_capacity> workspace;
  gmis::Philox source(1);
  std::size_t visited = 0;
  const auto counted = gmis::sample_round<gmis::Scheme::N3>(
      Given{in}, gmis::EqualAllocation{}, source, workspace, [&](int, float phi, std::size_t) {
        ++visited;
        fuzz::require(phi > 0.0F && std::isfinite(phi), "what is visited has a usable density");
        if (are_moderate)
          fuzz::require(std::abs(static_cast<long double>(phi) / mean - 1) < 1e-5L, "the mixture is the mean");
      });
  fuzz::require(visited + counted.zero_density + counted.non_finite_density == n, "every sample is visited or counted");
  if (are_moderate) fuzz::require(visited == n, "no sample is lost");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  if (input.below(2) == 0)
    check_recursion(input);
  else
    check_densities(input);
  return 0;
}
