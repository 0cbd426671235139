#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "gmis/check/density_test.hpp"
#include "gmis/check/findings.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/mis/moments.hpp"

namespace gmis::detail {

/// Statistics over many draws of a BSDF, at one point or at all points of a group of surfaces: the
/// density of directions, the mean weight of samples beside ∫ f |cos| and beside the albedo.
template <Spectrum S>
class ScatterStatistics {
 public:
  using T = ScalarOf<S>;
  using V = Vec3<double>;
  static constexpr std::size_t channels = static_cast<std::size_t>(SpectrumTraits<S>::channel_count);

  /// Draws `samples` times at one point, for light from `to_prev`.
  template <Bsdf B, UniformSource Source>
  void draw(const B& bsdf, const V& normal, const Vec3<T>& to_prev, TransportMode mode, std::size_t samples,
            Source& source) {
    mode_ = mode;
    const CapMixture known = pilot(bsdf, to_prev, source);
    for (std::size_t i = 0; i < samples; ++i) {
      add_sample(bsdf, normal, to_prev, known, source);
      add_known(bsdf, normal, to_prev, known, source);
    }
    for (std::size_t c = 0; c < channels; ++c) albedo_[c].add(channel(bsdf.albedo(), c));
    is_purely_delta_ = is_purely_delta_ && bsdf.is_purely_delta();
  }
  /// Joins the draws at another point.
  void add(const ScatterStatistics& other) {
    directions_.add(other.directions_);
    for (std::size_t c = 0; c < channels; ++c) {
      sampled_[c].merge(other.sampled_[c]);
      integral_[c].merge(other.integral_[c]);
      smooth_weight_[c].merge(other.smooth_weight_[c]);
      weight_[c].merge(other.weight_[c]);
      albedo_[c].merge(other.albedo_[c]);
    }
    deltas_ += other.deltas_;
    scattered_ += other.scattered_;
    is_purely_delta_ = is_purely_delta_ && other.is_purely_delta_;
    mode_ = other.mode_;
  }

  /// Verdicts on the draws. `level`: bound on the probability of a false alarm of the tests of the
  /// densities. Weights have no bound: ten standard errors allow for skewed distributions.
  void judge(Findings& findings, double level) const {
    if (weight_[0].count() < 2) return;
    if (scattered_ > 0)
      findings.judge(Convention::bsdf_distribution, directions_.passes(level / 2.0), directions_.integral(),
                     directions_.share());
    if (lobes_.size() <= most_lobes)  // with more of them `Convention::bsdf_delta` is broken
      for (const DeltaLobe& lobe : lobes_) judge_lobe(findings, lobe, level / (2.0 * most_lobes));
    findings.judge(Convention::bsdf_delta, is_purely_delta_ || deltas_ == 0 || deltas_ < weight_[0].count());
    double weight = 0.0, error = 0.0, albedo = 0.0;
    for (std::size_t c = 0; c < channels; ++c) {
      const double drawn = smooth_weight_[c].mean(), wanted = drawn + integral_[c].mean() - sampled_[c].mean();
      const double noise = 10.0 * std::hypot(error_of(sampled_[c]), error_of(integral_[c]));
      findings.judge(Convention::bsdf_mean_weight, std::abs(drawn - wanted) <= 0.01 * std::max(drawn, wanted) + noise,
                     drawn, wanted);
      if (weight_[c].mean() > weight) weight = weight_[c].mean(), error = error_of(weight_[c]);
      albedo = std::max(albedo, albedo_[c].mean());
    }
    if (mode_ == TransportMode::importance)
      findings.judge(Convention::bsdf_energy, weight <= 1.02 + 10.0 * error, weight, 1.0);
    findings.judge(Convention::bsdf_albedo, albedo > 0.0 || weight <= 1e-3, albedo, weight);
  }
  /// Verdict on the albedo, which is a mean over directions: for the draws at many points.
  void judge_albedo(Findings& findings) const {
    if (weight_[0].count() < 2) return;
    for (std::size_t c = 0; c < channels; ++c) {
      const double weight = weight_[c].mean(), albedo = albedo_[c].mean();
      // A dark coat scatters .04 where the mean over directions is .1, which decides nothing.
      if (std::abs(weight - albedo) < 0.1) continue;
      const double noise = 10.0 * error_of(weight_[c]);
      findings.judge(Convention::bsdf_albedo_share, weight <= 2.2 * albedo + noise && weight >= albedo / 2.2 - noise,
                     albedo, weight);
    }
  }

 private:
  /// The draws of one delta lobe at one point.
  struct DeltaLobe {
    V to_next;
    Moments<double> stated;  ///< its probability, as each draw states it
  };
  static constexpr std::size_t most_lobes = 4;
  static constexpr double rounding_of_directions = 200.0 * static_cast<double>(std::numeric_limits<T>::epsilon());

  [[nodiscard]] static double channel(const S& s, std::size_t c) {
    return static_cast<double>(SpectrumTraits<S>::channel(s, static_cast<int>(c)));
  }
  [[nodiscard]] static double error_of(const Moments<double>& values) {
    return values.count() < 2 ? 0.0 : std::sqrt(values.variance() / static_cast<double>(values.count()));
  }
  void judge_lobe(Findings& findings, const DeltaLobe& lobe, double level) const {
    const std::size_t count = weight_[0].count(), times = lobe.stated.count();
    findings.judge(Convention::bsdf_delta_frequency, fits_frequency(times, count, lobe.stated.mean(), level),
                   lobe.stated.mean(), static_cast<double>(times) / static_cast<double>(count));
  }
  void add_delta(const ScatterSample<S>& drawn) {
    ++deltas_;
    const V to_next(drawn.to_next);
    auto lobe = std::find_if(lobes_.begin(), lobes_.end(),
                             [&](const DeltaLobe& known) { return glm::length(known.to_next - to_next) < 1e-4; });
    if (lobe == lobes_.end()) {
      if (lobes_.size() > most_lobes) return;
      lobe = lobes_.insert(lobe, {to_next, {}});
    }
    lobe->stated.add(static_cast<double>(drawn.pdf.forward.value));
  }
  template <class B, class Source>
  [[nodiscard]] auto sample(const B& bsdf, const Vec3<T>& to_prev, Source& source) const {
    const T u = uniform<T>(source), v = uniform<T>(source);
    return bsdf.sample(to_prev, u, {v, uniform<T>(source)}, mode_);
  }
  /// A known density near that of the sampler, by draws of its own.
  template <class B, class Source>
  [[nodiscard]] CapMixture pilot(const B& bsdf, const Vec3<T>& to_prev, Source& source) const {
    std::vector<V> draws;
    for (int i = 0; i < 400; ++i)
      if (const auto drawn = sample(bsdf, to_prev, source); drawn && !drawn->is_delta)
        draws.push_back(glm::normalize(V(drawn->to_next)));
    return {draws, rounding_of_directions, source};
  }
  template <class B, class Source>
  void add_sample(const B& bsdf, const V& normal, const Vec3<T>& to_prev, const CapMixture& known, Source& source) {
    const auto drawn = sample(bsdf, to_prev, source);
    const bool is_smooth = drawn && !drawn->is_delta;
    const auto add_weight = [&](double share) {
      for (std::size_t c = 0; c < channels; ++c) {
        const double weight = drawn ? finite(channel(drawn->weight, c)) : 0.0;
        weight_[c].add(weight);
        smooth_weight_[c].add(is_smooth ? weight : 0.0);
        sampled_[c].add(is_smooth ? share * weight : 0.0);
      }
    };
    if (drawn && drawn->is_delta) add_delta(*drawn);
    if (!is_smooth) {
      add_weight(0.0);
      return directions_.add_failure();
    }
    // Where f is 0 no density is ever read: a sampler may fail there, or state any.
    const auto f = bsdf.evaluate(to_prev, drawn->to_next, mode_);
    const V direction = glm::normalize(V(drawn->to_next));
    const double density = stated_density(f), known_density = known.density(direction);
    add_weight(known_density / (density + known_density));
    scattered_ += is_black(f.value) ? 0U : 1U;
    directions_.add_sample(!is_black(f.value), density, known_density, known.factors(direction, normal));
  }
  template <class B, class Source>
  void add_known(const B& bsdf, const V& normal, const Vec3<T>& to_prev, const CapMixture& known, Source& source) {
    const V direction = known.draw(source);
    const auto f = bsdf.evaluate(to_prev, Vec3<T>(direction), mode_);
    const double density = stated_density(f), known_density = known.density(direction);
    scattered_ += is_black(f.value) ? 0U : 1U;
    const double share = std::abs(glm::dot(normal, direction)) / (density + known_density);
    for (std::size_t c = 0; c < channels; ++c) integral_[c].add(finite(channel(f.value, c)) * share);
    directions_.add_known(is_black(f.value) ? 0.0 : density, known_density, known.factors(direction, normal));
  }
  [[nodiscard]] static double stated_density(const BsdfValue<S>& f) noexcept {
    return std::max(0.0, finite(static_cast<double>(f.pdf.forward.value)));
  }
  [[nodiscard]] static double finite(double x) noexcept { return std::isfinite(x) ? x : 0.0; }

  DensityTest directions_;
  // ∫ f |cos| u/(p + u) by samples, of the density p, and by draws of the known density u:
  // directions that u hardly draws, such as the tail of a lobe, count in neither.
  std::array<Moments<double>, channels> sampled_, integral_;
  std::array<Moments<double>, channels> smooth_weight_, weight_, albedo_;
  std::size_t deltas_ = 0, scattered_ = 0;
  std::vector<DeltaLobe> lobes_;  ///< at this point: `add` joins none, for another point has other directions
  bool is_purely_delta_ = true;
  TransportMode mode_ = TransportMode::importance;
};

}  // namespace gmis::detail
