#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/diagnostics/exact_variance.hpp"
#include "gmis/mis/index_selection.hpp"

namespace gmis {

/// The largest number of outcomes of a selection that `exact_moments` sums over: 8^8.
inline constexpr std::size_t max_outcomes = 16'777'216;

namespace detail {

/// Sums mean and variance of a round over all outcomes of a selection.
template <IndexSelection S>
class OutcomeSum {
 public:
  OutcomeSum(const S& selection, Weighting weighting, const TabulatedProblem& problem)
      : selection_(selection),
        weighting_(weighting),
        problem_(problem),
        proposals_(problem.proposal_count()),
        samples_(selection.sample_count()),
        integral_(problem.integral()),
        next_(samples_ * proposals_) {
    if (weighting == Weighting::W3 || weighting == Weighting::W5) {
      const std::vector<double> marginals = marginal_probabilities(selection, proposals_);
      std::vector<double> coefficients(proposals_);
      for (std::size_t m = 0; m < samples_; ++m) {
        for (std::size_t i = 0; i < proposals_; ++i) {
          coefficients[i] = weighting == Weighting::W3 ? marginals[m * proposals_ + i] : 0.0;
          for (std::size_t other = 0; weighting == Weighting::W5 && other < samples_; ++other)
            coefficients[i] += marginals[other * proposals_ + i] / static_cast<double>(samples_);
        }
        by_place_.push_back(&terms_of(coefficients));
      }
    }
    if (weighting == Weighting::W2)
      for (std::size_t i = 0; i < proposals_; ++i) {
        std::vector<double> own(proposals_);
        own[i] = 1.0;
        by_place_.push_back(&terms_of(own));
      }
    visit(1.0, 0.0, 0.0);
    for (const auto& [counts, probability] : drawn_sets_) {
      std::vector<double> coefficients(counts.begin(), counts.end());
      for (double& coefficient : coefficients) coefficient /= static_cast<double>(samples_);
      const Terms& terms = terms_of(coefficients);
      double mean = 0.0, variance = 0.0;
      for (std::size_t i = 0; i < proposals_; ++i) {
        mean += counts[i] * terms.mean[i];
        if (counts[i] > 0) variance += counts[i] * terms.variance[i];
      }
      add(probability, mean, variance);
    }
  }
  [[nodiscard]] ExactMoments moments() const noexcept {
    return {integral_ + offset_, variance_from(second_, offset_ * offset_)};
  }

 private:
  /// Mean and variance of f/φ under every proposal, for one φ.
  struct Terms {
    std::vector<double> mean, variance;
  };
  const Terms& terms_of(const std::vector<double>& coefficients) {
    const auto found = terms_.find(coefficients);
    if (found != terms_.end()) return found->second;
    std::vector<double> phi(problem_.node_count());
    for (std::size_t i = 0; i < proposals_; ++i)
      if (coefficients[i] > 0.0) problem_.add_density(i, coefficients[i], phi.data(), phi.data());
    Terms terms;
    for (std::size_t i = 0; i < proposals_; ++i) {
      double mean = 0.0, mass = 0.0, variance = 0.0;
      const auto each = [&](auto use) {
        for (std::size_t node = 0; node < phi.size(); ++node) {
          const double q = problem_.weights()[node] * problem_.densities(i)[node];
          if (phi[node] > 0.0 && q > 0.0) use(q, problem_.values()[node] / phi[node]);
        }
      };
      each([&](double q, double value) {
        mass += q;
        mean += q * value;
      });
      each([&](double q, double value) { variance += q * (value - mean) * (value - mean); });
      terms.mean.push_back(mean);
      terms.variance.push_back(variance + std::max(0.0, 1.0 - mass) * mean * mean);
    }
    return terms_.emplace(coefficients, std::move(terms)).first->second;
  }

  void visit(double probability, double mean, double variance) {
    const std::size_t m = drawn_.size();
    if (m == samples_) {
      require_argument(++outcomes_ <= max_outcomes, "the selection has too many outcomes to sum over");
      if (weighting_ == Weighting::W4) {
        std::vector<std::uint32_t> counts(proposals_);
        for (const std::uint32_t i : drawn_) ++counts[i];
        drawn_sets_[counts] += probability;
      } else {
        add(probability, mean, variance);
      }
      return;
    }
    const std::span<double> next(next_.data() + m * proposals_, proposals_);
    selection_.next_probabilities(std::span<const std::uint32_t>(drawn_), next);
    require_probabilities(next);
    const Terms* terms = nullptr;
    if (weighting_ == Weighting::W1) terms = &terms_of({next.begin(), next.end()});
    if (weighting_ == Weighting::W3 || weighting_ == Weighting::W5) terms = by_place_[m];
    for (std::size_t i = 0; i < proposals_; ++i) {
      if (next[i] == 0.0) continue;
      if (weighting_ == Weighting::W2) terms = by_place_[i];
      drawn_.push_back(static_cast<std::uint32_t>(i));
      if (terms == nullptr)
        visit(probability * next[i], mean, variance);
      else
        visit(probability * next[i], mean + terms->mean[i], variance + terms->variance[i]);
      drawn_.pop_back();
    }
  }
  // About ∫ f, so that little cancels.
  void add(double probability, double mean, double variance) {
    const double n = static_cast<double>(samples_);
    const double offset = mean / n - integral_;
    offset_ += probability * offset;
    second_ += probability * (variance / (n * n) + offset * offset);
  }

  const S& selection_;
  Weighting weighting_;
  const TabulatedProblem& problem_;
  std::size_t proposals_, samples_;
  double integral_;
  std::vector<double> next_;
  std::map<std::vector<double>, Terms> terms_;
  std::vector<const Terms*> by_place_;
  std::map<std::vector<std::uint32_t>, double> drawn_sets_;
  std::vector<std::uint32_t> drawn_;
  std::size_t outcomes_ = 0;
  double offset_ = 0.0, second_ = 0.0;
};

}  // namespace detail

/// Mean and variance of one round of your own selection under any of the five weightings, by a sum
/// over all outcomes of the selection. Holds for partial support too. Eight samples drawn from
/// eight proposals with replacement take a few seconds. Throws std::invalid_argument for more than
/// `max_outcomes` outcomes or `max_summed_samples` samples, and as `marginal_probabilities` and
/// `require_probabilities` do.
template <IndexSelection S>
[[nodiscard]] ExactMoments exact_moments(const S& selection, Weighting weighting, const TabulatedProblem& problem) {
  require_enumerator(Selection::S1, weighting);
  require_argument(selection.sample_count() > 0, "a selection needs at least one sample");
  require_argument(selection.sample_count() <= max_summed_samples,
                   "the selection has too many samples to sum over its outcomes");
  return detail::OutcomeSum<S>(selection, weighting, problem).moments();
}

}  // namespace gmis
