#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/diagnostics/tabulated_problem.hpp"
#include "gmis/mis/groups.hpp"
#include "gmis/mis/sample_allocation.hpp"
#include "gmis/mis/scheme.hpp"

namespace gmis {

/// The largest number of multisets (R2), or of sub-multisets (N2), that are summed exactly: a
/// second of work or less at a thousand nodes.
inline constexpr double max_exact_terms = 100'000;
/// The largest N of R2 and of N2 within `max_exact_terms`, with one sample of each proposal.
inline constexpr std::size_t max_exact_r2 = 10;
inline constexpr std::size_t max_exact_n2 = 16;

/// Mean and variance of the estimate of one round.
struct ExactMoments {
  double mean;      ///< ∫ f where the scheme is unbiased; else what it converges to
  double variance;  ///< about that mean; +infinity where it leaves the range of double, never negative or NaN
};

namespace detail {

/// `first` − `second`, a second moment minus the squared means. It is 0 where rounding makes it
/// negative, and infinite where the difference is not finite: ∫ f²/φ leaves the range of double
/// where φ underflows and f is not zero.
[[nodiscard]] inline double variance_from(double first, double second) noexcept {
  const double difference = first - second;
  return std::isfinite(difference) ? std::max(difference, 0.0) : std::numeric_limits<double>::infinity();
}

/// Mean and variance of a round whose indices are given, φ being the same for all its samples:
/// `count_of(i)` samples of proposal i, n in all. `divided` is what `TabulatedProblem::divide`
/// wrote for φ.
template <class CountOf>
[[nodiscard]] double conditional_variance(const TabulatedProblem& problem, const double* divided, double n,
                                          CountOf count_of) {
  double squared_means = 0.0;
  for (std::size_t i = 0; i < problem.proposal_count(); ++i) {
    const double count = count_of(i);
    if (count == 0.0) continue;
    const double mean = problem.mean_under(i, divided);
    squared_means += count * mean * mean;
  }
  return variance_from(problem.squared_over(divided) / n, squared_means / (n * n));
}

/// Probabilities P of the counts 0 … n, where `ratio(c)` = P(c + 1)/P(c) does not rise with c.
/// They are computed relative to the most probable count, so that none overflows.
template <class Ratio>
[[nodiscard]] std::vector<double> count_probabilities(std::size_t n, Ratio ratio) {
  std::vector<double> probabilities(n + 1);
  std::size_t mode = 0;
  while (mode < n && ratio(mode) > 1.0) ++mode;
  double sum = probabilities[mode] = 1.0;
  for (std::size_t c = mode; c < n; ++c) sum += probabilities[c + 1] = probabilities[c] * ratio(c);
  for (std::size_t c = mode; c > 0; --c) sum += probabilities[c - 1] = probabilities[c] / ratio(c - 1);
  for (double& probability : probabilities) probability /= sum;
  return probabilities;
}

/// Sums over all multisets of n indices drawn with probabilities α_i, proposal by proposal; the
/// densities of a common beginning are added up once. Where m samples remain for the proposals from
/// i on, the number that proposal i makes is binomial, with the probability α_i over the sum of
/// these α.
class MultisetSum {
 public:
  MultisetSum(const TabulatedProblem& problem, std::vector<double> probabilities, std::size_t samples)
      : problem_(problem),
        probabilities_(std::move(probabilities)),
        later_(problem.proposal_count()),
        samples_(samples),
        counts_(problem.proposal_count()),
        partial_((problem.proposal_count() + 1) * problem.node_count()),
        divided_(problem.node_count()) {
    for (std::size_t i = later_.size() - 1; i > 0; --i) later_[i - 1] = later_[i] + probabilities_[i];
    visit(0, samples_, 1.0);
  }
  [[nodiscard]] ExactMoments moments() const noexcept {
    return {mean_, variance_from(conditional_ + (squared_mean_ - mean_ * mean_), 0.0)};
  }

 private:
  // `probability`: that of the counts chosen so far.
  void visit(std::size_t i, std::size_t remaining, double probability) {
    const double* const base = partial_.data() + i * problem_.node_count();
    double* const sum = partial_.data() + (i + 1) * problem_.node_count();
    const auto choose = [&](std::size_t count) {
      counts_[i] = static_cast<double>(count);
      problem_.add_density(i, counts_[i], base, sum);
    };
    if (i + 1 == counts_.size()) {
      choose(remaining);
      add(sum, probability);
      return;
    }
    const double odds = probabilities_[i] / later_[i];
    const std::vector<double> binomial = count_probabilities(remaining, [&](std::size_t c) {
      return static_cast<double>(remaining - c) / static_cast<double>(c + 1) * odds;
    });
    for (std::size_t count = 0; count <= remaining; ++count) {
      const double joint = probability * binomial[count];
      if (joint == 0.0) continue;
      choose(count);
      visit(i + 1, remaining - count, joint);
    }
  }
  void add(const double* density_sum, double probability) {
    const double n = static_cast<double>(samples_);
    problem_.divide(n, density_sum, divided_.data());
    const double mean = problem_.covered_integral(density_sum);
    conditional_ +=
        probability * conditional_variance(problem_, divided_.data(), n, [&](auto i) { return counts_[i]; });
    mean_ += probability * mean;
    squared_mean_ += probability * mean * mean;
  }

  const TabulatedProblem& problem_;
  std::vector<double> probabilities_;
  std::vector<double> later_;  // α_{i+1} + α_{i+2} + …
  std::size_t samples_;
  std::vector<double> counts_;
  std::vector<double> partial_;
  std::vector<double> divided_;
  double conditional_ = 0.0;
  double mean_ = 0.0;
  double squared_mean_ = 0.0;
};

/// Sums over all non-empty multisets of proposals that are still undrawn, c_i ≤ n_i of proposal i.
/// A sample at a uniform place in the order of n = Σ n_i meets all sizes r equally often, and a
/// multiset of size r with the probability Π binomial(n_i, c_i)/binomial(n, r).
///
/// With the empty multiset as one more size this is Pólya's urn: when c of m samples have been
/// included, c_i is beta-binomial with the parameters n_i, 1 + c and 1 + m − c.
class SubsetSum {
 public:
  SubsetSum(const TabulatedProblem& problem, std::vector<std::uint32_t> counts)
      : problem_(problem), counts_(std::move(counts)), divided_(problem.node_count()) {
    for (const std::uint32_t count : counts_) samples_ += count;
    partial_.resize((samples_ + 1) * problem.node_count());
    const double n = static_cast<double>(samples_);
    visit(0, 0, 0, (n + 1.0) / n);  // without the empty multiset
  }
  [[nodiscard]] double mean() const noexcept { return mean_; }
  /// (1/n) Σ_r E ∫ f²/p_S.
  [[nodiscard]] double second_moment() const noexcept { return second_moment_; }

 private:
  // Level `size` of the partial sums holds the densities of the `size` slots included so far, of
  // the `slots` that the proposals before i have.
  void visit(std::size_t i, std::size_t slots, std::size_t size, double probability) {
    if (i == counts_.size()) {
      if (size > 0) add(size, probability);
      return;
    }
    const std::size_t n = counts_[i];
    const double included = static_cast<double>(size), left_out = static_cast<double>(slots - size);
    const std::vector<double> beta_binomial = count_probabilities(n, [&](std::size_t c) {
      const double in = static_cast<double>(c), out = static_cast<double>(n - c);
      return out / (out + left_out) * ((in + 1.0 + included) / (in + 1.0));
    });
    const double* const base = partial_.data() + size * problem_.node_count();
    for (std::size_t count = 0; count <= n; ++count) {
      const double joint = probability * beta_binomial[count];
      if (joint == 0.0) continue;
      if (count > 0)
        problem_.add_density(i, static_cast<double>(count), base,
                             partial_.data() + (size + count) * problem_.node_count());
      visit(i + 1, slots + n, size + count, joint);
    }
  }
  void add(std::size_t size, double probability) {
    const double* const density_sum = partial_.data() + size * problem_.node_count();
    problem_.divide(static_cast<double>(size), density_sum, divided_.data());
    second_moment_ += probability * problem_.squared_over(divided_.data());
    mean_ += probability * problem_.covered_integral(density_sum);
  }

  const TabulatedProblem& problem_;
  std::vector<std::uint32_t> counts_;
  std::size_t samples_ = 0;
  std::vector<double> partial_;
  std::vector<double> divided_;
  double mean_ = 0.0;
  double second_moment_ = 0.0;
};

/// Mean and variance of one round of n = Σ n_i samples: R1, R2 and R3 draw proposal i with the
/// probability w_i/`weight_sum`, N1, N2 and N3 give it n_i = `counts[i]`.
[[nodiscard]] inline ExactMoments moments_of_round(Scheme scheme, const TabulatedProblem& problem,
                                                   const std::vector<double>& weights, double weight_sum,
                                                   const std::vector<std::uint32_t>& counts) {
  const std::size_t proposals = problem.proposal_count();
  std::size_t samples = 0;
  for (const std::uint32_t count : counts) samples += count;
  const double n = static_cast<double>(samples);
  std::vector<double> shares = weights, divided(problem.node_count());
  for (double& share : shares) share /= weight_sum;
  switch (scheme) {
    case Scheme::R1:
    case Scheme::N1: {  // (1/n) (Σ α_i ∫ f²/q_i − I²), or (1/n²) Σ n_i (∫ f²/q_i − I_i²)
      double second_moment = 0.0, mean = 0.0, squared_means = 0.0;
      for (std::size_t i = 0; i < proposals; ++i) {
        if (weights[i] == 0.0) continue;
        problem.divide(1.0, problem.densities(i), divided.data());
        const double covered = problem.covered_integral(problem.densities(i));
        second_moment += weights[i] * problem.squared_over(divided.data()) / weight_sum;
        mean += weights[i] * covered / weight_sum;
        squared_means += weights[i] * covered * covered / weight_sum;
      }
      return {mean, variance_from(second_moment / n, (scheme == Scheme::R1 ? mean * mean : squared_means) / n)};
    }
    case Scheme::R2: {
      double terms = 1.0;  // binomial(n + N − 1, n)
      for (std::size_t i = 1; i <= samples; ++i)
        terms *= static_cast<double>(proposals - 1 + i) / static_cast<double>(i);
      require_argument(
          terms <= max_exact_terms,
          "too many proposals and samples for an exact R2: with one sample of each, use averaged_variance");
      return MultisetSum(problem, shares, samples).moments();
    }
    case Scheme::N2: {
      double terms = 1.0;
      for (std::size_t i = 0; i < proposals; ++i) {
        terms *= counts[i] + 1.0;
        require_argument(counts[i] == 0 || problem.covers(problem.densities(i)),
                         "the exact variance of N2 needs full support");
      }
      require_argument(
          terms <= max_exact_terms,
          "too many proposals and samples for an exact N2: with one sample of each, use averaged_variance");
      // f(x_n)/p_n − I is a martingale difference: the draws are uncorrelated, and n I²/n² is
      // subtracted. The printed form leaves out a part of the noise, see docs/paper-corrections.md
      // [Elvira, corrected].
      const SubsetSum subsets(problem, counts);
      return {subsets.mean(), variance_from(subsets.second_moment() / n, subsets.mean() * subsets.mean() / n)};
    }
    case Scheme::R3:
    case Scheme::N3:
      break;
  }
  const std::vector<double> psi = mixture_of(shares, problem);
  problem.divide(1.0, psi.data(), divided.data());
  const double mean = problem.covered_integral(psi.data());
  if (scheme == Scheme::R3) return {mean, variance_from(problem.squared_over(divided.data()) / n, mean * mean / n)};
  return {mean, conditional_variance(problem, divided.data(), n, [&](std::size_t i) { return counts[i]; })};
}

}  // namespace detail

/// Mean and variance of one round of N samples under `scheme` (R rounds divide the variance by R),
/// with one sample of each; the overload with a `SampleAllocation` is for other counts.
/// Holds for partial support too, except that the variance of N2 needs full support (its draws are
/// correlated otherwise).
///
/// Throws std::invalid_argument for R2 with N > max_exact_r2, N2 with N > max_exact_n2, and N2 with
/// partial support.
[[nodiscard]] inline ExactMoments exact_moments(Scheme scheme, const TabulatedProblem& problem) {
  require_enumerator(scheme);
  const std::size_t n = problem.proposal_count();
  return detail::moments_of_round(scheme, problem, std::vector<double>(n, 1.0), static_cast<double>(n),
                                  std::vector<std::uint32_t>(n, 1));
}

/// The mean that `scheme` converges to: ∫ f when the proposals cover f as the scheme needs, else
/// less. Also for N2 with partial support. Throws std::invalid_argument as `exact_moments` does for
/// its N.
[[nodiscard]] inline double exact_mean(Scheme scheme, const TabulatedProblem& problem) {
  if (scheme != Scheme::N2) return exact_moments(scheme, problem).mean;
  require_argument(problem.proposal_count() <= max_exact_n2, "too many proposals for an exact N2");
  return detail::SubsetSum(problem, std::vector<std::uint32_t>(problem.proposal_count(), 1)).mean();
}

/// The variance of one round. Throws as `exact_moments` does.
[[nodiscard]] inline double exact_variance(Scheme scheme, const TabulatedProblem& problem) {
  return exact_moments(scheme, problem).variance;
}

/// Mean and variance of one round under `scheme` with a sample allocation: n = Σ n_i samples, drawn
/// with the probabilities α_i by R1, R2 and R3, n_i of proposal i by N1, N2 and N3. Holds for
/// partial support too, except for N2.
///
/// Throws std::invalid_argument for an allocation that does not fit, for R2 and N2 with more than
/// `max_exact_terms` terms, and for N2 where a proposal that has samples does not cover f.
template <std::floating_point T, std::size_t Capacity>
[[nodiscard]] ExactMoments exact_moments(Scheme scheme, const SampleAllocation<T, Capacity>& allocation,
                                         const TabulatedProblem& problem) {
  const Selection selection = cheapest_pair(scheme).selection;
  const std::size_t proposals = problem.proposal_count();
  allocation.require_fits(proposals, selection);
  const double n = static_cast<double>(allocation.sample_count(proposals));
  // α_i of S1, n_i/n of S2 and S3.
  std::vector<double> shares(proposals);
  std::vector<std::uint32_t> counts(proposals);
  double sum = 0.0;
  for (std::size_t i = 0; i < proposals; ++i) {
    counts[i] = allocation.count(i);
    shares[i] = selection == Selection::S1 ? static_cast<double>(allocation.weight(i)) : counts[i] / n;
    sum += shares[i];
  }
  for (double& share : shares) share /= sum;
  return detail::moments_of_round(scheme, problem, shares, 1.0, counts);
}

/// True when the mixture of every group covers f, as the partial deterministic mixture needs it.
template <std::size_t Capacity>
[[nodiscard]] bool has_full_support(const Groups<Capacity>& groups, const TabulatedProblem& problem) {
  groups.require_fits(problem.proposal_count());
  std::vector<double> sum(problem.node_count());
  for (std::size_t group = 0; group < groups.size(); ++group) {
    std::fill(sum.begin(), sum.end(), 0.0);
    for (const std::uint32_t i : groups.members(group)) problem.add_density(i, 1.0, sum.data(), sum.data());
    if (!problem.covers(sum.data())) return false;
  }
  return true;
}

/// Mean and variance of one round of the partial deterministic mixture:
/// (1/N²) Σ_g (P_g ∫ f²/ψ_g − Σ_{i in g} (∫ f q_i/ψ_g)²). Holds for partial support too.
template <std::size_t Capacity>
[[nodiscard]] ExactMoments exact_moments(const Groups<Capacity>& groups, const TabulatedProblem& problem) {
  groups.require_fits(problem.proposal_count());
  const double n = static_cast<double>(problem.proposal_count());
  std::vector<double> sum(problem.node_count()), divided(problem.node_count()), is_member(problem.proposal_count());
  ExactMoments moments{0.0, 0.0};
  for (std::size_t group = 0; group < groups.size(); ++group) {
    const double size = static_cast<double>(groups.members(group).size());
    std::fill(sum.begin(), sum.end(), 0.0);
    std::fill(is_member.begin(), is_member.end(), 0.0);
    for (const std::uint32_t i : groups.members(group)) {
      problem.add_density(i, 1.0, sum.data(), sum.data());
      is_member[i] = 1.0;
    }
    problem.divide(size, sum.data(), divided.data());
    const double share = size / n;
    moments.mean += share * problem.covered_integral(sum.data());
    moments.variance += share * share * detail::conditional_variance(problem, divided.data(), size, [&](std::size_t i) {
                          return is_member[i];
                        });
  }
  return moments;
}

}  // namespace gmis
