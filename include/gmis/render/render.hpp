#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/state_archive.hpp"
#include "gmis/render/contribution_sums.hpp"
#include "gmis/render/render_request.hpp"
#include "gmis/render/render_result.hpp"
#include "gmis/render/run_identity.hpp"
#include "gmis/result/batch_means.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/transport/render_engine.hpp"

namespace gmis {

namespace detail {

/// Adds the wall time and the processor time of its lifetime to two sums.
class RunTimer {
 public:
  RunTimer(double& wall, double& cpu) : wall_(wall), cpu_(cpu) {}
  ~RunTimer() {
    wall_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start_).count();
    cpu_ += static_cast<double>(std::clock() - cpu_start_) / CLOCKS_PER_SEC;
  }
  RunTimer(const RunTimer&) = delete;
  RunTimer& operator=(const RunTimer&) = delete;

 private:
  double& wall_;
  double& cpu_;
  std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  std::clock_t cpu_start_ = std::clock();
};

}  // namespace detail

/// An executor that can be told to begin no further work. `stop_when(flag)`: from now on, or never again for a null
/// pointer, work that has not begun is left out while `*flag` is true. `is_stopped()`: whether work is being left out.
template <class E>
concept StoppableExecutor = Executor<E> && requires(E& executor, const std::atomic<bool>* flag) {
  executor.stop_when(flag);
  { executor.is_stopped() } -> std::convertible_to<bool>;
};

/// A rendering that improves iteration by iteration: engine, film, error, convergence log and limits.
///
/// ```
/// gmis::Render render(scene, gmis::automatic_request(scene, {.iterations = 64}));
/// const gmis::RenderResult result = render.run(executor);
/// ```
///
/// `run` renders until a limit of the budget is met. A program with a loop of its own calls `advance` and
/// `reason_to_stop`; several renderings can then take turns. The scene must outlive the rendering. The constructor
/// throws `std::invalid_argument` for invalid settings, as the engines do.
///
/// The same seed and settings give the same pictures for any number of threads. A limit on time or on the error changes
/// the number of iterations alone.
template <Scene Sc, class Source = SampleNumbers>
class Render {
 public:
  using S = typename Sc::Spectrum;
  /// The engine that is run.
  using Engine = RenderEngine<Sc, Source>;

  /// Prepares a run over `scene`, which must outlive it.
  Render(const Sc& scene, RenderRequest request)
      : scene_(scene),
        request_(std::move(request)),
        resolution_(scene.camera().resolution()),
        crop_(clipped(request_.crop, resolution_)),
        film_(crop_.upper - crop_.lower),
        techniques_(resolution_, crop_),
        classes_(resolution_, crop_) {
    const detail::RunTimer timer(state_.seconds, cpu_seconds_);
    make_engine();
    if (request_.halves) halves_.assign(2, Film<S>(film_.resolution()));
    if (request_.intervals || request_.budget.relative_error)
      batches_.emplace(film_.resolution(), is_replicated() ? sobol_replications : 0);
  }
  Render(const Render&) = delete;
  Render& operator=(const Render&) = delete;

  /// Renders until a limit is met, and calls the callbacks of the request. With a `StoppableExecutor`, an interrupt
  /// after the first iteration leaves out the iteration under way; with another executor that iteration is finished.
  template <Executor E>
  RenderResult run(E& executor) {
    const auto stop_when = [&](const std::atomic<bool>* flag) {
      if constexpr (StoppableExecutor<E>) executor.stop_when(flag);
    };
    stop_when(nullptr);
    double last_picture = state_.seconds;
    std::optional<double> last_checkpoint;  // in seconds of the run
    std::optional<StopReason> reason;
    if (state_.iterations > 0) reason = reason_to_stop();
    while (!reason) {
      if (!advance(executor)) {
        reason = StopReason::interrupt;
        break;
      }
      if (request_.on_iteration) request_.on_iteration(state_);
      reason = reason_to_stop();
      if (!reason && request_.on_picture && state_.seconds - last_picture >= request_.seconds_between_pictures) {
        last_picture = state_.seconds;
        request_.on_picture(picture());
      }
      if (request_.on_checkpoint &&
          (reason || !last_checkpoint || state_.seconds - *last_checkpoint >= request_.seconds_between_pictures)) {
        last_checkpoint = state_.seconds;
        request_.on_checkpoint(checkpoint());
      }
      stop_when(request_.interrupt);  // from now on there is a picture
    }
    stop_when(nullptr);
    finish_log();
    return result(*reason);
  }

  /// Renders one more iteration. Returns false when the executor was stopped meanwhile: this iteration is left out, and
  /// the rendering cannot go on.
  template <Executor E>
  [[nodiscard]] bool advance(E& executor) {
    {
      const detail::RunTimer timer(state_.seconds, cpu_seconds_);
      engine_->iterate(executor);
      if constexpr (StoppableExecutor<E>)
        if (executor.is_stopped()) return false;
      double ignored = 0.0;
      const detail::RunTimer film_timer(film_seconds_, ignored);
      take_frame();
    }
    counters_ = engine_->counters();  // of whole iterations only
    light_work_ = engine_->light_work();
    const RejectionLog rejected = engine_->rejections();
    rejected_paths_.assign(rejected.paths().begin(), rejected.paths().end());
    phases_ = engine_->seconds();
    update_error();
    if (log_.is_due(state_.iterations)) add_to_log();
    return true;
  }

  /// The state after the latest iteration, from which the same program can go on (`resume`). To be written to a file
  /// that replaces the one before it.
  [[nodiscard]] std::vector<std::byte> checkpoint() {
    StateWriter state;
    state(request_.expected_iterations);
    exchange_state(state);
    const std::vector<std::byte>& bytes = state.bytes();
    std::string format{checkpoint_format};
    RunIdentity identity = identity_of_this();
    std::uint64_t digest = digest_of(bytes), size = bytes.size();
    StateWriter whole;
    whole(format, identity, digest, size);
    std::vector<std::byte> result = whole.bytes();
    result.insert(result.end(), bytes.begin(), bytes.end());
    return result;
  }

  /// Goes on from a checkpoint of a run with the same scene and request; limits, threads and callbacks may differ. The
  /// pictures then have the bits of a run that was never interrupted. Throws `std::invalid_argument` that says what
  /// differs, or that the bytes are damaged; this rendering is then unchanged. Call it before the first iteration.
  void resume(std::span<const std::byte> bytes) {
    StateReader header(bytes);
    std::string format;
    RunIdentity identity;
    std::uint64_t digest = 0, size = 0;
    header(format);
    if (header.is_broken() || format != checkpoint_format) refuse("this is no checkpoint of this version");
    header(identity, digest, size);
    if (header.is_broken()) refuse("the checkpoint is cut short");
    if (const std::string difference = identity.difference_to(identity_of_this()); !difference.empty())
      refuse(std::string("the checkpoint is of another run: ").append(difference));
    if (size != header.left().size()) refuse("the checkpoint is cut short or longer than it says");
    if (digest != digest_of(header.left())) refuse("the checkpoint is damaged: its digest differs");
    StateReader state(header.left());
    state(request_.expected_iterations);  // the choice of a pilot depends on it
    make_engine();
    exchange_state(state);
    if (state.is_broken() || !state.is_at_end()) refuse("the checkpoint is damaged");
  }

  /// Adds the latest iteration to the convergence log unless it is there.
  void finish_log() {
    if (state_.iterations > 0 && log_.points().back().iteration != state_.iterations) add_to_log();
  }

  /// The limit that is met after the iterations so far (at least one), or nothing to go on.
  [[nodiscard]] std::optional<StopReason> reason_to_stop() const {
    if (request_.interrupt != nullptr && request_.interrupt->load()) return StopReason::interrupt;
    if (request_.rejection_limit.is_surely_exceeded(counters_)) return StopReason::rejected;
    return request_.budget.reason_to_stop(state_);
  }

  /// Iterations and wall time so far. The error in it is known when it was estimated after the latest iteration.
  [[nodiscard]] const RunState& progress() const noexcept { return state_; }
  /// Processor time of the iterations so far, without estimates of the error.
  [[nodiscard]] double cpu_seconds() const noexcept { return cpu_seconds_; }
  /// The film so far.
  [[nodiscard]] const Film<S>& film() const noexcept { return film_; }
  /// The picture of the latest iteration alone, inside the crop.
  [[nodiscard]] std::span<const S> frame() const noexcept { return frame_; }
  /// The picture so far.
  [[nodiscard]] Picture picture() const { return picture_of(film_); }
  /// Error and time of the iterations so far.
  [[nodiscard]] const ConvergenceLog& log() const noexcept { return log_; }
  /// The engine that is run.
  [[nodiscard]] const Engine& engine() const noexcept { return *engine_; }

  /// The estimated error, with `RenderRequest::intervals` or a limit on the error, from the second iteration on.
  [[nodiscard]] std::optional<ErrorEstimate> error() const {
    if (!batches_) return {};
    return estimated_after_ == state_.iterations ? latest_error_ : estimate_error(*batches_);
  }

  /// The prices of the usual errors, and of half the present one.
  [[nodiscard]] std::optional<PriceTable> prices() const {
    const auto present = error();
    if (!present) return {};
    std::vector<double> errors(PriceTable::usual_errors.begin(), PriceTable::usual_errors.end());
    errors.push_back(present->relative_error / 2.0);
    return price_table(log_.points(), errors);
  }

  /// All there is to know about the run so far; `reason` says why it ended.
  [[nodiscard]] RenderResult result(StopReason reason) const {
    RenderResult result;
    result.stopped_by = reason;
    result.iterations = state_.iterations;
    result.wall_seconds = state_.seconds;
    result.cpu_seconds = cpu_seconds_;
    result.phases = phases_;
    result.phases.film += film_seconds_;
    result.picture = picture();
    if (request_.halves) {
      result.half_a = picture_of(halves_[0]);
      result.half_b = picture_of(halves_[1]);
    }
    if (request_.techniques) result.techniques = techniques_.means(state_.iterations);
    if (request_.class_pictures) result.classes = classes_.means(state_.iterations, counters_, light_work_);
    if (film_.pixel_count() > 0) result.estimate = estimate_of(film_);
    // The film takes iterations for independent.
    if (is_replicated()) {
      const std::vector<double> variances = batches_ ? variances_of_means(*batches_) : std::vector<double>();
      result.estimate.variance = batches_ ? variance_of_mean(*batches_) : std::numeric_limits<double>::quiet_NaN();
      if (!variances.empty()) {
        result.variance = Picture(film_.resolution(), Film<S>::channel_count);
        std::transform(variances.begin(), variances.end(), result.variance.values.begin(),
                       [](double variance) { return static_cast<float>(variance); });
      }
    } else if (film_.iterations() > 1) {
      result.variance = variance_picture_of(film_);
    }
    result.error = error();
    result.prices = prices();
    result.log = log_.points();
    result.counters = counters_;
    result.is_trustworthy = !request_.rejection_limit.is_exceeded(counters_);
    result.rejected_paths = rejected_paths_;
    result.counts = engine_->counts();
    if (const Choice* choice = engine_->choice()) result.choice = *choice;
    result.radius = engine_->first_radius();
    result.photon_bytes = engine_->photon_bytes();
    return result;
  }

 private:
  static constexpr std::string_view checkpoint_format = "gmis checkpoint 1\n";

  [[noreturn]] static void refuse(const std::string& message) { reject_argument(message.c_str()); }
  [[nodiscard]] RunIdentity identity_of_this() const {
    return identity_of(request_, resolution_, Film<S>::channel_count, sizeof(ScalarOf<S>));
  }
  void make_engine() {
    engine_.emplace(scene_, request_.settings, request_.candidates, request_.expected_iterations, request_.crop);
    engine_->keep_contributions(request_.techniques || request_.class_pictures);
  }
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(*engine_, film_, techniques_, classes_, log_, state_, cpu_seconds_, latest_error_, estimated_after_,
            next_estimate_, counters_, light_work_, rejected_paths_, phases_, film_seconds_);
    // The request, which is the same, says whether these are there.
    if (batches_) archive(*batches_);
    for (Film<S>& half : halves_) archive(half);
  }

  [[nodiscard]] bool is_replicated() const noexcept { return request_.settings.sampler == Sampler::sobol; }

  [[nodiscard]] static PixelBounds clipped(const std::optional<PixelBounds>& crop, glm::ivec2 resolution) {
    PixelBounds part = crop.value_or(PixelBounds{{0, 0}, resolution});
    part.lower = glm::clamp(part.lower, glm::ivec2(0), glm::max(resolution, glm::ivec2(0)));
    part.upper = glm::clamp(part.upper, part.lower, glm::max(resolution, part.lower));
    return part;
  }

  void take_frame() {
    frame_ = engine_->frame();
    const glm::ivec2 size = film_.resolution();
    if (size != resolution_) {
      part_.clear();
      for (int y = crop_.lower.y; y < crop_.upper.y; ++y) {
        const auto row = frame_.subspan(static_cast<std::size_t>(y) * static_cast<std::size_t>(resolution_.x) +
                                            static_cast<std::size_t>(crop_.lower.x),
                                        static_cast<std::size_t>(size.x));
        part_.insert(part_.end(), row.begin(), row.end());
      }
      frame_ = part_;
    }
    film_.add_iteration(frame_);
    if (batches_) batches_->add_iteration(frame_);
    // With replications, even and odd iterations belong to different ones, too.
    if (request_.halves) halves_[state_.iterations % 2].add_iteration(frame_);
    if (request_.techniques || request_.class_pictures)
      engine_->for_each_contribution([&](const Contribution<S>& contribution) {
        if (request_.techniques) techniques_.add(contribution);
        if (request_.class_pictures) classes_.add(contribution);
      });
    ++state_.iterations;
  }

  void update_error() {
    double ignored = 0.0;
    const detail::RunTimer timer(state_.seconds, ignored);
    state_.is_calibrated = false;  // an older estimate must not end the run
    const bool is_due = request_.budget.relative_error && state_.iterations >= next_estimate_;
    if (!batches_ || !(is_due || log_.is_due(state_.iterations))) return;
    // Eight times per doubling: an estimate takes about as long as adding ten iterations to a film.
    next_estimate_ = state_.iterations + std::max(1U, state_.iterations / 8);
    latest_error_ = estimate_error(*batches_);
    estimated_after_ = state_.iterations;
    if (!latest_error_) return;
    state_.relative_error = latest_error_->relative_error;
    state_.is_calibrated = latest_error_->is_calibrated();
  }

  void add_to_log() {
    double ignored = 0.0;
    const detail::RunTimer timer(state_.seconds, ignored);
    ConvergencePoint point;
    point.cpu_seconds = cpu_seconds_;
    point.wall_seconds = state_.seconds;
    point.iteration = state_.iterations;
    if (const auto estimate = error()) {
      point.estimated_error = estimate->relative_error;
      if (estimate->is_calibrated()) point.interval = estimate->interval;
    }
    if (!request_.reference.empty()) {
      const Picture shown = picture();
      point.reference_error = std::sqrt(
          image_error(std::span<const float>(shown.values), request_.reference, Film<S>::channel_count).relmse);
    }
    log_.add(point);
    if (request_.on_log) request_.on_log(log_.points().back());
  }

  const Sc& scene_;
  RenderRequest request_;
  glm::ivec2 resolution_;
  PixelBounds crop_;
  std::optional<Engine> engine_;
  Film<S> film_;
  std::vector<Film<S>> halves_;
  std::optional<BatchMeans<S>> batches_;
  TechniqueSums<S> techniques_;
  ClassSums<S> classes_;
  std::span<const S> frame_;  ///< of the engine, or `part_`
  std::vector<S> part_;
  RunState state_;
  double cpu_seconds_ = 0.0;
  std::optional<ErrorEstimate> latest_error_;  ///< after the iteration `estimated_after_`
  std::uint32_t estimated_after_ = 0, next_estimate_ = 2;
  ConvergenceLog log_;
  // Of the latest whole iteration.
  Counters counters_, light_work_;
  std::vector<RejectedPath> rejected_paths_;
  PhaseSeconds phases_;
  double film_seconds_ = 0.0;
};

}  // namespace gmis
