#include "gmis/scene/light_hierarchy_build.hpp"

#include <cmath>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/core/warp.hpp"
#include "gmis/scene/scene_builder.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"

namespace {

using gmis::Philox;
using gmis::uniform;
using gmis::scene::Light;
using gmis::scene::LightHierarchy;
using gmis::scene::LightHierarchyBuilder;

template <class T>
gmis::Vec3<T> random_in_cube(Philox& source, T size) {
  const T x = uniform<T>(source), y = uniform<T>(source), z = uniform<T>(source);
  return (gmis::Vec3<T>(x, y, z) * T(2) - T(1)) * size;
}
template <class T>
gmis::Vec3<T> random_direction(Philox& source) {
  const T u = uniform<T>(source);
  return gmis::square_to_sphere(gmis::Vec2<T>(u, uniform<T>(source)));
}

/// Lights of every kind, of powers from 1e-4 to 1e4; `infinite`: a sky and a sun among them.
template <class T>
std::vector<Light<T>> random_lights(Philox& source, std::size_t count, bool infinite) {
  std::vector<Light<T>> lights;
  if (infinite) {
    lights.push_back(Light<T>::environment(gmis::Vec3<T>(T(0.1))));
    lights.push_back(Light<T>::directional(random_direction<T>(source), gmis::Vec3<T>(T(0.3))));
  }
  while (lights.size() < count) {
    const auto place = random_in_cube(source, T(5));
    const gmis::Vec3<T> power(static_cast<T>(std::pow(10.0, 8.0 * uniform<double>(source) - 4.0)));
    const auto b = place + random_in_cube(source, T(0.3)), c = place + random_in_cube(source, T(0.3));
    const auto normal = glm::cross(b - place, c - place);
    switch (lights.size() % 6) {
      case 0:
      case 1:
        if (glm::length(normal) > T(1e-4))
          lights.push_back(
              Light<T>::triangle(place, b, c, glm::normalize(normal), T(1e-5), power, lights.size() % 6 == 1));
        else
          lights.push_back(Light<T>::point(place, power));
        break;
      case 2:
        lights.push_back(Light<T>::sphere(place, T(0.2), uniform<T>(source) < T(0.5), T(1e-5), power, false));
        break;
      case 3:
        lights.push_back(Light<T>::spot(
            place, gmis::scene::SpotCone<T>(random_direction<T>(source), 0.1, 0.1 + 2.9 * uniform<double>(source)),
            power));
        break;
      case 4:
        lights.push_back(Light<T>::point(place, power));
        break;
      default:
        lights.push_back(Light<T>::point(place, gmis::Vec3<T>(T(0))));  // it shines nowhere
        break;
    }
  }
  for (Light<T>& light : lights) light.enclose({}, T(10));
  return lights;
}

/// Groups of 1 to 12 lights that follow each other; leaves hold at most 8.
std::vector<std::size_t> groups_of(std::size_t lights) {
  std::vector<std::size_t> groups;
  for (std::size_t group = 0; groups.size() < lights; ++group)
    for (std::size_t k = 0; k <= group % 12 && groups.size() < lights; ++k) groups.push_back(group);
  return groups;
}

template <class T>
gmis::SurfacePoint<T> random_receiver(Philox& source, T size) {
  const auto normal = random_direction<T>(source);
  return {random_in_cube(source, size), normal, normal, T(1e-5)};
}

}  // namespace

TEMPLATE_TEST_CASE("The probabilities of all lights sum to one at every receiver", "", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(71));
  for (const std::size_t count : {1U, 2U, 3U, 7U, 40U, 1000U})
    for (const bool infinite : {false, true}) {
      const auto lights = random_lights<T>(source, std::max<std::size_t>(count, infinite ? 2 : 1), infinite);
      const auto groups = groups_of(lights.size());
      const auto hierarchy =
          count % 2 == 0 ? LightHierarchyBuilder<T>::build(lights, groups) : LightHierarchyBuilder<T>::build(lights);
      for (int n = 0; n < 50; ++n) {
        const auto from = random_receiver<T>(source, T(8));
        double sum = 0;
        for (std::size_t i = 0; i < lights.size(); ++i) {
          const auto p = static_cast<double>(hierarchy.probability(i, from));
          CHECK((p >= 0.0 && p <= 1.0));
          if (!(lights[i].power() > 0)) CHECK(p == 0.0);
          sum += p;
        }
        CAPTURE(count, infinite, n);
        CHECK(sum == Approx(1.0).epsilon(64 * static_cast<double>(std::numeric_limits<T>::epsilon())));
      }
    }
}

TEMPLATE_TEST_CASE("Lights are chosen with the stated probabilities", "", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(72));
  constexpr int receivers = 12, draws = 40000;
  const double level = gmis::sidak_level(1e-4, 2 * 3 * receivers);  // of both types
  for (const std::size_t count : {5U, 60U, 3000U}) {
    const auto lights = random_lights<T>(source, count, count == 60);
    const auto groups = groups_of(lights.size());
    const auto hierarchy =
        count == 5 ? LightHierarchyBuilder<T>::build(lights) : LightHierarchyBuilder<T>::build(lights, groups);
    for (int n = 0; n < receivers; ++n) {
      const auto from = random_receiver<T>(source, T(6));
      std::vector<double> expected(count), observed(count);
      for (std::size_t i = 0; i < count; ++i) expected[i] = draws * static_cast<double>(hierarchy.probability(i, from));
      double worst = 0;
      for (int i = 0; i < draws; ++i) {
        const auto choice = hierarchy.sample(from, uniform<T>(source));
        ++observed[choice.light];
        worst = std::max(worst, std::abs(static_cast<double>(choice.probability) * draws / expected[choice.light] - 1));
      }
      CAPTURE(count, n);
      CHECK(worst < 1e-4);
      CHECK(gmis::chi_square_test(observed, expected).passes(level));
    }
  }
}

TEMPLATE_TEST_CASE("A light that reaches the receiver is chosen with a positive probability", "", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(73));
  std::size_t reached = 0, possible = 0, excluded = 0;
  for (int repetition = 0; repetition < 6; ++repetition) {
    const auto lights = random_lights<T>(source, 200, repetition % 2 == 0);
    const auto hierarchy = LightHierarchyBuilder<T>::build(lights);
    for (int n = 0; n < 60; ++n) {
      auto from = random_receiver<T>(source, T(6));
      // Also on a light's own plane, and at its centre.
      if (n % 6 == 0) {
        const T u = uniform<T>(source), v = uniform<T>(source);
        if (const auto start = lights[static_cast<std::size_t>(n)].sample_emission({u, v}, {v, u}))
          from.position = start->origin.position;
      }
      for (std::size_t i = 0; i < lights.size(); ++i) {
        ++possible;
        bool reaches = false;
        for (int k = 0; k < 4 && !reaches; ++k) {
          const T u = uniform<T>(source);
          const auto sample = lights[i].sample_next_event(from, {u, uniform<T>(source)});
          reaches = sample && !gmis::is_black(sample->weight);
        }
        const bool is_chosen = hierarchy.probability(i, from) > T(0);
        excluded += is_chosen ? 0U : 1U;
        if (!reaches) continue;
        ++reached;
        if (!is_chosen) FAIL_CHECK("light " << i << " reaches the receiver and is never chosen");
      }
    }
  }
  CHECK(reached > possible / 3);
  CHECK(excluded > possible / 10);  // bounds that exclude nothing would pass, too
}

TEST_CASE("Lights at one place, thousands of them, and one alone make sound hierarchies") {
  const gmis::SurfacePoint<float> from{{1, 2, 3}, {0, 0, 1}, {0, 0, 1}, 1e-5F};
  for (const std::size_t count : {1U, 2U, 5000U}) {
    std::vector<Light<float>> lights(count, Light<float>::point({0.5F, 0.5F, 0.5F}, gmis::Vec3<float>(2.0F)));
    const auto hierarchy = LightHierarchyBuilder<float>::build(lights);
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += static_cast<double>(hierarchy.probability(i, from));
    CHECK(sum == Approx(1.0).epsilon(1e-4));
    // At the very place of the lights.
    const gmis::SurfacePoint<float> there{{0.5F, 0.5F, 0.5F}, {0, 0, 1}, {0, 0, 1}, 1e-5F};
    const auto choice = hierarchy.sample(there, 0.3F);
    CHECK((choice.probability > 0.0F && choice.probability <= 1.0F));
  }
  // Places in geometric progression: a deep tree.
  std::vector<Light<double>> deep;
  for (int i = 0; i < 900; ++i)
    deep.push_back(Light<double>::point({std::pow(2.0, -i), 0, 0}, gmis::Vec3<double>(1.0)));
  const auto hierarchy = LightHierarchyBuilder<double>::build(deep);
  double sum = 0;
  const gmis::SurfacePoint<double> above{{0, 0, 0.1}, {0, 0, -1}, {0, 0, -1}, 1e-9};
  for (std::size_t i = 0; i < deep.size(); ++i) sum += hierarchy.probability(i, above);
  CHECK(sum == Approx(1.0));
  CHECK(LightHierarchyBuilder<float>::build({}).is_empty());
}

TEST_CASE(
    "A light near the receiver is chosen more often than one far away, one that shines there than one turned away") {
  using V = gmis::Vec3<float>;
  std::vector<Light<float>> lights;
  for (int i = 0; i < 64; ++i) lights.push_back(Light<float>::point({static_cast<float>(i), 0, 1}, V(1.0F)));
  const auto hierarchy = LightHierarchyBuilder<float>::build(lights);
  const gmis::SurfacePoint<float> from{{20, 0, 0}, {0, 0, 1}, {0, 0, 1}, 1e-5F};
  // Exactly by irradiance it would be 0.48 for the light above, 1/2.83 of that for either
  // neighbour.
  CHECK(hierarchy.probability(20, from) > 0.15F);
  CHECK(hierarchy.probability(20, from) > 20 * hierarchy.probability(50, from));
  // Of two lamps, one turns its back.
  const auto lamp = [](float x, float up) {
    return Light<float>::triangle({x, -0.1F, 1}, {x + 0.2F, -0.1F, 1}, {x, 0.1F, 1}, {0, 0, up}, 1e-5F, V(1.0F), false);
  };
  const std::vector<Light<float>> pair{lamp(-0.5F, 1.0F), lamp(0.5F, -1.0F)};
  const auto two = LightHierarchyBuilder<float>::build(pair);
  const gmis::SurfacePoint<float> below{{0, 0, 0}, {0, 0, 1}, {0, 0, 1}, 1e-5F};
  CHECK(two.probability(0, below) == 0.0F);
  CHECK(two.probability(1, below) == 1.0F);
}

TEST_CASE("The triangles of a lamp share a leaf, within which they are chosen by power at every receiver") {
  const auto triangle = [](double x, double width) {
    return Light<double>::triangle({x, -0.1, 1}, {x + width, -0.1, 1}, {x, 0.1, 1}, {0, 0, -1}, 1e-9,
                                   gmis::Vec3<double>(1.0), false);
  };
  // Twice as wide is twice as bright. The third lamp is another one.
  const std::vector<Light<double>> lights{triangle(-1, 0.1), triangle(-0.9, 0.2), triangle(1, 0.1)};
  const std::vector<std::size_t> groups{4, 4, 5};
  const auto hierarchy = LightHierarchyBuilder<double>::build(lights, groups);
  CHECK(hierarchy.has_choice());
  for (const double x : {-3.0, -0.9, 0.0, 4.0}) {
    const gmis::SurfacePoint<double> below{{x, 0, 0}, {0, 0, 1}, {0, 0, 1}, 1e-9};
    const double first = hierarchy.probability(0, below);
    CHECK(hierarchy.probability(1, below) == Approx(2 * first).epsilon(1e-12));
    CHECK(hierarchy.probability(2, below) == Approx(1 - 3 * first).epsilon(1e-12));
  }
  CHECK_FALSE(LightHierarchyBuilder<double>::build(std::span(lights).first(2), groups).has_choice());
}

namespace {

/// A hall with lamps of every kind.
auto hall(gmis::scene::LightSelection selection) {
  using namespace gmis::scene;
  SceneBuilder<> builder;
  const auto stone = builder.add_material(make_diffuse({0.6, 0.55, 0.5}));
  const auto metal = builder.add_material(make_conductor_of_reflectance<float>({0.9, 0.7, 0.4}, 0.3F));
  const std::vector<std::array<int, 3>> quad{{0, 1, 2}, {0, 2, 3}};
  const auto add = [&](const std::vector<glm::dvec3>& corners, std::size_t material, const glm::dvec3& radiance) {
    builder.add_mesh({corners, quad}, material,
                     radiance.x > 0 ? std::optional(AreaEmission{radiance, false}) : std::nullopt);
  };
  add({{-6, 0, -2}, {-6, 0, 12}, {6, 0, 12}, {6, 0, -2}}, stone, {});
  add({{-6, 0, 12}, {-6, 5, 12}, {6, 5, 12}, {6, 0, 12}}, stone, {});
  builder.add_sphere({0, 1, 4}, 1, metal);
  Philox source(3);
  for (int i = 0; i < 60; ++i) {
    const double x = 10.0 * uniform<double>(source) - 5.0, y = 0.5 + 3.0 * uniform<double>(source),
                 z = 11.0 * uniform<double>(source);
    const double power = i % 9 == 0 ? 8.0 : 1.0;
    switch (i % 4) {
      case 0:
        builder.add_point_light({x, y, z}, glm::dvec3(0.2 * power));
        break;
      case 1:
        add({{x, y, z}, {x + 0.3, y, z}, {x + 0.3, y, z + 0.3}, {x, y, z + 0.3}}, stone, glm::dvec3(3.0 * power));
        break;
      case 2:
        builder.add_sphere({x, y, z}, 0.1, stone, AreaEmission{glm::dvec3(4.0 * power)});
        break;
      default:
        builder.add_spot_light({x, y, z}, {0.3, -1, 0.1}, glm::dvec3(0.5 * power), 0.3, 0.8);
        break;
    }
  }
  builder.add_environment({0.02, 0.03, 0.05});
  builder.set_light_selection(selection);
  builder.set_camera(look_at({0, 2.5, -5}, {0, 1, 4}, {0, 1, 0}, 60, {16, 12}));
  return builder.build();
}

struct Picture {
  std::vector<double> mean, variance_of_mean;
  int iterations;
};
template <class Engine, class Scene>
Picture picture_of(const Scene& scene, const gmis::SampleCounts& counts, int iterations, std::uint64_t seed) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 5;
  settings.seed = gmis_test::seed(seed);
  Engine engine(scene, settings);
  gmis::SerialExecutor executor;
  Picture picture{std::vector<double>(16 * 12), std::vector<double>(16 * 12), iterations};
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    for (std::size_t p = 0; p < picture.mean.size(); ++p) {
      const auto value = static_cast<double>(gmis::mean_channel(engine.frame()[p]));
      picture.mean[p] += value / iterations;
      picture.variance_of_mean[p] += value * value / iterations;
    }
  }
  for (std::size_t p = 0; p < picture.mean.size(); ++p)
    picture.variance_of_mean[p] =
        std::max(0.0, picture.variance_of_mean[p] - gmis::square(picture.mean[p])) / (iterations - 1);
  CHECK(engine.counters().rejected() == 0);
  return picture;
}

}  // namespace

TEST_CASE("Next events by the hierarchy make the same picture, with less noise") {
  using Scene = gmis::scene::BvhScene<>;
  const auto plain = hall(gmis::scene::LightSelection::by_power);
  const auto chosen = hall(gmis::scene::LightSelection::by_receiver);
  const Picture truth = picture_of<gmis::PathTracer<Scene>>(plain, gmis::integrators::pt, 800, 81);
  const Picture by_receiver = picture_of<gmis::PathTracer<Scene>>(chosen, gmis::integrators::pt, 400, 82);
  const Picture both_sides = picture_of<gmis::Engine<Scene>>(chosen, gmis::integrators::bpt, 400, 83);
  // Two comparisons of rows of pixels each; the mean of a row is nearly normal. One false alarm in
  // 10,000 seeds.
  const double level = gmis::sidak_level(1e-4, 2 * 12);
  for (const Picture* other : {&by_receiver, &both_sides})
    for (std::size_t row = 0; row < 12; ++row) {
      double difference = 0, variance = 0;
      for (std::size_t p = 16 * row; p < 16 * (row + 1); ++p) {
        difference += other->mean[p] - truth.mean[p];
        variance += other->variance_of_mean[p] + truth.variance_of_mean[p];
      }
      CAPTURE(row, difference, std::sqrt(variance));
      CHECK(gmis::t_test(difference, std::sqrt(variance), 400, 0.0).passes(level));
    }
  // Geometric mean over the pixels: a sum would be ruled by the few that see a lamp's edge or a
  // place next to a lamp. Pixels that see nothing but the sky have no noise, or hardly any.
  double logarithms = 0, count = 0;
  for (std::size_t p = 0; p < truth.mean.size(); ++p) {
    const double least = std::min(truth.variance_of_mean[p], by_receiver.variance_of_mean[p]);
    if (!(least > 1e-8 * gmis::square(truth.mean[p]))) continue;
    logarithms += std::log(2 * truth.variance_of_mean[p] / by_receiver.variance_of_mean[p]);
    ++count;
  }
  const double gain = std::exp(logarithms / count);
  CHECK(count > 96);
  CAPTURE(gain);
  CHECK(gain > 1.5);
}
