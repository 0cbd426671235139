#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/arguments.hpp"
#include "gmis/mis/proposal_set.hpp"
#include "gmis/mis/quadrature.hpp"

namespace gmis {

/// A one-dimensional problem tabulated at the points of a quadrature rule.
class TabulatedProblem {
 public:
  /// `f(x)` and the densities of `proposals` at every node. Throws std::invalid_argument when there are no nodes or no
  /// proposals, a value is not finite, or a density is negative.
  template <class Integrand, class P>
  TabulatedProblem(Integrand&& f, const P& proposals, std::span<const QuadratureNode> nodes)
      : node_count_(nodes.size()), weighted_f_(nodes.size()), f_(nodes.size()) {
    if constexpr (detail::explain_arguments<Integrand, P, Philox>()) {
      const auto& set = as_proposal_set(proposals);
      proposal_count_ = set.size();
      require_argument(node_count_ > 0, "no quadrature nodes: give at least one");
      require_argument(proposal_count_ > 0, "the set of proposals is empty: give it at least one proposal");
      densities_.resize(proposal_count_ * node_count_);
      for (std::size_t i = 0; i < node_count_; ++i) {
        f_[i] = static_cast<double>(f(nodes[i].x));
        weighted_f_[i] = nodes[i].weight * f_[i];
        require_argument(std::isfinite(f_[i]), "the integrand is not finite at a quadrature node");
        for (std::size_t k = 0; k < proposal_count_; ++k)
          densities_[k * node_count_ + i] = require_density(density_of(set, k, nodes[i].x));
      }
    }
  }

  /// From values at nodes that are given: `f` and the `weights` of the nodes, and the densities, all of proposal 0 first.
  /// Throws std::invalid_argument when there are none, the sizes do not fit (densities.size() is a multiple of f.size()), a
  /// value is not finite, or a density is negative.
  TabulatedProblem(std::vector<double> f, std::span<const double> weights, std::vector<double> densities)
      : node_count_(f.size()), weighted_f_(f.size()), f_(std::move(f)), densities_(std::move(densities)) {
    require_argument(node_count_ > 0 && !densities_.empty() && densities_.size() % node_count_ == 0,
                     "the densities must be given at every node, for at least one proposal");
    require_argument(weights.size() == node_count_, "one weight is needed for each node");
    proposal_count_ = densities_.size() / node_count_;
    for (std::size_t i = 0; i < node_count_; ++i) {
      weighted_f_[i] = weights[i] * f_[i];
      require_argument(std::isfinite(weights[i]) && std::isfinite(f_[i]),
                       "the integrand, or a weight, is not finite at a node");
    }
    for (const double density : densities_) require_density(density);
  }

  [[nodiscard]] std::size_t proposal_count() const noexcept { return proposal_count_; }
  [[nodiscard]] std::size_t node_count() const noexcept { return node_count_; }
  /// q_k at all nodes.
  [[nodiscard]] const double* densities(std::size_t k) const noexcept { return densities_.data() + k * node_count_; }

  /// ∫ f.
  [[nodiscard]] double integral() const noexcept {
    double sum = 0.0;
    for (const double term : weighted_f_) sum += term;
    return sum;
  }

  /// False when `density` is zero on a part of the domain that carries more than 1e-12 of ∫ |f|.
  [[nodiscard]] bool covers(const double* density) const noexcept {
    double whole = 0.0, missed = 0.0;
    for (std::size_t i = 0; i < node_count_; ++i) {
      whole += std::abs(weighted_f_[i]);
      missed += density[i] > 0.0 ? 0.0 : std::abs(weighted_f_[i]);
    }
    return missed <= 1e-12 * whole;
  }
  /// True when every proposal covers f.
  [[nodiscard]] bool has_full_support() const noexcept {
    for (std::size_t k = 0; k < proposal_count_; ++k)
      if (!covers(densities(k))) return false;
    return true;
  }

  /// Adds `times` q_k at all nodes: `sum[i] = base[i] + times · q_k(x_i)`. `sum` may be `base`.
  void add_density(std::size_t k, double times, const double* base, double* sum) const noexcept {
    const double* const q = densities(k);
    for (std::size_t i = 0; i < node_count_; ++i) sum[i] = base[i] + times * q[i];
  }

  /// Writes (quadrature weight) · f · scale / denominator to `out`, zero where the denominator is zero. Divides first: a
  /// scale over a denormal density is infinite, and 0 times that is not a number. Infinite where the quotient itself is.
  void divide(double scale, const double* denominator, double* out) const noexcept {
    for (std::size_t i = 0; i < node_count_; ++i) {
      const double safe = denominator[i] > 0.0 ? denominator[i] : 1.0;
      out[i] = denominator[i] > 0.0 ? weighted_f_[i] / safe * scale : 0.0;
    }
  }

  /// ∫ f over the places where `denominator` is positive.
  [[nodiscard]] double covered_integral(const double* denominator) const noexcept {
    double sum = 0.0;
    for (std::size_t i = 0; i < node_count_; ++i) sum += denominator[i] > 0.0 ? weighted_f_[i] : 0.0;
    return sum;
  }
  /// ∫ f²/φ from what `divide` wrote for φ.
  [[nodiscard]] double squared_over(const double* divided) const noexcept { return dot(divided, f_.data()); }
  /// ∫ f q_k/φ, the mean of f/φ under q_k, from what `divide` wrote for φ.
  [[nodiscard]] double mean_under(std::size_t k, const double* divided) const noexcept {
    return dot(divided, densities(k));
  }

 private:
  static double require_density(double density) {
    require_argument(density >= 0.0 && std::isfinite(density), "a density is negative or not finite at a node");
    return density;
  }

  // In eight partial sums: that much faster than one, and rounding errors grow that much more slowly.
  [[nodiscard]] double dot(const double* a, const double* b) const noexcept {
    double lanes[8] = {};
    std::size_t i = 0;
    for (; i + 8 <= node_count_; i += 8)
      for (std::size_t lane = 0; lane < 8; ++lane) lanes[lane] += a[i + lane] * b[i + lane];
    for (; i < node_count_; ++i) lanes[0] += a[i] * b[i];
    return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) + ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
  }

  template <class Set>
  [[nodiscard]] static double density_of(const Set& set, std::size_t k, double x) {
    const auto value = static_cast<typename Set::Value>(x);
    if constexpr (SetHasLogPdf<Set>) {
      return std::exp(static_cast<double>(set.log_pdf(k, value)));
    } else if constexpr (SetHasPdf<Set>) {
      return static_cast<double>(set.pdf(k, value));
    } else {
      std::vector<typename Set::Density> all(set.size());
      if constexpr (is_log_set<Set>)
        set.log_pdfs(value, std::span(all));
      else
        set.pdfs(value, std::span(all));
      return is_log_set<Set> ? std::exp(static_cast<double>(all[k])) : static_cast<double>(all[k]);
    }
  }

  std::size_t proposal_count_ = 0;
  std::size_t node_count_;
  std::vector<double> weighted_f_;  // quadrature weight · f
  std::vector<double> f_;
  std::vector<double> densities_;  // proposal by proposal
};

}  // namespace gmis
