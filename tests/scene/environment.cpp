#include "gmis/scene/environment_map.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "scene/shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;
using namespace scene_test;

namespace {

/// A few bright pixels on dim noise, a black row and a black patch.
EnvironmentImage test_image(SkyMapping mapping, glm::ivec2 resolution) {
  Philox source(gmis_test::seed(81));
  EnvironmentImage image{resolution, {}, mapping};
  for (int y = 0; y < resolution.y; ++y)
    for (int x = 0; x < resolution.x; ++x) {
      const bool is_black = y == 1 || (x < 2 && y == resolution.y - 1);
      const double level = is_black ? 0 : (x + y) % 7 == 3 ? 6 : 0.2 + uniform<double>(source);
      image.radiance.push_back(glm::vec3(glm::dvec3(1.2, 1, 0.8) * level));
    }
  return image;
}

const glm::dmat3 turned(glm::normalize(glm::dvec3(1, 2, 2)), glm::normalize(glm::dvec3(-2, -1, 2)),
                        glm::normalize(glm::dvec3(2, -2, 1)));
const glm::dmat3 mirrored(turned[0] * 3.0, turned[1] * -3.0, turned[2] * 3.0);

// False-alarm rate of all χ² and t-tests of this file together: 1e-3.
const double level = sidak_level(1e-3, 41);

TEST_CASE("the octahedral square keeps areas and has the inverse that it states", "[environment]") {
  using T = double;
  Philox source(gmis_test::seed(82));
  double worst = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec2<T> u = random_square<T>(source);
    const Vec3<T> w = square_to_octahedral_sphere(u);
    worst = std::max({worst, std::abs(glm::length(w) - 1), glm::length(octahedral_sphere_to_square(w) - u)});
    // The determinant of the map, by differences: 4π everywhere but on the creases.
    const T h = 1e-6;
    const bool on_crease = std::abs(std::abs(2 * u.x - 1) + std::abs(2 * u.y - 1) - 1) < 1e-4 ||
                           std::abs(u.x - 0.5) < 1e-4 || std::abs(u.y - 0.5) < 1e-4 || u.x > 0.999 || u.y > 0.999;
    if (on_crease) continue;
    const auto dx = (square_to_octahedral_sphere(Vec2<T>(u.x + h, u.y)) - w) / h;
    const auto dy = (square_to_octahedral_sphere(Vec2<T>(u.x, u.y + h)) - w) / h;
    if (!(std::abs(glm::length(glm::cross(dx, dy)) / (4 * pi<T>)-1) < 1e-3))
      FAIL("area is lost at " << u.x << ", " << u.y);
  }
  CHECK(worst < 1e-7);
  // Near the poles and where the square is folded, single precision finds its way back too.
  double worst_float = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto offset = static_cast<float>(random_magnitude(source, -6, -1));
    const Vec2<float> u(0.5F + offset, 0.5F - offset / 3);
    worst_float = std::max(
        worst_float, static_cast<double>(glm::length(octahedral_sphere_to_square(square_to_octahedral_sphere(u)) - u)));
  }
  CHECK(worst_float < 1e-6);
  // Where the format puts its landmarks: z up in the middle, x to the right, y down, −z in the
  // corners.
  CHECK(glm::length(square_to_octahedral_sphere(Vec2<T>(0.5, 0.5)) - Vec3<T>(0, 0, 1)) < 1e-12);
  CHECK(glm::length(square_to_octahedral_sphere(Vec2<T>(1, 0.5)) - Vec3<T>(1, 0, 0)) < 1e-12);
  CHECK(glm::length(square_to_octahedral_sphere(Vec2<T>(0.5, 1)) - Vec3<T>(0, 1, 0)) < 1e-12);
  CHECK(glm::length(square_to_octahedral_sphere(Vec2<T>(0, 0)) - Vec3<T>(0, 0, -1)) < 1e-12);
}

TEST_CASE("rows of latitude and columns of longitude go where they should", "[environment]") {
  EnvironmentImage image{{8, 4}, std::vector<glm::vec3>(32, glm::vec3(1)), SkyMapping::latitude_longitude};
  image.radiance[1 * 8 + 2] = glm::vec3(5);  // 45 to 90 degrees from z, 90 to 135 degrees from x towards y
  const EnvironmentMap<double> map(image, glm::dmat3(1));
  CHECK(map.radiance(glm::normalize(Vec3<double>(-0.4, 1, 0.6))).x == 5);
  CHECK(map.radiance(glm::normalize(Vec3<double>(0.1, 1, 0.6))).x == 1);
  CHECK(map.radiance(glm::normalize(Vec3<double>(-0.4, 1, -0.1))).x == 1);
  CHECK(map.radiance(glm::normalize(Vec3<double>(-0.4, 1, 2))).x == 1);
  CHECK(map.radiance(Vec3<double>(0, 0, 1)).x == 1);
  CHECK(map.radiance(Vec3<double>(0, 0, -1)).x == 1);
  // 4π of radiance 1, and 4 more over 2π/8 (cos 45° − cos 90°).
  CHECK(map.total() == Approx(4 * pi<double> + 4 * pi<double> / 4 * std::sqrt(0.5)));
}

TEMPLATE_TEST_CASE("a sky is sampled with the density that it states, which is exact", "[environment]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(83));
  for (const SkyMapping mapping : {SkyMapping::equal_area, SkyMapping::latitude_longitude})
    for (const glm::ivec2 resolution : {glm::ivec2(8, 8), glm::ivec2(13, 13)})
      for (const glm::dmat3& transform : {turned, mirrored}) {
        CAPTURE(static_cast<int>(mapping), resolution.x);
        const EnvironmentImage image = test_image(mapping, resolution);
        const EnvironmentMap<T> map(image, transform);

        // Four cells to a pixel, and what each should get: its radiance over its solid angle.
        const auto side = static_cast<std::size_t>(2 * resolution.x);
        std::vector<double> counts(side * side), expected(side * side);
        double total = 0;
        for (std::size_t row = 0; row < side; ++row) {
          const auto edge = [&](std::size_t i) { return std::cos(pi<double> * double(i) / double(side)); };
          const double height = mapping == SkyMapping::equal_area ? 2.0 / double(side) : edge(row) - edge(row + 1);
          for (std::size_t column = 0; column < side; ++column) {
            const glm::vec3& radiance = image.radiance[(row / 2) * (side / 2) + column / 2];
            expected[row * side + column] = (double(radiance.x) + double(radiance.y) + double(radiance.z)) / 3 *
                                            height * 2 * pi<double> / double(side);
            total += expected[row * side + column];
          }
        }
        CHECK(map.total() == Approx(total));
        constexpr int samples = 60'000;
        for (double& e : expected) e *= samples / total;

        int differ = 0;
        for (int i = 0; i < samples; ++i) {
          const auto sample = map.sample(random_square<T>(source));
          differ += sample.radiance == map.radiance(sample.to_sky) ? 0 : 1;
          if (!(std::abs(glm::length(sample.to_sky) - T(1)) < T(1e-5))) FAIL("not a unit vector");
          // In proportion to radiance: the weight is the same wherever it falls.
          const double weight = static_cast<double>(mean_channel(sample.radiance) / sample.density);
          if (!(std::abs(weight / total - 1) < 1e-5)) FAIL("the weight varies");
          if (!(std::abs(map.density(sample.radiance) / sample.density - T(1)) < T(1e-5))) FAIL("another density");
          const glm::dvec3 w = glm::transpose(transform) * glm::dvec3(sample.to_sky) / glm::length(transform[0]);
          const double turn = std::atan2(w.y, w.x) / (2 * pi<double>);
          const auto place = mapping == SkyMapping::equal_area
                                 ? octahedral_sphere_to_square(w)
                                 : Vec2<double>(turn < 0 ? turn + 1 : turn, std::acos(w.z) / pi<double>);
          const auto cell = [&](double x) { return std::min(static_cast<std::size_t>(x * double(side)), side - 1); };
          // Rounding may put a direction in single precision into the next pixel, which may be
          // black.
          const std::size_t at = cell(place.y) * side + cell(place.x);
          if (expected[at] > 0) ++counts[at];
        }
        CHECK(differ <= (std::same_as<T, float> ? 10 : 0));
        CHECK(chi_square_test(counts, expected).passes(level));
      }
}

/// The compensated density per steradian of every pixel, in long double, by the definition: the
/// largest λ-level set is found by adding pixels from the brightest down until the level no longer
/// reaches the next one.
std::vector<double> compensated(const EnvironmentImage& image, const std::vector<double>& angles, double fraction) {
  const long double c = fraction, floor = (1 - c) / (4 * std::numbers::pi_v<long double>);
  std::vector<std::size_t> order(angles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto value = [&](std::size_t i) {
    return (static_cast<long double>(image.radiance[i].x) + static_cast<long double>(image.radiance[i].y) +
            static_cast<long double>(image.radiance[i].z)) /
           3;
  };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return value(a) > value(b); });
  long double light = 0, angle = 0, lambda = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    light += value(order[k]) * static_cast<long double>(angles[order[k]]);
    angle += static_cast<long double>(angles[order[k]]);
    lambda = (c + floor * angle) / light;  // Σ (λ L − floor) Ω = c over the brightest
    if (k + 1 == order.size() || lambda * value(order[k + 1]) <= floor) break;
  }
  std::vector<double> density;
  for (std::size_t i = 0; i < angles.size(); ++i)
    density.push_back(static_cast<double>(std::max(0.0L, lambda * value(i) - floor) / c));
  return density;
}

TEMPLATE_TEST_CASE("a compensated sky: density, samples and energy", "[environment]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(85));
  for (const SkyMapping mapping : {SkyMapping::equal_area, SkyMapping::latitude_longitude})
    for (const double fraction : {0.25, 0.5, 0.9}) {
      CAPTURE(static_cast<int>(mapping), fraction);
      const EnvironmentImage image = test_image(mapping, {8, 8});
      const EnvironmentMap<T> map(image, glm::dmat3(1), fraction);
      const EnvironmentMap<T> plain(image, glm::dmat3(1));
      CHECK(map.is_compensated());
      CHECK_FALSE(plain.is_compensated());
      std::vector<double> angles;
      for (std::size_t i = 0; i < 64; ++i) {
        const auto edge = [&](std::size_t row) { return std::cos(pi<double> * double(row) / 8); };
        angles.push_back(mapping == SkyMapping::equal_area ? 4 * pi<double> / 64
                                                           : (edge(i / 8) - edge(i / 8 + 1)) * 2 * pi<double> / 8);
      }
      const std::vector<double> expected = compensated(image, angles, fraction);
      double integral = 0, compensated_moment = 0, plain_moment = 0, light = 0;
      for (std::size_t i = 0; i < 64; ++i) {
        const Vec3<T> radiance(image.radiance[i]);
        const double density = static_cast<double>(map.next_event_density(radiance));
        CHECK(density == Approx(expected[i]).epsilon(2e-4).margin(2e-4 / (4 * pi<double>)));
        CHECK(map.density(radiance) == plain.density(radiance));
        integral += density * angles[i];
        // The second moment of the mixture with uniform directions, which compensation makes least.
        const double l = static_cast<double>(mean_channel(radiance));
        const auto moment = [&](double own) {
          return l * l * angles[i] / (fraction * own + (1 - fraction) / (4 * pi<double>));
        };
        compensated_moment += moment(density);
        plain_moment += moment(static_cast<double>(plain.next_event_density(radiance)));
        light += l * angles[i];
      }
      CHECK(integral == Approx(1.0).epsilon(1e-5));
      CHECK(compensated_moment < plain_moment);

      // Samples follow it, and with uniform directions they carry all the light (balance weights).
      std::vector<double> counts(64), wanted(64);
      constexpr int samples = 60'000;
      for (std::size_t i = 0; i < 64; ++i) wanted[i] = expected[i] * angles[i] * samples;
      double sum = 0, squares = 0;
      for (int n = 0; n < samples; ++n) {
        const auto sample = map.sample_next_event(random_square<T>(source));
        if (!(sample.density == map.next_event_density(sample.radiance))) FAIL("another density");
        const glm::dvec3 w(sample.to_sky);
        const double turn = std::atan2(w.y, w.x) / (2 * pi<double>);
        const auto place =
            mapping == SkyMapping::equal_area
                ? octahedral_sphere_to_square(w)
                : Vec2<double>(turn < 0 ? turn + 1 : turn, std::acos(std::clamp(w.z, -1.0, 1.0)) / pi<double>);
        const auto cell = [](double x) { return std::min(static_cast<std::size_t>(x * 8), std::size_t{7}); };
        const std::size_t at = cell(place.y) * 8 + cell(place.x);
        if (wanted[at] > 0) ++counts[at];
        const auto weighted = [&](const Vec3<T>& radiance) {
          return static_cast<double>(mean_channel(radiance)) /
                 (fraction * static_cast<double>(map.next_event_density(radiance)) + (1 - fraction) / (4 * pi<double>));
        };
        const auto elsewhere = square_to_octahedral_sphere(random_square<T>(source));
        const double value = fraction * weighted(sample.radiance) + (1 - fraction) * weighted(map.radiance(elsewhere));
        sum += value;
        squares += value * value;
      }
      CHECK(chi_square_test(counts, wanted).passes(level));
      const double mean = sum / samples, error = std::sqrt((squares / samples - mean * mean) / samples);
      CHECK(t_test(mean - light, error, samples, 0).passes(level));
    }
  const EnvironmentImage image = test_image(SkyMapping::equal_area, {4, 4});
  for (const double fraction : {0.0, -1.0, 1.5, std::numeric_limits<double>::quiet_NaN()})
    CHECK_THROWS_AS(EnvironmentMap<T>(image, glm::dmat3(1), fraction), std::invalid_argument);
}

TEST_CASE("the poles of a sky are sampled evenly", "[environment]") {
  // All light in the last row: uniform over the cap of 180°/32.
  using T = float;
  Philox source(gmis_test::seed(84));
  EnvironmentImage image{{4, 32}, std::vector<glm::vec3>(128, glm::vec3(0)), SkyMapping::latitude_longitude};
  for (std::size_t i = 0; i < 4; ++i) image.radiance[124 + i] = glm::vec3(1);  // the last row: around −z
  const EnvironmentMap<T> map(image, glm::dmat3(1));
  std::vector<double> counts(40), expected(40, 250.0);
  const double cap = 1 - std::cos(pi<double> / 32);
  for (int i = 0; i < 10'000; ++i) {
    const auto w = map.sample(random_square<T>(source)).to_sky;
    const double drop =
        (static_cast<double>(w.x) * w.x + static_cast<double>(w.y) * w.y) / (1 - static_cast<double>(w.z));
    const auto ring = static_cast<std::size_t>(std::min(drop / cap * 10, 9.5));
    const auto quadrant = static_cast<std::size_t>((w.x > 0 ? 1 : 0) + (w.y > 0 ? 2 : 0));
    ++counts[ring * 4 + quadrant];
  }
  CHECK(chi_square_test(counts, expected).passes(level));
}

TEST_CASE("what is no sky is refused", "[environment]") {
  EnvironmentImage image = test_image(SkyMapping::equal_area, {4, 4});
  CHECK_NOTHROW(EnvironmentMap<float>(image, glm::dmat3(1)));
  image.resolution = {4, 3};
  CHECK_THROWS_AS(EnvironmentMap<float>(image, glm::dmat3(1)), std::invalid_argument);
  image.resolution = {8, 2};
  CHECK_THROWS_AS(EnvironmentMap<float>(image, glm::dmat3(1)), std::invalid_argument);
  image.resolution = {4, 4};
  CHECK_THROWS_AS(EnvironmentMap<float>(image, glm::dmat3(0)), std::invalid_argument);
  image.radiance[3].y = -1;
  CHECK_THROWS_AS(EnvironmentMap<float>(image, glm::dmat3(1)), std::invalid_argument);
}

}  // namespace
