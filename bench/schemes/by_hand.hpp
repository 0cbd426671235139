#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "gmis/mis/scheme.hpp"

/// One round of each scheme as one would write it without the library.
namespace bench {

/// The memory that a loop by hand keeps between rounds.
struct Scratch {
  std::vector<std::uint32_t> order;
  std::vector<double> multiplicity;
  explicit Scratch(std::size_t n) : order(n), multiplicity(n) {}
};

/// (1/N) Σ f/φ of one round. `checked`: with the library's checks, the density of a sample under
/// its own proposal and the denominator, what fails being counted in `unusable`; else with none.
template <gmis::Scheme scheme, bool checked, class P, class F, class Source>
[[gnu::always_inline]] inline double round_by_hand(std::span<const P> proposals, const F& f, Source& source,
                                                   Scratch& scratch, std::uint64_t& unusable) {
  using gmis::Scheme;
  constexpr bool at_random = scheme == Scheme::R1 || scheme == Scheme::R3;
  const std::size_t n = proposals.size();
  const double count = static_cast<double>(n);
  double sum = 0.0;
  const auto add = [&](double x, double own, double denominator) {
    if constexpr (checked) {
      if (own > 0.0 && denominator > 0.0 && denominator <= std::numeric_limits<double>::max())
        sum += f(x) / denominator;
      else
        ++unusable;
    } else {
      sum += f(x) / denominator;
    }
  };
  const auto draw = [&](std::size_t of) {
    return of == 1 ? 0U : gmis::uniform_index(source, static_cast<std::uint32_t>(of));
  };

  if constexpr (scheme == Scheme::R2) {
    for (double& times : scratch.multiplicity) times = 0.0;
    for (std::uint32_t& index : scratch.order) scratch.multiplicity[index = draw(n)] += 1.0;
  }
  if constexpr (scheme == Scheme::N2)
    for (std::size_t i = 0; i < n; ++i) scratch.order[i] = static_cast<std::uint32_t>(i);

  for (std::size_t i = 0; i < n; ++i) {
    std::size_t index = i;
    if constexpr (at_random) index = draw(n);
    if constexpr (scheme == Scheme::R2) index = scratch.order[i];
    if constexpr (scheme == Scheme::N2) {
      std::swap(scratch.order[i], scratch.order[i + draw(n - i)]);
      index = scratch.order[i];
    }
    const double x = proposals[index].sample(source);
    if constexpr (scheme == Scheme::R1 || scheme == Scheme::N1) {
      const double own = proposals[index].pdf(x);
      add(x, own, own);
    } else if constexpr (scheme == Scheme::N2) {
      const double own = proposals[index].pdf(x);
      double mixture = own;
      for (std::size_t m = i + 1; m < n; ++m) mixture += proposals[scratch.order[m]].pdf(x);
      add(x, own, mixture / static_cast<double>(n - i));
    } else {
      double own = 1.0, mixture = 0.0;
      for (std::size_t k = 0; k < n; ++k) {
        double times = 1.0;
        if constexpr (scheme == Scheme::R2) {
          times = scratch.multiplicity[k];
          if (times == 0.0) continue;
        }
        const double density = proposals[k].pdf(x);
        if constexpr (checked)
          if (k == index) own = density;
        mixture += scheme == Scheme::R2 ? times * density : density;
      }
      add(x, own, mixture / count);
    }
  }
  return sum / count;
}

}  // namespace bench
