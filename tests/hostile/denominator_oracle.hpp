#pragma once

#include <cstddef>
#include <span>

#include "gmis/mis/scheme.hpp"

namespace hostile {

/// φ of sample n in long double, from the definitions W1–W5 by way of the scheme: what the whole
/// round drew is known by then. `density_of(k)` is the density of proposal k, one of `count`, at
/// the sample.
template <class DensityOf>
[[nodiscard]] long double denominator(gmis::Scheme scheme, std::size_t count, std::span<const std::size_t> drawn,
                                      std::size_t n, const DensityOf& density_of) {
  long double sum = 0.0L;
  switch (scheme) {
    case gmis::Scheme::R1:
    case gmis::Scheme::N1:
      return density_of(drawn[n]);
    case gmis::Scheme::R2:
      for (const std::size_t k : drawn) sum += density_of(k);
      return sum / static_cast<long double>(count);
    case gmis::Scheme::N2:
      for (const std::size_t k : drawn.subspan(n)) sum += density_of(k);
      return sum / static_cast<long double>(count - n);
    default:
      for (std::size_t k = 0; k < count; ++k) sum += density_of(k);
      return sum / static_cast<long double>(count);
  }
}

}  // namespace hostile
