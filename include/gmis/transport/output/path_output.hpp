#pragma once

#include <concepts>
#include <cstdint>
#include <optional>

#include "gmis/core/spectrum.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/transport/output/rejection.hpp"
#include "gmis/transport/techniques/technique.hpp"

/// \file
/// The interface through which walks and techniques hand over their contributions.

namespace gmis {

/// One contribution to one pixel, in the unit of radiance. `value` excludes the MIS weight `weight`; `pixel` is the
/// index of the pixel in the frame.
template <Spectrum S>
struct Contribution {
  std::uint32_t pixel;  ///< number of the pixel, by rows from the top
  TechniqueId id;       ///< how the path was made
  S value;              ///< contribution without the weight
  /// MIS weight of the technique.
  ScalarOf<S> weight;
};

/// Receives contributions: values of type `S`, each with an MIS weight of type `Weight`.
///
/// - `counters()`: the counters of the work, by reference; walks and techniques increment them.
/// - `add(id, value, weight)`: adds a contribution to the pixel whose camera subpath is being traced.
/// - `add_splat(pixel, id, value, weight)`: adds a contribution to any pixel.
/// - `reject(cause, technique)`: reports that a sample or contribution of the current path is left out. `technique` is
///   empty when the subpath itself ends.
template <class O, class S, class Weight>
concept PathOutput = Spectrum<S> && requires(O& output, std::uint32_t pixel, TechniqueId id, const S& value,
                                             const Weight& weight, const std::optional<TechniqueId>& technique) {
  { output.counters() } -> std::same_as<Counters&>;
  output.add(id, value, weight);
  output.add_splat(pixel, id, value, weight);
  output.reject(RejectionCause::zero_pdf, technique);
};

/// A `PathOutput` that an engine owns, one for each chunk of paths.
///
/// - `clear()`: begins an iteration.
/// - `begin_pixel(pixel)`, `take_pixel()`: begin and end a camera subpath; `take_pixel` returns the value of the pixel.
/// - `begin_trees(first)`: begins light trees; the first one has the number `first`.
/// - `splats()`: the weighted contributions of light trees to pixels.
/// - `rejections()`, `counters()`: of the chunk since `clear()`.
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

/// True for an output that is also told every vertex (`ReplayOutput`). The calls are compiled for such outputs only.
template <class Output>
inline constexpr bool observes_paths = requires {
  typename Output::ObservesPaths;
};

/// True for an output that is told, before a merge is added, the squared distance of the two merged vertices divided by
/// the squared radius, and knows at the end of a camera subpath what that changes, and at the end of an iteration
/// how much was merged (`FilmOutput`). The calls are compiled for such outputs only.
template <class Output>
inline constexpr bool observes_merges = requires(Output& output, const Output& finished) {
  output.on_merge(1.0F);
  { finished.merging_change() } -> std::convertible_to<float>;
  { finished.merged_light() } -> std::convertible_to<double>;
};

/// True for an output that is told when a child of a split camera vertex begins and when the techniques at a vertex are
/// done (`PilotOutput`). The calls are compiled for such outputs only.
template <class Output>
inline constexpr bool observes_children = requires(Output& output) {
  output.begin_child(std::int16_t{});
  output.end_children();
  output.end_vertex();
};

/// True for an output that leaves out some pixels (`PilotOutput`): neither a camera subpath nor a splat is made for them.
template <class Output>
inline constexpr bool selects_pixels = requires(const Output& output) {
  { output.takes(std::uint32_t{}) } -> std::same_as<bool>;
};

}  // namespace gmis
