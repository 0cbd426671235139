#pragma once

#include <array>

#include "gmis/core/concepts.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/scheme.hpp"

namespace gmis {

template <BsdfWithLobes B, std::floating_point T, UniformSource Source, class Visit>
void sample_lobes(Scheme, const B& bsdf, const Vec3<T>& to_prev, TransportMode mode, Source& source, Visit&& visit) {
  std::array<T, static_cast<std::size_t>(B::max_lobes)> densities{};
  const int n = bsdf.lobe_count();
  for (int k = 0; k < n; ++k) {
    const auto x = bsdf.sample_lobe(k, to_prev, Vec2<T>(uniform<T>(source), uniform<T>(source)), mode);
    if (!x) continue;
    bsdf.lobe_pdfs(to_prev, *x, densities.data());
    T sum(0);
    for (int j = 0; j < n; ++j) sum += densities[static_cast<std::size_t>(j)];
    visit(*x, sum / T(n));
  }
}

}  // namespace gmis
