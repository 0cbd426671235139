#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "gmis/core/attributes.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/sobol_numbers.hpp"
#include "gmis/result/error_fit.hpp"

namespace gmis {

/// How the noise in the mean of N iterations falls. The variance of iteration i is `independent` +
/// `merging` · i^(1−α): what merging adds is inversely proportional to the area of its disk, which
/// shrinks like i^(α−1). The squared error is
///     (independent · N + merging · Σ_{i ≤ N} i^(1−α)) / N²,
/// and the error falls with a slope between −1/2 and −α/2. Merging's bias is not in it.
///
/// With low-discrepancy numbers (`Sampler::sobol`) a part of it falls by half an order faster once
/// a replication has more than one iteration: the squared error is that above times 1 − e (1 − √(R
/// / N)) from N = R iterations on, R = `sobol_replications`.
struct ErrorLaw {
  double independent = 0.0;  ///< relative variance of each iteration
  double merging = 0.0;      ///< the same, of merging in the first iteration
  double alpha = 1.0;     ///< of the radius, `RenderSettings::alpha`; 1 where nothing merges or the disk stays as it is
  double evenness = 0.0;  ///< e: the share of the squared error that evenly spread numbers take away in the end

  /// Relative error after this number of iterations, which need not be whole.
  [[nodiscard]] double error_at(double iterations) const noexcept { return std::sqrt(squared_error_at(iterations)); }

  /// The share of `merging` in the squared error.
  [[nodiscard]] double merging_share_at(double iterations) const noexcept {
    const double both = of_independent_numbers(iterations);
    return both > 0.0 ? merging * merging_sum(iterations) / square(iterations) / both : 0.0;
  }

  /// 1 − e (1 − √(R / N)): the squared error over that of independent numbers.
  [[nodiscard]] double remaining_at(double iterations) const noexcept {
    return 1.0 - evenness * (1.0 - first_points(iterations));
  }

  /// d ln error / d ln iterations.
  [[nodiscard]] double slope_at(double iterations) const noexcept {
    const double evened =
        iterations > sobol_replications ? evenness * first_points(iterations) / remaining_at(iterations) : 0.0;
    return -0.5 + 0.5 * (1.0 - alpha) * merging_share_at(iterations) - 0.25 * evened;
  }

  /// The iterations that it takes; infinite for an error of 0, and for no law at all.
  [[nodiscard]] double iterations_to_reach(double error) const noexcept {
    if (!(error > 0.0) || !(independent + merging > 0.0) || !std::isfinite(independent + merging))
      return std::numeric_limits<double>::infinity();
    // Between the two laws with the least and the greatest slope through the first iteration.
    const double at_one = error_at(1.0) / error;
    double lower = std::log(std::min(1.0, at_one * at_one)), upper = 2.0 * std::log(std::max(1.0, at_one)) / alpha;
    for (int i = 0; i < 64 && upper - lower > 1e-12; ++i) {
      const double middle = 0.5 * (lower + upper);
      (error_at(std::exp(middle)) > error ? lower : upper) = middle;
    }
    return std::exp(upper);
  }

  /// The same law for errors that are this factor as large.
  [[nodiscard]] ErrorLaw scaled(double factor) const noexcept {
    return {independent * factor * factor, merging * factor * factor, alpha, evenness};
  }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(independent, merging, alpha, evenness);
  }

 private:
  [[nodiscard]] double squared_error_at(double n) const noexcept { return of_independent_numbers(n) * remaining_at(n); }
  [[nodiscard]] double of_independent_numbers(double n) const noexcept {
    return independent / n + merging * merging_sum(n) / square(n);
  }
  /// √(R / N), at most 1.
  [[nodiscard]] static double first_points(double n) noexcept {
    return std::sqrt(std::min(1.0, sobol_replications / n));
  }
  /// Σ_{i ≤ n} i^(1−α) by the midpoint rule.
  [[nodiscard]] double merging_sum(double n) const noexcept {
    const double power = 2.0 - alpha;
    return (std::pow(n + 0.5, power) - std::pow(0.5, power)) / power;
  }
};

/// The law through the last point of a log, of errors over *iterations* (the `seconds` of the
/// points). Its shape is found by least squares of relative squared errors over the points from an
/// eighth of the last iteration on, both parts at least 0. With α = 1 nothing need be found.
/// `points` must hold an error above 0, the last one. `expected` is what was known before: a
/// forecast, or nothing but α and the evenness (both parts 0). The evenness stays: in a log it
/// looks like less merging.
///
/// Points of a log are correlated and few: from N iterations, the found share of merging
/// has the weight N / (N + 64), and the expected share has the rest. An error above the expected
/// one has come with rare samples that were not known, and counts as independent. Where the error
/// is in doubt (it has no interval) rare samples rule it: those that are met one after the other
/// let it fall too slowly, and few of them state it too high, while a forecast, which leaves the
/// brightest pixels out, is too low. Then the share counts as N / (N + 512), and the law goes
/// through the forecast and the last point in the proportion of 16 to N on a scale of logarithms.
GMIS_RARE [[nodiscard]] inline ErrorLaw fit_error_law(std::span<const ErrorAtTime> points, const ErrorLaw& expected,
                                                      bool is_in_doubt = false) {
  const ErrorAtTime last = points.back();
  const double n = last.seconds, forecast = expected.error_at(n) / last.error;
  const double anchor = last.error * (is_in_doubt && forecast > 0.0 ? std::pow(forecast, 16.0 / (n + 16.0)) : 1.0);
  const auto through_anchor = [&](const ErrorLaw& law) { return law.scaled(anchor / law.error_at(n)); };
  if (!(expected.alpha < 1.0)) return through_anchor({1.0, 0.0, 1.0, expected.evenness});
  const ErrorLaw independent{1.0, 0.0, expected.alpha, expected.evenness};
  const ErrorLaw merging{0.0, 1.0, expected.alpha, expected.evenness};
  // Normal equations for the factors a and b of the two laws: Σ (a x + b y − 1)².
  double xx = 0.0, xy = 0.0, yy = 0.0, x1 = 0.0, y1 = 0.0;
  int count = 0;
  for (const ErrorAtTime& point : points) {
    if (!(point.seconds >= last.seconds / 8) || !(point.error > 0.0)) continue;
    const double x = square(independent.error_at(point.seconds) / point.error);
    const double y = square(merging.error_at(point.seconds) / point.error);
    xx += x * x, xy += x * y, yy += y * y, x1 += x, y1 += y, ++count;
  }
  double found = 0.0;  // share of merging at the last point
  constexpr int fewest = 4;
  if (count >= fewest) {
    // The best of both parts, or of one alone where the other would be negative.
    const double determinant = xx * yy - xy * xy;
    const double a = x1 * yy - y1 * xy, b = y1 * xx - x1 * xy;
    const bool is_mixture = determinant > 1e-12 * xx * yy && a > 0.0 && b > 0.0;
    const bool merging_alone = !is_mixture && y1 * y1 * xx > x1 * x1 * yy;
    found = is_mixture ? ErrorLaw{a, b, expected.alpha}.merging_share_at(n) : merging_alone ? 1.0 : 0.0;
  }
  const double trusted_after = is_in_doubt && forecast > 0.0 ? 512.0 : 64.0;
  const double trust = count >= fewest ? n / (n + trusted_after) : 0.0;
  const double share = trust * found + (1.0 - trust) * std::min(1.0, square(forecast)) * expected.merging_share_at(n);
  return through_anchor({square(1.0 / independent.error_at(n)) * (1.0 - share),
                         square(1.0 / merging.error_at(n)) * share, expected.alpha, expected.evenness});
}

}  // namespace gmis
