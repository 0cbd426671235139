#pragma once

#include <embree3/rtcore.h>

#include <cstdint>

// Embree 4's calls, as far as lajolla makes them, over Embree 3, which Debian has.

struct RTCIntersectArguments {};
struct RTCOccludedArguments {};
inline void rtcInitIntersectArguments(RTCIntersectArguments*) {}
inline void rtcInitOccludedArguments(RTCOccludedArguments*) {}

inline std::uint64_t rays_traced = 0;  // of both kinds; on one thread

inline void rtcIntersect1(RTCScene scene, RTCRayHit* ray, RTCIntersectArguments*) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  ++rays_traced;
  rtcIntersect1(scene, &context, ray);
}
inline void rtcOccluded1(RTCScene scene, RTCRay* ray, RTCOccludedArguments*) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  ++rays_traced;
  rtcOccluded1(scene, &context, ray);
}
