#pragma once

#include <cstdint>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/transport/emission/emission_guide.hpp"
#include "gmis/transport/photons/light_vertex_cache.hpp"
#include "gmis/transport/photons/light_vertex_grid.hpp"
#include "gmis/transport/photons/stored_light_vertex.hpp"
#include "gmis/transport/pixel_counts/pixel_counts.hpp"
#include "gmis/transport/state/path_filter.hpp"
#include "gmis/transport/state/pixel_bounds.hpp"
#include "gmis/transport/state/sample_counts.hpp"
#include "gmis/transport/state/vertex.hpp"

namespace gmis {

/// The techniques that are on.
struct TechniquesOn {
  bool emitter_hit, next_event, connect, splat, merge;
};

/// The rendered part of the frame.
struct FrameBounds {
  PixelBounds crop;
  glm::ivec2 resolution;

  /// Index of the pixel in the frame (rows from the upper left), or −1 when it is outside the crop.
  [[nodiscard]] constexpr std::int64_t pixel_index(glm::ivec2 pixel) const noexcept {
    if (pixel.x < crop.lower.x || pixel.y < crop.lower.y || pixel.x >= crop.upper.x || pixel.y >= crop.upper.y)
      return -1;
    return static_cast<std::int64_t>(pixel.y) * resolution.x + pixel.x;
  }
};

/// The keys of the random numbers of an iteration.
struct NumberKeys {
  std::uint64_t seed;
  Sampler sampler;
  std::uint32_t iteration;
  PixelSchedule schedule;  ///< camera subpaths by pixel
};

/// The light vertices of an iteration, for connections.
template <class StoredVertex, std::floating_point T>
struct LightVertices {
  const LightVertexCache<StoredVertex>& cache;
  std::uint64_t tree_count;  ///< n_L
  T connection_scale;        ///< V / (m n_L): factor on the throughput of a light vertex drawn from the cache
};

/// The photons of an iteration, for merging.
template <std::floating_point T>
struct Photons {
  const LightVertexGrid<T>& grid;  ///< names its points by their numbers in the cache
  T normalization;                 ///< 1 / (n_L π r²), times a gain (`AnyEngine::scale_merging`)
  T inverse_radius_squared;        ///< 1 / r²
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
  Split split;  ///< nominal children of light subpaths
  SampleCounts counts;
  TechniquesOn has;
  int max_depth;
  FrameBounds frame;
  NumberKeys keys;
  PathFilter filter;
  LightVertices<StoredVertex, T> light;
  Photons<T> photons;
  const EmissionGuide<Sc>* guide;  ///< of light subpaths; null where they start as the lights emit

  /// Number of the light tree that the camera subpath of this pixel is paired with.
  [[nodiscard]] constexpr std::size_t tree_of_pixel(std::size_t pixel) const noexcept {
    const auto pixels = static_cast<std::uint64_t>(frame.resolution.x) * static_cast<std::uint64_t>(frame.resolution.y);
    return light.tree_count == pixels ? pixel : static_cast<std::size_t>(pixel * light.tree_count / pixels);
  }

  /// s(x) of the local count of merging, for a surface with this BSDF: true when light vertices
  /// that are made from it are photons. 1 everywhere when merging is not local.
  template <Bsdf B>
  [[nodiscard]] constexpr bool makes_photons(const B& bsdf) const noexcept {
    if constexpr (has_light_side)
      return !counts.local_merges || has_narrow_lobe(bsdf);
    else
      return false;
  }
  /// s(x_0): true when the first vertices of light subpaths are photons.
  [[nodiscard]] constexpr bool lights_make_photons() const noexcept { return !counts.local_merges; }

  /// Nominal number of children c of a camera subpath at a vertex, for a non-delta event;
  /// `survival` is included.
  [[nodiscard]] constexpr T camera_children(T survival) const noexcept {
    return counts.extends_camera ? survival : T(0);
  }
  /// Nominal number of children c of a light subpath at a vertex; `survival` is included.
  template <Bsdf B>
  [[nodiscard]] constexpr T light_children(const B& bsdf, T survival) const noexcept {
    return survival * split.nominal_children(bsdf);
  }
  /// c at a vertex of a light subpath, for a non-delta event.
  template <Bsdf B>
  [[nodiscard]] constexpr NominalChildren<T> children_of_light_vertex(const B& bsdf) const noexcept {
    const T survival = survival_probability(bsdf);
    return {light_children(bsdf, survival), camera_children(survival)};
  }
};

}  // namespace gmis
