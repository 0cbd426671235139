#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "gmis/transport/light_vertex_grid.hpp"
#include "support/catch.hpp"

// A query must return exactly the brute-force set, each point once.

namespace {

using Point = gmis::Vec3<float>;

std::vector<std::uint32_t> by_force(const std::vector<Point>& points, const Point& at, float radius) {
  std::vector<std::uint32_t> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point offset = points[i] - at;
    if (glm::dot(offset, offset) <= radius * radius) found.push_back(static_cast<std::uint32_t>(i));
  }
  return found;
}

/// The number of queries, of those around the points and far outside them, whose answer differs from the brute-force one.
int wrong_answers(const std::vector<Point>& points, float radius, std::mt19937& source, int queries) {
  gmis::LightVertexGrid<float> grid;
  grid.build(points.size(), radius, [&](std::size_t i) { return points[i]; });
  std::uniform_real_distribution<float> unit(-1.5F, 1.5F);
  int wrong = 0;
  for (int n = 0; n < queries; ++n) {
    Point at(unit(source), unit(source), unit(source));
    if (!points.empty() && n % 2 == 0) at = points[source() % points.size()] + at * radius;
    if (n % 7 == 0) at *= 3.0F;
    std::vector<std::uint32_t> found;
    grid.query(at, [&](std::uint32_t i) { found.push_back(i); });
    std::sort(found.begin(), found.end());
    wrong += found != by_force(points, at, radius);
  }
  return wrong;
}

std::vector<Point> random_points(std::size_t count, std::mt19937& source, float scale = 1.0F,
                                 Point offset = Point(0.0F)) {
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::vector<Point> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back(offset + scale * Point(unit(source), unit(source), unit(source)));
  return points;
}

}  // namespace

TEST_CASE("the light-vertex grid finds exactly the points within the radius") {
  std::mt19937 source(7);
  for (const std::size_t count : {0U, 1U, 2U, 3U, 17U, 300U, 3000U})
    for (const float radius : {0.0F, 1e-7F, 1e-3F, 0.05F, 0.7F, 100.0F}) {
      CAPTURE(count, radius);
      CHECK(wrong_answers(random_points(count, source), radius, source, 200) == 0);
    }
}

TEST_CASE("the grid is exact in awkward layouts") {
  std::mt19937 source(8);
  SECTION("all points in one place") {
    const std::vector<Point> points(500, Point(0.25F, -0.5F, 1.0F));
    for (const float radius : {0.0F, 0.1F}) CHECK(wrong_answers(points, radius, source, 50) == 0);
  }
  SECTION("duplicates in position") {
    std::vector<Point> points = random_points(200, source);
    points.insert(points.end(), points.begin(), points.begin() + 100);
    for (const float radius : {0.0F, 0.1F}) CHECK(wrong_answers(points, radius, source, 400) == 0);
  }
  SECTION("points on a lattice whose step is the radius: distances at the border of ≤") {
    std::vector<Point> points;
    for (int x = -4; x <= 4; ++x)
      for (int y = -4; y <= 4; ++y)
        for (int z = -4; z <= 4; ++z) points.push_back(0.25F * Point(x, y, z));
    gmis::LightVertexGrid<float> grid;
    grid.build(points.size(), 0.25F, [&](std::size_t i) { return points[i]; });
    for (const Point& at : points) {
      std::size_t found = 0;
      grid.query(at, [&](std::uint32_t) { ++found; });
      CHECK(found == by_force(points, at, 0.25F).size());
    }
  }
  SECTION("far from the origin, where the radius is near the spacing of floats") {
    CHECK(wrong_answers(random_points(500, source, 1.0F, Point(1e4F, -3e4F, 2e4F)), 4e-3F, source, 400) == 0);
  }
  SECTION("a tiny radius in a huge box: cell coordinates stay in range") {
    CHECK(wrong_answers(random_points(500, source, 1e20F), 1e-10F, source, 100) == 0);
  }
  SECTION("a flat layout") {
    std::vector<Point> points = random_points(2000, source);
    for (Point& point : points) point.y = 0.5F;
    CHECK(wrong_answers(points, 0.03F, source, 1000) == 0);
  }
}

TEST_CASE("a grid can be built again with other points, and a query that is not a number finds nothing") {
  std::mt19937 source(9);
  gmis::LightVertexGrid<float> grid;
  int found = 0;
  grid.query(Point(0.0F), [&](std::uint32_t) { ++found; });
  CHECK(found == 0);
  for (const std::size_t count : {1000U, 10U, 0U, 50U}) {
    const auto points = random_points(count, source);
    grid.build(points.size(), 2.0F, [&](std::size_t i) { return points[i]; });
    found = 0;
    grid.query(Point(0.0F), [&](std::uint32_t) { ++found; });
    CHECK(found == static_cast<int>(by_force(points, Point(0.0F), 2.0F).size()));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    found = 0;
    grid.query(Point(nan, 0.0F, 0.0F), [&](std::uint32_t) { ++found; });
    grid.query(Point(0.0F, nan, 0.0F), [&](std::uint32_t) { ++found; });
    CHECK(found == 0);
  }
}
