#include "gmis/core/transmittance.hpp"
#include "transport/furnace_scene.hpp"

struct World : gmis_test::FurnaceScene<float> {
  using Point = gmis::SurfacePoint<float>;
  Spectrum transmittance(const gmis::Ray<float>&, const Point& from, const Point& to) const;
#ifdef GMIS_EXPECT_OK  // without it nothing would be absorbed, silently
  bool has_absorption() const;
#endif
};

bool absorbs(const World& world) {
  return gmis::absorbs(world);
}
