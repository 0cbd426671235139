#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/executor_ref.hpp"
#include "gmis/core/math.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/result/merging_bias.hpp"
#include "gmis/transport/allocation/forecast.hpp"
#include "gmis/transport/allocation/pilot_output.hpp"
#include "gmis/transport/engine/any_engine.hpp"

/// \file
/// Forecasts the efficiency of many sample allocations from one set of samples. A pilot renders
/// with all techniques and keeps, for every contribution, the density of its path by each
/// technique. Re-weighting the contributions then gives the result of any other counts [Grittmann
/// et al. 2022, efficiency-aware MIS].
///
/// In one iteration the value of a pixel is A + B: its camera subpath makes A, and the splats of
/// independent light trees make B. With D(x) the expected sample density of all techniques
/// together,
///     Var(A + B) = ∫ f²/D + E[Σ_{i≠j} A_i A_j] − E[A]² + 2 Cov(A, B).
/// The sum runs over pairs of contributions of one camera subpath. A and B are correlated when a
/// light vertex is both merged and connected with the camera. Samples of one technique estimate the
/// integral for all techniques, including those that rarely find the path. The pilot therefore
/// predicts the fireflies of a caustic before one occurs.

namespace gmis {

namespace detail {

/// The threshold that the largest 0.1 % of `values` exceed: two of 1000 to 2999 values, none of
/// fewer. `values` has one entry per pixel, the least second moment of all candidates. Pixels above
/// the threshold hold fireflies that every candidate has; they would otherwise dominate all
/// forecasts. With one pixel left out of 1844, forecasts of a hall of mirrors were off by a factor
/// of 4, with two by 3.
[[nodiscard]] inline double firefly_threshold(std::vector<double> values) {
  constexpr std::size_t fewest_left_out = 2;
  if (values.empty()) return 0.0;
  const std::size_t thousandth = trimmed_pixels(values.size());
  const std::size_t left_out = thousandth > 0 ? std::max(fewest_left_out, thousandth) : 0;
  double* const begin = values.data();
  double* const last = begin + (values.size() - left_out - 1);
  std::nth_element(begin, last, begin + values.size());
  return *last;
}

}  // namespace detail

/// A pilot for any scene with the spectrum `S`: the candidates and the estimates of the iterations
/// so far. A forecast needs at least two iterations. `RenderPilot` has the engine.
template <Spectrum S>
class AnyPilot {
 public:
  virtual ~AnyPilot() = default;
  AnyPilot(const AnyPilot&) = delete;
  AnyPilot& operator=(const AnyPilot&) = delete;

  /// Renders one more iteration; `engine().frame()` is its picture in the pixels that are taken.
  virtual void iterate(ExecutorRef executor) = 0;
  /// `AnyEngine::learn_lights` of the engine that is run, before the first iteration.
  virtual void learn_lights(std::uint64_t seed, ExecutorRef executor) = 0;
  /// The engine that is run.
  [[nodiscard]] virtual const AnyEngine<S>& engine() const noexcept = 0;
  /// Iterations so far.
  [[nodiscard]] std::uint32_t iterations() const noexcept { return engine().iteration(); }

  /// Sets the picture to whose squared values variance and bias are relative: mean over channels,
  /// rows from the upper left. Without it they are relative to the pilot's own picture.
  void compare_with(std::vector<double> picture) { picture_ = std::move(picture); }

  /// True when at least one pixel was taken. Otherwise nothing is known about any candidate.
  [[nodiscard]] bool has_seen_pixels() const noexcept { return pixels_taken_ > 0.0; }

  /// One forecast per candidate, in the order of the candidates. Variance and bias use complete
  /// pairs of iterations. Without a pixel all predicted values are 0.
  GMIS_RARE [[nodiscard]] std::vector<Forecast> forecasts(const OperationCosts& costs = {}) const {
    std::vector<Forecast> all(candidates_.size());
    const Counters camera_work = engine().counters() - engine().light_work();
    for (std::size_t c = 0; c < all.size(); ++c) {
      all[c].counts = candidates_[c];
      if (!has_seen_pixels()) continue;
      all[c].variance = std::max(0.0, variance_[c]) / pixels_taken_;
      all[c].squared_bias = squared_bias(c);
      all[c].cost = (pixels_for_each() * predicted_camera_cost(candidates_[c], made_, camera_work, costs) +
                     predicted_light_cost(candidates_[c], made_, light_work(), photons_, costs)) /
                    static_cast<double>(iterations());
      all[c].missing_share = light_ > 0.0 ? missing_[c] / light_ : 0.0;
    }
    return all;
  }

 protected:
  /// The candidates, and the counts that the pilot renders with. Throws `std::invalid_argument` for
  /// a candidate with a technique that the pilot lacks, of which no sample would tell anything.
  GMIS_RARE AnyPilot(std::vector<SampleCounts> candidates, const SampleCounts& made)
      : candidates_(std::move(candidates)), made_(made) {
    shape_.made = made_;
    for (const SampleCounts& candidate : candidates_) {
      for (const Technique technique : all_techniques)
        require_argument(
            made_.has(technique) || !candidate.has(technique),
            "a candidate has a technique that is off in RenderSettings::counts, so a pilot cannot forecast "
            "it: switch on there every technique that any candidate has");
      shape_.add(candidate);
    }
    missing_.assign(shape_.count, 0.0);
    biases_.assign(shape_.count, {});
    variance_.assign(shape_.count, 0.0);
  }

  /// Takes the outputs of the engine, which must stay where they are. `resolution` is that of the
  /// whole frame.
  GMIS_RARE void observe(std::vector<PilotOutput<S>*> outputs, glm::ivec2 resolution,
                         std::uint32_t expected_iterations) {
    shape_.grid = PilotGrid(resolution, engine().crop(), expected_iterations);
    outputs_ = std::move(outputs);
    for (PilotOutput<S>* const output : outputs_) output->analyse(&shape_);
    pictures_.assign(shape_.grid.taken().size(), 0.0F);
  }

  /// Takes in the iteration that the engine has just rendered, with this number of photons.
  void end_iteration(std::size_t photon_count) {
    analyse(iterations() % 2 == 0 ? second_ : first_, photon_count);
    if (iterations() % 2 == 0) take_in(first_, second_);
  }

 private:
  /// The estimates of one iteration. The sums stay in the blocks in which the outputs made them:
  /// memory that the process has not used before costs more than their use.
  struct Analysis {
    std::vector<std::vector<float>> sums;    ///< `PilotOutput::pixel_sums`, per output
    std::vector<float*> camera;              ///< per pixel that is taken, its rows in `sums`
    std::vector<std::vector<float>> splats;  ///< B, per pixel that is taken and candidate; empty where there is none
    std::vector<float> picture;              ///< per pixel that is taken
    std::vector<double> kernel_changes;      ///< sum of `PilotOutput::kernel_changes`, per tile and candidate
  };

  /// Sums over pairs of iterations, for the squared bias of one candidate: that of the tiles, that
  /// of the whole picture, and the variance of either.
  struct BiasSums {
    double tiles = 0.0, tiles_noise = 0.0, whole = 0.0, whole_noise = 0.0;
  };

  /// The estimate of a pixel's squared mean counts at most this many times that of its second
  /// moment. The true squared mean is no larger than the second moment, but its estimate is a
  /// product of the candidate's own samples: two fireflies in one pixel, one in each iteration,
  /// could make the variance over all pixels negative.
  static constexpr double most_of_second_moment = 4.0;

  /// Collects the estimates of the latest iteration.
  void analyse(Analysis& all, std::size_t photon_count) {
    const PilotGrid& grid = shape_.grid;
    const std::size_t n = shape_.count;
    all.sums.resize(outputs_.size());
    all.camera.clear();
    all.splats.resize(grid.taken().size());
    for (std::vector<float>& splats : all.splats) splats.clear();
    all.kernel_changes.assign(n * grid.tile_count(), 0.0);
    // The outputs of the camera side come row by row, their pixels thus in the order of `taken()`.
    for (std::size_t o = 0; o < outputs_.size(); ++o) {
      PilotOutput<S>& output = *outputs_[o];
      for (std::size_t c = 0; c < output.missing.size(); ++c) missing_[c] += output.missing[c];
      std::swap(all.sums[o], output.pixel_sums);
      for (std::size_t i = 0; i < output.kernel_changes.size(); i += n) {
        double* const changes = all.kernel_changes.data() + n * grid.tile(grid.taken()[all.camera.size()]);
        for (std::size_t c = 0; c < n; ++c) changes[c] += static_cast<double>(output.kernel_changes[i + c]);
        all.camera.push_back(all.sums[o].data() + 2 * i);
      }
    }
    for (const PilotOutput<S>* const output : outputs_)
      for (const auto& splat : output->splat_records()) {
        const std::size_t pixel = grid.index(splat.pixel);
        all.splats[pixel].resize(n);
        output->for_each_candidate(splat,
                                   [&](std::size_t c, const typename PilotOutput<S>::Terms& terms, std::size_t i) {
                                     all.splats[pixel][c] += terms.own[i];
                                     all.camera[pixel][n + c] += terms.second_moment[i];
                                     missing_[c] += static_cast<double>(terms.missed[i]);
                                   });
      }
    photons_ += photon_count;
    all.picture.clear();
    for (const std::uint32_t pixel : grid.taken()) {
      all.picture.push_back(static_cast<float>(mean_channel(engine().frame()[pixel])));
      light_ += static_cast<double>(all.picture.back());
    }
  }

  /// Adds a pair of independent iterations. The product of two independent estimates has the square
  /// of their mean as its mean. The value that an error is relative to must be independent of the
  /// error, too: a firefly would otherwise brighten its pixel and look small relative to it. Each
  /// iteration is therefore compared with the picture of the other iteration and of all pairs
  /// before.
  void take_in(const Analysis& a, const Analysis& b) {
    const std::size_t n = shape_.count;
    std::vector<double> values, scales_a, scales_b, least;
    const std::vector<double> values_a = values_beside(b), values_b = values_beside(a);
    const std::size_t pixels = pictures_.size();
    for (std::size_t i = 0; i < pixels; ++i) {
      values.push_back(0.5 * (values_a[i] + values_b[i]));
      scales_a.push_back(0.5 / (square(values_a[i]) + relative_error_floor));
      scales_b.push_back(0.5 / (square(values_b[i]) + relative_error_floor));
      double least_moment = std::numeric_limits<double>::max();
      for (std::size_t k = n; k < 2 * n; ++k)
        least_moment = std::min(least_moment, scales_a[i] * static_cast<double>(a.camera[i][k]) +
                                                  scales_b[i] * static_cast<double>(b.camera[i][k]));
      least.push_back(least_moment);
    }
    const double most = detail::firefly_threshold(least);
    // Cov(A, B) is inversely proportional to the number of light trees.
    std::vector<double> fewer_trees;
    for (const SampleCounts& candidate : candidates_)
      fewer_trees.push_back(candidate.traces_light() ? made_.light_paths / candidate.light_paths : 0.0);
    for (std::size_t i = 0; i < pixels; ++i) {
      if (least[i] > most) continue;
      pixels_taken_ += 1.0;
      const float *const of_a = a.camera[i], *const of_b = b.camera[i];
      for (std::size_t c = 0; c < n; ++c) {
        const double scale = scales_a[i] + scales_b[i];
        const double second_moment =
            scales_a[i] * static_cast<double>(of_a[n + c]) + scales_b[i] * static_cast<double>(of_b[n + c]);
        const double squared_mean = scale * static_cast<double>(of_a[c]) * static_cast<double>(of_b[c]);
        const float difference =
            (a.splats[i].empty() ? 0.0F : a.splats[i][c]) - (b.splats[i].empty() ? 0.0F : b.splats[i][c]);
        // The last product is an estimate of 2 Cov(A, B) from two independent iterations.
        variance_[c] += second_moment - std::min(squared_mean, most_of_second_moment * second_moment) +
                        scale * static_cast<double>((of_a[c] - of_b[c]) * difference) * fewer_trees[c];
      }
    }
    add_biases(a, b, values);
    for (std::size_t p = 0; p < pictures_.size(); ++p) pictures_[p] += a.picture[p] + b.picture[p];
    iterations_in_pictures_ += 2;
  }

  /// Adds to the squared bias of merging, relative to the squared mean of `values`. The bias of a
  /// disk with radius r is c r² to first order, so that the change from half the radius is ¾ of it.
  /// Squares are products of two independent iterations. The mean square over tiles shows a bias
  /// that changes sign from place to place, but it is noisy; the square of the mean over the
  /// picture is a lower bound with little noise.
  void add_biases(const Analysis& a, const Analysis& b, const std::vector<double>& values) {
    const std::size_t n = shape_.count, tiles = shape_.grid.tile_count();
    std::vector<double> tile_values(tiles, 0.0), tile_pixels(tiles, 0.0);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t tile = shape_.grid.tile(shape_.grid.taken()[i]);
      tile_values[tile] += values[i];
      tile_pixels[tile] += 1.0;
    }
    for (std::size_t c = 0; c < n; ++c) {
      if (!candidates_[c].merges) continue;
      // Per tile, the mean change relative to the mean value; sums are weighted by numbers of
      // pixels.
      double sum_a = 0.0, sum_b = 0.0, apart = 0.0, pixels = 0.0;
      for (std::size_t t = 0; t < tiles; ++t) {
        if (!(tile_pixels[t] > 0.0)) continue;
        const double unit = bias_of_change_when_smooth /
                            std::sqrt(square(tile_values[t]) + square(tile_pixels[t]) * relative_error_floor);
        const double change_a = a.kernel_changes[t * n + c] * unit, change_b = b.kernel_changes[t * n + c] * unit;
        const double product = tile_pixels[t] * change_a * change_b;
        biases_[c].tiles += product;
        biases_[c].tiles_noise += square(product);
        pixels += tile_pixels[t];
        sum_a += tile_pixels[t] * change_a;
        sum_b += tile_pixels[t] * change_b;
        apart += square(tile_pixels[t] * (change_a - change_b));
      }
      if (!(pixels > 0.0)) continue;
      biases_[c].whole += sum_a * sum_b / pixels;
      biases_[c].whole_noise += square(0.5 * apart / pixels);  // that of a product of two such sums, but for its mean
    }
  }

  /// Lower confidence bound of the squared bias, at least 0: over tiles the estimate minus two
  /// standard errors, over the whole picture minus one.
  [[nodiscard]] double squared_bias(std::size_t c) const noexcept {
    constexpr double standard_errors = 2.0;
    if (!(pixels_taken_ > 0.0)) return 0.0;
    const BiasSums& bias = biases_[c];
    const double tiles = bias.tiles - standard_errors * std::sqrt(bias.tiles_noise);
    return std::max({0.0, tiles, bias.whole - std::sqrt(bias.whole_noise)}) / pixels_taken_;
  }

  /// For each pixel, the value that its error is relative to: that of the known picture, or the
  /// mean of `iteration` and of all pairs before over the pixels around it.
  [[nodiscard]] std::vector<double> values_beside(const Analysis& iteration) const {
    const PilotGrid& grid = shape_.grid;
    std::vector<double> values;
    values.reserve(pictures_.size());
    for (const std::uint32_t pixel : grid.taken()) {
      if (!picture_.empty()) {
        values.push_back(picture_[pixel]);
        continue;
      }
      const glm::ivec2 at = grid.place(pixel), low = glm::max(at - grid.reach(), glm::ivec2(0)),
                       high = glm::min(at + grid.reach(), grid.size() - 1);
      glm::vec2 sum(0.0F);  // value and number of pixels
      for (int y = low.y; y <= high.y; ++y) {
        glm::vec2 of_row(0.0F);
        grid.for_each_in_row(y, low.x, high.x,
                             [&](std::size_t i) { of_row += glm::vec2(pictures_[i] + iteration.picture[i], 1.0F); });
        sum += of_row;
      }
      values.push_back(static_cast<double>(sum.x / (sum.y * static_cast<float>(iterations_in_pictures_ + 1))));
    }
    return values;
  }

  /// Counted work of the light trees, as if splats were made for all pixels.
  [[nodiscard]] Counters light_work() const {
    Counters work = engine().light_work();
    work.shadow_rays =
        static_cast<std::uint64_t>(std::llround(static_cast<double>(work.shadow_rays) * pixels_for_each()));
    return work;
  }

  /// Pixels in the crop over pixels that were taken, of all iterations.
  [[nodiscard]] double pixels_for_each() const noexcept {
    const glm::ivec2 size = glm::max(engine().crop().upper - engine().crop().lower, glm::ivec2(0));
    return static_cast<double>(size.x) * size.y * iterations() / static_cast<double>(engine().counters().camera_paths);
  }

  std::vector<SampleCounts> candidates_;
  SampleCounts made_;  // counts of the pilot itself
  PilotCandidates shape_;
  std::vector<PilotOutput<S>*> outputs_;
  std::vector<double> picture_;
  Analysis first_, second_;      // the current pair of iterations
  std::vector<float> pictures_;  // sum of the pictures of all pairs before, per pixel that is taken
  std::uint32_t iterations_in_pictures_ = 0;
  std::vector<double> variance_;  // sums over pixels and pairs of iterations, per candidate
  std::vector<BiasSums> biases_;
  std::vector<double> missing_;
  double pixels_taken_ = 0.0, light_ = 0.0;
  std::uint64_t photons_ = 0;  // sum over iterations
};

#ifdef GMIS_COMPILED
extern template class AnyPilot<Vec3<float>>;
extern template class AnyPilot<Vec3<double>>;
#endif

}  // namespace gmis
