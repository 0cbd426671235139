#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/math.hpp"
#include "gmis/render/contribution_sums.hpp"
#include "gmis/render/expected_law.hpp"
#include "gmis/render/iteration_result.hpp"
#include "gmis/render/merging_gain.hpp"
#include "gmis/render/pixel_sums.hpp"
#include "gmis/render/render_request.hpp"
#include "gmis/render/render_result.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/result/sobol_gain.hpp"

namespace gmis {

/// The part of a frame that a request asks for, inside the frame.
[[nodiscard]] inline PixelBounds crop_of(const RenderRequest& request, glm::ivec2 resolution) {
  PixelBounds part = request.crop.value_or(PixelBounds{{0, 0}, resolution});
  part.lower = glm::clamp(part.lower, glm::ivec2(0), glm::max(resolution, glm::ivec2(0)));
  part.upper = glm::clamp(part.upper, part.lower, glm::max(resolution, part.lower));
  return part;
}

/// All that a run has made so far and that its result is made from: sums over iterations, and what
/// they took. It needs no scene and no engine, so that runs can be joined without either.
template <Spectrum S>
struct RunRecord : PixelSums<S>, RunFacts {
  using PixelSums<S>::film, PixelSums<S>::halves, PixelSums<S>::batches, PixelSums<S>::merging;

  TechniqueSums<S> techniques;         ///< empty sums unless they are asked for
  ClassSums<S> classes;                ///< empty sums unless they are asked for
  LightSums<S> by_light;               ///< empty sums unless they are asked for
  MergingGain gain;                    ///< what makes up for the bias of the mean
  double disks = 0.0;                  ///< sum of the squared merging radii of all iterations, in scene units
  ConvergenceLog log;                  ///< error and time so far
  RunState state;                      ///< iterations and wall time so far
  Counters light_work;                 ///< the part of `counters` that light trees took
  double film_seconds = 0.0;           ///< wall time of sums over iterations
  RunPart part;                        ///< with `kept`: which iterations these are
  std::vector<KeptIteration<S>> kept;  ///< the iterations of a part of a run, else empty
  ErrorLaw expected_law;               ///< as known before the run

  /// A record without iterations, for the run of a request. `resolution`: of the camera.
  RunRecord(const RenderRequest& request, glm::ivec2 resolution)
      : RunRecord(request, resolution, crop_of(request, resolution)) {}
  /// A record without iterations, of the pixels in `bounds` alone.
  RunRecord(const RenderRequest& request, glm::ivec2 resolution, const PixelBounds& bounds)
      : PixelSums<S>(request, bounds.upper - bounds.lower),
        techniques(resolution, bounds),
        classes(resolution, bounds),
        by_light(resolution, bounds) {}

  /// Adds an iteration that had this merging radius and gain. `pixel_count`: of the whole picture.
  void add(const IterationResult<S>& iteration, std::size_t pixel_count, double radius_of_disk,
           double gain_per_radius) {
    ++state.iterations;
    this->add_iteration(state.iterations, iteration.frame, iteration.merging_change,
                        1.0 + gain_per_radius * radius_of_disk);
    disks += square(radius_of_disk);
    gain.add_iteration(iteration.merged_light / static_cast<double>(std::max<std::size_t>(1, pixel_count)),
                       radius_of_disk);
    cpu_seconds += iteration.cpu_seconds;
  }

  /// The state for a later run (`core/state_archive.hpp`). A reading record must be made for the
  /// same request.
  template <class Archive>
  void exchange_state(Archive& archive) {
    PixelSums<S>::exchange_state(archive);
    archive(techniques, classes, by_light, log, state, cpu_seconds, counters, light_work, rejected_paths, phases,
            film_seconds, counts, choice, lights, forecast, expected_law, gain, disks, radius, photon_bytes, part,
            kept);
  }

  /// The estimated error of the picture, from the second iteration on.
  [[nodiscard]] std::optional<ErrorEstimate> error() const {
    if (!batches) return {};
    return estimate_error(*batches);
  }

  /// The record so far as a point of the log. `estimate`: `error()`, which takes long to compute.
  GMIS_RARE [[nodiscard]] ConvergencePoint point(const RenderRequest& request,
                                                 const std::optional<ErrorEstimate>& estimate) const {
    ConvergencePoint point{cpu_seconds, state.seconds, state.iterations, {}, {}, {}};
    if (estimate) {
      point.estimated_error = estimate->relative_error;
      if (estimate->is_calibrated()) point.interval = estimate->interval;
    }
    if (!request.reference.empty()) {
      const Picture shown = picture_of(film);
      point.reference_error = std::sqrt(
          image_error(std::span<const float>(shown.values), request.reference, Film<S>::channel_count).relmse);
    }
    return point;
  }

  /// Takes in a run of the same request with another seed. Pictures become means over all
  /// iterations; counts and times are added up. Log, choice and sample counts are those of the
  /// longer run. Names of rejected paths are dropped: they mean something only together with their
  /// run's seed.
  void join(const RunRecord& other) {
    merging.join(other.merging);
    gain.join(other.gain);
    disks += other.disks;
    film.join(other.film);
    for (std::size_t i = 0; i < halves.size(); ++i) halves[i].join(other.halves[i]);
    if (batches) batches->join(*other.batches);
    techniques.join(other.techniques);
    classes.join(other.classes);
    by_light.join(other.by_light);
    double pilot_cost = 0.0;
    std::uint32_t pilot_iterations = 0;
    for (const std::optional<Choice>* one : std::array<const std::optional<Choice>*, 2>{&choice, &other.choice})
      if (*one) pilot_cost += (*one)->pilot_cost, pilot_iterations += (*one)->pilot_iterations;
    const auto last_of = [](const ConvergenceLog& points) {
      return points.points().empty() ? 0 : points.points().back().iteration;
    };
    if (last_of(other.log) > last_of(log)) {
      log = other.log;
      counts = other.counts;
      choice = other.choice;
      lights = other.lights;
      forecast = other.forecast;
      expected_law = other.expected_law;
      radius = other.radius;
    }
    if (choice) choice->pilot_cost = pilot_cost, choice->pilot_iterations = pilot_iterations;
    state.iterations += other.state.iterations;
    state.seconds += other.state.seconds;
    cpu_seconds += other.cpu_seconds;
    counters += other.counters;
    light_work += other.light_work;
    rejected_paths.clear();
    phases += other.phases;
    film_seconds += other.film_seconds;
    photon_bytes = std::max(photon_bytes, other.photon_bytes);
  }

  /// `variances_of_means` of these pixels where iterations depend on each other (`Sampler::sobol`):
  /// the film takes them for independent. Else empty.
  [[nodiscard]] std::vector<double> variances(const RenderRequest& request) const {
    if (request.settings.sampler != Sampler::sobol || !batches) return {};
    return variances_of_means(*batches);
  }

  /// The result of a run that ended for this reason. `estimate`, `variances`: `error()` and
  /// `variances()` of the whole picture, which take long to compute.
  GMIS_RARE [[nodiscard]] RenderResult result(const RenderRequest& request, StopReason reason,
                                              const std::optional<ErrorEstimate>& estimate,
                                              std::span<const double> variances) const {
    RenderResult result;
    static_cast<RunFacts&>(result) = *this;
    result.stopped_by = reason;
    result.iterations = state.iterations;
    result.wall_seconds = state.seconds;
    result.phases.film += film_seconds;
    result.picture = picture_of(film);
    if (request.halves) {
      result.half_a = picture_of(halves[0]);
      result.half_b = picture_of(halves[1]);
    }
    if (request.techniques) result.techniques = techniques.means(state.iterations);
    if (request.class_pictures) result.classes = classes.means(state.iterations, counters, light_work);
    if (request.light_pictures) result.by_light = by_light.means(state.iterations);
    if (film.pixel_count() > 0) result.estimate = estimate_of(film);
    if (request.settings.sampler == Sampler::sobol) {
      result.estimate.variance = std::numeric_limits<double>::quiet_NaN();
      if (!variances.empty()) {
        result.estimate.variance =
            std::accumulate(variances.begin(), variances.end(), 0.0) / static_cast<double>(variances.size());
        result.variance = picture_with(film, [next = variances.begin()](std::size_t, int) mutable { return *next++; });
      }
    } else if (film.iterations() > 1) {
      result.variance = variance_picture_of(film);
    }
    result.error = estimate;
    result.prices = prices(estimate, variances);
    result.merging_bias = merging_bias();
    result.log = log.points();
    result.is_trustworthy = !request.rejection_limit.is_exceeded(counters);
    return result;
  }

  /// The bias of merging, for `RenderSummary`.
  GMIS_RARE [[nodiscard]] std::optional<MergingBias> merging_bias() const {
    if (!merging.is_known()) return std::nullopt;
    MergingBias bias = merging.bias_of(film);
    if (gain.made_up() != 0.0) {
      bias.made_up = gain.made_up() / static_cast<double>(film.iterations()) / estimate_of(film).mean;
      bias.of_mean += bias.made_up;
    }
    return bias;
  }

  /// `expected_law` with the evenness that the iterations have shown; the usual one counts as much
  /// as 16 of them.
  GMIS_RARE [[nodiscard]] ErrorLaw law_so_far(std::span<const double> variances) const {
    ErrorLaw law = expected_law;
    // Runs that are joined show nothing: their parts are not replications.
    if (!batches || !batches->has_equal_batches() || !(law.evenness > 0.0)) return law;
    if (const std::optional<double> measured = measured_evenness(film, variances)) {
      const double trust = static_cast<double>(film.iterations()) / (static_cast<double>(film.iterations()) + 16.0);
      law.evenness += trust * (*measured - law.evenness);
    }
    return law;
  }

  /// The prices of the usual errors, and of half the present one.
  GMIS_RARE [[nodiscard]] std::optional<PriceTable> prices(const std::optional<ErrorEstimate>& present,
                                                           std::span<const double> variances) const {
    if (!present) return {};
    std::vector<double> errors(PriceTable::usual_errors.begin(), PriceTable::usual_errors.end());
    errors.push_back(present->relative_error / 2.0);
    return price_table(log.points(), errors, law_so_far(variances));
  }
};

}  // namespace gmis
