#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/transport/candidate.hpp"
#include "gmis/transport/engine.hpp"
#include "gmis/transport/integrators.hpp"

/// \file
/// Which counts pay in a scene, from one set of samples. A pilot renders with all techniques and keeps, for every
/// contribution, the path's density by each group of techniques; what any other counts would have given follows by
/// re-weighting [Grittmann et al. 2022, efficiency-aware MIS]. In an iteration a pixel is A + B: A what its camera
/// subpath makes, B the splats of independent light trees. With D(x) the expected density of all techniques together,
///     Var(A + B) = ∫ f²/D + E[Σ_{i≠j} A_i A_j] − E[A]²,
/// the sum over pairs of contributions of one camera subpath. Any technique's samples can estimate the integral, also
/// that of techniques which rarely find the path themselves: so the pilot sees a caustic's fireflies before they happen.

namespace gmis {

/// Paths are analysed in whole rows, not more of them than make `analysed_pixels`: the pilot's cost is bounded.
struct PilotGrid {
  static constexpr int tile_size = 8;
  static constexpr std::int64_t analysed_pixels = 1 << 16;

  PilotGrid() = default;
  explicit PilotGrid(glm::ivec2 resolution) : size_(resolution) {
    const auto pixels = static_cast<std::int64_t>(size_.x) * size_.y;
    row_step_ = static_cast<int>(std::max<std::int64_t>(1, (pixels + analysed_pixels - 1) / analysed_pixels));
    tiles_ = {(size_.x + tile_size - 1) / tile_size,
              ((size_.y + row_step_ - 1) / row_step_ + tile_size - 1) / tile_size};
  }
  [[nodiscard]] bool is_analysed(std::uint32_t pixel) const noexcept { return row(pixel) % row_step_ == 0; }
  [[nodiscard]] std::size_t tile(std::uint32_t pixel) const noexcept {
    const int x = static_cast<int>(pixel) % size_.x;
    return static_cast<std::size_t>(row(pixel) / row_step_ / tile_size * tiles_.x + x / tile_size);
  }
  [[nodiscard]] std::size_t tile_count() const noexcept { return static_cast<std::size_t>(tiles_.x * tiles_.y); }

 private:
  [[nodiscard]] int row(std::uint32_t pixel) const noexcept { return static_cast<int>(pixel) / size_.x; }

  glm::ivec2 size_{0, 0}, tiles_{0, 0};
  int row_step_ = 1;
};

/// The candidates as the loop over all of them wants them: a row for each group.
struct PilotCandidates {
  PilotGrid grid;
  std::size_t count = 0;
  PerGroup<std::vector<float>> factors;
  std::vector<float> pair_scale;  ///< of pairs of connections at one vertex: m draws have (m−1)/m of the mean's square
};

/// What a chunk of paths says of every candidate. Also an ordinary output: the pilot's picture is kept.
template <Spectrum S>
class PilotOutput : public ChunkOutput<S, false> {
 public:
  using T = ScalarOf<S>;
  using Base = ChunkOutput<S, false>;

  /// A path's contribution from the light side, to be taken in when all chunks are done.
  struct SplatRecord {
    std::uint32_t pixel;
    float value;
    GroupDensities<float> densities;
  };
  /// Of one analysed pixel.
  struct PixelRecord {
    std::uint32_t pixel;
    std::span<const float> mean;            ///< A, for each candidate
    std::span<const double> second_moment;  ///< ∫ f²/D and the pairs, for each candidate
  };

  /// Must outlive this.
  void analyse(const PilotCandidates* candidates) { candidates_ = candidates; }

  void clear() {
    Base::clear();
    pixels_.clear();
    means_.clear();
    second_moments_.clear();
    splat_records_.clear();
    is_analysing_ = false;
    missing.assign(candidates_ == nullptr ? 0 : candidates_->count, 0.0);
  }

  void begin_pixel(std::uint32_t pixel) {
    finish_pixel();
    Base::begin_pixel(pixel);
    is_analysing_ = candidates_ != nullptr && candidates_->grid.is_analysed(pixel);
    if (!is_analysing_) return;
    const std::size_t n = candidates_->count;
    pixels_.push_back(pixel);
    means_.resize(means_.size() + n, 0.0F);
    second_moments_.resize(second_moments_.size() + n, 0.0);
    squares_.assign(n, 0.0F);
    connect_sum_.assign(n, 0.0F);
    connect_squares_.assign(n, 0.0F);
  }

  void add(TechniqueId id, const S& value, const GroupDensities<T>& densities) {
    Base::add(id, value, densities.weight());
    if (!is_analysing_ || !is_finite(value)) return;
    const bool connects = id.technique == Technique::connect;
    if (connects && id.t != connecting_vertex_) finish_vertex();
    connecting_vertex_ = connects ? id.t : connecting_vertex_;
    float* const mean = latest_mean();
    double* const second = latest_second_moment();
    for_each_candidate(single(value), single(densities), missing, [&](std::size_t c, float own, float second_moment) {
      mean[c] += own;
      second[c] += static_cast<double>(second_moment);
      squares_[c] += own * own;
      if (!connects) return;
      connect_sum_[c] += own;
      connect_squares_[c] += own * own;
    });
  }

  void add_splat(std::uint32_t pixel, TechniqueId id, const S& value, const GroupDensities<T>& densities) {
    Base::add_splat(pixel, id, value, densities.weight());
    if (candidates_ != nullptr && candidates_->grid.is_analysed(pixel) && is_finite(value))
      splat_records_.push_back({pixel, single(value), single(densities)});
  }

  /// Call when the chunk is done.
  void finish_pixel() {
    if (!is_analysing_) return;
    finish_vertex();
    const float* const mean = latest_mean();
    double* const second = latest_second_moment();
    for (std::size_t c = 0; c < candidates_->count; ++c)  // pairs: the square of the sum without the squares
      second[c] += static_cast<double>(mean[c]) * static_cast<double>(mean[c]) - static_cast<double>(squares_[c]);
    is_analysing_ = false;
  }

  [[nodiscard]] std::size_t pixel_count() const noexcept { return pixels_.size(); }
  [[nodiscard]] PixelRecord pixel(std::size_t i) const noexcept {
    const std::size_t n = candidates_->count;
    return {pixels_[i], {means_.data() + i * n, n}, {second_moments_.data() + i * n, n}};
  }
  [[nodiscard]] std::span<const SplatRecord> splat_records() const noexcept { return splat_records_; }

  /// Calls `visit(candidate, weighted value, its part of ∫ f²/D)`; what a candidate cannot make is added to `missing`.
  template <class Visit>
  void for_each_candidate(float value, const GroupDensities<float>& densities, std::vector<double>& missing_light,
                          Visit&& visit) const {
    const float weight = densities.weight();
    const auto& f = candidates_->factors;
    const auto& r = densities.relative;
    const std::vector<float>& own = f[static_cast<std::size_t>(densities.own)];
    for (std::size_t c = 0; c < candidates_->count; ++c) {
      const float total = f[0][c] * r[0] + f[1][c] * r[1] + f[2][c] * r[2] + f[3][c] * r[3];
      if (total > 0.0F)
        visit(c, own[c] * value / total, weight * value * value / total);
      else
        missing_light[c] += static_cast<double>(weight * value);
    }
  }

  std::vector<double> missing;  ///< light in the analysed pixels that a candidate has no technique for

 private:
  [[nodiscard]] static float single(const S& value) noexcept { return static_cast<float>(mean_channel(value)); }
  /// Bounded, so that sums of products stay numbers.
  [[nodiscard]] static GroupDensities<float> single(const GroupDensities<T>& densities) noexcept {
    GroupDensities<float> result{densities.own, {}};
    for (std::size_t g = 0; g < technique_groups; ++g)
      result.relative[g] = static_cast<float>(std::min(densities.relative[g], T(1e30)));
    return result;
  }

  [[nodiscard]] float* latest_mean() noexcept { return means_.data() + means_.size() - candidates_->count; }
  [[nodiscard]] double* latest_second_moment() noexcept {
    return second_moments_.data() + second_moments_.size() - candidates_->count;
  }

  /// Pairs of connections of one vertex: with m draws instead of m₀ they have another share.
  void finish_vertex() {
    double* const second = latest_second_moment();
    for (std::size_t c = 0; c < candidates_->count; ++c) {
      const double pairs = static_cast<double>(connect_sum_[c]) * static_cast<double>(connect_sum_[c]) -
                           static_cast<double>(connect_squares_[c]);
      second[c] += pairs * static_cast<double>(candidates_->pair_scale[c] - 1.0F);
      connect_sum_[c] = 0.0F;
      connect_squares_[c] = 0.0F;
    }
  }

  const PilotCandidates* candidates_ = nullptr;
  std::vector<std::uint32_t> pixels_;
  std::vector<float> means_;
  std::vector<double> second_moments_;
  std::vector<SplatRecord> splat_records_;
  std::vector<float> squares_, connect_sum_, connect_squares_;
  std::int16_t connecting_vertex_ = -1;
  bool is_analysing_ = false;
};

/// `Base`, which connects and splats, with contributions that are kept with their densities by groups.
template <class Base>
struct PilotOf : Base {
  static_assert(Base::template has<Connect> && Base::template has<Splat> && !Base::Split::splits);
  template <std::floating_point T>
  using Recursion = WeightRecursion<T, BalanceRatio, GroupSums<T>>;
  template <Spectrum S, bool>
  using Output = PilotOutput<S>;
};

/// Renders with the techniques of `Base`, two iterations at least, and forecasts what every candidate would give.
template <Scene Sc, class Base = integrators::Vcm, class Source = Philox>
class RenderPilot {
 public:
  using S = typename Sc::Spectrum;

  /// What the pilot itself renders with: two connections, since pairs of them must be seen.
  static constexpr Candidate made{1.0, 2, true, Base::template has<Merge>};
  using EngineType = Engine<Sc, PilotOf<Base>, false, Source>;

  RenderPilot(const Sc& scene, RenderSettings settings, std::vector<Candidate> candidates,
              std::optional<PixelBounds> crop = std::nullopt)
      : candidates_(std::move(candidates)), engine_(scene, settings_of_pilot(settings), crop) {
    shape_.grid = PilotGrid(scene.camera().resolution());
    shape_.count = candidates_.size();
    for (const Candidate& candidate : candidates_) {
      const PerGroup<float> factors = count_factors<float>(candidate, made);
      for (std::size_t g = 0; g < technique_groups; ++g) shape_.factors[g].push_back(factors[g]);
      const auto m = static_cast<float>(candidate.connections);
      shape_.pair_scale.push_back(m > 0.0F ? 2.0F * (m - 1.0F) / m : 1.0F);
    }
    engine_.for_each_output([&](PilotOutput<S>& output) { output.analyse(&shape_); });
    variance_.assign(shape_.count, 0.0);
    squared_bias_.assign(shape_.count, 0.0);
    missing_.assign(shape_.count, 0.0);
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
    Analysis analysis = analyse();
    if (iterations() % 2 == 0)
      take_in(first_, analysis);
    else
      first_ = std::move(analysis);
  }

  /// One forecast a candidate, in their order, from the iterations so far; an odd one at the end is left out.
  [[nodiscard]] std::vector<Forecast> forecasts(const OperationCosts& costs = {}) const {
    const WorkBySide work{engine_.light_work(), engine_.counters() - engine_.light_work()};
    std::vector<Forecast> all(shape_.count);
    for (std::size_t c = 0; c < shape_.count; ++c) {
      Forecast& forecast = all[c];
      forecast.candidate = candidates_[c];
      if (!(pixels_ > 0.0)) continue;
      forecast.cost = predicted_cost(candidates_[c], made, work, costs) / static_cast<double>(iterations());
      forecast.variance = std::max(0.0, variance_[c] / pixels_);
      forecast.squared_bias = std::max(0.0, squared_bias_[c] / pixels_);
      forecast.missing_share = light_ > 0.0 ? missing_[c] / light_ : 0.0;
    }
    return all;
  }

 private:
  [[nodiscard]] static RenderSettings settings_of_pilot(RenderSettings settings) {
    settings.light_paths = made.light_paths;
    settings.connections = made.connections;
    settings.adapts_split = false;
    return settings;
  }

  /// The candidate with the same counts but no merging; itself where there is none.
  [[nodiscard]] std::size_t without_merging(std::size_t c) const noexcept {
    Candidate other = candidates_[c];
    if (!other.merges) return c;
    other.merges = false;
    const auto found = std::find(candidates_.begin(), candidates_.end(), other);
    return found == candidates_.end() ? c : static_cast<std::size_t>(found - candidates_.begin());
  }

  /// What one iteration says, by analysed pixel.
  struct Analysis {
    std::vector<std::uint32_t> pixels;
    std::vector<float> values;           ///< of the picture
    std::vector<float> means;            ///< A, by pixel and candidate
    std::vector<double> second_moments;  ///< the same, with the splats'
    std::vector<double> tile_sums;       ///< A + B, by candidate and tile
  };

  [[nodiscard]] Analysis analyse() {
    const PilotGrid& grid = shape_.grid;
    const std::size_t n = shape_.count;
    Analysis all;
    all.tile_sums.assign(n * grid.tile_count(), 0.0);
    place_.assign(engine_.frame().size(), 0);
    engine_.for_each_output([&](PilotOutput<S>& output) {
      output.finish_pixel();
      for (std::size_t c = 0; c < output.missing.size(); ++c) missing_[c] += output.missing[c];
      for (std::size_t i = 0; i < output.pixel_count(); ++i) {
        const auto record = output.pixel(i);
        const auto value = static_cast<float>(mean_channel(engine_.frame()[record.pixel]));
        place_[record.pixel] = static_cast<std::uint32_t>(all.pixels.size());
        all.pixels.push_back(record.pixel);
        all.values.push_back(value);
        all.means.insert(all.means.end(), record.mean.begin(), record.mean.end());
        all.second_moments.insert(all.second_moments.end(), record.second_moment.begin(), record.second_moment.end());
        light_ += static_cast<double>(value);
        double* const sums = all.tile_sums.data() + n * grid.tile(record.pixel);
        for (std::size_t c = 0; c < n; ++c) sums[c] += static_cast<double>(record.mean[c]);
      }
    });
    engine_.for_each_output([&](PilotOutput<S>& output) {
      for (const auto& splat : output.splat_records()) {
        double* const sums = all.tile_sums.data() + n * grid.tile(splat.pixel);
        double* const second_moments = all.second_moments.data() + n * place_[splat.pixel];
        output.for_each_candidate(splat.value, splat.densities, missing_,
                                  [&](std::size_t c, float own, float second_moment) {
                                    sums[c] += static_cast<double>(own);
                                    second_moments[c] += static_cast<double>(second_moment);
                                  });
      }
    });
    return all;
  }

  /// Two iterations that know nothing of each other: the product of what they say has the square for its mean.
  void take_in(const Analysis& a, const Analysis& b) {
    const std::size_t n = shape_.count, tiles = shape_.grid.tile_count();
    std::vector<double> tile_mean(tiles, 0.0), tile_pixels(tiles, 0.0);
    double mean_square = 0.0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      const std::size_t tile = shape_.grid.tile(a.pixels[i]);
      tile_mean[tile] += 0.5 * static_cast<double>(a.values[i] + b.values[i]);
      tile_pixels[tile] += 1.0;
    }
    for (std::size_t t = 0; t < tiles; ++t) {
      if (tile_pixels[t] > 0.0) tile_mean[t] /= tile_pixels[t];
      mean_square += square(tile_mean[t]) * tile_pixels[t];
    }
    mean_square /= static_cast<double>(std::max<std::size_t>(1, a.pixels.size()));
    if (!(mean_square > 0.0)) return;

    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      const double tile = tile_mean[shape_.grid.tile(a.pixels[i])];
      const double value = 0.5 * static_cast<double>(a.values[i] + b.values[i]);
      // The picture so far is noisy, its tile's mean blurs it: something between the two.
      const double value_squared =
          picture_.empty() ? tile * std::max(value, 0.1 * tile) : square(picture_[a.pixels[i]]);
      const double scale = 1.0 / (value_squared + 0.01 * mean_square);
      for (std::size_t c = 0; c < n; ++c)
        variance_[c] += scale * (0.5 * (a.second_moments[i * n + c] + b.second_moments[i * n + c]) -
                                 static_cast<double>(a.means[i * n + c]) * static_cast<double>(b.means[i * n + c]));
    }
    for (std::size_t c = 0; c < n; ++c) {
      const std::size_t without = without_merging(c);
      if (without == c) continue;
      for (std::size_t t = 0; t < tiles; ++t) {
        if (!(tile_pixels[t] > 0.0)) continue;
        const double first = a.tile_sums[t * n + c] - a.tile_sums[t * n + without];
        const double second = b.tile_sums[t * n + c] - b.tile_sums[t * n + without];
        squared_bias_[c] += first * second / tile_pixels[t] / (square(tile_mean[t]) + 0.01 * mean_square);
      }
    }
    pixels_ += static_cast<double>(a.pixels.size());
  }

  std::vector<Candidate> candidates_;
  PilotCandidates shape_;
  EngineType engine_;
  std::vector<double> picture_;
  Analysis first_;                    // of a pair of iterations
  std::vector<std::uint32_t> place_;  // of a pixel among those analysed
  // Sums over pixels and pairs of iterations, by candidate.
  std::vector<double> variance_, squared_bias_, missing_;
  double pixels_ = 0.0, light_ = 0.0;
};

}  // namespace gmis
