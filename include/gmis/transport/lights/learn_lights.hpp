#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gmis/core/light_choice.hpp"
#include "gmis/core/random.hpp"
#include "gmis/transport/guiding/learn_directions.hpp"
#include "gmis/transport/lights/light_table_scene.hpp"

namespace gmis {

/// How a table of lights is learned.
struct LightTraining {
  std::uint64_t seed = 0;     ///< selects the random numbers
  int max_depth = 16;         ///< greatest number of edges of a path
  int rounds = 2;             ///< each has twice the subpaths of the one before, and chooses lights as learned so far
  std::size_t paths = 16384;  ///< camera subpaths of the first round
};

/// Learns which lights reach which part of the surfaces, visibility included, from next events at the vertices of camera subpaths
/// of its own, which add nothing to a picture: the table depends on no sample that it serves. The same bits for any number of threads.
template <Scene Sc, Executor E>
[[nodiscard]] LightTable<ScalarOf<typename Sc::Spectrum>, typename Sc::Light> learn_lights(
    const Sc& scene, const LightTraining& training, E& executor) {
  using T = ScalarOf<typename Sc::Spectrum>;
  using Table = LightTable<T, typename Sc::Light>;
  constexpr std::size_t part_size = 256;
  constexpr std::uint32_t camera_stream = 9, light_stream = 10;  // the others: `Engine::Stream`
  const glm::ivec2 size = scene.camera().resolution();
  const auto width = static_cast<std::uint64_t>(size.x);
  const std::uint64_t pixels = width * static_cast<std::uint64_t>(size.y);
  Table table;
  std::vector<LightArrival<T, typename Sc::Light>> all;
  for (int round = 0; round < training.rounds; ++round) {
    const LightTableScene<Sc> chosen(scene, table);
    const std::size_t part_count = ((training.paths << round) + part_size - 1) / part_size;
    std::vector<std::vector<LightArrival<T, typename Sc::Light>>> parts(part_count);
    executor.parallel_for(part_count, [&](std::size_t part) {
      for (std::size_t i = part * part_size; i < (part + 1) * part_size; ++i) {
        const auto source_of = [&](std::uint32_t stream) {
          return Philox(training.seed, static_cast<std::uint32_t>(round), static_cast<std::uint32_t>(i), stream);
        };
        Philox source = source_of(camera_stream), lights = source_of(light_stream);
        source.at_vertex(0);
        const auto [u, v, u_lens, v_lens] = uniforms<T, 4>(source);
        const std::uint64_t pixel = i * pixels / (part_count * part_size);
        const auto start = scene.camera().sample_ray({static_cast<int>(pixel % width), static_cast<int>(pixel / width)},
                                                     Vec2<T>{u, v}, Vec2<T>{u_lens, v_lens});
        if (!start) continue;
        const auto found = [&](const auto& hit, const Vec3<T>& to_prev, T throughput, int depth) {
          lights.at_vertex(static_cast<std::uint32_t>(depth));
          const auto [u_light, u_x, u_y] = uniforms<T, 3>(lights);
          const auto choice = chosen.sample_light(hit.point, u_light);
          if (choice.light == nullptr) return;
          const auto sample = choice.light->sample_next_event(hit.point, Vec2<T>{u_x, u_y});
          if (!sample) return;
          const T response = mean_channel(hit.bsdf.evaluate(to_prev, sample->to_light, TransportMode::radiance).value);
          const auto value = static_cast<double>(throughput * response * mean_channel(sample->weight) *
                                                 std::abs(glm::dot(hit.point.shading_normal, sample->to_light)));
          const double moment = square(value) / static_cast<double>(choice.selection_probability);
          if (!(moment > 0.0) || !std::isfinite(moment)) return;
          if (scene.visible(choice.light->is_infinite() ? leave(hit.point, sample->to_light)
                                                        : segment(hit.point, sample->origin, sample->to_light)))
            parts[part].push_back({hit.point.position, hit.point.geometric_normal, choice.light, moment});
        };
        detail::follow_subpath(scene, TransportMode::radiance, start->origin, start->direction,
                               mean_channel(start->weight), training.max_depth, source, found);
      }
    });
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    table = Table(all);
  }
  return table;
}

}  // namespace gmis
