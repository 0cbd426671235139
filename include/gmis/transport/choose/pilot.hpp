#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/transport/choose/pilot_output.hpp"
#include "gmis/transport/engine.hpp"

/// \file
/// Which counts pay in a scene, from one set of samples. A pilot renders with all techniques and keeps, for every
/// contribution, the path's density by each technique; what any other counts would have given follows by
/// re-weighting [Grittmann et al. 2022, efficiency-aware MIS]. In an iteration a pixel is A + B: A what its camera
/// subpath makes, B the splats of independent light trees. With D(x) the expected density of all techniques together,
///     Var(A + B) = ∫ f²/D + E[Σ_{i≠j} A_i A_j] − E[A]² + 2 Cov(A, B),
/// the sum over pairs of contributions of one camera subpath; A and B have to do with each other where a light vertex is
/// both merged and connected with the camera. Any technique's samples can estimate the integral, also
/// that of techniques which rarely find the path themselves: so the pilot sees a caustic's fireflies before they happen.
///
/// With c children of the first non-specular vertex in place of one, A's part beyond it is a mean of c that are
/// independent of each other: (1 − 1/c) W less, W the variance of one child given what lies before it. The pilot traces
/// two in some pixels and so knows W.

namespace gmis {

/// Weights whose densities by technique are kept apart.
struct SeparateWeights {
  static constexpr bool has_light_side = true;
  template <std::floating_point T>
  using Recursion = WeightRecursion<T, BalanceRatio, SeparateSums<T>>;
};

/// Renders two iterations at least, and forecasts what every candidate would give.
template <Scene Sc, class Source = Philox>
class RenderPilot {
 public:
  using S = typename Sc::Spectrum;
  using EngineType = Engine<Sc, Method<SeparateWeights, PilotSplit, PilotOutput>, Source>;

  /// The techniques of `settings.counts`, which must connect and splat, are those that candidates may have. The radius of
  /// merging shrinks from iteration to iteration; the pilot's is the mean of a run of `expected_iterations`.
  RenderPilot(const Sc& scene, const RenderSettings& settings, std::vector<SampleCounts> candidates,
              std::uint32_t expected_iterations, const std::optional<PixelBounds>& crop = std::nullopt)
      : candidates_(std::move(candidates)),
        made_(counts_of_pilot(settings.counts)),
        engine_(scene, settings_of_pilot(scene, settings, expected_iterations), crop) {
    shape_.grid = PilotGrid(scene.camera().resolution(), engine_.crop());
    shape_.made = made_;
    for (const SampleCounts& candidate : candidates_) {
      const SampleCounts unsplit = without_splitting(candidate);
      const auto found = std::find(unsplit_.begin(), unsplit_.end(), unsplit);
      unsplit_of_.push_back(static_cast<std::size_t>(found - unsplit_.begin()));
      if (found != unsplit_.end()) continue;
      unsplit_.push_back(unsplit);
      shape_.add(unsplit);
    }
    engine_.for_each_output([&](PilotOutput<S>& output) { output.analyse(&shape_); });
    missing_.assign(shape_.count, 0.0);
    biases_.assign(shape_.count, {});
    variance_.assign(shape_.count, 0.0);
    within_.assign(shape_.count, 0.0);
    earlier_.assign(engine_.frame().size(), 0.0F);
  }
  RenderPilot(const RenderPilot&) = delete;
  RenderPilot& operator=(const RenderPilot&) = delete;

  [[nodiscard]] const EngineType& engine() const noexcept { return engine_; }
  [[nodiscard]] std::uint32_t iterations() const noexcept { return engine_.iteration(); }

  /// The picture that variance is relative to the square of, where it is known: by rows, the mean over channels. Without
  /// it the pilot's own.
  void compare_with(std::vector<double> picture) { picture_ = std::move(picture); }

  /// One more iteration; its picture is that of the engine.
  template <Executor E>
  void iterate(E& executor) {
    engine_.iterate(executor);
    analyse(iterations() % 2 == 0 ? second_ : first_);
    if (iterations() % 2 == 0) take_in(first_, second_);
  }

  /// Whether any pixel was analysed: without one, nothing is known of any candidate.
  [[nodiscard]] bool has_seen_pixels() const noexcept { return pixels_taken_ > 0.0; }

  /// One forecast a candidate, in their order, from the iterations so far; an odd one at the end is left out.
  [[nodiscard]] std::vector<Forecast> forecasts(const OperationCosts& costs = {}) const {
    std::vector<Forecast> all(candidates_.size());
    for (std::size_t c = 0; c < all.size(); ++c) {
      all[c].counts = candidates_[c];
      if (!has_seen_pixels()) continue;
      const std::size_t u = unsplit_of_[c];
      const double share = 1.0 / static_cast<double>(candidates_[c].camera_children);
      // W is not more than all there is.
      const double least = std::max(0.0, share * variance_[u]);
      all[c].variance = std::max(least, variance_[u] - (1.0 - share) * within_[u]) / pixels_taken_;
      all[c].squared_bias = squared_bias(u);
      all[c].cost = (predicted_camera_cost(candidates_[c], made_, work_, costs) +
                     predicted_light_cost(candidates_[c], made_, engine_.light_work(), costs)) /
                    static_cast<double>(iterations());
      all[c].missing_share = light_ > 0.0 ? missing_[u] / light_ : 0.0;
    }
    return all;
  }

 private:
  /// Two connections, since the pilot must see pairs of them.
  [[nodiscard]] static SampleCounts counts_of_pilot(SampleCounts counts) {
    counts.light_paths = 1.0;
    counts.connections = 2;
    counts.camera_children = 1;
    return counts;
  }

  [[nodiscard]] static RenderSettings settings_of_pilot(const Sc& scene, RenderSettings settings,
                                                        std::uint32_t expected_iterations) {
    settings.radius =
        settings.radius.value_or(default_radius(scene)) * std::sqrt(mean_disk(settings.alpha, expected_iterations));
    settings.alpha = 1.0;
    settings.light_split = LightSplit::none;
    settings.counts = counts_of_pilot(settings.counts);
    return settings;
  }

  [[nodiscard]] static SampleCounts without_splitting(SampleCounts candidate) noexcept {
    candidate.camera_children = 1;
    return candidate;
  }

  /// The place of the same counts without merging; itself where there are none.
  [[nodiscard]] std::size_t without_merging(std::size_t u) const noexcept {
    SampleCounts other = unsplit_[u];
    other.merges = false;
    const auto found = std::find(unsplit_.begin(), unsplit_.end(), other);
    return found == unsplit_.end() ? u : static_cast<std::size_t>(found - unsplit_.begin());
  }

  /// What one iteration says.
  struct Analysis {
    std::vector<float> picture;
    // By analysed pixel and candidate: A, B, and of both together ∫ f²/D and what there is within a child.
    std::vector<float> means, splats, second_moments, within;
    std::vector<double> tile_sums;  ///< A + B, by tile and candidate
  };

  /// Of a candidate's squared bias, by tile and pair of iterations.
  struct BiasSums {
    double sum = 0.0, squares = 0.0;
  };

  static constexpr std::uint32_t not_analysed = 0xFFFFFFFFU;

  void analyse(Analysis& all) {
    const PilotGrid& grid = shape_.grid;
    const std::size_t n = shape_.count;
    all.means.clear();
    all.second_moments.clear();
    all.within.clear();
    all.splats.clear();
    all.tile_sums.assign(n * grid.tile_count(), 0.0);
    pixels_.clear();
    place_.assign(engine_.frame().size(), not_analysed);
    engine_.for_each_output([&](PilotOutput<S>& output) {
      for (std::size_t c = 0; c < output.missing.size(); ++c) missing_[c] += output.missing[c];
      work_.before += output.work().before;
      work_.children += output.work().children;
      for (std::size_t i = 0; i < output.pixel_count(); ++i) {
        const auto record = output.pixel(i);
        place_[record.pixel] = static_cast<std::uint32_t>(pixels_.size());
        pixels_.push_back(record.pixel);
        all.means.insert(all.means.end(), record.mean.begin(), record.mean.end());
        all.second_moments.insert(all.second_moments.end(), record.second_moment.begin(), record.second_moment.end());
        all.within.insert(all.within.end(), record.within.begin(), record.within.end());
        double* const sums = all.tile_sums.data() + n * grid.tile(record.pixel);
        for (std::size_t c = 0; c < n; ++c) sums[c] += static_cast<double>(record.mean[c]);
      }
    });
    all.splats.resize(all.means.size(), 0.0F);
    engine_.for_each_output([&](PilotOutput<S>& output) {
      for (const auto& splat : output.splat_records()) {
        double* const sums = all.tile_sums.data() + n * grid.tile(splat.pixel);
        const std::size_t first = n * place_[splat.pixel];
        output.for_each_candidate(splat, [&](std::size_t c, const typename PilotOutput<S>::Lane& lane) {
          sums[c] += static_cast<double>(lane.own);
          all.splats[first + c] += lane.own;
          all.second_moments[first + c] += lane.second_moment;
          all.within[first + c] += lane.beyond;
          missing_[c] += static_cast<double>(lane.missed);
        });
      }
    });
    all.picture.clear();
    for (const S& value : engine_.frame()) all.picture.push_back(static_cast<float>(mean_channel(value)));
    for (const std::uint32_t pixel : pixels_) light_ += static_cast<double>(all.picture[pixel]);
  }

  /// Two iterations that know nothing of each other: the product of what they say has the square for its mean. Nor may what
  /// an error is relative to know of the error: a pixel with a firefly would look bright and the firefly small. So it is
  /// the picture of the other iteration, with all before.
  void take_in(const Analysis& a, const Analysis& b) {
    const std::size_t n = shape_.count;
    std::vector<double> values, scales_a, scales_b, least;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const double value_a = value_of(pixels_[i], b), value_b = value_of(pixels_[i], a);
      values.push_back(0.5 * (value_a + value_b));
      scales_a.push_back(0.5 / (square(value_a) + relative_error_floor));
      scales_b.push_back(0.5 / (square(value_b) + relative_error_floor));
      double least_moment = std::numeric_limits<double>::max();
      for (std::size_t k = i * n; k < (i + 1) * n; ++k)
        least_moment = std::min(least_moment, scales_a[i] * static_cast<double>(a.second_moments[k]) +
                                                  scales_b[i] * static_cast<double>(b.second_moments[k]));
      least.push_back(least_moment);
    }
    const double most = kept_below(least);
    // With fewer light trees each has more to do with what it makes.
    std::vector<double> fewer_trees;
    for (const SampleCounts& candidate : unsplit_)
      fewer_trees.push_back(candidate.traces_light() ? made_.light_paths / candidate.light_paths : 0.0);
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      if (least[i] > most) continue;
      pixels_taken_ += 1.0;
      for (std::size_t k = i * n, c = 0; c < n; ++c, ++k) {
        variance_[c] +=
            scales_a[i] * static_cast<double>(a.second_moments[k]) +
            scales_b[i] * static_cast<double>(b.second_moments[k]) -
            (scales_a[i] + scales_b[i]) * (static_cast<double>(a.means[k]) * static_cast<double>(b.means[k]) -
                                           static_cast<double>(covariance_of(a, b, k)) * fewer_trees[c]);
        within_[c] += scales_a[i] * static_cast<double>(a.within[k]) + scales_b[i] * static_cast<double>(b.within[k]);
      }
    }
    add_biases(a, b, values);
    for (std::size_t p = 0; p < earlier_.size(); ++p) earlier_[p] += a.picture[p] + b.picture[p];
    earlier_iterations_ += 2;
  }

  /// The difference that merging makes, tile by tile, squared by way of two iterations; relative to the pixels' `values`.
  void add_biases(const Analysis& a, const Analysis& b, const std::vector<double>& values) {
    const std::size_t n = shape_.count, tiles = shape_.grid.tile_count();
    std::vector<double> tile_values(tiles, 0.0), tile_pixels(tiles, 0.0);
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const std::size_t tile = shape_.grid.tile(pixels_[i]);
      tile_values[tile] += values[i];
      tile_pixels[tile] += 1.0;
    }
    for (std::size_t c = 0; c < n; ++c) {
      const std::size_t without = without_merging(c);
      if (without == c) continue;
      for (std::size_t t = 0; t < tiles; ++t) {
        if (!(tile_pixels[t] > 0.0)) continue;
        const double product = (a.tile_sums[t * n + c] - a.tile_sums[t * n + without]) *
                               (b.tile_sums[t * n + c] - b.tile_sums[t * n + without]) / tile_pixels[t] /
                               (square(tile_values[t] / tile_pixels[t]) + relative_error_floor);
        biases_[c].sum += product;
        biases_[c].squares += square(product);
      }
    }
  }

  /// Of A and B, twice, from two iterations.
  [[nodiscard]] static float covariance_of(const Analysis& a, const Analysis& b, std::size_t k) noexcept {
    return (a.means[k] - b.means[k]) * (a.splats[k] - b.splats[k]);
  }

  /// The worst pixel in a thousand is left out, by what is least among the candidates: a few fireflies that all of them have
  /// would decide otherwise.
  [[nodiscard]] static double kept_below(std::vector<double> values) {
    if (values.empty()) return 0.0;
    const std::size_t kept = values.size() - values.size() / 1000;
    const auto last = values.begin() + static_cast<std::ptrdiff_t>(kept) - 1;
    std::nth_element(values.begin(), last, values.end());
    return *last;
  }

  /// Lower confidence bound of the squared bias: the estimate minus two standard errors, at least 0.
  [[nodiscard]] double squared_bias(std::size_t c) const noexcept {
    constexpr double standard_errors = 2.0;
    if (!(pixels_taken_ > 0.0)) return 0.0;
    return std::max(0.0, biases_[c].sum - standard_errors * std::sqrt(biases_[c].squares)) / pixels_taken_;
  }

  /// What an error is relative to: the known picture, or that of an iteration and all before the pair, in the mean over a
  /// pixel and two on each side.
  [[nodiscard]] double value_of(std::uint32_t pixel, const Analysis& iteration) const {
    if (!picture_.empty()) return picture_[pixel];
    const PixelBounds& crop = shape_.grid.crop();
    const int width = shape_.grid.width();
    const int x = static_cast<int>(pixel) % width, y = static_cast<int>(pixel) / width;
    constexpr int reach = 2;
    float sum = 0.0F, count = 0.0F;
    for (int v = std::max(crop.lower.y, y - reach); v <= std::min(crop.upper.y - 1, y + reach); ++v)
      for (int u = std::max(crop.lower.x, x - reach); u <= std::min(crop.upper.x - 1, x + reach); ++u) {
        const auto p = static_cast<std::size_t>(v * width + u);
        sum += earlier_[p] + iteration.picture[p];
        count += static_cast<float>(earlier_iterations_ + 1);
      }
    return static_cast<double>(sum / count);
  }

  std::vector<SampleCounts> candidates_;
  SampleCounts made_;                    // the pilot itself renders with, but for PilotSplit
  std::vector<SampleCounts> unsplit_;    // those that are followed: each of them once, without splitting
  std::vector<std::size_t> unsplit_of_;  // of a candidate, its place there
  PilotCandidates shape_;
  EngineType engine_;
  std::vector<double> picture_;
  Analysis first_, second_;            // of a pair of iterations
  std::vector<std::uint32_t> pixels_;  // those analysed
  std::vector<std::uint32_t> place_;   // of a pixel among them
  std::vector<float> earlier_;         // pictures of the iterations before the pair, added up
  std::uint32_t earlier_iterations_ = 0;
  CameraWork work_{{}, {}, PilotSplit<float>::mean_children};
  std::vector<double> variance_, within_;  // sums over pixels and iterations, by candidate
  std::vector<BiasSums> biases_;
  std::vector<double> missing_;
  double pixels_taken_ = 0.0, light_ = 0.0;
};

}  // namespace gmis
