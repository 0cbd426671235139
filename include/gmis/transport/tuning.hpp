#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/spectrum.hpp"
#include "gmis/transport/children.hpp"
#include "gmis/transport/operation_costs.hpp"
#include "gmis/transport/settings.hpp"

/// \file
/// Counts that follow measured efficiency. The first iterations of a run try the candidates, one after the other; each of
/// them is unbiased by itself with the counts it was made with, so nothing is thrown away. Then the counts stay as they
/// are. What an iteration costs is counted, not timed: the same seed gives the same choice on every machine.

namespace gmis {

/// The counts that may be chosen.
struct Tuning {
  int connections = paired_connections;                        ///< light vertices from the cache per camera vertex
  int camera_children = 1;                                     ///< of the first non-specular camera vertex
  std::array<std::int16_t, split_kinds> light_children = [] {  ///< of a light vertex, by its kind
    std::array<std::int16_t, split_kinds> ones{};
    ones.fill(1);
    return ones;
  }();
};

/// The counts before anything was measured: as `settings` say, and 1 for what is to be measured. Without measuring, a
/// vertex with N lobes has M = kN children.
[[nodiscard]] inline Tuning initial_tuning(const RenderSettings& settings) noexcept {
  Tuning tuning;
  tuning.connections = settings.connections == measured_connections ? 1 : std::max(0, settings.connections);
  if (settings.adapts_split) return tuning;
  tuning.camera_children = std::max(1, settings.camera_children);
  for (std::size_t kind = 1; kind < tuning.light_children.size(); ++kind)
    tuning.light_children[kind] =
        static_cast<std::int16_t>(std::clamp(settings.rounds, 1, 1024) * static_cast<int>(kind));
  return tuning;
}

/// What one candidate was measured at.
struct Trial {
  Tuning tuning;
  double variance = 0.0;  ///< of one iteration, relative to the squared values (as relMSE), the worst pixels left out
  double cost = 0.0;      ///< counted operations of one iteration, in the unit of `OperationCosts`
  [[nodiscard]] double work() const noexcept { return variance * cost; }
};

/// Chooses a tuning, one count after the other. Each candidate has two iterations, arranged so that all candidates of
/// one count stand at the same mean place in the sequence (first, second, …, second, first), since the merging radius
/// shrinks meanwhile.
template <Spectrum S>
class Tuner {
 public:
  using T = ScalarOf<S>;

  Tuner() = default;
  /// `connects` and `splits`: whether the integrator has these counts at all.
  Tuner(const RenderSettings& settings, bool connects, bool splits) : best_(initial_tuning(settings)) {
    if (connects && settings.connections == measured_connections)
      counts_.push_back([](Tuning& tuning, int value) { tuning.connections = value; });
    if (!splits || !settings.adapts_split) return;
    counts_.push_back([](Tuning& tuning, int value) { tuning.camera_children = value; });
    counts_.push_back([](Tuning& tuning, int value) { tuning.light_children[1] = static_cast<std::int16_t>(value); });
    counts_.push_back([](Tuning& tuning, int value) {
      for (std::size_t kind = 2; kind < tuning.light_children.size(); ++kind)
        tuning.light_children[kind] = static_cast<std::int16_t>(value == 1 ? 1 : value / 2 * static_cast<int>(kind));
    });
  }

  [[nodiscard]] bool is_settled() const noexcept { return next_count_ == counts_.size(); }

  /// What the next iteration is to be made with.
  [[nodiscard]] Tuning current() const {
    Tuning tuning = best_;
    if (!is_settled()) counts_[next_count_](tuning, values[candidate_at(frames_.size())]);
    return tuning;
  }

  /// Takes in the iteration that was made with `current()`: its image and what it took.
  void report(std::span<const S> frame, const Counters& work) {
    if (is_settled()) return;
    cost_[candidate_at(frames_.size())] += 0.5 * cost_of(work);
    frames_.emplace_back(frame.begin(), frame.end());
    if (frames_.size() < 2 * values.size()) return;
    choose();
    frames_.clear();
    cost_ = {};
    ++next_count_;
    if (is_settled()) frames_.shrink_to_fit();
  }

  /// Everything that was tried, in order.
  [[nodiscard]] const std::vector<Trial>& trials() const noexcept { return trials_; }

 private:
  static constexpr std::array<int, 3> values{1, 2, 4};
  /// A candidate must be better than the fewest by more than its two iterations can tell by chance.
  static constexpr double least_gain = 0.05;

  [[nodiscard]] static std::size_t candidate_at(std::size_t turn) noexcept {
    return turn < values.size() ? turn : 2 * values.size() - 1 - turn;
  }

  void choose() {
    const std::vector<double> scale = squared_scale();
    std::array<double, values.size()> work{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      Trial trial{best_, variance_between(frames_[i], frames_[2 * values.size() - 1 - i], scale), cost_[i]};
      counts_[next_count_](trial.tuning, values[i]);
      work[i] = trial.work();
      trials_.push_back(trial);
    }
    std::size_t chosen = 0;
    for (std::size_t i = 1; i < values.size(); ++i)
      if (work[i] < work[chosen] && work[i] < (1.0 - least_gain) * work[0]) chosen = i;
    counts_[next_count_](best_, values[chosen]);
  }

  [[nodiscard]] static double value_of(const S& s) noexcept { return static_cast<double>(mean_channel(s)); }

  /// Per pixel, what a squared error is to be divided by: the squared value, and a hundredth of its mean so that dark
  /// pixels do not rule.
  [[nodiscard]] std::vector<double> squared_scale() const {
    std::vector<double> scale(frames_[0].size(), 0.0);
    for (const std::vector<S>& frame : frames_)
      for (std::size_t i = 0; i < frame.size(); ++i) scale[i] += value_of(frame[i]);
    double mean_square = 0.0;
    for (double& value : scale) {
      value /= static_cast<double>(frames_.size());
      value *= value;
      mean_square += value;
    }
    mean_square /= static_cast<double>(std::max<std::size_t>(1, scale.size()));
    for (double& value : scale) value += 0.01 * mean_square;
    return scale;
  }

  /// (a − b)²/2 has the variance of one frame for its mean. The worst thousandth is left out: fireflies would decide.
  [[nodiscard]] static double variance_between(const std::vector<S>& a, const std::vector<S>& b,
                                               const std::vector<double>& scale) {
    std::vector<double> squares;
    squares.reserve(a.size());
    for (std::size_t i = 0; i < a.size(); ++i)
      if (scale[i] > 0.0) {
        const double difference = value_of(a[i]) - value_of(b[i]);
        squares.push_back(0.5 * difference * difference / scale[i]);
      }
    if (squares.empty()) return 0.0;
    const std::size_t kept = squares.size() - squares.size() / 1000;
    std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(kept) - 1, squares.end());
    double sum = 0.0;
    for (std::size_t i = 0; i < kept; ++i) sum += squares[i];
    return sum / static_cast<double>(kept);
  }

  Tuning best_;
  std::vector<void (*)(Tuning&, int)> counts_;  // those still to choose and those chosen
  std::size_t next_count_ = 0;
  std::vector<std::vector<S>> frames_;
  std::array<double, values.size()> cost_{};
  std::vector<Trial> trials_;
};

}  // namespace gmis
