#pragma once

#include <concepts>
#include <cstdint>
#include <optional>

#include "gmis/core/spectrum.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/transport/output/rejection.hpp"
#include "gmis/transport/techniques/technique.hpp"

/// \file
/// What the walks and the techniques ask of the place that their contributions go to.

namespace gmis {

/// One estimate of one pixel before it reaches the film: `value` is not yet multiplied by the MIS weight.
template <Spectrum S>
struct Contribution {
  std::uint32_t pixel;
  TechniqueId id;
  S value;
  ScalarOf<S> weight;
};

/// One path reached a weight of type `Weight` for a value of type `S`.
///
/// - `counters()`: what was done, by reference.
/// - `add(id, value, weight)`: a contribution to the pixel whose camera subpath is being traced.
/// - `add_splat(pixel, id, value, weight)`: a contribution to any pixel.
/// - `reject(cause, technique)`: something was left out of the path at hand.
template <class O, class S, class Weight>
concept PathOutput = Spectrum<S> && requires(O& output, std::uint32_t pixel, TechniqueId id, const S& value,
                                             const Weight& weight, const std::optional<TechniqueId>& technique) {
  { output.counters() } -> std::same_as<Counters&>;
  output.add(id, value, weight);
  output.add_splat(pixel, id, value, weight);
  output.reject(RejectionCause::zero_pdf, technique);
};

/// A `PathOutput` that an engine owns, one for each chunk of paths: `clear()` begins an iteration, `begin_pixel(pixel)` a
/// camera subpath, `take_pixel()` ends it and gives the pixel's value; `begin_trees(first)` begins light trees, and
/// `splats()` gives what they add to pixels.
template <class O, class S, class Weight>
concept ChunkOutput = PathOutput<O, S, Weight> && requires(O& output, const O& finished, std::uint32_t number) {
  output.clear();
  output.begin_pixel(number);
  { output.take_pixel() } -> std::convertible_to<S>;
  output.begin_trees(number);
  { finished.splats().begin()->pixel } -> std::convertible_to<std::uint32_t>;
  { finished.splats().begin()->value } -> std::convertible_to<S>;
  { finished.rejections() } -> std::same_as<const RejectionLog&>;
  { finished.counters() } -> std::same_as<const Counters&>;
};

/// An output that also sees every vertex (`ReplayOutput`). For any other, none of that is compiled.
template <class Output>
inline constexpr bool observes_paths = requires {
  typename Output::ObservesPaths;
};

/// An output that is told which child of a camera subpath's first non-specular vertex is being traced, and when the
/// techniques at a vertex are done (`PilotOutput`). For any other, none of that is compiled.
template <class Output>
inline constexpr bool observes_children = requires(Output& output) {
  output.begin_child(std::int16_t{});
  output.end_children();
  output.end_vertex();
};

}  // namespace gmis
