#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/mis/diagnostics/enumeration.hpp"
#include "gmis/mis/methods/weight_heuristic.hpp"
#include "gmis/mis/partial_mixture.hpp"
#include "gmis/mis/round.hpp"

namespace gmis {

/// SplitMix64: a cheap source of random words, which adds little to the time of a round.
class ComparisonSource {
 public:
  using result_type = std::uint64_t;
  /// Starts from the state `seed`.
  explicit constexpr ComparisonSource(std::uint64_t seed) noexcept : state_(seed) {}
  [[nodiscard]] static constexpr result_type min() noexcept { return 0; }
  [[nodiscard]] static constexpr result_type max() noexcept { return std::numeric_limits<result_type>::max(); }
  GMIS_ALWAYS_INLINE constexpr result_type operator()() noexcept {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }

 private:
  std::uint64_t state_;
};

/// A result that a round may return in place of a number: its estimate, and how many densities it
/// evaluated.
struct RoundValue {
  double value;                ///< estimate of one round, or the sum of several
  double density_evaluations;  ///< densities evaluated for it; NaN where a round does not say
};

/// A round: `round(source)` returns the estimate of one round, as a number or a `RoundValue`.
template <class R>
concept ComparableRound = requires(R& round, ComparisonSource& source) {
  requires std::convertible_to < std::invoke_result_t<R&, ComparisonSource&>,
  double > || std::same_as<std::invoke_result_t<R&, ComparisonSource&>, RoundValue>;
};

/// One of the estimators that `compare` puts side by side: a name, its rounds, and its exact
/// variance where there is one.
struct Contender {
  /// Runs rounds into `values`, or only adds them up where that is empty: returns the sum, and the
  /// densities evaluated.
  using Run = std::function<RoundValue(std::uint64_t rounds, std::span<double> values, ComparisonSource& source)>;

  std::string name;  ///< in the first column
  Run run;           ///< all rounds of a slice in one call, so that no call through a pointer is in the time of a round
  std::optional<double> exact_variance;  ///< of one round; without it the variance is measured
  double half_width = 0.0;  ///< of the 99 % interval of `exact_variance`, where that is itself an average over draws
  std::optional<double> exact_mean;  ///< of one round, where weights may not sum to one

  /// Your own round. `round` is any function of a source: with a `source` parameter of type
  /// `auto&`, or `ComparisonSource&`.
  template <ComparableRound Round>
  Contender(std::string its_name, Round round, std::optional<double> its_exact_variance = {})
      : name(std::move(its_name)), run(in_a_loop(std::move(round))), exact_variance(its_exact_variance) {}

  /// Your own loop over rounds.
  Contender(std::string its_name, Run its_run, std::optional<double> its_exact_variance = {})
      : name(std::move(its_name)), run(std::move(its_run)), exact_variance(its_exact_variance) {}

  /// A loop around a round.
  template <ComparableRound Round>
  [[nodiscard]] static Run in_a_loop(Round round) {
    return [round](std::uint64_t rounds, std::span<double> values, ComparisonSource& source) mutable {
      RoundValue sum{0.0, 0.0};
      for (std::uint64_t i = 0; i < rounds; ++i) {
        double value = 0.0;
        if constexpr (std::same_as<std::invoke_result_t<Round&, ComparisonSource&>, RoundValue>) {
          const RoundValue result = round(source);
          value = result.value;
          sum.density_evaluations += result.density_evaluations;
        } else {
          value = static_cast<double>(round(source));
          sum.density_evaluations = std::numeric_limits<double>::quiet_NaN();
        }
        if (i < values.size()) values[i] = value;
        sum.value += value;
      }
      return sum;
    };
  }
};

/// An integral, its proposals and a quadrature rule: the problem on which `compare` compares
/// contenders. Makes contenders from the methods of the library, with their exact variances where
/// there are any. f has one channel. Copies share what they hold.
template <class Integrand, class P>
class ComparedProblem {
 public:
  /// Throws as `TabulatedProblem` does.
  template <NodeRange Nodes>
  ComparedProblem(std::string name, Integrand f, P proposals, const Nodes& nodes)
      : shared_(std::make_shared<const Shared>(std::move(name), std::move(f), std::move(proposals), nodes)) {}

  /// The name of the problem, as it was given.
  [[nodiscard]] const std::string& name() const noexcept { return shared_->name; }
  /// The problem at the nodes of the rule.
  [[nodiscard]] const TabulatedProblem& table() const noexcept { return shared_->table; }
  /// The integral of f, by the quadrature rule.
  [[nodiscard]] double integral() const noexcept { return shared_->table.integral(); }

  /// One of the six schemes, run as its cheapest pair. R2 and N2 of many proposals have their
  /// variance averaged over 512 draws of the indices.
  [[nodiscard]] Contender scheme(Scheme scheme) const {
    const SelectionAndWeighting both = cheapest_pair(scheme);
    return pair(both.selection, both.weighting, std::string(name_of(scheme)));
  }
  /// All six.
  [[nodiscard]] std::vector<Contender> schemes() const {
    std::vector<Contender> all;
    for (const Scheme each : all_schemes) all.push_back(scheme(each));
    return all;
  }
  /// One of the fifteen pairs.
  [[nodiscard]] Contender pair(Selection selection, Weighting weighting, std::string name = {}) const {
    if (name.empty()) {
      name += name_of(selection);
      name += name_of(weighting);
    }
    return dispatch(selection, weighting, [&](auto fixed_selection, auto fixed_weighting) {
      constexpr Selection s = decltype(fixed_selection)::value;
      constexpr Weighting w = decltype(fixed_weighting)::value;
      Contender contender = with_rounds(std::move(name), [](const auto& set, auto& workspace, auto& source, auto& add) {
        return sample_round<s, w>(set, EqualAllocation{}, source, workspace, add);
      });
      set_variance(contender, scheme_of(s, w));
      return contender;
    });
  }
  /// The partial deterministic mixture in groups of this size.
  [[nodiscard]] Contender groups(std::size_t group_size) const {
    const Groups<> partition(table().proposal_count(), group_size);
    std::string name("groups of ");
    name += std::to_string(group_size);
    Contender contender =
        with_rounds(std::move(name), [partition](const auto& set, auto& workspace, auto& source, auto& add) {
          return sample_partial_round(set, partition, source, workspace, add);
        });
    if (has_full_support(partition, table())) contender.exact_variance = exact_moments(partition, table()).variance;
    return contender;
  }
  /// Your own selection under one of the five weightings. Its variance is exact for up to
  /// 100,000 outcomes.
  template <IndexSelection S>
  [[nodiscard]] Contender selection(std::string name, S selection, Weighting weighting) const {
    const std::size_t n = table().proposal_count();
    const double samples = static_cast<double>(selection.sample_count());
    Contender contender = with_rounds(
        std::move(name),
        [rounds = SelectedRounds<S>(selection, weighting, n)](const auto& set, auto& workspace, auto& source,
                                                              auto& add) mutable {
          return rounds.sample(set, source, workspace, add);
        },
        samples);
    if (std::pow(static_cast<double>(n), samples) <= 100'000.0)
      contender.exact_variance = exact_moments(selection, weighting, table()).variance;
    return contender;
  }
  /// Your own weights (a `WeightHeuristic`) with sample counts.
  template <WeightHeuristic H>
  [[nodiscard]] Contender weights(std::string name, H heuristic, std::vector<std::uint32_t> counts) const {
    const std::size_t n = table().proposal_count();
    (void)checked_total(counts, n);
    require_fits(heuristic, counts);
    const ExactMoments moments = exact_moments_with_weights(heuristic, counts, table());
    const auto shared = shared_;
    Contender contender(std::move(name), [shared, heuristic = std::move(heuristic), counts = std::move(counts),
                                          densities = std::vector<double>(n), out = std::vector<double>(n),
                                          workspace = WorkspaceOf()](ComparisonSource& source) mutable {
      const auto& set = as_proposal_set<ComparisonSource>(shared->proposals);
      double sum = 0.0;
      const RoundCounts cost = sample_counted_round(
          set, counts, source, workspace, [&](const auto& x, auto psi, auto relative, std::size_t index) {
            for (std::size_t k = 0; k < densities.size(); ++k) densities[k] = static_cast<double>(relative[k]);
            heuristic.weights(counts, densities, out);
            if (out[index] > 0.0 || out[index] < 0.0)
              sum += out[index] / (counts[index] * densities[index]) * quotient(shared->f(x), psi);
          });
      return RoundValue{sum, static_cast<double>(cost.density_evaluations)};
    });
    contender.exact_variance = moments.variance;
    contender.exact_mean = moments.mean;
    return contender;
  }

 private:
  struct Shared {
    template <class Nodes>
    Shared(std::string its_name, Integrand its_f, P its_proposals, const Nodes& nodes)
        : name(std::move(its_name)),
          f(std::move(its_f)),
          proposals(std::move(its_proposals)),
          table(f, proposals, nodes) {}
    std::string name;
    Integrand f;
    P proposals;
    TabulatedProblem table;
  };
  using Set = std::remove_cvref_t<decltype(as_proposal_set<ComparisonSource>(std::declval<const Shared&>().proposals))>;
  using WorkspaceOf = Workspace<typename Set::Density, dynamic_capacity>;

  template <class F, class D>
  [[nodiscard]] GMIS_ALWAYS_INLINE static double quotient(const F& value, D denominator) {
    return ratio<double>(SpectrumTraits<SummedAs<F>>::channel(static_cast<SummedAs<F>>(value), 0), denominator);
  }

  template <class Round>
  [[nodiscard]] Contender with_rounds(std::string name, Round round, double samples = 0.0) const {
    if (samples == 0.0) samples = static_cast<double>(table().proposal_count());
    const auto shared = shared_;
    return Contender(std::move(name),
                     [shared, round, samples, workspace = WorkspaceOf()](ComparisonSource& source) mutable {
                       const auto& set = as_proposal_set<ComparisonSource>(shared->proposals);
                       double sum = 0.0;
                       const auto add = [&](const auto& x, auto denominator, std::size_t) {
                         sum += quotient(shared->f(x), denominator);
                       };
                       const RoundCounts counts = round(set, workspace, source, add);
                       return RoundValue{sum / samples, static_cast<double>(counts.density_evaluations)};
                     });
  }

  void set_variance(Contender& contender, Scheme scheme) const {
    const std::size_t n = table().proposal_count();
    if (needs_full_support(scheme) && !table().has_full_support()) return;
    if ((scheme == Scheme::R2 && n > max_exact_r2) || (scheme == Scheme::N2 && n > max_exact_n2)) {
      Philox source(1);
      const AveragedVariance averaged = averaged_variance(scheme, table(), 512, source);
      contender.exact_variance = averaged.value;
      contender.half_width = averaged.half_width;
    } else {
      contender.exact_variance = gmis::exact_variance(scheme, table());
    }
  }

  std::shared_ptr<const Shared> shared_;
};

}  // namespace gmis
