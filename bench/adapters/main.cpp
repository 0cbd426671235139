#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "gmis/core/concepts.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"

#if defined(GMIS_OVER_BRING_YOUR_OWN)
#include "bring_your_own/adapter.hpp"
#include "bring_your_own/world.hpp"
#elif defined(GMIS_OVER_MANY_LIGHTS)
#include "many_lights/adapter.hpp"
#elif defined(GMIS_OVER_EMBREE)
#include "embree/room.hpp"
#else
#include "gmis/scene/scene_builder.hpp"
#endif

// The engine over one adapter, on one thread, for its instructions to be counted
// (bench/benches/adapters.py).
// Usage: PROGRAM pt|vcm ITERATIONS

namespace {
#if !defined(GMIS_OVER_BRING_YOUR_OWN) && !defined(GMIS_OVER_MANY_LIGHTS) && !defined(GMIS_OVER_EMBREE)
// The scene of examples/render_a_scene.cpp.
auto built_in_scene() {
  gmis::scene::SceneBuilder<> builder;
  const auto white = builder.add_material(gmis::scene::make_diffuse({0.7, 0.7, 0.7}));
  const auto glass = builder.add_material(gmis::scene::make_dielectric(1.5));
  const auto black = builder.add_material(gmis::scene::make_diffuse({0, 0, 0}));
  builder.add_sphere({0, -101, 0}, 100, white);
  builder.add_sphere({0, 0, 0}, 1, glass);
  builder.add_sphere({2, 4, -1}, 0.7, black, gmis::scene::AreaEmission{{20, 20, 20}});
  builder.set_camera(gmis::scene::look_at({0, 2, -6}, {0, 0, 0}, {0, 1, 0}, 40, {48, 36}));
  return builder.build();
}
#endif

template <class EngineType, class Scene>
double mean(const Scene& scene, const gmis::SampleCounts& counts, int iterations) {
  gmis::SerialExecutor serial;
  gmis::RenderSettings settings;
  settings.counts = counts;
  EngineType engine(scene, settings);
  double sum = 0;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(serial);
    for (const auto& value : engine.frame()) sum += static_cast<double>(gmis::mean_channel(value));
  }
  return sum;
}
}  // namespace

int main(int argc, char* argv[]) {
  if (argc != 3) return EXIT_FAILURE;
#if defined(GMIS_OVER_BRING_YOUR_OWN)
  const theirs::World world = theirs::make_world(48, 36);
  const adapter::Scene scene(world);
#elif defined(GMIS_OVER_MANY_LIGHTS)
  const town::Town town = town::make_town(48, 64, 48);
  const many_lights::Scene<true> scene(town);
#elif defined(GMIS_OVER_EMBREE)
  const embree::Scene scene(room::build(48, 36), room::triangles());
#else
  const auto scene = built_in_scene();
#endif
  using Scene = std::remove_const_t<decltype(scene)>;
  const int iterations = std::atoi(argv[2]);
  const double result = std::string_view(argv[1]) == "pt"
                            ? mean<gmis::PathTracer<Scene>>(scene, gmis::integrators::pt, iterations)
                            : mean<gmis::Engine<Scene>>(scene, gmis::integrators::vcm, iterations);
  std::printf("%g\n", result);
  return result > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
