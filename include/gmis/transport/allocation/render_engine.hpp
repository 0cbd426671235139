#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/transport/allocation/choice.hpp"
#include "gmis/transport/allocation/engine_maker.hpp"

namespace gmis {

/// Number of pilot iterations for a run of this length: 2 to 16, an even number because forecasts
/// use pairs. A pixel costs a pilot about three times what it costs with the chosen counts; the
/// pilot takes some of them (`PilotGrid`).
[[nodiscard]] constexpr std::uint32_t pilot_iterations_for(std::uint32_t expected_iterations) noexcept {
  return 2 * std::clamp(expected_iterations / 100U, 1U, 8U);
}

/// The engine of a run, chosen at run time. With several candidates for the counts, the first
/// iteration is preceded by a pilot, which renders some of the pixels for itself; the run then uses
/// the best candidate. The choice is made once, from the pilot alone: counts do not depend on
/// samples of the picture.
template <Spectrum S>
class RenderEngine {
 public:
  /// Chooses among `candidates` for a run of `expected_iterations`. The pilot renders with the
  /// techniques of `settings.counts`; every technique of the candidates must be on there, and so
  /// must connections and splats. With one candidate the run uses its counts, without a pilot; with
  /// none it uses `settings.counts`.
  GMIS_RARE RenderEngine(EngineMaker<S> maker, const RenderSettings& settings,
                         std::vector<SampleCounts> candidates = {}, std::uint32_t expected_iterations = 0,
                         const std::optional<PixelBounds>& crop = std::nullopt);

  /// Renders one more iteration, after a pilot where there is one.
  void iterate(ExecutorRef executor) {
    prepare(executor);
    engine_->iterate(executor);
  }
  /// Runs the pilot where there is one that has not run: the engine of the picture is then known.
  void prepare(ExecutorRef executor) {
    if (pilot_) choose(executor);
  }

  /// The engine of the picture; that of the pilot before the first iteration of a run that has a
  /// pilot.
  [[nodiscard]] const AnyEngine<S>& engine() const noexcept { return pilot_ ? pilot_->engine() : *engine_; }
  /// The engine of the picture; null before the first iteration of a run that has a pilot.
  [[nodiscard]] AnyEngine<S>* picture_engine() noexcept { return engine_.get(); }
  /// The choice of the pilot; null before the first iteration and in a run without a pilot.
  [[nodiscard]] const Choice* choice() const noexcept { return choice_ && !pilot_ ? &*choice_ : nullptr; }

  /// Counted work since the start, the pilot included. Contributions and rejections are those of
  /// the picture.
  [[nodiscard]] Counters counters() const { return Counters(of_pilot_.counters) += engine().counters(); }
  /// The part of `counters()` that light trees took.
  [[nodiscard]] Counters light_work() const { return Counters(of_pilot_.light_work) += engine().light_work(); }
  /// Seconds per phase since the start, the pilot included.
  [[nodiscard]] PhaseSeconds seconds() const { return PhaseSeconds(of_pilot_.seconds) += engine().seconds(); }

  /// Sets whether the engine of the picture keeps contributions.
  void keep_contributions(bool keep) {
    keeps_contributions_ = keep;
    if (engine_) engine_->keep_contributions(keep);
  }

  /// The state for a later run (`core/state_archive.hpp`), between two iterations. A reading engine
  /// must have been made with the same arguments.
  template <class Archive>
  void exchange_state(Archive& archive) {
    bool is_choosing = pilot_ != nullptr;
    archive(is_choosing, choice_, of_pilot_);
    if constexpr (Archive::is_reading)
      if (pilot_ && !is_choosing) {
        if (choice_ && choice_->chosen && *choice_->chosen < choice_->forecasts.size())
          settings_.counts = choice_->forecasts[*choice_->chosen].counts;
        start();
      }
    if (engine_) archive(*engine_);
  }

 private:
  /// The work of a finished pilot.
  struct Work {
    Counters counters, light_work;
    PhaseSeconds seconds;

    template <class Archive>
    void exchange_state(Archive& archive) {
      archive(counters, light_work, seconds);
    }
  };

  void start() {
    pilot_ = nullptr;
    engine_ = maker_.engine(settings_, crop_);
    engine_->keep_contributions(keeps_contributions_);
  }
  GMIS_RARE void choose(ExecutorRef executor);

  EngineMaker<S> maker_;
  RenderSettings settings_;
  std::optional<PixelBounds> crop_;
  std::optional<Choice> choice_;
  bool keeps_contributions_ = false;
  Work of_pilot_;
  std::unique_ptr<AnyPilot<S>> pilot_;
  std::unique_ptr<AnyEngine<S>> engine_;
};

template <Spectrum S>
RenderEngine<S>::RenderEngine(EngineMaker<S> maker, const RenderSettings& settings,
                              std::vector<SampleCounts> candidates, std::uint32_t expected_iterations,
                              const std::optional<PixelBounds>& crop)
    : maker_(std::move(maker)), settings_(settings), crop_(crop) {
  if (candidates.size() < 2) {
    if (!candidates.empty()) settings_.counts = candidates.front();
    start();
    return;
  }
  require_argument(static_cast<bool>(maker_.pilot),
                   "there are several candidates for the counts, but these engines have no pilot: make them by "
                   "engines_with_pilot (gmis/transport/allocation/engines_with_pilot.hpp), or give one candidate");
  choice_.emplace();
  choice_->expected_iterations = expected_iterations;
  choice_->pilot_iterations = pilot_iterations_for(expected_iterations);
  RenderSettings of_pilot = settings;
  of_pilot.seed ^= 0xB5297A4D3F84D5B5U;  // numbers that the picture does not use
  pilot_ = maker_.pilot(of_pilot, candidates, expected_iterations, crop);
}

template <Spectrum S>
void RenderEngine<S>::choose(ExecutorRef executor) {
  pilot_->learn_lights(settings_.seed, executor);  // with the run's own seed: one that goes on later learns the same
  while (pilot_->iterations() < choice_->pilot_iterations) pilot_->iterate(executor);
  const AnyEngine<S>& engine = pilot_->engine();
  choice_->forecasts = pilot_->forecasts();
  choice_->pilot_cost = cost_of(engine.counters());
  if (pilot_->has_seen_pixels()) {
    choice_->chosen = best_of(choice_->forecasts, choice_->expected_iterations);
    settings_.counts = choice_->forecasts[*choice_->chosen].counts;
  }
  of_pilot_ = {engine.counters(), engine.light_work(), engine.seconds()};
  Counters& counters = of_pilot_.counters;
  counters.contributions = counters.rejected_non_finite = counters.rejected_negative = counters.rejected_zero_pdf = 0;
  const auto lights = engine.learned_lights();
  start();
  engine_->use_lights(lights);
}

#ifdef GMIS_COMPILED
extern template class RenderEngine<Vec3<float>>;
extern template class RenderEngine<Vec3<double>>;
#endif

}  // namespace gmis
