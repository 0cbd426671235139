#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/round.hpp"
#include "gmis/mis/scheme.hpp"

/// \file
/// Your own selection: how the indices of a round are drawn, where S1, S2 and S3 do not
/// serve. All five weightings follow from the probabilities of the next index.

namespace gmis {

/// How the proposal of each sample of a round is chosen [Elvira, section 3: the distribution of the
/// indices j_1 … j_n]:
/// - `sample_count()`: n, the samples of a round;
/// - `next_probabilities(drawn, out)`: the probabilities of all proposals for the next sample,
///   given the indices `drawn` before it in this round. They sum to one.
template <class S>
concept IndexSelection = requires(const S& selection, std::span<const std::uint32_t> drawn, std::span<double> out) {
  { selection.sample_count() } -> std::convertible_to<std::size_t>;
  selection.next_probabilities(drawn, out);
};

/// Throws std::invalid_argument unless these are probabilities: none negative, their sum one.
inline void require_probabilities(std::span<const double> next) {
  double sum = 0.0;
  for (const double p : next) {
    require_argument(p >= 0.0, "a probability of the selection is negative or not a number");
    sum += p;
  }
  require_argument(sum > 1.0 - 1e-9 && sum < 1.0 + 1e-9, "the probabilities of the selection do not sum to one");
}

/// The largest number of samples of a round whose outcomes are summed over: the sum recurses once
/// for each sample, with some 150 bytes of stack each, 300 without optimisation, and 1,400 there
/// under AddressSanitizer.
inline constexpr std::size_t max_summed_samples = 5'000;

/// Marginal probabilities of every sample: at [m N + i] the probability that sample m is of
/// proposal i, by a sum over all prefixes j_1 … j_{m−1} of a round. Throws
/// std::invalid_argument for a selection with more than `max_summed_samples` samples or more than
/// `most_beginnings` prefixes, and for next probabilities that are negative or do not sum to one.
template <IndexSelection S>
[[nodiscard]] std::vector<double> marginal_probabilities(const S& selection, std::size_t proposal_count,
                                                         std::size_t most_beginnings = 4'000'000) {
  const std::size_t samples = selection.sample_count();
  require_argument(samples > 0 && proposal_count > 0, "a selection needs at least one sample and one proposal");
  require_argument(samples <= max_summed_samples, "the selection has too many samples to sum over its outcomes");
  std::vector<double> marginals(samples * proposal_count), next(samples * proposal_count);
  std::vector<std::uint32_t> drawn;
  std::size_t beginnings = 0;
  const auto visit = [&](const auto& self, double probability) -> void {
    const std::size_t m = drawn.size();
    if (m == samples) return;
    require_argument(++beginnings <= most_beginnings, "the selection has too many outcomes to sum over");
    const std::span<double> out(next.data() + m * proposal_count, proposal_count);
    selection.next_probabilities(std::span<const std::uint32_t>(drawn), out);
    require_probabilities(out);
    for (std::size_t i = 0; i < proposal_count; ++i) {
      if (out[i] == 0.0) continue;
      marginals[m * proposal_count + i] += probability * out[i];
      drawn.push_back(static_cast<std::uint32_t>(i));
      self(self, probability * out[i]);
      drawn.pop_back();
    }
  };
  visit(visit, 1.0);
  return marginals;
}

/// Draws rounds of your own selection under any of the five weightings: the mixture that
/// divides sample m has the coefficients P(i | j_1 … j_{m−1}) (W1), 1 for its own proposal
/// (W2), P(j_m = i) (W3), the shares of the indices that the round drew (W4), or the mean over m of
/// P(j_m = i) (W5).
template <IndexSelection S>
class SelectedRounds {
 public:
  /// Sums the marginal probabilities where W3 or W5 needs them. Throws as `marginal_probabilities`
  /// does; under the other weightings, where only the probabilities of the first sample are looked
  /// at, as `require_probabilities` does.
  SelectedRounds(S selection, Weighting weighting, std::size_t proposal_count)
      : selection_(std::move(selection)),
        weighting_(weighting),
        proposals_(proposal_count),
        samples_(selection_.sample_count()),
        coefficients_(proposal_count),
        next_(proposal_count) {
    require_enumerator(Selection::S1, weighting);
    require_argument(samples_ > 0 && proposals_ > 0, "a selection needs at least one sample and one proposal");
    if (weighting == Weighting::W3 || weighting == Weighting::W5)
      marginals_ = marginal_probabilities(selection_, proposals_);
    selection_.next_probabilities(std::span<const std::uint32_t>(), std::span<double>(next_));
    require_probabilities(next_);
    if (weighting == Weighting::W5)
      for (std::size_t i = 0; i < proposals_; ++i) {
        double mean = 0.0;
        for (std::size_t m = 0; m < samples_; ++m) mean += marginals_[m * proposals_ + i];
        for (std::size_t m = 0; m < samples_; ++m)
          marginals_[m * proposals_ + i] = mean / static_cast<double>(samples_);
      }
  }

  /// n.
  [[nodiscard]] std::size_t sample_count() const noexcept { return samples_; }

  /// One round: calls `visit(x, denominator, index)`; (1/n) Σ f/denominator estimates ∫ f.
  /// Throws std::invalid_argument for a set of another size.
  template <class Set, UniformSource Source, class Visit>
  requires ProposalSet<Set, Source> RoundCounts sample(const Set& set, Source& source,
                                                       Workspace<typename Set::Density, dynamic_capacity>& workspace,
                                                       Visit&& visit) {
    using T = typename Set::Density;
    require_argument(set.size() == proposals_, "the selection is for another number of proposals");
    workspace.prepare(proposals_, samples_);
    RoundCounts counts;
    drawn_.clear();
    if (weighting_ == Weighting::W4) {
      std::fill(coefficients_.begin(), coefficients_.end(), 0.0);
      for (std::size_t m = 0; m < samples_; ++m) coefficients_[draw(source)] += 1.0 / static_cast<double>(samples_);
    }
    for (std::size_t m = 0; m < samples_; ++m) {
      const std::size_t index = weighting_ == Weighting::W4 ? drawn_[m] : draw(source);
      std::span<const double> mixture(coefficients_);
      if (weighting_ == Weighting::W1) mixture = next_;
      if (weighting_ == Weighting::W3 || weighting_ == Weighting::W5)
        mixture = std::span<const double>(marginals_).subspan(m * proposals_, proposals_);
      if (weighting_ == Weighting::W2) {
        std::fill(coefficients_.begin(), coefficients_.end(), 0.0);
        coefficients_[index] = 1.0;
      }
      visit_sample<false>(
          set, index, source, workspace, counts,
          [&](DensitiesAt<Set>& densities) {
            MixtureSum<T, is_log_set<Set>> sum;
            for (std::size_t i = 0; i < proposals_; ++i)
              if (mixture[i] > 0.0) {
                sum.add(densities.keep(i), static_cast<T>(mixture[i]));
                densities.count(1);
              }
            return OwnAndDenominator<Set>{DensitiesAt<Set>::as_denominator(densities.kept(index)), sum.over(T(1))};
          },
          [] {}, visit);
    }
    return counts;
  }

 private:
  [[nodiscard]] std::size_t draw(UniformSource auto& source) {
    selection_.next_probabilities(std::span<const std::uint32_t>(drawn_), std::span<double>(next_));
    double u = uniform<double>(source);
    std::size_t index = 0, last = 0;
    for (; index < proposals_; ++index) {
      if (next_[index] == 0.0) continue;
      last = index;
      if (u < next_[index]) break;
      u -= next_[index];
    }
    drawn_.push_back(static_cast<std::uint32_t>(last));  // rounding never chooses a probability of 0
    return last;
  }

  S selection_;
  Weighting weighting_;
  std::size_t proposals_, samples_;
  std::vector<double> coefficients_, next_, marginals_;
  std::vector<std::uint32_t> drawn_;
};

}  // namespace gmis
