#include <algorithm>
#include <array>
#include <cmath>

#include "gmis/scene.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/technique_estimates.hpp"

// Glass that absorbs, against closed forms and technique against technique: each segment of a path
// counts once, whichever technique makes it. Some 40 comparisons, each at the level of a false
// alarm in 100,000 runs.

namespace {

using gmis::Technique;
using gmis_test::check_closed_form;
using gmis_test::Series;
using gmis_test::TechniqueEstimates;
using Builder = gmis::scene::SceneBuilder<float>;
using Point = glm::dvec3;

constexpr double pi = gmis::pi<double>;
constexpr double albedo = 0.8;

gmis::RenderSettings settings(int max_depth, double light_paths) {
  gmis::RenderSettings result;
  result.max_depth = max_depth;
  result.counts.light_paths = light_paths;
  result.radius = 0.05;
  result.alpha = 1.0;
  result.seed = gmis_test::seed(61);
  return result;
}

gmis::scene::Material<float> diffuse(double reflectance) {
  return gmis::scene::make_diffuse(Point(reflectance));
}

/// A box with its faces outward.
void add_box(Builder& builder, const Point& lower, const Point& upper, std::size_t material) {
  std::vector<Point> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back(
        {(i & 1) != 0 ? upper.x : lower.x, (i & 2) != 0 ? upper.y : lower.y, (i & 4) != 0 ? upper.z : lower.z});
  const std::vector<std::array<int, 3>> faces{{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                              {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  builder.add_mesh({corners, faces}, material);
}

/// A horizontal square around the origin, facing up.
void add_floor(Builder& builder, double half) {
  const std::vector<Point> corners{{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
  const std::vector<std::array<int, 3>> faces{{0, 1, 2}, {0, 2, 3}};
  builder.add_mesh({corners, faces}, builder.add_material(diffuse(albedo)));
}

/// A camera of parallel rays straight down, whose picture is the square of this half side around
/// the origin.
void look_down(Builder& builder, double height, double half, int pixels) {
  auto camera = gmis::scene::look_at({0, 0, height}, {0, 0, 0}, {0, 1, 0}, 40, {pixels, pixels});
  camera.projection = gmis::scene::Projection::orthographic;
  camera.window = {-half, half, -half, half};
  builder.set_camera(camera);
}

/// Two estimates of one number, neither known.
void check_same(const char* what, const Series& a, double factor_a, const Series& b, double factor_b, double power) {
  const double first = a.mean() * factor_a, second = b.mean() * factor_b;
  const double error = std::hypot(a.standard_error() * factor_a, b.standard_error() * factor_b);
  CAPTURE(what, first, second, first / second - 1, error / second);
  CHECK(gmis::student_t_p_value(std::abs(first - second) / error, static_cast<double>(a.count()) - 1) >
        gmis_test::single_level);
  CHECK(error < power * second);
}

/// The mean over the square of this half side, by the midpoint rule.
template <class F>
double mean_over_square(double half, const F& f) {
  constexpr int n = 400;
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) sum += f(half * ((2 * i + 1.0) / n - 1), half * ((2 * j + 1.0) / n - 1));
  return sum / (n * n);
}

/// A diffuse floor in a medium that has no end as far as light goes: its boundary is 60 away, where
/// less than 1e-20 is left.
void add_endless_medium(Builder& builder, double sigma) {
  builder.add_sphere({0, 0, 0}, 60,
                     builder.add_material(with_absorption(gmis::scene::make_dielectric(1.5, 0.5), Point(sigma))));
}

}  // namespace

TEST_CASE("a slab before a uniform light takes exp(-sigma t) of it") {
  // With the index of its surroundings it neither reflects nor bends light: no number is random.
  // Rays that are oblique by 30° have t / cos 30° to go.
  const double thickness = 0.7;
  const Point sigma(0.3, 1.1, 2.7);
  for (const double degrees : {0.0, 30.0, 50.0}) {
    Builder builder;
    add_box(builder, {-2, -2, -thickness}, {2, 2, 0},
            builder.add_material(with_absorption(gmis::scene::make_dielectric(1.0), sigma)));
    builder.add_environment(Point(2));
    const double angle = degrees * pi / 180;
    auto camera = gmis::scene::look_at({3 * std::sin(angle), 0, 3 * std::cos(angle)}, {0, 0, 0}, {0, 1, 0}, 40, {4, 4});
    camera.projection = gmis::scene::Projection::orthographic;
    camera.window = {-0.1, 0.1, -0.1, 0.1};
    builder.set_camera(camera);
    const auto scene = builder.build();
    REQUIRE(scene.has_absorption());
    gmis::Engine<gmis::scene::BvhScene<float>, gmis::CameraSide> engine(scene,
                                                                        gmis_test::ways::Pt::settings(settings(8, 1)));
    gmis::SerialExecutor executor;
    engine.iterate(executor);
    for (const auto& pixel : engine.frame())
      for (int c = 0; c < 3; ++c) {
        CAPTURE(degrees, c);
        // Rays start off surfaces, here by 1e-5.
        CHECK(static_cast<double>(pixel[c]) ==
              Approx(2 * std::exp(-sigma[c] * thickness / std::cos(angle))).epsilon(1e-4));
      }
  }
}

TEST_CASE("a slab of glass between two uniform halves: reflection to and fro within it") {
  // Reflectance R at each face, transmittance τ through the slab: of the light of radiance 1 all
  // around come R + (1 − R)² R τ² / (1 − R² τ²) back and (1 − R)² τ / (1 − R² τ²) through.
  const double sigma = 0.9, thickness = 0.8, index = 1.7;
  Builder builder;
  add_box(builder, {-9, -9, -thickness}, {9, 9, 0},
          builder.add_material(with_absorption(gmis::scene::make_dielectric(index), Point(sigma))));
  builder.add_environment(Point(1));
  look_down(builder, 2, 0.1, 16);
  const auto estimates = gmis_test::estimate<gmis_test::ways::Pt>(builder.build(), settings(40, 1), 200);
  const double r = gmis::square((index - 1) / (index + 1)), t = std::exp(-sigma * thickness);
  const double within = gmis::square(1 - r) / (1 - r * r * t * t);
  check_closed_form("image", estimates.image(), r + within * r * t * t + within * t, 0.005);
}

TEST_CASE("in a medium all around, each technique alone finds the light of a point") {
  const double sigma = 0.6, height = 1.1, light = 0.9;
  Builder builder;
  add_floor(builder, 1.2);
  add_endless_medium(builder, sigma);
  const Point lamp(0.2, 0.1, light);
  builder.add_point_light(lamp, Point(3));
  look_down(builder, height, 1, 16);
  const auto estimates = gmis_test::estimate<gmis_test::ways::Vcm>(builder.build(), settings(2, 2.0), 300);
  const double radiance = albedo / pi * std::exp(-sigma * height) * mean_over_square(1, [&](double x, double y) {
                            const double d = glm::length(lamp - Point(x, y, 0));
                            return 3 * light / (d * d * d) * std::exp(-sigma * d);
                          });
  const double power = 0.004;
  check_closed_form("next event", estimates.alone(Technique::next_event, 2), radiance, power);
  check_closed_form("splat", estimates.alone(Technique::splat, 2), radiance, power);
  // A disk of radius 0.05 under a light 0.9 away: its mean differs by less than r² / h².
  check_closed_form("merge", estimates.alone(Technique::merge, 2), radiance, 0.01, 0.004);
  check_closed_form("together", estimates.together(2), radiance, power, 0.004);
}

TEST_CASE("in a medium all around, connections lose what the other techniques lose") {
  Builder builder;
  add_floor(builder, 1.2);
  add_endless_medium(builder, 0.8);
  const std::vector<Point> ceiling{{-1, -1, 1.3}, {-1, 1, 1.3}, {1, 1, 1.3}, {1, -1, 1.3}};
  const std::vector<std::array<int, 3>> faces{{0, 1, 2}, {0, 2, 3}};
  builder.add_mesh({ceiling, faces}, builder.add_material(diffuse(albedo)));
  builder.add_sphere({1.9, 0, 0.7}, 0.6, builder.add_material(diffuse(0)), gmis::scene::AreaEmission{Point(3), false});
  look_down(builder, 0.7, 1, 16);
  const auto estimates = gmis_test::estimate<gmis_test::ways::Vcm>(builder.build(), settings(3, 2.0), 1500);
  for (const int edges : {2, 3}) {
    const Series& reference = estimates.together(edges);
    CAPTURE(edges);
    const double power = 0.03;
    check_same("emitter hit", estimates.alone(Technique::emitter_hit, edges), 1, reference, 1, power);
    check_same("next event", estimates.alone(Technique::next_event, edges), 1, reference, 1, power);
    check_same("splat", estimates.alone(Technique::splat, edges), 1, reference, 1, power);
    if (edges > 2) check_same("connect", estimates.alone(Technique::connect, edges), 1, reference, 1, power);
  }
}

TEST_CASE("through a rough slab that absorbs, with an object in it, each technique alone finds the same light") {
  const auto scene_with = [](double sigma) {
    Builder builder;
    add_box(builder, {-0.8, -0.8, -0.5}, {0.8, 0.8, 0.6},
            builder.add_material(with_absorption(gmis::scene::make_dielectric(1.3, 0.8), Point(sigma))));
    builder.add_sphere({0.1, 0, -0.1}, 0.35, builder.add_material(diffuse(albedo)));
    builder.add_sphere({0.3, 0.2, 1.9}, 0.8, builder.add_material(diffuse(0)),
                       gmis::scene::AreaEmission{Point(3), false});
    look_down(builder, 0.9, 0.5, 16);
    return builder.build();
  };
  const auto estimates = gmis_test::estimate<gmis_test::ways::Vcm>(scene_with(2), settings(4, 2.0), 2000);
  // Camera, slab, object, slab, light.
  const Series& reference = estimates.together(4);
  const double power = 0.1;
  check_same("emitter hit", estimates.alone(Technique::emitter_hit, 4), 1, reference, 1, power);
  check_same("next event", estimates.alone(Technique::next_event, 4), 1, reference, 1, power);
  check_same("connect", estimates.alone(Technique::connect, 4), 0.5, reference, 1, power);
  check_same("splat", estimates.alone(Technique::splat, 4), 1, reference, 1, power);
  // The way to the object and back is at least 0.35 + 0.35.
  const auto clear = gmis_test::estimate<gmis_test::ways::Vcm>(scene_with(0), settings(4, 2.0), 200);
  CHECK(reference.mean() < std::exp(-2 * 0.7) * clear.together(4).mean());
}
