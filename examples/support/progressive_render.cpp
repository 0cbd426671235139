#include "support/progressive_render.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>

#include "gmis/result/image_error.hpp"
#include "gmis/result/price.hpp"

namespace gmis::tools {

namespace {

/// Adds to two sums the wall and the processor time that pass while it lives.
class Timer {
 public:
  Timer(double& wall, double& cpu) : wall_(wall), cpu_(cpu) {}
  ~Timer() {
    wall_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start_).count();
    cpu_ += static_cast<double>(std::clock() - cpu_start_) / CLOCKS_PER_SEC;
  }
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

 private:
  double& wall_;
  double& cpu_;
  std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  std::clock_t cpu_start_ = std::clock();
};

Image image_of(const Film<SceneSpectrum>& film) {
  Image image(film.resolution().x, film.resolution().y);
  for (std::size_t pixel = 0; pixel < film.pixel_count(); ++pixel)
    for (int c = 0; c < 3; ++c)
      image.rgb[3 * pixel + static_cast<std::size_t>(c)] = static_cast<float>(film.mean(pixel, c));
  return image;
}

/// Of the usual errors, and of half the error that there is.
std::optional<PriceTable> prices_of(const ConvergenceLog& log, double error) {
  std::vector<double> errors(PriceTable::usual_errors.begin(), PriceTable::usual_errors.end());
  errors.push_back(error / 2);
  return price_table(log.points(), errors);
}

}  // namespace

ProgressiveRender::ProgressiveRender(const BuiltScene& scene, const RenderRequest& request)
    : request_(request),
      resolution_(scene.scene().camera().resolution()),
      crop_(request.crop.value_or(PixelBounds{{0, 0}, resolution_})),
      film_(crop_.upper - crop_.lower),
      techniques_(resolution_, crop_),
      classes_(resolution_, crop_) {
  const Timer timer(progress_.seconds, cpu_seconds_);
  engine_ = start(scene, request);
  if (request.halves) halves_.assign(2, Film<Spectrum>(film_.resolution()));
  if (request.intervals || request.budget.relative_error)
    batches_.emplace(film_.resolution(), is_replicated() ? sobol_replications : 0);
}

bool ProgressiveRender::advance(ThreadedExecutor& executor) {
  {
    const Timer timer(progress_.seconds, cpu_seconds_);
    engine_->iterate(executor);
    if (executor.is_stopped()) return false;
    double ignored = 0;
    const Timer film_timer(film_seconds_, ignored);
    take_frame();
  }
  counters_ = engine_->counters();  // of whole iterations only
  light_work_ = engine_->light_work();
  const RejectionLog rejected = engine_->rejections();
  rejected_paths_.assign(rejected.paths().begin(), rejected.paths().end());
  phases_ = engine_->seconds();
  look_at_error();
  if (log_.is_due(progress_.iterations)) add_to_log();
  return true;
}

void ProgressiveRender::add_to_log() {
  double ignored = 0;
  const Timer timer(progress_.seconds, ignored);  // looking at the picture is no part of making it
  log_.add(point());
  if (request_.on_log) request_.on_log(log_.points().back());
}

void ProgressiveRender::finish_log() {
  if (progress_.iterations > 0 && log_.points().back().iteration != progress_.iterations) add_to_log();
}

void ProgressiveRender::take_frame() {
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
  // Even and odd iterations are of different replications, too.
  if (request_.halves) halves_[progress_.iterations % 2].add_iteration(frame_);
  if (request_.techniques)
    engine_->for_each_contribution([&](const Contribution<Spectrum>& contribution) { techniques_.add(contribution); });
  if (request_.class_images)
    engine_->for_each_contribution([&](const Contribution<Spectrum>& contribution) { classes_.add(contribution); });
  ++progress_.iterations;
}

void ProgressiveRender::look_at_error() {
  double ignored = 0;
  const Timer timer(progress_.seconds, ignored);  // looking at the picture is no part of making it
  progress_.is_calibrated = false;                // a run ends by the figure that it then prints, not by an older one
  const bool is_due = request_.budget.relative_error && progress_.iterations >= next_look_;
  if (!batches_ || !(is_due || log_.is_due(progress_.iterations))) return;
  // Eight times in each doubling: an estimate takes about as long as adding ten iterations to a film.
  next_look_ = progress_.iterations + std::max(1U, progress_.iterations / 8);
  latest_error_ = estimate_error(*batches_);
  looked_at_ = progress_.iterations;
  if (!latest_error_) return;
  progress_.relative_error = latest_error_->relative_error;
  progress_.is_calibrated = latest_error_->is_calibrated();
}

std::optional<StopReason> ProgressiveRender::reason_to_stop() const {
  if (request_.interrupted != nullptr && request_.interrupted->load()) return StopReason::interrupt;
  if (request_.rejection_limit.is_surely_exceeded(counters_)) return StopReason::rejected;
  return request_.budget.reason_to_stop(progress_);
}

Image ProgressiveRender::image() const {
  return image_of(film_);
}

std::optional<ErrorEstimate> ProgressiveRender::error() const {
  if (!batches_) return {};
  return looked_at_ == progress_.iterations ? latest_error_ : estimate_error(*batches_);
}

ConvergencePoint ProgressiveRender::point() const {
  ConvergencePoint point;
  point.cpu_seconds = cpu_seconds_;
  point.wall_seconds = progress_.seconds;
  point.iteration = progress_.iterations;
  if (const auto estimate = error()) {
    point.estimated_error = estimate->relative_error;
    if (estimate->is_calibrated()) point.interval = estimate->interval;
  }
  if (request_.reference != nullptr) {
    const Image shown = image();
    point.reference_error = std::sqrt(
        image_error(std::span<const float>(shown.rgb), std::span<const float>(request_.reference->rgb), 3).relmse);
  }
  return point;
}

RenderResult ProgressiveRender::result(StopReason reason) const {
  RenderResult result;
  result.stopped_by = gmis::name_of(reason);
  result.iterations = progress_.iterations;
  result.wall_seconds = progress_.seconds;
  result.cpu_seconds = cpu_seconds_;
  result.image = image();
  if (request_.halves) {
    result.half_a = image_of(halves_[0]);
    result.half_b = image_of(halves_[1]);
  }
  if (request_.techniques) result.techniques = techniques_.means(progress_.iterations);
  if (request_.class_images) result.classes = classes_.result(progress_.iterations, counters_, light_work_);
  result.estimate = estimate_of(film_);
  // The film takes iterations for independent.
  if (is_replicated())
    result.estimate.variance = batches_ ? variance_of_mean(*batches_) : std::numeric_limits<double>::quiet_NaN();
  result.error = error();
  if (result.error) result.prices = prices_of(log_, result.error->relative_error);
  result.counters = counters_;
  result.rejected_paths = rejected_paths_;
  result.counts = engine_->counts();
  result.radius = engine_->first_radius();
  if (const Choice* choice = engine_->choice()) result.choice = *choice;
  result.phases = phases_;
  result.phases.film += film_seconds_;
  result.photon_bytes = engine_->photon_bytes();
  return result;
}

}  // namespace gmis::tools
