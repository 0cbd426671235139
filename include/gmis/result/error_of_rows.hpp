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

/// The part of some rows in the estimate of the error of a picture, in three steps: the values
/// without rare samples (constructor), how bright the places of rare samples are in the whole
/// picture (`brightness`), and the values with rare samples (`add_rare`).
template <Spectrum S>
class ErrorOfRows {
 public:
  using Values = PartsOfValues<S>;
  using Sums = typename ErrorAdder<S>::Sums;

  /// Looks at all values of `means`, which must outlive this, and adds those without rare samples.
  /// `around`: what is around these rows, if they are not the whole picture, without its mean. The
  /// bits depend neither on the executor nor on how a picture is cut into rows.
  GMIS_RARE ErrorOfRows(const BatchMeans<S>& means, ExecutorRef executor, RowsAround around = {})
      : parts_(means),
        around_(std::move(around)),
        row_length_(static_cast<std::size_t>(means.resolution().x) * channels),
        mean_(means.value_count()),
        rare_(static_cast<std::size_t>(means.resolution().y)) {
    make_room(rare_.size());
    if (parts_.count() < 2) return;
    for (std::size_t b = 0; b < around_.part_values.size(); ++b) {
      const std::vector<double>& values = around_.part_values[b];
      around_.mean.resize(values.size());
      for (std::size_t i = 0; i < values.size(); ++i) around_.mean[i] += parts_.share(b) * values[i];
    }
    executor.parallel_for_all(rare_.size(), [&](std::size_t row) { add_row(row); });
    executor.parallel_for_all(rare_.size(), [&](std::size_t row) {
      for (RareSample& sample : rare_[row]) {
        sample.around = neighbourhood_without(parts_, mean_, around_, sample.index, sample.part);
        brightness_[row].add(parts_, mean_[sample.index], sample);
      }
    });
  }

  /// Makes room for the sums of all rows of a picture, whose first ones are those here.
  void make_room(std::size_t rows) {
    sums_.resize(rows);
    brightness_.resize(rows);
    per_pixel_.resize(rows * row_length_ / channels);
  }
  /// The sums by row that tell the brightness.
  [[nodiscard]] std::vector<BrightnessSums>& brightness_by_row() noexcept { return brightness_; }
  /// `BrightnessSums::brightness` of all rows that there is room for.
  [[nodiscard]] BrightnessSums::Numbers brightness() const noexcept {
    BrightnessSums all;
    for (const BrightnessSums& row : brightness_) all += row;
    return all.brightness();
  }
  /// Adds the values with rare samples. `brightness`: that of the whole picture.
  GMIS_RARE void add_rare(const BrightnessSums::Numbers& brightness, ExecutorRef executor) {
    executor.parallel_for_all(rare_.size(), [&](std::size_t row) { sums_[row] += added(rare_[row], brightness); });
  }

  /// The sums over all values.
  [[nodiscard]] Sums sums() const noexcept {
    Sums all;
    for (const Sums& row : sums_) all += row;
    return all;
  }
  /// Takes out the squared relative error of each pixel, summed over its channels.
  [[nodiscard]] std::vector<double> take_per_pixel() noexcept { return std::move(per_pixel_); }
  /// The parts of the run.
  [[nodiscard]] const RunParts<S>& parts() const noexcept { return parts_; }

  /// The sums by row (`RowGatherer`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(per_pixel_, sums_);
  }

 private:
  static constexpr std::size_t channels = BatchMeans<S>::channel_count, lanes = Values::lanes;

  void add_row(std::size_t row) {
    const std::size_t count = parts_.count(), begin = row * row_length_, end = begin + row_length_;
    for (std::size_t b = 0; b < count; ++b)
      parts_.with_values(b, [&](const auto of_part) {
        for (std::size_t i = begin; i < end; ++i) mean_[i] += parts_.share(b) * static_cast<double>(of_part[i]);
      });
    ErrorAdder<S> adder(count);
    for (std::size_t first = begin; first < end; first += lanes) {
      typename Values::Indices indices;
      for (std::size_t l = 0; l < lanes; ++l) indices[l] = std::min(first + l, end - 1);
      const Values here(parts_, mean_, indices);
      std::array<bool, lanes> counts{};
      for (std::size_t l = 0; l < lanes && first + l < end; ++l) {
        if (!here.varies(l)) continue;
        counts[l] = !here.has_rare(l);
        for (std::size_t b = 0; b < count && !counts[l]; ++b)
          if (here.is_rare(b, l)) rare_[row].push_back({first + l, b});
      }
      const auto errors = adder.add(parts_, here, counts, nullptr);
      for (std::size_t l = 0; l < lanes; ++l)
        if (counts[l]) per_pixel_[(first + l) / channels] += errors[l];
    }
    sums_[row] = adder.sums(count);
  }

  /// Adds the rare samples of a row, by value and part, to their pixels; returns their sums.
  Sums added(std::span<const RareSample> rare, const BrightnessSums::Numbers& brightness) {
    ErrorAdder<S> adder(parts_.count());
    for (auto next = rare.begin(); next != rare.end();) {
      typename Values::Indices indices{};
      std::array<typename Values::Numbers, Values::most> inverse{};
      std::array<bool, lanes> counts{};
      for (std::size_t l = 0; l < lanes && next != rare.end(); ++l) {
        counts[l] = true;
        indices[l] = next->index;
        for (; next != rare.end() && next->index == indices[l]; ++next)
          inverse[next->part][l] =
              1.0 / (square(brightness[next->around.reach] * next->around.mean) + relative_error_floor);
      }
      const auto errors = adder.add(parts_, Values(parts_, mean_, indices), counts, &inverse);
      for (std::size_t l = 0; l < lanes; ++l)
        if (counts[l]) per_pixel_[indices[l] / channels] += errors[l];
    }
    return adder.sums(parts_.count());
  }

  RunParts<S> parts_;
  RowsAround around_;
  std::size_t row_length_;                     // in values
  std::vector<double> mean_;                   // of all parts, by value
  std::vector<std::vector<RareSample>> rare_;  // by row, value and part
  std::vector<BrightnessSums> brightness_;     // by row
  std::vector<double> per_pixel_;              // squared relative error
  std::vector<Sums> sums_;                     // by row
};

}  // namespace gmis::detail
