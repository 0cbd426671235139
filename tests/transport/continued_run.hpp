#pragma once

#include <cstdint>
#include <vector>

#include "gmis/core/state_archive.hpp"
#include "gmis/transport/state/settings.hpp"
#include "support/catch.hpp"

namespace gmis_test {

/// The frames after the first iterations of a run that was interrupted there and went on in another
/// engine, one after the other. `check(engine)` sees that engine in the end.
template <class Engine, class Scene, class Executor, class Check>
auto frames_after_interrupt(const Scene& scene, const gmis::RenderSettings& settings, std::uint32_t first,
                            std::uint32_t iterations, Executor&& executor, Check&& check) {
  Engine before(scene, settings), after(scene, settings);
  for (std::uint32_t i = 0; i < first; ++i) before.iterate(executor);
  gmis::StateWriter writer;
  writer(before);
  gmis::StateReader reader(writer.bytes());
  reader(after);
  REQUIRE((reader.is_at_end() && !reader.is_broken()));
  std::vector<typename Engine::S> rest;
  for (std::uint32_t i = first; i < iterations; ++i) {
    after.iterate(executor);
    rest.insert(rest.end(), after.frame().begin(), after.frame().end());
  }
  check(after);
  return rest;
}

}  // namespace gmis_test
