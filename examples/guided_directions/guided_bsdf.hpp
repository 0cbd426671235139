#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <type_traits>

#include "gmis/core/concepts.hpp"

namespace gmis {

/// A sampling lobe at one surface point in addition to those of its BSDF. It may depend on the side
/// of the surface that the subpath arrives from (`is_front`: that of the shading normal) and on the
/// transport mode, and on nothing else. Copied into vertices: keep it small.
///
/// - `L()`: no lobe.
/// - `is_empty()`: no lobe at this point, for either side and mode.
/// - `share(is_front, mode)`: the probability, in [0, 1), with which a direction is drawn from this
///   lobe.
/// - `sample(is_front, uv, mode)`: a unit direction. Called where `share` is positive.
/// - `pdf(is_front, to_next, mode)`: its density per steradian, which integrates to 1. Called where
///   `share` is positive.
template <class L, class T>
concept DirectionLobe = std::copyable<L> && std::default_initializable<L> &&
    requires(const L& lobe, bool is_front, Vec3<T> w, Vec2<T> uv, TransportMode mode) {
  { lobe.is_empty() } -> std::same_as<bool>;
  { lobe.share(is_front, mode) } -> std::same_as<T>;
  { lobe.sample(is_front, uv, mode) } -> std::same_as<Vec3<T>>;
  { lobe.pdf(is_front, w, mode) } -> std::same_as<T>;
};

/// A BSDF whose directions are drawn from a mixture of its own sampling and one more lobe: radiance
/// by the lobe for radiance, importance by that for importance. What it scatters is unchanged. The
/// reverse density in one mode is the forward density in the other mode, asked from the other end;
/// so both ends of a path agree on every weight.
///
/// - The density is (1 − share) × own density + share × density of the lobe, each share that of the
///   mode and the side. Where f is 0 the lobe makes no sample and adds no density.
/// - The selection probabilities of delta lobes are (1 − share) times their own.
/// - The lobe follows those of the BSDF as the last one (`BsdfWithLobes`), where the BSDF has
///   lobes.
template <Bsdf B, DirectionLobe<ScalarOf<typename B::Spectrum>> Lobe>
class Guided {
 public:
  using Spectrum = typename B::Spectrum;
  using T = ScalarOf<Spectrum>;
  using Value = BsdfValue<Spectrum>;
  using Sample = ScatterSample<Spectrum>;
  /// The most lobes of any point, the one that is added included; 0 where `B` does not offer its
  /// lobes.
  static constexpr int max_lobes = [] {
    if constexpr (BsdfWithLobes<B>)
      return static_cast<int>(B::max_lobes) + 1;
    else
      return 0;
  }();

  Guided() = default;
  /// `shading_normal` is that of the hit. `lobe` must be empty where `own` is purely delta.
  Guided(const B& own, const Vec3<T>& shading_normal, const Lobe& lobe)
      : own_(own), normal_{shading_normal}, lobe_(lobe) {}

  /// The BSDF without the lobe.
  [[nodiscard]] const B& own() const noexcept { return own_; }
  /// The lobe that is added.
  [[nodiscard]] const Lobe& lobe() const noexcept { return lobe_; }

  [[nodiscard]] Value evaluate(const Vec3<T>& to_prev, const Vec3<T>& to_next, TransportMode mode) const {
    return evaluate_mixture<true>(to_prev, to_next, mode);
  }
  /// A direction to go on in, from the mixture; the member that gmis::Bsdf requires.
  [[nodiscard]] std::optional<Sample> sample(const Vec3<T>& to_prev, T u, const Vec2<T>& uv, TransportMode mode) const {
    return sample_mixture<true>(to_prev, u, uv, mode);
  }
  /// `evaluate` without the reverse density.
  [[nodiscard]] Value evaluate_forward(const Vec3<T>& to_prev, const Vec3<T>& to_next, TransportMode mode) const {
    return evaluate_mixture<false>(to_prev, to_next, mode);
  }
  /// `sample` without the reverse density.
  [[nodiscard]] std::optional<Sample> sample_forward(const Vec3<T>& to_prev, T u, const Vec2<T>& uv,
                                                     TransportMode mode) const {
    return sample_mixture<false>(to_prev, u, uv, mode);
  }

  [[nodiscard]] bool is_purely_delta() const { return own_.is_purely_delta(); }
  [[nodiscard]] Spectrum albedo() const { return own_.albedo(); }
  [[nodiscard]] bool reflects_only() const { return gmis::reflects_only(own_); }
  [[nodiscard]] bool has_narrow_lobe() const requires BsdfWithNarrowLobes<B> { return own_.has_narrow_lobe(); }
  /// Where `B` can tell.
  [[nodiscard]] bool is_glossy() const requires requires(const B& b) {
    { b.is_glossy() } -> std::same_as<bool>;
  }
  { return own_.is_glossy(); }

  [[nodiscard]] int lobe_count() const requires BsdfWithLobes<B> {
    return static_cast<int>(own_.lobe_count()) + (lobe_.is_empty() ? 0 : 1);
  }
  /// A fixed share of ½ for the lobe that is added: its real one depends on the mode.
  [[nodiscard]] T lobe_weight(int k) const requires BsdfWithLobes<B> {
    if (is_added(k)) return T(0.5);
    return static_cast<T>(own_.lobe_weight(k)) * (lobe_.is_empty() ? T(1) : T(0.5));
  }
  [[nodiscard]] std::optional<Vec3<T>> sample_lobe(int k, const Vec3<T>& to_prev, const Vec2<T>& uv,
                                                   TransportMode mode) const requires BsdfWithLobes<B> {
    if (!is_added(k)) return own_.sample_lobe(k, to_prev, uv, mode);
    const bool is_front = is_at_front(to_prev);
    if (!(lobe_.share(is_front, mode) > T(0))) return std::nullopt;
    return lobe_.sample(is_front, uv, mode);
  }
  /// The lobe that is added depends on the mode.
  void lobe_pdfs(const Vec3<T>& to_prev, const Vec3<T>& to_next, T* pdfs,
                 TransportMode mode = TransportMode::radiance) const requires BsdfWithLobes<B> {
    own_.lobe_pdfs(to_prev, to_next, pdfs);
    if (lobe_.is_empty()) return;
    const bool is_front = is_at_front(to_prev);
    pdfs[own_.lobe_count()] = lobe_.share(is_front, mode) > T(0) ? lobe_.pdf(is_front, to_next, mode) : T(0);
  }
  [[nodiscard]] bool has_delta_lobes() const requires BsdfWithLobes<B> { return own_.has_delta_lobes(); }
  /// The lobe that is added need not cover all that the BSDF scatters to.
  [[nodiscard]] bool lobes_have_full_support() const requires BsdfWithLobes<B> {
    return lobe_.is_empty() && own_.lobes_have_full_support();
  }

 private:
  [[nodiscard]] static constexpr TransportMode other(TransportMode mode) noexcept {
    return mode == TransportMode::radiance ? TransportMode::importance : TransportMode::radiance;
  }
  /// The normal is not kept twice: with 32 bytes more a vertex, connections take a tenth longer.
  static constexpr bool knows_normal = requires(const B& b) {
    { b.shading_normal() } -> std::same_as<const Vec3<T>&>;
  };
  struct KeptNormal {
    Vec3<T> value;
  };
  struct NoNormal {
    constexpr NoNormal() = default;
    constexpr NoNormal(const Vec3<T>&) noexcept {}
  };
  [[nodiscard]] const Vec3<T>& shading_normal() const noexcept {
    if constexpr (knows_normal)
      return own_.shading_normal();
    else
      return normal_.value;
  }
  [[nodiscard]] bool is_at_front(const Vec3<T>& direction) const noexcept {
    return glm::dot(shading_normal(), direction) > T(0);
  }
  [[nodiscard]] bool is_added(int k) const { return !lobe_.is_empty() && k == static_cast<int>(own_.lobe_count()); }

  /// The density of the mixture at `to`, for a subpath that comes from `from`; `own` is that of the
  /// BSDF alone.
  [[nodiscard]] T mixed(T own, const Vec3<T>& from, const Vec3<T>& to, TransportMode mode, bool is_scattered) const {
    const bool is_front = is_at_front(from);
    const T share = lobe_.share(is_front, mode);
    if (share == T(0)) return own;
    return (T(1) - share) * own + (is_scattered ? share * lobe_.pdf(is_front, to, mode) : T(0));
  }
  template <bool needs_reverse>
  void mix(DirectionPdfs<T>& pdf, const Vec3<T>& to_prev, const Vec3<T>& to_next, TransportMode mode,
           bool is_scattered) const {
    pdf.forward.value = mixed(pdf.forward.value, to_prev, to_next, mode, is_scattered);
    if constexpr (needs_reverse)
      pdf.reverse.value = mixed(pdf.reverse.value, to_next, to_prev, other(mode), is_scattered);
  }

  template <bool needs_reverse>
  [[nodiscard]] Value evaluate_mixture(const Vec3<T>& to_prev, const Vec3<T>& to_next, TransportMode mode) const {
    Value value = evaluate_bsdf<needs_reverse>(own_, to_prev, to_next, mode);
    if (!lobe_.is_empty()) mix<needs_reverse>(value.pdf, to_prev, to_next, mode, !is_black(value.value));
    return value;
  }

  template <bool needs_reverse>
  [[nodiscard]] std::optional<Sample> sample_mixture(const Vec3<T>& to_prev, T u, const Vec2<T>& uv,
                                                     TransportMode mode) const {
    const bool is_front = is_at_front(to_prev);
    const T share = lobe_.is_empty() ? T(0) : lobe_.share(is_front, mode);
    if (u < share) {
      const Vec3<T> to_next = lobe_.sample(is_front, uv, mode);
      const Value f = evaluate_mixture<needs_reverse>(to_prev, to_next, mode);
      if (is_black(f.value) || !(f.pdf.forward.value > T(0))) return std::nullopt;
      const T cosine = std::abs(glm::dot(shading_normal(), to_next));
      return Sample{to_next, f.value * (cosine / f.pdf.forward.value), f.pdf, false, T(1)};
    }
    // u chose the BSDF's own sampling; rescaled to [0, 1), it also chooses one of the BSDF's lobes.
    const T rest = T(1) - share, below_one = T(1) - std::numeric_limits<T>::epsilon() / T(2);
    auto drawn = sample_bsdf<needs_reverse>(own_, to_prev, std::min((u - share) / rest, below_one), uv, mode);
    if (!drawn || lobe_.is_empty()) return drawn;
    if (drawn->is_delta) {
      drawn->weight = drawn->weight * (T(1) / rest);
      drawn->pdf.forward.value *= rest;
      drawn->pdf.reverse.value *= T(1) - lobe_.share(is_at_front(drawn->to_next), other(mode));
      return drawn;
    }
    const T own = drawn->pdf.forward.value;
    mix<needs_reverse>(drawn->pdf, to_prev, drawn->to_next, mode, !is_black(drawn->weight));
    if (own > T(0)) drawn->weight = drawn->weight * (own / drawn->pdf.forward.value);
    return drawn;
  }

  B own_;
  [[no_unique_address]] std::conditional_t<knows_normal, NoNormal, KeptNormal> normal_;
  Lobe lobe_;
};

}  // namespace gmis
