#pragma once

#include <cstdint>

#include "gmis/transport/effects/path_filter.hpp"
#include "gmis/transport/photons/light_vertex_cache.hpp"
#include "gmis/transport/photons/light_vertex_grid.hpp"
#include "gmis/transport/sample_counts.hpp"
#include "gmis/transport/walk/vertex.hpp"

namespace gmis {

/// A rectangle of pixels, the upper ends excluded.
struct PixelBounds {
  glm::ivec2 lower{0, 0};
  glm::ivec2 upper{0, 0};
};

/// Everything that is fixed during one iteration and read by all techniques: plain data.
template <Scene Sc, class Method_>
struct IterationContext {
  using SceneType = Sc;
  using MethodType = Method_;
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Recursion = typename Method_::Weights::template Recursion<T>;
  using Split = typename Method_::template Split<T>;
  using StoredVertex = LightVertex<Sc, Recursion>;
  static constexpr bool has_light_side = Method_::Weights::has_light_side;

  const Sc& scene;
  Recursion recursion;
  Split split;
  const LightVertexGrid<T>& grid;
  const LightVertexCache<StoredVertex>& cache;  ///< its numbers are those of the grid
  SampleCounts counts;
  struct {
    bool emitter_hit, next_event, connect, splat, merge;
  } has;               ///< the techniques whose count is not 0
  T connection_scale;  ///< V / (m n_L): the factor of the throughput of a light vertex drawn from the cache
  PixelBounds crop;
  glm::ivec2 resolution;
  std::uint64_t seed;
  std::uint32_t iteration;
  int max_depth;
  std::uint64_t tree_count;  ///< n_L
  T merge_normalization;     ///< 1 / (n_L π r²)
  PathFilter filter;

  /// The pixel's place in the frame, or −1 when it is outside the crop.
  [[nodiscard]] constexpr std::int64_t pixel_index(glm::ivec2 pixel) const noexcept {
    if (pixel.x < crop.lower.x || pixel.y < crop.lower.y || pixel.x >= crop.upper.x || pixel.y >= crop.upper.y)
      return -1;
    return static_cast<std::int64_t>(pixel.y) * resolution.x + pixel.x;
  }

  /// The tree that the camera subpath of a pixel is paired with.
  [[nodiscard]] constexpr std::size_t tree_of_pixel(std::size_t pixel) const noexcept {
    const auto pixels = static_cast<std::uint64_t>(resolution.x) * static_cast<std::uint64_t>(resolution.y);
    return tree_count == pixels ? pixel : static_cast<std::size_t>(pixel * tree_count / pixels);
  }

  /// Whether camera subpaths end at the first non-specular vertex.
  [[nodiscard]] constexpr bool camera_stops() const noexcept { return counts.camera_children == 0; }

  /// Nominal children of a camera subpath by a non-delta event, at a vertex with that survival probability.
  /// `is_first_non_specular`: every vertex between it and the camera is specular.
  [[nodiscard]] constexpr T camera_children(T survival, bool is_first_non_specular) const noexcept {
    if (camera_stops()) return T(0);
    return is_first_non_specular ? survival * static_cast<T>(split.nominal_camera_children()) : survival;
  }
  /// The same by a delta event.
  [[nodiscard]] constexpr T camera_delta_children(T survival, bool is_first_non_specular) const noexcept {
    return camera_stops() ? survival : camera_children(survival, is_first_non_specular);
  }
  /// Nominal children of a light subpath.
  template <Bsdf B>
  [[nodiscard]] constexpr T light_children(const B& bsdf, T survival) const noexcept {
    return survival * split.nominal_children(bsdf);
  }
};

}  // namespace gmis
