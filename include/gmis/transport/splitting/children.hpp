#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>

#include "gmis/mis/round.hpp"
#include "gmis/transport/state/scatter.hpp"

namespace gmis {

/// Kinds of vertices: 0 to 15 non-delta lobes, and 16 or more.
inline constexpr int split_kinds = 17;

/// The kind of a vertex, which the number of its children depends on: the number of its non-delta
/// lobes, at most `split_kinds` − 1. A specular vertex has the kind 0; a BSDF that offers no lobes
/// counts as one lobe.
template <Bsdf B>
[[nodiscard]] constexpr int split_kind(const B& bsdf) noexcept {
  if constexpr (BsdfWithLobes<B>)
    return std::clamp(static_cast<int>(bsdf.lobe_count()), 0, split_kinds - 1);
  else
    return bsdf.is_purely_delta() ? 0 : 1;
}

/// The N non-delta lobes of a BSDF at one vertex as the proposals of a MIS round. A sample is a
/// unit direction `to_next`; its density is per steradian, without the cosine. `sample` returns
/// nothing when the lobe fails.
template <BsdfWithLobes B>
class LobeProposals {
 public:
  using Density = ScalarOf<typename B::Spectrum>;
  using Value = Vec3<Density>;
  static constexpr std::size_t capacity = static_cast<std::size_t>(B::max_lobes);

  /// `bsdf` must outlive this. `to_prev` is a unit direction away from the surface.
  LobeProposals(const B& bsdf, const Value& to_prev, TransportMode mode)
      : bsdf_(bsdf), to_prev_(to_prev), mode_(mode) {}

  /// N: number of non-delta lobes here.
  [[nodiscard]] constexpr std::size_t size() const noexcept { return static_cast<std::size_t>(bsdf_.lobe_count()); }
  /// Draws a unit direction from one lobe; nothing when the lobe fails.
  [[nodiscard]] std::optional<Value> sample(std::size_t lobe, UniformSource auto& source) const {
    const Density u = uniform<Density>(source);
    return bsdf_.sample_lobe(static_cast<int>(lobe), to_prev_, {u, uniform<Density>(source)}, mode_);
  }
  void pdfs(const Value& to_next, std::span<Density> out) const {
    if constexpr (requires { bsdf_.lobe_pdfs(to_prev_, to_next, out.data(), mode_); })
      bsdf_.lobe_pdfs(to_prev_, to_next, out.data(), mode_);
    else
      bsdf_.lobe_pdfs(to_prev_, to_next, out.data());
  }

 private:
  const B& bsdf_;
  Value to_prev_;
  TransportMode mode_;
};

/// Draws one round of N samples over the N lobes of `bsdf` and calls `visit(to_next, denominator)`
/// for each. The denominator is φ_n, per steradian [Elvira W1–W5]. When a single lobe does not
/// cover the support of f, R3 or N3 replaces the requested scheme, because R1, R2, N1 and N2 would
/// lose energy.
template <BsdfWithLobes B, std::floating_point T, UniformSource Source, class Visit>
void sample_lobes(Scheme scheme, const B& bsdf, const Vec3<T>& to_prev, TransportMode mode, Source& source,
                  Visit&& visit) {
  if (needs_full_support(scheme) && !bsdf.lobes_have_full_support()) scheme = safe_for_partial_support(scheme);
  const LobeProposals<B> lobes(bsdf, to_prev, mode);
  dispatch(scheme, [&](auto fixed) {
    sample_round<fixed.value>(lobes, source,
                              [&](const Vec3<T>& to_next, T denominator, std::size_t) { visit(to_next, denominator); });
  });
}

/// Draws the first `drawn` of `planned` children of a vertex, independently of each other, from the
/// mixture of all lobes (delta lobes included). Calls `visit(step)` for each child that survives
/// Russian roulette and has a direction. The weight of each step is divided by `planned`.
template <Bsdf B, UniformSource Source, class Visit>
void draw_independent_children(const ScatteringVertex<B>& at, int planned, int drawn, Source& source, Visit&& visit) {
  using T = ScalarOf<typename B::Spectrum>;
  const T share = T(1) / static_cast<T>(planned);
  for (int i = 0; i < drawn; ++i)
    if (auto step = scatter(at, source)) {
      if (planned > 1) step->weight = step->weight * share;
      visit(*step);
    }
}

/// Draws the first `drawn` of `planned` children of a vertex. Calls `visit(step)` for each child
/// that survives Russian roulette and has a non-zero weight; the weight of each step is divided by
/// `planned`.
///
/// With N > 1 non-delta lobes, no delta lobe and `planned` a multiple of N, the children come in
/// rounds of one sample per lobe, combined by `scheme`. Otherwise they are drawn independently from
/// the mixture of all lobes.
template <Bsdf B, UniformSource Source, class Visit>
void draw_children(Scheme scheme, const ScatteringVertex<B>& at, int planned, int drawn, Source& source,
                   Visit&& visit) {
  if constexpr (BsdfWithLobes<B>) {
    using T = ScalarOf<typename B::Spectrum>;
    const T share = T(1) / static_cast<T>(planned);
    // A round covers only lobes that have a density. Directions of delta lobes come from `sample`
    // alone.
    const int lobes = at.bsdf.lobe_count();
    if (lobes > 1 && planned > 1 && planned % lobes == 0 && !at.bsdf.has_delta_lobes()) {
      int left = drawn;
      for (int round = 0; round < planned / lobes; ++round)
        sample_lobes(scheme, at.bsdf, at.to_prev, at.mode, source, [&](const Vec3<T>& to_next, T denominator) {
          const T u_survival = uniform<T>(source);
          if (left-- <= 0 || u_survival >= at.survival) return;
          const auto f = at.bsdf.evaluate(at.to_prev, to_next, at.mode);
          const T cosine = scattering_cosine(at.point, at.to_prev, to_next, at.mode);
          const auto weight = f.value * (cosine * share / (denominator * at.survival));
          if (is_black(weight)) return;
          visit(Step<typename B::Spectrum>{to_next, weight, at.children.forward * f.pdf.forward.value,
                                           at.children.reverse * f.pdf.reverse.value, false});
        });
      return;
    }
  }
  draw_independent_children(at, planned, drawn, source, visit);
}

}  // namespace gmis
