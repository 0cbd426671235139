#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <vector>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/scene/bvh_scene.hpp"
#include "gmis/transport/state/first_hit.hpp"

/// \file
/// A path tracer as one writes it over the built-in scene without this library's transport: next
/// event and emitter hits, combined by the balance heuristic, roulette from the second non-specular
/// vertex on. It draws the same random numbers in the same order, so that it makes the same picture
/// but for rounding; it passes a surface that the camera stands in. Nothing is counted and nothing
/// is checked, but that a pixel is finite.

namespace hand {

using gmis::Vec2;
using gmis::Vec3;
using Scene = gmis::scene::BvhScene<float>;

struct PathTracer {
  const Scene& scene;
  std::uint64_t seed;
  int max_depth;

  [[nodiscard]] std::vector<Vec3<float>> iterate(std::uint32_t iteration) const {
    const glm::ivec2 resolution = scene.camera().resolution();
    std::vector<Vec3<float>> frame(static_cast<std::size_t>(resolution.x) * static_cast<std::size_t>(resolution.y));
    for (int y = 0; y < resolution.y; ++y)
      for (int x = 0; x < resolution.x; ++x) {
        const auto pixel = static_cast<std::uint32_t>(y * resolution.x + x);
        const Vec3<float> value = trace({x, y}, gmis::SampleNumbers(seed, iteration, pixel, 1));
        if (gmis::is_finite(value)) frame[pixel] = value;
      }
    return frame;
  }

  [[nodiscard]] Vec3<float> trace(glm::ivec2 pixel, gmis::SampleNumbers source) const {
    using gmis::uniforms;
    Vec3<float> sum(0);
    source.at_vertex(0);
    const auto [u_pixel, v_pixel, u_lens, v_lens] = uniforms<float, 4>(source);
    const Vec2<float> uv_pixel{u_pixel, v_pixel}, uv_lens{u_lens, v_lens};
    const auto start = scene.camera().sample_ray(pixel, uv_pixel, uv_lens);
    if (!start) return sum;
    gmis::SurfacePoint<float> from = start->origin;
    Vec3<float> direction = start->direction;
    Vec3<float> throughput = start->weight;
    bool is_last_delta = true;  // or the camera
    bool is_specular = true;    // all events so far
    float last_density = 0;     // per steradian

    for (int depth = 1; depth <= max_depth; ++depth) {
      auto hit = scene.intersect(gmis::leave(from, direction));
      if (depth == 1) gmis::pass_start(scene, from, direction, hit);
      if (!hit) {
        for (const auto* light : scene.infinite_lights()) {
          if (light->is_delta()) continue;
          const auto emitted = light->emitted({}, -direction);
          if (gmis::is_black(emitted.radiance)) continue;
          float weight = 1;
          if (!is_last_delta)
            weight = last_density / (last_density + scene.selection_probability(*light) *
                                                        light->next_event_density({}, -direction, from));
          sum += throughput * emitted.radiance * weight;
        }
        break;
      }
      const auto& point = hit->point;
      const Vec3<float> to_prev = -direction;
      if (hit->light != nullptr) {
        const auto emitted = hit->light->emitted(point, to_prev);
        if (!gmis::is_black(emitted.radiance)) {
          float weight = 1;
          if (!is_last_delta) {
            const Vec3<float> offset = point.position - from.position;
            const float by_light = scene.selection_probability(*hit->light) *
                                   hit->light->next_event_density(point, to_prev, from) * glm::dot(offset, offset) /
                                   std::abs(glm::dot(point.geometric_normal, to_prev));
            weight = last_density / (last_density + by_light);
          }
          sum += throughput * emitted.radiance * weight;
        }
      }
      if (depth == max_depth) break;

      const auto& bsdf = hit->bsdf;
      const float albedo = gmis::max_channel(bsdf.albedo());
      if (albedo <= 0.0F) break;
      const float survival = is_specular ? 1.0F : 0.9F * albedo;
      const std::uint32_t number = 2 * static_cast<std::uint32_t>(depth);
      if (!bsdf.is_purely_delta()) {
        source.at_vertex(number);
        sum += throughput * next_event(point, bsdf, to_prev, survival, source);
      }

      source.at_vertex(number + 1);
      const auto [u_survival, u, u_next, v_next] = uniforms<float, 4>(source);
      const Vec2<float> uv{u_next, v_next};
      if (u_survival >= survival) break;
      const auto next = bsdf.sample(to_prev, u, uv, gmis::TransportMode::radiance);
      if (!next) break;
      throughput *= next->weight / survival;
      is_last_delta = next->is_delta;
      is_specular = is_specular && is_last_delta;
      last_density = survival * next->pdf.forward.value;
      from = point;
      direction = next->to_next;
    }
    return sum;
  }

  [[nodiscard]] Vec3<float> next_event(const gmis::SurfacePoint<float>& point, const Scene::Bsdf& bsdf,
                                       const Vec3<float>& to_prev, float survival, gmis::SampleNumbers& source) const {
    const auto [u_light, u, v] = gmis::uniforms<float, 3>(source);
    const auto choice = scene.sample_light(u_light);
    const Vec2<float> uv{u, v};
    if (choice.light == nullptr) return Vec3<float>(0);
    const auto sample = choice.light->sample_next_event(point, uv);
    if (!sample) return Vec3<float>(0);
    const auto f = bsdf.evaluate(to_prev, sample->to_light, gmis::TransportMode::radiance);
    if (gmis::is_black(f.value)) return Vec3<float>(0);
    const bool is_infinite = choice.light->is_infinite();
    if (!scene.visible(is_infinite ? gmis::leave(point, sample->to_light)
                                   : gmis::segment(point, sample->origin, sample->to_light)))
      return Vec3<float>(0);
    const float cosine = std::abs(glm::dot(point.shading_normal, sample->to_light));
    float weight = 1;
    if (!choice.light->is_delta()) {
      float by_surface = survival * f.pdf.forward.value;
      if (!is_infinite) {
        const Vec3<float> offset = sample->origin.position - point.position;
        by_surface *= std::abs(glm::dot(sample->origin.geometric_normal, sample->to_light)) / glm::dot(offset, offset);
      }
      const float by_light = choice.selection_probability * sample->next_event_density;
      weight = by_light / (by_light + by_surface);
    }
    return f.value * sample->weight * (cosine * weight / choice.selection_probability);
  }
};

}  // namespace hand
