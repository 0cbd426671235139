#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "gmis/core/random.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/transport/counts/count_table.hpp"
#include "gmis/transport/counts/vertex_log.hpp"
#include "gmis/transport/techniques/connect.hpp"
#include "gmis/transport/techniques/merge.hpp"
#include "gmis/transport/techniques/next_event.hpp"

/// \file
/// The techniques at a camera vertex, with numbers of samples from a table or with a log of what each technique gives.

namespace gmis {

/// The normal of a vertex on the side that its subpath came from.
template <class Vertex>
[[nodiscard]] constexpr auto facing_normal(const Vertex& vertex) noexcept {
  const auto& normal = vertex.hit.point.geometric_normal;
  return glm::dot(normal, vertex.to_prev) < typename Vertex::T(0) ? -normal : normal;
}

/// Numbers of samples at one vertex, by `VertexWork`.
template <std::floating_point T>
struct DrawnCounts {
  std::array<T, vertex_work_count> expected;  ///< a contribution is divided by it
  std::array<int, vertex_work_count> drawn;   ///< at random, with that mean
};

/// Draws the numbers of samples at a non-specular vertex of the camera subpath of a pixel. Merging has one query or none: a second one
/// would find the same photons; so have connections with all vertices of one light tree. Without `may_branch` there is no more than one
/// child. At most one random number is drawn, for all counts, each a quarter of a turn on: merging is rather done where next events are
/// not.
template <class Context, class Vertex, UniformSource Source>
[[nodiscard]] DrawnCounts<typename Vertex::T> draw_counts(const Context& context,
                                                          const CountTable<typename Vertex::T>& table,
                                                          const Vertex& vertex, std::size_t pixel, bool may_branch,
                                                          Source& source) {
  using T = typename Vertex::T;
  const auto& entry = table.at(vertex.hit.point.position, facing_normal(vertex));
  const T importance = mean_channel(vertex.throughput) * table.pixel_scale(pixel);
  const std::array most{CountTable<T>::most, context.counts.draws_connections() ? CountTable<T>::most : T(1), T(1),
                        may_branch ? CountTable<T>::most : T(1)};
  DrawnCounts<T> counts;
  bool is_random = false;
  for (std::size_t k = 0; k < vertex_work_count; ++k) {
    const T expected = std::min(table.count(entry, static_cast<VertexWork>(k), importance), most[k]);
    counts.expected[k] = expected;
    counts.drawn[k] = static_cast<int>(expected);
    is_random |= static_cast<T>(counts.drawn[k]) != expected;
  }
  if (is_random) {
    T u = uniform<T>(source);
    for (std::size_t k = 0; k < vertex_work_count; ++k) {
      if (u < counts.expected[k] - static_cast<T>(counts.drawn[k])) ++counts.drawn[k];
      u += u < T(0.75) ? T(0.25) : T(-0.75);
    }
  }
  return counts;
}

/// Applies the techniques at a non-specular vertex, each with its number of samples.
template <class Context, class Vertex, UniformSource Source, class Output>
void counted_work(const Context& context, const DrawnCounts<typename Vertex::T>& counts, Vertex& vertex,
                  std::size_t pixel, Source& source, Output& output) {
  using T = typename Vertex::T;
  const auto throughput = vertex.throughput;
  const auto samples = [&](VertexWork work) {
    const auto k = static_cast<std::size_t>(work);
    const T expected = counts.expected[k];
    vertex.throughput = expected == T(1) ? throughput : throughput * (T(1) / expected);
    return counts.drawn[k];
  };
  if (context.has.next_event)
    for (int left = samples(VertexWork::next_event); left > 0; --left)
      NextEvent::at_camera_vertex(context, vertex, source, output);
  if constexpr (Context::has_light_side) {
    if (context.has.connect)
      for (int left = samples(VertexWork::connect); left > 0; --left)
        Connect::at_camera_vertex(context, vertex, pixel, source, output);
    if (context.has.merge && samples(VertexWork::merge) > 0) Merge::at_camera_vertex(context, vertex, output);
  }
  vertex.throughput = throughput;
}

/// Applies the techniques at a non-specular vertex once each, and logs what they give and cost.
template <class Context, class Vertex, UniformSource Source, class Output>
[[gnu::noinline]] void logged_work(const Context& context, VertexLog<typename Vertex::T>& log, const Vertex& vertex,
                                   std::size_t pixel, Source& source, Output& output) {
  using T = typename Vertex::T;
  const auto value = [&] { return mean_channel(output.take_pixel()); };
  const T throughput = mean_channel(vertex.throughput);
  const bool is_logged = throughput > T(0);
  const auto end = [&](VertexWork work) {
    if (is_logged) log.end(work, value(), output.counters());
  };
  if (is_logged)
    log.begin_vertex(vertex.hit.point.position, facing_normal(vertex), pixel, throughput, value(), output.counters());
  if (context.has.next_event) NextEvent::at_camera_vertex(context, vertex, source, output);
  end(VertexWork::next_event);
  if constexpr (Context::has_light_side) {
    if (context.has.connect) Connect::at_camera_vertex(context, vertex, pixel, source, output);
    end(VertexWork::connect);
    if (context.has.merge) Merge::at_camera_vertex(context, vertex, output);
    end(VertexWork::merge);
  }
  if (is_logged) log.end_vertex();
}

}  // namespace gmis
