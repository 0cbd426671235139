#include "support/report/metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/result/image_error.hpp"

namespace gmis::tools {

namespace {

using Colour = std::array<double, 3>;

constexpr double pixels_per_degree = 0.7 * 3840 / 0.7 * pi<double> / 180;

// --- Colour spaces -------------------------------------------------------------------------------

/// Linear sRGB to XYZ, divided by the XYZ of white (the sums of the rows).
constexpr std::array<Colour, 3> to_xyz{{{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                                        {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                        {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}}};

Colour xyz_over_white(const Colour& rgb) {
  Colour xyz{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) xyz[i] += to_xyz[i][k] * rgb[k] / (to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2]);
  return xyz;
}

Colour rgb_of(const Colour& relative_xyz) {
  std::array<Colour, 3> m = to_xyz;
  for (auto& row : m) {
    const double white = row[0] + row[1] + row[2];
    for (double& entry : row) entry /= white;
  }
  const auto minor = [&m](std::size_t i, std::size_t k) {
    const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
    return m[i1][k1] * m[i2][k2] - m[i1][k2] * m[i2][k1];
  };
  const double determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
  Colour rgb{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) rgb[i] += minor(k, i) / determinant * relative_xyz[k];
  return rgb;
}

/// Y, Cx, Cz: a linear opponent space, so that filters may act in it.
Colour opponent_of(const Colour& rgb) {
  const Colour w = xyz_over_white(rgb);
  return {116 * w[1] - 16, 500 * (w[0] - w[1]), 200 * (w[1] - w[2])};
}

Colour rgb_of_opponent(const Colour& c) {
  const double y = (c[0] + 16) / 116;
  return rgb_of({y + c[1] / 500, y, y - c[2] / 200});
}

/// L*, a*, b*, with the chroma scaled by the lightness [Hunt].
Colour adjusted_lab(const Colour& rgb) {
  const Colour w = xyz_over_white(rgb);
  const auto f = [](double t) {
    constexpr double delta = 6.0 / 29;
    return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
  };
  const double lightness = 116 * f(w[1]) - 16;
  return {lightness, 0.01 * lightness * 500 * (f(w[0]) - f(w[1])), 0.01 * lightness * 200 * (f(w[1]) - f(w[2]))};
}

/// The distance HyAB, to the power 0.7.
double colour_distance(const Colour& a, const Colour& b) {
  return std::pow(std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]), 0.7);
}

// --- Filters -------------------------------------------------------------------------------------

/// One number for each pixel.
struct Plane {
  int width, height;
  std::vector<double> values;

  Plane(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  [[nodiscard]] double& at(int x, int y) { return values[static_cast<std::size_t>(y * width + x)]; }
  [[nodiscard]] double at(int x, int y) const { return values[static_cast<std::size_t>(y * width + x)]; }
};

/// From −r to r.
using Kernel = std::vector<double>;

/// The plane under the product of two kernels, one along each axis; beyond its edge a plane goes on
/// with the edge's values.
Plane filtered(const Plane& plane, const Kernel& along_x, const Kernel& along_y) {
  const auto pass = [](const Plane& from, const Kernel& kernel, bool is_x) {
    Plane to(from.width, from.height);
    const int r = static_cast<int>(kernel.size() / 2);
    for (int y = 0; y < from.height; ++y)
      for (int x = 0; x < from.width; ++x) {
        double sum = 0;
        for (int k = -r; k <= r; ++k)
          sum += kernel[static_cast<std::size_t>(k + r)] * (is_x ? from.at(std::clamp(x + k, 0, from.width - 1), y)
                                                                 : from.at(x, std::clamp(y + k, 0, from.height - 1)));
        to.at(x, y) = sum;
      }
    return to;
  };
  return pass(pass(plane, along_x, true), along_y, false);
}

/// a √(π / b) exp(−π² x² / b), x in degrees: one term of a contrast sensitivity, along both axes.
struct SensitivityTerm {
  double a, b;
};

/// The plane seen with the sensitivity that is the sum of the terms.
Plane seen_with(const Plane& plane, std::span<const SensitivityTerm> terms) {
  // The widest of all sensitivities sets the size of every kernel.
  constexpr double widest = 0.04;
  const int r = static_cast<int>(std::ceil(3 * std::sqrt(widest / (2 * pi<double> * pi<double>)) * pixels_per_degree));
  Plane sum(plane.width, plane.height);
  double weight = 0;
  for (const SensitivityTerm& term : terms) {
    Kernel kernel;
    double total = 0;
    for (int k = -r; k <= r; ++k) {
      const double x = k / pixels_per_degree;
      kernel.push_back(std::exp(-pi<double> * pi<double> * x * x / term.b));
      total += kernel.back();
    }
    const double factor = term.a * std::sqrt(pi<double> / term.b);
    weight += factor * total * total;
    const Plane part = filtered(plane, kernel, kernel);
    for (std::size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += factor * part.values[i];
  }
  for (double& value : sum.values) value /= weight;
  return sum;
}

/// The strength of edges or of points (lines, too) in a plane: first or second derivatives of
/// Gaussians.
Plane features_of(const Plane& plane, bool points) {
  constexpr double width = 0.082;  // of a feature, in degrees
  constexpr double deviation = 0.5 * width * pixels_per_degree;
  const int r = static_cast<int>(std::ceil(3 * deviation));
  Kernel smooth, derivative;
  double total = 0, positive = 0, negative = 0;
  for (int k = -r; k <= r; ++k) {
    const double gauss = std::exp(-k * k / (2 * deviation * deviation));
    smooth.push_back(gauss);
    derivative.push_back(points ? (k * k / (deviation * deviation) - 1) * gauss : -k * gauss);
    total += gauss;
    (derivative.back() > 0 ? positive : negative) += std::abs(derivative.back());
  }
  for (double& value : smooth) value /= total;
  for (double& value : derivative) value /= value > 0 ? positive : negative;
  const Plane x = filtered(plane, derivative, smooth), y = filtered(plane, smooth, derivative);
  Plane strength(plane.width, plane.height);
  for (std::size_t i = 0; i < strength.values.size(); ++i) strength.values[i] = std::hypot(x.values[i], y.values[i]);
  return strength;
}

// --- ꟻLIP ----------------------------------------------------------------------------------------

/// The parts of one picture that ꟻLIP's two halves, colours and features, need.
struct Seen {
  std::vector<Colour> lab;  ///< after the eye's filters
  Plane edges, points;
};

Seen seen(const Image& image, float exposure) {
  std::array<Plane, 3> opponent{Plane(image.width, image.height), Plane(image.width, image.height),
                                Plane(image.width, image.height)};
  const std::size_t pixels = opponent[0].values.size();
  for (std::size_t i = 0; i < pixels; ++i) {
    Colour shown;
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = image.rgb[3 * i + c] * exposure;
      shown[c] = value >= 0 ? std::min(static_cast<double>(value), 1.0) : 0.0;  // NaN is shown as black
    }
    const Colour converted = opponent_of(shown);
    for (std::size_t c = 0; c < 3; ++c) opponent[c].values[i] = converted[c];
  }
  Plane achromatic = opponent[0];
  for (double& value : achromatic.values) value = (value + 16) / 116;
  constexpr std::array<SensitivityTerm, 1> light{{{1, 0.0047}}}, red_green{{{1, 0.0053}}};
  constexpr std::array<SensitivityTerm, 2> blue_yellow{{{34.1, 0.04}, {13.5, 0.025}}};
  const std::array<Plane, 3> filtered{seen_with(opponent[0], light), seen_with(opponent[1], red_green),
                                      seen_with(opponent[2], blue_yellow)};
  Seen result{{}, features_of(achromatic, false), features_of(achromatic, true)};
  for (std::size_t i = 0; i < pixels; ++i) {
    Colour rgb = rgb_of_opponent({filtered[0].values[i], filtered[1].values[i], filtered[2].values[i]});
    for (double& value : rgb) value = std::clamp(value, 0.0, 1.0);
    result.lab.push_back(adjusted_lab(rgb));
  }
  return result;
}

}  // namespace

Image smape_map(const Image& image, const Image& reference) {
  Image map(image.width, image.height);
  for (std::size_t i = 0; i < map.rgb.size(); ++i)
    map.rgb[i] =
        std::abs(image.rgb[i] - reference.rgb[i]) / (std::abs(image.rgb[i]) + std::abs(reference.rgb[i]) + 0.01F);
  return map;
}

Image flip_map(const Image& image, const Image& reference, float exposure) {
  const Seen ours = seen(image, exposure), theirs = seen(reference, exposure);
  // The largest distance of two colours is that of green and blue. Distances up to 0.4 of it take
  // 0.95 of the range.
  const double largest = colour_distance(adjusted_lab({0, 1, 0}), adjusted_lab({0, 0, 1}));
  constexpr double knee = 0.4, at_knee = 0.95;
  Image map(image.width, image.height);
  for (std::size_t i = 0; 3 * i < map.rgb.size(); ++i) {
    const double distance = colour_distance(ours.lab[i], theirs.lab[i]) / largest;
    const double colour =
        distance < knee ? distance / knee * at_knee : at_knee + (distance - knee) / (1 - knee) * (1 - at_knee);
    const double feature = std::max(std::abs(ours.edges.values[i] - theirs.edges.values[i]),
                                    std::abs(ours.points.values[i] - theirs.points.values[i]));
    const double amplified = std::pow(colour, 1 - std::sqrt(feature / std::sqrt(2.0)));
    for (std::size_t c = 0; c < 3; ++c) map.rgb[3 * i + c] = static_cast<float>(amplified);
  }
  return map;
}

PictureError picture_error(const Image& image, const Image& reference, float exposure) {
  const ImageError error =
      image_error(std::span<const float>(image.rgb), std::span<const float>(reference.rgb), std::size_t{3});
  PictureError result{{}, smape_map(image, reference), flip_map(image, reference, exposure)};
  result.metrics = {std::sqrt(error.relmse), std::sqrt(error.relmse_trimmed), mean_of(result.smape),
                    mean_of(result.flip)};
  return result;
}

}  // namespace gmis::tools
