#pragma once

#include <cstdint>

#include "gmis/transport/integrator.hpp"
#include "gmis/transport/light_vertex_cache.hpp"
#include "gmis/transport/light_vertex_grid.hpp"
#include "gmis/transport/vertex.hpp"

namespace gmis {

/// A rectangle of pixels, the upper ends excluded.
struct PixelBounds {
  glm::ivec2 lower{0, 0};
  glm::ivec2 upper{0, 0};
};

/// Everything that is fixed during one iteration and read by all techniques.
template <Scene Sc, class Integrator_>
struct IterationContext {
  using SceneType = Sc;
  using IntegratorType = Integrator_;
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using StoredVertex = LightVertex<Sc, Integrator_>;
  using Path = typename Integrator_::Path;

  const Sc& scene;
  typename Integrator_::template Recursion<T> recursion;
  typename Integrator_::Split::template Policy<T> split;
  const LightVertexGrid<T>& grid;
  const LightVertexCache<StoredVertex>& cache;  ///< its numbers are those of the grid
  int connections;                              ///< vertices drawn from the cache; 0: the paired tree instead
  T connection_scale;                           ///< V / (m n_L): what the throughput of one of them stands for
  PixelBounds crop;
  glm::ivec2 resolution;
  std::uint64_t seed;
  std::uint32_t iteration;
  int max_depth;
  std::uint64_t tree_count;  ///< n_L
  T merge_normalization;     ///< 1 / (n_L π r²)
  [[no_unique_address]] typename Integrator_::Filter filter;

  /// The pixel's place in the frame, or −1 when it is outside what is rendered.
  [[nodiscard]] std::int64_t pixel_index(glm::ivec2 pixel) const noexcept {
    if (pixel.x < crop.lower.x || pixel.y < crop.lower.y || pixel.x >= crop.upper.x || pixel.y >= crop.upper.y)
      return -1;
    return static_cast<std::int64_t>(pixel.y) * resolution.x + pixel.x;
  }

  /// The tree that the camera subpath of a pixel is paired with.
  [[nodiscard]] std::size_t tree_of_pixel(std::size_t pixel) const noexcept {
    const auto pixels = static_cast<std::uint64_t>(resolution.x) * static_cast<std::uint64_t>(resolution.y);
    return tree_count == pixels ? pixel : static_cast<std::size_t>(pixel * tree_count / pixels);
  }

  /// Nominal children of a camera subpath by a non-delta event at a vertex with that survival probability.
  /// `is_first`: every vertex between it and the camera is specular.
  [[nodiscard]] T camera_children(T survival, bool is_first) const noexcept {
    if constexpr (Integrator_::camera_walk == CameraWalk::specular) return T(0);
    if constexpr (Integrator_::Split::splits_camera)
      if (is_first) return survival * static_cast<T>(split.nominal_camera_children());
    return survival;
  }
  /// The same by a delta event.
  [[nodiscard]] T camera_delta_children(T survival, bool is_first) const noexcept {
    if constexpr (Integrator_::camera_walk == CameraWalk::specular) return survival;
    return camera_children(survival, is_first);
  }
  /// Nominal children of a light subpath.
  template <Bsdf B>
  [[nodiscard]] T light_children(const B& bsdf, T survival) const noexcept {
    return survival * split.nominal_children(bsdf);
  }
};

}  // namespace gmis
