#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"

/// \file
/// Checks that a sampler draws with the density that it states: for proposals, BSDFs and lights, in
/// any test framework. Each check compares the number of samples in a bin with the density
/// integrated over the bin [Subr, Arvo 2007].

namespace gmis {

/// How much a check draws, and how finely it compares. With fewer than `smallest_expected` samples
/// a bin, or fewer than 1,000 in all, nearly every sampler passes: the checks then throw
/// std::invalid_argument.
struct CheckSettings {
  std::size_t samples = 100'000;  ///< draws
  std::size_t bins = 400;         ///< on the sphere: columns are twice the rows
  double smallest_expected = 5;   ///< bins that expect fewer samples are pooled
  double precision = 1e-7;        ///< absolute, of the integral over one bin
};

/// The result of comparing samples with a density.
struct DensityCheck {
  StatisticalTest test;      ///< χ² of the counts; failed samples have a bin of their own
  double integral = 0;       ///< integral of the density: the probability that a sample succeeds, at most 1
  double success_share = 0;  ///< measured share of the samples that succeeded
  std::size_t outside = 0;   ///< samples where the density is 0, negative or not finite

  /// True when nothing is found; a sound sampler fails with probability `level` at most.
  /// `tolerance`: of the integral above 1.
  [[nodiscard]] bool passes(double level, double tolerance = 1e-4) const noexcept {
    return outside == 0 && integral <= 1 + tolerance && test.passes(level);
  }
};

namespace detail {

/// Throws std::invalid_argument where the samples are too few to tell a wrong density from a right
/// one.
inline void require_power(const CheckSettings& settings) {
  require_argument(settings.bins > 0, "the check needs at least one bin");
  const double least = std::max(1000.0, settings.smallest_expected * static_cast<double>(settings.bins));
  if (static_cast<double>(settings.samples) >= least) return;
  const std::string text = std::to_string(settings.samples) + " samples in " + std::to_string(settings.bins) +
                           " bins cannot tell a wrong density from a right one: set CheckSettings::samples to " +
                           std::to_string(static_cast<std::size_t>(std::ceil(least))) +
                           " at least (1000, and smallest_expected for each bin)";
  require_argument(false, text.c_str());
}

/// ∫∫ f over a rectangle, by Gauss's rule with 3×3 points. The rectangle is halved both ways until
/// the sum of its parts agrees with the whole, and at least `least_depth` times.
template <class F>
[[nodiscard]] double integrate_rectangle(const F& f, double x0, double x1, double y0, double y1, double precision,
                                         int depth, int least_depth = 1) {
  const auto rule = [&f](double left, double right, double low, double high) {
    constexpr std::array<double, 3> node{-0.77459666924148338, 0, 0.77459666924148338};
    constexpr std::array<double, 3> weight{5.0 / 18, 8.0 / 18, 5.0 / 18};
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        sum += weight[i] * weight[j] *
               f((left + right) / 2 + node[i] * (right - left) / 2, (low + high) / 2 + node[j] * (high - low) / 2);
    return sum * (right - left) * (high - low);
  };
  const auto refine = [&](const auto& self, double left, double right, double low, double high, double whole,
                          double tolerance, int left_to_go) -> double {
    const double x = (left + right) / 2, y = (low + high) / 2;
    const std::array<double, 4> parts{rule(left, x, low, y), rule(x, right, low, y), rule(left, x, y, high),
                                      rule(x, right, y, high)};
    const double sum = parts[0] + parts[1] + parts[2] + parts[3];
    if (left_to_go == 0 || (left_to_go <= depth - least_depth + 1 && std::abs(sum - whole) <= tolerance)) return sum;
    const double t = tolerance / 2;
    return self(self, left, x, low, y, parts[0], t, left_to_go - 1) +
           self(self, x, right, low, y, parts[1], t, left_to_go - 1) +
           self(self, left, x, y, high, parts[2], t, left_to_go - 1) +
           self(self, x, right, y, high, parts[3], t, left_to_go - 1);
  };
  return refine(refine, x0, x1, y0, y1, rule(x0, x1, y0, y1), precision, depth);
}

/// Turns counts and integrals into the result of the check.
[[nodiscard]] inline DensityCheck judge(std::vector<double> counts, std::vector<double> integrals, std::size_t outside,
                                        const CheckSettings& settings) {
  DensityCheck result;
  const auto total = static_cast<double>(settings.samples);
  double succeeded = 0;
  for (const double count : counts) succeeded += count;
  for (const double integral : integrals) result.integral += integral;
  for (double& integral : integrals) integral *= total;
  counts.push_back(total - succeeded);
  integrals.push_back(std::max(0.0, total * (1 - result.integral)));
  // The quadrature has an error. A density whose integral is 1 within that error leaves no samples
  // that fail.
  if (integrals.back() < 1e-5 * total && counts.back() == 0) integrals.back() = 0;
  result.success_share = succeeded / total;
  result.outside = outside;
  // χ² has no meaning where an expected number is infinite or NaN.
  result.test = std::isfinite(total * result.integral) ? chi_square_test(counts, integrals, settings.smallest_expected)
                                                       : StatisticalTest{std::numeric_limits<double>::infinity(), 0, 0};
  return result;
}

}  // namespace detail

/// Checks a sampler of directions against its density per steradian. `sample()` returns an
/// `std::optional` of a unit vector, `pdf(direction)` the density. Bins are cells of equal solid
/// angle in coordinates around `axis`. Choose the axis of symmetry of the discontinuities, such as
/// the normal of a surface. Throws std::invalid_argument where samples are too few for the bins.
template <std::floating_point T, class Sample, class Pdf>
[[nodiscard]] DensityCheck check_directions(const Vec3<T>& axis, Sample&& sample, Pdf&& pdf,
                                            const CheckSettings& settings = {}) {
  detail::require_power(settings);
  const auto rows = static_cast<std::size_t>(std::max(2.0, 2 * std::round(std::sqrt(double(settings.bins) / 2) / 2)));
  const std::size_t columns = 2 * rows;
  const Frame<T> frame = Frame<T>::around(axis);
  const Frame<double> exact{Vec3<double>(frame.tangent), Vec3<double>(frame.bitangent), Vec3<double>(frame.normal)};
  const auto cell = [](double x, std::size_t cells) {
    return std::min(static_cast<std::size_t>(std::max(0.0, x * static_cast<double>(cells))), cells - 1);
  };

  std::vector<double> counts(rows * columns), integrals(rows * columns);
  std::size_t outside = 0;
  for (std::size_t i = 0; i < settings.samples; ++i) {
    const std::optional<Vec3<T>> direction = sample();
    if (!direction) continue;
    const double density = static_cast<double>(pdf(*direction));
    if (!(density > 0 && density <= std::numeric_limits<double>::max())) ++outside;
    const Vec3<double> local = exact.to_local(Vec3<double>(*direction));
    const double turn = std::atan2(local.y, local.x) / (2 * pi<double>);
    ++counts[cell((local.z + 1) / 2, rows) * columns + cell(turn < 0 ? turn + 1 : turn, columns)];
  }
  const auto integral_over = [&](std::size_t row, std::size_t column, double precision, int depth, int least_depth) {
    return detail::integrate_rectangle(
        [&](double z, double angle) {
          const double radius = sqrt_or_zero(1 - z * z);
          const Vec3<double> local(radius * std::cos(angle), radius * std::sin(angle), z);
          return static_cast<double>(pdf(Vec3<T>(exact.to_world(local))));
        },
        2 * static_cast<double>(row) / static_cast<double>(rows) - 1,
        2 * static_cast<double>(row + 1) / static_cast<double>(rows) - 1,
        2 * pi<double> * static_cast<double>(column) / static_cast<double>(columns),
        2 * pi<double> * static_cast<double>(column + 1) / static_cast<double>(columns), precision, depth, least_depth);
  };
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < columns; ++column)
      integrals[row * columns + column] = integral_over(row, column, settings.precision, 6, 1);

  // Where counts and integrals disagree, the quadrature may have missed a sliver with a positive
  // density: it is refined there. This does not favour the sampler, because a refined integral is
  // closer to the true one whatever the counts are.
  const auto samples = static_cast<double>(settings.samples);
  const auto deviation = [](double count, double expected) { return std::abs(count - expected) / std::sqrt(expected); };
  const double share = std::accumulate(counts.begin(), counts.end(), 0.0) / samples;
  const double integral = std::accumulate(integrals.begin(), integrals.end(), 0.0);
  const bool is_total_off =
      std::abs(share - integral) > 1e-4 + 3 * std::sqrt(share * std::max(1 - share, 0.0) / samples);
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t i = row * columns + column;
      const auto is_off = [&](double sigmas) { return deviation(counts[i], samples * integrals[i] + 1e-9) > sigmas; };
      if (is_total_off || is_off(2)) integrals[i] = integral_over(row, column, settings.precision / 100, 9, 3);
      if (is_off(4)) integrals[i] = integral_over(row, column, settings.precision / 100, 9, 6);
    }
  return detail::judge(std::move(counts), std::move(integrals), outside, settings);
}

namespace detail {
template <class P, class X>
concept StatesLogarithm = requires(const P& proposal, const X& x) {
  proposal.log_pdf(x);
};
template <class P, class X>
[[nodiscard]] double density_of_proposal(const P& proposal, const X& x) {
  if constexpr (StatesLogarithm<P, X>)
    return std::exp(static_cast<double>(proposal.log_pdf(x)));
  else
    return static_cast<double>(proposal.pdf(x));
}
}  // namespace detail

/// Checks a proposal for numbers (`sample(source)` and `pdf(x)` or `log_pdf(x)`, as in
/// `gmis::Proposal`) against its density on [lower, upper]. The numbers are of a floating-point
/// type: a density over integers is no integral. Samples outside the interval count as failed.
/// Throws std::invalid_argument unless lower < upper are finite and there are enough samples for
/// the bins.
template <class P, UniformSource Source>
[[nodiscard]] DensityCheck check_proposal(const P& proposal, double lower, double upper, Source& source,
                                          const CheckSettings& settings = {}) {
  using Value = std::remove_cvref_t<decltype(proposal.sample(source))>;
  static_assert(
      std::floating_point<Value> || requires { requires std::floating_point<typename Value::value_type>; },
      "check_proposal needs samples that are floating-point numbers, or std::optional of them: for integers, "
      "give their counts to chi_square_test");
  require_argument(lower < upper && std::isfinite(upper - lower), "the interval must be finite, with lower < upper");
  detail::require_power(settings);
  std::vector<double> counts(settings.bins), integrals(settings.bins);
  const double width = (upper - lower) / static_cast<double>(settings.bins);
  std::size_t outside = 0;
  const auto count = [&](auto x) {
    const double density = detail::density_of_proposal(proposal, x);
    if (!(density > 0 && density <= std::numeric_limits<double>::max())) ++outside;
    const double place = (static_cast<double>(x) - lower) / width;
    if (place >= 0 && static_cast<double>(x) <= upper)
      ++counts[std::min(static_cast<std::size_t>(place), settings.bins - 1)];
  };
  for (std::size_t i = 0; i < settings.samples; ++i) {
    const Value x = proposal.sample(source);
    if constexpr (std::floating_point<Value>) {
      count(x);
    } else {
      if (x) count(*x);
    }
  }
  const auto pdf_at = [&](double x) {
    if constexpr (std::floating_point<Value>)
      return detail::density_of_proposal(proposal, static_cast<Value>(x));
    else
      return detail::density_of_proposal(proposal, static_cast<typename Value::value_type>(x));
  };
  for (std::size_t bin = 0; bin < settings.bins; ++bin)
    integrals[bin] = detail::integrate_rectangle(
        [&](double x, double) { return pdf_at(x); }, lower + width * static_cast<double>(bin),
        lower + width * static_cast<double>(bin + 1), 0, 1, settings.precision, 8);
  return detail::judge(std::move(counts), std::move(integrals), outside, settings);
}

namespace detail {
/// The largest channel; infinity where a channel is not finite, which std::max may pass over.
template <Spectrum S>
[[nodiscard]] double largest_channel(const S& s) {
  double largest = static_cast<double>(max_channel(s));
  for (int i = 0; i < SpectrumTraits<S>::channel_count; ++i)
    if (!std::isfinite(SpectrumTraits<S>::channel(s, i))) largest = std::numeric_limits<double>::infinity();
  return largest;
}

/// ∫ f |cos| over all directions, without delta lobes, of the largest channel: quadrature over
/// cells of the sphere. Infinity where the integral of a channel is not finite.
template <Bsdf B, class V>
[[nodiscard]] double smooth_share(const B& bsdf, const V& normal, const V& to_prev, TransportMode mode,
                                  double precision) {
  using S = typename B::Spectrum;
  const Frame<double> frame = Frame<double>::around(Vec3<double>(normal));
  double share = 0;
  for (int i = 0; i < SpectrumTraits<S>::channel_count; ++i) {
    double sum = 0;
    constexpr int cells = 8;
    for (int z = -cells; z < cells; ++z)
      for (int turn = 0; turn < 2 * cells; ++turn) {
        sum += integrate_rectangle(
            [&](double height, double angle) {
              const double radius = sqrt_or_zero(1 - height * height);
              const Vec3<double> local(radius * std::cos(angle), radius * std::sin(angle), height);
              const S value = bsdf.evaluate(to_prev, V(frame.to_world(local)), mode).value;
              return static_cast<double>(SpectrumTraits<S>::channel(value, i)) * std::abs(height);
            },
            z / double(cells), (z + 1) / double(cells), pi<double> * turn / cells, pi<double> * (turn + 1) / cells,
            precision, 7);
        if (!std::isfinite(sum)) return std::numeric_limits<double>::infinity();
      }
    share = std::max(share, sum);
  }
  return share;
}
}  // namespace detail

/// The share of light from `to_prev` that a BSDF scatters, largest channel: ∫ f |cos| by
/// quadrature, and delta lobes by the mean weight of `samples` draws. For importance, so that
/// refraction changes no radiance: at most 1. Infinity where f or a weight is not finite. Throws
/// std::invalid_argument for no samples.
template <Bsdf B, UniformSource Source>
[[nodiscard]] double reflected_share(const B& bsdf, const Vec3<ScalarOf<typename B::Spectrum>>& normal,
                                     const Vec3<ScalarOf<typename B::Spectrum>>& to_prev, Source& source,
                                     std::size_t samples = 1000, double precision = 1e-7) {
  using T = ScalarOf<typename B::Spectrum>;
  require_argument(samples > 0, "reflected_share needs at least one sample");
  constexpr auto mode = TransportMode::importance;
  double delta = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    const T u = uniform<T>(source);
    const T v = uniform<T>(source);
    const auto drawn = bsdf.sample(to_prev, u, {v, uniform<T>(source)}, mode);
    if (drawn && drawn->is_delta) delta += detail::largest_channel(drawn->weight);
  }
  return detail::smooth_share(bsdf, normal, to_prev, mode, precision) + delta / static_cast<double>(samples);
}

/// The result of `check_bsdf`. All errors are relative; infinite where a value is not finite.
struct BsdfCheck {
  DensityCheck directions;       ///< the non-delta part of `sample` against `evaluate(…).pdf.forward`
  double reverse_error = 0;      ///< largest difference of pdf.reverse(a, b) from pdf.forward(b, a)
  double reciprocity_error = 0;  ///< largest difference of f(a, b) for importance from f(b, a) for radiance
  double sample_error = 0;       ///< largest difference of `sample` from `evaluate` at the same directions
  double reflected_share = 0;    ///< ∫ f |cos|, delta lobes included, largest channel: at most 1

  /// True when nothing is found; a sound BSDF fails with probability `level` at most. `tolerance`:
  /// of the relative errors.
  [[nodiscard]] bool passes(double level, double tolerance = 1e-3) const noexcept {
    return directions.passes(level) && reverse_error <= tolerance && reciprocity_error <= tolerance &&
           sample_error <= tolerance && reflected_share <= 1 + tolerance;
  }
};

/// Checks a BSDF at one point with the shading normal `normal`, for light from `to_prev`: the
/// sampler against its density, reverse densities, reciprocity and energy. Reciprocity compares
/// importance in one direction with radiance in the other direction, so that it holds for
/// refraction too [Veach 1997, section 5.2].
///
/// `bsdf_for(to_prev)` returns the BSDF that a ray arriving from `to_prev` finds. An engine
/// evaluates a BSDF only with the `to_prev` of the ray that made its hit, so a BSDF may store
/// values that depend on `to_prev`.
template <class BsdfFor, std::floating_point T, UniformSource Source>
requires Bsdf < std::remove_cvref_t < std::invoke_result_t < const BsdfFor&, const Vec3<T>
& >>> [[nodiscard]] BsdfCheck check_bsdf(const BsdfFor& bsdf_for, const Vec3<T>& normal, const Vec3<T>& to_prev,
                                         Source& source, const CheckSettings& settings = {}) {
  using B = std::remove_cvref_t<std::invoke_result_t<const BsdfFor&, const Vec3<T>&>>;
  const B bsdf = bsdf_for(to_prev);
  using S = typename B::Spectrum;
  static_assert(std::same_as<T, ScalarOf<S>>);
  constexpr auto mode = TransportMode::importance;  // no change of radiance by refraction
  BsdfCheck result;
  const auto differ = [](double a, double b) {
    if (!std::isfinite(a - b)) return std::numeric_limits<double>::infinity();
    const double scale = std::max(std::abs(a), std::abs(b));
    return scale > 1e-4 ? std::abs(a - b) / scale : 0.0;
  };
  const auto compare = [&](double& worst, double a, double b) { worst = std::max(worst, differ(a, b)); };
  const auto channel = [](const S& s, int i) { return static_cast<double>(SpectrumTraits<S>::channel(s, i)); };

  double delta_share = 0;
  const auto sample = [&]() -> std::optional<Vec3<T>> {
    const T u = uniform<T>(source);
    const Vec2<T> uv{uniform<T>(source), uniform<T>(source)};
    const auto drawn = bsdf.sample(to_prev, u, uv, mode);
    if (!drawn) return std::nullopt;
    if (drawn->is_delta) {
      delta_share += detail::largest_channel(drawn->weight);
      return std::nullopt;
    }
    const T cosine = std::abs(glm::dot(normal, drawn->to_next));
    if (cosine < T(1e-3)) return drawn->to_next;  // dominated by the rounding of the direction
    const auto value = bsdf.evaluate(to_prev, drawn->to_next, mode);
    compare(result.sample_error, static_cast<double>(drawn->pdf.forward.value),
            static_cast<double>(value.pdf.forward.value));
    compare(result.sample_error, static_cast<double>(drawn->pdf.reverse.value),
            static_cast<double>(value.pdf.reverse.value));
    for (int i = 0; i < SpectrumTraits<S>::channel_count; ++i)
      compare(result.sample_error, channel(drawn->weight, i) * static_cast<double>(value.pdf.forward.value),
              channel(value.value, i) * static_cast<double>(cosine));
    const auto swapped = bsdf_for(drawn->to_next).evaluate(drawn->to_next, to_prev, TransportMode::radiance);
    compare(result.reverse_error, static_cast<double>(swapped.pdf.forward.value),
            static_cast<double>(value.pdf.reverse.value));
    for (int i = 0; i < SpectrumTraits<S>::channel_count; ++i)
      compare(result.reciprocity_error, channel(value.value, i), channel(swapped.value, i));
    return drawn->to_next;
  };
  result.directions = check_directions<T>(
      normal, sample, [&](const Vec3<T>& w) { return bsdf.evaluate(to_prev, w, mode).pdf.forward.value; }, settings);

  result.reflected_share = detail::smooth_share(bsdf, normal, to_prev, mode, settings.precision) +
                           delta_share / static_cast<double>(settings.samples);
  return result;
}

/// Checks a BSDF that does not depend on the `to_prev` of its hit.
template <Bsdf B, UniformSource Source>
[[nodiscard]] BsdfCheck check_bsdf(const B& bsdf, const Vec3<ScalarOf<typename B::Spectrum>>& normal,
                                   const Vec3<ScalarOf<typename B::Spectrum>>& to_prev, Source& source,
                                   const CheckSettings& settings = {}) {
  using T = ScalarOf<typename B::Spectrum>;
  return check_bsdf([&bsdf](const Vec3<T>&) -> const B& { return bsdf; }, normal, to_prev, source, settings);
}

}  // namespace gmis
