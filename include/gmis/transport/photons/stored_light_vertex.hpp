#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "gmis/core/concepts.hpp"
#include "gmis/core/transmittance.hpp"
#include "gmis/transport/state/vertex.hpp"
#include "gmis/transport/weights/weight_formulas.hpp"

namespace gmis {

/// Partial sums as they are kept in memory: unchanged, except in the specialisation below.
template <class Partial>
class KeptSums {
 public:
  explicit constexpr KeptSums(const Partial& sums) noexcept : sums_(sums) {}
  [[nodiscard]] constexpr const Partial& sums() const noexcept { return sums_; }

 private:
  Partial sums_;
};

/// Two numbers with exponents, in 12 bytes instead of 16: no product of 256 densities has an
/// exponent beyond 16 bits.
template <>
class KeptSums<PartialWeights<float>> {
 public:
  explicit constexpr KeptSums(const PartialWeights<float>& sums) noexcept
      : shared_(sums.shared.mantissa()),
        chain_(sums.chain.mantissa()),
        shared_exponent_(static_cast<std::int16_t>(sums.shared.exponent())),
        chain_exponent_(static_cast<std::int16_t>(sums.chain.exponent())) {}
  [[nodiscard]] constexpr PartialWeights<float> sums() const noexcept {
    return {Extended<float>::of(shared_, shared_exponent_), Extended<float>::of(chain_, chain_exponent_)};
  }

 private:
  float shared_, chain_;
  std::int16_t shared_exponent_, chain_exponent_;
};

/// The part of a light vertex that connections and merging need: 96 bytes with the built-in
/// materials and `float`. The numbers of its children are functions of its BSDF; of the BSDF only
/// its compact form is kept where it has one. The tag of its point is kept where
/// `transmittance(ray, from, to)` may read it; else its place holds other data.
template <Scene Sc, class Recursion>
class StoredLightVertex {
 public:
  using Bsdf = typename Sc::Bsdf;
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;

  explicit constexpr StoredLightVertex(const LightVertex<Sc, Recursion>& vertex)
      : bsdf_(kept(vertex.bsdf)),
        point(vertex.point),
        to_prev(vertex.to_prev),
        throughput(vertex.throughput),
        weights_(vertex.weights) {
    const Rest rest{static_cast<unsigned>(vertex.depth) & 0x1ffU, vertex.is_photon ? 1U : 0U,
                    static_cast<unsigned>(vertex.path.number()) & 0x3fU, vertex.light_group};
    if constexpr (keeps_tag)
      rest_ = rest;
    else
      point.tag = std::bit_cast<std::uint32_t>(rest);
  }

  /// The BSDF: made anew where a compact form is kept.
  [[nodiscard]] constexpr decltype(auto) bsdf() const noexcept {
    if constexpr (BsdfWithCompactForm<Bsdf>)
      return Bsdf(bsdf_, point);
    else
      return (bsdf_);
  }
  [[nodiscard]] constexpr decltype(auto) weights() const noexcept { return weights_.sums(); }
  // As the members of `LightVertex`.
  [[nodiscard]] constexpr std::int16_t depth() const noexcept { return static_cast<std::int16_t>(rest().depth); }
  [[nodiscard]] constexpr bool is_photon() const noexcept { return rest().is_photon != 0; }
  [[nodiscard]] constexpr HalfPath path() const noexcept { return HalfPath::with_number(rest().path); }
  [[nodiscard]] constexpr std::uint16_t light_group() const noexcept {
    return static_cast<std::uint16_t>(rest().light_group);
  }

 private:
  static constexpr bool keeps_tag = SceneWithAbsorptionBetween<Sc>;
  struct Rest {
    std::uint32_t depth : 9;  // at most 256
    std::uint32_t is_photon : 1;
    std::uint32_t path : 6;  // HalfPath::number()
    std::uint32_t light_group : 16;
  };
  static_assert(HalfPath::state_count <= 64);
  struct Nothing {};
  [[nodiscard]] constexpr Rest rest() const noexcept {
    if constexpr (keeps_tag)
      return rest_;
    else
      return std::bit_cast<Rest>(point.tag);
  }
  [[nodiscard]] static constexpr decltype(auto) kept(const Bsdf& bsdf) noexcept {
    if constexpr (BsdfWithCompactForm<Bsdf>)
      return bsdf.compact();
    else
      return (bsdf);
  }
  std::remove_cvref_t<decltype(kept(std::declval<const Bsdf&>()))> bsdf_;

 public:
  SurfacePoint<T> point;  ///< its tag means something only where it is kept
  // As in `LightVertex`.
  Vec3<T> to_prev;
  S throughput;

 private:
  KeptSums<typename Recursion::LightPartial> weights_;
  [[no_unique_address]] std::conditional_t<keeps_tag, Rest, Nothing> rest_;
};

}  // namespace gmis
