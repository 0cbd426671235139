#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/render/render_request.hpp"
#include "gmis/result/batch_means.hpp"
#include "gmis/result/film.hpp"
#include "gmis/result/merging_bias.hpp"
#include "gmis/result/row_copy.hpp"

namespace gmis {

/// The sums over iterations that a run keeps by pixel, of a picture or of some of its rows.
template <Spectrum S>
struct PixelSums {
  Film<S> film;                          ///< the mean of the picture
  std::vector<Film<S>> halves;           ///< of the odd and of the even iterations, or empty
  std::optional<BatchMeans<S>> batches;  ///< for the error
  MergingChange merging;                 ///< what the disk changes

  /// Sums without iterations that a run with this request keeps, of `size` pixels.
  PixelSums(const RenderRequest& request, glm::ivec2 size)
      : film(size), halves(request.halves ? 2 : 0, Film<S>(size)), merging(size) {
    if (request.intervals || request.budget.relative_error)
      batches.emplace(size, request.settings.sampler == Sampler::sobol ? sobol_replications : 0);
  }

  /// Adds an iteration. `number`: from 1; `gain`: as in `MergingChange::add_iteration`.
  void add_iteration(std::uint32_t number, std::span<const S> frame, std::span<const float> merging_change,
                     double gain) {
    film.add_iteration(frame);
    merging.add_iteration(merging_change, gain);
    if (batches) batches->add_iteration(frame);
    // With replications, even and odd iterations belong to different ones, too.
    if (!halves.empty()) halves[(number - 1) % 2].add_iteration(frame);
  }

  /// Takes rows over from the same iterations of a picture of the same width.
  void copy_rows(const PixelSums& other, const RowCopy& rows) {
    film.copy_rows(other.film, rows);
    for (std::size_t i = 0; i < halves.size(); ++i) halves[i].copy_rows(other.halves[i], rows);
    if (batches && other.batches) batches->copy_rows(*other.batches, rows);
    merging.copy_rows(other.merging, rows);
  }

  /// Swaps the pixels with `other`; batches only where both have them.
  void swap_with(PixelSums& other) noexcept {
    std::swap(film, other.film);
    std::swap(halves, other.halves);
    std::swap(merging, other.merging);
    if (batches && other.batches) std::swap(*batches, *other.batches);
  }

  /// The state for another process (`core/state_archive.hpp`) but for the batches.
  template <class Archive>
  void exchange_pictures(Archive& archive) {
    archive(film, merging);
    for (Film<S>& half : halves) archive(half);
  }
  /// The state for another process.
  template <class Archive>
  void exchange_state(Archive& archive) {
    exchange_pictures(archive);
    if (batches) archive(*batches);
  }
};

}  // namespace gmis
