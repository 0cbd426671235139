#pragma once

#include <embree3/rtcore.h>

#include <string>

#include "bvh/meshes.hpp"
#include "bvh/rays.hpp"

/// \file
/// Embree 3 over a mesh, single rays, ROBUST.

namespace bench_bvh {

class EmbreeScene {
 public:
  EmbreeScene(const Mesh& mesh, int threads) {
    device_ = rtcNewDevice(("threads=" + std::to_string(threads) + ",set_affinity=0").c_str());
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* positions = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.positions.size()));
    for (const auto& p : mesh.positions)
      for (int axis = 0; axis < 3; ++axis) *positions++ = p[axis];
    auto* corners = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size()));
    for (const auto& t : mesh.triangles)
      for (const std::uint32_t corner : t) *corners++ = corner;
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  void build() { rtcCommitScene(scene_); }

  /// The distance of the nearest hit; `t_max` of the ray for none.
  [[nodiscard]] float closest(const Ray<float>& ray) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query;
    query.ray = prepared(ray);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &query);
    return query.ray.tfar;
  }
  [[nodiscard]] bool is_blocked(const Ray<float>& ray) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay query = prepared(ray);
    rtcOccluded1(scene_, &context, &query);
    return query.tfar < 0;
  }

 private:
  static RTCRay prepared(const Ray<float>& ray) {
    RTCRay query;
    query.org_x = ray.origin.x;
    query.org_y = ray.origin.y;
    query.org_z = ray.origin.z;
    query.tnear = 0;
    query.dir_x = ray.direction.x;
    query.dir_y = ray.direction.y;
    query.dir_z = ray.direction.z;
    query.time = 0;
    query.tfar = ray.t_max;
    query.mask = ~0U;
    query.id = 0;
    query.flags = 0;
    return query;
  }

  RTCDevice device_;
  RTCScene scene_;
};

}  // namespace bench_bvh
