#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// \file
/// What `check_scene`, `check_camera`, `check_light` and `check_surface` report: which convention of the interface
/// (core/concepts.hpp, core/interaction.hpp) is broken, in words.

namespace gmis {

/// A convention of the interface between a renderer and the engine. `sentence_of` says it in words.
enum class Convention : std::uint8_t {
  camera_ray_unit,
  camera_pixel,
  camera_to_camera,
  camera_two_densities,
  camera_two_weights,
  camera_density,
  hit_on_ray,
  hit_range,
  hit_normal_unit,
  hit_normal_hemisphere,
  hit_normal_slant,
  hit_normal_turned,
  hit_same_surface,
  visible_false,
  visible_true,
  light_choice,
  light_frequency,
  receiver_choice,
  receiver_frequency,
  receiver_reach,
  light_infinite_list,
  light_not_hit,
  light_delta_densities,
  next_event_direction,
  next_event_two_densities,
  next_event_emission_density,
  next_event_weight,
  next_event_distribution,
  emission_unit,
  emission_two_densities,
  emission_weight,
  emission_origin_distribution,
  emission_direction_distribution,
  emission_disk,
  emission_intensity,
  bsdf_unit,
  bsdf_value,
  bsdf_two_densities,
  bsdf_two_reverse_densities,
  bsdf_weight,
  bsdf_distribution,
  bsdf_reverse,
  bsdf_reciprocity,
  bsdf_energy,
  bsdf_albedo,
  bsdf_albedo_of_point,
  bsdf_through,
  bsdf_reflects_only,
  bsdf_delta,
  bsdf_eta,
  bsdf_delta_adjoint,
  bsdf_delta_reverse,
};
/// How many conventions there are.
inline constexpr std::size_t convention_count = static_cast<std::size_t>(Convention::bsdf_delta_reverse) + 1;

/// The convention, which member breaks it, and the usual mistakes.
[[nodiscard]] constexpr std::string_view sentence_of(Convention convention) noexcept {
  constexpr std::array<std::string_view, convention_count> sentences{
      "Camera::sample_ray: the direction must have unit length",
      "Camera::project must find the pixel whose ray passes the point (x to the right, y down, from the upper left): "
      "it "
      "finds another one, so one of the two members flips an axis or shifts pixels",
      "CameraProjection::to_camera must be the unit vector from the point to the lens",
      "Camera: project and sample_ray must state the same density for the same ray",
      "Camera: project and sample_ray must state the same weight for the same ray",
      "Camera: the density must be that of the rays of one pixel (not of the whole picture), per steradian: 1 / (area "
      "of "
      "the pixel on the plane at distance 1 · cos³); per area for parallel rays",
      "Scene::intersect: the position of a hit must lie on the ray, in front of its origin",
      "Scene::intersect must report no hit beyond Ray::t_max",
      "SurfacePoint: both normals of a hit must have unit length",
      "SurfacePoint: the shading normal must lie in the hemisphere of the geometric normal",
      "SurfacePoint::geometric_normal must be perpendicular to the surface, in world space",
      "SurfacePoint::geometric_normal must not be turned towards the ray: the side from which a ray comes must not "
      "change it",
      "Rays that leave a surface must not meet it again at once: set SurfacePoint::position_error to a bound on the "
      "error "
      "of the position, or let the scene ignore hits that near",
      "Scene::visible must be true when nothing lies between 0 and Ray::t_max: it is false between points that see "
      "each "
      "other (t_max ignored, or no room for rounding at its ends)",
      "Scene::visible must be false when a surface lies between 0 and Ray::t_max: it is true where intersect finds one",
      "Scene: sample_light and selection_probability must state the same probability for a light",
      "Scene::selection_probability must be the probability with which sample_light chooses the light",
      "Scene: sample_light(from, u) and selection_probability(light, from) must state the same probability for the "
      "same "
      "receiver",
      "Scene::selection_probability(light, from) must be the probability with which sample_light(from, u) chooses the "
      "light",
      "Scene::selection_probability(light, from) must be positive wherever the light reaches the receiver and is "
      "scattered there",
      "Scene::infinite_lights must list every infinite light that is no delta light",
      "A ray towards a point of a light that is no delta light must hit it, with Hit::light pointing to that light",
      "A delta light must state the density 1 for what it fixes: next_event_density, and EmissionDensity::origin",
      "NextEventSample::to_light must be the unit vector from the receiver to the light (not from the light)",
      "Light: sample_next_event and next_event_density must state the same density",
      "NextEventSample::density must be the density of emission that Light::emitted states for the light's direction "
      "towards the receiver",
      "NextEventSample::weight must be the incident radiance over the density per steradian at the receiver: radiance "
      "· "
      "|cos| / (distance² · next_event_density), for an infinite light radiance / next_event_density; without the "
      "cosine "
      "at the receiver",
      "Light::next_event_density must be the density with which sample_next_event makes the point, per area (for an "
      "infinite light: of the direction, per steradian), without the probability of choosing the light",
      "Light::sample_emission: the direction must have unit length and leave the light",
      "Light: sample_emission and emitted must state the same densities for the same start (origin: per area, first: "
      "per "
      "steradian; for an infinite light origin: per steradian, first: per area on the disk)",
      "EmissionSample::weight must be radiance · |cos| / (origin · first), for an infinite light radiance / (origin · "
      "first)",
      "EmissionDensity::origin must be the density with which sample_emission makes the point, per area (for an "
      "infinite "
      "light: of the direction, per steradian), without the probability of choosing the light",
      "EmissionDensity::first must be the density of the direction alone, per steradian: the density per area and the "
      "probability of choosing the light are not part of it",
      "EmissionDensity::first of an infinite light must be 1 / the area of the disk that sample_emission starts from, "
      "and that disk must cover the scene",
      "A delta light must send the same light in sample_emission and in sample_next_event: intensity / first and "
      "intensity / distance² (for a directional light irradiance / first and irradiance)",
      "Bsdf::sample: to_next must have unit length, in world space",
      "Bsdf: values, densities and weights must be finite and not negative",
      "ScatterSample::pdf.forward must be the density that Bsdf::evaluate states for the same directions, with the "
      "probability of choosing the lobe; a delta lobe must set is_delta",
      "ScatterSample::pdf.reverse must be the reverse density that Bsdf::evaluate states for the same directions",
      "ScatterSample::weight must be f · |cos| / pdf.forward, with f of Bsdf::evaluate, which does not include the "
      "cosine",
      "Bsdf: pdf.forward must be the density per steradian with which sample makes to_next (forward and reverse "
      "swapped, "
      "or not normalised)",
      "Bsdf: pdf.reverse must be the density of the way back: pdf.forward for swapped directions and the other mode",
      "Bsdf: f(a, b) for importance must equal f(b, a) for radiance (a cosine in f, or a mode mistaken)",
      "Bsdf: for importance no more than all light may be scattered: the mean weight of sample is above 1 (factors of "
      "refraction belong to radiance)",
      "Bsdf::albedo must be between 0 and 1, and above 0 where light is scattered; a surface whose albedo is above 0 "
      "must "
      "scatter some (to_prev points away from the surface)",
      "Bsdf::albedo must depend on the point alone, not on the ray that found it",
      "Bsdf::sample: every direction goes through the surface: to_prev and to_next both point away from it",
      "Bsdf::reflects_only must be false where evaluate is not 0 for directions on different sides of the surface: "
      "connections through it are left out",
      "Bsdf: is_purely_delta must be true exactly where evaluate is 0 everywhere and sample makes delta directions "
      "only",
      "ScatterSample::eta must be the index of refraction on the side of to_next over that on the side of to_prev: sin "
      "of "
      "to_prev = eta · sin of to_next",
      "A delta lobe must be adjoint: weight · pdf.forward for radiance, times eta², must equal the same product for "
      "importance on the way back (the factor 1 / eta² belongs to radiance)",
      "A delta lobe: pdf.reverse must be the selection probability of the same lobe on the way back",
  };
  return sentences[static_cast<std::size_t>(convention)];
}

/// One broken convention.
struct Finding {
  /// What is broken.
  Convention convention = Convention::camera_ray_unit;
  std::size_t broken = 0;  ///< cases that break it
  std::size_t tried = 0;   ///< cases tried
};

/// What a check found out.
class Findings {
 public:
  /// Counts one case. A convention counts as broken when more than `tolerated` of its cases break it, and at least 3:
  /// rounding spoils single cases.
  void count(Convention convention, bool holds) noexcept {
    Tally& tally = tallies_[static_cast<std::size_t>(convention)];
    ++tally.tried;
    if (!holds) ++tally.broken;
  }
  /// A verdict that rests on all cases at once.
  void judge(Convention convention, bool holds) noexcept {
    Tally& tally = tallies_[static_cast<std::size_t>(convention)];
    ++tally.tried;
    if (holds) return;
    ++tally.broken;
    tally.is_judged_broken = true;
  }
  /// Joins the cases of another check.
  void add(const Findings& other) noexcept {
    for (std::size_t i = 0; i < convention_count; ++i) {
      tallies_[i].tried += other.tallies_[i].tried;
      tallies_[i].broken += other.tallies_[i].broken;
      tallies_[i].is_judged_broken = tallies_[i].is_judged_broken || other.tallies_[i].is_judged_broken;
    }
  }

  /// The broken conventions, in the order of `Convention`.
  [[nodiscard]] std::vector<Finding> broken() const {
    std::vector<Finding> result;
    for (std::size_t i = 0; i < convention_count; ++i)
      if (is_broken(static_cast<Convention>(i)))
        result.push_back({static_cast<Convention>(i), tallies_[i].broken, tallies_[i].tried});
    return result;
  }
  /// Whether more cases break the convention than rounding explains, or a verdict says so.
  [[nodiscard]] bool is_broken(Convention convention) const noexcept {
    const Tally& tally = tallies_[static_cast<std::size_t>(convention)];
    const double limit = std::max(3.0, tolerated(convention) * static_cast<double>(tally.tried));
    return tally.is_judged_broken || (tally.broken > 0 && static_cast<double>(tally.broken) >= limit);
  }
  /// Cases tried for a convention; 0 says that nothing is known about it.
  [[nodiscard]] std::size_t tried(Convention convention) const noexcept {
    return tallies_[static_cast<std::size_t>(convention)].tried;
  }
  /// True when no convention is broken.
  [[nodiscard]] bool passes() const { return broken().empty(); }

  /// A line for each broken convention; empty when none is.
  [[nodiscard]] std::string text() const {
    std::string result;
    for (const Finding& finding : broken()) {
      result += sentence_of(finding.convention);
      result += " [" + std::to_string(finding.broken) + " of " + std::to_string(finding.tried) + " cases]\n";
    }
    return result;
  }

 private:
  struct Tally {
    std::size_t tried = 0, broken = 0;
    bool is_judged_broken = false;
  };

  /// The share of cases that may break a convention by rounding, at edges and at silhouettes.
  [[nodiscard]] static constexpr double tolerated(Convention convention) noexcept {
    if (convention == Convention::bsdf_reflects_only) return 0.0;  // far from the horizon no rounding hides a side
    return convention == Convention::hit_normal_slant ? 0.5 : 0.05;
  }

  std::array<Tally, convention_count> tallies_{};
};

namespace detail {

/// The mean of values in [0, `largest`], with bounds that hold for every distribution.
class BoundedMean {
 public:
  explicit BoundedMean(double largest) : largest_(largest) {}
  void add(double value) noexcept {
    ++count_;
    const double difference = value - mean_;
    mean_ += difference / static_cast<double>(count_);
    squares_ += difference * (value - mean_);
  }
  [[nodiscard]] double mean() const noexcept { return mean_; }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  /// The distance from the mean that the expectation exceeds with a probability of at most `level`: the empirical
  /// Bernstein bound √(2 V ln(3/level) / n) + 3 b ln(3/level) / n [Audibert, Munos, Szepesvári 2009, theorem 1].
  [[nodiscard]] double reach(double level) const noexcept {
    if (count_ == 0) return largest_;
    const double n = static_cast<double>(count_), logarithm = std::log(3.0 / level);
    return std::sqrt(2.0 * squares_ / n * logarithm / n) + 3.0 * largest_ * logarithm / n;
  }

 private:
  double largest_, mean_ = 0.0, squares_ = 0.0;
  std::size_t count_ = 0;
};

/// Tests whether samples of a set with density p(x) follow it: integrals over the set, by mixture sampling, against means
/// of samples.
///
/// Half of the draws come from the sampler, half from a distribution with the known density u. With the balance weight a
/// draw counts p / (p/2 + u/2), between 0 and 2, and its mean is ∫ p when the sampler follows p. The share of samples in
/// the set has the same expectation. A second pair of means carries a factor h between 0 and 1, which sees a wrong shape
/// with a right integral. All are bounded, so that the test holds however narrow p is.
class DensityTest {
 public:
  /// A draw from the sampler: its stated density, or 0 when it failed or lies outside the set. `h`: any function of the
  /// draw with values in [0, 1].
  void add_sample(double density, double known, double h) noexcept {
    const double is_inside = density > 0.0 ? 1.0 : 0.0;
    for (std::size_t i = 0; i < 2; ++i) {
      const double factor = i == 0 ? 1.0 : h;
      means_[i].share.add(is_inside * factor);
      means_[i].samples.add(value_of(density, known) * factor);
    }
  }
  /// A draw from the known distribution: the density that the sampler states there, 0 outside the set.
  void add_known(double density, double known, double h) noexcept {
    for (std::size_t i = 0; i < 2; ++i) means_[i].known.add(value_of(density, known) * (i == 0 ? 1.0 : h));
  }

  /// `level`: bound on the probability of a false alarm.
  [[nodiscard]] bool passes(double level) const noexcept {
    for (const Means& means : means_) {
      if (means.share.count() == 0 || means.known.count() == 0) return true;
      const double integral = (means.samples.mean() + means.known.mean()) / 2.0, bound = level / 6.0;
      const double reach = (means.samples.reach(bound) + means.known.reach(bound)) / 2.0 + means.share.reach(bound);
      constexpr double rounding = 0.01;
      if (std::abs(integral - means.share.mean()) > reach + rounding) return false;
    }
    return true;
  }

 private:
  struct Means {
    BoundedMean share{1.0}, samples{2.0}, known{2.0};
  };
  [[nodiscard]] static double value_of(double density, double known) noexcept {
    return density > 0.0 ? 2.0 * density / (density + known) : 0.0;
  }
  std::array<Means, 2> means_;
};

/// Equal but for rounding: relative to the larger one, or both negligible.
[[nodiscard]] inline bool nearly(double a, double b, double tolerance = 0.01, double negligible = 1e-12) noexcept {
  const double scale = std::max(std::abs(a), std::abs(b));
  return scale <= negligible || std::abs(a - b) <= tolerance * scale;
}

}  // namespace detail

}  // namespace gmis
