#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <array>
#include <gmis/scene.hpp>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

/// \file
/// Embree as the intersector; materials, lights and camera stay the built-in ones. Tried with
/// Embree 3.13; the lines for version 4, behind RTC_VERSION_MAJOR, were not.

namespace embree {
#if RTC_VERSION_MAJOR >= 4
inline constexpr auto find_nearest = [](RTCScene in, RTCRayHit& ray) { rtcIntersect1(in, &ray, nullptr); };
inline constexpr auto find_any = [](RTCScene in, RTCRay& ray) { rtcOccluded1(in, &ray, nullptr); };
#else
inline RTCIntersectContext new_context() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return context;
}
inline constexpr auto find_nearest = [](RTCScene in, RTCRayHit& ray, RTCIntersectContext context = new_context()) {
  rtcIntersect1(in, &context, &ray);
};
inline constexpr auto find_any = [](RTCScene in, RTCRay& ray, RTCIntersectContext context = new_context()) {
  rtcOccluded1(in, &context, &ray);
};
#endif
struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
/// A scene of triangles. `Built` is a built-in scene of the same triangles.
class Scene {
 public:
  using Built = gmis::scene::BvhScene<float>;
  using Spectrum = Built::Spectrum;
  using Bsdf = Built::Bsdf;
  using Light = Built::Light;
  using Camera = Built::Camera;
  using Hit = gmis::Hit<float, Bsdf, Light>;
  using Corners = std::array<glm::dvec3, 3>;  ///< in world space; the normal is (b − a) × (c − a)
  Scene(Built built, std::span<const Corners> triangles)
      : built_(std::move(built)), device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_.get())) {
    if (!device_) throw std::runtime_error("Embree: no device");
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    RTCGeometry mesh = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* corners = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                    sizeof(glm::vec3), 3 * triangles.size()));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   3 * sizeof(unsigned), triangles.size()));
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      std::array<glm::vec3, 3> moved;  // the built-in scene has its camera at 0
      for (std::size_t c = 0; c < 3; ++c) {
        moved[c] = glm::vec3(triangles[i][c] - built_.statistics().world_origin);
        corners[3 * i + c] = moved[c];
        indices[3 * i + c] = static_cast<unsigned>(3 * i + c);
      }
      corners_.push_back(moved);
      surfaces_.push_back(surface_of(moved));
    }
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene_.get(), mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(scene_.get());
  }
  [[nodiscard]] std::optional<Hit> intersect(const gmis::Ray<float>& ray) const {
    RTCRayHit query{};
    query.ray = converted(ray);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    find_nearest(scene_.get(), query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    Hit hit = surfaces_[query.hit.primID];
    const auto& [a, b, c] = corners_[query.hit.primID];
    // From the corners, not along the ray: this error does not grow with the distance.
    hit.point.position = a * (1 - query.hit.u - query.hit.v) + b * query.hit.u + c * query.hit.v;
    return hit;
  }
  [[nodiscard]] bool visible(const gmis::Ray<float>& ray) const {
    if (!(ray.t_max > 0)) return true;  // points nearer to each other than their offsets
    RTCRay query = converted(ray);
    find_any(scene_.get(), query);
    return query.tfar >= 0;  // −∞ says that something was met
  }
  [[nodiscard]] gmis::LightChoice<float, Light> sample_light(float u) const { return built_.sample_light(u); }
  [[nodiscard]] float selection_probability(const Light& light) const { return built_.selection_probability(light); }
  [[nodiscard]] auto infinite_lights() const { return built_.infinite_lights(); }
  [[nodiscard]] const Camera& camera() const { return built_.camera(); }
  [[nodiscard]] const gmis::Effects& effects() const { return built_.effects(); }

 private:
  /// Normal, material and light of a triangle, as the built-in scene finds them in its middle.
  [[nodiscard]] Hit surface_of(const std::array<glm::vec3, 3>& t) const {
    const glm::vec3 normal = glm::normalize(glm::cross(t[1] - t[0], t[2] - t[0])), middle = (t[0] + t[1] + t[2]) / 3.0F;
    const float step = 1e-4F * glm::length(t[1] - t[0]);
    const auto hit = built_.intersect({middle + step * normal, -normal, 2 * step});
    if (!hit) throw std::invalid_argument("Embree: a triangle is not in the built-in scene");
    return *hit;
  }
  [[nodiscard]] static RTCRay converted(const gmis::Ray<float>& ray) {
    const glm::vec3 &o = ray.origin, &d = ray.direction;
    return {o.x, o.y, o.z, 0, d.x, d.y, d.z, 0, ray.t_max, ~0U, 0, 0};
  }
  Built built_;
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::unique_ptr<RTCSceneTy, Release> scene_;
  std::vector<std::array<glm::vec3, 3>> corners_;
  std::vector<Hit> surfaces_;
};
static_assert(gmis::SceneWithEffects<Scene>);

}  // namespace embree
