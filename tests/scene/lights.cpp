#include "gmis/core/check.hpp"
#include "scene/shapes.hpp"
#include "support/catch.hpp"

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
const double level = sidak_level(1e-3, 60);

template <std::floating_point T>
scene::Light<T> triangle_light(const Vec3<double>& a, const Vec3<double>& b, const Vec3<double>& c,
                               bool two_sided = false) {
  const auto normal = glm::normalize(glm::cross(b - a, c - a));
  return scene::Light<T>::triangle(Vec3<T>(a), Vec3<T>(b), Vec3<T>(c), Vec3<T>(normal), T(0), Vec3<T>(2), two_sided);
}

/// Irradiance of a polygon that the horizon does not cut: L/2 Σ angle · (edge normal · n) [Lambert 1760].
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
  Philox source(51);
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
  Philox source(52);
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
  Philox source(53);
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

/// What a light emits through a plane far below must be the irradiance that next event gives there: flux through a window
/// by emission, and by integrating next event over the window.
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
  Philox source(54);
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

/// The densities that samples carry are those that `emitted` and `next_event_density` give, and weights are what the
/// interface says they are.
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
  Philox source(55);
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
}

TEST_CASE("directions of emission are distributed as stated", "[light]") {
  using T = double;
  Philox source(56);
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

TEST_CASE("the alias table gives each index its share, exactly", "[alias]") {
  Philox source(57);
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

TEST_CASE("lights are chosen by power, and the chances add up to one", "[light]") {
  SceneBuilder<> builder;
  const auto material = builder.add_material(make_diffuse({.5, .5, .5}));
  builder.add_mesh(box({-1, -1, -1}, {1, 1, 1}).shape(), material);
  builder.add_sphere({0, 0, 0}, 0.1, material, AreaEmission{{10, 10, 10}, false});
  builder.add_point_light({0.5, 0, 0}, {1, 1, 1});
  builder.add_directional_light({0, 1, 0}, {2, 2, 2});
  builder.add_environment({0.1, 0.1, 0.1});
  builder.add_point_light({0.5, 0, 0}, {0, 0, 0});
  builder.set_camera(camera_at({0, 0, -0.5}));
  const auto scene = builder.build();
  REQUIRE(scene.lights().size() == 5);
  CHECK(scene.infinite_lights().size() == 2);
  double sum = 0;
  for (const auto& light : scene.lights()) sum += static_cast<double>(scene.selection_probability(light));
  CHECK(sum == Approx(1).epsilon(1e-6));
  const double disk = pi<double> * 3;  // the ball around the box has r² = 3
  const double area = 4 * pi<double> * 0.01 * pi<double> * 10, point = 4 * pi<double>, sun = 2 * disk,
               sky = 0.1 * 4 * pi<double> * disk;
  CHECK(scene.selection_probability(scene.lights()[0]) == Approx(area / (area + point + sun + sky)).epsilon(1e-4));
  CHECK(scene.selection_probability(scene.lights()[3]) == Approx(sun / (area + point + sun + sky)).epsilon(1e-4));
  Philox source(58);
  for (int i = 0; i < 2000; ++i) {
    const auto choice = scene.sample_light(uniform<float>(source));
    REQUIRE(choice.light != nullptr);
    if (!(choice.selection_probability > 0.0F)) FAIL("a light that emits nothing was chosen");
  }
}

}  // namespace
