#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/scene.hpp"
#include "gmis/transport/emission/learn_lights.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/backward_executor.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/mean_of_iterations.hpp"

// Learned emission in built-in scenes: starts follow the stated density, pictures keep their
// energy, and light trees hit what is seen as often as the geometry says.

namespace {

using Scene = gmis::scene::BvhScene<float>;
using Builder = gmis::scene::SceneBuilder<float>;
using Guide = gmis::EmissionGuide<Scene>;
using V = gmis::Vec3<double>;

const V to_sun = glm::normalize(V(0.5, 0.8, -0.33));

void add_quad(Builder& builder, std::size_t material, const V& centre, const V& a, const V& b,
              const std::optional<gmis::scene::AreaEmission>& emission = {}) {
  const std::vector<glm::dvec3> corners{centre - a - b, centre + a - b, centre + a + b, centre - a + b};
  const std::vector<std::array<int, 3>> halves{{0, 1, 2}, {0, 2, 3}};
  builder.add_mesh({corners, halves}, material, emission);
}

enum class Lights { far_sphere, sky, image, sun, ceiling, spot_and_point, all };

/// A floor of 2 × 2 with a diffuse ball and a mirror, which throws light onto the floor and is seen
/// from behind.
Scene make_scene(Lights lights, int size = 24) {
  Builder builder;
  const auto grey = builder.add_material(gmis::scene::make_diffuse({0.6, 0.6, 0.6}));
  const auto black = builder.add_material(gmis::scene::make_diffuse({0, 0, 0}));
  const auto mirror = builder.add_material(gmis::scene::make_mirror({0.8, 0.8, 0.8}));
  add_quad(builder, grey, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});
  builder.add_sphere({0.4, 0.35, 0.1}, 0.35, grey);
  add_quad(builder, mirror, {-0.95, 0.4, 0}, {0, 0.4, 0}, {0, 0, 0.6});
  const bool has_all = lights == Lights::all;
  const gmis::scene::AreaEmission bright{{9, 9, 9}, false}, dim{{2, 2, 2}, true};
  if (has_all || lights == Lights::far_sphere) builder.add_sphere(to_sun * 15.0, 4.5, black, bright);
  if (has_all || lights == Lights::sky) builder.add_environment({0.5, 0.6, 0.7});
  if (lights == Lights::image) {
    gmis::scene::EnvironmentImage image{{4, 4}, {}, gmis::scene::SkyMapping::equal_area};
    for (int i = 0; i < 16; ++i) image.radiance.push_back(glm::vec3(i % 5 == 2 ? 4.0F : 0.2F));
    builder.add_environment(image);
  }
  if (has_all || lights == Lights::sun) builder.add_directional_light(to_sun, {2, 2, 2});
  if (lights == Lights::ceiling) add_quad(builder, black, {0, 4, 0}, {6, 0, 0}, {0, 0, 6}, dim);
  if (has_all || lights == Lights::spot_and_point) {
    builder.add_spot_light({1, 1.5, -0.5}, {-1, -1.5, 0.5}, {3, 3, 3}, 0.2, 0.6);
    builder.add_point_light({-0.5, 1.2, 0.5}, {1, 1, 1});
  }
  // Far away: everything else is small beside the bounding ball.
  if (lights != Lights::far_sphere) builder.add_sphere({0, -12, 0}, 2, grey);
  builder.set_camera(gmis::scene::look_at({-2, 2.5, -0.6}, {0.1, 0, 0}, {0, 1, 0}, 40, {size, size}));
  return builder.build();
}

Guide learn(const Scene& scene, std::uint64_t seed = gmis_test::seed(7)) {
  gmis::SerialExecutor executor;
  return gmis::learn_lights(scene, seed, 8, executor, 1e9)->guide;  // also where it would not pay
}

constexpr std::array every_kind{Lights::far_sphere,     Lights::sky, Lights::image, Lights::sun, Lights::ceiling,
                                Lights::spot_and_point, Lights::all};

/// Where the line of a start passes the floor's middle: the place of its nearest point, among 12;
/// nothing beyond 2 units.
struct Passing {
  gmis::Vec3<float> point;
  std::size_t place;
};
std::optional<Passing> passing(const Scene& scene, const gmis::EmissionSample<gmis::Vec3<float>>& start) {
  const V origin = scene.statistics().world_origin;  // the scene's own space has the camera at 0
  const V from = V(start.origin.position) + origin, direction(start.direction);
  const double along = glm::dot(-from, direction);
  if (along <= 0) return std::nullopt;
  const V nearest = from + direction * along;
  const double distance = glm::length(nearest);
  if (distance > 2) return std::nullopt;
  const std::size_t octant = (nearest.x > 0 ? 1U : 0U) + (nearest.y > 0 ? 2U : 0U) + (nearest.z > 0 ? 4U : 0U);
  return Passing{gmis::Vec3<float>(nearest - origin), distance < 0.6 ? 8 + octant / 2 : octant};
}

}  // namespace

TEST_CASE("Guided starts follow the stated density, which is nowhere below its fixed share") {
  // A million starts by emission as the lights have it, with the density p, and as many guided
  // ones, with the density R p, where R is `ratio`. Each of the first counts R / (1 + R) and each
  // of the second 1 / (1 + R): both sums have the mean Σ p R / (1 + R), and no term is above 1.
  constexpr int count = 1'000'000;
  // 7 scenes with 12 places each.
  const double level = gmis::sidak_level(1e-3, 7 * 12);
  for (const Lights lights : every_kind) {
    CAPTURE(static_cast<int>(lights));
    const Scene scene = make_scene(lights);
    const Guide guide = learn(scene);
    REQUIRE_FALSE(guide.is_empty());
    gmis::Philox source(gmis_test::seed(19));
    const auto two = [&] {
      const float u = gmis::uniform<float>(source);
      return gmis::Vec2<float>{u, gmis::uniform<float>(source)};
    };
    bool is_above_share = true;
    std::array<double, 12> own{}, stated{}, squares{};
    for (const bool is_guided : {false, true})
      for (int i = 0; i < count; ++i) {
        const gmis::GuidedLight<float, gmis::scene::Light<float>>* guided = nullptr;
        const float u = gmis::uniform<float>(source);
        const auto choice = is_guided ? guide.sample_light(scene, u, guided) : scene.sample_light(u);
        const auto start = guide.sample(*choice.light, guided, two(), two());
        if (!start) continue;
        const auto place = passing(scene, *start);
        if (!place) continue;
        const double ratio =
            static_cast<double>(guide.ratio(*choice.light, choice.selection_probability, start->density.first,
                                            start->origin, start->direction, place->point));
        is_above_share = is_above_share && ratio >= static_cast<double>(guide.own_share());
        const double term = (is_guided ? 1 : ratio) / (1 + ratio);
        (is_guided ? stated : own)[place->place] += term;
        squares[place->place] += term * term;
      }
    CHECK(is_above_share);
    for (std::size_t i = 0; i < own.size(); ++i) {
      CAPTURE(i, own[i], stated[i], squares[i]);
      if (own[i] + stated[i] < 100) continue;  // below, the sums are not normal
      CHECK(gmis::z_test(own[i], std::sqrt(squares[i]), stated[i]).passes(level));
    }
  }
}

TEST_CASE("What is learned depends on the seed alone, not on who does which part of the work when") {
  const Scene scene = make_scene(Lights::all);
  gmis_test::BackwardExecutor executor;
  const Guide forwards = learn(scene, 3), backwards = gmis::learn_lights(scene, 3, 8, executor, 1e9)->guide;
  REQUIRE(forwards.lights().size() == backwards.lights().size());
  REQUIRE(forwards.lights().size() >= 2);
  for (std::size_t i = 0; i < forwards.lights().size(); ++i) {
    const auto &a = forwards.lights()[i], &b = backwards.lights()[i];
    CHECK(a.light == b.light);
    CHECK(a.probability == b.probability);
    CHECK(a.first.bins() == b.first.bins());
    CHECK(a.aim.centre() == b.aim.centre());
    CHECK(a.aim.radii() == b.aim.radii());
  }
}

TEST_CASE("A run that goes on later learns the same: its pictures have the same bits") {
  const Scene scene = make_scene(Lights::far_sphere);
  gmis::RenderSettings settings;
  settings.emission = gmis::Emission::learned;
  settings.max_depth = 5;
  settings.seed = 3;
  gmis::SerialExecutor executor;
  gmis::Engine<Scene> whole(scene, settings), later(scene, settings);
  for (int i = 0; i < 3; ++i) whole.iterate(executor);
  later.continue_after(2);
  later.iterate(executor);
  REQUIRE(later.emission_guide() != nullptr);
  CHECK(std::memcmp(whole.frame().data(), later.frame().data(), whole.frame().size_bytes()) == 0);
}

TEST_CASE("The share of next events is that of their density per steradian") {
  constexpr float by_bsdf = 0.2F;
  for (const Lights lights : every_kind) {
    CAPTURE(static_cast<int>(lights));
    const Scene scene = make_scene(lights);
    const gmis::SurfacePoint<float> receiver{
        gmis::Vec3<float>(V(-0.4, 0, 0.2) - scene.statistics().world_origin), {0, 1, 0}, {0, 1, 0}, 0.0F};
    gmis::Philox source(gmis_test::seed(20));
    int compared = 0;
    for (int i = 0; i < 200; ++i) {
      const auto choice = scene.sample_light(gmis::uniform<float>(source));
      const float u = gmis::uniform<float>(source);
      const auto sample = choice.light->sample_next_event(receiver, {u, gmis::uniform<float>(source)});
      if (!sample) continue;
      const double share = gmis::detail::next_event_share(choice, *sample, receiver, by_bsdf);
      ++compared;
      if (choice.light->is_delta()) {
        CHECK(share == 1);
        continue;
      }
      // The radiance over the weight of the sample is that density.
      const auto radiance = choice.light->emitted(sample->origin, -sample->to_light).radiance;
      const double density = static_cast<double>(choice.selection_probability * gmis::mean_channel(radiance) /
                                                 gmis::mean_channel(sample->weight));
      CHECK(share == Approx(density / (density + static_cast<double>(by_bsdf))).epsilon(1e-4));
    }
    CHECK(compared > 50);
  }
}

TEST_CASE("Arrivals at later vertices count the rays that roulette lets go on") {
  // A floor and a wall under a sky: next events at the first vertex of a camera subpath, and at the
  // second, where nine tenths of the albedo goes on.
  constexpr float sky = 0.8F, albedo = 0.5F;
  Builder builder;
  const auto grey = builder.add_material(gmis::scene::make_diffuse({albedo, albedo, albedo}));
  add_quad(builder, grey, {0, 0, 0}, {0, 0, 2}, {2, 0, 0});
  add_quad(builder, grey, {0, 2, 2}, {0, 2, 0}, {2, 0, 0});
  builder.add_environment({sky, sky, sky});
  builder.set_camera(gmis::scene::look_at({0, 3, -5}, {0, 1, 1}, {0, 1, 0}, 30, {16, 16}));
  const Scene scene = builder.build();
  int first = 0, later = 0;
  for (std::uint32_t i = 0; i < 256; ++i) {
    bool is_past_first = false;
    gmis::detail::find_arrivals(
        scene, {static_cast<int>(i % 16), static_cast<int>(i / 16)}, 4, gmis::Philox(gmis_test::seed(23), 0, i, 6),
        [&](const auto& arrival) {
          const V at = V(arrival.receiver) + scene.statistics().world_origin;
          const gmis::Vec3<float> normal = at.y < 1e-3 ? gmis::Vec3<float>(0, 1, 0) : gmis::Vec3<float>(0, 0, -1);
          const gmis::SurfacePoint<float> receiver{arrival.receiver, normal, normal, 0.0F};
          const auto sample = arrival.light->sample_next_event(receiver, {0.3F, 0.6F});
          REQUIRE(sample.has_value());
          const double density = static_cast<double>(sky / gmis::mean_channel(sample->weight));
          const double cosine = static_cast<double>(-glm::dot(normal, arrival.direction));
          const auto share = [&](double survival) {
            return density / (density + survival * cosine / std::numbers::pi);
          };
          const bool is_first = arrival.next_event_share == Approx(share(1.0)).epsilon(1e-4);
          if (!is_first)
            CHECK(arrival.next_event_share == Approx(share(0.9 * static_cast<double>(albedo))).epsilon(1e-4));
          CHECK_FALSE((is_first && is_past_first));
          is_past_first = true;
          ++(is_first ? first : later);
        });
  }
  CHECK(first > 50);
  CHECK(later > 20);
}

TEST_CASE("A guide chooses between a sun and a sky by what next events make of them") {
  // A floor that sees nothing else: all places are alike.
  constexpr float sky = 0.8F, sun = 2.0F, albedo = 0.2F;
  Builder builder;
  add_quad(builder, builder.add_material(gmis::scene::make_diffuse({albedo, albedo, albedo})), {0, 0, 0}, {0, 0, 1},
           {1, 0, 0});
  builder.add_environment({sky, sky, sky});
  builder.add_directional_light(to_sun, {sun, sun, sun});
  builder.set_camera(gmis::scene::look_at({0, 4, 0}, {0, 0, 0}, {0, 0, 1}, 20, {64, 64}));
  const Scene scene = builder.build();
  const Guide guide = learn(scene);
  REQUIRE(guide.lights().size() == 2);

  // Moments of the masses, without the common factor, where light i is drawn with p_i: of the sky
  // by a sum over cosines, with its constant density per steradian on the upper half.
  std::array<double, 2> mean{}, square{};
  std::size_t number_of_sky = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& light = *guide.lights()[i].light;
    const double p = static_cast<double>(scene.selection_probability(light));
    if (light.is_delta()) {
      mean[i] = static_cast<double>(sun) * to_sun.y;
      square[i] = mean[i] * mean[i] / p;
      continue;
    }
    number_of_sky = i;
    const gmis::SurfacePoint<float> receiver{
        gmis::Vec3<float>(-scene.statistics().world_origin), {0, 1, 0}, {0, 1, 0}, 0.0F};
    const auto sample = light.sample_next_event(receiver, {0.3F, 0.6F});
    REQUIRE(sample.has_value());
    const double density = static_cast<double>(sky / gmis::mean_channel(sample->weight));
    constexpr double survival = 1;  // at the first vertex
    constexpr int steps = 1000;
    for (int k = 0; k < steps; ++k) {
      const double cosine = (k + 0.5) / steps, by_bsdf = survival * cosine / std::numbers::pi;
      const double value = static_cast<double>(sky) * cosine * p * density / (p * density + by_bsdf);
      mean[i] += 2 * std::numbers::pi * value / steps;
      square[i] += 2 * std::numbers::pi * value * value / (p * density) / steps;
    }
  }
  const double whole = mean[0] + mean[1], share = mean[number_of_sky] / whole;
  // Of X / (X + Y), with means over 1024 camera subpaths of one next event each.
  const double a = mean[0] / whole, b = mean[1] / whole;
  const double variance = (b * b * (square[0] / (whole * whole) - a * a) +
                           a * a * (square[1] / (whole * whole) - b * b) + 2 * a * b * a * b) /
                          1024;
  const double learned = static_cast<double>(guide.lights()[number_of_sky].probability);
  CAPTURE(share, learned, std::sqrt(variance));
  CHECK(share < 0.7 * sky * std::numbers::pi / (sky * std::numbers::pi + sun * to_sun.y));
  CHECK(gmis::z_test(learned, std::sqrt(variance), share).passes(1e-4));
  CHECK(std::sqrt(variance) < 0.1 * share);
}

TEST_CASE("The moment of a guide counts each arrival by its share of next events") {
  const Scene scene = make_scene(Lights::all);
  std::vector<gmis::ArrivalIn<Scene>> arrivals;
  for (std::uint32_t i = 0; i < 576; ++i)
    gmis::detail::find_arrivals(scene, {static_cast<int>(i % 24), static_cast<int>(i / 24)}, 4,
                                gmis::Philox(gmis_test::seed(21), 0, i, 6),
                                [&](const auto& arrival) { arrivals.push_back(arrival); });
  auto scaled = arrivals;
  bool is_any_shared = false;
  for (auto& arrival : scaled) {
    is_any_shared = is_any_shared || arrival.next_event_share < 0.5F;
    arrival.mass *= std::exchange(arrival.next_event_share, 1.0F);
  }
  CHECK(is_any_shared);
  const Guide guide = learn(scene);
  const auto moment_of = [&](const std::vector<gmis::ArrivalIn<Scene>>& all) {
    std::vector<const gmis::ArrivalIn<Scene>*> pointers;
    for (const auto& arrival : all) pointers.push_back(&arrival);
    return gmis::relative_moment<Scene>(scene, guide, pointers);
  };
  const double moment = moment_of(arrivals);
  CHECK(moment == Approx(moment_of(scaled)));
  for (auto& arrival : arrivals) arrival.next_event_share = 1;
  CHECK(std::abs(moment_of(arrivals) / moment - 1) > 0.01);
}

TEST_CASE("Nothing is guided where most of the emitted light is of use") {
  Builder builder;
  const auto grey = builder.add_material(gmis::scene::make_diffuse({0.5, 0.5, 0.5}));
  builder.add_sphere({0, 0, 0}, 5, grey);
  builder.add_point_light({0, 3, 0}, {10, 10, 10});
  builder.set_camera(gmis::scene::look_at({0, 0, -2}, {0, 0, 1}, {0, 1, 0}, 80, {16, 16}));
  const Scene scene = builder.build();
  gmis::SerialExecutor executor;
  CHECK(gmis::learn_lights(scene, gmis_test::seed(8), 8, executor)->guide.is_empty());
}

namespace {

using gmis_test::Mean;

Mean mean_of(const Scene& scene, const gmis::SampleCounts& counts, gmis::Emission emission, int iterations) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 5;
  settings.emission = emission;
  settings.seed = gmis_test::seed(emission == gmis::Emission::learned ? 43 : 44);
  gmis::Engine<Scene> engine(scene, settings);
  if (emission == gmis::Emission::learned) {
    const auto lights = std::make_shared<gmis::LearnedLights<Scene>>();
    lights->guide = learn(scene, settings.seed);
    engine.use_lights(lights);
  }
  const Mean mean = gmis_test::mean_of_iterations(engine, iterations);
  CHECK(engine.counters().rejected() == 0);
  CHECK((engine.emission_guide() != nullptr) == (emission == gmis::Emission::learned));
  return mean;
}

}  // namespace

TEST_CASE("Learned emission keeps the energy, with every technique and under every kind of light") {
  // 6 scenes, 2 integrators. Merging is biased a little, in its own way with each set of weights.
  const double quantile = gmis::normal_quantile(1 - gmis::sidak_level(1e-3, 12) / 2);
  for (const Lights lights : every_kind) {
    if (lights == Lights::all) continue;  // by power, hardly a tree starts on the small lights
    const Scene scene = make_scene(lights);
    // Path tracing finds each path but the mirror's light from lights that no ray can hit.
    const bool has_delta_lights = lights == Lights::sun || lights == Lights::spot_and_point;
    for (const auto* const counts : {&gmis::integrators::bpt, &gmis::integrators::vcm}) {
      const Mean truth =
          mean_of(scene, has_delta_lights ? *counts : gmis::integrators::pt, gmis::Emission::power, 1000);
      const Mean learned = mean_of(scene, *counts, gmis::Emission::learned, 400);
      const double error = std::hypot(truth.standard_error, learned.standard_error);
      const double bias = counts->merges ? 0.003 : 0.0;
      CAPTURE(static_cast<int>(lights), counts->merges, learned.value / truth.value, error / truth.value);
      CHECK(std::abs(learned.value - truth.value) < quantile * error + bias * truth.value);
      CHECK(quantile * error < 0.03 * truth.value);  // so that 3 % shows
    }
  }
}

TEST_CASE("A far sun over a small floor: light trees hit it as much more often as the geometry says") {
  // The sun of radius R at a distance d emits 4π²R²L. The floor of area A receives A cos θ π L
  // (R/d)²: a share of A cos θ / (4π d²) of all light trees, exact as long as the sun is far away.
  constexpr double distance = 3000, radius = 300, area = 4;
  Builder builder;
  const auto grey = builder.add_material(gmis::scene::make_diffuse({0.6, 0.6, 0.6}));
  const auto black = builder.add_material(gmis::scene::make_diffuse({0, 0, 0}));
  add_quad(builder, grey, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});
  builder.add_sphere(to_sun * distance, radius, black, gmis::scene::AreaEmission{{9, 9, 9}, false});
  builder.set_camera(gmis::scene::look_at({0, 1.5, -3}, {0, 0, 0}, {0, 1, 0}, 50, {64, 64}));
  const Scene scene = builder.build();
  const double by_power = area * to_sun.y / (4 * gmis::pi<double> * distance * distance);
  CHECK(by_power < 1e-7);  // so that no tree at all would hit it

  constexpr int iterations = 8;
  gmis::SampleCounts counts = gmis::integrators::bpt;
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 3;
  settings.seed = gmis_test::seed(45);
  settings.emission = gmis::Emission::learned;
  gmis::Engine<Scene> engine(scene, settings);
  gmis::SerialExecutor executor;
  for (int i = 0; i < iterations; ++i) engine.iterate(executor);
  const double trees = static_cast<double>(engine.counters().light_subpaths);
  const double hits = static_cast<double>(engine.counters().photons_stored) / trees;  // the floor is all they can hit

  // The share of the guided starts that hit the floor is that by power times the mean ratio of the
  // densities over the lines between the floor and the sun. All those lines carry about the same
  // light.
  const Guide& guide = *engine.emission_guide();
  const auto& sun = scene.lights()[0];
  gmis::Philox source(gmis_test::seed(46));
  constexpr int count = 200'000;
  double mean = 0, squares = 0;
  for (int i = 0; i < count; ++i) {
    const float u = gmis::uniform<float>(source), v = gmis::uniform<float>(source);
    const V at(2.0 * static_cast<double>(u) - 1, 0, 2.0 * static_cast<double>(v) - 1);
    // The scene's own space has the camera at 0.
    gmis::SurfacePoint<float> point{
        gmis::Vec3<float>(at - scene.statistics().world_origin), {0, 1, 0}, {0, 1, 0}, 0.0F};
    const float a = gmis::uniform<float>(source), b = gmis::uniform<float>(source);
    const auto sample = sun.sample_next_event(point, {a, b});
    REQUIRE(sample.has_value());
    const double ratio = static_cast<double>(
        guide.ratio(sun, 1.0F, sample->density.first, sample->origin, -sample->to_light, point.position));
    const double carried = static_cast<double>(sample->to_light.y) / to_sun.y;
    mean += ratio * carried * by_power / count;
    squares += gmis::square(ratio * carried * by_power) / count;
  }
  // Floats: a direction over 3000 units is off by 2e-4 units at the floor, of 2 across, and 1 % of
  // the sun's edge is dark.
  const double error = std::hypot(std::sqrt(hits * (1 - hits) / trees), std::sqrt((squares - mean * mean) / count));
  CAPTURE(hits, mean, hits / by_power, error);
  CHECK(std::abs(hits - mean) < gmis::normal_quantile(1 - 1e-4) * error + 0.01 * mean);
  // The rings that the floor fills, the half of the sun that faces it, and a quarter as by power:
  // more than 0.4 of all.
  CHECK(hits > 0.4);
  CHECK(hits / by_power > 4e6);
}
