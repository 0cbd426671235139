#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "gmis/scene.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/technique_estimates.hpp"

// Scenes whose answer is known in closed form (or by an integral of one or two variables), against
// what each technique finds by itself, with the weight 1, and what all find together. Paths are
// told apart by their number of edges. Some 95 comparisons, all of them pass in at least 999 of
// 1000 seeds. Standard errors are 0.05 to 0.2 % but in a few, so that an error of 1 % shows.

namespace {

using gmis::Technique;
using gmis_test::check_closed_form;
using gmis_test::TechniqueEstimates;
using Builder = gmis::scene::SceneBuilder<float>;
using Scene = gmis::scene::BvhScene<float>;
using Point = glm::dvec3;

constexpr double pi = gmis::pi<double>;
constexpr double albedo = 0.8;

gmis::RenderSettings settings(int max_depth, double light_paths, double radius = 0.02) {
  gmis::RenderSettings result;
  result.max_depth = max_depth;
  result.counts.light_paths = light_paths;
  result.radius = radius;
  result.alpha = 1.0;
  result.seed = gmis_test::seed(2);
  return result;
}

TechniqueEstimates estimate(const Scene& scene, const gmis::RenderSettings& render_settings, int iterations) {
  return gmis_test::estimate<gmis_test::ways::Vcm>(scene, render_settings, iterations);
}

/// Corners in order, seen from the side that the normal points to counter-clockwise.
void add_polygon(Builder& builder, const std::vector<Point>& corners, std::size_t material,
                 const std::optional<gmis::scene::AreaEmission>& emission = {}) {
  std::vector<std::array<int, 3>> triangles;
  for (int i = 2; i < static_cast<int>(corners.size()); ++i) triangles.push_back({0, i - 1, i});
  builder.add_mesh({corners, triangles}, material, emission);
}

/// A horizontal square, facing up or down.
std::vector<Point> level_square(double half, double z, bool faces_up, double x = 0.0, double y = 0.0) {
  std::vector<Point> corners{
      {x - half, y - half, z}, {x + half, y - half, z}, {x + half, y + half, z}, {x - half, y + half, z}};
  if (!faces_up) std::reverse(corners.begin(), corners.end());
  return corners;
}

/// At (x, y, height), looking straight down: the picture is exactly the square of this half side
/// around (x, y) on the floor, and its mean is the mean of the floor's radiance.
void look_down(Builder& builder, double height, double half_side, double x = 0.0, double y = 0.0) {
  builder.set_camera(
      gmis::scene::look_at({x, y, height}, {x, y, 0}, {0, 1, 0}, 360.0 / pi * std::atan(half_side / height), {16, 16}));
}

/// The mean of a function over the square of this half side, by Gauss's rule of 5 points on 20 × 20
/// cells.
double mean_over_square(double half, const std::function<double(double, double)>& f) {
  constexpr std::array<double, 5> node{-0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683,
                                       0.906179845938664};
  constexpr std::array<double, 5> weight{0.236926885056189, 0.478628670499366, 0.568888888888889, 0.478628670499366,
                                         0.236926885056189};
  constexpr int cells = 20;
  double sum = 0.0;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j)
      for (std::size_t a = 0; a < 5; ++a)
        for (std::size_t b = 0; b < 5; ++b)
          sum += weight[a] * weight[b] *
                 f(half * ((2 * i + 1 + node[a]) / cells - 1.0), half * ((2 * j + 1 + node[b]) / cells - 1.0));
  return sum / (4.0 * cells * cells);
}

/// The irradiance at `at` with the normal +z from a polygon of radiance 1 above the horizon, as the
/// edges see it [Lambert 1760].
double polygon_irradiance(const std::vector<Point>& corners, const Point& at) {
  double sum = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point a = glm::normalize(corners[i] - at), b = glm::normalize(corners[(i + 1) % corners.size()] - at);
    const Point normal = glm::cross(a, b);
    sum += std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0)) * normal.z / glm::length(normal);
  }
  return std::abs(sum) / 2.0;
}

/// Floor of half side 1.2 (the picture shows 1) at z = 0.
void add_floor(Builder& builder, double reflectance = albedo, double half = 1.2) {
  add_polygon(builder, level_square(half, 0.0, true),
              builder.add_material(gmis::scene::make_diffuse(Point(reflectance))));
}

constexpr double merge_radius = 0.1;

/// The mean over the picture of an irradiance, as it is and as merging sees it, by its mean over
/// disks: that of a disk of radius r is, but for r⁴, that of four points at r / √2.
struct Irradiance {
  double mean, merged;

  explicit Irradiance(const std::function<double(double, double)>& at)
      : mean(mean_over_square(1.0, at)), merged(mean_over_square(1.0, [&](double x, double y) {
          const double d = merge_radius / 2.0;
          return (at(x + d, y + d) + at(x - d, y + d) + at(x + d, y - d) + at(x - d, y - d)) / 4.0;
        })) {}
};

/// All that can make light which comes to the floor directly, against the floor's irradiance.
void check_direct(const Builder& builder, const std::function<double(double, double)>& irradiance, bool can_be_hit,
                  int iterations) {
  const auto estimates = estimate(builder.build(), settings(2, 2.0, merge_radius), iterations);
  const Irradiance all(irradiance);
  const double radiance = albedo / pi * all.mean;
  const double bias = std::abs(all.merged / all.mean - 1.0);
  const double power = 0.003;
  if (can_be_hit) check_closed_form("emitter hit", estimates.alone(Technique::emitter_hit, 2), radiance, power);
  check_closed_form("next event", estimates.alone(Technique::next_event, 2), radiance, power);
  check_closed_form("splat", estimates.alone(Technique::splat, 2), radiance, power);
  check_closed_form("merge", estimates.alone(Technique::merge, 2), albedo / pi * all.merged, power);
  check_closed_form("together", estimates.together(2), radiance, power, bias);
  check_closed_form("image", estimates.image(), radiance, power, bias);
}

double fresnel(double cos_incident, double index) {
  const double sin_incident = std::sqrt(std::max(0.0, 1.0 - cos_incident * cos_incident));
  if (sin_incident >= index) return 1.0;
  if (sin_incident < 1e-6) return gmis::square((index - 1.0) / (index + 1.0));
  const double i = std::asin(sin_incident), t = std::asin(sin_incident / index);
  return (gmis::square(std::sin(i - t) / std::sin(i + t)) + gmis::square(std::tan(i - t) / std::tan(i + t))) / 2.0;
}

}  // namespace

TEST_CASE("Lambert's formula for polygons gives the form factors of the books") {
  const auto parallel = level_square(0.5, 1.0, false);
  CHECK(mean_over_square(0.5,
                         [&](double x, double y) {
                           return polygon_irradiance(parallel, {x, y, 0}) / pi;
                         }) ==
        Approx(2 / pi * (std::log(std::sqrt(4.0 / 3.0)) + 2 * std::sqrt(2.0) * std::atan(1 / std::sqrt(2.0)) - pi / 2))
            .epsilon(1e-9));
  const std::vector<Point> wall{{-0.5, -0.5, 0}, {-0.5, 0.5, 0}, {-0.5, 0.5, 1}, {-0.5, -0.5, 1}};
  CHECK(
      mean_over_square(0.5, [&](double x, double y) {
        return polygon_irradiance(wall, {x, y, 0}) / pi;
      }) == Approx((pi / 2 - std::sqrt(2.0) * std::atan(1 / std::sqrt(2.0)) + std::log(0.75) / 4) / pi).epsilon(1e-5));
}

TEST_CASE("a diffuse floor under an area light") {
  const gmis::scene::AreaEmission emission{Point(3.0), false};
  Builder builder;
  add_floor(builder);
  look_down(builder, 0.3, 1.0);
  const auto black = builder.add_material(gmis::scene::make_diffuse(Point(0.0)));
  const auto check_light = [&](const std::vector<Point>& light, int iterations) {
    add_polygon(builder, light, black, emission);
    check_direct(
        builder,
        [&](double x, double y) {
          return 3.0 * polygon_irradiance(light, {x, y, 0});
        },
        true, iterations);
  };
  SECTION("a square opposite to it") {
    check_light(level_square(1.0, 0.8, false, 0.2, 0.1), 1000);
  }
  SECTION("a disk of 24 sides, oblique") {
    const Point center(0.5, -0.3, 1.2), x = glm::normalize(Point(0.8, 0, 0.4)), y(0, 1, 0);
    std::vector<Point> light;
    for (int i = 0; i < 24; ++i)
      light.push_back(center + 0.9 * (x * std::cos(2 * pi * i / 24) - y * std::sin(2 * pi * i / 24)));
    check_light(light, 2500);
  }
  SECTION("a wall at right angles") {
    check_light({{-1.4, -1, 0.2}, {-1.4, 1, 0.2}, {-1.4, 1, 2}, {-1.4, -1, 2}}, 3500);
  }
}

TEST_CASE("a diffuse floor under a sphere") {
  Builder builder;
  add_floor(builder);
  look_down(builder, 0.3, 1.0);
  const Point center(0.3, -0.2, 1.3);
  const double radius = 0.8;
  builder.add_sphere(center, radius, builder.add_material(gmis::scene::make_diffuse(Point(0.0))),
                     gmis::scene::AreaEmission{Point(3.0), false});
  const auto irradiance = [&](double x, double y) {
    const double d2 = glm::dot(center - Point(x, y, 0), center - Point(x, y, 0));
    return 3.0 * pi * radius * radius / d2 * center.z / std::sqrt(d2);
  };
  check_direct(builder, irradiance, true, 2200);
}

TEST_CASE("a diffuse floor under lights that cannot be hit, and under the sky") {
  Builder builder;
  add_floor(builder);
  look_down(builder, 0.7, 1.0);
  SECTION("a point light") {
    const Point position(0.4, 0.3, 0.9);
    builder.add_point_light(position, Point(2.0));
    const auto irradiance = [&](double x, double y) {
      const double d2 = glm::dot(position - Point(x, y, 0), position - Point(x, y, 0));
      return 2.0 / d2 * position.z / std::sqrt(d2);
    };
    check_direct(builder, irradiance, false, 1200);
  }
  SECTION("a sun") {
    builder.add_directional_light({1, 2, 2}, Point(1.5));
    check_direct(
        builder, [](double, double) { return 1.5 * 2.0 / 3.0; }, false, 1200);
  }
  SECTION("a uniform sky") {
    builder.add_environment(Point(1.5));
    check_direct(
        builder, [](double, double) { return 1.5 * pi; }, true, 1500);
  }
}

TEST_CASE("mirrors that face each other") {
  const double reflectance = 0.9;
  Builder builder;
  const auto mirror = builder.add_material(gmis::scene::make_mirror(Point(reflectance)));
  const auto add_mirrors = [&](double half_width, double top) {
    for (const double x : {0.0, 1.0})
      add_polygon(builder, {{x, -half_width, 0}, {x, half_width, 0}, {x, half_width, top}, {x, -half_width, top}},
                  mirror);
  };
  SECTION("a sky seen at the end of the corridor: one image for each reflection") {
    add_mirrors(3.0, 4.0);
    builder.add_environment(Point(2.0));
    for (const double slope : {0.0, 0.1, 0.3, 0.625, 0.9, 1.4}) {
      // The way leads up by 3.9 and sideways from 0.2, through the images of the mirrors at 1, 2,
      // ….
      const int reflections = static_cast<int>(std::floor(0.2 + slope * 3.9));
      builder.set_camera(gmis::scene::look_at({0.2, 0, 0.1}, {0.2 + slope, 0, 1.1}, {0, 1, 0}, 0.1, {16, 16}));
      const auto estimates = estimate(builder.build(), settings(12, 0.1), 500);
      CAPTURE(slope, reflections);
      check_closed_form("emitter hit", estimates.alone(Technique::emitter_hit, reflections + 1),
                        2.0 * std::pow(reflectance, reflections), 0.003);
      check_closed_form("image", estimates.image(), 2.0 * std::pow(reflectance, reflections), 0.003);
    }
  }
  SECTION("a sun that reaches the floor by two or by three reflections") {
    add_mirrors(0.45, 1.0);
    add_polygon(builder, {{0, -0.45, 0}, {1, -0.45, 0}, {1, 0.45, 0}, {0, 0.45, 0}},
                builder.add_material(gmis::scene::make_diffuse(Point(albedo))));
    builder.add_directional_light({-2.5, 0, 1}, Point(2.0));
    look_down(builder, 0.4, 0.4, 0.5);
    // From x on the floor the way up goes 2.5 sideways. Leftwards through 3 mirrors where x < 1/2,
    // else 2; rightwards 2, else
    // 3. It ends in the sun where leftwards has been even or rightwards odd: both where x > 1/2,
    //    neither elsewhere.
    const double radiance = albedo / pi * 2.0 / std::hypot(2.5, 1.0) / 2.0;
    const auto estimates = estimate(builder.build(), settings(5, 8.0, 0.04), 1300);
    for (const int reflections : {2, 3}) {
      CAPTURE(reflections);
      const double truth = radiance * std::pow(reflectance, reflections);
      check_closed_form("splat", estimates.alone(Technique::splat, reflections + 2), truth, 0.0025);
      check_closed_form("merge", estimates.alone(Technique::merge, reflections + 2), truth, 0.003);
      check_closed_form("together", estimates.together(reflections + 2), truth, 0.0025);
    }
  }
}

TEST_CASE("a slab of glass lets through what the interfaces say, in both directions") {
  const double index = 2.5;
  Builder builder;
  const auto glass = builder.add_material(gmis::scene::make_dielectric(index));
  const auto add_slab = [&](double bottom, double top, double half) {
    add_polygon(builder, level_square(half, top, true), glass);
    add_polygon(builder, level_square(half, bottom, false), glass);
  };
  SECTION("radiance of an emitter behind it: (1 − R)² R^2m, in all (1 − R)/(1 + R)") {
    add_slab(1.0, 1.2, 3.0);
    add_polygon(builder, level_square(3.0, 0.0, true), builder.add_material(gmis::scene::make_diffuse(Point(0.0))),
                gmis::scene::AreaEmission{Point(2.0), false});
    builder.set_camera(gmis::scene::look_at({0, 0, 2.2}, {0.6, 0, 1.2}, {0, 1, 0}, 0.05, {8, 8}));
    const double reflected = fresnel(1.0 / std::hypot(0.6, 1.0), index);
    const auto estimates = estimate(builder.build(), settings(12, 0.1), 8000);
    for (const int m : {0, 1})
      check_closed_form("emitter hit", estimates.alone(Technique::emitter_hit, 3 + 2 * m),
                        2.0 * gmis::square(1.0 - reflected) * std::pow(reflected, 2 * m), m == 0 ? 0.002 : 0.01);
    check_closed_form("image", estimates.image(), 2.0 * (1.0 - reflected) / (1.0 + reflected), 0.002);
  }
  SECTION("a sun through it on a floor") {
    add_floor(builder);
    add_slab(1.0, 1.2, 2.0);
    builder.add_directional_light({0.5, 0, 1}, Point(2.0));
    look_down(builder, 0.7, 1.0);
    const double cosine = 1.0 / std::hypot(0.5, 1.0), reflected = fresnel(cosine, index);
    const double radiance = albedo / pi * 2.0 * cosine * gmis::square(1.0 - reflected);
    const auto estimates = estimate(builder.build(), settings(4, 6.0, 0.1), 700);
    check_closed_form("splat", estimates.alone(Technique::splat, 4), radiance, 0.0025);
    check_closed_form("merge", estimates.alone(Technique::merge, 4), radiance, 0.0025);
    check_closed_form("together", estimates.together(4), radiance, 0.0025);
  }
  SECTION("a lit floor seen through it: what enters the glass is undone where it leaves") {
    add_floor(builder, albedo, 1.0);
    add_slab(0.5, 0.7, 2.0);
    const double height = 0.2, disk = 0.06;
    builder.add_point_light({0.0, 0.0, height}, Point(2.0));
    // The picture is half a centimetre wide: all is as it is under the light; merging sees the mean
    // over its disk there.
    builder.set_camera(gmis::scene::look_at({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 0.1, {8, 8}));
    const double seen = albedo / pi * gmis::square(1.0 - fresnel(1.0, index)) * 2.0;
    const double direct = seen / gmis::square(height);
    const double merged = seen * 2.0 / gmis::square(disk) * (1.0 - height / std::hypot(height, disk));
    const auto estimates = estimate(builder.build(), settings(4, 16.0, disk), 2500);
    check_closed_form("next event", estimates.alone(Technique::next_event, 4), direct, 0.003);
    check_closed_form("merge", estimates.alone(Technique::merge, 4), merged, 0.002);
    check_closed_form("together", estimates.together(4), direct, 0.002, 1.0 - merged / direct);
  }
}

TEST_CASE("inside glass radiance is n² times what it is outside, found from the camera and from the light") {
  const double index = 1.5;
  Builder builder;
  builder.add_sphere({0, 0, 0}, 1.0, builder.add_material(gmis::scene::make_dielectric(index)));
  builder.add_environment(Point(1.0));
  SECTION("seen directly from the middle, where all rays leave at right angles") {
    builder.set_camera(gmis::scene::look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 60, {8, 8}));
    const double reflected = fresnel(1.0, index);
    const auto estimates = estimate(builder.build(), settings(8, 1.0), 400);
    check_closed_form("emitter hit", estimates.alone(Technique::emitter_hit, 2), index * index * (1.0 - reflected),
                      0.002);
    check_closed_form("image", estimates.image(), index * index, 0.002);
  }
  SECTION("seen on a diffuse square in the glass") {
    const double half = 0.3;
    add_polygon(builder, level_square(half + 0.05, 0.0, true),
                builder.add_material(gmis::scene::make_diffuse(Point(albedo))));
    look_down(builder, 0.5, half);
    // ∫ n² (1 − R) cos dω over the hemisphere; a ray that passes the centre at the distance b
    // leaves the ball under sin = b.
    const double irradiance = mean_over_square(half, [&](double x, double y) {
      const int rings = 24, steps = 48;
      double sum = 0.0;
      for (int i = 0; i < rings; ++i)
        for (int j = 0; j < steps; ++j) {
          const double sin2 = (i + 0.5) / rings, angle = 2 * pi * (j + 0.5) / steps;
          const Point w(std::sqrt(sin2) * std::cos(angle), std::sqrt(sin2) * std::sin(angle), std::sqrt(1 - sin2));
          const double sine = glm::length(glm::cross(Point(x, y, 0), w));
          sum += 1.0 - fresnel(std::sqrt(1.0 - sine * sine), 1.0 / index);
        }
      return index * index * pi * sum / (rings * steps);
    });
    const double radiance = albedo / pi * irradiance;
    const auto estimates = estimate(builder.build(), settings(3, 10.0, 0.04), 600);
    check_closed_form("emitter hit", estimates.alone(Technique::emitter_hit, 3), radiance, 0.002);
    check_closed_form("splat", estimates.alone(Technique::splat, 3), radiance, 0.0025);
    check_closed_form("merge", estimates.alone(Technique::merge, 3), radiance, 0.0025);
    check_closed_form("together", estimates.together(3), radiance, 0.0025);
  }
}

TEST_CASE("a ball of glass in the sun throws on the floor what it lets through") {
  const double index = 1.5, height = 2.2, half = 2.0, small_albedo = 0.01;
  Builder builder;
  add_floor(builder, small_albedo, 2.2);
  builder.add_sphere({0, 0, height}, 1.0, builder.add_material(gmis::scene::make_dielectric(index)));
  builder.add_directional_light({0, 0, 1}, Point(2.0));
  look_down(builder, 0.8, half);
  // A ray at the distance b from the axis enters under sin i = b, leaves turned by 2 (i − t), from
  // the point of the ball that is π − 2 t + i away from the top, and meets the floor at the
  // distance s from the axis.
  double power = 0.0;
  const int steps = 20000;
  for (int n = 0; n < steps; ++n) {
    const double b = std::sqrt((n + 0.5) / steps), i = std::asin(b), t = std::asin(b / index);
    const double turn = 2 * (i - t);
    if (turn >= pi / 2) continue;
    const double place = i + pi - 2 * t;
    const double s = std::abs(std::sin(place) - std::tan(turn) * (height + std::cos(place)));
    // The share of that circle within the square.
    double inside = 1.0;
    if (s > half) inside = s < half * std::sqrt(2.0) ? 1.0 - 4.0 / pi * std::acos(half / s) : 0.0;
    power += 2.0 * pi / steps * gmis::square(1.0 - fresnel(std::cos(i), index)) * inside;
  }
  const double radiance = small_albedo / pi * power / gmis::square(2 * half);
  const auto estimates = estimate(builder.build(), settings(4, 8.0, 0.1), 800);
  // By way of the floor and the ball again come some 2e-4 more.
  check_closed_form("splat", estimates.alone(Technique::splat, 4), radiance, 0.002, 4e-4);
  check_closed_form("merge", estimates.alone(Technique::merge, 4), radiance, 0.005, 6e-4);
  check_closed_form("together", estimates.together(4), radiance, 0.0025, 6e-4);
}

TEST_CASE("a coarse ball with a smooth look is the same seen from the camera and from the light") {
  Builder builder;
  const std::vector<Point> corners{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  const std::vector<std::array<int, 3>> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                  {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  builder.add_mesh({corners, triangles, corners}, builder.add_material(gmis::scene::make_diffuse(Point(albedo))));
  builder.set_camera(gmis::scene::look_at({0.5, 0.4, 4}, {0, 0, 0}, {0, 1, 0}, 32, {16, 16}));
  bool can_be_hit = false;
  SECTION("in the sun") {
    builder.add_directional_light({3, 1, 1}, Point(2.0));
  }
  SECTION("under a sky") {
    builder.add_environment(Point(1.0));
    can_be_hit = true;
  }
  const auto estimates = estimate(builder.build(), settings(2, 2.0), 3200);
  const auto& reference = estimates.alone(Technique::next_event, 2);
  CHECK(reference.standard_error() < 0.004 * reference.mean());
  const auto agree = [&](const char* what, const gmis_test::Series& series, double bias) {
    const double error = std::hypot(series.standard_error(), reference.standard_error());
    const double off = std::max(0.0, std::abs(series.mean() - reference.mean()) - bias * reference.mean());
    CAPTURE(what, series.mean(), reference.mean(), series.mean() / reference.mean() - 1.0, error / reference.mean());
    CHECK(gmis::z_test(off, error, 0.0).passes(gmis_test::single_level));
    CHECK(error < 0.005 * reference.mean());
  };
  if (can_be_hit) agree("emitter hit", estimates.alone(Technique::emitter_hit, 2), 0.0);
  agree("splat", estimates.alone(Technique::splat, 2), 0.0);
  // Without merging: where the light comes from below the true surface, but not below the one that
  // is seen, a merge's factor has no finite variance.
  const auto without_merging = gmis_test::estimate<gmis_test::ways::Bpt>(builder.build(), settings(2, 2.0), 3200);
  CHECK(without_merging.alone(Technique::merge, 2).mean() == 0.0);
  agree("together", without_merging.together(2), 0.0);
}
