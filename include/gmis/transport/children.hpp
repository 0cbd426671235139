#pragma once

#include <algorithm>

#include "gmis/transport/lobe_proposals.hpp"
#include "gmis/transport/scatter.hpp"

namespace gmis {

inline constexpr int split_kinds = 17;  // by number of lobes; more count as the last

/// The kind of a vertex that numbers of children depend on: how many non-delta lobes it has, 0 when it is specular.
template <Bsdf B>
[[nodiscard]] int split_kind(const B& bsdf) noexcept {
  if constexpr (BsdfWithLobes<B>)
    return std::clamp(static_cast<int>(bsdf.lobe_count()), 0, split_kinds - 1);
  else
    return bsdf.is_purely_delta() ? 0 : 1;
}

/// Draws the first `drawn` of `planned` children at a vertex from the mixture of all its lobes, independently of each other,
/// and hands those that go on to `visit(step)`; the step's weight is divided by `planned`.
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

/// Draws the first `drawn` of `planned` children at a vertex and hands those that go on to `visit(step)`; the step's
/// weight is divided by `planned`. Whole rounds over several lobes are combined by `scheme`; otherwise the children are
/// independent, from the mixture of all lobes. Returns `drawn`.
template <Bsdf B, UniformSource Source, class Visit>
int draw_children(Scheme scheme, const ScatteringVertex<B>& at, int planned, int drawn, Source& source, Visit&& visit) {
  if constexpr (BsdfWithLobes<B>) {
    using T = ScalarOf<typename B::Spectrum>;
    const T share = T(1) / static_cast<T>(planned);
    // A round covers the lobes that have a density; what a delta lobe scatters is drawn by `sample` alone.
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
      return drawn;
    }
  }
  draw_independent_children(at, planned, drawn, source, visit);
  return drawn;
}

}  // namespace gmis
