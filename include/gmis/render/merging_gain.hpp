#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace gmis {

/// The factor by which the later iterations of a run multiply the light that they merge, so that
/// the mean of the picture comes out right.
///
/// In the midst of a surface a disk moves light and leaves the mean as it is; within one radius of
/// where a surface ends, it loses or adds light, in proportion to its radius
/// (`bias_of_change_of_mean`). The iterations so far have measured how much. The iterations to come
/// can therefore make up for all of it: iteration i multiplies what it merges by 1 + q r_i, the
/// more the wider its disk is. To first order the mean is then that of disks without extent
/// [Richardson 1911]; pixels into which nothing is merged stay as they are. q vanishes as the disks
/// do, so that the picture converges to the same limit.
class MergingGain {
 public:
  /// Greatest relative change of the light that an iteration merges: a larger one would follow the
  /// noise of a few photons.
  static constexpr double most_change = 0.25;

  /// Adds an iteration. `merged`: mean over the pixels of the light that it has merged, with the
  /// gain. `radius`: of its disk, in scene units.
  void add_iteration(double merged, double radius) noexcept {
    if (!std::isfinite(merged)) merged = 0.0;  // as in a sum of changes
    merged_ += merged;
    radii_ += radius;
    const double change = per_radius_ * radius;
    made_up_ += merged * change / (1.0 + change);
    ++iterations_;
  }

  /// Chooses q for the iterations to come. `bias`: of the mean over the pixels, from merging alone,
  /// summed over the iterations so far; `radii` and `radius`: the sum of the radii to come, and the
  /// first of them. Without a bias, merged light or a disk to come, q is 0.
  void choose(double bias, double radii, double radius) noexcept {
    per_radius_ = 0.0;
    const double merging = merged_ * radii;
    if (!(merging > 0.0) || !(radii_ > 0.0)) return;
    // The bias of all iterations, and what was made up: Σ q r_i merged makes up for the rest.
    const double all = bias * (1.0 + radii / radii_) + made_up_;
    const double change = -all * static_cast<double>(iterations_) / merging * radius;
    per_radius_ = std::clamp(change, -most_change, most_change) / radius;
  }

  /// q, per scene unit.
  [[nodiscard]] double per_radius() const noexcept { return per_radius_; }
  /// The light that the iterations so far have added to the mean over the pixels by their gain,
  /// summed over iterations.
  [[nodiscard]] double made_up() const noexcept { return made_up_; }

  /// Takes in another run.
  void join(const MergingGain& other) noexcept {
    merged_ += other.merged_;
    radii_ += other.radii_;
    made_up_ += other.made_up_;
    iterations_ += other.iterations_;
  }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(merged_, radii_, made_up_, per_radius_, iterations_);
  }

 private:
  double merged_ = 0.0, radii_ = 0.0, made_up_ = 0.0;  // sums over the iterations so far
  double per_radius_ = 0.0;
  std::uint64_t iterations_ = 0;
};

}  // namespace gmis
