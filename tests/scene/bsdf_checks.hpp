#pragma once

#include <array>
#include <cstddef>

#include "gmis/core/density_tests.hpp"
#include "support/catch.hpp"

/// \file
/// Checks of a BSDF at one point, for light from `to_prev`, at the level of one χ² test.

namespace scene_test {

[[nodiscard]] inline gmis::CheckSettings bsdf_settings(double precision) {
  return {.samples = 40'000, .bins = 200, .precision = precision};
}

/// Errors that rounding and quadrature may make.
struct BsdfTolerance {
  double reverse;    ///< of reverse densities and of reciprocity
  double sample;     ///< of a sample against `evaluate`
  double reflected;  ///< of the reflected share above 1
};

/// The sampler makes the density that it states; f is reciprocal and makes no energy.
template <class B, class V>
gmis::BsdfCheck check_at_point(const B& bsdf, const V& normal, const V& to_prev, gmis::Philox& source, double precision,
                               double level, const BsdfTolerance& tolerance) {
  const auto check = gmis::check_bsdf(bsdf, normal, to_prev, source, bsdf_settings(precision));
  CHECK(check.directions.outside == 0);
  CHECK(check.directions.test.p_value > level);
  CHECK(check.directions.integral < 1 + 1e-3);
  CHECK(check.reverse_error < tolerance.reverse);
  CHECK(check.reciprocity_error < tolerance.reverse);
  CHECK(check.sample_error < tolerance.sample);
  CHECK(check.reflected_share < 1 + tolerance.reflected);
  CHECK_FALSE(bsdf.is_purely_delta());
  return check;
}

/// Each lobe alone makes the density that it states, and their weights are 1 together.
template <class B, class V>
void check_lobes(const B& bsdf, const V& normal, const V& to_prev, gmis::Philox& source, double precision,
                 double level) {
  using T = typename V::value_type;
  T sum = 0;
  for (int k = 0; k < bsdf.lobe_count(); ++k) {
    CAPTURE(k);
    sum += bsdf.lobe_weight(k);
    const auto check = gmis::check_directions<T>(
        normal,
        [&] {
          const T x = gmis::uniform<T>(source);
          return bsdf.sample_lobe(k, to_prev, {x, gmis::uniform<T>(source)}, gmis::TransportMode::radiance);
        },
        [&](const V& w) {
          std::array<T, B::max_lobes> pdfs{};
          bsdf.lobe_pdfs(to_prev, w, pdfs.data());
          return pdfs[static_cast<std::size_t>(k)];
        },
        bsdf_settings(precision));
    CHECK(check.passes(level, 1e-3));
  }
  CHECK(sum == Approx(1));
}

}  // namespace scene_test
