#include "gmis/core/warp.hpp"

#include "gmis/core/density_tests.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;

namespace {

// False-alarm rate of the family of all χ² tests in this file: 1e-3.
const double level = sidak_level(1e-3, 14);

template <std::floating_point T>
Vec2<T> square_point(Philox& source) {
  const T x = uniform<T>(source);
  return {x, uniform<T>(source)};
}

TEMPLATE_TEST_CASE("maps of the square make the densities they state", "[warp]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(3));
  const Vec3<T> axis(0, 0, 1);
  const auto sphere = check_directions<T>(
      axis, [&] { return std::optional(square_to_sphere(square_point<T>(source))); },
      [](const Vec3<T>&) { return T(1) / (T(4) * pi<T>); });
  CHECK(sphere.passes(level));
  CHECK(sphere.integral == Approx(1).epsilon(1e-5));

  const auto cosine = check_directions<T>(
      axis, [&] { return std::optional(square_to_cosine_hemisphere(square_point<T>(source))); },
      [](const Vec3<T>& w) { return std::max(T(0), w.z) / pi<T>; });
  CHECK(cosine.passes(level));
  CHECK(cosine.integral == Approx(1).epsilon(1e-5));

  const auto octahedral = check_directions<T>(
      axis, [&] { return std::optional(square_to_octahedral_hemisphere(square_point<T>(source))); },
      [](const Vec3<T>& w) { return w.z > T(0) ? octahedral_hemisphere_density(w) : T(0); });
  CHECK(octahedral.passes(level));
  CHECK(octahedral.integral == Approx(1).epsilon(1e-5));

  // Rims that fall on the border of two rows of bins.
  for (const T drop : {T(1), T(2)}) {
    const auto cone = check_directions<T>(
        axis, [&] { return std::optional(square_to_cone(square_point<T>(source), drop)); },
        [drop](const Vec3<T>& w) { return w.z >= T(1) - drop ? T(1) / (T(2) * pi<T> * drop) : T(0); });
    CHECK(cone.passes(level));
  }
}

TEMPLATE_TEST_CASE("what is drawn over a hemisphere has a density, on the border of the square too", "[warp]", float,
                   double) {
  using T = TestType;
  for (const T x : {T(0), T(0.3), T(0.5), std::nextafter(T(1), T(0))})
    for (const T y : {T(0), T(0.7), std::nextafter(T(1), T(0))}) {
      const Vec3<T> edge = square_to_cosine_hemisphere(Vec2<T>{x, y}),
                    other = square_to_cosine_hemisphere(Vec2<T>{y, x});
      CHECK(edge.z > T(0));
      CHECK(other.z > T(0));
      CHECK(std::abs(glm::length(edge) - T(1)) < T(2) * std::numeric_limits<T>::epsilon());
    }
}

TEMPLATE_TEST_CASE("the octahedral map of the square has an inverse", "[warp]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(5));
  for (int i = 0; i < 1000; ++i) {
    const Vec2<T> point = square_point<T>(source);
    const Vec3<T> w = square_to_octahedral_hemisphere(point);
    CHECK(w.z >= T(0));
    CHECK(std::abs(glm::length(w) - T(1)) < T(4) * std::numeric_limits<T>::epsilon());
    CHECK(glm::distance(octahedral_hemisphere_to_square(w), point) < T(8) * std::numeric_limits<T>::epsilon());
  }
}

TEMPLATE_TEST_CASE("the maps of the square to sphere and triangle have inverses", "[warp]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(6));
  constexpr T tolerance = T(16) * std::numeric_limits<T>::epsilon();
  for (int i = 0; i < 1000; ++i) {
    const Vec2<T> point = square_point<T>(source);
    if (point.x == T(0)) continue;  // the pole and the corner, whatever y is
    CHECK(glm::distance(sphere_to_square(square_to_sphere(point)), point) < tolerance);
    CHECK(glm::distance(triangle_to_square(square_to_triangle(point)), point) < tolerance);
  }
  // Beside the triangle.
  CHECK(triangle_to_square(Vec2<T>(T(-0.25), T(0.5))) == Vec2<T>(T(0.25), T(1)));
  CHECK(triangle_to_square(Vec2<T>(T(1), T(1))) == Vec2<T>(T(1), T(0.5)));
}

TEMPLATE_TEST_CASE("a narrow cone keeps its width", "[warp]", float, double) {
  using T = TestType;
  // Mean of sin² over the cone: drop (1 − drop/3), whatever 1 − drop rounds to.
  const T drop = T(1e-10);
  double sum = 0;
  constexpr int steps = 1000;
  for (int i = 0; i < steps; ++i) {
    const Vec3<T> w = square_to_cone(Vec2<T>((T(i) + T(0.5)) / T(steps), T(0.3)), drop);
    sum += static_cast<double>(w.x) * static_cast<double>(w.x) + static_cast<double>(w.y) * static_cast<double>(w.y);
  }
  CHECK(sum / steps == Approx(1e-10).epsilon(1e-4));
}

TEMPLATE_TEST_CASE("disk and triangle are filled evenly", "[warp]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(4));
  constexpr int count = 100'000;
  constexpr std::size_t cells = 8;
  std::array<double, cells * cells> disk{}, triangle{}, expected{};
  expected.fill(double(count) / double(cells * cells));
  const auto bin = [](double x, double y) {
    const auto at = [](double v) { return std::min(static_cast<std::size_t>(std::max(v, 0.0) * cells), cells - 1); };
    return at(x) * cells + at(y);
  };
  int outside = 0;
  for (int i = 0; i < count; ++i) {
    const Vec2<T> d = square_to_disk(square_point<T>(source));
    const double radius2 = static_cast<double>(glm::dot(d, d));
    outside += radius2 > 1.00001 ? 1 : 0;
    ++disk[bin(radius2, std::atan2(double(d.y), double(d.x)) / (2 * pi<double>)+0.5)];
    // P(b + c < s) = s² and b/(b + c) is uniform.
    const Vec2<T> b = square_to_triangle(square_point<T>(source));
    outside += b.x < T(0) || b.y < T(0) || b.x + b.y > T(1.00001) ? 1 : 0;
    const double s = static_cast<double>(b.x + b.y);
    ++triangle[bin(s * s, static_cast<double>(b.x) / s)];
  }
  CHECK(outside == 0);
  CHECK(chi_square_test(disk, expected).passes(level));
  CHECK(chi_square_test(triangle, expected).passes(level));
}

TEMPLATE_TEST_CASE("a frame is orthonormal and right-handed around any axis", "[math]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(5));
  const T tolerance = 16 * std::numeric_limits<T>::epsilon();
  for (int i = 0; i < 20'000; ++i) {
    Vec3<T> axis = square_to_sphere(square_point<T>(source));
    if (i % 4 == 1) axis = glm::normalize(Vec3<T>(axis.x * T(1e-6), axis.y * T(1e-6), -1));
    if (i == 2) axis = {0, 0, -1};
    const auto frame = Frame<T>::around(axis);
    T worst = std::max({std::abs(glm::dot(frame.tangent, frame.bitangent)), std::abs(glm::dot(frame.tangent, axis)),
                        std::abs(glm::dot(frame.bitangent, axis)), std::abs(glm::length(frame.tangent) - T(1)),
                        std::abs(glm::length(frame.bitangent) - T(1)),
                        glm::length(glm::cross(frame.tangent, frame.bitangent) - axis)});
    const Vec3<T> w = square_to_sphere(square_point<T>(source));
    worst = std::max(worst, glm::length(frame.to_world(frame.to_local(w)) - w));
    worst = std::max(worst, std::abs(glm::dot(reflect_about(w, axis), axis) - glm::dot(w, axis)));
    // The part along the surface turns round; rounded twice as often as the rest.
    const Vec3<T> local = frame.to_local(w), mirrored = frame.to_local(reflect_about(w, axis));
    worst = std::max(worst, glm::length(mirrored + Vec3<T>(local.x, local.y, -local.z)) / T(2));
    if (!(worst <= tolerance)) FAIL("axis " << axis.x << ' ' << axis.y << ' ' << axis.z << ": error " << worst);
  }
}

}  // namespace
