#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gmis/transport/pilot.hpp"
#include "support/auto_integrator.hpp"
#include "support/diagnostics.hpp"
#include "support/frame_source.hpp"
#include "support/render.hpp"

/// \file
/// A pilot first, then the candidate that it found best. Included by one source file per pilot.

namespace gmis::tools {

/// The choice is made once and stays: what is rendered after it does not depend on what it is weighted with.
template <class Base>
class MeasuredSource final : public FrameSource {
 public:
  MeasuredSource(const BuiltScene& built, const RenderRequest& request, std::vector<Candidate> candidates)
      : built_(built),
        request_(request),
        expected_iterations_(expected_iterations(request.budget, pixel_count(built))),
        pilot_iterations_(pilot_iterations_of(expected_iterations_)),
        pilot_(std::make_unique<PilotType>(built.scene(), request.settings, std::move(candidates), expected_iterations_,
                                           request.crop)) {}

  void iterate(ThreadedExecutor& executor) override {
    if (!chosen_ && pilot_->iterations() == pilot_iterations_) choose();
    if (chosen_) {
      chosen_->iterate(executor);
      counters_ = pilot_counters_;
      counters_ += chosen_->counters();
      light_work_ = pilot_light_work_;
      light_work_ += chosen_->light_work();
      seconds_ = pilot_seconds_;
      seconds_ += chosen_->seconds();
      rejections_ = pilot_rejections_;
      rejections_.append(chosen_->rejections());
      return;
    }
    pilot_->iterate(executor);
    counters_ = pilot_->engine().counters();
    light_work_ = pilot_->engine().light_work();
    seconds_ = pilot_->engine().seconds();
    rejections_ = pilot_->engine().rejections();
  }
  void continue_after(std::uint32_t) override {}  // nothing comes before a pilot
  [[nodiscard]] std::span<const Spectrum> frame() const override {
    return chosen_ ? chosen_->frame() : pilot_->engine().frame();
  }
  [[nodiscard]] const Counters& counters() const override { return counters_; }
  [[nodiscard]] const Counters& light_work() const override { return light_work_; }
  [[nodiscard]] const RejectionLog& rejections() const override { return rejections_; }
  [[nodiscard]] const PhaseSeconds& seconds() const override { return seconds_; }
  [[nodiscard]] std::size_t photon_bytes() const override {
    return chosen_ ? chosen_->photon_bytes() : pilot_->engine().photon_bytes();
  }
  [[nodiscard]] const Tuning& tuning() const override {
    return chosen_ ? chosen_->tuning() : pilot_->engine().tuning();
  }
  [[nodiscard]] std::vector<Trial> trials() const override { return {}; }
  [[nodiscard]] const MeasuredChoice* choice() const override { return chosen_ ? &choice_ : nullptr; }
  void for_each_contribution(const Visit&) const override {}
  [[nodiscard]] ReplayedPath<Spectrum> replay(ThreadedExecutor& executor, const PathName& path) override {
    if (path.iteration <= pilot_iterations_)
      throw InputError(
          "--replay: the first " + std::to_string(pilot_iterations_) +
          " iterations with --integrator auto measure what pays and cannot be replayed: choose a later one");
    if (!chosen_) {
      while (pilot_->iterations() < pilot_iterations_) pilot_->iterate(executor);
      choose();
    }
    return chosen_->replay(executor, path);
  }

 private:
  using PilotType = RenderPilot<BuiltScene::SceneType, Base>;

  [[nodiscard]] static std::size_t pixel_count(const BuiltScene& built) {
    const glm::ivec2 size = built.scene().camera().resolution();
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  }
  /// In pairs; one costs some two to three times an iteration of what it finds best.
  [[nodiscard]] static std::uint32_t pilot_iterations_of(std::uint32_t expected) {
    return 2 * std::clamp(expected / 100U, 1U, 8U);
  }

  void choose() {
    choice_.forecasts = pilot_->forecasts();
    choice_.chosen = best_of(choice_.forecasts, expected_iterations_);
    choice_.expected_iterations = expected_iterations_;
    choice_.pilot_iterations = pilot_iterations_;
    const Forecast& best = choice_.forecasts[choice_.chosen];
    if (const double work = best.variance * best.cost; work > 0.0)
      choice_.least_by_region = pilot_->least_work_by_region() / work;
    choice_.pilot_cost = cost_of(pilot_->engine().counters());
    chosen_ = start_candidate(choice_.forecasts[choice_.chosen].candidate, built_, request_);
    chosen_->continue_after(pilot_iterations_);
    pilot_counters_ = pilot_->engine().counters();
    pilot_light_work_ = pilot_->engine().light_work();
    pilot_rejections_ = pilot_->engine().rejections();
    pilot_seconds_ = pilot_->engine().seconds();
    pilot_.reset();
  }

  const BuiltScene& built_;
  RenderRequest request_;
  std::uint32_t expected_iterations_, pilot_iterations_;
  std::unique_ptr<PilotType> pilot_;
  std::unique_ptr<FrameSource> chosen_;
  MeasuredChoice choice_;
  Counters counters_, pilot_counters_, light_work_, pilot_light_work_;
  PhaseSeconds seconds_, pilot_seconds_;
  RejectionLog rejections_, pilot_rejections_;
};

}  // namespace gmis::tools
