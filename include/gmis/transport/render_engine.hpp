#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "gmis/transport/check_settings.hpp"
#include "gmis/transport/choose/pilot.hpp"
#include "gmis/transport/engine.hpp"

namespace gmis {

/// A pilot's choice of counts, with the forecasts that it rests on.
struct Choice {
  std::vector<Forecast> forecasts;        ///< one per candidate
  std::optional<std::size_t> chosen;      ///< index in `forecasts`; empty when the pilot analysed no pixel
  std::uint32_t expected_iterations = 0;  ///< length of the run for which the objective was minimised
  std::uint32_t pilot_iterations = 0;     ///< iterations of the pilot; they are not part of the picture
  double pilot_cost = 0.0;                ///< cost of all pilot iterations; unit: `OperationCosts`

  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(forecasts, chosen, expected_iterations, pilot_iterations, pilot_cost);
  }
};

/// Selects the engine for the settings of a run, at run time: `CameraSide` when no light subpath is traced,
/// `SplitTrees` when `RenderSettings::light_split` asks for it, `BothSides` otherwise.
///
/// With several candidates for the counts, the first iteration is preceded by a pilot, which renders some of the pixels for
/// itself. The run has the best candidate. The choice is made once, from the pilot alone: counts do not depend on samples of
/// the picture.
template <Scene Sc, class Source = SampleNumbers>
class RenderEngine {
 public:
  using S = typename Sc::Spectrum;

  /// Renders with `settings.counts`.
  RenderEngine(const Sc& scene, const RenderSettings& settings, const std::optional<PixelBounds>& crop = std::nullopt)
      : RenderEngine(scene, settings, {}, 0, crop) {}

  /// Chooses among `candidates` for a run of `expected_iterations`. The pilot renders with the techniques of
  /// `settings.counts`; every technique of the candidates must be on there, and so must connections and splats. With
  /// one candidate the run uses its counts, without a pilot; with none it uses `settings.counts`.
  RenderEngine(const Sc& scene, const RenderSettings& settings, std::vector<SampleCounts> candidates,
               std::uint32_t expected_iterations, const std::optional<PixelBounds>& crop = std::nullopt)
      : scene_(scene), settings_(settings), crop_(crop) {
    if (candidates.size() < 2) {
      if (!candidates.empty()) settings_.counts = candidates.front();
      start();
      return;
    }
    // The pilot has neither, and would not say so.
    check_learned_counts(settings);
    choice_.emplace();
    choice_->expected_iterations = expected_iterations;
    choice_->pilot_iterations = pilot_iterations_for(expected_iterations);
    RenderSettings of_pilot = settings;
    of_pilot.seed ^= 0xB5297A4D3F84D5B5U;  // numbers that the picture does not use
    engine_.template emplace<Pilot>(scene, of_pilot, std::move(candidates), expected_iterations, crop);
  }
  RenderEngine(const RenderEngine&) = delete;
  RenderEngine& operator=(const RenderEngine&) = delete;

  /// Renders one more iteration; `frame()` is then the image of this iteration alone.
  template <Executor E>
  void iterate(E& executor) {
    if (has_pilot()) choose(executor);
    std::visit([&](auto& engine) { iterate_one(engine, executor); }, engine_);
  }

  /// Image of the latest iteration, linear, rows from the upper left; pixels outside the crop are black.
  [[nodiscard]] std::span<const S> frame() const {
    return visit([](const auto& engine) { return engine.frame(); });
  }
  /// What merging changes in the latest iteration, as `Engine::merging_change`.
  [[nodiscard]] std::span<const float> merging_change() const {
    return visit([](const auto& engine) { return engine.merging_change(); });
  }
  /// Counted work since the start, including the pilot, whose contributions and rejections are not among the counted ones.
  [[nodiscard]] Counters counters() const {
    Counters all = pilot_.counters;
    return all += visit([](const auto& engine) { return engine.counters(); });
  }
  /// The part of `counters()` that light trees took.
  [[nodiscard]] Counters light_work() const {
    Counters all = pilot_.light_work;
    return all += visit([](const auto& engine) { return engine.light_work(); });
  }
  /// The first paths with rejections.
  [[nodiscard]] RejectionLog rejections() const {
    return has_pilot() ? RejectionLog{} : visit([](const auto& engine) { return engine.rejections(); });
  }
  /// Seconds per phase since the start, including the pilot.
  [[nodiscard]] PhaseSeconds seconds() const {
    PhaseSeconds all = pilot_.seconds;
    return all += visit([](const auto& engine) { return engine.seconds(); });
  }
  /// Bytes held by the current engine for light vertices and their grid.
  [[nodiscard]] std::size_t photon_bytes() const {
    return visit([](const auto& engine) { return engine.photon_bytes(); });
  }
  /// Merging radius r_1 of the current engine in scene units; 0 when merging is off. Before the first iteration it is that of
  /// a pilot.
  [[nodiscard]] double first_radius() const {
    return visit([](const auto& engine) { return engine.first_radius(); });
  }
  /// Merging radius of the latest iteration in scene units; 0 when merging is off, and before the first iteration. After
  /// `merge_within` it is what that iteration would have had.
  [[nodiscard]] double radius() const {
    return visit(
        [](const auto& engine) { return engine.iteration() > 0 ? engine.merge_radius(engine.iteration()) : 0.0; });
  }
  /// As `Engine::merge_within`, after a pilot.
  void merge_within(double radius_factor) {
    std::visit(
        [&](auto& engine) {
          if constexpr (requires { engine.merge_within(radius_factor); }) engine.merge_within(radius_factor);
        },
        engine_);
  }
  /// As `Engine::scale_merging`, after a pilot.
  void scale_merging(double per_radius) {
    std::visit(
        [&](auto& engine) {
          if constexpr (requires { engine.scale_merging(per_radius); }) engine.scale_merging(per_radius);
        },
        engine_);
  }
  /// As `Engine::merging_gain`.
  [[nodiscard]] double merging_gain() const {
    return visit([](const auto& engine) { return engine.merging_gain(); });
  }
  /// As `Engine::merged_light`.
  [[nodiscard]] double merged_light() const {
    return visit([](const auto& engine) { return engine.merged_light(); });
  }
  /// The counts of the latest iteration.
  [[nodiscard]] const SampleCounts& counts() const {
    return visit([](const auto& engine) -> const SampleCounts& { return engine.counts(); });
  }
  /// The choice of the pilot; null before the first iteration and in a run without a pilot.
  [[nodiscard]] const Choice* choice() const { return choice_ && !has_pilot() ? &*choice_ : nullptr; }

  /// Sets whether contributions are kept for `for_each_contribution`, from the next iteration on.
  void keep_contributions(bool keep) {
    keeps_contributions_ = keep;
    std::visit(
        [keep](auto& engine) {
          if constexpr (requires { engine.keep_contributions(keep); }) engine.keep_contributions(keep);
        },
        engine_);
  }
  /// Calls `visit_one(const Contribution<S>&)` for every kept contribution of the latest iteration.
  template <class Visit>
  void for_each_contribution(Visit&& visit_one) const {
    std::visit(
        [&](const auto& engine) {
          if constexpr (requires { engine.iteration(); }) engine.for_each_contribution(visit_one);
        },
        engine_);
  }

  /// The state for a later run (`core/state_archive.hpp`), between two iterations. A reading engine must have been made
  /// with the same arguments.
  template <class Archive>
  void exchange_state(Archive& archive) {
    bool is_choosing = has_pilot();
    archive(is_choosing, choice_, pilot_);
    if constexpr (Archive::is_reading)
      if (has_pilot() && !is_choosing) {
        if (choice_ && choice_->chosen && *choice_->chosen < choice_->forecasts.size())
          settings_.counts = choice_->forecasts[*choice_->chosen].counts;
        start();
      }
    std::visit(
        [&](auto& engine) {
          if constexpr (requires { engine.exchange_state(archive); }) archive(engine);
        },
        engine_);
  }

  /// Number of pilot iterations for a run of this length: 2 to 16, an even number because forecasts use pairs. A pixel costs a
  /// pilot about three times what it costs with the chosen counts; the pilot takes some of them (`PilotGrid`).
  [[nodiscard]] static constexpr std::uint32_t pilot_iterations_for(std::uint32_t expected_iterations) noexcept {
    return 2 * std::clamp(expected_iterations / 100U, 1U, 8U);
  }

 private:
  using Pilot = RenderPilot<Sc, Source>;
  using OneSide = Engine<Sc, CameraSide, Source>;
  using TwoSides = Engine<Sc, BothSides, Source>;
  using Trees = Engine<Sc, SplitTrees, Source>;

  /// The work of a finished pilot.
  struct Done {
    Counters counters, light_work;
    PhaseSeconds seconds;

    template <class Archive>
    void exchange_state(Archive& archive) {
      archive(counters, light_work, seconds);
    }
  };

  [[nodiscard]] bool has_pilot() const noexcept { return std::holds_alternative<Pilot>(engine_); }

  template <class E>
  static void iterate_one(std::monostate&, E&) {}
  template <class Engine_, class E>
  static void iterate_one(Engine_& engine, E& executor) {
    engine.iterate(executor);
  }

  /// `view` applied to the current engine, or to the pilot's engine while the pilot runs.
  template <class View>
  [[nodiscard]] decltype(auto) visit(View&& view) const {
    if (const auto* engine = std::get_if<OneSide>(&engine_)) return view(*engine);
    if (const auto* engine = std::get_if<TwoSides>(&engine_)) return view(*engine);
    if (const auto* engine = std::get_if<Trees>(&engine_)) return view(*engine);
    return view(std::get<Pilot>(engine_).engine());
  }

  void start() {
    if (!settings_.counts.traces_light())
      engine_.template emplace<OneSide>(scene_, settings_without_split(), crop_);
    else if (settings_.light_split != LightSplit::none)
      engine_.template emplace<Trees>(scene_, settings_, crop_);
    else
      engine_.template emplace<TwoSides>(scene_, settings_, crop_);
    keep_contributions(keeps_contributions_);
  }

  [[nodiscard]] RenderSettings settings_without_split() const {
    RenderSettings settings = settings_;
    settings.light_split = LightSplit::none;
    return settings;
  }

  template <class E>
  void choose(E& executor) {
    Pilot& pilot = std::get<Pilot>(engine_);
    while (pilot.iterations() < choice_->pilot_iterations) pilot.iterate(executor);
    choice_->forecasts = pilot.forecasts();
    choice_->pilot_cost = cost_of(pilot.engine().counters());
    if (pilot.has_seen_pixels()) {
      choice_->chosen = best_of(choice_->forecasts, choice_->expected_iterations);
      settings_.counts = choice_->forecasts[*choice_->chosen].counts;
    }
    pilot_ = {pilot.engine().counters(), pilot.engine().light_work(), pilot.engine().seconds()};
    Counters& counters = pilot_.counters;
    counters.contributions = counters.rejected_non_finite = counters.rejected_negative = counters.rejected_zero_pdf = 0;
    start();
  }

  const Sc& scene_;
  RenderSettings settings_;
  std::optional<PixelBounds> crop_;
  std::optional<Choice> choice_;
  bool keeps_contributions_ = false;
  Done pilot_;
  std::variant<std::monostate, Pilot, OneSide, TwoSides, Trees> engine_;
};

}  // namespace gmis
