#pragma once

#include <cstdint>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/transport/counts/count_table.hpp"
#include "gmis/transport/counts/pixel_counts.hpp"
#include "gmis/transport/effects/path_filter.hpp"
#include "gmis/transport/emission/emission_guide.hpp"
#include "gmis/transport/photons/light_vertex_cache.hpp"
#include "gmis/transport/photons/light_vertex_grid.hpp"
#include "gmis/transport/photons/stored_light_vertex.hpp"
#include "gmis/transport/sample_counts.hpp"
#include "gmis/transport/walk/vertex.hpp"

namespace gmis {

/// A rectangle of pixels: `lower` inclusive, `upper` exclusive, y down from the upper left.
struct PixelBounds {
  glm::ivec2 lower{0, 0};
  glm::ivec2 upper{0, 0};
};

/// Plain data that is fixed during one iteration and that all techniques read.
template <Scene Sc, class Method_>
struct IterationContext {
  using SceneType = Sc;
  using MethodType = Method_;
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Recursion = typename Method_::Weights::template Recursion<T>;
  using Split = typename Method_::template Split<T>;
  using StoredVertex = StoredLightVertex<Sc, Recursion>;
  static constexpr bool has_light_side = Method_::Weights::has_light_side;

  const Sc& scene;
  Recursion recursion;
  Split split;
  const LightVertexGrid<T>& grid;
  const LightVertexCache<StoredVertex>& cache;  ///< the grid names its points by their numbers in the cache
  SampleCounts counts;
  struct {
    bool emitter_hit, next_event, connect, splat, merge;
  } has;               ///< true for each technique with a positive count
  T connection_scale;  ///< V / (m n_L): factor on the throughput of a light vertex drawn from the cache
  PixelBounds crop;
  glm::ivec2 resolution;
  std::uint64_t seed;
  Sampler sampler;
  std::uint32_t iteration;
  int max_depth;
  std::uint64_t tree_count;  ///< n_L
  T merge_normalization;     ///< 1 / (n_L π r²), times a gain (`Engine::scale_merging`)
  T inverse_radius_squared;  ///< 1 / r²
  PathFilter filter;
  const EmissionGuide<Sc>* guide;    ///< of light subpaths; null where they start as the lights emit
  const CountTable<T>* count_table;  ///< numbers of samples at camera vertices; null where they are the nominal ones
  PixelSchedule schedule;            ///< numbers of camera subpaths

  /// Index of the pixel in the frame (rows from the upper left), or −1 when it is outside the crop.
  [[nodiscard]] constexpr std::int64_t pixel_index(glm::ivec2 pixel) const noexcept {
    if (pixel.x < crop.lower.x || pixel.y < crop.lower.y || pixel.x >= crop.upper.x || pixel.y >= crop.upper.y)
      return -1;
    return static_cast<std::int64_t>(pixel.y) * resolution.x + pixel.x;
  }

  /// Number of the light tree that the camera subpath of this pixel is paired with.
  [[nodiscard]] constexpr std::size_t tree_of_pixel(std::size_t pixel) const noexcept {
    const auto pixels = static_cast<std::uint64_t>(resolution.x) * static_cast<std::uint64_t>(resolution.y);
    return tree_count == pixels ? pixel : static_cast<std::size_t>(pixel * tree_count / pixels);
  }

  /// s(x) of the local count of merging, for a surface with this BSDF: true when light vertices that are made from it are
  /// photons. 1 everywhere when merging is not local.
  template <Bsdf B>
  [[nodiscard]] constexpr bool makes_photons(const B& bsdf) const noexcept {
    if constexpr (has_light_side)
      return !counts.local_merges || has_narrow_lobe(bsdf);
    else
      return false;
  }
  /// s(x_0): true when the first vertices of light subpaths are photons.
  [[nodiscard]] constexpr bool lights_make_photons() const noexcept { return !counts.local_merges; }

  /// True when camera subpaths end at their first non-specular vertex.
  [[nodiscard]] constexpr bool camera_stops() const noexcept { return counts.camera_children == 0; }

  /// Nominal number of children c of a camera subpath at a vertex, for a non-delta event; `survival` is included.
  /// `may_branch`: the vertex is the first non-specular one of the subpath. It may be true of those after it where no vertex
  /// has more than one child.
  [[nodiscard]] constexpr T camera_children(T survival, bool may_branch) const noexcept {
    if (camera_stops()) return T(0);
    return may_branch ? survival * static_cast<T>(split.nominal_camera_children()) : survival;
  }
  /// Nominal number of children of a camera subpath at a vertex, for a delta event. A subpath that ends at the first
  /// non-specular vertex still goes on through delta lobes.
  [[nodiscard]] constexpr T camera_delta_children(T survival, bool may_branch) const noexcept {
    return camera_stops() ? survival : camera_children(survival, may_branch);
  }
  /// Nominal number of children c of a light subpath at a vertex; `survival` is included.
  template <Bsdf B>
  [[nodiscard]] constexpr T light_children(const B& bsdf, T survival) const noexcept {
    return survival * split.nominal_children(bsdf);
  }
  /// c at a vertex of a light subpath.
  template <Bsdf B>
  [[nodiscard]] constexpr NominalChildren<T> children_of_light_vertex(const B& bsdf) const noexcept {
    const T survival = survival_probability(bsdf);
    return {light_children(bsdf, survival), camera_children(survival, false)};
  }
};

}  // namespace gmis
