#include "gmis/transport/emission/learn_lights.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "gmis/scene.hpp"
#include "gmis/transport/allocation/engines_with_pilot.hpp"
#include "gmis/transport/allocation/render_engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/mean_of_iterations.hpp"

// What a choice of lights for the receiver gains, against a sum over all lights; runs that use it
// where it pays; and a pilot whose run has the same knowledge.

namespace {

using Scene = gmis::scene::BvhScene<float>;
using Builder = gmis::scene::SceneBuilder<float>;
using gmis::scene::LightSelection;
using V = gmis::Vec3<double>;

struct PointLight {
  V position;
  double intensity;
};

/// A floor of 2 × 2 seen from above, with point lights.
Scene floor_with(const std::vector<PointLight>& lights, LightSelection selection, int size = 64) {
  Builder builder;
  const auto grey = builder.add_material(gmis::scene::make_diffuse({0.6, 0.6, 0.6}));
  const std::vector<glm::dvec3> corners{{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
  const std::vector<std::array<int, 3>> halves{{0, 1, 2}, {0, 2, 3}};
  builder.add_mesh({corners, halves}, grey);
  builder.add_sphere({0, -30, 0}, 12, grey);  // so that all lights are within the ball around the scene
  builder.add_sphere({0, 30, 0}, 12, grey);
  for (const PointLight& light : lights) builder.add_point_light(light.position, V(light.intensity));
  builder.set_light_selection(selection);
  builder.set_camera(gmis::scene::look_at({0, 4, 0}, {0, 0, 0}, {0, 0, 1}, 20, {size, size}));
  return builder.build();
}

/// A lamp near the floor, and a bright one far away.
const std::vector<PointLight> unequal{{{0.3, 1.5, 0.2}, 1}, {{12, 14, -9}, 60}, {{-2, 3, 1}, 2}};
/// Each part of the floor needs the same lights.
const std::vector<PointLight> alike{{{0.5, 9, 0}, 4}, {{-0.5, 9, 0}, 4}};

}  // namespace

TEST_CASE("The gain leaves out the largest hundredth, narrow lobes and lights without power") {
  using Arrival = gmis::Arrival<float, Scene::Light>;
  const auto arrival = [](float mass, float chosen, float by_power, bool has_narrow_lobe) {
    Arrival one{};
    one.mass = mass;
    one.chosen = chosen;
    one.by_power = by_power;
    one.has_narrow_lobe = has_narrow_lobe;
    return one;
  };
  // 100 with m² = 1 and a ratio of 2, 98 with m² = 4 and a ratio of 1/2; the two largest of 200 say
  // 1000, a narrow lobe and a light that power never chooses the same.
  std::vector<Arrival> arrivals(100, arrival(1, 0.5F, 0.25F, false));
  arrivals.insert(arrivals.end(), 98, arrival(2, 0.25F, 0.5F, false));
  arrivals.insert(arrivals.end(), 2, arrival(3, 1, 0.001F, false));
  arrivals.push_back(arrival(1, 1, 0.001F, true));
  arrivals.push_back(arrival(1, 1, 0, false));
  std::vector<const Arrival*> all;
  for (const Arrival& one : arrivals) all.push_back(&one);
  const double gain = gmis::receiver_gain(std::span<const Arrival* const>(all));
  CHECK(gain == Approx((100 * 2 + 98 * 4 * 0.5) / (100 + 98 * 4.0)));
  CHECK(gmis::receiver_gain(std::span<const Arrival* const>()) == 1);
}

TEST_CASE("Quantiles of values with masses are those of their sums in order") {
  gmis::Philox source(gmis_test::seed(301));
  for (const std::size_t count : {1U, 2U, 3U, 16U, 33U, 1000U, 4097U})
    for (const bool has_ties : {false, true}) {
      // Masses are whole numbers, so that sums are exact in any order.
      std::vector<std::pair<double, double>> values;
      for (std::size_t i = 0; i < count; ++i) {
        const double u = gmis::uniform<double>(source);
        values.emplace_back(has_ties ? std::floor(8 * u) : u, std::floor(4 * gmis::uniform<double>(source)));
      }
      auto sorted = values;
      std::sort(sorted.begin(), sorted.end());
      double total = 0;
      for (const auto& [value, mass] : values) total += mass;
      std::vector<double> wanted, found(19), expected;
      for (std::size_t k = 0; k < found.size(); ++k)
        wanted.push_back(std::floor(total * static_cast<double>(k) / 16.0));
      for (const double least : wanted) {
        double sum = sorted[0].second;
        std::size_t at = 0;
        while (sum < least && at + 1 < count) sum += sorted[++at].second;
        expected.push_back(sorted[at].first);
      }
      gmis::detail::find_quantiles<double>(values, 0.0, wanted, found);
      CAPTURE(count, has_ties);
      CHECK(found == expected);
    }
}

TEST_CASE("The gain of a choice for the receiver is that of a sum over all lights and places") {
  const Scene scene = floor_with(unequal, LightSelection::learned);
  REQUIRE(scene.receiver_choice() == gmis::ReceiverChoice::where_it_pays);
  gmis::SerialExecutor executor;
  const auto learned = gmis::learn_lights(scene, gmis_test::seed(91), 2, executor);  // next events at the floor alone

  // All lights are points: at a place x, light i makes f_i(x), with the probability p(i|x) as
  // m = f/p. The middle of each pixel stands for the places in it.
  struct Atom {
    double weight, chosen, by_power;  ///< share of the samples; m² and m² p(i|x)/p(i)
  };
  std::vector<Atom> atoms;
  const auto& camera = scene.camera();
  const auto size = camera.resolution();
  const V origin = scene.statistics().world_origin;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      const auto ray = camera.sample_ray({x, y}, {0.5F, 0.5F}, {0.5F, 0.5F});
      const V from = V(ray->origin.position) + origin, direction(ray->direction);
      const V at = from - direction * (from.y / direction.y);
      const gmis::SurfacePoint<float> point{gmis::Vec3<float>(at - origin), {0, 1, 0}, {0, 1, 0}, 0.0F};
      for (std::size_t i = 0; i < unequal.size(); ++i) {
        const V offset = unequal[i].position - at;
        const double f = unequal[i].intensity * offset.y / std::pow(glm::dot(offset, offset), 1.5);
        const auto p = static_cast<double>(scene.selection_probability(scene.lights()[i], point));
        const double square = f * f / (p * p);
        atoms.push_back({p / (1.0 * size.x * size.y), square,
                         square * p / static_cast<double>(scene.selection_probability(scene.lights()[i]))});
      }
    }
  std::sort(atoms.begin(), atoms.end(), [](const Atom& a, const Atom& b) { return a.chosen < b.chosen; });
  double kept = 0, moment = 0, by_power = 0;
  for (Atom& atom : atoms) {
    atom.weight = std::clamp(0.99 - kept, 0.0, atom.weight);  // the largest hundredth is left out
    kept += atom.weight;
    moment += atom.weight * atom.chosen;
    by_power += atom.weight * atom.by_power;
  }
  const double gain = by_power / moment;
  double variance = 0;
  for (const Atom& atom : atoms)
    variance += atom.weight * gmis::square((atom.by_power - gain * atom.chosen) / moment) / 1024;
  CAPTURE(learned->receiver_gain, gain, std::sqrt(variance));
  CHECK(gain > 1.5);
  // One false alarm in 10,000 seeds.
  CHECK(std::abs(learned->receiver_gain - gain) < 3.9 * std::sqrt(variance));
  CHECK(3.9 * std::sqrt(variance) < 0.3 * gain);
}

namespace {

template <class Engine>
bool have_same_bits(const Engine& a, const Engine& b) {
  return std::memcmp(a.frame().data(), b.frame().data(), a.frame().size_bytes()) == 0;
}

}  // namespace

TEST_CASE("A run chooses lights for the receiver where that pays, with less noise and the same energy") {
  gmis::RenderSettings settings;
  settings.max_depth = 3;
  settings.seed = gmis_test::seed(92);
  const Scene learned = floor_with(unequal, LightSelection::learned, 16);
  const Scene by_power = floor_with(unequal, LightSelection::by_power, 16);
  const Scene by_receiver = floor_with(unequal, LightSelection::by_receiver, 16);
  gmis::SerialExecutor executor;
  for (const auto* const counts : {&gmis::integrators::pt, &gmis::integrators::bpt}) {
    settings.counts = *counts;
    gmis::Engine<Scene> engine(learned, settings), power(by_power, settings), receiver(by_receiver, settings);
    const gmis_test::Mean a = gmis_test::mean_of_iterations(engine, 300), b = gmis_test::mean_of_iterations(power, 300);
    CHECK(engine.chooses_for_receiver());
    CHECK_FALSE(power.chooses_for_receiver());
    const gmis::LightUse use = engine.light_use(), of_power = power.light_use();
    CHECK(use.chooses_for_receiver);
    CHECK(use.receiver_gain.value() > 1.25);
    CHECK_FALSE(use.emission_gain.has_value());  // emission is not asked for
    CHECK_FALSE(of_power.chooses_for_receiver);
    CHECK_FALSE(of_power.receiver_gain.has_value());
    receiver.continue_after(299);
    receiver.iterate(executor);
    CHECK(have_same_bits(engine, receiver));
    CAPTURE(a.value, b.value, a.standard_error, b.standard_error);
    CHECK(a.standard_error < b.standard_error);
    // One false alarm in 10,000 seeds for the two together.
    CHECK(std::abs(a.value - b.value) < 4.1 * std::hypot(a.standard_error, b.standard_error));
  }
}

TEST_CASE("Where a choice for the receiver gains nothing the bits are those of a choice by power") {
  gmis::RenderSettings settings;
  settings.max_depth = 4;
  settings.counts = gmis::integrators::bpt;
  const Scene learned = floor_with(alike, LightSelection::learned, 16);
  const Scene by_power = floor_with(alike, LightSelection::by_power, 16);
  gmis::Engine<Scene> engine(learned, settings), power(by_power, settings);
  gmis::SerialExecutor executor;
  engine.iterate(executor);
  power.iterate(executor);
  REQUIRE(engine.learned_lights() != nullptr);
  CHECK(power.learned_lights() == nullptr);
  CHECK_FALSE(engine.light_use().chooses_for_receiver);
  CHECK(std::abs(engine.light_use().receiver_gain.value() - 1) < 0.25);
  CHECK(have_same_bits(engine, power));
  // One light leaves no choice, and nothing is learned.
  CHECK(floor_with({alike.front()}, LightSelection::learned).receiver_choice() == gmis::ReceiverChoice::never);
}

TEST_CASE("A run has what its pilot learned, which is what it would have learned without one") {
  const Scene scene = floor_with(unequal, LightSelection::learned, 16);
  gmis::RenderSettings settings;
  settings.counts = gmis::integrators::bpt;
  settings.emission = gmis::Emission::learned;
  settings.max_depth = 3;
  settings.seed = 17;
  gmis::SampleCounts few = settings.counts;
  few.light_paths = 0.25;
  gmis::RenderEngine<gmis::Vec3<float>> run(gmis::engines_with_pilot(scene), settings, {settings.counts, few}, 4);
  gmis::SerialExecutor executor;
  run.iterate(executor);
  REQUIRE(run.choice() != nullptr);
  REQUIRE(run.engine().learned_lights() != nullptr);
  settings.counts = run.engine().counts();
  gmis::Engine<Scene> alone(scene, settings);
  alone.iterate(executor);
  REQUIRE(alone.emission_guide() != nullptr);  // so that the numbers it was learned from matter
  CHECK(have_same_bits(static_cast<const gmis::AnyEngine<gmis::Vec3<float>>&>(alone), run.engine()));
  const gmis::LightUse use = run.engine().light_use();
  CHECK(use.guides_emission);
  CHECK(use.emission_gain.value() >= 1 / gmis::most_relative_moment);
  CHECK(use.emission_gain == alone.light_use().emission_gain);
  // Where no light subpath is traced no emission is guided, whatever is known of it.
  settings.counts = gmis::integrators::pt;
  gmis::Engine<Scene> path_tracer(scene, settings);
  path_tracer.use_lights(run.engine().learned_lights());
  CHECK(path_tracer.light_use().chooses_for_receiver);
  CHECK_FALSE(path_tracer.light_use().guides_emission);
}
