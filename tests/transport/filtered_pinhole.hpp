#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <optional>

#include "gmis/core/interaction.hpp"

// A camera with a reconstruction filter wider than a pixel, by the rule of docs/your-renderer.md:
// `sample_ray` draws the point of the film with the density h(x − c_p) of its pixel, `project`
// chooses pixel p with the probability h(x − c_p) / H(x), H(x) = Σ_p h(x − c_p). Both state
// the density of all pixels' rays together, H(x) / (A cos³). All techniques then have one factor
// h / H in common, which cancels in the weights. Here h is a tent, with H = 1, or a truncated
// Gaussian, whose H varies.

namespace gmis_test {

using glm::dvec2;
using glm::dvec3;
using glm::ivec2;

/// A filter in one dimension, 0 beyond a pixel's width from the centre; the filter of the film is a
/// product of two.
struct Tent {
  static double h(double x) { return std::max(0.0, 1.0 - std::abs(x)); }
  /// The inverse of its distribution function.
  static double sample(double u) { return u < 0.5 ? std::sqrt(2.0 * u) - 1.0 : 1.0 - std::sqrt(2.0 * (1.0 - u)); }
};
struct Gaussian {
  static constexpr double sd = 0.4;
  static double distribution(double x) { return 0.5 * std::erfc(-x / (sd * std::sqrt(2.0))); }
  static double h(double x) {
    constexpr double pi = 3.14159265358979323846;
    if (std::abs(x) >= 1.0) return 0.0;
    return std::exp(-0.5 * x * x / (sd * sd)) / (sd * std::sqrt(2.0 * pi)) / (distribution(1.0) - distribution(-1.0));
  }
  static double sample(double u) {
    const double wanted = distribution(-1.0) + u * (distribution(1.0) - distribution(-1.0));
    double low = -1.0, high = 1.0;
    for (int i = 0; i < 50; ++i) (distribution((low + high) / 2.0) < wanted ? low : high) = (low + high) / 2.0;
    return (low + high) / 2.0;
  }
};

/// A pinhole at `eye` that looks along +z, x to the right and y down.
template <class Filter>
struct FilteredPinhole {
  using Spectrum = dvec3;
  ivec2 size{10, 8};
  dvec3 eye{0, 0, 0};  // where the built-in scene puts its camera
  double step = 0.1;   // side of a pixel on the plane at distance 1
  double fault = 1.0;
  /// Planted mistakes of both members.
  bool is_density_of_picture = false, lacks_a_cosine = false, shifts_pixel = false, ignores_filter = false;

  [[nodiscard]] ivec2 resolution() const { return size; }
  [[nodiscard]] bool has_parallel_rays() const { return false; }
  [[nodiscard]] double filter_radius() const { return 1.0; }
  /// Σ_p h(x − c_p) in one dimension: the pixels around, inside the picture or not.
  static double sum(double x) {
    double total = 0.0;
    for (int p = static_cast<int>(std::floor(x)) - 2; p <= static_cast<int>(std::floor(x)) + 2; ++p)
      total += Filter::h(x - (p + 0.5));
    return total;
  }
  /// One of the pixels around, with the probability h / H.
  static int choose(double x, double u) {
    const int first = static_cast<int>(std::floor(x)) - 2;
    double left = u * sum(x);
    for (int p = first; p <= first + 4; ++p) {
      left -= Filter::h(x - (p + 0.5));
      if (left < 0.0) return p;
    }
    return static_cast<int>(std::floor(x));
  }
  [[nodiscard]] double density(const dvec2& film, double cosine) const {
    const double box = 1.0 / (step * step * cosine * cosine * (lacks_a_cosine ? 1.0 : cosine));
    return sum(film.x) * sum(film.y) * (is_density_of_picture ? box / (size.x * size.y) : box);
  }
  [[nodiscard]] std::optional<gmis::CameraSample<Spectrum>> sample_ray(ivec2 pixel, dvec2 uv, dvec2) const {
    const dvec2 film = dvec2(pixel) + 0.5 + dvec2(Filter::sample(uv.x), Filter::sample(uv.y));
    const dvec3 direction = glm::normalize(dvec3((film - 0.5 * dvec2(size)) * step, 1.0));
    return gmis::CameraSample<Spectrum>{{eye, {}, {}, 0}, direction, Spectrum(1), density(film, direction.z) * fault};
  }
  [[nodiscard]] std::optional<gmis::CameraProjection<Spectrum>> project(const dvec3& point, dvec2 uv) const {
    const dvec3 offset = point - eye;
    if (!(offset.z > 0)) return std::nullopt;
    const dvec2 film = dvec2(offset) / (offset.z * step) + 0.5 * dvec2(size);
    ivec2 pixel(choose(film.x, uv.x), choose(film.y, uv.y));
    if (ignores_filter) pixel = ivec2(glm::floor(film));
    if (shifts_pixel) ++pixel.y;
    if (pixel.x < 0 || pixel.y < 0 || pixel.x >= size.x || pixel.y >= size.y) return std::nullopt;
    const dvec3 direction = glm::normalize(offset);
    return gmis::CameraProjection<Spectrum>{
        pixel, {eye, {}, {}, 0}, -direction, Spectrum(1), density(film, direction.z)};
  }
};

}  // namespace gmis_test
