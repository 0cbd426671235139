#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "gmis/transport/photons/light_vertex_grid.hpp"
#include "support/backward_executor.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// A query must return exactly the brute-force set, each point once.

namespace {

using Point = gmis::Vec3<float>;

gmis::SerialExecutor one_thread;

std::vector<std::uint32_t> by_force(const std::vector<Point>& points, const Point& at, float radius) {
  std::vector<std::uint32_t> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point offset = points[i] - at;
    if (glm::dot(offset, offset) <= radius * radius) found.push_back(static_cast<std::uint32_t>(i));
  }
  return found;
}

/// The number of queries, of those around the points and far outside them, whose answer differs
/// from the brute-force one.
int wrong_answers(const std::vector<Point>& points, float radius, std::mt19937& source, int queries) {
  gmis::LightVertexGrid<float> grid;
  grid.build(one_thread, points.size(), radius, [&](std::size_t i) { return points[i]; });
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
  std::mt19937 source(gmis_test::seed(7));
  for (const std::size_t count : {0U, 1U, 2U, 3U, 17U, 300U, 3000U})
    for (const float radius : {0.0F, 1e-7F, 1e-3F, 0.05F, 0.7F, 100.0F}) {
      CAPTURE(count, radius);
      CHECK(wrong_answers(random_points(count, source), radius, source, 200) == 0);
    }
}

TEST_CASE("the grid is exact in awkward layouts") {
  std::mt19937 source(gmis_test::seed(8));
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
    grid.build(one_thread, points.size(), 0.25F, [&](std::size_t i) { return points[i]; });
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
  SECTION("few buckets: rows of cells share some of them, in either order") {
    int wrong = 0;
    for (int layout = 0; layout < 400; ++layout) wrong += wrong_answers(random_points(4, source), 0.05F, source, 50);
    CHECK(wrong == 0);
  }
  SECTION("a flat layout") {
    std::vector<Point> points = random_points(2000, source);
    for (Point& point : points) point.y = 0.5F;
    CHECK(wrong_answers(points, 0.03F, source, 1000) == 0);
  }
}

TEST_CASE("a grid can be built again with other points, and a query that is not finite finds nothing") {
  std::mt19937 source(gmis_test::seed(9));
  gmis::LightVertexGrid<float> grid;
  int found = 0;
  grid.query(Point(0.0F), [&](std::uint32_t) { ++found; });
  CHECK(found == 0);
  for (const std::size_t count : {1000U, 10U, 0U, 50U}) {
    const auto points = random_points(count, source);
    grid.build(one_thread, points.size(), 2.0F, [&](std::size_t i) { return points[i]; });
    found = 0;
    grid.query(Point(0.0F), [&](std::uint32_t) { ++found; });
    CHECK(found == static_cast<int>(by_force(points, Point(0.0F), 2.0F).size()));
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    found = 0;
    for (const Point& at : {Point(nan, 0.0F, 0.0F), Point(0.0F, nan, 0.0F), Point(0.0F, 0.0F, nan),
                            Point(infinity, 0.0F, 0.0F), Point(0.0F, -infinity, 0.0F), Point(0.0F, 0.0F, infinity)})
      grid.query(at, [&](std::uint32_t) { ++found; });
    CHECK(found == 0);
  }
}

namespace {

/// A layout with any number of points, any extent, shape, share of repeated points and place.
template <class T>
struct Layout {
  std::vector<gmis::Vec3<T>> points;
  T radius;
  std::string description;
};

template <class T>
Layout<T> random_layout(std::mt19937_64& source) {
  using V = gmis::Vec3<T>;
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto log_uniform = [&](double low, double high) { return std::pow(10.0, low + (high - low) * unit(source)); };
  const auto pick = [&](int count) { return static_cast<int>(source() % static_cast<std::uint64_t>(count)); };

  // Twice as many buckets as points: 1 to 65,536.
  const auto count = static_cast<std::size_t>(std::exp2(15.0 * unit(source)) - (pick(6) == 0 ? 1.0 : 0.0));
  const double scale = pick(3) == 0 ? log_uniform(-15.0, 15.0) : log_uniform(-2.0, 2.0);
  const int shape = pick(6);
  const V offset =
      pick(3) == 0 ? V(static_cast<T>(scale * log_uniform(0.0, 5.0)), static_cast<T>(-2.0 * scale), T(0)) : V(T(0));
  const double repeated = pick(3) == 0 ? unit(source) : 0.0;
  Layout<T> layout;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && unit(source) < repeated) {
      layout.points.push_back(layout.points[source() % i]);
      continue;
    }
    glm::dvec3 at(unit(source), unit(source), unit(source));
    if (shape == 1) at.z = 0.3;                                 // a plane
    if (shape == 2) at.y = at.z = 0.7;                          // a line
    if (shape == 3) at = glm::floor(at * 12.0) / 12.0;          // a lattice
    if (shape == 4) at = pick(50) == 0 ? at * 1e4 : at * 1e-3;  // one heap, and a few far away
    if (shape == 5) at = glm::dvec3(0.5);                       // one place
    layout.points.push_back(offset + V(at * scale));
  }
  switch (pick(5)) {
    case 0:
      layout.radius = T(0);
      break;
    case 1:
      layout.radius = static_cast<T>(scale * log_uniform(1.0, 3.0));
      break;  // all in one cell
    case 2:
      layout.radius = static_cast<T>(scale / 12.0);
      break;  // the step of the lattice
    default:
      layout.radius = static_cast<T>(scale * log_uniform(-5.0, 0.0));
      break;
  }
  layout.description = std::to_string(count) + " points, scale " + std::to_string(scale) + ", shape " +
                       std::to_string(shape) + ", radius " +
                       std::to_string(static_cast<double>(layout.radius) / scale) + " of the scale, repeated " +
                       std::to_string(repeated);
  return layout;
}

/// Wrong answers to queries at points, at the radius from points and a little to either side,
/// between points, and outside.
template <class T>
int wrong_answers(const Layout<T>& layout, std::mt19937_64& source) {
  using V = gmis::Vec3<T>;
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  gmis::LightVertexGrid<T> grid;
  grid.build(one_thread, layout.points.size(), layout.radius, [&](std::size_t i) { return layout.points[i]; });
  int wrong = 0;
  for (int n = 0; n < 24; ++n) {
    V at = layout.points.empty() ? V(T(0)) : layout.points[source() % layout.points.size()];
    V away = V(glm::dvec3(unit(source), unit(source), unit(source)));
    if (n % 4 == 3) away = V(T(n % 3 == 0), T(n % 3 == 1), T(n % 3 == 2)) * (n % 8 == 3 ? T(1) : T(-1));
    const T length = glm::length(away);
    if (n % 4 >= 2) at += away * (layout.radius / length);
    if (n % 4 == 1) at += away * (layout.radius * T(3));
    if (n % 12 == 5) at += away * T(1e3) * layout.radius;
    std::vector<std::uint32_t> found, expected;
    grid.query(at, [&](std::uint32_t i) { found.push_back(i); });
    for (std::size_t i = 0; i < layout.points.size(); ++i) {
      const V offset = layout.points[i] - at;
      if (glm::dot(offset, offset) <= layout.radius * layout.radius) expected.push_back(static_cast<std::uint32_t>(i));
    }
    std::sort(found.begin(), found.end());
    wrong += found != expected;
  }
  return wrong;
}

template <class T>
void check_random_layouts(std::uint64_t first_seed, int layouts) {
  for (int n = 0; n < layouts; ++n) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(n);
    std::mt19937_64 source(gmis_test::seed(seed));
    const Layout<T> layout = random_layout<T>(source);
    CAPTURE(seed, layout.description);
    CHECK(wrong_answers(layout, source) == 0);
  }
}

}  // namespace

TEST_CASE("whatever the layout, the grid finds exactly the points within the radius") {
  SECTION("float") {
    check_random_layouts<float>(1000, 600);
  }
  SECTION("double") {
    check_random_layouts<double>(5000, 200);
  }
}

namespace {

/// Runs the work on several threads, in turns of any length.
struct ThreadExecutor {
  std::size_t threads;
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) const {
    std::atomic<std::size_t> next = 0;
    std::vector<std::thread> pool;
    for (std::size_t t = 0; t < threads; ++t)
      pool.emplace_back([&] {
        for (std::size_t i = next++; i < count; i = next++) work(i);
      });
    for (std::thread& thread : pool) thread.join();
  }
};

/// The answers to queries around the points, in the order in which they are given.
template <class E>
std::vector<std::uint32_t> answers(const std::vector<Point>& points, float radius, E executor) {
  gmis::LightVertexGrid<float> grid;
  grid.build(
      executor, points.size(), radius, [&](std::size_t i) { return points[i]; },
      [](std::size_t i) { return 3 * i + 1; });
  std::vector<std::uint32_t> all;
  for (std::size_t i = 0; i < points.size(); i += 7) {
    all.push_back(0);
    grid.query(points[i] + Point(0.3F * radius), [&](std::uint32_t name) { all.push_back(name); });
  }
  return all;
}

}  // namespace

TEST_CASE("a grid is the same whoever builds it, and answers by the names of its points") {
  std::mt19937 source(gmis_test::seed(10));
  for (const std::size_t count : {100U, 4096U, 4097U, 30000U}) {
    const auto points = random_points(count, source);
    const auto serial = answers(points, 0.05F, gmis::SerialExecutor{});
    CAPTURE(count, serial.size());
    CHECK(serial.size() > 2 * count / 7);
    CHECK(std::all_of(serial.begin(), serial.end(), [](std::uint32_t name) { return name == 0 || name % 3 == 1; }));
    CHECK(answers(points, 0.05F, gmis_test::BackwardExecutor{}) == serial);
    CHECK(answers(points, 0.05F, ThreadExecutor{2}) == serial);
    CHECK(answers(points, 0.05F, ThreadExecutor{5}) == serial);
  }
}

TEST_CASE("memory of a grid is that of its largest build") {
  std::mt19937 source(gmis_test::seed(11));
  gmis::LightVertexGrid<float> grid;
  for (const std::size_t count : {5000U, 5001U, 20000U, 100U}) {
    const auto points = random_points(count, source);
    grid.build(one_thread, points.size(), 0.05F, [&](std::size_t i) { return points[i]; });
  }
  // 16 bytes a point, 8 for its bucket and its place, 4 for each of at most 4 buckets a point;
  // chunks.
  CHECK(grid.byte_count() <= 20000U * (16 + 8 + 4 * 4) + 16 * 4096);
}
