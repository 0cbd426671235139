#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/transport/state/first_hit.hpp"
#include "gmis/transport/state/scatter.hpp"
#include "guided_directions/guided_scene.hpp"

namespace gmis {

/// How a guide of directions is learned.
struct GuideTraining {
  std::uint64_t seed = 0;  ///< selects the random numbers
  int max_depth = 16;      ///< greatest number of edges of a subpath
  int rounds = 2;          ///< each has twice the subpaths of the one before, and is guided by what is learned so far
  std::size_t first_paths = 8192;  ///< light and camera subpaths each in round 1, rounded up to a multiple of 256
};

namespace detail {

/// Follows a subpath from its first ray, without any technique, and calls
/// `found(hit, to_prev, throughput, depth)` at each vertex that is not purely delta.
template <Scene Sc, UniformSource Source, class Found>
void follow_subpath(const Sc& scene, TransportMode mode, SurfacePoint<ScalarOf<typename Sc::Spectrum>> from,
                    Vec3<ScalarOf<typename Sc::Spectrum>> direction, ScalarOf<typename Sc::Spectrum> throughput,
                    int max_depth, Source& source, Found&& found) {
  using T = ScalarOf<typename Sc::Spectrum>;
  bool always_goes_on = mode == TransportMode::radiance;  // up to the first non-specular vertex and from there
  for (int depth = 1; depth < max_depth; ++depth) {
    const auto hit = depth == 1 ? first_hit(scene, from, direction) : scene.intersect(leave(from, direction));
    if (!hit) return;
    if (!hit->bsdf.is_purely_delta()) found(*hit, -direction, throughput, depth);
    const T albedo = survival_probability(hit->bsdf);
    if (albedo == T(0)) return;
    const T survival = always_goes_on ? T(1) : mode == TransportMode::radiance ? camera_survival(albedo) : albedo;
    source.at_vertex(static_cast<std::uint32_t>(depth));
    const Vec3<T> to_prev = -direction;
    const auto next = scatter<false>(
        ScatteringVertex<typename Sc::Bsdf>{hit->bsdf, hit->point, to_prev, mode, survival, {T(1), T(1)}, {T(1), T(1)}},
        source);
    if (!next) return;
    throughput *= mean_channel(next->weight);
    always_goes_on = always_goes_on && next->is_delta;
    from = hit->point;
    direction = next->to_next;
  }
}

}  // namespace detail

/// Learns where light and importance come from over the surfaces of a scene, from light subpaths
/// and camera subpaths of its own, which add nothing to a picture: the guide depends on no sample
/// that it guides. Light straight from a lamp and importance straight from the camera are left out:
/// next events and splats carry them. Same bits for any number of threads.
template <Scene Sc, Executor E>
[[nodiscard]] DirectionGuide<ScalarOf<typename Sc::Spectrum>> learn_directions(const Sc& scene,
                                                                               const GuideTraining& training,
                                                                               E& executor) {
  using T = ScalarOf<typename Sc::Spectrum>;
  using Guide = DirectionGuide<T>;
  constexpr std::size_t part_size = 256;
  constexpr std::uint32_t light_stream = 7, camera_stream = 8;  // the others: `Engine::Stream`
  const glm::ivec2 size = scene.camera().resolution();
  const auto width = static_cast<std::uint64_t>(size.x);
  const std::uint64_t pixels = width * static_cast<std::uint64_t>(size.y);
  Guide guide;
  std::vector<Incidence<T>> all;
  for (int round = 0; round < training.rounds; ++round) {
    const GuidedScene<Sc> guided(scene, guide);
    const std::size_t part_count = ((training.first_paths << round) + part_size - 1) / part_size;
    const std::size_t paths = part_count * part_size;
    std::vector<std::vector<Incidence<T>>> parts(2 * part_count);
    executor.parallel_for(parts.size(), [&](std::size_t part) {
      const bool is_light = part < part_count;
      const TransportMode learned = is_light ? TransportMode::radiance : TransportMode::importance;
      const auto found = [&](const auto& hit, const Vec3<T>& to_prev, T throughput, int depth) {
        if (depth >= 2 && Guide::is_guidable(hit.bsdf) && throughput > T(0) && std::isfinite(throughput))
          parts[part].push_back({hit.point.position, hit.point.shading_normal, to_prev, throughput, learned});
      };
      const std::size_t first = (part % part_count) * part_size;
      for (std::size_t i = first; i < first + part_size; ++i) {
        Philox source(training.seed, static_cast<std::uint32_t>(round), static_cast<std::uint32_t>(i),
                      is_light ? light_stream : camera_stream);
        source.at_vertex(0);
        const auto [u, v, u_second, v_second] = uniforms<T, 4>(source);
        if (is_light) {
          const auto choice = scene.sample_light(uniform<T>(source));
          if (choice.light == nullptr) continue;
          const auto start = choice.light->sample_emission(Vec2<T>{u, v}, Vec2<T>{u_second, v_second});
          if (!start) continue;
          detail::follow_subpath(guided, TransportMode::importance, start->origin, start->direction,
                                 mean_channel(start->weight) / choice.selection_probability, training.max_depth, source,
                                 found);
        } else {
          const std::uint64_t pixel = i * pixels / paths;
          const auto start =
              scene.camera().sample_ray({static_cast<int>(pixel % width), static_cast<int>(pixel / width)},
                                        Vec2<T>{u, v}, Vec2<T>{u_second, v_second});
          if (!start) continue;
          detail::follow_subpath(guided, TransportMode::radiance, start->origin, start->direction,
                                 mean_channel(start->weight), training.max_depth, source, found);
        }
      }
    });
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    guide = Guide(all);
  }
  return guide;
}

}  // namespace gmis
