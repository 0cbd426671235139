#include "gmis/core/density_tests.hpp"
#include "scene/shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;
using namespace scene_test;

namespace {

template <std::floating_point T>
SurfacePoint<T> receiver(const Vec3<double>& position, const Vec3<double>& normal) {
  return {Vec3<T>(position), Vec3<T>(normal), Vec3<T>(normal), T(0)};
}

struct Mean {
  double mean, standard_error;
};

/// Irradiance at a point by next-event samples: weight · cos.
template <std::floating_point T>
Mean irradiance(const scene::Light<T>& light, const SurfacePoint<T>& at, Philox& source, int count = 100'000) {
  double sum = 0, squares = 0;
  for (int i = 0; i < count; ++i) {
    const auto sample = light.sample_next_event(at, random_square<T>(source));
    if (!sample) continue;
    const double value = static_cast<double>(sample->weight.x) *
                         std::max(0.0, static_cast<double>(glm::dot(at.shading_normal, sample->to_light)));
    sum += value;
    squares += value * value;
  }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean) / count)};
}

// Level of each z- and χ² test here, for 1e-3 in all.
const double level = sidak_level(1e-3, 90);

template <std::floating_point T>
scene::Light<T> triangle_light(const Vec3<double>& a, const Vec3<double>& b, const Vec3<double>& c,
                               bool two_sided = false) {
  const auto normal = glm::normalize(glm::cross(b - a, c - a));
  return scene::Light<T>::triangle(Vec3<T>(a), Vec3<T>(b), Vec3<T>(c), Vec3<T>(normal), T(0), Vec3<T>(2), two_sided);
}

/// Irradiance of a polygon that the horizon does not cut: L/2 Σ angle · (edge normal · n) [Lambert
/// 1760].
double polygon_irradiance(const std::vector<Vec3<double>>& corners, const Vec3<double>& from,
                          const Vec3<double>& normal) {
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto a = glm::normalize(corners[i] - from);
    const auto b = glm::normalize(corners[(i + 1) % corners.size()] - from);
    sum += std::acos(glm::dot(a, b)) * glm::dot(glm::normalize(glm::cross(a, b)), normal);
  }
  return std::abs(sum) / 2;
}

TEMPLATE_TEST_CASE("irradiance of a rectangle of two triangles is Lambert's", "[light]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(51));
  const Vec3<double> a(-1, 2, -0.5), b(1, 2, -0.5), c(1, 2.5, 1), d(-1, 2.5, 1);
  for (const Vec3<double> position : {Vec3<double>(0, 0, 0), Vec3<double>(3, 0.2, -1), Vec3<double>(-0.5, 1.7, 0)}) {
    const auto at = receiver<T>(position, {0, 1, 0});
    const double exact = 2 * polygon_irradiance({a, b, c, d}, position, {0, 1, 0});
    const auto first = irradiance(triangle_light<T>(a, b, c), at, source);
    const auto second = irradiance(triangle_light<T>(a, c, d), at, source);
    CHECK(
        z_test(first.mean + second.mean, std::hypot(first.standard_error, second.standard_error), exact).passes(level));
    // From behind it is dark, or not when both sides emit.
    CHECK(irradiance(triangle_light<T>(a, c, b), at, source, 1000).mean == 0);
    const auto back = irradiance(triangle_light<T>(a, c, b, true), at, source);
    CHECK(z_test(back.mean, back.standard_error, 2 * polygon_irradiance({a, b, c}, position, {0, 1, 0})).passes(level));
  }
}

TEMPLATE_TEST_CASE("irradiance of a sphere is L π r²/d² cos, from near and from far, and π L from within", "[light]",
                   float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(52));
  const auto sphere = [](double radius, bool inward, bool two_sided) {
    return scene::Light<T>::sphere(Vec3<T>(0, 0, 0), T(radius), inward, T(0), Vec3<T>(2), two_sided);
  };
  for (const double distance : {1.001, 1.5, 10.0, 1e4}) {
    // Tilted as far as the whole sphere stays above the horizon.
    const double tilt = distance < 1.1 ? 0 : 0.7 * std::acos(1 / distance);
    const auto at = receiver<T>({0, -distance, 0}, {std::sin(tilt), std::cos(tilt), 0});
    const double exact = 2 * pi<double> / (distance * distance) * std::cos(tilt);
    const auto found = irradiance(sphere(1, false, false), at, source);
    CAPTURE(distance, found.mean, exact, found.standard_error);
    CHECK(normal_p_value((found.mean - exact) / (found.standard_error + 2e-6 * exact)) > level);
    CHECK(irradiance(sphere(1, true, false), at, source, 1000).mean == 0);
    const auto both = irradiance(sphere(1, true, true), at, source);
    CHECK(normal_p_value((both.mean - exact) / (both.standard_error + 2e-6 * exact)) > level);
  }
  const auto within = irradiance(sphere(1, true, false), receiver<T>({0.3, 0.2, -0.4}, {0, 1, 0}), source);
  CHECK(z_test(within.mean, within.standard_error, 2 * pi<double>).passes(level));
  CHECK(irradiance(sphere(1, false, false), receiver<T>({0.3, 0.2, -0.4}, {0, 1, 0}), source, 1000).mean == 0);
}

TEST_CASE("irradiance of lights at a point, in a direction, all around", "[light]") {
  using T = double;
  Philox source(gmis_test::seed(53));
  const auto at = receiver<T>({1, 2, 3}, {0, 1, 0});
  const auto point = scene::Light<T>::point({1, 4, 4}, Vec3<T>(3));
  CHECK(irradiance(point, at, source, 1).mean == Approx(3.0 / 5 * 2 / std::sqrt(5.0)));
  auto sun = scene::Light<T>::directional(glm::normalize(Vec3<T>(1, 2, 0)), Vec3<T>(3));
  sun.enclose({0, 0, 0}, 5);
  CHECK(irradiance(sun, at, source, 1).mean == Approx(3 * 2 / std::sqrt(5.0)));
  auto sky = scene::Light<T>::environment(Vec3<T>(3));
  sky.enclose({0, 0, 0}, 5);
  const auto found = irradiance(sky, at, source);
  CHECK(z_test(found.mean, found.standard_error, 3 * pi<T>).passes(level));
}

/// Compares the flux that a light emits through a plane far below with the irradiance that next
/// event gives there: flux through a window by emission, and by integrating next event over the
/// window.
template <std::floating_point T>
void compare_emission_with_next_event(const scene::Light<T>& light, Philox& source) {
  constexpr int count = 200'000;
  const double y = -3;
  double emitted = 0, emitted2 = 0, received = 0, received2 = 0;
  for (int i = 0; i < count; ++i) {
    const auto start = light.sample_emission(random_square<T>(source), random_square<T>(source));
    if (start && start->direction.y != T(0)) {
      const double t = (y - static_cast<double>(start->origin.position.y)) / static_cast<double>(start->direction.y);
      const double x = static_cast<double>(start->origin.position.x) + t * static_cast<double>(start->direction.x);
      const double z = static_cast<double>(start->origin.position.z) + t * static_cast<double>(start->direction.z);
      if (t > 0 && std::abs(x) < 1 && std::abs(z) < 1) {
        emitted += static_cast<double>(start->weight.x) / count;
        emitted2 += static_cast<double>(start->weight.x) * static_cast<double>(start->weight.x) / count;
      }
    }
    const Vec2<double> place = random_square<double>(source);
    const auto at = receiver<T>({2 * place.x - 1, y, 2 * place.y - 1}, {0, 1, 0});
    const auto sample = light.sample_next_event(at, random_square<T>(source));
    if (!sample) continue;
    // From both sides: emission does not ask which side of the window it meets.
    const double value = 4 * static_cast<double>(sample->weight.x) * std::abs(static_cast<double>(sample->to_light.y));
    received += value / count;
    received2 += value * value / count;
  }
  const double error = std::sqrt((emitted2 - emitted * emitted + received2 - received * received) / count);
  CAPTURE(emitted, received, error);
  CHECK(received > 10 * error);
  CHECK(z_test(emitted, error, received).passes(level));
}

TEMPLATE_TEST_CASE("emission and next event carry the same light", "[light]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(54));
  const auto enclosed = [](scene::Light<T> light) {
    light.enclose(Vec3<T>(0, -1, 0), T(5));
    return light;
  };
  compare_emission_with_next_event(triangle_light<T>({-1, 0, 0}, {1, 0, 0.3}, {0, 0.3, 1}), source);
  compare_emission_with_next_event(triangle_light<T>({-1, 0, 0}, {1, 0, 0.3}, {0, 0.3, 1}, true), source);
  compare_emission_with_next_event(scene::Light<T>::sphere(Vec3<T>(0.2, 0, 0), T(0.7), false, T(0), Vec3<T>(1), false),
                                   source);
  compare_emission_with_next_event(scene::Light<T>::sphere(Vec3<T>(0, -2, 0), T(4), true, T(0), Vec3<T>(1), false),
                                   source);
  compare_emission_with_next_event(scene::Light<T>::point(Vec3<T>(0.2, 0, 0), Vec3<T>(1)), source);
  compare_emission_with_next_event(
      enclosed(scene::Light<T>::directional(glm::normalize(Vec3<T>(0.3, 1, 0.2)), Vec3<T>(1))), source);
  compare_emission_with_next_event(enclosed(scene::Light<T>::environment(Vec3<T>(1))), source);
}

/// The densities that samples carry are those that `emitted` and `next_event_density` give, and
/// weights are what the interface says they are.
template <std::floating_point T>
void check_densities(const scene::Light<T>& light, bool is_area, double tolerance, Philox& source) {
  const auto at = receiver<T>({0.3, -3, 0.1}, {0, 1, 0});
  double worst = 0;
  const auto compare = [&](T a, T b) {
    worst = std::max(worst, std::abs(double(a) - double(b)) / std::max(std::abs(double(a)), 1e-30));
  };
  for (int i = 0; i < 2000; ++i) {
    const auto start = light.sample_emission(random_square<T>(source), random_square<T>(source));
    if (start && is_area && std::abs(glm::dot(start->origin.geometric_normal, start->direction)) > T(0.01)) {
      const auto emitted = light.emitted(start->origin, start->direction);
      compare(emitted.density.origin, start->density.origin);
      compare(emitted.density.first, start->density.first);
      const T cosine = std::abs(glm::dot(start->origin.geometric_normal, start->direction));
      compare(start->weight.x, emitted.radiance.x * cosine / (start->density.origin * start->density.first));
    }
    if (start && !is_area && !light.is_delta()) {
      const auto emitted = light.emitted(start->origin, start->direction);
      compare(emitted.density.origin, start->density.origin);
      compare(emitted.density.first, start->density.first);
      compare(start->weight.x, emitted.radiance.x / (start->density.origin * start->density.first));
    }
    if (start && light.is_delta()) {
      // Two units down the way, next event gives the intensity over the square of the distance, or
      // the irradiance.
      const auto there = receiver<T>(Vec3<double>(start->origin.position + start->direction * T(2)), {0, 1, 0});
      const auto arriving = light.sample_next_event(there, {T(0.5), T(0.5)});
      // Where a spot fades out, its falloff has few digits.
      if (arriving && arriving->density.first > T(1e-3)) {
        compare(start->density.first * start->weight.x, arriving->weight.x * (light.is_infinite() ? T(1) : T(4)));
        compare(start->density.first, arriving->density.first);
      }
    }
    const auto sample = light.sample_next_event(at, random_square<T>(source));
    if (!sample) continue;
    const T cosine = std::abs(glm::dot(sample->origin.geometric_normal, sample->to_light));
    if (is_area && cosine < T(0.02)) continue;
    compare(sample->next_event_density, light.next_event_density(sample->origin, -sample->to_light, at));
    if (light.is_delta()) continue;
    const auto emitted = light.emitted(sample->origin, -sample->to_light);
    compare(emitted.density.origin, sample->density.origin);
    compare(emitted.density.first, sample->density.first);
    T per_steradian = sample->next_event_density;
    if (is_area) {
      const Vec3<T> offset = sample->origin.position - at.position;
      per_steradian *= glm::dot(offset, offset) / cosine;
    }
    compare(sample->weight.x, emitted.radiance.x / per_steradian);
  }
  CHECK(worst < tolerance);
}

TEMPLATE_TEST_CASE("samples carry the densities that the light states for them", "[light]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(55));
  const double tolerance = std::same_as<T, float> ? 1e-3 : 1e-11;
  check_densities(triangle_light<T>({-1, 0, 0}, {1, 0, 0.3}, {0, 0.3, 1}), true, tolerance, source);
  check_densities(triangle_light<T>({-1, 0, 0}, {1, 0, 0.3}, {0, 0.3, 1}, true), true, tolerance, source);
  check_densities(scene::Light<T>::sphere(Vec3<T>(0.2, 0, 0), T(0.7), false, T(0), Vec3<T>(1), false), true, tolerance,
                  source);
  check_densities(scene::Light<T>::sphere(Vec3<T>(0, -2, 0), T(4), true, T(0), Vec3<T>(1), true), true, tolerance,
                  source);
  check_densities(scene::Light<T>::point(Vec3<T>(0.2, 0, 0), Vec3<T>(1)), false, tolerance, source);
  auto sky = scene::Light<T>::environment(Vec3<T>(1));
  sky.enclose(Vec3<T>(0, 0, 0), T(5));
  check_densities(sky, false, tolerance, source);
  auto sun = scene::Light<T>::directional(glm::normalize(Vec3<T>(1, 2, 0)), Vec3<T>(3));
  sun.enclose(Vec3<T>(0, 0, 0), T(5));
  check_densities(sun, false, tolerance, source);
}

template <std::floating_point T>
scene::Light<T> spot(double inner, double outer) {
  return scene::Light<T>::spot(
      Vec3<T>(0.2, 0, 0), SpotCone<T>(Vec3<T>(glm::normalize(glm::dvec3(0.1, -1, 0.2))), inner, outer), Vec3<T>(2));
}

EnvironmentImage small_sky() {
  EnvironmentImage image{{4, 4}, {}, SkyMapping::equal_area};
  for (int i = 0; i < 16; ++i) image.radiance.push_back(glm::vec3(i % 5 == 2 ? 9.0F : 0.5F * static_cast<float>(i)));
  return image;
}

TEMPLATE_TEST_CASE("spot lights and image skies: emission, next event and stated densities agree", "[light]", float,
                   double) {
  using T = TestType;
  Philox source(gmis_test::seed(59));
  const double tolerance = std::same_as<T, float> ? 1e-3 : 1e-11;
  for (const auto& [inner, outer] : {std::pair{0.2, 0.5}, std::pair{0.3, 0.3}, std::pair{0.0, 2.5}}) {
    compare_emission_with_next_event(spot<T>(inner, outer), source);
    check_densities(spot<T>(inner, outer), false, tolerance, source);
  }
  for (const SkyMapping mapping : {SkyMapping::equal_area, SkyMapping::latitude_longitude}) {
    EnvironmentImage image = small_sky();
    image.mapping = mapping;
    const EnvironmentMap<T> map(image, glm::dmat3(glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0)));
    auto sky = scene::Light<T>::environment(map);
    sky.enclose(Vec3<T>(0, -1, 0), T(5));
    CHECK(sky.is_infinite());
    CHECK_FALSE(sky.is_delta());
    compare_emission_with_next_event(sky, source);
    check_densities(sky, false, tolerance, source);
    // Compensated, next-event samples leave out the dark part: no comparison with emission, but all
    // densities agree.
    const EnvironmentMap<T> compensated(image, glm::dmat3(1), 0.5);
    auto bright = scene::Light<T>::environment(compensated);
    bright.enclose(Vec3<T>(0, -1, 0), T(5));
    check_densities(bright, false, tolerance, source);
  }
}

/// `emission_along` and `start_numbers` are inverses of `sample_emission`. `has_numbers`: the light
/// can tell its numbers.
template <std::floating_point T>
void check_inverse(const scene::Light<T>& light, bool has_numbers, Philox& source) {
  const double tolerance = std::same_as<T, float> ? 2e-4 : 1e-10;
  double worst_number = 0, worst = 0, worst_place = 0;
  const auto compare = [&](T a, T b) {
    worst = std::max(worst, std::abs(double(a) - double(b)) / std::max(std::abs(double(a)), 1e-30));
  };
  for (int i = 0; i < 2000; ++i) {
    const auto uv_origin = random_square<T>(source), uv_direction = random_square<T>(source);
    const auto start = light.sample_emission(uv_origin, uv_direction);
    if (!start) continue;
    const auto numbers = light.start_numbers(start->origin, start->direction);
    REQUIRE(numbers.has_value() == has_numbers);
    if (numbers) {
      const Vec2<T> first = light.is_infinite() ? uv_direction : uv_origin;
      // Near the poles and at the first corner the second number has few digits.
      const double digits = std::min(1.0, double(std::min(first.x, T(1) - first.x)) * 50);
      worst_number = std::max(worst_number, std::abs(double(numbers->x - first.x)));
      const double turn = std::abs(double(numbers->y - first.y));
      worst_number = std::max(worst_number, std::min(turn, std::abs(1 - turn)) * digits);
      REQUIRE((numbers->x >= T(0) && numbers->x <= T(1) && numbers->y >= T(0) && numbers->y <= T(1)));
    }
    auto at = start->origin;
    if (light.is_infinite()) at.position += start->direction * T(3);  // any point of the line
    const auto again = light.emission_along(at, start->direction);
    if (!again) {  // rounding, at the rim of the disk or of a cone, or where a sky changes
      CHECK((light.is_infinite() || light.is_spot()));
      worst_place += 1e-4;
      continue;
    }
    worst_place =
        std::max(worst_place, double(glm::length(again->origin.position - start->origin.position)) / (1 + tolerance));
    REQUIRE(again->direction == start->direction);
    // The falloff of a spot has few digits at its rim, and so has a cosine near 0.
    const bool is_oblique = glm::length(start->origin.geometric_normal) > T(0) &&
                            std::abs(glm::dot(start->origin.geometric_normal, start->direction)) < T(0.02);
    if (is_oblique || (light.is_spot() && start->density.first < T(0.02))) continue;
    compare(start->weight.x, again->weight.x);
    compare(start->density.origin, again->density.origin);
    compare(start->density.first, again->density.first);
  }
  CHECK(worst < 10 * tolerance);
  CHECK(worst_number < tolerance);
  CHECK(worst_place < 0.01);
}

TEMPLATE_TEST_CASE("the start of emission can be inverted for every kind of light", "[light]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(61));
  const auto enclosed = [](scene::Light<T> light) {
    light.enclose(Vec3<T>(0, -1, 0), T(5));
    return light;
  };
  check_inverse(triangle_light<T>({-1, 0, 0}, {1, 0, 0.3}, {0, 0.3, 1}), true, source);
  check_inverse(triangle_light<T>({-1, 0, 0}, {1, 0, 0.3}, {0, 0.3, 1}, true), true, source);
  for (const bool is_inward : {false, true})
    for (const bool is_two_sided : {false, true})
      check_inverse(scene::Light<T>::sphere(Vec3<T>(0.2, 0, 0), T(0.7), is_inward, T(0), Vec3<T>(1), is_two_sided),
                    true, source);
  check_inverse(scene::Light<T>::point(Vec3<T>(0.2, 0, 0), Vec3<T>(1)), false, source);
  check_inverse(spot<T>(0.2, 0.5), false, source);
  check_inverse(enclosed(scene::Light<T>::directional(glm::normalize(Vec3<T>(0.3, 1, 0.2)), Vec3<T>(1))), false,
                source);
  check_inverse(enclosed(scene::Light<T>::environment(Vec3<T>(1))), true, source);
}

TEST_CASE("the start of emission from an image: the direction has no numbers, the rest is inverted", "[light]") {
  Philox source(gmis_test::seed(62));
  EnvironmentImage image{{1, 1}, {glm::vec3(2.0F)}, SkyMapping::latitude_longitude};
  const EnvironmentMap<double> plain(image, glm::dmat3(1)), map(small_sky(), glm::dmat3(1));
  for (const auto* const one : {&plain, &map}) {
    auto sky = scene::Light<double>::environment(*one);
    sky.enclose(Vec3<double>(0, -1, 0), 5);
    check_inverse(sky, false, source);
  }
}

TEST_CASE("no emission along what does not shine", "[light]") {
  using T = double;
  const auto triangle = triangle_light<T>({-1, 0, 0}, {1, 0, 0}, {0, 1, 0});  // shines along +z
  const auto at = receiver<T>({0, 0.2, 0}, {0, 0, 1});
  CHECK(triangle.emission_along(at, {0, 0, 1}).has_value());
  CHECK_FALSE(triangle.emission_along(at, {0, 0, -1}).has_value());
  CHECK_FALSE(spot<T>(0.2, 0.5).emission_along(at, {0, 1, 0}).has_value());
  auto sky = scene::Light<T>::environment(Vec3<T>(1));
  sky.enclose({0, 0, 0}, 2);
  CHECK(sky.emission_along(receiver<T>({0, 1.9, 0}, {0, 1, 0}), {1, 0, 0}).has_value());
  CHECK_FALSE(sky.emission_along(receiver<T>({0, 2.1, 0}, {0, 1, 0}), {1, 0, 0}).has_value());
}

TEST_CASE("a spot light shines as its falloff says, and gives off the power that comes of it", "[light][spot]") {
  using T = double;
  Philox source(gmis_test::seed(60));
  const double inner = 0.4, outer = 0.9;
  const Vec3<T> axis = glm::normalize(Vec3<T>(1, -2, 0.5));
  const auto light = scene::Light<T>::spot({0, 0, 0}, SpotCone<T>(axis, inner, outer), Vec3<T>(3));
  const auto falloff = [&](double angle) {
    const double t = std::clamp((std::cos(angle) - std::cos(outer)) / (std::cos(inner) - std::cos(outer)), 0.0, 1.0);
    return t * t * (3 - 2 * t);
  };
  double flux = 0;
  constexpr int steps = 20'000;
  for (int i = 0; i < steps; ++i) {
    const double angle = outer * (i + 0.5) / steps;
    flux += 3 * falloff(angle) * 2 * pi<T> * std::sin(angle) * outer / steps;
  }
  CHECK(light.power() == Approx(flux).epsilon(1e-6));
  // Walking over the first number walks outwards, and it is the share of the flux that is further
  // in.
  const double a = 1 - std::cos(inner), b = std::cos(inner) - std::cos(outer);
  for (int i = 0; i < 1000; ++i) {
    const double u = (i + 0.5) / 1000;
    const double drop = 1 - glm::dot(SpotCone<T>(axis, inner, outer).sample({u, 0.3}).direction, axis);
    const double t = drop < a ? 1 : 1 - (drop - a) / b;
    const double further_in = drop < a ? drop : a + b * (0.5 - t * t * t + t * t * t * t / 2);
    if (!(std::abs(further_in / (a + b / 2) - u) < 1e-9)) FAIL("the share " << u << " is not where it should be");
  }
  for (const double angle : {0.0, 0.3, 0.5, 0.8, 0.89, 1.0, 3.0}) {
    const Vec3<T> direction = Frame<T>::around(axis).to_world({std::sin(angle), 0, std::cos(angle)});
    const auto sample = light.sample_next_event(receiver<T>(direction * 2.0, {0, 1, 0}), {0.1, 0.2});
    CHECK(sample.has_value() == (angle < outer));
    if (!sample) continue;
    CHECK(sample->weight.x == Approx(3 * falloff(angle) / 4));
    CHECK(sample->density.first == Approx(3 * falloff(angle) / flux).epsilon(1e-6));
  }
  const auto emission = check_directions<T>(
      axis,
      [&]() -> std::optional<Vec3<T>> {
        const auto start = light.sample_emission({0, 0}, random_square<T>(source));
        if (!start) return std::nullopt;
        if (!(std::abs(start->weight.x / flux - 1) < 1e-5)) FAIL("the weight varies");
        const double angle = std::acos(glm::dot(start->direction, axis));
        if (!(std::abs(start->density.first - 3 * falloff(angle) / flux) < 1e-5)) FAIL("another density is stated");
        return start->direction;
      },
      [&](const Vec3<T>& w) { return 3 * falloff(std::acos(std::clamp(glm::dot(w, axis), -1.0, 1.0))) / flux; });
  CHECK(emission.passes(level));
  CHECK(emission.integral == Approx(1).epsilon(1e-4));
}

TEST_CASE("directions of emission are distributed as stated", "[light]") {
  using T = double;
  Philox source(gmis_test::seed(56));
  const auto light = triangle_light<T>({-1, 0, 0}, {1, 0, 0.3}, {0, 0.3, 1}, true);
  const auto origin = light.sample_emission({0.3, 0.4}, {0.1, 0.2})->origin;
  const auto emission = check_directions<T>(
      origin.geometric_normal,
      [&] {
        return std::optional(light.sample_emission({0.3, 0.4}, random_square<T>(source))->direction);
      },
      [&](const Vec3<T>& w) { return light.emitted(origin, w).density.first; });
  CHECK(emission.passes(level));
  CHECK(emission.integral == Approx(1).epsilon(1e-5));

  // Next event on a sphere: directions uniform over the cone.
  const auto ball = scene::Light<T>::sphere({0, 2, 0}, 1, false, 0, Vec3<T>(1), false);
  const auto at = receiver<T>({0, 0, 0}, {0, 1, 0});
  const T drop = 1 - std::sqrt(0.75);
  std::vector<double> counts(100), expected(100, 400.0);
  for (int i = 0; i < 40'000; ++i) {
    const auto sample = ball.sample_next_event(at, random_square<T>(source));
    if (!sample) continue;
    const auto ring = static_cast<std::size_t>(std::clamp((1 - sample->to_light.y) / drop * 10, 0.0, 9.99));
    const auto turn = static_cast<std::size_t>(
        std::clamp((std::atan2(sample->to_light.z, sample->to_light.x) / (2 * pi<T>)+0.5) * 10, 0.0, 9.99));
    ++counts[ring * 10 + turn];
  }
  CHECK(chi_square_test(counts, expected).passes(level));
}

/// χ² of the directions that next event takes against the density it states, from where a ray meets
/// the light.
template <std::floating_point T, class Meet>
void check_next_event_directions(const scene::Light<T>& light, const Vec3<double>& position, const Vec3<double>& axis,
                                 Meet&& meet, Philox& source) {
  const auto at = receiver<T>(position, {0, 1, 0});
  CheckSettings settings;
  settings.samples = 60'000;
  settings.precision = 1e-6;
  const auto check = check_directions<T>(
      Vec3<T>(glm::normalize(axis)),
      [&]() -> std::optional<Vec3<T>> {
        const auto sample = light.sample_next_event(at, random_square<T>(source));
        if (!sample) return std::nullopt;
        return sample->to_light;
      },
      [&](const Vec3<T>& w) -> T {
        const std::optional<SurfacePoint<T>> point = meet(at.position, w);
        if (!point || is_black(light.emitted(*point, -w).radiance)) return T(0);
        const Vec3<T> offset = point->position - at.position;
        const T cosine = std::abs(glm::dot(point->geometric_normal, w));
        return light.next_event_density(*point, -w, at) * glm::dot(offset, offset) / std::max(cosine, T(1e-6));
      },
      settings);
  CAPTURE(check.integral, check.success_share, check.test.statistic, check.test.degrees_of_freedom);
  CHECK(check.test.p_value > level);
  CHECK(check.outside <= 3);  // at the edge of the light, where rounding decides
  CHECK(check.integral < 1.005);
}

TEST_CASE("next event goes where its density says", "[light]") {
  using T = double;
  Philox source(gmis_test::seed(48));
  const Vec3<T> a(-1, 1, -0.5), b(1, 1.4, -0.5), c(0.3, 1.2, 1);
  const Vec3<T> normal = glm::normalize(glm::cross(b - a, c - a));
  for (const bool two_sided : {false, true})
    check_next_event_directions<T>(
        triangle_light<T>(a, b, c, two_sided), {0.2, -0.3, 0.1}, {0, 1, 0},
        [&](const Vec3<T>& from, const Vec3<T>& w) -> std::optional<SurfacePoint<T>> {
          const T t = glm::dot(a - from, normal) / glm::dot(w, normal);
          const Vec3<T> p = from + w * t;
          const auto inside = [&](const Vec3<T>& u, const Vec3<T>& v) {
            return glm::dot(glm::cross(v - u, p - u), normal) >= 0;
          };
          if (!(t > 0) || !inside(a, b) || !inside(b, c) || !inside(c, a)) return std::nullopt;
          return SurfacePoint<T>{p, normal, normal, 0};
        },
        source);
  for (const T radius : {0.5, 3.0})  // seen from outside, and from within
    check_next_event_directions<T>(
        scene::Light<T>::sphere({0, 1, 0}, radius, false, 0, Vec3<T>(1), true), {0.2, -0.3, 0.1}, {-0.2, 1.3, -0.1},
        [&](const Vec3<T>& from, const Vec3<T>& w) -> std::optional<SurfacePoint<T>> {
          const Vec3<T> offset = from - Vec3<T>(0, 1, 0);
          const T half = glm::dot(offset, w), inner = glm::dot(offset, offset) - radius * radius;
          const T root = half * half - inner;
          if (!(root >= 0)) return std::nullopt;
          const T t = inner > 0 ? -half - std::sqrt(root) : -half + std::sqrt(root);
          if (!(t > 0)) return std::nullopt;
          const Vec3<T> outward = (offset + w * t) / radius;
          return SurfacePoint<T>{from + w * t, outward, outward, 0};
        },
        source);
}

TEST_CASE("light subpaths start evenly over a light, and over the disk of an infinite one", "[light]") {
  using T = double;
  Philox source(gmis_test::seed(49));
  constexpr std::size_t across = 12, along = 8;
  const auto check = [&](const scene::Light<T>& light, auto&& place) {
    std::vector<double> counts(across * along), expected(across * along, 300.0);
    for (std::size_t i = 0; i < 300 * across * along; ++i) {
      const auto start = light.sample_emission(random_square<T>(source), random_square<T>(source));
      if (!start) continue;
      const Vec2<T> at = place(*start);
      if (!(at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1)) FAIL("outside at " << at.x << ", " << at.y);
      ++counts[std::min(static_cast<std::size_t>(at.x * across), across - 1) * along +
               std::min(static_cast<std::size_t>(at.y * along), along - 1)];
    }
    CHECK(chi_square_test(counts, expected).passes(level));
  };
  const auto turn = [](T y, T x) { return std::atan2(y, x) / (2 * pi<T>)+0.5; };
  // A triangle folds to the unit square by the share of its area beside an edge and the place
  // across.
  const Vec3<T> a(-1, 0, 0), b(1, 0, 0.3), c(0, 0.3, 1);
  check(triangle_light<T>(a, b, c), [&](const auto& start) {
    const Vec3<T> n = glm::cross(b - a, c - a), p = start.origin.position;
    const T at_b = glm::dot(glm::cross(p - a, c - a), n) / glm::dot(n, n),
            at_c = glm::dot(glm::cross(b - a, p - a), n) / glm::dot(n, n);
    const T far = at_b + at_c;
    return Vec2<T>(std::min(far * far, 1.0), far > 0 ? at_c / far : 0.0);
  });
  check(scene::Light<T>::sphere({1, 2, 3}, 2, true, 0, Vec3<T>(1), false), [&](const auto& start) {
    const Vec3<T> outward = (start.origin.position - Vec3<T>(1, 2, 3)) / 2.0;
    CHECK(std::abs(glm::length(outward) - 1) < 1e-9);
    return Vec2<T>(turn(outward.y, outward.x), std::min((outward.z + 1) / 2, 1.0));
  });
  auto sun = scene::Light<T>::directional(glm::normalize(Vec3<T>(1, 2, 2)), Vec3<T>(1));
  sun.enclose({1, 2, 3}, 4);
  auto sky = scene::Light<T>::environment(Vec3<T>(1));
  sky.enclose({1, 2, 3}, 4);
  const EnvironmentMap<T> map(small_sky(), glm::dmat3(1));
  auto image = scene::Light<T>::environment(map);
  image.enclose({1, 2, 3}, 4);
  for (const auto& light : {sun, sky, image})
    check(light, [&](const auto& start) {
      const Vec3<T> offset = start.origin.position - Vec3<T>(1, 2, 3);
      const Frame<T> frame = Frame<T>::around(start.direction);
      const Vec2<T> disk(glm::dot(offset, frame.tangent) / 4, glm::dot(offset, frame.bitangent) / 4);
      // Before the ball that holds the scene.
      if (!(glm::dot(offset, start.direction) < -4 * (1 - 1e-9))) FAIL("starts within the scene");
      return Vec2<T>(turn(disk.y, disk.x), disk.x * disk.x + disk.y * disk.y);
    });
  // Directions of the lights that shine all around.
  check(scene::Light<T>::point({0, 0, 0}, Vec3<T>(1)), [&](const auto& start) {
    return Vec2<T>(turn(start.direction.y, start.direction.x), (start.direction.z + 1) / 2);
  });
  check(sky, [&](const auto& start) {
    return Vec2<T>(turn(start.direction.y, start.direction.x), (start.direction.z + 1) / 2);
  });
}

TEST_CASE("the alias table gives each index its share, exactly", "[alias]") {
  Philox source(gmis_test::seed(57));
  for (const std::size_t count : {1U, 2U, 7U, 1000U}) {
    std::vector<double> weights(count);
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += weights[i] = i % 3 == 1 ? 0.0 : random_magnitude(source, -6, 2);
    const AliasTable<double> table(weights);
    double worst = 0;
    for (std::size_t i = 0; i < count; ++i) {
      worst = std::max(worst, std::abs(table.probability(i) - weights[i] / sum));
      if (weights[i] == 0) CHECK(table.probability(i) == 0);
    }
    CHECK(worst < 1e-13);
    // Walking u over a fine grid draws what the cells say.
    std::vector<double> drawn(count);
    constexpr int steps = 200'000;
    for (int i = 0; i < steps; ++i) ++drawn[table.sample((i + 0.5) / steps)];
    for (std::size_t i = 0; i < count; ++i)
      if (!(std::abs(drawn[i] / steps - weights[i] / sum) < 2.0 * static_cast<double>(count + 1) / steps))
        FAIL("index " << i << " was drawn with " << drawn[i] / steps);
    CHECK(table.sample(1 - 1e-16) < count);
  }
  const std::vector<double> nothing(3, 0.0);
  CHECK(AliasTable<float>(nothing).is_empty());
}

TEST_CASE("the chances that many lights really have are known", "[alias]") {
  Philox source(gmis_test::seed(50));
  std::vector<double> weights(3000);
  double sum = 0;
  for (double& weight : weights) sum += weight = random_magnitude(source, -4, 0);
  const AliasTable<float> table(weights);
  const std::vector<double> realised = table.realised_probabilities();
  // All the numbers there are.
  constexpr int steps = 1 << 24;
  std::vector<int> counts(weights.size());
  for (int k = 0; k < steps; ++k) ++counts[table.sample(static_cast<float>(k) / static_cast<float>(steps))];
  int wrong = 0;
  double worst = 0, total = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    wrong += static_cast<double>(counts[i]) / steps == realised[i] ? 0 : 1;
    worst = std::max(worst, std::abs(realised[i] - weights[i] / sum));
    total += realised[i];
  }
  CHECK(wrong == 0);
  CHECK(total == 1);
  CHECK(worst < 1e-5);
  const std::vector<double> exact = AliasTable<double>(weights).realised_probabilities();
  worst = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) worst = std::max(worst, std::abs(exact[i] / weights[i] * sum - 1));
  CHECK(worst < 1e-9);
  CHECK(AliasTable<float>(std::vector<double>{0.0, 2.0}).realised_probabilities() == std::vector<double>{0, 1});
}

TEST_CASE("what of a number an alias table does not use is uniform", "[alias]") {
  const std::vector<double> weights{1, 0, 5, 2, 0.1};
  const AliasTable<double> table(weights);
  constexpr int steps = 400'000, bins = 10;
  std::vector<double> drawn(5 * bins);
  for (int i = 0; i < steps; ++i) {
    const double u = (i + 0.5) / steps;
    const auto choice = table.sample_and_reuse(u);
    if (choice.index != table.sample(u) || !(choice.rest >= 0 && choice.rest < 1)) FAIL("another index, or no rest");
    ++drawn[choice.index * bins + static_cast<std::size_t>(choice.rest * bins)];
  }
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t bin = 0; bin < bins; ++bin)
      CHECK(std::abs(drawn[i * bins + bin] / steps - weights[i] / 8.1 / bins) < 3e-5);
  CHECK(table.sample_and_reuse(1 - 1e-16).rest < 1);
}

TEST_CASE("lights are chosen by power, and the chances add up to one", "[light]") {
  SceneBuilder<> builder;
  const auto material = builder.add_material(make_diffuse({.5, .5, .5}));
  builder.add_mesh(box({-1, -1, -1}, {1, 1, 1}).shape(), material);
  builder.add_sphere({0, 0, 0}, 0.1, material, AreaEmission{{1000, 1000, 1000}, false});
  builder.add_point_light({0.5, 0, 0}, {1, 1, 1});
  builder.add_directional_light({0, 1, 0}, {2, 2, 2});
  builder.add_environment({0.1, 0.1, 0.1});
  builder.add_point_light({0.5, 0, 0}, {0, 0, 0});
  builder.add_spot_light({0, 0.5, 0}, {0, -1, 0}, {1, 2, 3}, 0.3, 0.3);
  builder.add_environment(small_sky());
  builder.set_camera(camera_at({0, 0, -0.5}));
  const auto scene = builder.build();
  REQUIRE(scene.lights().size() == 7);
  CHECK(scene.infinite_lights().size() == 3);
  double sum = 0;
  for (const auto& light : scene.lights()) sum += static_cast<double>(scene.selection_probability(light));
  CHECK(sum == Approx(1).epsilon(1e-6));
  const double disk = pi<double> * 3;  // the ball around the box has r² = 3
  const double area = 4 * pi<double> * 0.01 * pi<double> * 1000, point = 4 * pi<double>, sun = 2 * disk,
               sky = 0.1 * 4 * pi<double> * disk / 16, cone = 2 * 2 * pi<double> * (1 - std::cos(0.3));
  double image = 0;
  for (const auto& pixel : small_sky().radiance) image += static_cast<double>(pixel.x) * 4 * pi<double> / 16 * disk;
  const double all = area + point + sun + sky + cone + image;
  CHECK(scene.selection_probability(scene.lights()[0]) == Approx(area / all).epsilon(1e-4));
  // Area lights come first, then points, spots and what is infinitely far.
  CHECK(scene.selection_probability(scene.lights()[3]) == Approx(cone / all).epsilon(1e-4));
  CHECK(scene.selection_probability(scene.lights()[4]) == Approx(sun / all).epsilon(1e-4));
  CHECK(scene.selection_probability(scene.lights()[6]) == Approx(image / all).epsilon(1e-4));
  Philox source(gmis_test::seed(58));
  for (int i = 0; i < 2000; ++i) {
    const auto choice = scene.sample_light(uniform<float>(source));
    REQUIRE(choice.light != nullptr);
    if (!(choice.selection_probability > 0.0F)) FAIL("a light that emits nothing was chosen");
  }
}

TEST_CASE("neither a sky nor a sun starves the lamps", "[light]") {
  const auto chances = [](double half_width, bool has_sky, bool has_sun, double lamps) {
    SceneBuilder<> builder;
    const auto material = builder.add_material(make_diffuse({.5, .5, .5}));
    builder.add_mesh(box({-half_width, -1, -half_width}, {half_width, 1, half_width}).shape(), material);
    builder.add_sphere({0, 0, 0}, 0.1, material, AreaEmission{glm::dvec3(10 * lamps), false});
    builder.add_point_light({0.5, 0, 0}, glm::dvec3(0.1 * lamps));
    if (has_sky) builder.add_environment({0.1, 0.1, 0.1});
    if (has_sun) builder.add_directional_light({0, 1, 0}, {0.3, 0.3, 0.3});
    builder.set_camera(camera_at({0, 0, -0.5}));
    const auto scene = builder.build();
    std::vector<double> result;
    for (const auto& light : scene.lights()) result.push_back(static_cast<double>(scene.selection_probability(light)));
    return result;
  };
  const double disk = pi<double> * 3, lamps = 4 * pi<double> * 0.01 * pi<double> * 10 + 0.1 * 4 * pi<double>;
  // A uniform sky counts a sixteenth of its power.
  const double sky = 0.1 * 4 * pi<double> * disk / 16, sun = 0.3 * disk;
  const auto of_lamps = [&](double half_width, bool has_sky, bool has_sun, double factor) {
    const auto all = chances(half_width, has_sky, has_sun, factor);
    return all[0] + all[1];
  };
  // With a sun: by power, where that gives the lamps a tenth or more.
  CHECK(of_lamps(1, true, true, 1) == Approx(lamps / (lamps + sky + sun)).epsilon(1e-4));
  CHECK(of_lamps(1, false, true, 0.1) == Approx(0.1 * lamps / (0.1 * lamps + sun)).epsilon(1e-4));
  // Else half by power, which is next to nothing, and half as one of three.
  CHECK(of_lamps(1e4, true, true, 1) == Approx(0.5 / 3).epsilon(1e-4));
  CHECK(of_lamps(1e4, false, true, 1) == Approx(0.5 / 2).epsilon(1e-4));
  // With a sky alone: half by power and half as one of two, where they have less than half by
  // power.
  CHECK(of_lamps(1, true, false, 0.05) == Approx(0.5 * 0.05 * lamps / (0.05 * lamps + sky) + 0.5 / 2).epsilon(1e-4));
  CHECK(of_lamps(1, true, false, 1) == Approx(lamps / (lamps + sky)).epsilon(1e-4));
  CHECK(scene::infinite_share(1, 1, 3, false) == Approx(0.25));
  CHECK(of_lamps(1e4, true, false, 1) == Approx(0.5 / 2).epsilon(1e-4));
  // Among themselves lamps are chosen by power, and so is what is infinitely far.
  const auto alone = chances(1, false, false, 1), small = chances(1, true, true, 1), wide = chances(1e4, true, true, 1);
  CHECK(wide[0] / wide[1] == Approx(alone[0] / alone[1]).epsilon(1e-4));
  CHECK(wide[2] / wide[3] == Approx(small[2] / small[3]).epsilon(1e-4));
  CHECK(wide[0] + wide[1] + wide[2] + wide[3] == Approx(1).epsilon(1e-6));
}

/// The flux that a unit of a light's area emits, by quadrature over the directions of both sides:
/// radiance · |cos|, midpoints in the cosine.
template <std::floating_point T>
double emitted_per_area(const scene::Light<T>& light) {
  const SurfacePoint<T> origin{Vec3<T>(0), Vec3<T>(0, 0, 1), Vec3<T>(0, 0, 1), T(0)};
  constexpr int steps = 2000;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double cosine = 2 * (i + 0.5) / steps - 1;
    const Vec3<T> direction(Vec3<double>(std::sqrt(1 - cosine * cosine), 0, cosine));
    const double radiance = static_cast<double>(mean_channel(light.emitted(origin, direction).radiance));
    sum += radiance * std::abs(cosine) * 2 * pi<double> * 2 / steps;
  }
  return sum;
}

TEMPLATE_TEST_CASE("the power of an area light is what leaves its area on the sides that emit", "[light]", float,
                   double) {
  using T = TestType;
  Philox source(gmis_test::seed(59));
  for (const bool two_sided : {false, true}) {
    const Vec3<double> a = random_in_cube(source), b = a + Vec3<double>(1, 0.2, 0) + random_in_cube(source) * 0.2,
                       c = a + Vec3<double>(0.1, 1, 0.3) + random_in_cube(source) * 0.2;
    const auto triangle = triangle_light<T>(a, b, c, two_sided);
    const double triangle_area = glm::length(glm::cross(b - a, c - a)) / 2;
    const double radius = random_magnitude(source, -1, 1);
    const auto sphere = scene::Light<T>::sphere(Vec3<T>(a), T(radius), false, T(0), Vec3<T>(1, 2, 6), two_sided);
    CAPTURE(two_sided);
    // The midpoints are exact for a radiance that depends on the side alone. Corners, edges and
    // their product are rounded in T; the edges are about as long as the corners are far away, and
    // at an angle of 45° or more.
    const double rounding = 32 * static_cast<double>(std::numeric_limits<T>::epsilon()) + 1e-9;
    CHECK(triangle.power() == Approx(emitted_per_area(triangle) * triangle_area).epsilon(rounding));
    CHECK(sphere.power() == Approx(emitted_per_area(sphere) * 4 * pi<double> * radius * radius).epsilon(rounding));
  }
}

TEST_CASE("a light that emits on both sides is chosen twice as often as one of its size that emits on one", "[light]") {
  SceneBuilder<> builder;
  const auto material = builder.add_material(make_diffuse({.5, .5, .5}));
  Mesh mesh;
  mesh.positions = {{0, 0, 2}, {1, 0, 2}, {0, 1, 2}};
  mesh.triangles = {{0, 1, 2}};
  builder.add_mesh(mesh.shape(), material, AreaEmission{{3, 3, 3}, false});
  builder.add_mesh(mesh.shape(), material, AreaEmission{{3, 3, 3}, true});
  builder.add_sphere({0, 0, 5}, 1, material, AreaEmission{{1, 1, 1}, false});
  builder.add_sphere({4, 0, 5}, 1, material, AreaEmission{{1, 1, 1}, true});
  builder.set_camera(camera_at({0, 0, 0}));
  const auto scene = builder.build();
  REQUIRE(scene.lights().size() == 4);
  const auto chance = [&](std::size_t i) { return scene.selection_probability(scene.lights()[i]); };
  // Chances are multiples of 2^−24 for each column of the table.
  CHECK(chance(1) == Approx(2 * chance(0)).epsilon(1e-5));
  CHECK(chance(3) == Approx(2 * chance(2)).epsilon(1e-5));
  CHECK(chance(2) == Approx(chance(0) * (4 * pi<double>) / (3 * 0.5)).epsilon(1e-5));
}

}  // namespace
