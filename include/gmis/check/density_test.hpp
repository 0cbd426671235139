#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <tuple>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/core/warp.hpp"
#include "gmis/mis/moments.hpp"

/// \file
/// Does a sampler follow the density that it states? Tests whose bounds hold for every
/// distribution.

namespace gmis::detail {

/// Bound on the distance between the mean of values in an interval of length 1 and their
/// expectation, exceeded with a probability of at most `level` for every distribution: the
/// empirical Bernstein bound √(2 V ln(3/level) / n) + 3 ln(3/level) / n [Audibert, Munos,
/// Szepesvári 2009, theorem 1].
[[nodiscard]] inline double bernstein_reach(const Moments<double>& values, double level) noexcept {
  if (values.count() < 2) return 1.0;
  const double n = static_cast<double>(values.count()), logarithm = std::log(3.0 / level);
  return std::sqrt(2.0 * values.variance() * logarithm / n) + 3.0 * logarithm / n;
}

/// False where an event of probability `p` that came `times` times in `count` draws came too often
/// or too seldom, by Bernstein's inequality; with a probability of at most `level` by chance.
[[nodiscard]] inline bool fits_frequency(std::size_t times, std::size_t count, double p, double level) noexcept {
  const double n = static_cast<double>(count), share = static_cast<double>(times) / n;
  const double logarithm = std::log(2.0 / level);
  const double reach = std::sqrt(2.0 * std::max(p * (1.0 - p), 0.0) * logarithm / n) + logarithm / n;
  return std::abs(share - p) <= reach + 1e-4;
}

/// A density over the sphere that is known and lies near that of a sampler: a tenth is uniform, the
/// rest uniform over caps around directions that the sampler drew, wide enough to hold a fifth or a
/// twentieth of its draws.
class CapMixture {
 public:
  using V = Vec3<double>;
  /// With fewer draws it is uniform over the sphere.
  static constexpr std::size_t least_draws = 40;

  /// Uniform over the sphere.
  CapMixture() = default;
  /// `draws`: directions of the sampler. `least_drop`: 1 − cos of the narrowest cap whose
  /// directions have enough digits.
  template <UniformSource Source>
  CapMixture(std::span<const V> draws, double least_drop, Source& source) {
    if (draws.size() < least_draws) return;
    std::vector<double> drops(draws.size());
    for (std::size_t k = 0; k < caps; ++k) {
      const V& center = draws[uniform_index(source, static_cast<std::uint32_t>(draws.size()))];
      for (std::size_t i = 0; i < draws.size(); ++i) drops[i] = drop_between(center, draws[i]);
      const auto held = drops.begin() + static_cast<std::ptrdiff_t>(draws.size() / (k % 2 == 0 ? 5 : 20));
      std::nth_element(drops.begin(), held, drops.end());
      caps_.push_back({center, std::clamp(1.05 * *held, least_drop, 2.0)});
    }
  }

  /// Per steradian.
  [[nodiscard]] double density(const V& direction) const noexcept {
    constexpr double uniform_density = 1.0 / (4.0 * pi<double>);
    if (caps_.empty()) return uniform_density;
    double sum = 0.0;
    for (const Cap& cap : caps_)
      if (cap.holds(direction)) sum += 1.0 / (2.0 * pi<double> * cap.drop);
    return spread * uniform_density + (1.0 - spread) * sum / static_cast<double>(caps_.size());
  }
  /// A direction with this density.
  template <UniformSource Source>
  [[nodiscard]] V draw(Source& source) const {
    const double choice = uniform<double>(source), u = uniform<double>(source), v = uniform<double>(source);
    if (caps_.empty() || choice < spread) return square_to_sphere(Vec2<double>(u, v));
    const Cap& cap = caps_[uniform_index(source, static_cast<std::uint32_t>(caps_.size()))];
    return glm::normalize(Frame<double>::around(cap.center).to_world(square_to_cone(Vec2<double>(u, v), cap.drop)));
  }
  /// Five functions of a direction with values in [0, 1] by which a wrong shape shows where the
  /// integral is right: all, both sides of `axis`, and two caps that hold a fifth of the draws.
  [[nodiscard]] std::array<double, 5> factors(const V& direction, const V& axis) const noexcept {
    const double side = std::clamp((1.0 + glm::dot(direction, axis)) / 2.0, 0.0, 1.0);
    if (caps_.empty()) return {1.0, side, 1.0 - side, 0.0, 0.0};
    return {1.0, side, 1.0 - side, caps_[0].holds(direction) ? 1.0 : 0.0, caps_[2].holds(direction) ? 1.0 : 0.0};
  }

 private:
  static constexpr std::size_t caps = 24;
  static constexpr double spread = 0.1;

  /// 1 − cos of the angle, with all digits where it is small.
  [[nodiscard]] static double drop_between(const V& a, const V& b) noexcept { return glm::dot(a - b, a - b) / 2.0; }
  struct Cap {
    V center;
    double drop;
    [[nodiscard]] bool holds(const V& direction) const noexcept { return drop_between(center, direction) <= drop; }
  };
  std::vector<Cap> caps_;
};

/// Tests whether samples follow their stated density p(x), by mixture sampling.
///
/// Half of the draws come from the sampler, half from a distribution with the known density u.
/// Where the sampler follows p, the balance heuristic gives ∫ p h = E_p[h p/(p + u)] + E_u[h p/(p +
/// u)] for every function h, and E_p[h] is the same integral; their difference is tested. All terms
/// are bounded, so that the test holds however narrow p is. A factor c too much in p changes the
/// difference by E_p[h (c − 1) / (c p/u + 1)]: u must be near p, or the test is blind to it.
class DensityTest {
 public:
  using Factors = std::array<double, 5>;

  /// A draw of the sampler that failed.
  void add_failure() noexcept { add_sample(false, 0.0, 1.0, {}); }
  /// A draw of the sampler: whether it lies in the set where samples count, the density stated for
  /// it, the known density. `h`: any functions of the draw with values in [0, 1].
  void add_sample(bool is_inside, double density, double known, const Factors& h) noexcept {
    for (std::size_t i = 0; i < h.size(); ++i) {
      means_[i].samples.add(is_inside ? h[i] * (share_of(density, known) - 1.0) : 0.0);
      means_[i].inside.add(is_inside ? h[i] : 0.0);
    }
  }
  /// A draw from the known distribution: the density that the sampler states there, 0 where no
  /// sample counts.
  void add_known(double density, double known, const Factors& h) noexcept {
    for (std::size_t i = 0; i < h.size(); ++i) means_[i].known.add(h[i] * share_of(density, known));
  }
  /// Joins the draws of another test.
  void add(const DensityTest& other) noexcept {
    for (std::size_t i = 0; i < means_.size(); ++i) {
      means_[i].samples.merge(other.means_[i].samples);
      means_[i].inside.merge(other.means_[i].inside);
      means_[i].known.merge(other.means_[i].known);
    }
  }

  /// `level`: bound on the probability of a false alarm.
  [[nodiscard]] bool passes(double level) const noexcept {
    if (means_[0].samples.count() == 0 || means_[0].known.count() == 0) return true;
    constexpr double rounding = 0.01;
    for (const Means& means : means_) {
      const double bound = level / (2.0 * static_cast<double>(means_.size()));
      if (std::abs(means.samples.mean() + means.known.mean()) >
          bernstein_reach(means.samples, bound) + bernstein_reach(means.known, bound) + rounding)
        return false;
    }
    return true;
  }
  /// Share of the draws that count.
  [[nodiscard]] double share() const noexcept { return means_[0].inside.mean(); }
  /// Estimate of the integral of the stated density; biased towards `share()` where the two differ
  /// much.
  [[nodiscard]] double integral() const noexcept { return share() + means_[0].samples.mean() + means_[0].known.mean(); }

 private:
  struct Means {
    Moments<double> samples, known, inside;
  };
  [[nodiscard]] static double share_of(double density, double known) noexcept {
    return density > 0.0 ? density / (density + known) : 0.0;
  }
  std::array<Means, std::tuple_size_v<Factors>> means_;
};

}  // namespace gmis::detail
