#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/arguments.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/mixture.hpp"
#include "gmis/mis/round_moments.hpp"

namespace gmis {

/// Estimates ∫ f with groups of proposals that are chosen anew in every round, *after* its samples were drawn [Elvira,
/// Martino, Luengo, Bugallo: Heretical multiple importance sampling, 2016]. Each proposal makes one sample. The sample with
/// the largest |f|/q_own leads the first group: its proposal is joined by the P − 1 others with the largest densities there,
/// which brings that weight down the most; then the next one among proposals without a group, and so on. A sample is
/// divided by the mixture of its group, as in the partial deterministic mixture.
///
/// Biased, since groups depend on samples: too small on average for f ≥ 0, and more rounds do not help, as the bias of the
/// mean is that of a single round. It pays where few rounds are drawn of many proposals, and an outlier costs more than a bias.
/// With P = 1 and P = N the groups cannot depend on anything: N1 and N3.
///
/// Densities a round: N, then those of the proposals still without a group at each leader, then P − 1 for each other sample:
/// about N P + N²/(2 P). f may have several channels (the sum of their sizes counts). Samples and failures are
/// counted as by `estimate`. Throws std::invalid_argument for no proposals, no rounds, or P outside 1 to N.
template <class Integrand, class P, class Source>
requires(detail::explain_arguments<Integrand, P, Source>())
    [[nodiscard]] auto estimate_heretical(Integrand&& f, const P& proposals, std::size_t group_size,
                                          std::uint64_t rounds, Source& source) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  using X = typename Set::Value;
  using T = typename Set::Density;
  using F = SummandOf<Integrand, X>;
  using A = typename RoundMoments<F>::A;
  using Traits = SpectrumTraits<F>;
  const std::size_t n = set.size();
  require_argument(group_size > 0 && group_size <= n, "the size of the groups must lie between 1 and N");
  require_rounds(rounds);
  const std::size_t group_count = (n + group_size - 1) / group_size;

  struct Drawn {
    X x;
    F value;
    T own;        // its density or the logarithm of it
    double size;  // |f|/q_own
  };
  std::vector<std::optional<Drawn>> drawn(n);
  std::vector<std::size_t> free(n);
  std::vector<T> at_leader(n), buffer(n);
  RoundMoments<F> moments;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    RoundCounts cost;
    typename RoundMoments<F>::Channels sum{};
    const auto densities_at = [&](const X& x) { return DensitiesAt<Set>(set, x, buffer.data()); };
    for (std::size_t k = 0; k < n; ++k) {
      free[k] = k;
      drawn[k].reset();
      const auto result = set.sample(k, source);
      const X* x = nullptr;
      if constexpr (SampleResult<std::remove_cvref_t<decltype(result)>>::can_fail) {
        if (!result) {
          ++cost.failed_samples;
          continue;
        }
        x = &*result;
      } else {
        x = &result;
      }
      auto densities = densities_at(*x);
      const T own = densities[k];
      cost.density_evaluations += densities.evaluations();
      const auto as_denominator = DensitiesAt<Set>::as_denominator(own);
      if (!is_usable(as_denominator)) [[unlikely]] {
        ++(state_of(as_denominator) == DensityState::zero ? cost.zero_density : cost.non_finite_density);
        continue;
      }
      const F value = value_of(f, *x);
      double size = 0.0;
      for (int c = 0; c < Traits::channel_count; ++c)
        size += std::abs(static_cast<double>(ratio<A>(Traits::channel(value, c), as_denominator)));
      drawn[k] = Drawn{*x, value, own, size > 0.0 ? size : 0.0};  // NaN leads no group
    }

    std::size_t begin = 0;  // free[begin …] have no group yet
    for (std::size_t group = 0; group < group_count; ++group) {
      const std::size_t members = n / group_count + (group < n % group_count ? 1 : 0), end = begin + members;
      const auto size_of = [&](std::size_t k) { return drawn[k] ? drawn[k]->size : -1.0; };
      std::swap(free[begin], *std::max_element(free.begin() + static_cast<std::ptrdiff_t>(begin), free.end(),
                                               [&](std::size_t a, std::size_t b) { return size_of(a) < size_of(b); }));
      const std::size_t leader = free[begin];
      const bool decides = size_of(leader) > 0.0 && members > 1;
      if (decides) {
        auto densities = densities_at(drawn[leader]->x);
        at_leader[leader] = drawn[leader]->own;
        for (std::size_t i = begin + 1; i < n; ++i) at_leader[free[i]] = densities[free[i]];
        cost.density_evaluations += densities.evaluations();
        std::partial_sort(free.begin() + static_cast<std::ptrdiff_t>(begin + 1),
                          free.begin() + static_cast<std::ptrdiff_t>(end), free.end(),
                          [&](std::size_t a, std::size_t b) { return at_leader[a] > at_leader[b]; });
      }
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t k = free[i];
        if (!drawn[k]) continue;
        MixtureSum<T, is_log_set<Set>> mixture;
        auto densities = densities_at(drawn[k]->x);
        for (std::size_t j = begin; j < end; ++j)
          mixture.add(free[j] == k ? drawn[k]->own : k == leader && decides ? at_leader[free[j]] : densities[free[j]]);
        cost.density_evaluations += densities.evaluations();
        const auto value = moments.quotient(drawn[k]->value, mixture.over(as_factor<T>(members)));
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += value[c] / static_cast<A>(n);
      }
      begin = end;
    }
    moments.add_round(sum, n, cost);
  }
  return moments.result();
}

}  // namespace gmis
