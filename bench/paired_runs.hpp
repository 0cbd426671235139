#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <vector>

#include "gmis/transport/engine/engine.hpp"

/// \file
/// Two ways to render the same scene, one iteration after the other: variance, time and mean of
/// each.

namespace gmis_bench {

/// Processor seconds of this thread.
inline double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// One way to render, iteration by iteration.
template <class Engine, class Scene_>
class Run {
 public:
  Run(const Scene_& scene, const gmis::RenderSettings& settings) : engine_(scene, settings) {}
  void iterate() {
    const double start = processor_seconds();
    engine_.iterate(executor_);
    seconds_ += processor_seconds() - start;
    ++count_;
    double total = 0;
    for (const auto& pixel : engine_.frame()) total += static_cast<double>(gmis::mean_channel(pixel));
    total_ += total, total_squares_ += total * total;
    sums_.resize(3 * engine_.frame().size());
    squares_.resize(sums_.size());
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const auto value = static_cast<double>(engine_.frame()[i / 3][static_cast<int>(i % 3)]);
      sums_[i] += value;
      squares_[i] += value * value;
    }
  }
  [[nodiscard]] double seconds() const { return seconds_ / count_; }
  [[nodiscard]] double mean(std::size_t i) const { return sums_[i] / count_; }
  [[nodiscard]] double total() const { return total_ / count_; }
  [[nodiscard]] double total_error() const {
    return std::sqrt(std::max(0.0, total_squares_ / count_ - total() * total()) / (count_ - 1));
  }
  [[nodiscard]] std::size_t size() const { return sums_.size(); }
  /// The variance of one iteration at each pixel and channel, relative to `mean`² + 0.01.
  template <class Mean>
  [[nodiscard]] std::vector<double> relative_variances(const Mean& mean_of) const {
    std::vector<double> result(sums_.size());
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = (squares_[i] / count_ - mean(i) * mean(i)) * count_ / (count_ - 1) / (mean_of(i) * mean_of(i) + 0.01);
    return result;
  }

 private:
  Engine engine_;
  gmis::SerialExecutor executor_;
  double seconds_ = 0, count_ = 0, total_ = 0, total_squares_ = 0;
  std::vector<double> sums_, squares_;
};

/// The mean of all values but the largest thousandth, and of all.
inline std::array<double, 2> trimmed_and_whole(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t kept = values.size() - values.size() / 1000;
  double sum = 0, rest = 0;
  for (std::size_t i = 0; i < values.size(); ++i) (i < kept ? sum : rest) += values[i];
  return {sum / static_cast<double>(kept), (sum + rest) / static_cast<double>(values.size())};
}

/// The variances and times of two ways to render one picture. An array holds two means over the
/// values: without the largest thousandth, and over all of them.
struct Comparison {
  std::array<double, 2> before{}, after{};  ///< relative variance of one iteration, of the plain way and of the other
  double plain_seconds = 0, other_seconds = 0;  ///< of one iteration
  double ratio = 0, ratio_error = 0;            ///< of the means, other over plain

  /// Time of the other way over that of the plain one, `training` seconds spread over all
  /// iterations.
  [[nodiscard]] double cost(double training, int iterations) const {
    return (other_seconds + training / iterations) / plain_seconds;
  }
};

/// Renders both scenes, which show the same, in turns and with different seeds.
template <template <class> class Engine, class Plain, class Other>
Comparison compare(const Plain& plain_scene, const Other& other_scene, const gmis::SampleCounts& counts,
                   int iterations) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 10;
  Run<Engine<Plain>, Plain> plain(plain_scene, settings);
  settings.seed = 1;
  Run<Engine<Other>, Other> other(other_scene, settings);
  for (int i = 0; i < iterations; ++i) {
    plain.iterate();
    other.iterate();
  }
  const auto mean = [&](std::size_t i) { return (plain.mean(i) + other.mean(i)) / 2; };
  return {trimmed_and_whole(plain.relative_variances(mean)),
          trimmed_and_whole(other.relative_variances(mean)),
          plain.seconds(),
          other.seconds(),
          other.total() / plain.total(),
          std::hypot(other.total_error(), plain.total_error()) / plain.total()};
}

template <class S>
using TwoSides = gmis::Engine<S>;
template <class S>
using OneSide = gmis::PathTracer<S>;

}  // namespace gmis_bench
