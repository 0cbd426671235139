#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/vec2.hpp>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/executor_ref.hpp"
#include "gmis/core/math.hpp"
#include "gmis/result/batch_means.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/result/rare_samples.hpp"
#include "gmis/result/run_parts.hpp"

/// \file
/// The sums that estimate the error of a picture (`estimate_error`), row by row: processes that
/// hold some rows each can share the work.

namespace gmis::detail {

/// Sums over values of a picture that estimate its error. `most`: number of parts of a run.
template <std::size_t most>
struct ErrorSums {
  double near = 0.0;  ///< squared error relative to the mean of all parts
  double far = 0.0;   ///< squared error relative to that of the others
  /// Products of the deviations of two parts, each relative to the value that it is compared with.
  std::array<double, most*(most - 1) / 2> products{};

  /// The product of the parts b and c, c < b.
  [[nodiscard]] double& product(std::size_t b, std::size_t c) noexcept { return products[b * (b - 1) / 2 + c]; }
  /// The product of the parts b and c, c < b.
  [[nodiscard]] double product(std::size_t b, std::size_t c) const noexcept { return products[b * (b - 1) / 2 + c]; }

  ErrorSums& operator+=(const ErrorSums& other) noexcept {
    near += other.near;
    far += other.far;
    for (std::size_t k = 0; k < products.size(); ++k) products[k] += other.products[k];
    return *this;
  }
};

/// Adds values to such sums, a few side by side.
template <Spectrum S>
class ErrorAdder {
 public:
  using Values = PartsOfValues<S>;
  using Numbers = typename Values::Numbers;
  using Sums = ErrorSums<Values::most>;
  static constexpr std::size_t lanes = Values::lanes;

  /// Sums of no values. `count`: of the parts.
  explicit ErrorAdder(std::size_t count) noexcept {
    for (std::size_t b = 0; b < count; ++b)
      for (std::size_t c = 0; c < b; ++c) products_[b][c].fill(0.0);
  }

  /// Adds the values of the lanes for which `counts` is true; returns the squared relative error of
  /// each. `rare`, by part and lane: 1 / (v² + `relative_error_floor`) for a rare sample, v the
  /// value that it is compared with, else 0; null where none is rare.
  Numbers add(const RunParts<S>& parts, const Values& here, const std::array<bool, lanes>& counts,
              const std::array<Numbers, Values::most>* rare) {
    const std::size_t count = parts.count();
    std::array<Numbers, Values::most> scaled;
    Numbers use, squares{}, errors{}, far{};
    for (std::size_t l = 0; l < lanes; ++l) use[l] = counts[l] ? 1.0 : 0.0;
    for (std::size_t b = 0; b < count; ++b) {
      const double share = parts.share(b), of_others = 1.0 / (1.0 - share);
      const Numbers &deviation = here.deviation(b), &spread = here.variance_by_others(b);
      Numbers inverse;
      for (std::size_t l = 0; l < lanes; ++l) {
        const double others = parts.mean_of_others(b, here.mean()[l], deviation[l]);
        const double variance = parts.variance_by(b, deviation[l]);
        const double plain = 1.0 / (others * others + relative_error_floor);
        squares[l] += variance;
        far[l] += variance * plain;
        // Half the second derivative of 1 / (v² + c) over it: (3v² − c) / (v² + c)².
        const double curvature = std::max(0.0, 3.0 * others * others - relative_error_floor) * plain * plain;
        inverse[l] = plain / (1.0 + curvature * spread[l] * of_others);
      }
      if (rare != nullptr)
        for (std::size_t l = 0; l < lanes; ++l) inverse[l] = (*rare)[b][l] > 0.0 ? (*rare)[b][l] : inverse[l];
      for (std::size_t l = 0; l < lanes; ++l) {
        errors[l] += parts.variance_by(b, deviation[l]) * inverse[l];
        scaled[b][l] = use[l] > 0.0 ? share * deviation[l] * std::sqrt(inverse[l]) : 0.0;
      }
    }
    for (std::size_t l = 0; l < lanes; ++l) {
      far_ += counts[l] ? far[l] : 0.0;
      near_ += counts[l] ? squares[l] / (here.mean()[l] * here.mean()[l] + relative_error_floor) : 0.0;
    }
    for (std::size_t b = 0; b < count; ++b)
      for (std::size_t c = 0; c < b; ++c)
        for (std::size_t first = 0; first < lanes; first += folded)
          for (std::size_t l = 0; l < folded; ++l) products_[b][c][l] += scaled[b][first + l] * scaled[c][first + l];
    return errors;
  }

  /// The sums of the values so far. `count`: of the parts.
  [[nodiscard]] Sums sums(std::size_t count) const noexcept {
    Sums all{.near = near_, .far = far_};
    for (std::size_t b = 0; b < count; ++b)
      for (std::size_t c = 0; c < b; ++c)
        all.product(b, c) = std::accumulate(products_[b][c].begin(), products_[b][c].end(), 0.0);
    return all;
  }

 private:
  static constexpr std::size_t folded = 8;  // sums side by side

  double near_ = 0.0, far_ = 0.0;
  std::array<std::array<std::array<double, folded>, Values::most>, Values::most> products_;  // c < b of the parts
};

/// The part of rows in the estimate of the error of a picture. Values with rare samples are added
/// last (`add_rare`): they need the pixels around them, which may lie in other rows.
template <Spectrum S>
class ErrorOfRows {
 public:
  using Values = PartsOfValues<S>;
  using Sums = typename ErrorAdder<S>::Sums;

  /// Looks at all values of `means`, which may be some rows of a picture, and adds those without
  /// rare samples. `first_row`: of these rows in the picture; `room`: number of rows that there is
  /// room for, those of `means` if 0. The bits do not depend on the executor.
  GMIS_RARE ErrorOfRows(const BatchMeans<S>& means, ExecutorRef executor, std::size_t first_row = 0,
                        std::size_t room = 0)
      : row_length_(static_cast<std::size_t>(means.resolution().x) * channels) {
    const auto rows = static_cast<std::size_t>(means.resolution().y);
    sums_.resize(std::max(rows, room));
    mean_.resize(sums_.size() * row_length_);
    per_pixel_.resize(mean_.size() / channels);
    const RunParts<S> parts(means);
    if (parts.count() < 2) return;
    std::vector<std::vector<RareSample>> found(rows);
    executor.parallel_for_all(rows, [&](std::size_t row) { add_row(parts, row, found[row]); });
    for (const std::vector<RareSample>& of_row : found)
      for (const RareSample& sample : of_row)
        rare_.push_back({sample.index + first_row * row_length_, sample.part, sample.around});
  }

  /// The rare samples of these rows, by value of the picture and part, to be completed by those of
  /// rows below before `add_rare`.
  [[nodiscard]] std::vector<RareSample>& rare() noexcept { return rare_; }

  /// Adds the values with rare samples. `parts`: of the whole picture, as all rows of this must be.
  GMIS_RARE void add_rare(const RunParts<S>& parts, ExecutorRef executor) {
    const RareSamples looked_at(parts, mean_, std::move(rare_), executor);
    const std::span<const RareSample> all = looked_at.samples();
    const auto first_of = [&](std::size_t block) {
      return std::lower_bound(all.begin(), all.end(), block * rows_of_block * row_length_,
                              [](const RareSample& sample, std::size_t index) { return sample.index < index; });
    };
    std::vector<Sums> sums((sums_.size() + rows_of_block - 1) / rows_of_block);
    executor.parallel_for_all(sums.size(), [&](std::size_t block) {
      sums[block] = added(parts, looked_at, {first_of(block), first_of(block + 1)});
    });
    for (const Sums& block : sums) sums_of_rare_ += block;
  }

  /// The sums over all values.
  [[nodiscard]] Sums sums() const noexcept {
    Sums all = sums_of_rare_;
    for (const Sums& row : sums_) all += row;
    return all;
  }
  /// Takes out the squared relative error of each pixel, summed over its channels.
  [[nodiscard]] std::vector<double> take_per_pixel() noexcept { return std::move(per_pixel_); }

  /// Numbers by rows (`RowGatherer`); the rare samples are not among them.
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(mean_, per_pixel_, sums_);
  }

 private:
  static constexpr std::size_t channels = BatchMeans<S>::channel_count, lanes = Values::lanes, rows_of_block = 16;

  void add_row(const RunParts<S>& parts, std::size_t row, std::vector<RareSample>& found) {
    const std::size_t count = parts.count(), begin = row * row_length_, end = begin + row_length_;
    for (std::size_t b = 0; b < count; ++b)
      parts.with_values(b, [&](const auto of_part) {
        for (std::size_t i = begin; i < end; ++i) mean_[i] += parts.share(b) * static_cast<double>(of_part[i]);
      });
    ErrorAdder<S> adder(count);
    for (std::size_t first = begin; first < end; first += lanes) {
      typename Values::Indices indices;
      for (std::size_t l = 0; l < lanes; ++l) indices[l] = std::min(first + l, end - 1);
      const Values here(parts, mean_, indices);
      std::array<bool, lanes> counts{};
      for (std::size_t l = 0; l < lanes && first + l < end; ++l) {
        if (!here.varies(l)) continue;
        counts[l] = !here.has_rare(l);
        for (std::size_t b = 0; b < count && !counts[l]; ++b)
          if (here.is_rare(b, l)) found.push_back({first + l, b});
      }
      const auto errors = adder.add(parts, here, counts, nullptr);
      for (std::size_t l = 0; l < lanes; ++l)
        if (counts[l]) per_pixel_[(first + l) / channels] += errors[l];
    }
    sums_[row] = adder.sums(count);
  }

  /// Adds rare samples, by value and part, to their pixels; returns their sums.
  Sums added(const RunParts<S>& parts, const RareSamples& rare, std::span<const RareSample> here) {
    ErrorAdder<S> adder(parts.count());
    for (auto next = here.begin(); next != here.end();) {
      typename Values::Indices indices{};
      std::array<typename Values::Numbers, Values::most> inverse{};
      std::array<bool, lanes> counts{};
      for (std::size_t l = 0; l < lanes && next != here.end(); ++l) {
        counts[l] = true;
        indices[l] = next->index;
        for (; next != here.end() && next->index == indices[l]; ++next)
          inverse[next->part][l] = 1.0 / (square(rare.value_at(*next)) + relative_error_floor);
      }
      const auto errors = adder.add(parts, Values(parts, mean_, indices), counts, &inverse);
      for (std::size_t l = 0; l < lanes; ++l)
        if (counts[l]) per_pixel_[indices[l] / channels] += errors[l];
    }
    return adder.sums(parts.count());
  }

  std::size_t row_length_;         // in values
  std::vector<double> mean_;       // of all parts, by value
  std::vector<double> per_pixel_;  // squared relative error
  std::vector<Sums> sums_;         // by row, without rare samples
  std::vector<RareSample> rare_;
  Sums sums_of_rare_;
};

}  // namespace gmis::detail
