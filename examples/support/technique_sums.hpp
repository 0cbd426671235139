#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "support/render.hpp"

namespace gmis::tools {

/// Sums of what each technique gave, over all iterations.
class TechniqueSums {
 public:
  TechniqueSums(glm::ivec2 resolution, PixelBounds crop) : resolution_(resolution), crop_(crop) {}

  template <class S>
  void add(const Contribution<S>& contribution) {
    Images& images = images_of(contribution.id);
    for (int c = 0; c < 3; ++c) {
      const std::size_t i = 3 * static_cast<std::size_t>(contribution.pixel) + static_cast<std::size_t>(c);
      images.weighted[i] += static_cast<double>(contribution.value[c] * contribution.weight);
      images.unweighted[i] += static_cast<double>(contribution.value[c]);
    }
  }

  [[nodiscard]] std::vector<TechniqueImage> means(std::uint32_t iterations) const {
    std::vector<TechniqueImage> result;
    for (const auto& [key, images] : images_)
      result.push_back({{static_cast<Technique>(std::get<0>(key)), std::get<1>(key), std::get<2>(key)},
                        mean_of(images.weighted, iterations),
                        mean_of(images.unweighted, iterations)});
    return result;
  }

 private:
  struct Images {
    std::vector<double> weighted, unweighted;
  };

  [[nodiscard]] Images& images_of(const TechniqueId& id) {
    Images& images = images_[{static_cast<int>(id.technique), id.s, id.t}];
    if (images.weighted.empty()) {
      const auto size = 3 * static_cast<std::size_t>(resolution_.x) * static_cast<std::size_t>(resolution_.y);
      images = {std::vector<double>(size), std::vector<double>(size)};
    }
    return images;
  }

  [[nodiscard]] Image mean_of(const std::vector<double>& sum, std::uint32_t iterations) const {
    Image image(resolution_.x, resolution_.y);
    for (std::size_t i = 0; i < sum.size(); ++i) image.rgb[i] = static_cast<float>(sum[i] / iterations);
    return cropped(image, crop_.lower.x, crop_.lower.y, crop_.upper.x, crop_.upper.y);
  }

  glm::ivec2 resolution_;
  PixelBounds crop_;
  std::map<std::tuple<int, std::int16_t, std::int16_t>, Images> images_;
};

}  // namespace gmis::tools
