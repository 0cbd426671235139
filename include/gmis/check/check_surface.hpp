#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "gmis/check/findings.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"

namespace gmis {

/// Checks the BSDF at one point of a surface in both modes of transport.
///
/// `bsdf_for(to_prev)` makes the BSDF of that point as a ray that arrives from `to_prev` finds it, in a `std::optional`:
/// the engine evaluates a BSDF only with the `to_prev` of the ray that made its hit. `findings` take the cases; the
/// verdict on the distribution of `sample` needs `samples` draws at this point and raises a false alarm with a
/// probability of at most `level`. With 0 samples it is left out.
template <class BsdfFor, std::floating_point T, UniformSource Source>
void check_surface(const BsdfFor& bsdf_for, const SurfacePoint<T>& point, const Vec3<T>& to_prev, Source& source,
                   Findings& findings, std::size_t samples, double level) {
  using B = typename std::remove_cvref_t<decltype(bsdf_for(to_prev))>::value_type;
  using S = typename B::Spectrum;
  using V = Vec3<double>;
  constexpr int channels = SpectrumTraits<S>::channel_count;
  constexpr double least_cosine = 0.02;  // below it rounding of directions rules
  const std::optional<B> found = bsdf_for(to_prev);
  if (!found) return;
  const B& bsdf = *found;
  const V normal(point.shading_normal), geometric(point.geometric_normal), prev(to_prev);
  if (std::abs(glm::dot(normal, prev)) < least_cosine) return;
  const auto channel = [](const S& s, int i) { return static_cast<double>(SpectrumTraits<S>::channel(s, i)); };
  const auto are_near = [&](const S& a, const S& b, double factor, double tolerance) {
    const double scale = 1e-3 * std::max(static_cast<double>(max_channel(a)), static_cast<double>(max_channel(b)));
    for (int i = 0; i < channels; ++i)
      if (!detail::nearly(channel(a, i) * factor, channel(b, i), tolerance, scale)) return false;
    return true;
  };
  const auto is_sound = [&](const S& s) { return is_finite(s) && min_channel(s) >= T(0); };
  const auto draw = [&](const B& from, const Vec3<T>& prev_of, TransportMode mode) {
    const T u = uniform<T>(source);
    const T v = uniform<T>(source);
    return from.sample(prev_of, u, {v, uniform<T>(source)}, mode);
  };

  const double albedo = static_cast<double>(max_channel(bsdf.albedo()));
  findings.count(Convention::bsdf_albedo, is_sound(bsdf.albedo()) && albedo <= 1.0 + 1e-3);
  std::size_t through = 0, smooth = 0, succeeded = 0;
  bool is_refracting = false;
  constexpr std::size_t pairs = 24;
  for (const TransportMode mode : {TransportMode::radiance, TransportMode::importance}) {
    const TransportMode other = mode == TransportMode::radiance ? TransportMode::importance : TransportMode::radiance;
    for (std::size_t i = 0; i < pairs; ++i) {
      if (reflects_only(bsdf)) {
        const double u = uniform<double>(source);
        V beyond = square_to_sphere(Vec2<double>(u, uniform<double>(source)));
        if (glm::dot(normal, beyond) * glm::dot(normal, prev) > 0.0) beyond = -beyond;
        if (std::abs(glm::dot(normal, beyond)) >= least_cosine)
          findings.count(Convention::bsdf_reflects_only, is_black(bsdf.evaluate(to_prev, Vec3<T>(beyond), mode).value));
      }
      const auto sample = draw(bsdf, to_prev, mode);
      if (!sample) continue;
      ++succeeded;
      const V next(sample->to_next);
      const double forward = static_cast<double>(sample->pdf.forward.value),
                   reverse = static_cast<double>(sample->pdf.reverse.value), cosine = std::abs(glm::dot(normal, next));
      const double eta = static_cast<double>(sample->eta);
      findings.count(Convention::bsdf_unit, detail::nearly(glm::length(next), 1.0, 1e-3));
      findings.count(Convention::bsdf_value,
                     is_sound(sample->weight) && forward >= 0.0 && reverse >= 0.0 && std::isfinite(forward + reverse));
      is_refracting = is_refracting || eta != 1.0;
      // One delta lobe cannot scatter more than all light.
      if (mode == TransportMode::importance && sample->is_delta && eta != 1.0)
        findings.count(Convention::bsdf_energy, static_cast<double>(max_channel(sample->weight)) * forward <= 1.01);
      const auto f = bsdf.evaluate(to_prev, sample->to_next, mode);
      findings.count(Convention::bsdf_value, is_sound(f.value) && f.pdf.forward.value >= T(0) &&
                                                 f.pdf.reverse.value >= T(0) &&
                                                 std::isfinite(f.pdf.forward.value + f.pdf.reverse.value));
      findings.count(Convention::bsdf_delta, !bsdf.is_purely_delta() || (sample->is_delta && is_black(f.value)));
      if (cosine < least_cosine) continue;
      // Where shading and geometric normal disagree about the side of a direction, light leaks or is lost: no check.
      const bool is_plain = glm::dot(normal, next) * glm::dot(geometric, next) > 0.0 &&
                            glm::dot(normal, prev) * glm::dot(geometric, prev) > 0.0;
      if (!is_plain) continue;
      if (!sample->is_delta) {
        const bool is_through = glm::dot(normal, prev) * glm::dot(normal, next) < 0.0;
        ++smooth;
        if (is_through) ++through;
        if (reflects_only(bsdf)) findings.count(Convention::bsdf_reflects_only, !is_through || is_black(f.value));
        const double stated = static_cast<double>(f.pdf.forward.value);
        findings.count(Convention::bsdf_two_densities, detail::nearly(forward, stated, 0.02));
        findings.count(Convention::bsdf_two_reverse_densities,
                       detail::nearly(reverse, static_cast<double>(f.pdf.reverse.value), 0.02));
        if (stated > 0.0)
          findings.count(Convention::bsdf_weight, are_near(sample->weight, f.value, stated / cosine, 0.02));
      } else if (eta != 1.0 && glm::dot(normal, prev) * glm::dot(normal, next) < 0.0) {
        // Snell's law.
        const double sin_prev = sqrt_or_zero(1.0 - square(glm::dot(normal, prev))),
                     sin_next = sqrt_or_zero(1.0 - square(glm::dot(normal, next)));
        if (std::max(sin_prev, sin_next) > 0.1)
          findings.count(Convention::bsdf_eta, std::abs(sin_prev - eta * sin_next) < 0.02);
      }

      // The way back.
      const std::optional<B> back = bsdf_for(sample->to_next);
      if (!back) continue;
      findings.count(Convention::bsdf_albedo_of_point, are_near(back->albedo(), bsdf.albedo(), 1.0, 0.01));
      if (!sample->is_delta) {
        const auto swapped = back->evaluate(sample->to_next, to_prev, other);
        findings.count(Convention::bsdf_reverse, detail::nearly(static_cast<double>(swapped.pdf.forward.value),
                                                                static_cast<double>(f.pdf.reverse.value), 0.03));
        findings.count(Convention::bsdf_reciprocity, are_near(swapped.value, f.value, 1.0, 0.03));
        continue;
      }
      // The same lobe on the way back: among some draws, the one that returns.
      for (int attempt = 0; attempt < 32; ++attempt) {
        const auto returned = draw(*back, sample->to_next, other);
        if (!returned || !returned->is_delta || glm::length(V(returned->to_next) - prev) > 0.01) continue;
        const double back_forward = static_cast<double>(returned->pdf.forward.value);
        findings.count(Convention::bsdf_delta_reverse, detail::nearly(reverse, back_forward, 0.02));
        findings.count(Convention::bsdf_eta, detail::nearly(eta * static_cast<double>(returned->eta), 1.0, 0.01));
        // R(a → b) η² of one mode equals R(b → a) of the other, R being weight · pdf, η of the way a → b for both.
        findings.count(
            Convention::bsdf_delta_adjoint,
            back_forward > 0.0 && are_near(sample->weight, returned->weight, forward * eta * eta / back_forward, 0.03));
        break;
      }
    }
  }
  findings.count(Convention::bsdf_albedo, albedo == 0.0 || succeeded > 0);
  if (smooth >= 8 && !is_refracting) findings.count(Convention::bsdf_through, through < smooth);
  if (samples == 0) return;

  // Statistics over many draws.
  detail::DensityTest directions;
  double weights = 0.0, squares = 0.0;
  std::size_t deltas = 0;
  constexpr double known = 1.0 / (4.0 * pi<double>);
  for (std::size_t i = 0; i < samples; ++i) {
    const auto sample = draw(bsdf, to_prev, TransportMode::importance);
    if (sample) {
      const double weight = static_cast<double>(mean_channel(sample->weight));
      weights += weight;
      squares += weight * weight;
      if (sample->is_delta) ++deltas;
    }
    const auto density = [&](const Vec3<T>& to_next) {
      const double value =
          static_cast<double>(bsdf.evaluate(to_prev, to_next, TransportMode::importance).pdf.forward.value);
      return std::isfinite(value) ? value : 0.0;
    };
    const auto cosine = [&](const Vec3<T>& to_next) { return std::min(1.0, std::abs(glm::dot(normal, V(to_next)))); };
    if (sample && !sample->is_delta)
      directions.add_sample(density(sample->to_next), known, cosine(sample->to_next));
    else
      directions.add_sample(0.0, known, 0.0);
    const double u = uniform<double>(source);
    const Vec3<T> any(square_to_sphere(Vec2<double>(u, uniform<double>(source))));
    directions.add_known(density(any), known, cosine(any));
  }
  findings.judge(Convention::bsdf_distribution, directions.passes(level));
  findings.judge(Convention::bsdf_delta, bsdf.is_purely_delta() || deltas < samples);
  // Weights have no bound: ten standard errors stand for skewed distributions.
  const double n = static_cast<double>(samples), mean = weights / n;
  const double error = std::sqrt(std::max(0.0, squares / n - mean * mean) / n);
  findings.judge(Convention::bsdf_energy, mean <= 1.02 + 10.0 * error);
  findings.judge(Convention::bsdf_albedo, albedo > 0.0 || mean <= 1e-3);
}

}  // namespace gmis
