#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "gmis/transport/state/path_output.hpp"
#include "gmis/transport/weights/path_densities.hpp"
#include "transport/discrete_atlas.hpp"
#include "transport/tagged_spectrum.hpp"

namespace gmis_test {

/// A path through a discrete world, from the light (index 0) to the camera: nodes, and by which
/// lobe each scatters.
struct DiscretePath {
  std::vector<std::uint8_t> nodes;
  std::vector<std::uint8_t> lobes;  ///< those at the ends are `Tag::smooth`

  [[nodiscard]] int edges() const { return static_cast<int>(nodes.size()) - 1; }
  [[nodiscard]] friend bool operator<(const DiscretePath& a, const DiscretePath& b) {
    return a.nodes != b.nodes ? a.nodes < b.nodes : a.lobes < b.lobes;
  }
};

/// The path that a contribution came by, from the tags alone.
template <std::floating_point T>
[[nodiscard]] DiscretePath path_of(const Tagged<T>& value) {
  std::vector<Tag> light, camera;
  Tag light_end{}, camera_end{};
  for (std::size_t i = 0; i < value.count; ++i) {
    const Tag& tag = value.tags[i];
    if (tag.role == TagRole::light) light_end = tag;
    if (tag.role == TagRole::camera) camera_end = tag;
    if (tag.role == TagRole::scattered_importance) light.push_back(tag);
    if (tag.role == TagRole::scattered_radiance) camera.push_back(tag);
  }
  std::sort(light.begin(), light.end(), [](const Tag& a, const Tag& b) { return a.order < b.order; });
  std::sort(camera.begin(), camera.end(), [](const Tag& a, const Tag& b) { return a.order > b.order; });
  DiscretePath path;
  const auto append = [&](const Tag& tag) {
    path.nodes.push_back(tag.node);
    path.lobes.push_back(tag.lobe);
  };
  append(light_end);
  for (const Tag& tag : light) append(tag);
  for (const Tag& tag : camera) append(tag);
  append(camera_end);
  return path;
}

/// The nominal numbers of children at a surface, without survival. The defaults are those of
/// undivided subpaths.
struct NominalCounts {
  long double light_per_lobe =
      0.0L;                   ///< of a light subpath at a surface with smooth lobes, for each of them; 0: one in all
  bool camera_stops = false;  ///< camera subpaths go on by delta events alone
  bool local_merges = false;  ///< photons are what comes from a surface with a narrow lobe
  /// Guided emission: the density of the start from a node of a light to a surface, relative to
  /// that of the light alone.
  std::function<long double(std::size_t, std::size_t)> emission_ratio;
  bool chooses_for_receiver = false;  ///< next events choose their light for the surface x_1
  /// Guided directions: whether the surface has one lobe more, how often subpaths of the camera or
  /// of a light that come from a direction take it, and its density. Empty: no surface has one.
  std::function<bool(std::size_t)> has_lobe;
  std::function<long double(std::size_t, const gmis::Vec3<long double>&, bool)> lobe_share;
  std::function<long double(std::size_t, const gmis::Vec3<long double>&, const gmis::Vec3<long double>&, bool)>
      lobe_pdf;
};

/// The light that a path carries and the densities with which each technique makes it, all in area
/// measure, written down from the laws of the world vertex by vertex. A delta event is taken per
/// unit of étendue, n² |cos| dω with the shading normal, on either side of it: so it has one and
/// the same δ in the light it carries and in the densities of both ways, which cancels.
class PathOracle {
 public:
  using Atlas = DiscreteAtlas<long double>;
  using V = Atlas::V;

  PathOracle(const Atlas& atlas, const NominalCounts& nominal) : atlas_(atlas), nominal_(nominal) {}

  struct Path {
    gmis::PathDensities<long double> densities;
    long double value;
  };

  /// The path with the densities that weights are to count on, or (`as_drawn`) with the densities
  /// of the real draws: rounds of one child a lobe have the lobes' even mixture, where `sample` has
  /// its own.
  [[nodiscard]] Path operator()(const DiscretePath& path, bool as_drawn = false) const {
    const auto k = static_cast<std::size_t>(path.edges());
    const auto node = [&](std::size_t i) { return std::size_t{path.nodes[i]}; };
    const auto towards = [&](std::size_t i, std::size_t j) { return atlas_.direction(node(i), node(j)); };
    Path result;
    gmis::PathDensities<long double>& densities = result.densities;
    densities.from_light.resize(k);
    densities.from_camera.resize(k);
    densities.is_delta.assign(k + 1, false);
    for (std::size_t i = 1; i < k; ++i) densities.is_delta[i] = path.lobes[i] != Tag::smooth;
    densities.makes_photons.assign(k, !nominal_.local_merges);
    for (std::size_t i = 1; i < k; ++i)
      if (atlas_.has_narrow_lobe(node(i))) densities.makes_photons[i] = true;

    const auto kind = atlas_.nodes[node(0)].kind;
    const bool is_distant = atlas_.nodes[node(0)].is_infinite;
    const V emitted = is_distant ? -atlas_.nodes[node(0)].position : towards(0, 1);
    const long double choice = atlas_.light_probability(kind);
    densities.light_can_be_hit = kind == Atlas::Kind::surface || kind == Atlas::Kind::sky;
    densities.from_light[0] = choice * atlas_.emission_origin_density(node(0));
    if (k >= 2) {
      const auto& receiver = atlas_.nodes[node(1)];
      const long double next_event_choice =
          nominal_.chooses_for_receiver
              ? atlas_.light_probability_at(kind, receiver.position, receiver.geometric_normal, receiver.shading_normal)
              : choice;
      densities.next_event = next_event_choice * atlas_.next_event_density(node(0), receiver.position);
    }
    for (std::size_t i = 1; i < k; ++i)
      densities.from_light[i] =
          (i == 1 ? atlas_.emission_first_density(node(0), emitted) : step(path, i - 1, i - 2, i, false, as_drawn)) *
          atlas_.to_area(node(i), node(i - 1));
    if (nominal_.emission_ratio && k >= 2) densities.from_light[1] *= nominal_.emission_ratio(node(0), node(1));
    // From the camera.
    const V seen = atlas_.nodes[node(k)].is_infinite ? -atlas_.nodes[node(k)].position : towards(k, k - 1);
    for (std::size_t i = k; i-- > 0;)
      densities.from_camera[i] =
          (i + 1 == k ? atlas_.camera_density(node(k), seen) : step(path, i + 1, i + 2, i, true, as_drawn)) *
          atlas_.to_area(node(i), node(i + 1));

    // W · (response) · Π f |cos| · G · L, in radiance's direction: from the camera on.
    long double value = atlas_.camera_weight(node(k), seen) * atlas_.camera_density(node(k), seen);
    for (std::size_t i = k - 1; i >= 1; --i) {
      const V to_light = towards(i, i - 1), to_camera = towards(i, i + 1);
      const long double cosine = std::abs(glm::dot(atlas_.nodes[node(i)].shading_normal, to_light));
      value *= atlas_.to_area(node(i), node(i + 1)) * cosine;
      if (!densities.is_delta[i]) {
        value *= atlas_.f(node(i), to_light, to_camera);
      } else {
        // L_camera / n_camera² = τ L_light / n_light², and |cos| dω on the light's side is étendue
        // over n_light².
        const long double index = atlas_.index(node(i + 1));
        value *= atlas_.transmittance(node(i), path.lobes[i], to_light, to_camera) * index * index;
      }
    }
    result.value = value * atlas_.to_area(node(0), node(1)) * atlas_.emitted(node(0), emitted);
    return result;
  }

 private:
  /// The density of going on from x_i to x_next when coming from x_prev: per steradian, or per δ of
  /// étendue.
  [[nodiscard]] long double step(const DiscretePath& path, std::size_t i, std::size_t prev, std::size_t next,
                                 bool is_camera, bool as_drawn) const {
    const std::size_t node = path.nodes[i], to = path.nodes[next];
    const V to_prev = atlas_.direction(node, path.nodes[prev]), to_next = atlas_.direction(node, to);
    const bool is_smooth = path.lobes[i] == Tag::smooth;
    const long double albedo = atlas_.albedo(node);
    const long double children =
        is_camera ? camera_survival(path, i) * camera_children(path, i) : albedo * light_children(node);
    const bool has_lobe = nominal_.has_lobe && nominal_.has_lobe(node);
    const long double share = has_lobe ? nominal_.lobe_share(node, to_prev, is_camera) : 0.0L;
    const long double lobe = has_lobe ? nominal_.lobe_pdf(node, to_prev, to_next, is_camera) : 0.0L;
    if (is_smooth && as_drawn && is_drawn_in_rounds(path, i, is_camera)) {
      long double sum = lobe;
      for (int k = 0; k < atlas_.nodes[node].smooth_lobes; ++k) sum += atlas_.lobe_pdf(node, k, to_prev, to_next);
      return children * sum / static_cast<long double>(lobes_of(node));
    }
    if (is_smooth) return children * ((1.0L - share) * atlas_.pdf(node, to_prev, to_next) + share * lobe);
    const long double cosine = std::abs(glm::dot(atlas_.nodes[node].shading_normal, to_next));
    const long double index = atlas_.index(to);
    return children * (1.0L - share) * atlas_.delta_probability(node, path.lobes[i], to_prev) * cosine * index * index;
  }

  /// Smooth lobes, the one that guides included.
  [[nodiscard]] int lobes_of(std::size_t node) const {
    return atlas_.nodes[node].smooth_lobes + (nominal_.has_lobe && nominal_.has_lobe(node) ? 1 : 0);
  }
  [[nodiscard]] bool is_purely_specular(std::size_t node) const { return atlas_.nodes[node].smooth_lobes == 0; }

  [[nodiscard]] bool is_drawn_in_rounds(const DiscretePath& path, std::size_t i, bool is_camera) const {
    const std::size_t node = path.nodes[i];
    if (lobes_of(node) < 2 || atlas_.nodes[node].delta_lobes > 0) return false;
    const long double children = is_camera ? camera_children(path, i) : light_children(node);
    return std::fmod(children, static_cast<long double>(lobes_of(node))) == 0.0L;
  }
  [[nodiscard]] long double light_children(std::size_t node) const {
    if (nominal_.light_per_lobe == 0.0L || is_purely_specular(node)) return 1.0L;
    return nominal_.light_per_lobe * static_cast<long double>(lobes_of(node));
  }
  /// 1 where all events between the vertex and the camera are specular, else 9/10 of the albedo.
  [[nodiscard]] long double camera_survival(const DiscretePath& path, std::size_t i) const {
    for (std::size_t k = i + 1; k + 1 < path.nodes.size(); ++k)
      if (path.lobes[k] == Tag::smooth) return 0.9L * atlas_.albedo(path.nodes[i]);
    return 1.0L;
  }
  [[nodiscard]] long double camera_children(const DiscretePath& path, std::size_t i) const {
    if (nominal_.camera_stops && path.lobes[i] == Tag::smooth) return 0.0L;
    return 1.0L;
  }

  const Atlas& atlas_;
  const NominalCounts& nominal_;
};

[[nodiscard]] inline int edges_of(const gmis::TechniqueId& id) {
  return id.s + id.t - (id.technique == gmis::Technique::merge ? 2 : 1);
}

/// The place of a technique in `technique_densities` of a path with `edges` edges.
[[nodiscard]] inline std::size_t place_of(const gmis::TechniqueId& id, int edges) {
  if (id.technique == gmis::Technique::merge) return static_cast<std::size_t>(edges + 1 + id.s - 2);
  return static_cast<std::size_t>(id.s);
}

}  // namespace gmis_test
