#pragma once

#include <array>
#include <optional>

#include "gmis/core/concepts.hpp"
#include "gmis/core/guided_light.hpp"
#include "gmis/core/light_choice.hpp"
#include "transport/discrete_atlas.hpp"
#include "transport/tagged_spectrum.hpp"

namespace gmis_test {

/// The world of a `DiscreteAtlas` as a renderer would show it to the engine. Where it goes next is
/// chosen evenly among the nodes, whatever density it claims for that: a weight, and a value times
/// its density, are functions of the claims alone. So the same path comes again and again by every
/// technique, and merged vertices coincide. For one thread: the rays are numbered. `is_choosy`:
/// lights are chosen for their receiver.
template <std::floating_point T, bool is_choosy = false>
class DiscreteWorld {
 public:
  using Spectrum = Tagged<T>;
  using Atlas = DiscreteAtlas<T>;
  using V = gmis::Vec3<T>;
  using Kind = typename Atlas::Kind;

  class Bsdf {
   public:
    using Spectrum = Tagged<T>;
    static constexpr int max_lobes = 2;

    Bsdf() = default;
    Bsdf(const DiscreteWorld& world, std::uint8_t node, std::uint32_t order)
        : world_(&world), node_(node), order_(order) {}
    [[nodiscard]] std::uint8_t node() const { return node_; }

    [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate(const V& to_prev, const V& to_next,
                                                     gmis::TransportMode mode) const {
      if (is_purely_delta()) return {};
      return {Spectrum(f(to_prev, to_next, mode), tag(mode, Tag::smooth)),
              {{atlas().pdf(node_, to_prev, to_next)}, {atlas().pdf(node_, to_next, to_prev)}}};
    }
    [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample(const V& to_prev, T u, const gmis::Vec2<T>& uv,
                                                                      gmis::TransportMode mode) const {
      const Atlas& laws = atlas();
      const auto& here = laws.nodes[node_];
      const int choices = here.delta_lobes + (here.smooth_lobes > 0 ? 1 : 0);
      const int choice = std::min(static_cast<int>(u * static_cast<T>(choices)), choices - 1);
      if (choice == here.delta_lobes) {
        const V to_next = *sample_lobe(0, to_prev, uv, mode);
        const T forward = laws.pdf(node_, to_prev, to_next);
        const T cosine = std::abs(glm::dot(here.shading_normal, to_next));
        return gmis::ScatterSample<Spectrum>{
            to_next,
            Spectrum(f(to_prev, to_next, mode) * cosine / forward, tag(mode, Tag::smooth)),
            {{forward}, {laws.pdf(node_, to_next, to_prev)}},
            false,
            T(1)};
      }
      const std::size_t prev = world_->node_towards(here.position, to_prev);
      const std::size_t next = here.partner[choice][prev];
      const V to_next = laws.direction(node_, next);
      const T eta = laws.index(next) / laws.index(prev);
      const bool is_radiance = mode == gmis::TransportMode::radiance;
      // Radiance grows with the square of the index, flux does not.
      const T transmittance = is_radiance ? laws.transmittance(node_, choice, to_next, to_prev) / (eta * eta)
                                          : laws.transmittance(node_, choice, to_prev, to_next);
      const T forward = laws.delta_probability(node_, choice, to_prev);
      return gmis::ScatterSample<Spectrum>{
          to_next,
          Spectrum(transmittance / forward, tag(mode, static_cast<std::uint8_t>(choice))),
          {{forward}, {laws.delta_probability(node_, choice, to_next)}},
          true,
          eta};
    }
    [[nodiscard]] bool is_purely_delta() const { return atlas().nodes[node_].smooth_lobes == 0; }
    [[nodiscard]] Spectrum albedo() const { return Spectrum(atlas().albedo(node_)); }

    [[nodiscard]] bool has_narrow_lobe() const { return atlas().has_narrow_lobe(node_); }
    [[nodiscard]] int lobe_count() const { return atlas().nodes[node_].smooth_lobes; }
    [[nodiscard]] bool has_delta_lobes() const { return atlas().nodes[node_].delta_lobes > 0; }
    [[nodiscard]] T lobe_weight(int lobe) const { return atlas().lobe_weight(node_, lobe); }
    [[nodiscard]] std::optional<V> sample_lobe(int, const V&, const gmis::Vec2<T>& uv, gmis::TransportMode) const {
      // Surfaces but this one, and the two directions of the sky.
      const std::size_t choice = pick(uv.x, surfaces - 1 + sky_nodes);
      if (choice >= surfaces - 1) return atlas().direction(node_, first_sky + choice - (surfaces - 1));
      return atlas().direction(node_, choice < node_ ? choice : choice + 1);
    }
    void lobe_pdfs(const V& to_prev, const V& to_next, T* pdfs) const {
      for (int lobe = 0; lobe < lobe_count(); ++lobe) pdfs[lobe] = atlas().lobe_pdf(node_, lobe, to_prev, to_next);
    }
    [[nodiscard]] bool lobes_have_full_support() const { return true; }

   private:
    [[nodiscard]] const Atlas& atlas() const { return world_->atlas_; }
    [[nodiscard]] T f(const V& to_prev, const V& to_next, gmis::TransportMode mode) const {
      return mode == gmis::TransportMode::radiance ? atlas().f(node_, to_next, to_prev)
                                                   : atlas().f(node_, to_prev, to_next);
    }
    [[nodiscard]] Tag tag(gmis::TransportMode mode, std::uint8_t lobe) const {
      const bool is_radiance = mode == gmis::TransportMode::radiance;
      return {order_, node_, lobe, is_radiance ? TagRole::scattered_radiance : TagRole::scattered_importance};
    }
    const DiscreteWorld* world_ = nullptr;
    std::uint8_t node_ = 0;
    std::uint32_t order_ = 0;
  };

  class Light {
   public:
    using Spectrum = Tagged<T>;
    Light(const DiscreteWorld& world, Kind kind) : world_(&world), kind_(kind) {
      for (std::size_t i = 0; i < world.atlas_.nodes.size(); ++i)
        if (world.atlas_.nodes[i].kind == kind && world.atlas_.nodes[i].emits) nodes_.push_back(i);
    }
    [[nodiscard]] Kind kind() const { return kind_; }
    [[nodiscard]] bool is_delta() const { return kind_ == Kind::point_light || kind_ == Kind::sun; }
    [[nodiscard]] bool is_infinite() const { return kind_ == Kind::sky || kind_ == Kind::sun; }

    [[nodiscard]] std::optional<gmis::NextEventSample<Spectrum>> sample_next_event(const gmis::SurfacePoint<T>& from,
                                                                                   const gmis::Vec2<T>& uv) const {
      const Atlas& laws = world_->atlas_;
      const std::size_t node = nodes_[pick(uv.x, nodes_.size())];
      const std::size_t receiver = world_->node_at(from.position);
      if (node == receiver) return std::nullopt;
      const V to_light = laws.direction(receiver, node);
      const T density = laws.next_event_density(node, from.position);
      // Radiance per density per steradian; intensity and irradiance as the plain irradiance they
      // make.
      const T weight = laws.emitted(node, -to_light) * laws.to_area(node, receiver) / density;
      auto origin = world_->point_of(node);
      if (is_delta()) origin.geometric_normal = -to_light;  // it is no surface, and nobody may ask
      return gmis::NextEventSample<Spectrum>{origin, to_light, Spectrum(weight, tag(node)), density,
                                             densities(node, -to_light)};
    }
    [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> sample_emission(
        const gmis::Vec2<T>& uv_origin, const gmis::Vec2<T>& uv_direction) const {
      const Atlas& laws = world_->atlas_;
      const std::size_t node = nodes_[pick(uv_origin.x, nodes_.size())];
      const std::size_t target = pick(uv_direction.x, surfaces);
      if (target == node) return std::nullopt;
      const V direction = -laws.direction(target, node);
      auto origin = world_->point_of(node);
      if (is_infinite()) origin = {laws.nodes[target].position - direction * T(4), {}, {}, T(0)};
      const auto density = densities(node, direction);
      const T cosine = kind_ == Kind::surface ? std::abs(glm::dot(laws.nodes[node].geometric_normal, direction)) : T(1);
      const T weight = laws.emitted(node, direction) * cosine / (density.origin * density.first);
      return gmis::EmissionSample<Spectrum>{origin, direction, Spectrum(weight, tag(node)), density};
    }
    /// The direction is turned to the nearest surface, and the line through `origin` is moved to
    /// it.
    [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> emission_along(const gmis::SurfacePoint<T>& origin,
                                                                               const V& direction) const {
      const Atlas& laws = world_->atlas_;
      const std::size_t node = node_of(origin, direction);
      const auto distance = [&](std::size_t target) {
        return is_infinite() ? glm::length(glm::cross(laws.nodes[target].position - origin.position, direction))
                             : -glm::dot(-laws.direction(target, node), direction);
      };
      std::size_t target = node == 0 ? 1 : 0;
      for (std::size_t i = 0; i < surfaces; ++i)
        if (i != node && distance(i) < distance(target)) target = i;
      for (std::size_t i = 0; i < surfaces; ++i)
        if (i == target) return sample_emission(number(node), {(static_cast<T>(i) + T(0.5)) / T(surfaces), T(0.5)});
      return std::nullopt;
    }
    [[nodiscard]] std::optional<gmis::Vec2<T>> start_numbers(const gmis::SurfacePoint<T>& origin,
                                                             const V& direction) const {
      if (is_delta()) return std::nullopt;
      return atlas_numbers(node_of(origin, direction));
    }
    /// The numbers of a node that emits: a law of this world.
    [[nodiscard]] static gmis::Vec2<T> atlas_numbers(std::size_t node) {
      return {T(0.03) + T(0.11) * static_cast<T>(node), T(0.97) - T(0.09) * static_cast<T>(node)};
    }
    [[nodiscard]] gmis::Emitted<Spectrum> emitted(const gmis::SurfacePoint<T>& origin, const V& direction) const {
      const std::size_t node = node_of(origin, direction);
      // Only the nodes of the sky shine.
      if (is_infinite() && glm::dot(world_->atlas_.nodes[node].position, -direction) < aligned) return {};
      return {Spectrum(world_->atlas_.emitted(node, direction), tag(node)), densities(node, direction)};
    }
    [[nodiscard]] T next_event_density(const gmis::SurfacePoint<T>& origin, const V& direction,
                                       const gmis::SurfacePoint<T>& from) const {
      if (is_delta()) return T(1);
      return world_->atlas_.next_event_density(node_of(origin, direction), from.position);
    }

   private:
    [[nodiscard]] std::size_t node_of(const gmis::SurfacePoint<T>& origin, const V& direction) const {
      if (!is_infinite()) return world_->node_at(origin.position);
      const auto is_less = [&](std::size_t a, std::size_t b) {
        return glm::dot(world_->atlas_.nodes[a].position, -direction) <
               glm::dot(world_->atlas_.nodes[b].position, -direction);
      };
      return *std::max_element(nodes_.begin(), nodes_.end(), is_less);
    }
    [[nodiscard]] gmis::EmissionDensity<T> densities(std::size_t node, const V& direction) const {
      return {world_->atlas_.emission_origin_density(node), world_->atlas_.emission_first_density(node, direction)};
    }
    [[nodiscard]] static Tag tag(std::size_t node) {
      return {0, static_cast<std::uint8_t>(node), Tag::smooth, TagRole::light};
    }
    /// A number from which `sample_emission` chooses this node.
    [[nodiscard]] gmis::Vec2<T> number(std::size_t node) const {
      const auto place = std::find(nodes_.begin(), nodes_.end(), node) - nodes_.begin();
      return {(static_cast<T>(place) + T(0.5)) / static_cast<T>(nodes_.size()), T(0.5)};
    }
    const DiscreteWorld* world_;
    Kind kind_;
    std::vector<std::size_t> nodes_;
  };

  class Camera {
   public:
    using Spectrum = Tagged<T>;
    Camera(const DiscreteWorld& world, int size) : world_(&world), size_(size) {}
    [[nodiscard]] glm::ivec2 resolution() const { return {size_, size_}; }
    [[nodiscard]] bool has_parallel_rays() const { return world_->atlas_.has_parallel_rays; }
    [[nodiscard]] std::optional<gmis::CameraSample<Spectrum>> sample_ray(glm::ivec2, const gmis::Vec2<T>& uv,
                                                                         const gmis::Vec2<T>& uv_lens) const {
      const Atlas& laws = world_->atlas_;
      const std::size_t camera = choose(uv_lens);
      const std::size_t target = pick(uv.x, surfaces + (has_parallel_rays() ? 0 : 1));
      const std::size_t node = target < surfaces ? target : first_sky;
      const V direction = has_parallel_rays() ? -laws.nodes[camera].position : laws.direction(camera, node);
      return gmis::CameraSample<Spectrum>{origin_for(camera, node), direction,
                                          Spectrum(laws.camera_weight(camera, direction), tag(camera)),
                                          laws.camera_density(camera, direction)};
    }
    [[nodiscard]] std::optional<gmis::CameraProjection<Spectrum>> project(const V& point,
                                                                          const gmis::Vec2<T>& uv) const {
      const Atlas& laws = world_->atlas_;
      const std::size_t camera = choose(uv);
      const std::size_t node = world_->node_at(point);
      const V to_camera = laws.direction(node, camera);
      const auto pixel = static_cast<int>(pick(uv.y, static_cast<std::size_t>(size_)));
      return gmis::CameraProjection<Spectrum>{{pixel, static_cast<int>(node) % size_},
                                              origin_for(camera, node),
                                              to_camera,
                                              Spectrum(laws.camera_weight(camera, -to_camera), tag(camera)),
                                              laws.camera_density(camera, -to_camera)};
    }

   private:
    [[nodiscard]] std::size_t choose(const gmis::Vec2<T>& uv) const {
      return first_camera + pick(uv.x, world_->atlas_.nodes.size() - first_camera);
    }
    [[nodiscard]] gmis::SurfacePoint<T> origin_for(std::size_t camera, std::size_t node) const {
      if (!has_parallel_rays()) return world_->point_of(camera);
      return {world_->atlas_.nodes[node].position + world_->atlas_.nodes[camera].position * T(4), {}, {}, T(0)};
    }
    [[nodiscard]] static Tag tag(std::size_t node) {
      return {0, static_cast<std::uint8_t>(node), Tag::smooth, TagRole::camera};
    }
    const DiscreteWorld* world_;
    int size_;
  };

  DiscreteWorld(Atlas atlas, int size)
      : atlas_(std::move(atlas)),
        lights_{Light(*this, Kind::surface), Light(*this, Kind::point_light), Light(*this, Kind::sun),
                Light(*this, Kind::sky)},
        camera_(*this, size) {}
  DiscreteWorld(const DiscreteWorld&) = delete;
  DiscreteWorld& operator=(const DiscreteWorld&) = delete;

  [[nodiscard]] std::optional<gmis::Hit<T, Bsdf, Light>> intersect(const gmis::Ray<T>& ray) const {
    ++rays_;
    for (std::size_t i = 0; i < surfaces; ++i) {
      const V offset = atlas_.nodes[i].position - ray.origin;
      const T length = glm::length(offset);
      if (length < T(0.1) || glm::dot(offset, ray.direction) < aligned * length) continue;
      return gmis::Hit<T, Bsdf, Light>{point_of(i), Bsdf(*this, static_cast<std::uint8_t>(i), rays_),
                                       atlas_.nodes[i].emits ? &lights_[0] : nullptr};
    }
    return std::nullopt;
  }
  [[nodiscard]] bool visible(const gmis::Ray<T>&) const { return true; }
  [[nodiscard]] gmis::LightChoice<T, Light> sample_light(T u) const {
    const Light& light = lights_[pick(u, lights_.size())];
    return {&light, selection_probability(light)};
  }
  [[nodiscard]] T selection_probability(const Light& light) const { return atlas_.light_probability(light.kind()); }
  [[nodiscard]] gmis::LightChoice<T, Light> sample_light(const gmis::SurfacePoint<T>& from,
                                                         T u) const requires is_choosy {
    const Light& light = lights_[pick(u, lights_.size())];
    return {&light, selection_probability(light, from)};
  }
  [[nodiscard]] T selection_probability(const Light& light,
                                        const gmis::SurfacePoint<T>& from) const requires is_choosy {
    return atlas_.light_probability_at(light.kind(), from.position, from.geometric_normal, from.shading_normal);
  }
  [[nodiscard]] std::array<const Light*, 1> infinite_lights() const { return {&lights_[3]}; }
  [[nodiscard]] const Camera& camera() const { return camera_; }
  [[nodiscard]] const Atlas& atlas() const { return atlas_; }
  [[nodiscard]] const std::array<Light, 4>& lights() const { return lights_; }

 private:
  static constexpr std::size_t surfaces = 5, first_sky = 7, sky_nodes = 2, first_camera = 9;
  static constexpr T aligned = T(0.9999);

  [[nodiscard]] static std::size_t pick(T u, std::size_t count) {
    return std::min(static_cast<std::size_t>(u * static_cast<T>(count)), count - 1);
  }
  [[nodiscard]] gmis::SurfacePoint<T> point_of(std::size_t node) const {
    const auto& n = atlas_.nodes[node];
    return {n.position, n.geometric_normal, n.shading_normal, T(0)};
  }
  [[nodiscard]] std::size_t node_at(const V& position) const {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < surfaces; ++i)
      if (glm::distance(atlas_.nodes[i].position, position) < glm::distance(atlas_.nodes[nearest].position, position))
        nearest = i;
    return nearest;
  }
  [[nodiscard]] std::size_t node_towards(const V& from, const V& direction) const {
    std::size_t best = 0;
    T largest(-2);
    for (std::size_t i = 0; i < atlas_.nodes.size(); ++i) {
      const V offset = atlas_.nodes[i].is_infinite ? atlas_.nodes[i].position : atlas_.nodes[i].position - from;
      const T length = glm::length(offset);
      if (length < T(0.1)) continue;
      const T cosine = glm::dot(offset, direction) / length;
      if (cosine > largest) {
        largest = cosine;
        best = i;
      }
    }
    return best;
  }

  Atlas atlas_;
  std::array<Light, 4> lights_;
  Camera camera_;
  mutable std::uint32_t rays_ = 0;
};

static_assert(gmis::Scene<DiscreteWorld<float>>);
static_assert(gmis::Scene<DiscreteWorld<double>>);
static_assert(!gmis::SceneWithReceiverChoice<DiscreteWorld<double>>);
static_assert(gmis::SceneWithReceiverChoice<DiscreteWorld<double, true>>);
static_assert(gmis::BsdfWithLobes<DiscreteWorld<double>::Bsdf>);

}  // namespace gmis_test
