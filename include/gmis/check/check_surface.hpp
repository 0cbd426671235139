#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <vector>

#include "gmis/check/compare.hpp"
#include "gmis/check/findings.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"

namespace gmis {

namespace detail {

/// True where the mirrored direction of `to_prev` lies well on its side of both normals, so that a
/// mirror and glass scatter what their albedo says. Elsewhere they may rightly scatter nothing.
[[nodiscard]] inline bool has_mirrored_side(const Vec3<double>& shading_normal, const Vec3<double>& geometric_normal,
                                            const Vec3<double>& to_prev) noexcept {
  const double side = glm::dot(geometric_normal, to_prev);
  return side * glm::dot(shading_normal, to_prev) > 0.0 &&
         std::copysign(1.0, side) * glm::dot(geometric_normal, reflect_about(to_prev, shading_normal)) > 0.05;
}

}  // namespace detail

/// Checks the BSDF at one point of a surface in both modes of transport, pair of directions by pair
/// of directions.
///
/// `BsdfFor`: makes the BSDF of that point as a ray that arrives from a direction finds it, in a
/// `std::optional`, since the engine evaluates a BSDF only with the `to_prev` of the ray that made
/// its hit.
template <class BsdfFor, std::floating_point T, UniformSource Source>
class SurfaceCheck {
 public:
  /// The BSDF of the point.
  using B = typename std::remove_cvref_t<std::invoke_result_t<const BsdfFor&, const Vec3<T>&>>::value_type;
  using S = typename B::Spectrum;

  /// `findings` take the cases.
  SurfaceCheck(const BsdfFor& bsdf_for, const SurfacePoint<T>& point, const Vec3<T>& to_prev, Source& source,
               Findings& findings)
      : bsdf_for_(bsdf_for),
        point_(point),
        to_prev_(to_prev),
        normal_(point.shading_normal),
        geometric_(point.geometric_normal),
        prev_(to_prev),
        source_(source),
        findings_(findings) {}

  /// Tries `pairs` samples in each mode.
  void run(int pairs) {
    const std::optional<B> found = bsdf_for_(to_prev_);
    if (!found || std::abs(glm::dot(normal_, prev_)) < least_cosine) return;
    const B& bsdf = *found;
    const double albedo = static_cast<double>(max_channel(bsdf.albedo()));
    findings_.count(Convention::bsdf_albedo, is_sound(bsdf.albedo()) && albedo <= 1.0 + 1e-3, albedo, 1.0);
    for (const TransportMode mode : {TransportMode::radiance, TransportMode::importance}) {
      mode_ = mode;
      for (int i = 0; i < pairs; ++i) {
        if (reflects_only(bsdf)) check_beyond(bsdf);
        check_leak(bsdf);
        if (const auto sample = draw(bsdf, to_prev_, mode)) check_sample(bsdf, *sample);
      }
    }
    findings_.look_along(V(0));
    if (pairs >= 8 && detail::has_mirrored_side(normal_, geometric_, prev_))
      findings_.count(Convention::bsdf_albedo, albedo == 0.0 || succeeded_ > 0, albedo, 0.0);
    // A surface has few delta lobes, and each of them one direction.
    if (pairs >= 8) findings_.judge(Convention::bsdf_delta, delta_directions_.size() <= 4);
    if (smooth_ >= 8 && !is_refracting_) findings_.count(Convention::bsdf_through, through_ < smooth_);
  }

 private:
  using V = Vec3<double>;
  static constexpr double least_cosine = 0.02;  // below it rounding of directions rules
  static constexpr double least_disagreement = 0.005;

  [[nodiscard]] static bool is_sound(const S& s) { return is_finite(s) && min_channel(s) >= T(0); }
  [[nodiscard]] static bool is_sound(const BsdfValue<S>& f) {
    return is_sound(f.value) && f.pdf.forward.value >= T(0) && f.pdf.reverse.value >= T(0) &&
           std::isfinite(f.pdf.forward.value + f.pdf.reverse.value);
  }
  [[nodiscard]] static double number(SolidAnglePdf<T> pdf) { return static_cast<double>(pdf.value); }
  [[nodiscard]] auto draw(const B& from, const Vec3<T>& to_prev, TransportMode mode) {
    const T u = uniform<T>(source_), v = uniform<T>(source_);
    const Vec2<T> uv{v, uniform<T>(source_)};
    const auto sample = from.sample(to_prev, u, uv, mode);
    if constexpr (requires { from.sample_forward(to_prev, u, uv, mode); })
      check_forward_sample(sample, from.sample_forward(to_prev, u, uv, mode));
    return sample;
  }
  /// `sample` and `sample_forward` with the same numbers.
  void check_forward_sample(const std::optional<ScatterSample<S>>& sample,
                            const std::optional<ScatterSample<S>>& other) {
    if (!sample || !other) return findings_.count(Convention::bsdf_forward, !sample && !other);
    findings_.count(Convention::bsdf_forward, sample->is_delta == other->is_delta);
    const double cosine = glm::dot(V(sample->to_next), V(other->to_next));
    findings_.count(Convention::bsdf_forward, cosine > 0.9999, cosine, 1.0);
    compare(Convention::bsdf_forward, number(other->pdf.forward), number(sample->pdf.forward), 0.01);
    compare_channels(Convention::bsdf_forward, other->weight, sample->weight, 1.0, 0.01);
  }
  [[nodiscard]] TransportMode other_mode() const {
    return mode_ == TransportMode::radiance ? TransportMode::importance : TransportMode::radiance;
  }
  void compare(Convention convention, double found, double wanted, double tolerance) {
    detail::compare(findings_, convention, found, wanted, tolerance);
  }
  void compare_channels(Convention convention, const S& found, const S& wanted, double factor, double tolerance) {
    detail::compare_channels(findings_, convention, found, wanted, factor, tolerance);
  }

  /// A BSDF that says it reflects only must be zero on the other side.
  void check_beyond(const B& bsdf) {
    const double u = uniform<double>(source_);
    V beyond = square_to_sphere(Vec2<double>(u, uniform<double>(source_)));
    if (glm::dot(normal_, beyond) * glm::dot(normal_, prev_) > 0.0) beyond = -beyond;
    if (std::abs(glm::dot(normal_, beyond)) < least_cosine) return;
    findings_.look_along(beyond);
    findings_.count(Convention::bsdf_reflects_only, is_black(bsdf.evaluate(to_prev_, Vec3<T>(beyond), mode_).value));
  }

  /// Positive where both normals put the direction on one side, negative where light would leak;
  /// small where rounding rules.
  [[nodiscard]] double agreement(const V& direction) const {
    const double shading = glm::dot(normal_, direction), geometric = glm::dot(geometric_, direction);
    return std::copysign(std::min(std::abs(shading), std::abs(geometric)), shading * geometric);
  }
  /// `evaluate` for a direction between the planes of the two normals.
  void check_leak(const B& bsdf) {
    const V across = normal_ - geometric_;
    if (glm::length(across) < 4.0 * least_disagreement || agreement(prev_) < least_disagreement) return;
    const V first = glm::normalize(across), second = glm::cross(glm::normalize(normal_ + geometric_), first);
    const double turn = (uniform<double>(source_) - 0.5) * 2.0 * pi<double> / 3.0;
    for (const double side : {-1.0, 1.0}) {
      const V between = side * (std::cos(turn) * first + std::sin(turn) * second);
      findings_.look_along(between);
      findings_.count(Convention::bsdf_leak, is_black(bsdf.evaluate(to_prev_, Vec3<T>(between), mode_).value));
    }
  }

  void check_sample(const B& bsdf, const ScatterSample<S>& sample) {
    ++succeeded_;
    const V next(sample.to_next);
    findings_.look_along(next);
    const double forward = number(sample.pdf.forward), reverse = number(sample.pdf.reverse);
    const double cosine = std::abs(glm::dot(normal_, next)), eta = static_cast<double>(sample.eta);
    findings_.count(Convention::bsdf_unit, detail::nearly(glm::length(next), 1.0, 1e-3), glm::length(next), 1.0);
    findings_.count(Convention::bsdf_value,
                    is_sound(sample.weight) && forward >= 0.0 && reverse >= 0.0 && std::isfinite(forward + reverse));
    is_refracting_ = is_refracting_ || eta != 1.0;
    // One delta lobe cannot scatter more than all light.
    if (mode_ == TransportMode::importance && sample.is_delta && eta != 1.0) {
      const double share = static_cast<double>(max_channel(sample.weight)) * forward;
      findings_.count(Convention::bsdf_energy, share <= 1.01, share, 1.0);
    }
    const BsdfValue<S> f = bsdf.evaluate(to_prev_, sample.to_next, mode_);
    findings_.count(Convention::bsdf_value, is_sound(f));
    findings_.count(Convention::bsdf_delta, !bsdf.is_purely_delta() || (sample.is_delta && is_black(f.value)));
    if (sample.is_delta && std::none_of(delta_directions_.begin(), delta_directions_.end(),
                                        [&](const V& other) { return glm::length(other - next) < 0.01; }))
      delta_directions_.push_back(next);
    const double least_agreement = std::min(agreement(prev_), agreement(next));
    if (std::abs(least_agreement) > least_disagreement) findings_.count(Convention::bsdf_leak, least_agreement > 0.0);
    if (cosine < least_cosine || least_agreement <= 0.0) return;
    const bool is_through = glm::dot(normal_, prev_) * glm::dot(normal_, next) < 0.0;
    bool has_snell = false;
    if (!sample.is_delta)
      check_smooth(bsdf, sample, f, is_through);
    else if (eta != 1.0 && is_through)
      has_snell = check_snell(next, eta);

    const std::optional<B> back = bsdf_for_(sample.to_next);
    if (!back) return;
    // A texture changes that much by the rounding of the position.
    compare_channels(Convention::bsdf_albedo_of_point, back->albedo(), bsdf.albedo(), 1.0, 0.05);
    if (!sample.is_delta)
      check_way_back(*back, sample, f);
    else
      check_delta_way_back(*back, sample, has_snell);
  }

  /// A sample of a smooth lobe against `evaluate`.
  void check_smooth(const B& bsdf, const ScatterSample<S>& sample, const BsdfValue<S>& f, bool is_through) {
    ++smooth_;
    if (is_through) ++through_;
    if (reflects_only(bsdf)) findings_.count(Convention::bsdf_reflects_only, !is_through || is_black(f.value));
    const double forward = number(sample.pdf.forward), stated = number(f.pdf.forward);
    compare(Convention::bsdf_two_densities, forward, stated, 0.02);
    compare(Convention::bsdf_two_reverse_densities, number(sample.pdf.reverse), number(f.pdf.reverse), 0.02);
    check_world_space(bsdf, sample, f);
    check_optional_members(bsdf, sample, f);
    const double cosine = std::abs(glm::dot(normal_, V(sample.to_next)));
    if (stated > 0.0) compare_channels(Convention::bsdf_weight, sample.weight, f.value, cosine / stated, 0.02);
  }
  /// A direction that fits density or weight only as coordinates in the frame of the surface.
  void check_world_space(const B& bsdf, const ScatterSample<S>& sample, const BsdfValue<S>& f) {
    const V next(sample.to_next);
    const double forward = number(sample.pdf.forward), stated = number(f.pdf.forward);
    const double cosine = std::abs(glm::dot(normal_, next));
    const double weight = static_cast<double>(max_channel(sample.weight)) * forward,
                 value = static_cast<double>(max_channel(f.value));
    bool is_local = false;
    if (forward > 0.0 && !detail::nearly(forward, stated, 0.02)) {
      const Vec3<T> turned = Frame<T>::around(point_.shading_normal).to_world(sample.to_next);
      is_local = detail::nearly(forward, number(bsdf.evaluate(to_prev_, turned, mode_).pdf.forward), 0.002);
    } else if (weight > 0.0 && !detail::nearly(weight, value * cosine, 0.02)) {
      for (int axis = 0; axis < 3; ++axis)
        is_local = is_local || detail::nearly(weight, value * std::abs(next[axis]), 0.002);
    }
    findings_.count(Convention::bsdf_world, !is_local);
  }
  void check_optional_members(const B& bsdf, const ScatterSample<S>& sample, const BsdfValue<S>& f) {
    if constexpr (requires { bsdf.evaluate_forward(to_prev_, sample.to_next, mode_); }) {
      const BsdfValue<S> other = bsdf.evaluate_forward(to_prev_, sample.to_next, mode_);
      compare(Convention::bsdf_forward, number(other.pdf.forward), number(f.pdf.forward), 0.01);
      compare_channels(Convention::bsdf_forward, other.value, f.value, 1.0, 0.01);
    }
    if constexpr (BsdfWithCompactForm<B>) {
      SurfacePoint<T> stored = point_;
      stored.tag = ~point_.tag;
      const BsdfValue<S> other = B(bsdf.compact(), stored).evaluate(to_prev_, sample.to_next, mode_);
      compare(Convention::bsdf_compact, number(other.pdf.forward), number(f.pdf.forward), 0.03);
      compare_channels(Convention::bsdf_compact, other.value, f.value, 1.0, 0.03);
    }
  }
  /// False where the directions are too near to the normal to say anything.
  bool check_snell(const V& next, double eta) {
    const double sin_prev = sqrt_or_zero(1.0 - square(glm::dot(normal_, prev_))),
                 sin_next = sqrt_or_zero(1.0 - square(glm::dot(normal_, next)));
    if (std::max(sin_prev, sin_next) <= 0.1) return false;
    findings_.count(Convention::bsdf_eta, std::abs(sin_prev - eta * sin_next) < 0.02, eta, sin_prev / sin_next);
    return true;
  }

  void check_way_back(const B& back, const ScatterSample<S>& sample, const BsdfValue<S>& f) {
    const BsdfValue<S> swapped = back.evaluate(sample.to_next, to_prev_, other_mode());
    compare(Convention::bsdf_reverse, number(f.pdf.reverse), number(swapped.pdf.forward), 0.03);
    compare_channels(Convention::bsdf_reciprocity, f.value, swapped.value, 1.0, 0.03);
    if (sample.eta != T(1)) return;
    // A cosine left in f shows as a ratio of cosines: between the two directions, or between the
    // modes where `evaluate` swaps its arguments for one of them.
    const double cos_prev = std::abs(glm::dot(normal_, prev_)),
                 cos_next = std::abs(glm::dot(normal_, V(sample.to_next)));
    if (detail::nearly(cos_prev, cos_next, 0.03)) return;
    const BsdfValue<S> there = bsdf_of_mode(other_mode(), sample.to_next);
    const auto differ_by_cosines = [&](const S& a, const S& b) {
      const double x = static_cast<double>(max_channel(a)), y = static_cast<double>(max_channel(b));
      return x > 0.0 && y > 0.0 &&
             (detail::nearly(x * cos_prev, y * cos_next, 0.005) || detail::nearly(x * cos_next, y * cos_prev, 0.005));
    };
    // The modes may differ by a ratio of cosines without a mistake, where the density of `sample`
    // is symmetric: the weights of radiance are the albedo then, and fit f.
    const double weight = static_cast<double>(max_channel(sample.weight)), pdf = number(f.pdf.forward);
    const bool is_unlike = mode_ == TransportMode::radiance && differ_by_cosines(f.value, there.value);
    const bool is_sound_weight =
        detail::nearly(weight, static_cast<double>(max_channel(back.albedo())), 0.03) &&
        detail::nearly(weight * pdf, static_cast<double>(max_channel(f.value)) * cos_next, 0.03);
    const bool has_cosine = differ_by_cosines(f.value, swapped.value) || (is_unlike && !is_sound_weight);
    findings_.count(Convention::bsdf_cosine, !has_cosine, static_cast<double>(max_channel(f.value)),
                    static_cast<double>(max_channel(f.value)) / cos_next);
  }
  [[nodiscard]] BsdfValue<S> bsdf_of_mode(TransportMode mode, const Vec3<T>& to_next) const {
    const std::optional<B> bsdf = bsdf_for_(to_prev_);
    return bsdf ? bsdf->evaluate(to_prev_, to_next, mode) : BsdfValue<S>{};
  }
  /// The same lobe on the way back: among some draws, the one that returns.
  void check_delta_way_back(const B& back, const ScatterSample<S>& sample, bool has_snell) {
    const double forward = number(sample.pdf.forward), eta = static_cast<double>(sample.eta);
    for (int attempt = 0; attempt < 32; ++attempt) {
      const auto returned = draw(back, sample.to_next, other_mode());
      if (!returned || !returned->is_delta || glm::length(V(returned->to_next) - prev_) > 0.01) continue;
      const double back_forward = number(returned->pdf.forward);
      compare(Convention::bsdf_delta_reverse, number(sample.pdf.reverse), back_forward, 0.02);
      const double product = eta * static_cast<double>(returned->eta);
      if (!has_snell && (eta != 1.0 || returned->eta != T(1))) compare(Convention::bsdf_eta, product, 1.0, 0.01);
      // R(a → b) η² of one mode equals R(b → a) of the other, R being weight · pdf, η of the way a
      // → b for both.
      if (back_forward > 0.0)
        compare_channels(Convention::bsdf_delta_adjoint, sample.weight, returned->weight,
                         back_forward / (forward * eta * eta), 0.03);
      else
        findings_.count(Convention::bsdf_delta_adjoint, false, back_forward, number(sample.pdf.reverse));
      return;
    }
  }

  const BsdfFor& bsdf_for_;
  const SurfacePoint<T>& point_;
  Vec3<T> to_prev_;
  V normal_, geometric_, prev_;
  Source& source_;
  Findings& findings_;
  TransportMode mode_ = TransportMode::radiance;
  std::vector<V> delta_directions_;  // that differ
  std::size_t through_ = 0, smooth_ = 0, succeeded_ = 0;
  bool is_refracting_ = false;
};

}  // namespace gmis
