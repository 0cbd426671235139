#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/sobol_numbers.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/result/film.hpp"
#include "gmis/result/image_error.hpp"

namespace gmis {

/// e of `ErrorLaw` as a run with `Sampler::sobol` shows it: what remains of the squared error is
/// the variance between its replications over the variance that its iterations would give if they
/// were independent of each other, both relative to the squared picture, without the pixels that
/// have the worst of the latter. Between 0 and 0.95. Nothing before each replication has two
/// iterations. `between`: `variances_of_means` of replications with the iterations of `film`.
template <Spectrum S>
GMIS_RARE [[nodiscard]] std::optional<double> measured_evenness(const Film<S>& film, std::span<const double> between) {
  constexpr std::size_t channels = Film<S>::channel_count;
  const auto iterations = static_cast<double>(film.iterations());
  if (between.empty() || iterations < 2.0 * sobol_replications) return {};
  std::vector<std::pair<double, double>> pixels(film.pixel_count());  // if independent, and between replications
  for (std::size_t p = 0; p < pixels.size(); ++p)
    for (std::size_t c = 0; c < channels; ++c) {
      const double scale = square(film.mean(p, static_cast<int>(c))) + relative_error_floor;
      pixels[p].first += film.variance_of_mean(p, static_cast<int>(c)) / scale;
      pixels[p].second += between[p * channels + c] / scale;
    }
  std::sort(pixels.begin(), pixels.end());
  double independent = 0.0, remaining = 0.0;
  for (std::size_t p = 0; p < pixels.size() - trimmed_pixels(pixels.size()); ++p)
    independent += pixels[p].first, remaining += pixels[p].second;
  if (!(independent > 0.0)) return {};
  return std::clamp((1.0 - remaining / independent) / (1.0 - std::sqrt(sobol_replications / iterations)), 0.0, 0.95);
}

}  // namespace gmis
