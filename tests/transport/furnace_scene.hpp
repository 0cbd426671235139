#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "gmis/core/concepts.hpp"
#include "gmis/core/warp.hpp"

namespace gmis_test {

/// The uniform furnace, written as a renderer of someone's own would adapt itself: a sphere of
/// radius 1 seen from inside, every point emitting radiance L and reflecting the share a diffusely.
/// Radiance is the same everywhere and in every direction: with paths of at most D edges it is L
/// (1 + a + … + a^{D-1}) = L (1 − a^D)/(1 − a).
template <std::floating_point T>
class FurnaceScene {
 public:
  using Spectrum = T;  // one channel

  /// Where the camera is, if nothing else is said: not in the middle, so that pixels differ.
  static constexpr gmis::Vec3<T> usual_eye{T(0.2), T(0.1), T(0)};

  /// Lambert's f, offered as two proposals of very different shape: cosine-weighted and uniform
  /// over the hemisphere.
  class Bsdf {
   public:
    using Spectrum = T;
    static constexpr int max_lobes = 2;

    Bsdf() = default;
    Bsdf(T albedo, const gmis::Vec3<T>& normal, int lobes) : albedo_(albedo), normal_(normal), lobes_(lobes) {}

    [[nodiscard]] gmis::BsdfValue<T> evaluate(const gmis::Vec3<T>& to_prev, const gmis::Vec3<T>& to_next,
                                              gmis::TransportMode) const {
      if (glm::dot(to_prev, normal_) <= T(0) || glm::dot(to_next, normal_) <= T(0)) return {};
      return {albedo_ / gmis::pi<T>, {{mixture(to_next)}, {mixture(to_prev)}}};
    }
    [[nodiscard]] std::optional<gmis::ScatterSample<T>> sample(const gmis::Vec3<T>& to_prev, T u,
                                                               const gmis::Vec2<T>& uv,
                                                               gmis::TransportMode mode) const {
      const auto to_next = sample_lobe(lobes_ == 2 && u < T(0.5) ? 1 : 0, to_prev, uv, mode);
      const auto f = evaluate(to_prev, *to_next, mode);
      if (!(f.pdf.forward.value > T(0))) return std::nullopt;
      return gmis::ScatterSample<T>{*to_next, f.value * glm::dot(*to_next, normal_) / f.pdf.forward.value, f.pdf, false,
                                    T(1)};
    }
    [[nodiscard]] bool is_purely_delta() const { return false; }
    [[nodiscard]] T albedo() const { return albedo_; }
    [[nodiscard]] int lobe_count() const { return lobes_; }
    [[nodiscard]] T lobe_weight(int) const { return T(1) / static_cast<T>(lobes_); }
    [[nodiscard]] std::optional<gmis::Vec3<T>> sample_lobe(int lobe, const gmis::Vec3<T>&, const gmis::Vec2<T>& uv,
                                                           gmis::TransportMode) const {
      gmis::Vec3<T> local = gmis::square_to_cosine_hemisphere(uv);
      if (lobe == 1) {
        local = gmis::square_to_sphere(uv);
        local.z = std::abs(local.z);
      }
      return gmis::Frame<T>::around(normal_).to_world(local);
    }
    void lobe_pdfs(const gmis::Vec3<T>&, const gmis::Vec3<T>& to_next, T* pdfs) const {
      const T cosine = std::max(T(0), glm::dot(to_next, normal_));
      pdfs[0] = cosine / gmis::pi<T>;
      if (lobes_ == 2) pdfs[1] = T(1) / (T(2) * gmis::pi<T>);
    }
    [[nodiscard]] bool has_delta_lobes() const { return false; }
    [[nodiscard]] bool lobes_have_full_support() const { return true; }

   private:
    [[nodiscard]] T mixture(const gmis::Vec3<T>& w) const {
      const T cosine = glm::dot(w, normal_) / gmis::pi<T>;
      return lobes_ == 2 ? (cosine + T(1) / (T(2) * gmis::pi<T>)) / T(2) : cosine;
    }
    T albedo_{};
    gmis::Vec3<T> normal_{};
    int lobes_ = 1;
  };

  class Light {
   public:
    using Spectrum = T;
    explicit Light(T radiance) : radiance_(radiance) {}
    [[nodiscard]] bool is_delta() const { return false; }
    [[nodiscard]] bool is_infinite() const { return false; }
    [[nodiscard]] std::optional<gmis::NextEventSample<T>> sample_next_event(const gmis::SurfacePoint<T>& from,
                                                                            const gmis::Vec2<T>& uv) const {
      const auto origin = point_at(gmis::square_to_sphere(uv));
      const auto offset = origin.position - from.position;
      const T distance_squared = glm::dot(offset, offset);
      if (distance_squared < T(1e-8)) return std::nullopt;
      const auto to_light = offset / std::sqrt(distance_squared);
      const T cosine = -glm::dot(origin.geometric_normal, to_light);
      if (cosine <= T(0)) return std::nullopt;
      return gmis::NextEventSample<T>{origin, to_light, radiance_ * cosine / distance_squared * area(), T(1) / area(),
                                      density(cosine)};
    }
    [[nodiscard]] std::optional<gmis::EmissionSample<T>> sample_emission(const gmis::Vec2<T>& uv_origin,
                                                                         const gmis::Vec2<T>& uv_direction) const {
      const auto origin = point_at(gmis::square_to_sphere(uv_origin));
      const auto local = gmis::square_to_cosine_hemisphere(uv_direction);
      if (local.z <= T(0)) return std::nullopt;
      return gmis::EmissionSample<T>{origin, gmis::Frame<T>::around(origin.geometric_normal).to_world(local),
                                     radiance_ * gmis::pi<T> * area(), density(local.z)};
    }
    [[nodiscard]] gmis::Emitted<T> emitted(const gmis::SurfacePoint<T>& origin, const gmis::Vec3<T>& direction) const {
      const T cosine = glm::dot(origin.geometric_normal, direction);
      if (cosine <= T(0)) return {};
      return {radiance_, density(cosine)};
    }
    [[nodiscard]] T next_event_density(const gmis::SurfacePoint<T>&, const gmis::Vec3<T>&,
                                       const gmis::SurfacePoint<T>&) const {
      return T(1) / area();
    }

   private:
    [[nodiscard]] static T area() { return T(4) * gmis::pi<T>; }
    [[nodiscard]] static gmis::EmissionDensity<T> density(T cosine) { return {T(1) / area(), cosine / gmis::pi<T>}; }
    T radiance_;
  };

  /// Looks along +z; x to the right, y up.
  class Camera {
   public:
    using Spectrum = T;
    explicit Camera(int size, const gmis::Vec3<T>& eye = usual_eye) : size_(size), eye_(eye) {}
    [[nodiscard]] glm::ivec2 resolution() const { return {size_, size_}; }
    [[nodiscard]] bool has_parallel_rays() const { return false; }
    [[nodiscard]] std::optional<gmis::CameraSample<T>> sample_ray(glm::ivec2 pixel, const gmis::Vec2<T>& uv,
                                                                  const gmis::Vec2<T>&) const {
      const T x = (T(2) * (static_cast<T>(pixel.x) + uv.x) / static_cast<T>(size_) - T(1)) * half_width;
      const T y = (T(1) - T(2) * (static_cast<T>(pixel.y) + uv.y) / static_cast<T>(size_)) * half_width;
      const auto direction = glm::normalize(gmis::Vec3<T>(x, y, T(1)));
      return gmis::CameraSample<T>{origin(), direction, T(1), density(direction)};
    }
    [[nodiscard]] std::optional<gmis::CameraProjection<T>> project(const gmis::Vec3<T>& point,
                                                                   const gmis::Vec2<T>&) const {
      const auto direction = glm::normalize(point - origin().position);
      if (direction.z <= T(0)) return std::nullopt;
      const T x = (direction.x / direction.z / half_width + T(1)) / T(2) * static_cast<T>(size_);
      const T y = (T(1) - direction.y / direction.z / half_width) / T(2) * static_cast<T>(size_);
      if (!(x >= T(0) && y >= T(0) && x < static_cast<T>(size_) && y < static_cast<T>(size_))) return std::nullopt;
      return gmis::CameraProjection<T>{
          {static_cast<int>(x), static_cast<int>(y)}, origin(), -direction, T(1), density(direction)};
    }

   private:
    static constexpr T half_width = T(0.75);
    [[nodiscard]] gmis::SurfacePoint<T> origin() const { return {eye_, {}, {}, T(0)}; }
    [[nodiscard]] T density(const gmis::Vec3<T>& direction) const {
      const T pixel_area = gmis::square(T(2) * half_width / static_cast<T>(size_));
      return T(1) / (pixel_area * direction.z * direction.z * direction.z);
    }
    int size_;
    gmis::Vec3<T> eye_;
  };

  FurnaceScene(T albedo, T radiance, int size, int lobes = 1, const gmis::Vec3<T>& eye = usual_eye)
      : albedo_(albedo), lobes_(lobes), light_(radiance), camera_(size, eye) {}

  [[nodiscard]] std::optional<gmis::Hit<T, Bsdf, Light>> intersect(const gmis::Ray<T>& ray) const {
    // From inside there is always a hit, and only one: t² + 2 t (o·d) + o·o − 1 = 0.
    const T half_b = glm::dot(ray.origin, ray.direction);
    const T t = -half_b + std::sqrt(std::max(T(0), half_b * half_b + T(1) - glm::dot(ray.origin, ray.origin)));
    if (!(t > T(1e-4) && t < ray.t_max)) return std::nullopt;
    const auto point = point_at(glm::normalize(ray.origin + ray.direction * t));
    return gmis::Hit<T, Bsdf, Light>{point, Bsdf(albedo_, point.geometric_normal, lobes_), &light_};
  }
  [[nodiscard]] bool visible(const gmis::Ray<T>&) const { return true; }
  [[nodiscard]] gmis::LightChoice<T, Light> sample_light(T) const { return {&light_, T(1)}; }
  [[nodiscard]] T selection_probability(const Light&) const { return T(1); }
  [[nodiscard]] std::array<const Light*, 0> infinite_lights() const { return {}; }
  [[nodiscard]] const Camera& camera() const { return camera_; }

 private:
  [[nodiscard]] static gmis::SurfacePoint<T> point_at(const gmis::Vec3<T>& on_sphere) {
    return {on_sphere, -on_sphere, -on_sphere, T(0)};
  }
  T albedo_;
  int lobes_;
  Light light_;
  Camera camera_;
};

static_assert(gmis::Scene<FurnaceScene<float>>);
static_assert(gmis::Scene<FurnaceScene<double>>);
static_assert(gmis::BsdfWithLobes<FurnaceScene<float>::Bsdf>);

}  // namespace gmis_test
