#pragma once

#include <cstdint>

#include "gmis/transport/state/technique.hpp"

namespace gmis {

/// The sample allocation of a run: the number of samples of each technique. An integrator is a set
/// of such counts. A technique with the count 0 is off: nothing is traced or stored for it, it
/// takes no part in any weight, and its counters stay 0.
struct SampleCounts {
  double light_paths = 1.0;    ///< light trees per pixel
  int connections = 1;         ///< light vertices drawn per camera vertex from the cache of all light trees; 0: none
  bool splats = true;          ///< each light vertex is connected with the camera
  bool merges = true;          ///< each camera vertex gathers the photons within the merging radius
  bool extends_camera = true;  ///< camera subpaths go on beyond their first non-specular vertex
  bool next_events = true;     ///< each camera vertex samples a point on a light
  bool emitter_hits = true;    ///< camera subpaths contribute when they hit a light
  /// The light vertices that are photons: false, all; true, those made from a surface with a narrow
  /// lobe (`has_narrow_lobe`), where other techniques seldom find the path. It is a local count of
  /// merging (docs/weights.md).
  bool local_merges = false;
  double radius_factor = 1.0;  ///< m: merging radius divided by `RenderSettings::radius`
  /// With connections on: each camera vertex is connected with every vertex of one light tree, the
  /// one that its pixel is paired with, in place of drawn vertices.
  bool connects_paired_tree = false;

  /// True when the technique is on.
  [[nodiscard]] constexpr bool has(Technique technique) const noexcept {
    switch (technique) {
      case Technique::emitter_hit:
        return emitter_hits;
      case Technique::next_event:
        return next_events;
      case Technique::connect:
        return light_paths > 0.0 && connections > 0;
      case Technique::splat:
        return light_paths > 0.0 && splats;
      case Technique::merge:
        return light_paths > 0.0 && merges;
    }
    return false;
  }
  /// True when connections or merging need stored light vertices.
  [[nodiscard]] constexpr bool stores_light_vertices() const noexcept {
    return has(Technique::connect) || has(Technique::merge);
  }
  /// True when some technique needs light trees.
  [[nodiscard]] constexpr bool traces_light() const noexcept {
    return stores_light_vertices() || has(Technique::splat);
  }
  /// True when some technique needs camera subpaths.
  [[nodiscard]] constexpr bool traces_camera() const noexcept {
    return emitter_hits || next_events || stores_light_vertices();
  }
  /// True when connections are drawn from the cache of all trees.
  [[nodiscard]] constexpr bool draws_connections() const noexcept {
    return has(Technique::connect) && !connects_paired_tree;
  }

  /// All counts are the same.
  [[nodiscard]] constexpr bool operator==(const SampleCounts&) const = default;

  /// The state for a later run (`core/state_archive.hpp`): member by member, for bytes between them
  /// have no value.
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(light_paths, connections, splats, merges, extends_camera, next_events, emitter_hits, local_merges,
            radius_factor, connects_paired_tree);
  }

  /// These counts with every technique off for which `is_kept(technique)` is false.
  template <class IsKept>
  [[nodiscard]] constexpr SampleCounts only(IsKept&& is_kept) const {
    SampleCounts kept = *this;
    kept.emitter_hits = emitter_hits && is_kept(Technique::emitter_hit);
    kept.next_events = next_events && is_kept(Technique::next_event);
    if (!is_kept(Technique::connect)) kept.connections = 0, kept.connects_paired_tree = false;
    kept.splats = splats && is_kept(Technique::splat);
    kept.merges = merges && is_kept(Technique::merge);
    if (!kept.traces_light()) kept.light_paths = 0.0;
    return kept;
  }
};

}  // namespace gmis
