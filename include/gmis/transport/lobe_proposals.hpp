#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "gmis/core/concepts.hpp"
#include "gmis/mis/round.hpp"

namespace gmis {

/// The lobes of a BSDF at one vertex as the N proposals of a MIS round; a sample is a direction, its density per steradian.
template <BsdfWithLobes B>
class LobeProposals {
 public:
  using Density = ScalarOf<typename B::Spectrum>;
  using Value = Vec3<Density>;
  static constexpr std::size_t capacity = static_cast<std::size_t>(B::max_lobes);

  LobeProposals(const B& bsdf, const Value& to_prev, TransportMode mode)
      : bsdf_(bsdf), to_prev_(to_prev), mode_(mode) {}

  [[nodiscard]] std::size_t size() const noexcept { return static_cast<std::size_t>(bsdf_.lobe_count()); }
  [[nodiscard]] std::optional<Value> sample(std::size_t lobe, UniformSource auto& source) const {
    const Density u = uniform<Density>(source);
    return bsdf_.sample_lobe(static_cast<int>(lobe), to_prev_, {u, uniform<Density>(source)}, mode_);
  }
  void pdfs(const Value& to_next, std::span<Density> out) const { bsdf_.lobe_pdfs(to_prev_, to_next, out.data()); }

 private:
  const B& bsdf_;
  Value to_prev_;
  TransportMode mode_;
};

/// One round over the lobes of `bsdf`, one sample a lobe in the mean, each handed to `visit(to_next, denominator)`. Lobes that
/// cover f only together are combined by R3 or N3 whatever was asked for: the other schemes would lose energy.
template <BsdfWithLobes B, std::floating_point T, UniformSource Source, class Visit>
RoundCounts sample_lobes(Scheme scheme, const B& bsdf, const Vec3<T>& to_prev, TransportMode mode, Source& source,
                         Visit&& visit) {
  if (needs_full_support(scheme) && !bsdf.lobes_have_full_support()) scheme = safe_for_partial_support(scheme);
  const LobeProposals<B> lobes(bsdf, to_prev, mode);
  return dispatch(scheme, [&](auto fixed) {
    return sample_round<fixed.value>(
        lobes, source, [&](const Vec3<T>& to_next, T denominator, std::size_t) { visit(to_next, denominator); });
  });
}

}  // namespace gmis
