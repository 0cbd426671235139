#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <iterator>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/arguments.hpp"
#include "gmis/mis/diagnostics/quadrature.hpp"
#include "gmis/mis/proposal_set.hpp"

namespace gmis {

namespace detail {
/// Channel c of a value of f, as a double.
template <class F>
[[nodiscard]] double channel_value(const F& value, int c) {
  return static_cast<double>(SpectrumTraits<F>::channel(value, c));
}
template <std::floating_point T>
[[nodiscard]] double channel_value(const LogValue<T>& value, int) {
  return static_cast<double>(value.sign * std::exp(value.log_magnitude));
}
}  // namespace detail

/// A problem tabulated at the points of a quadrature rule: on the line, or in any space that a rule
/// covers.
class TabulatedProblem {
 public:
  /// `f(x)` and the densities of `proposals` at every node, a range of `NodeAt`. f has one channel;
  /// `tabulate_channels` is for more. Throws std::invalid_argument when there are no nodes or no
  /// proposals, a value or a weight is not finite, or a density is negative.
  template <class Integrand, class P, NodeRange Nodes>
  TabulatedProblem(Integrand&& f, const P& proposals, const Nodes& nodes) {
    if constexpr (detail::explain_arguments<Integrand, P, Philox>()) {
      using F = SummandOf<Integrand, typename std::remove_cvref_t<decltype(as_proposal_set(proposals))>::Value>;
      static_assert(
          SpectrumTraits<F>::channel_count == 1,
          "a TabulatedProblem is for an integrand with one channel: use gmis::tabulate_channels(f, proposals, "
          "nodes), one problem for each channel");
      if constexpr (SpectrumTraits<F>::channel_count == 1) tabulate(f, proposals, nodes, 0);
    }
  }

  /// From values at nodes that are given: `f` and the `weights` of the nodes, and the densities,
  /// all of proposal 0 first. Throws std::invalid_argument when there are none, the sizes do not
  /// fit (densities.size() is a multiple of f.size()), a value is not finite, or a density is
  /// negative.
  TabulatedProblem(std::vector<double> f, std::span<const double> weights, std::vector<double> densities)
      : node_count_(f.size()),
        weighted_f_(f.size()),
        f_(std::move(f)),
        densities_(std::move(densities)),
        weights_(weights.begin(), weights.end()) {
    require_argument(node_count_ > 0 && !densities_.empty() && densities_.size() % node_count_ == 0,
                     "the densities must be given at every node, for at least one proposal");
    require_argument(weights.size() == node_count_, "one weight is needed for each node");
    proposal_count_ = densities_.size() / node_count_;
    for (std::size_t node = 0; node < node_count_; ++node) {
      weighted_f_[node] = weights[node] * f_[node];
      require_argument(std::isfinite(weights[node]) && std::isfinite(f_[node]),
                       "the integrand, or a weight, is not finite at a node");
    }
    for (const double density : densities_) require_density(density);
  }

  [[nodiscard]] std::size_t proposal_count() const noexcept { return proposal_count_; }
  /// Nodes of the quadrature.
  [[nodiscard]] std::size_t node_count() const noexcept { return node_count_; }
  /// q_i at all nodes, held by this object.
  [[nodiscard]] const double* densities(std::size_t i) const& noexcept { return densities_.data() + i * node_count_; }
  const double* densities(std::size_t i) const&& = delete;  // it would end with the problem

  /// f at all nodes, held by this object.
  [[nodiscard]] std::span<const double> values() const& noexcept { return f_; }
  std::span<const double> values() const&& = delete;
  /// The weights of the nodes, held by this object: ∫ g is Σ weight · g.
  [[nodiscard]] std::span<const double> weights() const& noexcept { return weights_; }
  std::span<const double> weights() const&& = delete;

  /// ∫ f.
  [[nodiscard]] double integral() const noexcept {
    double sum = 0.0;
    for (const double term : weighted_f_) sum += term;
    return sum;
  }

  /// False when `density` is zero on a part of the domain that carries more than 1e-12 of ∫ |f|.
  [[nodiscard]] bool covers(const double* density) const noexcept {
    double whole = 0.0, missed = 0.0;
    for (std::size_t node = 0; node < node_count_; ++node) {
      whole += std::abs(weighted_f_[node]);
      missed += density[node] > 0.0 ? 0.0 : std::abs(weighted_f_[node]);
    }
    return missed <= 1e-12 * whole;
  }
  /// True when every proposal covers f.
  [[nodiscard]] bool has_full_support() const noexcept {
    for (std::size_t i = 0; i < proposal_count_; ++i)
      if (!covers(densities(i))) return false;
    return true;
  }

  /// Adds `times` q_i at all nodes: `sum[node] = base[node] + times · q_i(x_node)`. `sum` may be
  /// `base`.
  void add_density(std::size_t i, double times, const double* base, double* sum) const noexcept {
    const double* const q = densities(i);
    for (std::size_t node = 0; node < node_count_; ++node) sum[node] = base[node] + times * q[node];
  }

  /// Writes (quadrature weight) · f · scale / denominator to `out`, zero where the denominator is
  /// zero. Divides first: a scale over a denormal density is infinite, and 0 times that is not a
  /// number. Infinite where the quotient itself is.
  void divide(double scale, const double* denominator, double* out) const noexcept {
    for (std::size_t node = 0; node < node_count_; ++node) {
      const double safe = denominator[node] > 0.0 ? denominator[node] : 1.0;
      out[node] = denominator[node] > 0.0 ? weighted_f_[node] / safe * scale : 0.0;
    }
  }

  /// ∫ f over the places where `denominator` is positive.
  [[nodiscard]] double covered_integral(const double* denominator) const noexcept {
    double sum = 0.0;
    for (std::size_t node = 0; node < node_count_; ++node) sum += denominator[node] > 0.0 ? weighted_f_[node] : 0.0;
    return sum;
  }
  /// ∫ f²/φ from what `divide` wrote for φ.
  [[nodiscard]] double squared_over(const double* divided) const noexcept { return dot(divided, f_.data()); }
  /// ∫ f q_i/φ, the mean of f/φ under q_i, from what `divide` wrote for φ.
  [[nodiscard]] double mean_under(std::size_t i, const double* divided) const noexcept {
    return dot(divided, densities(i));
  }

  template <class Integrand, class P, NodeRange Nodes>
  friend std::vector<TabulatedProblem> tabulate_channels(Integrand&& f, const P& proposals, const Nodes& nodes);

 private:
  TabulatedProblem() = default;

  template <class Integrand, class P, NodeRange Nodes>
  void tabulate(Integrand& f, const P& proposals, const Nodes& nodes, int channel) {
    const auto& set = as_proposal_set(proposals);
    using X = typename std::remove_cvref_t<decltype(set)>::Value;
    proposal_count_ = set.size();
    node_count_ = std::size(nodes);
    require_argument(node_count_ > 0, "no quadrature nodes: give at least one");
    require_argument(proposal_count_ > 0, "the set of proposals is empty: give it at least one proposal");
    weighted_f_.reserve(node_count_);
    f_.reserve(node_count_);
    weights_.reserve(node_count_);
    densities_.resize(proposal_count_ * node_count_);
    for (const auto& node : nodes) {
      const auto x = static_cast<X>(node.x);
      const std::size_t index = f_.size();
      f_.push_back(detail::channel_value(value_of(f, x), channel));
      weighted_f_.push_back(node.weight * f_.back());
      weights_.push_back(node.weight);
      require_argument(std::isfinite(node.weight) && std::isfinite(f_.back()),
                       "the integrand, or a weight, is not finite at a quadrature node");
      for (std::size_t i = 0; i < proposal_count_; ++i)
        densities_[i * node_count_ + index] = require_density(density_of(set, i, x));
    }
  }

  static double require_density(double density) {
    require_argument(density >= 0.0 && std::isfinite(density), "a density is negative or not finite at a node");
    return density;
  }

  // Eight partial sums are faster than one, and their rounding errors grow more slowly.
  [[nodiscard]] double dot(const double* a, const double* b) const noexcept {
    double lanes[8] = {};
    std::size_t node = 0;
    for (; node + 8 <= node_count_; node += 8)
      for (std::size_t lane = 0; lane < 8; ++lane) lanes[lane] += a[node + lane] * b[node + lane];
    for (; node < node_count_; ++node) lanes[0] += a[node] * b[node];
    return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) + ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
  }

  template <class Set>
  [[nodiscard]] static double density_of(const Set& set, std::size_t i, const typename Set::Value& value) {
    if constexpr (SetHasLogPdf<Set>) {
      return std::exp(static_cast<double>(set.log_pdf(i, value)));
    } else if constexpr (SetHasPdf<Set>) {
      return static_cast<double>(set.pdf(i, value));
    } else {
      std::vector<typename Set::Density> all(set.size());
      if constexpr (is_log_set<Set>)
        set.log_pdfs(value, std::span(all));
      else
        set.pdfs(value, std::span(all));
      return is_log_set<Set> ? std::exp(static_cast<double>(all[i])) : static_cast<double>(all[i]);
    }
  }

  std::size_t proposal_count_ = 0;
  std::size_t node_count_ = 0;
  std::vector<double> weighted_f_;  // quadrature weight · f
  std::vector<double> f_;
  std::vector<double> densities_;  // proposal by proposal
  std::vector<double> weights_;
};

/// One problem for each channel of f: exact variances per channel. The densities are evaluated once
/// a channel.
template <class Integrand, class P, NodeRange Nodes>
[[nodiscard]] std::vector<TabulatedProblem> tabulate_channels(Integrand&& f, const P& proposals, const Nodes& nodes) {
  std::vector<TabulatedProblem> problems;
  if constexpr (detail::explain_arguments<Integrand, P, Philox>()) {
    using F = SummandOf<Integrand, typename std::remove_cvref_t<decltype(as_proposal_set(proposals))>::Value>;
    for (int channel = 0; channel < SpectrumTraits<F>::channel_count; ++channel) {
      TabulatedProblem problem;
      problem.tabulate(f, proposals, nodes, channel);
      problems.push_back(std::move(problem));
    }
  }
  return problems;
}

/// ψ = Σ α_k q_k at all nodes, positive wherever some α_k q_k is: a product below the range of
/// double counts as the smallest positive number. Throws std::invalid_argument unless there is one
/// fraction α_k ≥ 0 for each proposal and they sum to one within 1e-6.
[[nodiscard]] inline std::vector<double> mixture_of(std::span<const double> fractions,
                                                    const TabulatedProblem& problem) {
  require_argument(fractions.size() == problem.proposal_count(), "give one fraction for each proposal");
  double sum = 0.0;
  for (const double fraction : fractions) {
    require_argument(fraction >= 0.0, "the fractions of a mixture must not be negative");
    sum += fraction;
  }
  require_argument(std::abs(sum - 1.0) <= 1e-6, "the fractions of a mixture must sum to one");
  std::vector<double> psi(problem.node_count());
  for (std::size_t k = 0; k < fractions.size(); ++k) {
    if (!(fractions[k] > 0.0)) continue;
    const double* const q = problem.densities(k);
    for (std::size_t i = 0; i < psi.size(); ++i)
      psi[i] += q[i] > 0.0 ? std::max(fractions[k] * q[i], std::numeric_limits<double>::denorm_min()) : 0.0;
  }
  return psi;
}

}  // namespace gmis
