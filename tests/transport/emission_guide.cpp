#include "gmis/transport/emission/emission_guide.hpp"

#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "gmis/core/density_tests.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// The parts of guided emission alone: the table on the unit square and the aim, against quadrature,
// counts and the definition of an inverse.

using namespace gmis;

namespace {

// A family of 12 tests of samples: a false alarm in a thousandth of the seeds.
const double level = sidak_level(1e-3, 12);

template <std::floating_point T>
SquareTable<T> uneven_table(Philox& source, double uniform_share) {
  std::array<double, SquareTable<T>::size> masses{};
  for (std::size_t i = 0; i < masses.size(); ++i) masses[i] = i % 5 == 0 ? 0.0 : std::pow(uniform<double>(source), 4.0);
  return SquareTable<T>(masses, uniform_share);
}

/// p-value of counts against expected counts that are all large.
double chi_square_p(const std::vector<double>& counts, const std::vector<double>& expected) {
  double sum = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) sum += square(counts[i] - expected[i]) / expected[i];
  return chi_square_p_value(sum, static_cast<double>(counts.size()) - 1.0);
}

template <std::floating_point T>
Vec2<T> two(Philox& source) {
  const T u = uniform<T>(source);
  return {u, uniform<T>(source)};
}

template <std::floating_point T>
typename Aim<T>::Radii uneven_radii(double scale) {
  typename Aim<T>::Radii radii{};
  for (std::size_t k = 1; k < radii.size(); ++k)
    radii[k] = static_cast<T>(scale * (0.02 * static_cast<double>(k) + std::pow(0.06 * static_cast<double>(k), 3)));
  return radii;
}

}  // namespace

TEMPLATE_TEST_CASE("A table on the unit square: its mean is 1, and samples follow it", "[emission][long]", float,
                   double) {
  using T = TestType;
  Philox source(gmis_test::seed(3));
  for (const double share : {0.05, 0.5}) {
    const auto table = uneven_table<T>(source, share);
    double sum = 0;
    for (const T density : table.bins()) {
      sum += static_cast<double>(density) / static_cast<double>(table.size);
      CHECK(static_cast<double>(density) >= share * (1 - 1e-6));
    }
    CHECK(sum == Approx(1.0).epsilon(1e-5));
    constexpr int count = 400'000;
    std::vector<double> counts(table.size, 0.0), expected;
    for (int i = 0; i < count; ++i) {
      const auto sample = table.warp(two<T>(source));
      REQUIRE((sample.point.x >= T(0) && sample.point.x < T(1) && sample.point.y >= T(0) && sample.point.y < T(1)));
      REQUIRE(sample.density == table.density(sample.point));
      ++counts[table.bin_of(sample.point)];
    }
    for (const T density : table.bins())
      expected.push_back(static_cast<double>(density) * count / static_cast<double>(table.size));
    CHECK(chi_square_p(counts, expected) > level);
  }
}

TEST_CASE("A table on the unit square: its warp is the inverse of the distribution", "[emission]") {
  Philox source(gmis_test::seed(4));
  const auto table = uneven_table<double>(source, 0.1);
  constexpr double side = 16;
  for (int i = 0; i < 1000; ++i) {
    const Vec2<double> point = two<double>(source);
    // The share of all mass in the rows below, and of the row's mass to the left, bin by bin.
    double below = 0, left = 0, row_mass = 0;
    const auto row = static_cast<std::size_t>(point.y * side), column = static_cast<std::size_t>(point.x * side);
    for (std::size_t y = 0; y < 16; ++y)
      for (std::size_t x = 0; x < 16; ++x) {
        const double mass = table.bins()[y * 16 + x] / 256;
        below += y < row ? mass : y == row ? mass * (point.y * side - static_cast<double>(row)) : 0.0;
        if (y != row) continue;
        row_mass += mass;
        left += x < column ? mass : x == column ? mass * (point.x * side - static_cast<double>(column)) : 0.0;
      }
    const auto found = table.warp({left / row_mass, below});
    CHECK(found.point.x == Approx(point.x).margin(1e-12));
    CHECK(found.point.y == Approx(point.y).margin(1e-12));
  }
}

TEST_CASE("A table without mass is uniform", "[emission]") {
  const SquareTable<float> plain, empty(std::array<double, 256>{}, 0.1);
  for (std::size_t i = 0; i < plain.size; ++i) {
    CHECK(plain.bins()[i] == 1.0F);
    CHECK(empty.bins()[i] == 1.0F);
  }
  CHECK(plain.warp({0.3F, 0.8F}).point.x == Approx(0.3F));
}

TEMPLATE_TEST_CASE("An aim: its densities integrate to what does not fail, at any distance", "[emission]", float,
                   double) {
  using T = TestType;
  const Vec3<T> centre(T(0.3), T(-0.2), T(0.1));
  const Aim<T> aim(centre, uneven_radii<T>(1.0));
  for (const double distance : {1e5, 30.0, 1.3, 0.4, 0.05}) {
    CAPTURE(distance);
    const auto away = Vec3<T>(glm::normalize(Vec3<double>(2, -1, 3)));
    const Vec3<T> point = centre + away * static_cast<T>(distance);
    const Frame<T> frame = Frame<T>::around(-away);
    // ∫ 2π sin θ q(θ) dθ = ∫ 2π q sin θ / (d cos θ) db over b = d sin θ. In each ring the density
    // is constant, and the solid angle between two angles is 2π times the difference of the
    // cosines.
    double integral = 0;
    for (std::size_t k = 0; k < Aim<T>::rings; ++k) {
      const double inner = static_cast<double>(aim.radii()[k]), outer = static_cast<double>(aim.radii()[k + 1]);
      if (inner >= distance) continue;
      const double from = std::asin(inner / distance), to = std::asin(std::min(1.0, outer / distance));
      const double solid_angle = 4 * pi<double> * std::sin((to - from) / 2) * std::sin((to + from) / 2);
      const double theta = (from + to) / 2;
      const Vec3<T> direction =
          frame.to_world({static_cast<T>(std::sin(theta)), T(0), static_cast<T>(std::cos(theta))});
      // The point of the line that is nearest to the centre.
      const Vec3<T> on_line = centre + frame.to_world({static_cast<T>(distance * std::sin(theta) * std::cos(theta)),
                                                       T(0), static_cast<T>(-distance * square(std::sin(theta)))});
      integral += solid_angle * static_cast<double>(aim.direction_density(point, direction, on_line));
      CHECK(aim.direction_density(point, -direction, on_line) == T(0));
    }
    CHECK(integral + static_cast<double>(aim.failure(point)) == Approx(1.0).epsilon(1e-3));
  }
  // Parallel lines: the rings are flat.
  const Vec3<T> direction = glm::normalize(Vec3<T>(1, 2, -2));
  const Frame<T> frame = Frame<T>::around(direction);
  double integral = 0;
  for (std::size_t k = 0; k < Aim<T>::rings; ++k) {
    const double inner = static_cast<double>(aim.radii()[k]), outer = static_cast<double>(aim.radii()[k + 1]);
    const Vec3<T> on_line = centre + frame.to_world({T(0), static_cast<T>((inner + outer) / 2), T(7)});
    integral +=
        pi<double> * (square(outer) - square(inner)) * static_cast<double>(aim.line_density(direction, on_line));
  }
  CHECK(integral == Approx(1.0).epsilon(1e-4));
  CHECK(aim.line_density(direction, centre + frame.tangent * (aim.radii().back() * T(1.01))) == T(0));
}

TEMPLATE_TEST_CASE("An aim: as many samples in each ring and sector as its density says", "[emission]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(5));
  const Vec3<T> centre(T(1), T(2), T(-1));
  const Aim<T> aim(centre, uneven_radii<T>(1.0));
  constexpr int count = 100'000;
  constexpr std::size_t halves = 2, sectors = 4;
  for (const double distance : {2000.0, 0.5, 0.0}) {  // 0: parallel lines
    CAPTURE(distance);
    const Vec3<double> axis = glm::normalize(Vec3<double>(1, 1, -2));
    const Vec3<double> point = Vec3<double>(centre) - axis * distance;
    // Each ring in two parts of the same solid angle or area, by four sectors.
    std::vector<double> counts(Aim<T>::rings * halves * sectors, 0.0), expected(counts.size(), 0.0);
    const auto measure = [&](double radius) {
      if (distance == 0.0) return square(radius);
      return 1 - std::sqrt(1 - square(std::min(1.0, radius / distance)));
    };
    double failures = 0, samples = 0;
    for (int i = 0; i < count; ++i) {
      Vec3<double> across;
      if (distance == 0.0) {
        const Vec3<T> on_line = aim.sample_line(Vec3<T>(axis), two<T>(source));
        across = Vec3<double>(on_line) - Vec3<double>(centre);
      } else {
        const auto direction = aim.sample_direction(Vec3<T>(point), two<T>(source));
        if (!direction) {
          ++failures;
          continue;
        }
        CHECK(std::abs(glm::length(*direction) - T(1)) < T(1e-5));
        across = glm::normalize(Vec3<double>(*direction)) * distance;
      }
      ++samples;
      across -= axis * glm::dot(across, axis);
      const double past = glm::length(across);
      std::size_t ring = 0;
      while (ring + 1 < Aim<T>::rings && static_cast<double>(aim.radii()[ring + 1]) < past) ++ring;
      const double inner = measure(static_cast<double>(aim.radii()[ring])),
                   outer = measure(static_cast<double>(aim.radii()[ring + 1]));
      const std::size_t half = measure(past) > (inner + outer) / 2 ? 1 : 0;
      const Frame<double> frame = Frame<double>::around(axis);
      const double turn = std::atan2(glm::dot(across, frame.bitangent), glm::dot(across, frame.tangent));
      const auto sector = std::min<std::size_t>(3, static_cast<std::size_t>((turn / pi<double> + 1) * 2));
      ++counts[(ring * halves + half) * sectors + sector];
    }
    double reached = 0;
    for (std::size_t k = 0; k < Aim<T>::rings; ++k)
      reached += distance == 0.0 || static_cast<double>(aim.radii()[k]) < distance;
    const double failing = 1 - reached / 16;  // 0 from far away: no draw may fail there
    CHECK(failures == Approx(count * failing).margin(6 * std::sqrt(failing * (1 - failing) * count)));
    if (distance > 0.0)
      CHECK(static_cast<double>(aim.failure(Vec3<T>(point))) == Approx(1 - reached / 16).margin(1e-6));
    std::vector<double> seen, wanted;
    for (std::size_t i = 0; i < counts.size(); ++i)
      if (i / (halves * sectors) < static_cast<std::size_t>(reached)) {
        seen.push_back(counts[i]);
        wanted.push_back(samples / (reached * halves * sectors));
      } else {
        CHECK(counts[i] == 0.0);
      }
    CHECK(chi_square_p(seen, wanted) > level);
  }
}
