// One engine over an adapter, without gmis::Render: what a program that owns its iterations
// compiles (./run bench compile).

#include <cstdio>
#include <gmis/transport/engine/engine.hpp>

#include "bring_your_own/adapter.hpp"
#include "bring_your_own/world.hpp"

int main() {
  const theirs::World world = theirs::make_world(64, 48);
  const adapter::Scene scene(world);
  const gmis::RenderSettings settings;
  gmis::Engine<adapter::Scene> engine(scene, settings);
  gmis::SerialExecutor executor;
  engine.iterate(executor);
  std::printf("%g\n", static_cast<double>(engine.frame().front().x));
}
