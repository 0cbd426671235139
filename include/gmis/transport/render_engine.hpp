#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "gmis/transport/choose/pilot.hpp"
#include "gmis/transport/engine.hpp"

namespace gmis {

/// The counts that a pilot found best, and why.
struct Choice {
  std::vector<Forecast> forecasts;
  std::optional<std::size_t> chosen;      ///< its place among them; nothing where the pilot saw no pixel
  std::uint32_t expected_iterations = 0;  ///< that the choice is best for
  std::uint32_t pilot_iterations = 0;     ///< part of the picture like all others
  double pilot_cost = 0.0;                ///< counted operations, as `Forecast::cost`
};

/// The engine that a run's settings ask for, at run time: the one without a light side where nothing is traced from the
/// lights, the one that splits light trees where that is asked for, the one for both sides otherwise. Given several sets of
/// counts to choose from, it begins with a pilot, whose iterations are part of the picture, and goes on with the best. The
/// pilot's choice is made once and stays: later iterations do not depend on the values that they are weighted with.
template <Scene Sc, class Source = Philox>
class RenderEngine {
 public:
  using S = typename Sc::Spectrum;

  /// Renders with `settings.counts`.
  RenderEngine(const Sc& scene, const RenderSettings& settings, const std::optional<PixelBounds>& crop = std::nullopt)
      : RenderEngine(scene, settings, {}, 0, crop) {}

  /// Chooses among `candidates` for a run of `expected_iterations`. `settings.counts` hold the techniques that the pilot
  /// renders with: all those of the candidates, connections and splats among them. With fewer than two candidates nothing is
  /// chosen.
  RenderEngine(const Sc& scene, const RenderSettings& settings, std::vector<SampleCounts> candidates,
               std::uint32_t expected_iterations, const std::optional<PixelBounds>& crop = std::nullopt)
      : scene_(scene), settings_(settings), crop_(crop) {
    if (candidates.size() < 2) {
      if (!candidates.empty()) settings_.counts = candidates.front();
      start();
      return;
    }
    choice_.emplace();
    choice_->expected_iterations = expected_iterations;
    choice_->pilot_iterations = pilot_iterations_for(expected_iterations);
    engine_.template emplace<Pilot>(scene, settings, std::move(candidates), expected_iterations, crop);
  }
  RenderEngine(const RenderEngine&) = delete;
  RenderEngine& operator=(const RenderEngine&) = delete;

  /// Renders one more iteration; the image it alone gives is `frame()` afterwards.
  template <Executor E>
  void iterate(E& executor) {
    if (has_pilot() && std::get<Pilot>(engine_).iterations() == choice_->pilot_iterations) choose();
    std::visit([&](auto& engine) { iterate_one(engine, executor); }, engine_);
  }

  [[nodiscard]] std::span<const S> frame() const {
    return visit([](const auto& engine) { return engine.frame(); });
  }
  [[nodiscard]] Counters counters() const {
    Counters all = pilot_.counters;
    return all += visit([](const auto& engine) { return engine.counters(); });
  }
  /// The part of them that tracing light trees took.
  [[nodiscard]] Counters light_work() const {
    Counters all = pilot_.light_work;
    return all += visit([](const auto& engine) { return engine.light_work(); });
  }
  /// The first paths of which something was left out.
  [[nodiscard]] RejectionLog rejections() const {
    RejectionLog all = pilot_.rejections;
    all.append(visit([](const auto& engine) { return engine.rejections(); }));
    return all;
  }
  [[nodiscard]] PhaseSeconds seconds() const {
    PhaseSeconds all = pilot_.seconds;
    return all += visit([](const auto& engine) { return engine.seconds(); });
  }
  [[nodiscard]] std::size_t photon_bytes() const {
    return visit([](const auto& engine) { return engine.photon_bytes(); });
  }
  /// The merging radius that the engine at hand began with, in scene units; 0 where nothing merges.
  [[nodiscard]] double first_radius() const {
    return visit([](const auto& engine) { return engine.first_radius(); });
  }
  /// The counts that the latest iteration was made with.
  [[nodiscard]] const SampleCounts& counts() const {
    return visit([](const auto& engine) -> const SampleCounts& { return engine.counts(); });
  }
  /// How the counts were chosen, once they are; nothing where there was no choice to make.
  [[nodiscard]] const Choice* choice() const { return choice_ && !has_pilot() ? &*choice_ : nullptr; }

  /// Whether contributions are kept from the next iteration on, for `for_each_contribution`. A pilot keeps none.
  void keep_contributions(bool keep) {
    std::visit(
        [keep](auto& engine) {
          if constexpr (requires { engine.keep_contributions(keep); }) engine.keep_contributions(keep);
        },
        engine_);
  }
  template <class Visit>
  void for_each_contribution(Visit&& visit_one) const {
    std::visit(
        [&](const auto& engine) {
          if constexpr (requires { engine.iteration(); }) engine.for_each_contribution(visit_one);
        },
        engine_);
  }

  /// In pairs; an iteration of the pilot costs some two to three times one of the counts that it finds best.
  [[nodiscard]] static constexpr std::uint32_t pilot_iterations_for(std::uint32_t expected_iterations) noexcept {
    return 2 * std::clamp(expected_iterations / 100U, 1U, 8U);
  }

 private:
  using Pilot = RenderPilot<Sc, Source>;
  using OneSide = Engine<Sc, CameraSide, Source>;
  using TwoSides = Engine<Sc, BothSides, Source>;
  using Trees = Engine<Sc, SplitTrees, Source>;

  /// The work of a pilot that is done.
  struct Done {
    Counters counters, light_work;
    PhaseSeconds seconds;
    RejectionLog rejections;
  };

  [[nodiscard]] bool has_pilot() const noexcept { return std::holds_alternative<Pilot>(engine_); }

  template <class E>
  static void iterate_one(std::monostate&, E&) {}
  template <class Engine_, class E>
  static void iterate_one(Engine_& engine, E& executor) {
    engine.iterate(executor);
  }

  /// `view` of the engine at hand, a pilot's own one included.
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
  }

  [[nodiscard]] RenderSettings settings_without_split() const {
    RenderSettings settings = settings_;
    settings.light_split = LightSplit::none;
    return settings;
  }

  void choose() {
    const Pilot& pilot = std::get<Pilot>(engine_);
    choice_->forecasts = pilot.forecasts();
    choice_->pilot_cost = cost_of(pilot.engine().counters());
    if (pilot.has_seen_pixels()) {
      choice_->chosen = best_of(choice_->forecasts, choice_->expected_iterations);
      settings_.counts = choice_->forecasts[*choice_->chosen].counts;
    }
    pilot_ = {pilot.engine().counters(), pilot.engine().light_work(), pilot.engine().seconds(),
              pilot.engine().rejections()};
    start();
    std::visit(
        [this](auto& engine) {
          if constexpr (requires { engine.continue_after(0U); }) engine.continue_after(choice_->pilot_iterations);
        },
        engine_);
  }

  const Sc& scene_;
  RenderSettings settings_;
  std::optional<PixelBounds> crop_;
  std::optional<Choice> choice_;
  Done pilot_;
  std::variant<std::monostate, Pilot, OneSide, TwoSides, Trees> engine_;
};

}  // namespace gmis
