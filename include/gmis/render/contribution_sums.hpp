#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/render/picture.hpp"
#include "gmis/transport/plan/class_costs.hpp"
#include "gmis/transport/state/path_output.hpp"
#include "gmis/transport/state/pixel_bounds.hpp"

/// \file
/// Sums of contributions over iterations, for a picture of each technique, of each path class and
/// of each group of lights.

namespace gmis {

namespace detail {

/// Adds values to a sum; an empty sum counts as zeros.
inline void add_values(std::vector<double>& sum, const std::vector<double>& values) {
  if (sum.empty()) sum.assign(values.size(), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) sum[i] += values[i];
}

/// Where contributions to the pixels of a frame go in sums over a crop.
class CropSums {
 public:
  CropSums(glm::ivec2 resolution, const PixelBounds& crop, int channels)
      : width_(resolution.x), crop_(crop), channels_(channels) {}

  [[nodiscard]] std::vector<double> zeros() const {
    const glm::ivec2 size = crop_.upper - crop_.lower;
    return std::vector<double>(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                               static_cast<std::size_t>(channels_));
  }
  /// Index of the first channel of a pixel, which is an index in the frame and lies in the crop.
  [[nodiscard]] std::size_t place_of(std::uint32_t pixel) const noexcept {
    const int x = static_cast<int>(pixel % static_cast<std::uint32_t>(width_)) - crop_.lower.x;
    const int y = static_cast<int>(pixel / static_cast<std::uint32_t>(width_)) - crop_.lower.y;
    return static_cast<std::size_t>(y * (crop_.upper.x - crop_.lower.x) + x) * static_cast<std::size_t>(channels_);
  }
  /// Adds a weighted contribution to a sum over the crop; an empty sum is filled with zeros first.
  template <Spectrum S>
  void add(std::vector<double>& sum, const Contribution<S>& contribution) const {
    if (sum.empty()) sum = zeros();
    const std::size_t first = place_of(contribution.pixel);
    for (int c = 0; c < channels_; ++c)
      sum[first + static_cast<std::size_t>(c)] +=
          static_cast<double>(SpectrumTraits<S>::channel(contribution.value, c) * contribution.weight);
  }
  [[nodiscard]] Picture mean_of(const std::vector<double>& sum, std::uint32_t iterations) const {
    Picture picture(crop_.upper - crop_.lower, channels_);
    for (std::size_t i = 0; i < sum.size(); ++i) picture.values[i] = static_cast<float>(sum[i] / iterations);
    return picture;
  }

 private:
  int width_;
  PixelBounds crop_;
  int channels_;
};

}  // namespace detail

/// Sums of the contributions of each technique, over all iterations.
template <Spectrum S>
class TechniqueSums {
 public:
  /// `resolution`: of the frame that contributions name pixels of.
  TechniqueSums(glm::ivec2 resolution, const PixelBounds& crop)
      : crop_(resolution, crop, SpectrumTraits<S>::channel_count) {}

  /// Adds one contribution to its picture.
  void add(const Contribution<S>& contribution) {
    const TechniqueId& id = contribution.id;
    Sums& sums = sums_[{static_cast<int>(id.technique), id.s, id.t}];
    if (sums.weighted.empty()) sums = {crop_.zeros(), crop_.zeros()};
    const std::size_t first = crop_.place_of(contribution.pixel);
    for (int c = 0; c < SpectrumTraits<S>::channel_count; ++c) {
      const ScalarOf<S> value = SpectrumTraits<S>::channel(contribution.value, c);
      sums.weighted[first + static_cast<std::size_t>(c)] += static_cast<double>(value * contribution.weight);
      sums.unweighted[first + static_cast<std::size_t>(c)] += static_cast<double>(value);
    }
  }

  /// Adds the sums of another run of the same size.
  void join(const TechniqueSums& other) {
    for (const auto& [key, sums] : other.sums_) {
      detail::add_values(sums_[key].weighted, sums.weighted);
      detail::add_values(sums_[key].unweighted, sums.unweighted);
    }
  }

  /// One entry per technique and path length that gave anything, ordered by technique, then by s
  /// and t.
  GMIS_RARE [[nodiscard]] std::vector<TechniquePicture> means(std::uint32_t iterations) const {
    std::vector<TechniquePicture> result;
    for (const auto& [key, sums] : sums_)
      result.push_back({{static_cast<Technique>(std::get<0>(key)), std::get<1>(key), std::get<2>(key)},
                        crop_.mean_of(sums.weighted, iterations),
                        crop_.mean_of(sums.unweighted, iterations)});
    return result;
  }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(sums_);
  }

 private:
  struct Sums {
    std::vector<double> weighted, unweighted;

    template <class Archive>
    void exchange_state(Archive& archive) {
      archive(weighted, unweighted);
    }
  };

  detail::CropSums crop_;
  std::map<std::tuple<int, std::int16_t, std::int16_t>, Sums> sums_;
};

/// Pictures of path classes.
struct ClassPictures {
  std::vector<ClassPicture> classes;  ///< one for each class that has contributed
  double unattributed_cost = 0.0;     ///< share of operations that led to no contribution
};

/// Sums of the contributions of each path class, over all iterations.
template <Spectrum S>
class ClassSums {
 public:
  /// `resolution`: of the frame that contributions name pixels of.
  ClassSums(glm::ivec2 resolution, const PixelBounds& crop)
      : crop_(resolution, crop, SpectrumTraits<S>::channel_count) {}

  /// Adds one contribution to its picture.
  void add(const Contribution<S>& contribution) {
    const auto number = static_cast<std::size_t>(contribution.id.path_class);
    if (number >= path_class_count) return;  // paths are not classified
    work_[number].add(contribution.id);
    crop_.add(sums_[number], contribution);
  }

  /// Adds the sums of another run of the same size.
  void join(const ClassSums& other) {
    for (std::size_t i = 0; i < path_class_count; ++i) {
      detail::add_values(sums_[i], other.sums_[i]);
      work_[i] += other.work_[i];
    }
  }

  /// The classes that had any contribution, in the order of their numbers. `work` and `light_work`
  /// as in `costs_of_classes`.
  GMIS_RARE [[nodiscard]] ClassPictures means(std::uint32_t iterations, const Counters& work,
                                              const Counters& light_work) const {
    const ClassCosts costs = costs_of_classes(work_, work, light_work);
    const double whole = cost_of(work);
    const auto share = [whole](double cost) { return whole > 0.0 ? cost / whole : 0.0; };
    ClassPictures result;
    result.unattributed_cost = share(costs.unattributed);
    for (std::size_t i = 0; i < path_class_count; ++i)
      if (!sums_[i].empty())
        result.classes.push_back({static_cast<PathClass>(i), crop_.mean_of(sums_[i], iterations), work_[i].total(),
                                  share(costs.classes[i])});
    return result;
  }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(sums_, work_);
  }

 private:
  detail::CropSums crop_;
  std::array<std::vector<double>, path_class_count> sums_;
  std::array<ClassWork, path_class_count> work_{};
};

/// Sums of the contributions of each group of lights, over all iterations.
template <Spectrum S>
class LightSums {
 public:
  /// `resolution`: of the frame that contributions name pixels of.
  LightSums(glm::ivec2 resolution, const PixelBounds& crop)
      : crop_(resolution, crop, SpectrumTraits<S>::channel_count) {}

  /// Adds one contribution to its picture.
  void add(const Contribution<S>& contribution) {
    const std::size_t group = contribution.id.light_group;
    if (group >= sums_.size()) sums_.resize(group + 1);
    crop_.add(sums_[group], contribution);
  }

  /// Adds the sums of another run of the same size.
  void join(const LightSums& other) {
    sums_.resize(std::max(sums_.size(), other.sums_.size()));
    for (std::size_t group = 0; group < other.sums_.size(); ++group)
      if (!other.sums_[group].empty()) detail::add_values(sums_[group], other.sums_[group]);
  }

  /// The groups that had any contribution, in the order of their numbers.
  GMIS_RARE [[nodiscard]] std::vector<LightPicture> means(std::uint32_t iterations) const {
    std::vector<LightPicture> result;
    for (std::size_t group = 0; group < sums_.size(); ++group)
      if (!sums_[group].empty())
        result.push_back({static_cast<std::uint16_t>(group), crop_.mean_of(sums_[group], iterations)});
    return result;
  }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(sums_);
  }

 private:
  detail::CropSums crop_;
  std::vector<std::vector<double>> sums_;  // by group; empty where nothing came
};

}  // namespace gmis
