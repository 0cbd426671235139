#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/executor_ref.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/state_archive.hpp"
#include "gmis/render/checkpoint.hpp"
#include "gmis/render/merging_disk.hpp"
#include "gmis/render/merging_gain.hpp"
#include "gmis/render/rank_gathering.hpp"
#include "gmis/render/rank_round.hpp"
#include "gmis/render/render_request.hpp"
#include "gmis/render/render_result.hpp"
#include "gmis/render/run_identity.hpp"
#include "gmis/render/run_record.hpp"
#include "gmis/render/run_timer.hpp"
#include "gmis/render/validate_request.hpp"
#include "gmis/render/whole_record.hpp"
#include "gmis/transport/allocation/render_engine.hpp"

namespace gmis {

/// A rendering that improves iteration by iteration, over engines of any scene with the spectrum
/// `S`: engine, film, error, convergence log and limits. Nothing here depends on the scene, so that
/// it is compiled once a spectrum. `Render<Scene>` (render.hpp) is the same with the engines of a
/// scene.
///
/// `run` renders until a limit of the budget is met. A program with a loop of its own calls
/// `advance` and `reason_to_stop`; several renderings can then take turns. The constructor throws
/// `std::invalid_argument` for invalid settings, as the engines do.
///
/// The same seed and settings give the same pictures for any number of threads. A limit on time or
/// on the error changes the number of iterations alone.
///
/// With `RenderRequest::ranks`, processes share the iterations, and each adds up some rows of the
/// picture. Pictures, stated errors and checkpoints, times aside, have the bits of a run of one
/// process. All ranks call the same members in the same order; results are at rank 0, which alone
/// calls callbacks. The constructor throws on all ranks when the run of one is another one than
/// that of rank 0.
template <Spectrum S_>
class RenderRun {
 public:
  using S = S_;

  /// Prepares a run with these engines. `resolution` is that of the camera.
  GMIS_RARE RenderRun(EngineMaker<S> maker, glm::ivec2 resolution, RenderRequest request);
  RenderRun(const RenderRun&) = delete;
  RenderRun& operator=(const RenderRun&) = delete;
  GMIS_RARE ~RenderRun();

  /// Renders until a limit is met, and calls the callbacks of the request. With a
  /// `StoppableExecutor`, an interrupt after the first iteration leaves out the iteration under
  /// way; with another executor that iteration is finished.
  GMIS_RARE RenderResult run(ExecutorRef executor);

  /// Renders one more iteration; with several ranks a round, of at most one for each. Returns false
  /// when the executor was stopped meanwhile: this iteration is left out, and the rendering cannot
  /// go on.
  GMIS_RARE [[nodiscard]] bool advance(ExecutorRef executor);

  /// The state after the latest iteration, from which the same program can go on (`resume`). Write
  /// it to a file that replaces the one before.
  GMIS_RARE [[nodiscard]] std::vector<std::byte> checkpoint();

  /// Goes on from a checkpoint of a run with the same scene and request; limits, threads and
  /// callbacks may differ. The pictures then have the bits of a run that was never interrupted.
  /// Throws `std::invalid_argument` that says what differs; this rendering is then unchanged. It
  /// throws, too, where the digest is right and the state has another length, as that of another
  /// scene with the same name: do not use this rendering then. Call it before the first iteration.
  GMIS_RARE void resume(std::span<const std::byte> bytes);

  /// Adds the latest iteration to the convergence log unless it is there.
  GMIS_RARE void finish_log(ExecutorRef executor);
  /// Adds the latest iteration to the log likewise, with a `SerialExecutor`.
  void finish_log() {
    SerialExecutor executor;
    finish_log(executor);
  }

  /// The limit that is met after the iterations so far (at least one), or nothing to go on.
  [[nodiscard]] std::optional<StopReason> reason_to_stop() const {
    std::optional<StopReason> reason = request_.budget.reason_to_stop(made_.state);
    if (request_.rejection_limit.is_surely_exceeded(made_.counters)) reason = StopReason::rejected;
    if (request_.interrupt != nullptr && request_.interrupt->load()) reason = StopReason::interrupt;
    return request_.ranks.of_first(reason);
  }

  /// Iterations and wall time so far. The error in it is known when it was estimated after the
  /// latest iteration.
  [[nodiscard]] const RunState& progress() const noexcept { return made_.state; }
  /// Processor time so far: of the pilot, the iterations and the estimates of the error.
  [[nodiscard]] double cpu_seconds() const noexcept { return made_.cpu_seconds; }
  /// The film so far, of the rows of this rank.
  [[nodiscard]] const Film<S>& film() const noexcept { return made_.film; }
  /// The picture of the latest iteration alone, inside the crop, of the rows of this rank.
  [[nodiscard]] std::span<const S> frame() const noexcept { return frame_; }
  /// The picture so far.
  [[nodiscard]] Picture picture() const { return picture_of(whole()->film); }
  /// Error and time of the iterations so far.
  [[nodiscard]] const ConvergenceLog& log() const noexcept { return made_.log; }
  /// The engine that is run, with the choice of a pilot.
  [[nodiscard]] const RenderEngine<S>& engine() const noexcept { return *engine_; }

  /// The estimated error, with `RenderRequest::intervals` or a limit on the error, from the second
  /// iteration on.
  [[nodiscard]] std::optional<ErrorEstimate> error() const {
    if (!made_.batches || estimated_after_ == made_.state.iterations) return latest_error_;
    SerialExecutor executor;
    return detail::error_over_ranks(request_.ranks, crop_, *made_.batches, executor);
  }

  /// The bias of merging in the picture so far; empty after one iteration that merges.
  [[nodiscard]] std::optional<MergingBias> merging_bias() const {
    const WholeRecord<S> all = whole();
    return request_.ranks.is_first() ? all->merging_bias() : std::nullopt;
  }

  /// The prices of the usual errors, and of half the present one.
  [[nodiscard]] std::optional<PriceTable> prices() const {
    const std::optional<ErrorEstimate> present = error();
    const std::vector<double> variances_of_all = variances();
    const WholeRecord<S> all = whole();
    return request_.ranks.is_first() ? all->prices(present, variances_of_all) : std::nullopt;
  }
  /// The prices of the usual errors as the pilot's choice has them; empty before two iterations
  /// with the chosen counts.
  [[nodiscard]] const std::optional<PriceTable>& forecast() const noexcept { return made_.forecast; }

  /// The result of the run so far; `reason` says why it ended.
  GMIS_RARE [[nodiscard]] RenderResult result(StopReason reason) const;

 private:
  GMIS_RARE [[nodiscard]] RunIdentity identity() const {
    RunIdentity all = identity_of(request_, resolution_, Film<S>::channel_count, sizeof(ScalarOf<S>));
    for (const auto& [name, value] : maker_.properties) all.add(name, value);
    return all;
  }
  GMIS_RARE void make_engine() {
    engine_.emplace(maker_, request_.settings, request_.candidates, request_.expected_iterations, request_.crop);
    engine_->keep_contributions(request_.keeps_contributions());
  }
  /// The record comes first, which `join_runs` reads without the rest.
  template <class Archive>
  void exchange_state(Archive& archive, RunRecord<S>& all) {
    std::optional<double> limit = request_.budget.relative_error;  // which the next estimate was chosen for
    archive(all, latest_error_, estimated_after_, next_estimate_, limit);
    if (limit != request_.budget.relative_error) next_estimate_ = Budget::fewest_iterations_for_error;
    archive(request_.expected_iterations);  // the choice of a pilot depends on it
    if constexpr (Archive::is_reading) make_engine();
    archive(*engine_);
  }

  /// The sums whose rows `whole` gathers. Batches are many, and checkpoints alone need them.
  enum class Gathered { pictures, all };
  /// The record with the rows of all ranks, at rank 0; elsewhere that of its own rows. All ranks
  /// call it together.
  GMIS_RARE WholeRecord<S> whole(Gathered sums = Gathered::pictures) const;
  /// `RunRecord::variances` of the whole picture, at rank 0.
  GMIS_RARE [[nodiscard]] std::vector<double> variances() const;
  /// The part of a whole record that this rank keeps.
  GMIS_RARE void keep_rows_of(RunRecord<S>&& all);

  /// Copies the state of the engine into the record.
  GMIS_RARE void note_engine();
  /// Once, after the second iteration: the first one includes the pilot and measures light trees.
  /// The seconds are those of the second iteration.
  GMIS_RARE void update_forecast(double cpu_seconds, double wall_seconds);

  /// Rejects a part of a run that cannot be rendered by itself.
  GMIS_RARE void prepare_part();
  /// Iterations of the run before those of its part.
  [[nodiscard]] std::uint32_t iterations_before() const { return request_.part ? request_.part->first - 1 : 0; }
  /// Number of iterations to render now: some a rank, but decisions come between rounds.
  [[nodiscard]] std::uint32_t round_length() const;
  /// Takes in an iteration of the round under way, which took this share of its wall time.
  GMIS_RARE void take(const IterationResult<S>& iteration, double wall_seconds);
  /// True when a limit is met that does not depend on time.
  [[nodiscard]] bool is_over() const {
    RunState state = made_.state;
    state.seconds = 0.0;
    return request_.rejection_limit.is_surely_exceeded(made_.counters) ||
           request_.budget.reason_to_stop(state).has_value();
  }
  /// True when disk and gain of merging follow what the iterations show.
  [[nodiscard]] bool adapts_merging() const {
    const Choice* const choice = engine_->choice();
    return choice != nullptr && choice->chosen && engine_->engine().counts().has(Technique::merge);
  }

  /// The number of iterations after which disk and gain of merging are chosen next.
  [[nodiscard]] std::uint32_t next_choice_after(std::uint32_t iterations) const {
    return next_choice_of_merging(iterations, engine_->choice()->expected_iterations);
  }
  /// After some iterations of a run whose radius a pilot has chosen (`next_choice_of_merging`):
  /// sets disk and gain of the iterations to come. A pilot can hardly see the bias of merging; the
  /// iterations so far have measured it.
  GMIS_RARE void adapt_merging();
  /// The radius becomes at most what the pilot chose, for larger ones have their costs, and at
  /// least that of the settings.
  GMIS_RARE void choose_disk(const Choice& choice, const MergingBias& bias, std::uint32_t length);
  /// A bias b with the standard error s is made up for by the factor 1 − s²/b², since a part may be
  /// noise.
  GMIS_RARE void choose_gain(const MergingBias& bias, double mean, std::uint32_t length);

  GMIS_RARE void update_error(ExecutorRef executor);
  /// Estimates the error after the latest iteration unless that is done.
  GMIS_RARE void estimate_now(ExecutorRef executor);
  /// Adds the latest iteration to the log, after `estimate_now`.
  GMIS_RARE void add_to_log();

  EngineMaker<S> maker_;
  RenderRequest request_;
  glm::ivec2 resolution_;
  PixelBounds crop_;
  std::optional<RenderEngine<S>> engine_;
  RankRound<S> round_;
  RunRecord<S> made_;                          ///< of whole iterations and the rows of this rank
  std::span<const S> frame_;                   ///< of the round
  std::optional<ErrorEstimate> latest_error_;  ///< after the iteration `estimated_after_`
  std::uint32_t estimated_after_ = 0, next_estimate_ = Budget::fewest_iterations_for_error;
};

template <Spectrum S_>
RenderRun<S_>::RenderRun(EngineMaker<S> maker, glm::ivec2 resolution, RenderRequest request)
    : maker_(std::move(maker)),
      request_(std::move(request)),
      resolution_(resolution),
      crop_(crop_of(request_, resolution_)),
      round_(request_.ranks, crop_),
      made_(request_, resolution_, detail::stripe_of(crop_, request_.ranks.rank(), request_.ranks.count())) {
  const RanksRef& ranks = request_.ranks;
  detail::require_same_run(ranks, identity());
  request_.budget = ranks.of_first(request_.budget);
  request_.rejection_limit = ranks.of_first(request_.rejection_limit);
  request_.expected_iterations = ranks.of_first(request_.expected_iterations);
  validate(request_);
  const glm::ivec2 size = crop_.upper - crop_.lower;
  const std::size_t values =
      static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * Film<S>::channel_count;
  require_argument(ranks.of_first(request_.reference.empty() || request_.reference.size() == values),
                   "RenderRequest::reference must have the pixels and channels of the crop");
  if (!ranks.is_first()) {
    request_.on_iteration = {};
    request_.on_forecast = {};
    request_.on_log = {};
    request_.on_picture = {};
    request_.on_checkpoint = {};
    request_.reference = {};
  }
  if (request_.part) prepare_part();
  const detail::RunTimer timer(made_.state.seconds, made_.cpu_seconds);
  make_engine();
  note_engine();
}

template <Spectrum S_>
RenderRun<S_>::~RenderRun() = default;

template <Spectrum S_>
void RenderRun<S_>::prepare_part() {
  const RunPart& part = *request_.part;
  require_argument(part.first >= 1 && part.first <= part.last && part.last <= part.of,
                   "a part of a run needs 1 <= first <= last <= of");
  require_argument(request_.ranks.count() == 1, "a part of a run is rendered by one rank");
  require_argument(!request_.keeps_contributions(),
                   "a part of a run keeps no pictures of techniques, path classes and lights");
  require_argument(
      request_.candidates.size() < 2 || std::none_of(request_.candidates.begin(), request_.candidates.end(),
                                                     [](const SampleCounts& one) { return one.has(Technique::merge); }),
      "a part of a run cannot follow the iterations before it, as merging does where a pilot may choose "
      "it: give the counts, or candidates without merging");
  request_.budget.iterations = part.length();
  made_.part = part;
}

template <Spectrum S_>
WholeRecord<S_> RenderRun<S_>::whole(Gathered sums) const {
  const RanksRef& ranks = request_.ranks;
  auto& own = const_cast<RunRecord<S>&>(made_);  // an archive names what it writes as it does what it reads
  if (ranks.count() == 1) return {own, {}};
  detail::RowGatherer gatherer(ranks, crop_);
  if (!ranks.is_first()) {
    PixelSums<S>& rows = own;
    if (sums == Gathered::all)
      rows.exchange_state(gatherer);
    else
      rows.exchange_pictures(gatherer);
    return {own, {}};
  }
  PixelSums<S> all(request_, crop_.upper - crop_.lower);
  if (sums == Gathered::pictures) all.batches.reset();
  const PixelBounds stripe = detail::stripe_of(crop_, 0, ranks.count());
  all.copy_rows(own, {0, stripe.upper.y - stripe.lower.y});
  all.exchange_state(gatherer);
  return {own, std::move(all)};
}

template <Spectrum S_>
std::vector<double> RenderRun<S_>::variances() const {
  std::vector<double> all = made_.variances(request_);
  const RanksRef& ranks = request_.ranks;
  if (ranks.count() == 1 || !ranks.of_first(!all.empty())) return all;
  const glm::ivec2 size = crop_.upper - crop_.lower;
  if (ranks.is_first())
    all.resize(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * Film<S>::channel_count);
  detail::RowGatherer gatherer(ranks, crop_);
  gatherer(all);
  return all;
}

template <Spectrum S_>
void RenderRun<S_>::keep_rows_of(RunRecord<S>&& all) {
  const RanksRef& ranks = request_.ranks;
  if (ranks.count() > 1) {
    const PixelBounds stripe = detail::stripe_of(crop_, ranks.rank(), ranks.count());
    const int height = stripe.upper.y - stripe.lower.y;
    PixelSums<S> rows(request_, {stripe.upper.x - stripe.lower.x, height});
    rows.copy_rows(all, {stripe.lower.y - crop_.lower.y, height});
    static_cast<PixelSums<S>&>(all) = std::move(rows);
  }
  made_ = std::move(all);
}

template <Spectrum S_>
RenderResult RenderRun<S_>::run(ExecutorRef executor) {
  // Work may be left out while there is a picture, but no longer when an exception leaves the loop.
  struct Unbound {
    ExecutorRef executor;
    ~Unbound() { executor.stop_when(nullptr); }
  } const unbound{executor};
  const auto keep = [&] {
    const std::vector<std::byte> state = checkpoint();
    if (request_.on_checkpoint) request_.on_checkpoint(state);
  };
  double last_picture = made_.state.seconds;
  std::optional<double> last_checkpoint;  // in seconds of the run
  std::optional<StopReason> reason;
  if (made_.state.iterations > 0) reason = reason_to_stop();
  while (!reason) {
    executor.stop_when(made_.state.iterations > 0 ? request_.interrupt : nullptr);
    if (!advance(executor)) {
      reason = StopReason::interrupt;
      break;
    }
    if (request_.on_iteration) request_.on_iteration(made_.state);
    reason = reason_to_stop();
    const double seconds = made_.state.seconds, interval = request_.seconds_between_pictures;
    if (request_.ranks.of_first(!reason && request_.on_picture && seconds - last_picture >= interval)) {
      last_picture = seconds;
      const Picture so_far = picture();
      if (request_.on_picture) request_.on_picture(so_far);
    }
    if (request_.ranks.of_first(!reason && request_.on_checkpoint &&
                                (!last_checkpoint || seconds - *last_checkpoint >= interval))) {
      last_checkpoint = seconds;
      keep();
    }
  }
  executor.stop_when(nullptr);
  if (request_.ranks.of_first(static_cast<bool>(request_.on_checkpoint))) keep();
  finish_log(executor);
  return result(*reason);
}

template <Spectrum S_>
std::uint32_t RenderRun<S_>::round_length() const {
  const std::uint32_t n = made_.state.iterations;
  const Budget& budget = request_.budget;
  std::uint32_t length = round_.length_after(n, budget.iterations && !budget.relative_error && !budget.seconds);
  if (adapts_merging()) length = std::min(length, next_choice_after(n) - n);
  const std::uint32_t last = budget.iterations.value_or(0);
  return last > n ? std::min(length, last - n) : length;
}

template <Spectrum S_>
bool RenderRun<S_>::advance(ExecutorRef executor) {
  const double wall_before = made_.state.seconds;
  {
    const detail::RunTimer timer(made_.state.seconds, made_.cpu_seconds);
    engine_->prepare(executor);
  }
  AnyEngine<S>& engine = *engine_->picture_engine();
  const std::uint32_t length = round_length();
  {
    double ignored = 0.0;
    const detail::RunTimer timer(made_.state.seconds, ignored);
    const EngineWork before = engine.take_work();
    const bool is_whole = round_.render(engine, executor, iterations_before() + made_.state.iterations, length);
    engine.add_work(before);
    if (!is_whole) return false;
  }
  const double wall_seconds = (made_.state.seconds - wall_before) / length;
  for (const IterationResult<S>& iteration : round_.iterations()) {
    take(iteration, wall_seconds);
    adapt_merging();
    update_error(executor);
    if (made_.log.is_due(made_.state.iterations)) add_to_log();
    if (length > 1 && is_over()) break;
  }
  return true;
}

template <Spectrum S_>
void RenderRun<S_>::take(const IterationResult<S>& iteration, double wall_seconds) {
  AnyEngine<S>& engine = *engine_->picture_engine();
  engine.continue_after(iterations_before() + made_.state.iterations + 1);
  engine.add_work(iteration.work);
  const double cpu_before = made_.cpu_seconds;
  {
    const detail::RunTimer film_timer(made_.film_seconds, made_.cpu_seconds);
    double ignored = 0.0;
    const detail::RunTimer timer(made_.state.seconds, ignored);
    const glm::ivec2 size = crop_.upper - crop_.lower;
    frame_ = iteration.frame;
    made_.add(iteration, static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y), engine.radius(),
              engine.merging_gain());
    if (request_.part)
      made_.kept.push_back({iteration,
                            {iteration.frame.begin(), iteration.frame.end()},
                            {iteration.merging_change.begin(), iteration.merging_change.end()},
                            engine.radius()});
    if (request_.keeps_contributions())
      engine.for_each_contribution([&](const Contribution<S>& contribution) {
        if (request_.techniques) made_.techniques.add(contribution);
        if (request_.class_pictures) made_.classes.add(contribution);
        if (request_.light_pictures) made_.by_light.add(contribution);
      });
  }
  made_.counters = engine_->counters();  // of whole iterations only
  made_.light_work = engine_->light_work();
  const RejectionLog& rejected = engine.rejections();
  made_.rejected_paths.assign(rejected.paths().begin(), rejected.paths().end());
  made_.phases = engine_->seconds();
  note_engine();
  update_forecast(made_.cpu_seconds - cpu_before, wall_seconds);
}

template <Spectrum S_>
std::vector<std::byte> RenderRun<S_>::checkpoint() {
  StateWriter state;
  exchange_state(state, *whole(Gathered::all));
  if (!request_.ranks.is_first()) return {};
  return detail::checkpoint_bytes(identity(), state.bytes());
}

template <Spectrum S_>
void RenderRun<S_>::resume(std::span<const std::byte> bytes) {
  const Checkpoint opened = open_checkpoint(bytes, identity());
  StateReader state(opened.state);
  RunRecord<S> all(request_, resolution_);
  exchange_state(state, all);
  if (state.is_broken() || !state.is_at_end()) reject_argument("the checkpoint is damaged");
  keep_rows_of(std::move(all));
}

template <Spectrum S_>
void RenderRun<S_>::finish_log(ExecutorRef executor) {
  if (made_.state.iterations == 0 || made_.log.points().back().iteration == made_.state.iterations) return;
  estimate_now(executor);
  add_to_log();
}

template <Spectrum S_>
RenderResult RenderRun<S_>::result(StopReason reason) const {
  const std::optional<ErrorEstimate> estimate = error();
  const std::vector<double> variances_of_all = variances();
  const WholeRecord<S> all = whole();
  if (request_.ranks.is_first()) return all->result(request_, reason, estimate, variances_of_all);
  RenderResult elsewhere;
  elsewhere.stopped_by = reason;
  elsewhere.iterations = made_.state.iterations;
  return elsewhere;
}

template <Spectrum S_>
void RenderRun<S_>::note_engine() {
  made_.counts = engine_->engine().counts();
  if (const Choice* choice = engine_->choice(); choice != nullptr && !made_.choice) made_.choice = *choice;
  // Known from the first iteration on; an engine that goes on from a checkpoint may learn less.
  if (made_.state.iterations <= 1) made_.lights = engine_->engine().light_use();
  made_.radius = engine_->engine().first_radius();
  made_.photon_bytes = engine_->engine().photon_bytes();
  made_.expected_law = expected_law(made_.choice, made_.counts, request_.settings);
}

template <Spectrum S_>
void RenderRun<S_>::update_forecast(double cpu_seconds, double wall_seconds) {
  const Choice* const choice = engine_->choice();
  if (choice == nullptr || !choice->chosen || made_.forecast || made_.state.iterations != 2) return;
  made_.forecast =
      forecast_prices(expected_law(*choice, choice->forecasts[*choice->chosen].counts, request_.settings),
                      {static_cast<double>(made_.state.iterations), made_.cpu_seconds, made_.state.seconds},
                      {1, cpu_seconds, wall_seconds});
  if (request_.on_forecast) request_.on_forecast(*made_.forecast);
}

template <Spectrum S_>
void RenderRun<S_>::adapt_merging() {
  const detail::RunTimer timer(made_.state.seconds, made_.cpu_seconds);
  const std::uint32_t n = made_.state.iterations;
  if (!adapts_merging() || next_choice_after(n - 1) != n) return;
  const WholeRecord<S> all = whole();
  AnyEngine<S>& engine = *engine_->picture_engine();
  const std::optional<MergingBias> bias = request_.ranks.is_first() ? all->merging_bias() : std::nullopt;
  if (bias) {
    const Choice& choice = *engine_->choice();
    // A gain has to make up for everything before the run ends, or before the next choice.
    const std::uint32_t length = choice.expected_iterations > n ? choice.expected_iterations : next_choice_after(n);
    choose_disk(choice, *bias, length);
    choose_gain(*bias, estimate_of(all->film).mean, length);
  }
  engine.merge_within(request_.ranks.of_first(engine.counts().radius_factor));
  made_.gain = request_.ranks.of_first(made_.gain);
  engine.scale_merging(made_.gain.per_radius());
}

template <Spectrum S_>
void RenderRun<S_>::choose_disk(const Choice& choice, const MergingBias& bias, std::uint32_t length) {
  if (!(made_.expected_law.merging > 0.0) || !(bias.relative_bias > 0.0)) return;
  AnyEngine<S>& engine = *engine_->picture_engine();
  const double factor = engine.counts().radius_factor, disk = square(engine.first_radius());
  const double merging = made_.expected_law.merging * made_.expected_law.remaining_at(length);
  const double best = best_first_disk({made_.state.iterations, made_.disks, square(bias.relative_bias)}, merging * disk,
                                      request_.settings.alpha, length);
  const double chosen = choice.forecasts[*choice.chosen].counts.radius_factor;
  engine.merge_within(std::clamp(factor * std::sqrt(best / disk), std::min(1.0, chosen), chosen));
}

template <Spectrum S_>
void RenderRun<S_>::choose_gain(const MergingBias& bias, double mean, std::uint32_t length) {
  const AnyEngine<S>& engine = *engine_->picture_engine();
  const double n = made_.state.iterations;
  const double of_merging = (bias.of_mean - bias.made_up) * mean;
  const double error = bias.standard_error_of_mean * mean;
  if (!(square(of_merging) > square(error))) {
    made_.gain.choose(0.0, 0.0, 0.0);
  } else {
    const double exponent = 0.5 * (request_.settings.alpha + 1.0);  // r_i = r_1 i^(exponent − 1)
    const double radii = engine.first_radius() *
                         (length * mean_disk(exponent, length) - n * mean_disk(exponent, made_.state.iterations));
    made_.gain.choose(n * of_merging * (1.0 - square(error / of_merging)), radii,
                      engine.first_radius() * std::pow(n + 1.0, exponent - 1.0));
  }
}

template <Spectrum S_>
void RenderRun<S_>::update_error(ExecutorRef executor) {
  made_.state.is_calibrated = false;  // an older estimate must not end the run
  const std::uint32_t n = made_.state.iterations;
  const std::optional<double>& limit = request_.budget.relative_error;
  if (!(limit && n >= next_estimate_) && !made_.log.is_due(n)) return;
  estimate_now(executor);
  if (!latest_error_) return;
  made_.state.relative_error = latest_error_->relative_error;
  made_.state.is_calibrated = latest_error_->is_calibrated() ||
                              (latest_error_->doubt == ErrorDoubt::nothing_found && n >= Budget::most_iterations_alike);
  if (!limit) return;
  // An error that falls like 1/n comes down to the limit no sooner. The guess is trusted for one
  // doubling.
  const double error = latest_error_->relative_error;
  const double factor = error < 2.0 * *limit ? std::max(1.125, error / *limit) : 2.0;
  constexpr double latest = std::numeric_limits<std::uint32_t>::max();
  next_estimate_ = std::max(Budget::fewest_iterations_for_error,
                            static_cast<std::uint32_t>(std::min(latest, std::ceil(n * factor))));
}

template <Spectrum S_>
void RenderRun<S_>::estimate_now(ExecutorRef executor) {
  if (!made_.batches || made_.state.iterations < 2 || estimated_after_ == made_.state.iterations) return;
  const detail::RunTimer timer(made_.state.seconds, made_.cpu_seconds);
  latest_error_ = detail::error_over_ranks(request_.ranks, crop_, *made_.batches, executor);
  estimated_after_ = made_.state.iterations;
}

template <Spectrum S_>
void RenderRun<S_>::add_to_log() {
  const detail::RunTimer timer(made_.state.seconds, made_.cpu_seconds);
  const bool compares = request_.ranks.of_first(!request_.reference.empty());
  made_.log.add(compares ? whole()->point(request_, latest_error_) : made_.point(request_, latest_error_));
  if (request_.on_log) request_.on_log(made_.log.points().back());
}

#ifdef GMIS_COMPILED
extern template class RenderRun<Vec3<float>>;
extern template class RenderRun<Vec3<double>>;
#endif

}  // namespace gmis
