#pragma once

#include <cstddef>
#include <vector>

#include "gmis/core/spectrum.hpp"
#include "gmis/result/image_error.hpp"
#include "support/series.hpp"

namespace gmis_test {

/// The variance of one iteration, relative as relMSE is, in the mean over pixels; and the relative
/// standard error of that.
struct RelativeVariance {
  double value = 0, relative_error = 0;
};

/// The variance of every pixel of an iteration, of the mean over channels, in batches: how far
/// these are apart says how well it is known.
class MeasuredVariance {
 public:
  /// `next_frame()` renders one more iteration and returns its picture.
  template <class NextFrame>
  MeasuredVariance(std::size_t batches, int iterations, NextFrame&& next_frame) : variance_(batches) {
    for (auto& variance : variance_) {
      std::vector<double> mean;
      for (int i = 1; i <= iterations; ++i) {
        const auto frame = next_frame();
        mean.resize(frame.size());
        variance.resize(frame.size());
        for (std::size_t p = 0; p < frame.size(); ++p) {
          const double value = static_cast<double>(gmis::mean_channel(frame[p]));
          const double before = value - mean[p];
          mean[p] += before / i;
          variance[p] += before * (value - mean[p]) / (iterations - 1);
        }
      }
      mean_.resize(mean.size());
      for (std::size_t p = 0; p < mean.size(); ++p) mean_[p] += mean[p] / static_cast<double>(batches);
    }
  }

  [[nodiscard]] const std::vector<double>& mean() const { return mean_; }
  [[nodiscard]] RelativeVariance relative_to(const std::vector<double>& truth) const {
    Series batches;
    for (const auto& variance : variance_) {
      double relative = 0;
      for (std::size_t p = 0; p < truth.size(); ++p)
        relative +=
            variance[p] / (truth[p] * truth[p] + gmis::relative_error_floor) / static_cast<double>(truth.size());
      batches.add(relative);
    }
    return {batches.mean(), batches.standard_error() / batches.mean()};
  }

 private:
  std::vector<std::vector<double>> variance_;
  std::vector<double> mean_;
};

}  // namespace gmis_test
