#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace gmis_test {

/// Means over square blocks of pixels, with the standard error that the spread between independent
/// frames gives.
class BlockStatistics {
 public:
  BlockStatistics(glm::ivec2 resolution, int block_size)
      : resolution_(resolution),
        block_size_(block_size),
        blocks_((resolution + glm::ivec2(block_size - 1)) / block_size),
        sum_(count()),
        squares_(count()) {}

  void add(std::span<const glm::vec3> frame) {
    const std::vector<double> means = block_means([&](int x, int y, int c) {
      return static_cast<double>(frame[static_cast<std::size_t>(y * resolution_.x + x)][c]);
    });
    ++frames_;
    for (std::size_t i = 0; i < means.size(); ++i) {
      sum_[i] += means[i];
      squares_[i] += means[i] * means[i];
    }
  }

  /// Blocks times three channels.
  [[nodiscard]] std::size_t count() const {
    return 3 * static_cast<std::size_t>(blocks_.x) * static_cast<std::size_t>(blocks_.y);
  }
  [[nodiscard]] double mean(std::size_t i) const { return sum_[i] / frames_; }
  [[nodiscard]] double standard_error(std::size_t i) const {
    return std::sqrt(std::max(0.0, squares_[i] / frames_ - mean(i) * mean(i)) / (frames_ - 1));
  }
  [[nodiscard]] double image_mean() const {
    double total = 0.0;
    for (std::size_t i = 0; i < count(); ++i) total += mean(i);
    return total / static_cast<double>(count());
  }
  [[nodiscard]] int frames() const { return static_cast<int>(frames_); }

  /// Block means of anything that gives `value(x, y, channel)`, y from the top.
  template <class Value>
  [[nodiscard]] std::vector<double> block_means(Value&& value) const {
    std::vector<double> means(count()), pixels(count());
    for (int y = 0; y < resolution_.y; ++y)
      for (int x = 0; x < resolution_.x; ++x)
        for (int c = 0; c < 3; ++c) {
          const auto i = static_cast<std::size_t>(3 * ((y / block_size_) * blocks_.x + x / block_size_) + c);
          means[i] += value(x, y, c);
          pixels[i] += 1.0;
        }
    for (std::size_t i = 0; i < means.size(); ++i) means[i] /= pixels[i];
    return means;
  }

 private:
  glm::ivec2 resolution_;
  int block_size_;
  glm::ivec2 blocks_;
  double frames_ = 0.0;
  std::vector<double> sum_, squares_;
};

}  // namespace gmis_test
