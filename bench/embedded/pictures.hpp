#pragma once

#include <cstdint>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string_view>
#include <vector>

#include "gmis/render/automatic_request.hpp"
#include "gmis/render/render.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"

/// \file
/// Shared by the programs inside other renderers: pictures by the engine over an adapter.

namespace embedded {

using Picture = std::vector<glm::dvec3>;  // rows from above

inline double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

template <class EngineType, class Scene>
Picture by_engine(const Scene& scene, const gmis::RenderSettings& settings, int iterations) {
  EngineType engine(scene, settings);
  gmis::SerialExecutor serial;
  Picture picture;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(serial);
    picture.resize(engine.frame().size());
    for (std::size_t p = 0; p < picture.size(); ++p) picture[p] += glm::dvec3(engine.frame()[p]) / double(iterations);
  }
  return picture;
}

template <class Scene>
Picture by_auto(const Scene& scene, int max_depth, int iterations, std::uint64_t seed) {
  gmis::RenderSettings settings = gmis::settings_with(gmis::Sampler::sobol);
  settings.seed = seed;
  settings.max_depth = max_depth;
  gmis::SerialExecutor serial;
  const auto request = gmis::automatic_request(scene, {.iterations = std::uint32_t(iterations)}, 1, settings);
  const gmis::RenderResult result = gmis::Render(scene, request).run(serial);
  Picture picture;
  for (std::size_t p = 0; p < result.picture.values.size(); p += 3)
    picture.emplace_back(result.picture.values[p], result.picture.values[p + 1], result.picture.values[p + 2]);
  return picture;
}

/// The picture by pt, bpt, vcm or auto; nothing for another name.
template <class Scene>
std::optional<Picture> by_gmis(std::string_view integrator, const Scene& scene, int max_depth, int iterations,
                               std::uint64_t seed) {
  gmis::RenderSettings settings;
  settings.seed = seed;
  settings.max_depth = max_depth;
  if (integrator == "pt") {
    settings.counts = gmis::integrators::pt;
    return by_engine<gmis::PathTracer<Scene>>(scene, settings, iterations);
  }
  if (integrator == "bpt" || integrator == "vcm") {
    settings.counts = integrator == "bpt" ? gmis::integrators::bpt : gmis::integrators::vcm;
    return by_engine<gmis::Engine<Scene>>(scene, settings, iterations);
  }
  if (integrator == "auto") return by_auto(scene, max_depth, iterations, seed);
  return std::nullopt;
}

inline bool write(const char* file, const Picture& picture, int width, int height) {
  std::FILE* out = std::fopen(file, "wb");
  if (!out) return false;
  std::fprintf(out, "PF\n%d %d\n-1\n", width, height);
  for (int y = height - 1; y >= 0; --y)
    for (int x = 0; x < width; ++x) {
      const glm::vec3 pixel(picture[std::size_t(y * width + x)]);
      std::fwrite(&pixel, sizeof pixel, 1, out);
    }
  return std::fclose(out) == 0;
}

}  // namespace embedded
