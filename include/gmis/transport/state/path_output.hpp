#pragma once

#include <concepts>
#include <cstdint>
#include <optional>

#include "gmis/core/spectrum.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/transport/state/rejection.hpp"
#include "gmis/transport/state/technique.hpp"

/// \file
/// The interface through which walks and techniques hand over their contributions.

namespace gmis {

/// One contribution to one pixel, in the unit of radiance. `value` excludes the MIS weight
/// `weight`; `pixel` is the index of the pixel in the frame.
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
/// - `add(id, value, weight)`: adds a contribution to the pixel whose camera subpath is being
///   traced.
/// - `add_splat(pixel, id, value, weight)`: adds a contribution to any pixel.
/// - `reject(cause, technique)`: reports that a sample or contribution of the current path is left
///   out. `technique` is empty when the subpath itself ends.
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
/// - `begin_pixel(pixel)`, `take_pixel()`: begin and end a camera subpath; `take_pixel` returns the
///   value of the pixel.
/// - `begin_trees(first)`: begins light trees; the first one has the number `first`.
/// - `splats()`: the weighted contributions of light trees to pixels.
/// - `rejections()`, `counters()`: of the chunk since `clear()`.
/// - `merging_change()`: of the pixel, the merged light minus what a disk of half the radius would
///   have merged; `merged_light()`: merged since `clear()`, summed over the pixels. Both are means
///   over channels.
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
  { finished.merging_change() } -> std::convertible_to<float>;
  { finished.merged_light() } -> std::convertible_to<double>;
};

/// Base of a `ChunkOutput`, and of every output that the walks write to: hears of each step and
/// does nothing. An output hides the functions that it needs; calls of the others cost nothing.
struct PathObserver {
  /// The subpath starts at `origin`; `weight` is the throughput that leaves there.
  static constexpr void on_start(const auto& /*origin*/, const auto& /*weight*/) noexcept {}
  /// `step` reached `vertex` at `point`, with `density` per area, which may be unusable.
  static constexpr void on_vertex(const auto& /*step*/, auto /*density*/, const auto& /*vertex*/,
                                  const auto& /*point*/) noexcept {}
  /// `step` left the scene.
  static constexpr void on_escape(const auto& /*step*/, const auto& /*throughput*/, int /*depth*/) noexcept {}
  /// The techniques of a light vertex follow.
  static constexpr void on_use(const auto& /*vertex*/) noexcept {}
  /// The contribution that follows ends at this stored light vertex.
  static constexpr void on_light_vertex(const auto& /*vertex*/) noexcept {}
  /// The contribution that follows ends at this point of a light.
  static constexpr void on_light_point(const auto& /*origin*/) noexcept {}
  /// The merge that follows joins two vertices at this squared distance, divided by the squared
  /// radius.
  static constexpr void on_merge(auto /*relative_distance_squared*/) noexcept {}
  /// The techniques of a camera vertex are done.
  static constexpr void end_vertex() noexcept {}
  /// False for a pixel that is left out: neither a camera subpath nor a splat is made for it.
  static constexpr bool takes(std::uint32_t /*pixel*/) noexcept { return true; }
};

}  // namespace gmis
