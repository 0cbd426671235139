#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/scene/scene_builder.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"

// Lights chosen by power and for their receiver (`LightSelection`).
//
//   light_choice                                  variance of the picture at equal samples
//   light_choice loop LIGHTS SELECTION COUNT      COUNT next events in a town of LIGHTS lamps;
//                                                 benches/light_choice.py counts their instructions

namespace {

using namespace gmis::scene;
using Scene = BvhScene<>;

/// A square town with lamps in rows on a ground of one size for each; every seventh lamp is bright.
Scene town(int lights, LightSelection selection) {
  SceneBuilder<> builder;
  const auto stone = builder.add_material(make_diffuse({0.6, 0.55, 0.5}));
  const auto black = builder.add_material(make_diffuse({0, 0, 0}));
  const int side = std::max(1, static_cast<int>(std::ceil(std::sqrt(lights))));
  const double length = 2.0 * side;
  const std::vector<std::array<int, 3>> quad{{0, 2, 1}, {0, 3, 2}};
  const std::vector<glm::dvec3> ground{{0, 0, 0}, {length, 0, 0}, {length, 0, length}, {0, 0, length}};
  builder.add_mesh({ground, quad}, stone);
  gmis::Philox source(9);
  for (int i = 0; i < lights; ++i) {
    const double x = 2.0 * (i % side) + 0.4 + 1.2 * gmis::uniform<double>(source);
    const double z = 2.0 * (i / side) + 0.4 + 1.2 * gmis::uniform<double>(source);
    const double y = 0.6 + gmis::uniform<double>(source);
    const double power = i % 7 == 3 ? 20.0 : 4.0;
    // A lamp that shines down, and a low wall beside it.
    const std::vector<glm::dvec3> lamp{{x, y, z}, {x + 0.2, y, z}, {x + 0.2, y, z + 0.2}, {x, y, z + 0.2}};
    builder.add_mesh({lamp, std::vector<std::array<int, 3>>{{0, 1, 2}}}, black, AreaEmission{glm::dvec3(power)});
    const std::vector<glm::dvec3> wall{{x - 0.4, 0, z}, {x - 0.4, 0, z + 1}, {x - 0.4, 0.5, z + 1}, {x - 0.4, 0.5, z}};
    builder.add_mesh({wall, quad}, stone);
  }
  const double middle = length / 2;
  builder.set_camera(look_at({middle, 6, middle - 9}, {middle, 0, middle}, {0, 1, 0}, 50, {32, 32}));
  builder.set_light_selection(selection);
  return builder.build();
}

/// Mean over the pixels of the variance of one iteration, over the squared mean of the picture.
template <class Engine>
double relative_variance(const Scene& scene, const gmis::SampleCounts& counts, int iterations) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 4;
  Engine engine(scene, settings);
  gmis::SerialExecutor executor;
  std::vector<double> sums(32 * 32), squares(32 * 32);
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    for (std::size_t p = 0; p < sums.size(); ++p) {
      const auto value = static_cast<double>(gmis::mean_channel(engine.frame()[p]));
      sums[p] += value / iterations;
      squares[p] += value * value / iterations;
    }
  }
  double variance = 0, mean = 0;
  for (std::size_t p = 0; p < sums.size(); ++p) {
    variance += (squares[p] - sums[p] * sums[p]) / static_cast<double>(sums.size());
    mean += sums[p] / static_cast<double>(sums.size());
  }
  return variance / (mean * mean);
}

/// The variance of an iteration with lights chosen by power, over that with lights chosen for their
/// receiver: a line for each town, of lamps, pt, bpt and vcm.
void print_gains() {
  for (const int lights : {1, 10, 100, 1000, 10000}) {
    const Scene by_power = town(lights, LightSelection::by_power);
    const Scene by_receiver = town(lights, LightSelection::by_receiver);
    const auto gain = [&](const auto& measure) { return measure(by_power) / measure(by_receiver); };
    const double pt = gain([](const Scene& scene) {
      return relative_variance<gmis::PathTracer<Scene>>(scene, gmis::integrators::pt, 200);
    });
    const double bpt = gain(
        [](const Scene& scene) { return relative_variance<gmis::Engine<Scene>>(scene, gmis::integrators::bpt, 100); });
    const double vcm = gain(
        [](const Scene& scene) { return relative_variance<gmis::Engine<Scene>>(scene, gmis::integrators::vcm, 100); });
    std::printf("%d %.2f %.2f %.2f\n", lights, pt, bpt, vcm);
  }
}

/// Next events at places on the ground: the choice, a point on the light, the shadow ray. Returns
/// the light that arrives.
[[gnu::noinline]] double next_events(const Scene& scene, double length, int count) {
  gmis::Philox source(5);
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const auto [x, z, u, v] = gmis::uniforms<float, 4>(source);
    const float w = gmis::uniform<float>(source);
    const glm::dvec3 place(static_cast<double>(x) * length, 0.55, static_cast<double>(z) * length);
    const auto hit = scene.intersect({gmis::Vec3<float>(place - scene.statistics().world_origin), {0, -1, 0}});
    if (!hit) continue;
    const auto choice = scene.sample_light(hit->point, u);
    if (choice.light == nullptr) continue;
    const auto sample = choice.light->sample_next_event(hit->point, {v, w});
    if (sample && scene.visible(gmis::segment(hit->point, sample->origin, sample->to_light)))
      sum += static_cast<double>(gmis::mean_channel(sample->weight) / choice.selection_probability);
  }
  return sum / count;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 1) {
    print_gains();
    return 0;
  }
  if (argc != 5 || std::strcmp(argv[1], "loop") != 0) {
    std::fprintf(stderr, "usage: light_choice [loop LIGHTS by_power|by_receiver COUNT]\n");
    return 2;
  }
  const int lights = std::atoi(argv[2]);
  const bool by_receiver = std::strcmp(argv[3], "by_receiver") == 0;
  const Scene scene = town(lights, by_receiver ? LightSelection::by_receiver : LightSelection::by_power);
  std::printf("%.6f\n", next_events(scene, 2.0 * std::ceil(std::sqrt(lights)), std::atoi(argv[4])));
}
