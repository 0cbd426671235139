#pragma once

#include <array>
#include <cstdint>

namespace gmis {

/// Counted operations of a run. The counters of a technique that is off stay exactly 0.
struct Counters {
  std::uint64_t camera_paths = 0;         ///< subpaths started at the camera
  std::uint64_t light_subpaths = 0;       ///< light trees
  std::uint64_t rays = 0;                 ///< closest-hit queries
  std::uint64_t shadow_rays = 0;          ///< visibility queries
  std::uint64_t connections = 0;          ///< pairs of vertices evaluated, visible or not
  std::uint64_t connection_rays = 0;      ///< visibility queries of connections; included in `shadow_rays`
  std::uint64_t projections = 0;          ///< light vertices projected onto the image, seen or not
  std::uint64_t splats = 0;               ///< contributions of light vertices to the image
  std::uint64_t merge_queries = 0;        ///< searches for light vertices around a camera vertex
  std::uint64_t merges = 0;               ///< pairs of a camera vertex and a light vertex merged
  std::uint64_t photons_stored = 0;       ///< light vertices stored
  std::uint64_t grids_built = 0;          ///< grids over photons
  std::uint64_t contributions = 0;        ///< offered to the film, including the non-finite and negative ones
  std::uint64_t rejected_non_finite = 0;  ///< contributions left out: NaN or infinite
  std::uint64_t rejected_negative = 0;    ///< contributions left out: negative
  std::uint64_t rejected_zero_pdf = 0;    ///< samples whose own density is zero or not finite

  /// Every count, once.
  static constexpr auto all() noexcept {
    using C = Counters;
    return std::array{
        &C::camera_paths,     &C::light_subpaths, &C::rays,          &C::shadow_rays,         &C::connections,
        &C::connection_rays,  &C::projections,    &C::splats,        &C::merge_queries,       &C::merges,
        &C::photons_stored,   &C::grids_built,    &C::contributions, &C::rejected_non_finite, &C::rejected_negative,
        &C::rejected_zero_pdf};
  }

  /// Adds another count.
  constexpr Counters& operator+=(const Counters& other) noexcept {
    for (const auto count : all()) this->*count += other.*count;
    return *this;
  }

  /// Operations since `earlier`.
  [[nodiscard]] constexpr Counters operator-(const Counters& earlier) const noexcept {
    Counters result = *this;
    for (const auto count : all()) result.*count -= earlier.*count;
    return result;
  }

  /// All rejections.
  [[nodiscard]] constexpr std::uint64_t rejected() const noexcept {
    return rejected_non_finite + rejected_negative + rejected_zero_pdf;
  }
};

}  // namespace gmis
