#include "support/report/metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <tuple>

#include "support/catch.hpp"
#include "support/seed.hpp"

// ꟻLIP against its definition, written out a second time: filters in two dimensions, the matrices
// of sRGB in decimals.

using namespace gmis::tools;

namespace {

using Colour = std::array<long double, 3>;

Image uniform(int width, int height, float r, float g, float b) {
  Image image(width, height);
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) image.rgb[i] = r, image.rgb[i + 1] = g, image.rgb[i + 2] = b;
  return image;
}

Image noise(int width, int height, unsigned seed) {
  std::mt19937 source(seed);
  std::uniform_real_distribution<float> value(0, 1);
  Image image(width, height);
  for (float& x : image.rgb) x = value(source);
  return image;
}

constexpr long double ppd = 67.0206432765823L, pi = 3.14159265358979323846L;

Colour white_xyz(const Colour& rgb) {
  const long double x = 0.4123865632529916L * rgb[0] + 0.357591490920625L * rgb[1] + 0.18045049120356364L * rgb[2];
  const long double y = 0.21263682167732384L * rgb[0] + 0.71518298184125L * rgb[1] + 0.07218019648142546L * rgb[2];
  const long double z = 0.019330620152483987L * rgb[0] + 0.11919716364020833L * rgb[1] + 0.9503725870054354L * rgb[2];
  return {x / 0.9504285453771803L, y, z / 1.0889003707981277L};
}

Colour inverse_of(const Colour& target) {
  // Newton's method for a linear map ends after one step; the columns by differences.
  Colour rgb{0, 0, 0};
  const Colour r = white_xyz({1, 0, 0}), g = white_xyz({0, 1, 0}), b = white_xyz({0, 0, 1});
  const auto determinant = [](const Colour& p, const Colour& q, const Colour& s) {
    return p[0] * (q[1] * s[2] - q[2] * s[1]) - q[0] * (p[1] * s[2] - p[2] * s[1]) + s[0] * (p[1] * q[2] - p[2] * q[1]);
  };
  const long double all = determinant(r, g, b);
  rgb[0] = determinant(target, g, b) / all;
  rgb[1] = determinant(r, target, b) / all;
  rgb[2] = determinant(r, g, target) / all;
  return rgb;
}

Colour hunt_lab(const Colour& rgb) {
  const Colour w = white_xyz(rgb);
  const auto f = [](long double t) { return t > 216.0L / 24389 ? std::cbrt(t) : (24389.0L / 27 * t + 16) / 116; };
  const long double l = 116 * f(w[1]) - 16;
  return {l, l / 100 * 500 * (f(w[0]) - f(w[1])), l / 100 * 200 * (f(w[1]) - f(w[2]))};
}

long double hyab(const Colour& p, const Colour& q) {
  return std::abs(p[0] - q[0]) + std::sqrt((p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2]));
}

long double redistributed(long double distance) {
  const long double largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), 0.7L);
  const long double powered = std::pow(distance, 0.7L), knee = 0.4L * largest;
  return powered < knee ? 0.95L / knee * powered : 0.95L + (powered - knee) / (largest - knee) * 0.05L;
}

/// ꟻLIP of one pixel, by the definition.
long double flip_at(const Image& a, const Image& b, int px, int py) {
  const auto opponent = [](const Image& image, int x, int y) {
    x = std::clamp(x, 0, image.width - 1);
    y = std::clamp(y, 0, image.height - 1);
    Colour rgb;
    for (std::size_t c = 0; c < 3; ++c) rgb[c] = static_cast<long double>(image.rgb[image.index(x, y) + c]);
    const Colour w = white_xyz(rgb);
    return Colour{116 * w[1] - 16, 500 * (w[0] - w[1]), 200 * (w[1] - w[2])};
  };
  const auto sensitivity = [](int channel, long double z) {
    const auto term = [&](long double p, long double q) { return p * std::sqrt(pi / q) * std::exp(-pi * pi * z / q); };
    return channel == 0 ? term(1, 0.0047L) : channel == 1 ? term(1, 0.0053L) : term(34.1L, 0.04L) + term(13.5L, 0.025L);
  };
  const auto lab = [&](const Image& image) {
    Colour sum{}, weight{};
    for (int dy = -10; dy <= 10; ++dy)
      for (int dx = -10; dx <= 10; ++dx) {
        const Colour there = opponent(image, px + dx, py + dy);
        for (std::size_t c = 0; c < 3; ++c) {
          const long double w = sensitivity(static_cast<int>(c), (dx * dx + dy * dy) / (ppd * ppd));
          sum[c] += w * there[c];
          weight[c] += w;
        }
      }
    for (std::size_t c = 0; c < 3; ++c) sum[c] /= weight[c];
    const long double y = (sum[0] + 16) / 116;
    Colour rgb = inverse_of({y + sum[1] / 500, y, y - sum[2] / 200});
    for (long double& value : rgb) value = std::clamp(value, 0.0L, 1.0L);
    return hunt_lab(rgb);
  };
  const auto features = [&](const Image& image, bool points) {
    const long double sd = 0.5L * 0.082L * ppd;
    const int r = static_cast<int>(std::ceil(3 * sd));
    long double x_sum = 0, y_sum = 0, positive = 0, negative = 0;
    const auto filter = [&](int along, int across) {
      const long double gauss = std::exp(-(along * along + across * across) / (2 * sd * sd));
      return points ? (along * along / (sd * sd) - 1) * gauss : -along * gauss;
    };
    for (int i = -r; i <= r; ++i)
      for (int k = -r; k <= r; ++k) (filter(i, k) > 0 ? positive : negative) += std::abs(filter(i, k));
    for (int dy = -r; dy <= r; ++dy)
      for (int dx = -r; dx <= r; ++dx) {
        const long double value = (opponent(image, px + dx, py + dy)[0] + 16) / 116;
        const long double x = filter(dx, dy), y = filter(dy, dx);
        x_sum += value * x / (x > 0 ? positive : negative);
        y_sum += value * y / (y > 0 ? positive : negative);
      }
    return std::sqrt(x_sum * x_sum + y_sum * y_sum);
  };
  const long double feature =
      std::max(std::abs(features(a, false) - features(b, false)), std::abs(features(a, true) - features(b, true)));
  return std::pow(redistributed(hyab(lab(a), lab(b))), 1 - std::sqrt(feature / std::sqrt(2.0L)));
}

}  // namespace

TEST_CASE("FLIP of uniform pictures is the distance of their colours") {
  const Image black = uniform(6, 5, 0, 0, 0), white = uniform(6, 5, 1, 1, 1);
  // HyAB of black and white is 100: there are no features, and no filter changes a uniform picture.
  const auto expected = static_cast<float>(redistributed(100));
  CHECK(flip_map(black, white, 1).rgb[7] == Approx(expected).epsilon(1e-5));
  // The number itself: HyAB of green and blue is 203.3017, its power 0.7 is 41.2761, that of 100 is
  // 25.1189, the knee is at 0.4 · 41.2761 = 16.5104, and 0.95 + 0.05 · 8.6085/24.7657 = 0.96738.
  CHECK(expected == Approx(0.96738).margin(5e-6));
  for (const auto& [one, other, wanted] : {std::tuple{&black, &white, static_cast<double>(expected)},
                                           std::tuple{&white, &black, static_cast<double>(expected)},
                                           std::tuple{&white, &white, 0.0}, std::tuple{&black, &black, 0.0}}) {
    const PictureError error = picture_error(*one, *other, 1);
    for (const float value : error.flip.rgb) CHECK(value == Approx(wanted).epsilon(1e-5));
    CHECK(error.metrics.flip == Approx(wanted).epsilon(1e-5));
  }
  CHECK(flip_map(uniform(6, 5, 0, 1, 0), uniform(6, 5, 0, 0, 1), 1).rgb[0] == Approx(1.0).epsilon(1e-5));
  // As they are shown: times the exposure, and cut to [0, 1].
  CHECK(flip_map(uniform(6, 5, 4, 4, 4), white, 1).rgb[0] == 0.0F);
  CHECK(flip_map(uniform(6, 5, 0.25F, 0.25F, 0.25F), uniform(6, 5, 0.5F, 0.5F, 0.5F), 8).rgb[0] == 0.0F);
  const auto grey = static_cast<double>(redistributed(hyab(hunt_lab({0.5L, 0.5L, 0.5L}), hunt_lab({1, 1, 1}))));
  CHECK(flip_map(uniform(6, 5, 0.25F, 0.25F, 0.25F), uniform(6, 5, 0.5F, 0.5F, 0.5F), 2).rgb[0] ==
        Approx(grey).epsilon(1e-5));
}

TEST_CASE("FLIP is what its definition says, pixel by pixel") {
  const auto seed = static_cast<unsigned>(gmis_test::seed(3));
  Image a = noise(17, 13, seed), b = a;
  const Image other = noise(17, 13, seed + 1);
  for (std::size_t i = 0; i < b.rgb.size() / 2; ++i) b.rgb[i] = 0.7F * b.rgb[i] + 0.3F * other.rgb[i];
  a.rgb[a.index(12, 9)] = 1.0F;
  const Image map = flip_map(a, b, 1), swapped = flip_map(b, a, 1);
  for (const auto& [x, y] :
       {std::array{0, 0}, std::array{8, 6}, std::array{16, 12}, std::array{3, 11}, std::array{11, 8}}) {
    CAPTURE(x, y);
    CHECK(map.rgb[map.index(x, y)] == Approx(static_cast<double>(flip_at(a, b, x, y))).epsilon(1e-4).margin(1e-5));
  }
  CHECK(map.rgb == swapped.rgb);
  for (const float value : flip_map(a, a, 1).rgb) CHECK(value == 0.0F);
}

TEST_CASE("The measures of a picture: relative error, trimmed, SMAPE") {
  // Everywhere 0.1 too much of 0.5, and one firefly among 2000 pixels.
  const Image reference = uniform(50, 40, 0.5F, 0.5F, 0.5F);
  Image image = uniform(50, 40, 0.6F, 0.6F, 0.6F);
  for (std::size_t c = 0; c < 3; ++c) image.rgb[image.index(20, 20) + c] = 1000;
  const double quiet = 0.1 * 0.1 / (0.25 + 0.01), firefly = 999.5 * 999.5 / (0.25 + 0.01);
  const ImageMetrics metrics = picture_error(image, reference, 1).metrics;
  CHECK(metrics.relative_error == Approx(std::sqrt((1999 * quiet + firefly) / 2000)).epsilon(1e-5));
  CHECK(metrics.trimmed == Approx(std::sqrt(quiet)).epsilon(1e-5));  // two pixels are left out
  CHECK(metrics.smape == Approx((1999 * 0.1 / 1.11 + 999.5 / 1000.51) / 2000).epsilon(1e-5));
  // The mean of the definition over all pixels, of the picture as it is shown: cut to 1.
  Image shown = image;
  for (float& value : shown.rgb) value = std::min(value, 1.0F);
  long double flip = 0;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 50; ++x) flip += flip_at(shown, reference, x, y) / 2000;
  CHECK(metrics.flip == Approx(static_cast<double>(flip)).epsilon(1e-4));
  const ImageMetrics same = picture_error(reference, reference, 1).metrics;
  CHECK((same.relative_error == 0 && same.trimmed == 0 && same.smape == 0 && same.flip == 0));
}
