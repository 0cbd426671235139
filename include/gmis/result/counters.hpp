#pragma once

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

  /// Adds another count.
  constexpr Counters& operator+=(const Counters& other) noexcept {
    camera_paths += other.camera_paths;
    light_subpaths += other.light_subpaths;
    rays += other.rays;
    shadow_rays += other.shadow_rays;
    connections += other.connections;
    connection_rays += other.connection_rays;
    projections += other.projections;
    splats += other.splats;
    merge_queries += other.merge_queries;
    merges += other.merges;
    photons_stored += other.photons_stored;
    grids_built += other.grids_built;
    contributions += other.contributions;
    rejected_non_finite += other.rejected_non_finite;
    rejected_negative += other.rejected_negative;
    rejected_zero_pdf += other.rejected_zero_pdf;
    return *this;
  }

  /// Operations since `earlier`.
  [[nodiscard]] constexpr Counters operator-(const Counters& earlier) const noexcept {
    return {camera_paths - earlier.camera_paths,
            light_subpaths - earlier.light_subpaths,
            rays - earlier.rays,
            shadow_rays - earlier.shadow_rays,
            connections - earlier.connections,
            connection_rays - earlier.connection_rays,
            projections - earlier.projections,
            splats - earlier.splats,
            merge_queries - earlier.merge_queries,
            merges - earlier.merges,
            photons_stored - earlier.photons_stored,
            grids_built - earlier.grids_built,
            contributions - earlier.contributions,
            rejected_non_finite - earlier.rejected_non_finite,
            rejected_negative - earlier.rejected_negative,
            rejected_zero_pdf - earlier.rejected_zero_pdf};
  }

  /// All rejections.
  [[nodiscard]] constexpr std::uint64_t rejected() const noexcept {
    return rejected_non_finite + rejected_negative + rejected_zero_pdf;
  }
};

}  // namespace gmis
