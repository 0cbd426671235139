#include "gmis/core/transmittance.hpp"
#include "transport/furnace_scene.hpp"

struct World : gmis_test::FurnaceScene<float> {
  bool has_absorption() const;
#ifdef GMIS_EXPECT_OK
  Spectrum transmittance(const gmis::Ray<float>&) const;
#else  // nothing would be absorbed, silently
  Spectrum transmittance(const gmis::Ray<float>&);
#endif
};

bool absorbs(const World& world) {
  return gmis::absorbs(world);
}
