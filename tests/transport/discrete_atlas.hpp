#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "gmis/core/math.hpp"

namespace gmis_test {

/// The map of a world of a few points and the laws that hold there. Light goes from point to point;
/// every law (densities, f, emission, response) is an arbitrary smooth function with nothing
/// symmetric about it: no density equals the one of the way back, no two cosines or distances are
/// equal. `T` is the scalar: the renderer works in float or double, the oracle in long double on
/// the same map.
template <std::floating_point T>
struct DiscreteAtlas {
  using V = gmis::Vec3<T>;

  enum class Kind : std::uint8_t { surface, point_light, sun, sky, camera };

  /// A sun, a direction of the sky and a camera of parallel rays are infinitely far: `position` is
  /// the direction to them.
  struct Node {
    Kind kind;
    bool is_infinite;
    bool emits;  ///< a surface that is part of the area light
    V position, geometric_normal, shading_normal;
    int smooth_lobes, delta_lobes;
    std::vector<std::uint8_t> partner[2];  ///< of each delta lobe: where light from a node goes; an involution
  };
  std::vector<Node> nodes;
  bool has_parallel_rays = false;

  template <class U>
  [[nodiscard]] DiscreteAtlas<U> as() const {
    DiscreteAtlas<U> result;
    result.has_parallel_rays = has_parallel_rays;
    for (const Node& n : nodes)
      result.nodes.push_back({static_cast<typename DiscreteAtlas<U>::Kind>(n.kind),
                              n.is_infinite,
                              n.emits,
                              gmis::Vec3<U>(n.position),
                              gmis::Vec3<U>(n.geometric_normal),
                              gmis::Vec3<U>(n.shading_normal),
                              n.smooth_lobes,
                              n.delta_lobes,
                              {n.partner[0], n.partner[1]}});
    return result;
  }

  [[nodiscard]] bool is_surface(std::size_t node) const { return nodes[node].kind == Kind::surface; }
  /// s of a local count of merging: any function of the node; one of the emitting surfaces has it.
  [[nodiscard]] bool has_narrow_lobe(std::size_t node) const { return is_surface(node) && node >= 2; }
  [[nodiscard]] V direction(std::size_t from, std::size_t to) const {
    return nodes[to].is_infinite ? nodes[to].position : glm::normalize(nodes[to].position - nodes[from].position);
  }
  [[nodiscard]] T distance_squared(std::size_t a, std::size_t b) const {
    if (nodes[a].is_infinite || nodes[b].is_infinite) return T(1);
    const V offset = nodes[a].position - nodes[b].position;
    return glm::dot(offset, offset);
  }
  /// |cos| / d² at `node` for a ray from `from`, both surfaces; the two factors that are not there for other kinds are 1.
  [[nodiscard]] T to_area(std::size_t node, std::size_t from) const {
    const T cosine = is_surface(node) ? std::abs(glm::dot(nodes[node].geometric_normal, direction(node, from))) : T(1);
    return cosine / distance_squared(node, from);
  }

  // ---- laws -------------------------------------------------------------------------------------

  /// Any positive number between `low` and `high` that depends on all that is given.
  [[nodiscard]] static T law(int which, std::size_t node, T low, T high, const V& a = V(T(0)), const V& b = V(T(0))) {
    const T w = static_cast<T>(which), n = static_cast<T>(node);
    const T phase = T(1.7) * w + T(0.9) * n + glm::dot(a, V(T(1.1) + T(0.3) * w, T(-0.7), T(0.4) + T(0.2) * n)) +
                    glm::dot(b, V(T(-0.8), T(1.3) - T(0.1) * n, T(0.6) + T(0.15) * w));
    return low + (high - low) * (T(0.5) + T(0.5) * std::sin(phase));
  }

  [[nodiscard]] T albedo(std::size_t node) const { return law(1, node, T(0.45), T(0.95)); }
  /// f; reciprocal no more than the rest.
  [[nodiscard]] T f(std::size_t node, const V& to_light, const V& to_camera) const {
    return law(2, node, T(0.1), T(1), to_light, to_camera);
  }
  [[nodiscard]] T lobe_weight(std::size_t node, int lobe) const {
    if (nodes[node].smooth_lobes == 1) return T(1);
    const T first = law(3, node, T(0.2), T(0.8));
    return lobe == 0 ? first : T(1) - first;
  }
  [[nodiscard]] T lobe_pdf(std::size_t node, int lobe, const V& to_prev, const V& to_next) const {
    return law(4 + lobe, node, T(0.05), T(0.6), to_prev, to_next);
  }
  /// The chance that `sample` chooses a delta lobe, which depends on where it comes from as
  /// Fresnel's does.
  [[nodiscard]] T delta_probability(std::size_t node, int lobe, const V& to_prev) const {
    if (nodes[node].delta_lobes == 0) return T(0);
    if (nodes[node].smooth_lobes > 0) return law(6, node, T(0.3), T(0.7), to_prev);
    const T first = law(6, node, T(0.3), T(0.7), to_prev);
    return lobe == 0 ? first : T(1) - first;
  }
  /// Per steradian, the delta lobes' share left out.
  [[nodiscard]] T pdf(std::size_t node, const V& to_prev, const V& to_next) const {
    T mixture(0);
    for (int lobe = 0; lobe < nodes[node].smooth_lobes; ++lobe)
      mixture += lobe_weight(node, lobe) * lobe_pdf(node, lobe, to_prev, to_next);
    return mixture * (T(1) - delta_probability(node, 0, to_prev));
  }
  /// The index of refraction at a delta surface on the side of `to`.
  [[nodiscard]] T index(std::size_t to) const { return to % 2 == 0 ? T(1) : T(1.5); }
  /// Transmittance of a delta lobe, for flux on its way from the light to the camera.
  [[nodiscard]] T transmittance(std::size_t node, int lobe, const V& to_light, const V& to_camera) const {
    return law(7 + lobe, node, T(0.3), T(0.9), to_light, to_camera);
  }

  /// Radiance, intensity or irradiance that leaves an emitting node along `direction`.
  [[nodiscard]] T emitted(std::size_t node, const V& direction) const { return law(9, node, T(0.5), T(2), direction); }
  [[nodiscard]] T emission_origin_density(std::size_t node) const {
    const Kind kind = nodes[node].kind;
    return kind == Kind::surface || kind == Kind::sky ? law(10, node, T(0.2), T(0.8)) : T(1);
  }
  [[nodiscard]] T emission_first_density(std::size_t node, const V& direction) const {
    return nodes[node].is_infinite ? law(11, node, T(0.1), T(0.4)) : law(11, node, T(0.05), T(0.5), direction);
  }
  [[nodiscard]] T next_event_density(std::size_t node, const V& from) const {
    const Kind kind = nodes[node].kind;
    return kind == Kind::surface || kind == Kind::sky ? law(12, node, T(0.2), T(0.8), from) : T(1);
  }
  [[nodiscard]] T light_probability(Kind kind) const {
    return law(13, static_cast<std::size_t>(kind), T(0.15), T(0.35));
  }
  /// `light_probability`, for a next event at a surface, where lights are chosen for their
  /// receiver.
  [[nodiscard]] T light_probability_at(Kind kind, const V& position, const V& geometric_normal,
                                       const V& shading_normal) const {
    return law(16, static_cast<std::size_t>(kind), T(0.02), T(0.6), position,
               geometric_normal + T(0.5) * shading_normal);
  }

  [[nodiscard]] T camera_density(std::size_t camera, const V& direction) const {
    return law(14, camera, T(0.3), T(1.5), direction);
  }
  [[nodiscard]] T camera_weight(std::size_t camera, const V& direction) const {
    return law(15, camera, T(0.5), T(1.5), direction);
  }
};

/// Five surfaces (smooth with one lobe and with two, a shading normal of its own, a delta lobe
/// beside a smooth one, two delta lobes alone), two of them an area light, besides a point light, a
/// sun, a sky of two directions and a camera of two points (or of parallel rays). Everything is at
/// least 0.6 apart in place or direction, no cosine is below 0.15.
template <std::floating_point T>
[[nodiscard]] DiscreteAtlas<T> make_atlas(std::uint64_t seed, bool has_parallel_rays) {
  using A = DiscreteAtlas<double>;
  using V = gmis::Vec3<double>;
  std::mt19937_64 source(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] { return V(unit(source), unit(source), unit(source)); };
  const auto unit_vector = [&] { return glm::normalize(vector()); };
  A atlas;
  atlas.has_parallel_rays = has_parallel_rays;
  const auto add = [&](A::Kind kind, bool is_infinite, int smooth, int delta, bool emits) {
    atlas.nodes.push_back({kind, is_infinite, emits, V(0.0), V(0.0), V(0.0), smooth, delta, {}});
  };
  add(A::Kind::surface, false, 1, 0, false);
  add(A::Kind::surface, false, 2, 0, true);
  add(A::Kind::surface, false, 2, 1, true);
  add(A::Kind::surface, false, 0, 2, false);
  add(A::Kind::surface, false, 2, 0, false);
  add(A::Kind::point_light, false, 0, 0, true);
  add(A::Kind::sun, true, 0, 0, true);
  add(A::Kind::sky, true, 0, 0, true);
  add(A::Kind::sky, true, 0, 0, true);
  add(A::Kind::camera, has_parallel_rays, 0, 0, false);
  if (!has_parallel_rays) add(A::Kind::camera, false, 0, 0, false);
  const std::size_t count = atlas.nodes.size();

  // Places at random until all are apart, as seen from one another too.
  const auto is_spread = [&] {
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j) {
        if (i == j) continue;
        if (!atlas.nodes[i].is_infinite && !atlas.nodes[j].is_infinite && atlas.distance_squared(i, j) < 0.36)
          return false;
        if (atlas.nodes[i].is_infinite) continue;
        for (std::size_t l = j + 1; l < count; ++l)
          if (l != i && glm::dot(atlas.direction(i, j), atlas.direction(i, l)) > 0.995) return false;
      }
    return true;
  };
  do {
    for (A::Node& node : atlas.nodes) node.position = node.is_infinite ? unit_vector() : vector();
  } while (!is_spread());

  for (std::size_t i = 0; i < count; ++i) {
    A::Node& node = atlas.nodes[i];
    if (node.kind != A::Kind::surface) continue;
    const auto sees_all = [&](const V& normal) {
      for (std::size_t j = 0; j < count; ++j)
        if (j != i && std::abs(glm::dot(normal, atlas.direction(i, j))) < 0.15) return false;
      return true;
    };
    do node.geometric_normal = unit_vector();
    while (!sees_all(node.geometric_normal));
    node.shading_normal = node.geometric_normal;
    if (i >= 2) do
        node.shading_normal = glm::normalize(node.geometric_normal + 0.7 * vector());
      while (!sees_all(node.shading_normal) || glm::dot(node.shading_normal, node.geometric_normal) < 0.3);
    for (int lobe = 0; lobe < node.delta_lobes; ++lobe) {
      std::vector<std::uint8_t> others;
      for (std::size_t j = 0; j < count; ++j)
        if (j != i) others.push_back(static_cast<std::uint8_t>(j));
      std::shuffle(others.begin(), others.end(), source);
      node.partner[lobe].assign(count, static_cast<std::uint8_t>(i));
      for (std::size_t j = 0; j < others.size(); ++j) {
        const std::size_t other = (j ^ 1U) < others.size() ? j ^ 1U : j;
        node.partner[lobe][others[j]] = others[other];
      }
    }
  }
  return atlas.template as<T>();
}

}  // namespace gmis_test
