#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/partial_mixture.hpp"

/// \file
/// Rounds of the library over whole arrays: samples first, then the integrand at all of them in one
/// call, then the sums.

namespace gmis::python {

/// The partial deterministic mixture in groups of this size.
struct GroupsOf {
  std::size_t size;
};
/// The kind of a round: a pair of selection and weighting, groups, or multi-sample with a
/// heuristic.
using Method = std::variant<SelectionAndWeighting, GroupsOf, Balance, Power, Cutoff, Maximum>;
/// One sample of each proposal, or any numbers.
using AnyAllocation = std::variant<EqualAllocation, SampleAllocation<double>>;

/// The samples of consecutive rounds that can be used, with what each is divided by.
template <class X>
struct UsedSamples {
  std::vector<X> x;
  std::vector<double> denominators;
  std::vector<std::uint32_t> in_round;  ///< how many samples of each round can be used
  RoundCounts counts;                   ///< over all rounds
};

/// Draws rounds and evaluates their densities; the integrand is left for later. The same samples
/// and denominators as in `estimate` with this source.
template <class Set, class AllocationType>
[[nodiscard]] UsedSamples<typename Set::Value> draw_rounds(const Method& method, const Set& set,
                                                           const AllocationType& allocation, std::uint64_t rounds,
                                                           Philox& source) {
  UsedSamples<typename Set::Value> used;
  const std::size_t sample_count = allocation.sample_count(set.size());
  used.x.reserve(rounds * sample_count);
  used.denominators.reserve(rounds * sample_count);
  used.in_round.reserve(rounds);
  Workspace<typename Set::Density, dynamic_capacity> workspace;
  const auto run = [&](auto&& run_round) {
    for (std::uint64_t round = 0; round < rounds; ++round) {
      const std::size_t before = used.x.size();
      run_round([&](const typename Set::Value& x, double denominator, std::size_t) {
        used.x.push_back(x);
        used.denominators.push_back(denominator);
      });
      used.in_round.push_back(static_cast<std::uint32_t>(used.x.size() - before));
    }
  };
  const auto with_method = [&]<class M>(const M& chosen) {
    const auto add = [&](const RoundCounts& counts) {
      used.counts.density_evaluations += counts.density_evaluations;
      used.counts.zero_density += counts.zero_density;
      used.counts.non_finite_density += counts.non_finite_density;
    };
    if constexpr (std::is_same_v<M, SelectionAndWeighting>) {
      dispatch(chosen.selection, chosen.weighting, [&](auto selection, auto weighting) {
        allocation.require_fits(set.size(), chosen.selection);
        workspace.prepare(set.size(), sample_count);
        run([&](auto&& visit) {
          sample_checked_round<decltype(selection)::value, decltype(weighting)::value>(set, allocation, source,
                                                                                       workspace, used.counts, visit);
        });
      });
    } else if constexpr (std::is_same_v<M, GroupsOf>) {
      require_argument(std::is_same_v<AllocationType, EqualAllocation>, "groups take one sample of each proposal");
      const Groups<> groups(set.size(), chosen.size);
      run([&](auto&& visit) { add(sample_partial_round(set, groups, source, workspace, visit)); });
    } else {
      require_heuristic(chosen);
      run([&](auto&& visit) { add(sample_weighted_round(chosen, set, allocation, source, workspace, visit)); });
    }
  };
  std::visit(with_method, method);
  return used;
}

/// Adds the rounds of `used` to `accumulator`, as `estimate` does. `value(k)`: f at sample k.
template <class X, class Value>
void add_rounds(EstimateAccumulator<double>& accumulator, const UsedSamples<X>& used, std::size_t sample_count,
                const Value& value) {
  std::size_t next = 0, round = 0;
  accumulator.add_rounds(value, sample_count, used.in_round.size(), [&](RoundCounts& counts, auto&& visit) {
    if (round == 0) counts = used.counts;
    for (const std::size_t end = next + used.in_round[round]; next < end; ++next)
      visit(next, used.denominators[next], 0);
    ++round;
  });
}

/// The estimate of each round of `used`, without the checks of an accumulator.
template <class X, class Value>
void write_rounds(const UsedSamples<X>& used, std::size_t sample_count, const Value& value, std::span<double> out) {
  std::size_t next = 0;
  for (std::size_t round = 0; round < used.in_round.size(); ++round) {
    double sum = 0.0;
    for (const std::size_t end = next + used.in_round[round]; next < end; ++next)
      sum += value(next) / used.denominators[next];
    out[round] = sum / static_cast<double>(sample_count);
  }
}

/// Samples that were drawn in arrays, proposal by proposal, and are called by their numbers: a set
/// of proposals whose rounds draw them in order.
class DrawnSamples {
 public:
  using Value = std::uint32_t;
  using Density = double;

  /// `counts`: samples of each proposal. The densities are all 0.
  explicit DrawnSamples(std::vector<std::size_t> counts) : counts_(std::move(counts)) {
    for (const std::size_t count : counts_) {
      next_.push_back(static_cast<Value>(total_));
      total_ += count;
    }
    densities_.resize(counts_.size() * total_);
  }

  [[nodiscard]] std::size_t size() const noexcept { return counts_.size(); }
  /// The number of the next sample of proposal i.
  [[nodiscard]] Value sample(std::size_t i, UniformSource auto&) const noexcept { return next_[i]++; }
  [[nodiscard]] double pdf(std::size_t i, Value sample) const noexcept { return densities_[i * total_ + sample]; }

  /// Samples of proposal i.
  [[nodiscard]] std::size_t count(std::size_t i) const noexcept { return counts_[i]; }
  /// Samples of all proposals.
  [[nodiscard]] std::size_t total() const noexcept { return total_; }
  /// The densities of proposal i at all samples, to be filled in.
  [[nodiscard]] std::span<double> densities(std::size_t i) noexcept {
    return std::span(densities_).subspan(i * total_, total_);
  }

 private:
  std::vector<std::size_t> counts_;
  std::size_t total_ = 0;
  mutable std::vector<Value> next_;
  std::vector<double> densities_;
};

/// How the proposals of a round are chosen.
[[nodiscard]] inline Selection selection_of(const Method& method) {
  const auto* const pair = std::get_if<SelectionAndWeighting>(&method);
  return pair != nullptr ? pair->selection : Selection::S3;
}

/// How many samples of each proposal `rounds` rounds from this state of the source will draw. The
/// source must serve the choice of proposals alone.
template <class AllocationType>
[[nodiscard]] std::vector<std::size_t> samples_of_rounds(const Method& method, const AllocationType& allocation,
                                                         std::size_t proposals, std::uint64_t rounds, Philox source) {
  std::vector<std::size_t> counts(proposals);
  const std::size_t sample_count = allocation.sample_count(proposals);
  if (selection_of(method) == Selection::S1) {
    for (std::uint64_t i = 0; i < rounds * sample_count; ++i) ++counts[allocation.draw(source, proposals)];
  } else {
    for (std::size_t i = 0; i < proposals; ++i) counts[i] = rounds * allocation.count(i);
  }
  return counts;
}

/// True when a sample is divided by the density of its own proposal, and needs no other.
[[nodiscard]] inline bool needs_own_density_alone(const Method& method) {
  const auto* const pair = std::get_if<SelectionAndWeighting>(&method);
  return pair != nullptr && (*pair == cheapest_pair(Scheme::R1) || *pair == cheapest_pair(Scheme::N1));
}

}  // namespace gmis::python
