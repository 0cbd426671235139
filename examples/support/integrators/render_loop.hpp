#pragma once

#include <array>
#include <chrono>
#include <ctime>
#include <map>
#include <memory>
#include <span>
#include <tuple>
#include <utility>

#include "gmis/transport/integrators.hpp"
#include "support/render.hpp"

/// \file
/// The progressive loop around the engine. Included by one source file per integrator.

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

/// Why to stop now; null to go on.
[[nodiscard]] inline const char* reason_to_stop(const RenderRequest& request, const Progress& progress) {
  // An error estimated from a few iterations is itself too uncertain to stop by.
  constexpr std::uint32_t fewest_for_error = 8;
  if (request.interrupted != nullptr && request.interrupted->load()) return "interrupt";
  if (request.iterations && progress.iterations >= *request.iterations) return "iterations";
  if (request.relative_error && progress.iterations >= fewest_for_error &&
      progress.relative_error <= *request.relative_error)
    return "error";
  // One more iteration must not end later than this one ends early.
  const double half_iteration = progress.seconds / progress.iterations / 2;
  if (request.seconds && progress.seconds + half_iteration >= *request.seconds) return "time";
  return nullptr;
}

template <class FilmType>
[[nodiscard]] Image image_of(const FilmType& film) {
  Image image(film.resolution().x, film.resolution().y);
  for (std::size_t pixel = 0; pixel < film.pixel_count(); ++pixel)
    for (int c = 0; c < 3; ++c)
      image.rgb[3 * pixel + static_cast<std::size_t>(c)] = static_cast<float>(film.mean(pixel, c));
  return image;
}

/// The engine records techniques only when asked to: one type for both halves the time to compile it.
template <class Integrator>
[[nodiscard]] RenderResult run_with(const BuiltScene& built, const RenderRequest& request, ThreadedExecutor& executor) {
  using SceneType = std::remove_cvref_t<decltype(built.scene())>;
  using S = typename SceneType::Spectrum;
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  const Clock::time_point start = Clock::now();
  const std::clock_t cpu_start = std::clock();

  const glm::ivec2 resolution = built.scene().camera().resolution();
  const PixelBounds crop = request.crop.value_or(PixelBounds{{0, 0}, resolution});
  const glm::ivec2 size = crop.upper - crop.lower;
  auto engine = std::make_unique<Engine<SceneType, Integrator, true>>(built.scene(), request.settings, crop);
  engine->keep_contributions(request.techniques);
  Film<S> film(size);
  std::vector<Film<S>> halves;
  if (request.halves) halves.assign(2, Film<S>(size));
  TechniqueSums techniques(resolution, crop);
  std::vector<S> part;
  double film_seconds = 0;

  RenderResult result;
  Progress progress;
  const char* reason = nullptr;
  executor.stop_when(nullptr);
  while (reason == nullptr) {
    engine->iterate(executor);
    if (executor.is_stopped()) {
      reason = "interrupt";  // this iteration is not whole
      break;
    }
    const Clock::time_point film_start = Clock::now();
    std::span<const S> frame = engine->frame();
    if (size != resolution) {
      part.clear();
      for (int y = crop.lower.y; y < crop.upper.y; ++y) {
        const auto row = frame.subspan(static_cast<std::size_t>(y) * static_cast<std::size_t>(resolution.x) +
                                           static_cast<std::size_t>(crop.lower.x),
                                       static_cast<std::size_t>(size.x));
        part.insert(part.end(), row.begin(), row.end());
      }
      frame = part;
    }
    film.add_iteration(frame);
    if (request.halves) halves[progress.iterations % 2].add_iteration(frame);
    if (request.techniques)
      engine->for_each_contribution([&](const Contribution<S>& contribution) { techniques.add(contribution); });
    ++progress.iterations;
    if (request.relative_error || request.on_iteration)
      progress.relative_error = progress.iterations > 1 ? estimate_of(film).relative_error : 0;
    film_seconds += seconds_since(film_start);
    progress.seconds = seconds_since(start);
    result.counters = engine->counters();  // of whole iterations only
    result.phases = engine->seconds();
    if (request.on_iteration) request.on_iteration(progress);
    reason = reason_to_stop(request, progress);
    executor.stop_when(request.interrupted);  // there is something to show from now on
  }
  executor.stop_when(nullptr);

  result.stopped_by = reason;
  result.iterations = progress.iterations;
  result.wall_seconds = seconds_since(start);
  result.cpu_seconds = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
  result.image = image_of(film);
  if (request.halves) {
    result.half_a = image_of(halves[0]);
    result.half_b = image_of(halves[1]);
  }
  if (request.techniques) result.techniques = techniques.means(progress.iterations);
  result.estimate = estimate_of(film);
  result.tuning = engine->tuning();
  result.trials = engine->tuner().trials();
  result.phases.film += film_seconds;
  result.photon_bytes = engine->photon_bytes();
  return result;
}

}  // namespace gmis::tools
