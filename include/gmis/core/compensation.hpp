#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"

namespace gmis {

/// MIS compensation [Karlík, Šik, Vévoda, Skřivan, Křivánek: MIS compensation, 2019]: the density
/// that a free technique (a table: an environment map, a guiding grid) should have beside others
/// that are given. In cells i with `target` t_i = ∫ |f| and `others` o_i = the probability of the
/// rest of the mixture, and with the fraction c of all samples, it returns p_i = max(0, λ t_i − (1
/// − c) o_i)/c with λ such that Σ p_i = 1: samples go where the others leave f short, none where
/// they have more than enough. For densities that are constant in a cell no other p has a smaller ∫
/// f²/ψ.
///
/// Only a zero of ψ = c p + (1 − c) o would bias; where the others are zero, p is positive wherever
/// the target is. Where `others` is an approximation, add a defensive share of your own. Throws
/// std::invalid_argument for lists of different or no length, values that are negative or not
/// finite, a target without mass, others that sum to more than 1.5, or a fraction outside (0, 1].
[[nodiscard]] inline std::vector<double> compensated_density(std::span<const double> target,
                                                             std::span<const double> others, double fraction) {
  if (target.empty() || target.size() != others.size())
    reject_argument("give the target and the others in the same cells");
  if (!(fraction > 0.0 && fraction <= 1.0)) reject_argument("the fraction of samples must lie in (0, 1]");
  double mass = 0.0, rest = 0.0;
  for (std::size_t i = 0; i < target.size(); ++i) {
    if (!(target[i] >= 0.0 && std::isfinite(target[i]) && others[i] >= 0.0 && std::isfinite(others[i])))
      reject_argument("target and others must be finite and not negative");
    mass += target[i];
    rest += others[i];
  }
  if (!(mass > 0.0 && std::isfinite(mass))) reject_argument("the target has no mass");
  if (!(rest <= 1.5)) reject_argument("the others are probabilities, which sum to one at most");

  // With Σ t = 1, Σ max(0, λ t − (1 − c) o) rises with λ, from 0 to at least c at λ = c + (1 − c) Σ
  // o.
  const auto excess = [&](double lambda) {
    double sum = 0.0;
    for (std::size_t i = 0; i < target.size(); ++i)
      sum += std::max(0.0, lambda * (target[i] / mass) - (1.0 - fraction) * others[i]);
    return sum;
  };
  double low = 0.0, high = fraction + (1.0 - fraction) * rest;
  for (int step = 0; step < 200; ++step) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    (excess(middle) < fraction ? low : high) = middle;
  }
  std::vector<double> density(target.size());
  const double sum = excess(high);
  if (!(sum > 0.0)) {  // a fraction below the rounding of the others, which are in proportion to the target
    for (std::size_t i = 0; i < target.size(); ++i) density[i] = target[i] / mass;
    return density;
  }
  for (std::size_t i = 0; i < target.size(); ++i)
    density[i] = std::max(0.0, high * (target[i] / mass) - (1.0 - fraction) * others[i]) / sum;
  return density;
}

}  // namespace gmis
