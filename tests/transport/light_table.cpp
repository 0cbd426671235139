#include "gmis/transport/lights/light_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/render/thread_executor.hpp"
#include "gmis/scene.hpp"
#include "gmis/transport/engine.hpp"
#include "gmis/transport/integrators.hpp"
#include "gmis/transport/lights/learn_lights.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/quads.hpp"

// Lights chosen by a learned table: probabilities, energy, and what it gains where walls hide lamps.

namespace {

using Scene = gmis::scene::BvhScene<float>;
using Builder = gmis::scene::SceneBuilder<float>;
using Light = Scene::Light;
using Table = gmis::LightTable<float, Light>;
using Learned = gmis::LightTableScene<Scene>;
using Point = gmis::SurfacePoint<float>;
using gmis_test::add_quad;
using V = gmis::Vec3<double>;

/// Four rooms in a row without ceilings between walls; in each a point light, and one has a lamp, too. From above the camera sees all. A
/// wall hides each light from the other rooms.
Scene make_rooms(gmis::scene::LightSelection selection) {
  Builder builder;
  builder.set_light_selection(selection);
  const auto grey = builder.add_material(gmis::scene::make_diffuse({0.3, 0.3, 0.3}));
  const auto black = builder.add_material(gmis::scene::make_diffuse({0, 0, 0}));
  add_quad(builder, grey, {0, 0, 0}, {2, 0, 0}, {0, 1, 0});
  for (int wall = -2; wall <= 2; ++wall) add_quad(builder, grey, {wall, 0, 0.5}, {0, 1, 0}, {0, 0, 0.5});
  for (const double power : {0.2, 0.3, 0.25})
    builder.add_point_light({power == 0.2 ? -1.5 : power == 0.3 ? -0.5 : 0.5, 0.1, 0.4}, {power, power, power});
  add_quad(builder, black, {1.5, 0, 0.3}, {0.1, 0, 0}, {0, -0.1, 0}, gmis::scene::AreaEmission{{12, 12, 12}, false});
  builder.set_camera(gmis::scene::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 45, {32, 16}));
  return builder.build();
}

template <class Executor = gmis::SerialExecutor>
Table learn(const Scene& scene, std::uint64_t seed, Executor executor = {}) {
  return gmis::learn_lights(scene, {.seed = seed, .max_depth = 5, .paths = 4096}, executor);
}

/// Points of the floor and of the walls.
std::vector<Point> receivers() {
  std::vector<Point> points;
  for (int i = 0; i < 40; ++i) {
    Point point{};
    point.position = {-1.95F + 0.1F * static_cast<float>(i), 0.3F * static_cast<float>(i % 5 - 2), 0.0F};
    point.geometric_normal = point.shading_normal = {0, 0, 1};
    points.push_back(point);
  }
  Point wall{};
  wall.position = {1.0F, 0.2F, 0.4F};
  wall.geometric_normal = wall.shading_normal = {1, 0, 0};
  points.push_back(wall);
  return points;
}

std::vector<const Light*> lights_of(const Scene& scene) {
  std::vector<const Light*> lights;
  gmis::Philox source(1, 2, 3);
  for (int i = 0; i < 2000; ++i) {
    const Light* const light = scene.sample_light(gmis::uniform<float>(source)).light;
    if (std::find(lights.begin(), lights.end(), light) == lights.end()) lights.push_back(light);
  }
  return lights;
}

struct Moments {
  double mean = 0, standard_error = 0, variance = 0;  // of the whole picture; sum over pixels of that of an iteration
};

template <class Method, class Scene_>
Moments moments_of(const Scene_& scene, const gmis::SampleCounts& counts, std::uint64_t seed, int iterations) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 4;
  settings.seed = seed;
  settings.radius = 0.02;
  gmis::Engine<Scene_, Method> engine(scene, settings);
  gmis::SerialExecutor executor;
  std::vector<double> sums(engine.frame().size()), squares(engine.frame().size());
  double sum = 0, square = 0;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    double mean = 0;
    for (std::size_t p = 0; p < sums.size(); ++p) {
      const auto value = static_cast<double>(gmis::mean_channel(engine.frame()[p]));
      sums[p] += value, squares[p] += value * value;
      mean += value / static_cast<double>(sums.size());
    }
    sum += mean / iterations, square += mean * mean / iterations;
  }
  CHECK(engine.counters().rejected() == 0);
  Moments all{sum, std::sqrt(std::max(0.0, square - sum * sum) / (iterations - 1)), 0};
  for (std::size_t p = 0; p < sums.size(); ++p)
    all.variance += (squares[p] - sums[p] * sums[p] / iterations) / (iterations - 1);
  return all;
}

}  // namespace

TEST_CASE("A table is what it is made from: probabilities in proportion to the roots of second moments") {
  const std::array<int, 3> lights{};
  std::vector<gmis::LightArrival<float, int>> arrivals;
  const auto arrive = [&](std::size_t light, double moment) {
    arrivals.push_back({{0.1F, 0.2F, 0.3F}, {0, 0, 1}, &lights[light], moment});
  };
  arrive(1, 3), arrive(0, 1), arrive(1, 6), arrive(2, 0), arrive(0, 3);
  const gmis::LightTable<float, int> table(arrivals);
  const std::size_t cell = table.cell({0.1F, 0.2F, 0.3F}, {0, 0.1F, 2});
  CHECK(table.probability(cell, &lights[0]) == Approx(0.4));  // √4 : √9
  CHECK(table.probability(cell, &lights[1]) == Approx(0.6));
  CHECK(table.probability(cell, &lights[2]) == 0);
  CHECK(table.share(cell) == Approx(0.9 * 5 / (5 + 2 * 8)));
  CHECK(table.sample(cell, 0.0F) == &lights[0]);
  CHECK(table.sample(cell, 0.3999F) == &lights[0]);
  CHECK(table.sample(cell, 0.4001F) == &lights[1]);
  CHECK(table.sample(cell, std::nextafter(1.0F, 0.0F)) == &lights[1]);
  const std::size_t other = table.cell({0.1F, 0.2F, 0.3F}, {0, 0.1F, -2});
  CHECK(other != cell);
  CHECK(table.share(other) == 0);
  CHECK(table.probability(other, &lights[0]) == 0);
  CHECK(gmis::LightTable<float, int>().is_empty());
  CHECK(gmis::LightTable<float, int>().share(0) == 0);
}

TEST_CASE("Lights are chosen with the probabilities that are said, and none loses its own") {
  for (const auto selection : {gmis::scene::LightSelection::by_power, gmis::scene::LightSelection::by_receiver}) {
    const Scene scene = make_rooms(selection);
    const Table table = learn(scene, gmis_test::seed(71));
    const Learned learned(scene, table);
    const auto lights = lights_of(scene);
    REQUIRE(lights.size() == 5);  // a quad is two triangles
    const auto points = receivers();
    const double level = gmis::sidak_level(1e-3, 2 * points.size());
    gmis::Philox source(gmis_test::seed(72), 1, 0);
    for (const Point& point : points) {
      constexpr int draws = 4000;
      std::vector<double> counts(lights.size(), 0.0), expected;
      for (int i = 0; i < draws; ++i) {
        const auto choice = learned.sample_light(point, gmis::uniform<float>(source));
        REQUIRE(choice.light != nullptr);
        REQUIRE(choice.selection_probability == learned.selection_probability(*choice.light, point));
        ++counts[static_cast<std::size_t>(std::find(lights.begin(), lights.end(), choice.light) - lights.begin())];
      }
      double sum = 0, chi_square = 0;
      int classes = 0;
      for (std::size_t k = 0; k < lights.size(); ++k) {
        const auto own = static_cast<double>(selection == gmis::scene::LightSelection::by_power
                                                 ? scene.selection_probability(*lights[k])
                                                 : scene.selection_probability(*lights[k], point));
        const auto probability = static_cast<double>(learned.selection_probability(*lights[k], point));
        CHECK(probability >= 0.0999 * own);
        sum += probability;
        if (probability == 0) {
          CHECK(counts[k] == 0);
          continue;
        }
        ++classes;
        chi_square += gmis::square(counts[k] - draws * probability) / (draws * probability);
      }
      CHECK(sum == Approx(1).epsilon(1e-5));
      CAPTURE(point.position.x, chi_square, classes);
      if (classes > 1) CHECK(gmis::chi_square_p_value(chi_square, classes - 1) > level);
    }
  }
}

TEST_CASE("A learned table knows which light is behind a wall") {
  const Scene scene = make_rooms(gmis::scene::LightSelection::by_power);
  const Table table = learn(scene, gmis_test::seed(73));
  const Learned learned(scene, table);
  gmis::Philox source(gmis_test::seed(74), 1, 0);
  int close = 0, all = 0;
  for (const Point& point : receivers()) {
    double nearby = 0;
    for (const Light* light : lights_of(scene)) {
      const auto sample = light->sample_next_event(point, {0.3F, 0.6F});
      if (sample && scene.visible(gmis::segment(point, sample->origin, sample->to_light)))
        nearby += static_cast<double>(learned.selection_probability(*light, point));
    }
    close += nearby > 0.8;
    ++all;
  }
  CHECK(close >= all * 9 / 10);  // cells at the walls are in two rooms
}

TEST_CASE("A table keeps the energy, and takes away the variance that comes from hidden lights") {
  const Scene scene = make_rooms(gmis::scene::LightSelection::by_power);
  gmis::SerialExecutor executor;
  const gmis::LightTraining training{.seed = gmis_test::seed(75), .max_depth = 5, .paths = 4096};
  const auto table = gmis::learn_lights(scene, training, executor);
  const gmis::LightTableScene<Scene> learned(scene, table);
  const double level = gmis::sidak_level(1e-3, 3);
  constexpr int iterations = 1500;
  const auto check = [&]<class Method>(Method, const gmis::SampleCounts& counts, double most_ratio) {
    const Moments truth = moments_of<Method>(scene, counts, gmis_test::seed(76), iterations);
    const Moments with_table = moments_of<Method>(learned, counts, gmis_test::seed(77), iterations);
    const double error = std::hypot(truth.standard_error, with_table.standard_error);
    CAPTURE(with_table.mean / truth.mean, error / truth.mean, with_table.variance / truth.variance);
    CHECK(gmis::student_t_p_value((with_table.mean - truth.mean) / error, iterations - 1.0) > level);
    CHECK(gmis::normal_quantile(1 - level / 2) * error < 0.03 * truth.mean);  // so that 3 % shows
    CHECK(with_table.variance < most_ratio * truth.variance);
  };
  // By power every light has a fifth to a third; the table gives that of the room nearly all. With one light in three the variance of a
  // next event is twice the squared value and more; a half is far from both.
  check(gmis::CameraSide(), gmis::integrators::pt, 0.5);
  check(gmis::BothSides(), gmis::integrators::bpt, 1.0);
  check(gmis::BothSides(), gmis::integrators::vcm, 1.0);
}

TEST_CASE("A table is the same for any number of threads, and one that knows nothing changes no bit") {
  const Scene scene = make_rooms(gmis::scene::LightSelection::by_receiver);
  const Table one = learn(scene, gmis_test::seed(78)),
              three = learn(scene, gmis_test::seed(78), gmis::ThreadExecutor(3));
  const Learned first(scene, one), second(scene, three);
  for (const Point& point : receivers())
    for (const Light* light : lights_of(scene))
      CHECK(first.selection_probability(*light, point) == second.selection_probability(*light, point));
  const Table nothing;
  const Learned plain(scene, nothing);
  gmis::RenderSettings settings;
  settings.counts = gmis::integrators::vcm;
  settings.max_depth = 4;
  settings.seed = gmis_test::seed(79);
  gmis::Engine<Scene> own(scene, settings);
  gmis::Engine<Learned> same(plain, settings);
  gmis::SerialExecutor executor;
  own.iterate(executor);
  same.iterate(executor);
  CHECK(std::memcmp(own.frame().data(), same.frame().data(), own.frame().size_bytes()) == 0);
}
