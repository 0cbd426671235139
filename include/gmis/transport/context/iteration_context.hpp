#pragma once

#include <cstdint>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/transport/emission/emission_guide.hpp"
#include "gmis/transport/photons/light_vertex_cache.hpp"
#include "gmis/transport/photons/light_vertex_grid.hpp"
#include "gmis/transport/photons/stored_light_vertex.hpp"
#include "gmis/transport/state/path_filter.hpp"
#include "gmis/transport/state/pixel_bounds.hpp"
#include "gmis/transport/state/sample_counts.hpp"
#include "gmis/transport/state/vertex.hpp"

namespace gmis {

/// The techniques that are on.
struct TechniquesOn {
  bool emitter_hit;  ///< camera subpaths hit emitters
  bool next_event;   ///< camera vertices are connected with points on lights
  bool connect;      ///< camera vertices are connected with light vertices
  bool splat;        ///< light vertices are connected with the camera
  bool merge;        ///< camera vertices gather photons
};

/// The rendered part of the frame.
struct FrameBounds {
  PixelBounds crop;       ///< the rendered pixels
  glm::ivec2 resolution;  ///< columns and rows of the frame

  /// Index of the pixel in the frame (rows from the upper left), or −1 when it is outside the crop.
  [[nodiscard]] constexpr std::int64_t pixel_index(glm::ivec2 pixel) const noexcept {
    if (pixel.x < crop.lower.x || pixel.y < crop.lower.y || pixel.x >= crop.upper.x || pixel.y >= crop.upper.y)
      return -1;
    return static_cast<std::int64_t>(pixel.y) * resolution.x + pixel.x;
  }
};

/// The keys of the random numbers of an iteration.
struct NumberKeys {
  std::uint64_t seed;       ///< of the run
  Sampler sampler;          ///< the sequences that the numbers come from
  std::uint32_t iteration;  ///< from 1
};

/// The light vertices of an iteration, for connections.
template <class StoredVertex, std::floating_point T>
struct LightVertices {
  const LightVertexCache<StoredVertex>& cache;  ///< in the order of the light trees
  std::uint64_t tree_count;                     ///< n_L
  T connection_scale;  ///< V / (m n_L): factor on the throughput of a light vertex drawn from the cache
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
  using SceneType = Sc;        ///< the scene
  using MethodType = Method_;  ///< the parts of the engine fixed at compile time
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Recursion = typename Method_::Weights::template Recursion<T>;
  using Split = typename Method_::template Split<T>;
  using StoredVertex = StoredLightVertex<Sc, Recursion>;
  /// Light subpaths take part.
  static constexpr bool has_light_side = Method_::Weights::has_light_side;

  const Sc& scene;                       ///< must outlive the context
  Recursion recursion;                   ///< forms the path weights
  Split split;                           ///< nominal children of light subpaths
  SampleCounts counts;                   ///< numbers of samples by technique
  TechniquesOn has;                      ///< the techniques that are on
  int max_depth;                         ///< greatest number of edges of a path
  FrameBounds frame;                     ///< frame and crop, in pixels
  NumberKeys keys;                       ///< keys of the random numbers
  PathFilter filter;                     ///< the path classes that are made
  LightVertices<StoredVertex, T> light;  ///< light vertices for connections
  Photons<T> photons;                    ///< light vertices for merging
  const EmissionGuide<Sc>* guide;        ///< of light subpaths; null where they start as the lights emit
  bool chooses_for_receiver;             ///< next events choose lights for the receiver

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
    return {light_children(bsdf, survival), camera_children(camera_survival(survival))};
  }
};

}  // namespace gmis
