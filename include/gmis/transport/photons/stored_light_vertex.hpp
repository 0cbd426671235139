#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>

#include "gmis/core/concepts.hpp"
#include "gmis/transport/state/vertex.hpp"
#include "gmis/transport/weights/weight_formulas.hpp"

namespace gmis {

/// Partial sums as they are kept in memory. In general as they are.
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
/// its compact form is kept where it has one.
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
        weights_(vertex.weights),
        depth(vertex.depth),
        is_photon(vertex.is_photon),
        path(vertex.path) {}

  /// The BSDF: made anew where a compact form is kept.
  [[nodiscard]] constexpr decltype(auto) bsdf() const noexcept {
    if constexpr (BsdfWithCompactForm<Bsdf>)
      return Bsdf(bsdf_, point);
    else
      return (bsdf_);
  }
  [[nodiscard]] constexpr decltype(auto) weights() const noexcept { return weights_.sums(); }

 private:
  [[nodiscard]] static constexpr decltype(auto) kept(const Bsdf& bsdf) noexcept {
    if constexpr (BsdfWithCompactForm<Bsdf>)
      return bsdf.compact();
    else
      return (bsdf);
  }
  std::remove_cvref_t<decltype(kept(std::declval<const Bsdf&>()))> bsdf_;

 public:
  // As in `LightVertex`.
  SurfacePoint<T> point;
  Vec3<T> to_prev;
  S throughput;

 private:
  KeptSums<typename Recursion::LightPartial> weights_;

 public:
  std::int16_t depth;
  bool is_photon;
  HalfPath path;
};

}  // namespace gmis
