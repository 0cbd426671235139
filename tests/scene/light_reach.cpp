#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/scene/light.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "scene/shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/mean_of_iterations.hpp"

// The share of a light's flux that meets a ball: the bounds against emission that is sampled and
// counted, against closed forms, in the probabilities of a whole scene, and in pictures of known
// energy.

using namespace gmis::scene;
using namespace scene_test;
using gmis::pi;

namespace {

using D = glm::dvec3;
using L = Light<double>;

L triangle_at(const D& middle, double size, const D& normal, bool is_two_sided) {
  const auto frame = gmis::Frame<double>::around(normal);
  const auto corner = [&](double turns) {
    const double angle = 2 * pi<double> * turns;
    return middle + (frame.tangent * std::cos(angle) + frame.bitangent * std::sin(angle)) * size;
  };
  return L::triangle(corner(0), corner(1.0 / 3), corner(2.0 / 3), normal, 0, D(2), is_two_sided);
}
L sphere_at(const D& center, double radius, bool inward = false, bool is_two_sided = false) {
  return L::sphere(center, radius, inward, 0, D(2), is_two_sided);
}
L spot_along(const D& axis, double inner, double outer) {
  return L::spot(D(0), SpotCone<double>(glm::normalize(axis), inner, outer), D(3));
}

/// A light and a ball; the bound is at most `slack` times the share.
struct Case {
  std::string name;
  L light;
  ReceiverBall ball;
  double slack;
};

std::vector<Case> cases() {
  const double loose = 1e9;  // the share is small or 0, and the bound need not be
  const D up(0, 0, 1);
  return {
      {"point, near", L::point(D(0), D(1)), {{0, 0, 3}, 2.9}, 1},
      {"point, far", L::point(D(0), D(1)), {{0, 9, 3}, 1.5}, 1},
      {"point, inside", L::point(D(0), D(1)), {{0, 0.5, 0}, 2}, 1},
      {"sphere, near", sphere_at(D(0), 1), {{3, 0, 0}, 1.5}, 2},
      {"sphere, far and large", sphere_at(D(0), 4), {{0, 30, 0}, 1}, 1.05},
      {"sphere, far and small", sphere_at(D(0), 0.1), {{0, 20, 0}, 3}, 1.05},
      {"sphere, inside the ball", sphere_at(D(0), 1), {{1, 0, 0}, 4}, 1},
      {"sphere that shines inward, around the ball", sphere_at(D(0), 5, true), {{2, 0, 0}, 2}, 1},
      {"sphere that shines both ways, around the ball", sphere_at(D(0), 5, false, true), {{2, 0, 0}, 2}, 2},
      {"sphere that shines both ways, far", sphere_at(D(0), 2, false, true), {{12, 0, 0}, 2}, 2.2},
      {"sphere that the ball cuts", sphere_at(D(0), 2), {{2.5, 0, 0}, 1}, 6},
      {"triangle, near", triangle_at(D(0), 1, up, false), {{0, 0, 4}, 2.5}, 2.5},
      {"triangle, far", triangle_at(D(0), 1, up, false), {{2, 0, 15}, 1}, 1.2},
      {"triangle, far and tilted", triangle_at(D(0), 0.3, up, false), {{8, 3, 7}, 2}, 1.2},
      {"triangle, at its horizon", triangle_at(D(0), 0.3, up, false), {{9, 0, 0.3}, 2}, 4},
      {"triangle, below its horizon in part", triangle_at(D(0), 0.3, up, false), {{9, 0, -1.5}, 2}, loose},
      {"triangle, behind", triangle_at(D(0), 0.3, up, false), {{0, 0, -9}, 2}, loose},
      {"triangle, inside the ball", triangle_at(D(0), 1, up, false), {{0, 0, 0.5}, 3}, 1},
      {"wide triangle, the ball before it", triangle_at(D(0), 20, up, false), {{0, 0, 2}, 1}, 2.2},
      {"triangle that shines both ways, far", triangle_at(D(0), 0.5, up, true), {{2, 0, -15}, 1.5}, 1.2},
      {"triangle that shines both ways, at its horizon", triangle_at(D(0), 0.5, up, true), {{12, 0, 0.5}, 2}, 4},
      {"spot, the ball in its cone", spot_along(up, 0.5, 0.6), {{0.3, 0, 9}, 2}, 1.2},
      {"spot, the cone in the ball", spot_along(up, 0.1, 0.2), {{0.3, 0, 9}, 5}, 1},
      {"spot, the ball at its edge", spot_along(up, 0.4, 0.6), {{6, 0, 8}, 2}, loose},
      {"spot, behind", spot_along(up, 0.4, 0.6), {{0, 0, -9}, 2}, loose},
      {"spot, inside the ball", spot_along(up, 0.4, 0.6), {{0, 1, 0}, 2}, 1},
  };
}

bool meets(const gmis::EmissionSample<D>& start, const ReceiverBall& ball) {
  const D offset = ball.center - start.origin.position;
  if (glm::length(offset) <= ball.radius) return true;
  const double along = glm::dot(offset, start.direction);
  return along > 0 && glm::length(offset - start.direction * along) <= ball.radius;
}

}  // namespace

TEST_CASE("The share towards a ball bounds the share of sampled emission from above, and not loosely") {
  // Two checks in each case, for one false alarm in a thousand seeds.
  const auto all = cases();
  const double quantile = gmis::normal_quantile(1 - gmis::sidak_level(1e-3, 2 * all.size()));
  gmis::Philox source(gmis_test::seed(61));
  for (const Case& c : all) {
    constexpr int count = 100'000;
    double met = 0, flux = 0;
    for (int i = 0; i < count; ++i) {
      const Vec2<double> u(uniform<double>(source), uniform<double>(source));
      const auto start = c.light.sample_emission(u, {uniform<double>(source), uniform<double>(source)});
      if (!start) continue;
      flux += start->weight.x;
      if (meets(*start, c.ball)) met += start->weight.x;
    }
    // Weights of one light are alike.
    const double share = met / flux, error = std::sqrt(std::max(share * (1 - share), 1.0 / count) / count);
    const double bound = c.light.share_towards(c.ball);
    CAPTURE(c.name, share, error, bound);
    CHECK(bound >= share - quantile * error);
    CHECK(bound <= c.slack * (share + quantile * error));
    CHECK(bound <= 1);
    CHECK(bound >= 0);
    CHECK(flux / count == Approx(c.light.power()).epsilon(0.01));
  }
}

TEST_CASE("From far away the shares are those of the closed forms, to single units of the last digits") {
  // The ball covers R²/(4 d²) of all directions, and a small flat light sends cos θ R²/d² to it.
  for (const double distance : {1e3, 1e6, 1e9}) {
    CAPTURE(distance);
    const D to_ball = glm::normalize(D(0.3, -0.2, 0.8));
    const ReceiverBall ball{to_ball * distance, 2};
    const double covered = 1 / (distance * distance);
    CHECK(L::point(D(0), D(1)).share_towards(ball) == Approx(covered).epsilon(1e-5));
    CHECK(sphere_at(D(0), 0.1 * distance).share_towards(ball) == Approx(covered).epsilon(0.03));
    CHECK(triangle_at(D(0), 1e-3, {0, 0, 1}, false).share_towards(ball) ==
          Approx(4 * covered * to_ball.z).epsilon(1e-4));
    CHECK(triangle_at(D(0), 1e-3, {0, 0, -1}, true).share_towards(ball) ==
          Approx(2 * covered * to_ball.z).epsilon(1e-4));
    // A cone of 0.2 has 2π(1 − cos 0.2) steradians; the ball covers π R²/d² of them.
    CHECK(spot_along(to_ball, 0.2, 0.2).share_towards(ball) ==
          Approx(4 * covered / (2 * (1 - std::cos(0.2)))).epsilon(1e-4));
    CHECK(spot_along(-to_ball, 0.2, 0.2).share_towards(ball) == 0);
  }
}

namespace {

/// A square of side 2 in the plane y = 0; the ball around it has the radius √2.
SceneBuilder<double> square_builder(std::size_t& black) {
  SceneBuilder<double> builder;
  const auto grey = builder.add_material(make_diffuse<double>({0.5, 0.5, 0.5}));
  black = builder.add_material(make_diffuse<double>({0, 0, 0}));
  const std::vector<D> corners{{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
  const std::vector<std::array<int, 3>> halves{{0, 1, 2}, {0, 2, 3}};
  builder.add_mesh({corners, halves}, grey);
  builder.set_camera(look_at({0, 1, -3}, {0, 0, 0}, {0, 1, 0}, 50, {8, 8}));
  return builder;
}

}  // namespace

TEST_CASE("A scene chooses a far sun and a lamp by the light that they send to what does not shine") {
  std::size_t black = 0;
  auto builder = square_builder(black);
  constexpr double distance = 1e4, radius = 1e3;
  builder.add_sphere({0, distance, 0}, radius, black, AreaEmission{D(50)});
  builder.add_point_light({0, 3, 0}, D(2));
  const auto scene = builder.build();
  const double of_sun = 50 * pi<double> * 4 * pi<double> * radius * radius * 2 / (4 * distance * distance);
  const double of_lamp = 2 * 4 * pi<double> * (1 - std::sqrt(1 - 2.0 / 9)) / 2;
  CHECK(scene.lights()[0].selection_probability() == Approx(of_sun / (of_sun + of_lamp)).epsilon(0.02));
  CHECK(scene.lights()[1].selection_probability() == Approx(of_lamp / (of_sun + of_lamp)).epsilon(0.02));
  // The sun is not among the surfaces to reach, and power is still the whole flux.
  CHECK(scene.lights()[0].power() == Approx(50 * 4 * gmis::square(pi<double> * radius)));
}

TEST_CASE("Lights within the ball are chosen by power, and no light is left without a chance") {
  std::size_t black = 0;
  auto inside = square_builder(black);
  inside.add_point_light({0, 0.5, 0}, D(1));
  inside.add_spot_light({0.2, 0.4, 0}, {0, -1, 0}, D(1), 0.3, 0.5);
  inside.add_sphere({0.5, 0.5, 0.5}, 0.1, black, AreaEmission{D(4)});
  const auto near = inside.build();
  double power = 0;
  for (const auto& light : near.lights()) power += light.power();
  for (const auto& light : near.lights()) CHECK(light.selection_probability() == Approx(light.power() / power));

  // A spot light that turns away from everything keeps a hundredth of the mean.
  auto behind = square_builder(black);
  behind.add_point_light({0, 0.5, 0}, D(1));
  behind.add_spot_light({0, 5, 0}, {0, 1, 0}, D(1e6), 0.1, 0.2);
  const auto turned = behind.build();
  CHECK(turned.lights()[1].selection_probability() == Approx(0.005 / 1.005));

  // Nothing is lit, or nothing but lights is there: power.
  auto alone = square_builder(black);
  alone.add_spot_light({0, 5, 0}, {0, 1, 0}, D(1), 0.1, 0.2);
  alone.add_spot_light({0, 6, 0}, {0, 1, 0}, D(3), 0.1, 0.2);
  CHECK(alone.build().lights()[1].selection_probability() == Approx(0.75));
  SceneBuilder<double> bare;
  const auto dark = bare.add_material(make_diffuse<double>({0, 0, 0}));
  bare.add_sphere({0, 0, 0}, 1, dark, AreaEmission{D(1)});
  bare.add_point_light({0, 5000, 0}, D(1));
  bare.set_camera(look_at({0, 0, -3}, {0, 0, 0}, {0, 1, 0}, 50, {8, 8}));
  CHECK(bare.build().lights()[1].selection_probability() == Approx(4 / (4 + 4 * pi<double>)));
}

namespace {

using Irradiance = std::function<double(const D& at)>;  // on a floor, whose normal is +y

Irradiance of_point(const D& from, double intensity) {
  return [=](const D& at) {
    const D offset = from - at;
    return intensity * offset.y / std::pow(glm::dot(offset, offset), 1.5);
  };
}
Irradiance of_sphere(const D& center, double radius, double radiance) {
  return of_point(center, radiance * pi<double> * radius * radius);
}
/// Irradiance below a square that faces down: a sum over its cells.
Irradiance of_square(const D& middle, double half, double radiance) {
  return [=](const D& at) {
    constexpr int cells = 60;
    double sum = 0;
    for (int i = 0; i < cells; ++i)
      for (int k = 0; k < cells; ++k) {
        const D from = middle + half * D((2 * i + 1.0) / cells - 1, 0, (2 * k + 1.0) / cells - 1);
        const D offset = from - at;
        sum += offset.y * offset.y / gmis::square(glm::dot(offset, offset));
      }
    return sum * radiance * gmis::square(2 * half / cells);
  };
}

struct World {
  std::string name;
  std::function<void(SceneBuilder<>&, std::size_t black)> add;
  Irradiance irradiance;
  bool trees_meet_the_floor;  ///< so often that light tracing alone has little noise
};

void add_square(SceneBuilder<>& builder, std::size_t black, const D& middle, double half, bool faces_down,
                double radiance) {
  const std::vector<D> corners{middle + D(-half, 0, -half), middle + D(half, 0, -half), middle + D(half, 0, half),
                               middle + D(-half, 0, half)};
  const std::vector<std::array<int, 3>> down{{0, 1, 2}, {0, 2, 3}}, up{{0, 2, 1}, {0, 3, 2}};
  builder.add_mesh({corners, faces_down ? down : up}, black, AreaEmission{D(radiance)});
}

std::vector<World> worlds() {
  const auto nothing = [](const D&) { return 0.0; };
  const D near(0, 1.2, 0), far(3, 40, 5), sun = D(2000, 9000, -1000);
  std::vector<World> all;
  const auto add = [&](const char* name, bool meets, auto&& add_light, Irradiance irradiance) {
    all.push_back({name, add_light, std::move(irradiance), meets});
  };
  using B = SceneBuilder<>&;
  add(
      "point, near", true, [=](B b, std::size_t) { b.add_point_light(near, D(1)); }, of_point(near, 1));
  add(
      "point, far", false, [=](B b, std::size_t) { b.add_point_light(far, D(900)); }, of_point(far, 900));
  add(
      "spot, near", true,
      [=](B b, std::size_t) {
        b.add_spot_light(near, {0, -1, 0}, D(1), 1.2, 1.2);
      },
      of_point(near, 1));
  add(
      "spot, far", true, [=](B b, std::size_t) { b.add_spot_light(far, -far, D(900), 0.05, 0.08); },
      of_point(far, 900));
  add(
      "spot, behind", true,
      [=](B b, std::size_t) {
        b.add_spot_light({0, 4, 0}, {0, 1, 0}, D(900), 0.4, 0.5);
      },
      nothing);
  add(
      "sphere, near", true, [=](B b, std::size_t black) { b.add_sphere(near, 0.1, black, AreaEmission{D(30)}); },
      of_sphere(near, 0.1, 30));
  add(
      "sphere, far", false, [=](B b, std::size_t black) { b.add_sphere(far, 6, black, AreaEmission{D(9)}); },
      of_sphere(far, 6, 9));
  add(
      "sun", false, [=](B b, std::size_t black) { b.add_sphere(sun, 900, black, AreaEmission{D(30)}); },
      of_sphere(sun, 900, 30));
  add(
      "square, near", true, [=](B b, std::size_t black) { add_square(b, black, near, 0.2, true, 6); },
      of_square(near, 0.2, 6));
  add(
      "square, far", false, [=](B b, std::size_t black) { add_square(b, black, far, 5, true, 20); },
      of_square(far, 5, 20));
  add(
      "square, behind", true,
      [=](B b, std::size_t black) {
        add_square(b, black, {0, 4, 0}, 0.2, false, 900);
      },
      nothing);
  // The furnace of radiance 0.4 with a far sun: where the sun is, its radiance takes the place of
  // the furnace's.
  add(
      "a furnace and its far sun", false,
      [=](B b, std::size_t black) {
        b.add_sphere({0, 0, 0}, 20'000, black, AreaEmission{D(0.4)}, true);
        b.add_sphere(sun, 900, black, AreaEmission{D(30)});
      },
      [=](const D& at) { return pi<double> * 0.4 + of_sphere(sun, 900, 30 - 0.4)(at); });
  return all;
}

/// The mean over the pixels of the floor's radiance, from light that arrives directly.
template <class Camera>
double floor_radiance(const Camera& camera, const D& origin, const Irradiance& irradiance) {
  constexpr int cells = 4;
  const auto size = camera.resolution();
  double sum = 0, count = 0;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x)
      for (int cell = 0; cell < cells * cells; ++cell) {
        const gmis::Vec2<float> u((static_cast<float>(cell % cells) + 0.5F) / cells,
                                  (static_cast<float>(cell / cells) + 0.5F) / cells);
        const auto ray = camera.sample_ray({x, y}, u, {0.5F, 0.5F});
        const D from = D(ray->origin.position) + origin, direction(ray->direction);
        sum += 0.5 / pi<double> * irradiance(from - direction * (from.y / direction.y));
        ++count;
      }
  return sum / count;
}

template <class Engine, class Scene>
gmis_test::Mean mean_and_error(const Scene& scene, const gmis::SampleCounts& counts, int iterations,
                               std::uint64_t seed) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 2;
  settings.seed = gmis_test::seed(seed);
  Engine engine(scene, settings);
  const gmis_test::Mean mean = gmis_test::mean_of_iterations(engine, iterations);
  CHECK(engine.counters().rejected() == 0);
  return mean;
}

}  // namespace

TEST_CASE("Every kind of light keeps its energy near, far and behind, beside a lamp, and so does a furnace", "[long]") {
  using Scene = BvhScene<float>;
  const auto all = worlds();
  // One false alarm in a thousand seeds.
  const double quantile = gmis::normal_quantile(1 - gmis::sidak_level(1e-3, 3 * all.size()) / 2);
  const D lamp(0.4, 0.8, 0.3);
  for (const World& world : all) {
    SceneBuilder<> builder;
    const auto grey = builder.add_material(make_diffuse({0.5, 0.5, 0.5}));
    const auto black = builder.add_material(make_diffuse({0, 0, 0}));
    const std::vector<D> corners{{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
    const std::vector<std::array<int, 3>> halves{{0, 1, 2}, {0, 2, 3}};
    builder.add_mesh({corners, halves}, grey);
    builder.add_point_light(lamp, D(0.2));
    world.add(builder, black);
    builder.set_camera(look_at({0, 2, -2}, {0, 0, 0}, {0, 1, 0}, 16, {8, 8}));  // sees nothing but the floor
    const Scene scene = builder.build();
    const D origin = scene.statistics().world_origin;
    const auto irradiance = [&](const D& at) { return world.irradiance(at) + of_point(lamp, 0.2)(at); };
    const double truth = floor_radiance(scene.camera(), origin, irradiance);
    const auto check = [&](const char* how, const gmis_test::Mean& found) {
      CAPTURE(world.name, how, found.value / truth, found.standard_error / truth);
      // The oracle's own grid, and float.
      CHECK(std::abs(found.value - truth) < quantile * found.standard_error + 1e-3 * truth);
      CHECK(quantile * found.standard_error < 0.05 * truth);  // so that 5 % shows
    };
    check("pt", mean_and_error<gmis::PathTracer<Scene>>(scene, gmis::integrators::pt, 400, 71));
    check("bpt", mean_and_error<gmis::Engine<Scene>>(scene, gmis::integrators::bpt, 400, 72));
    if (world.trees_meet_the_floor)
      check("lt", mean_and_error<gmis::Engine<Scene>>(scene, gmis::integrators::lt, 12000, 73));
  }
}
