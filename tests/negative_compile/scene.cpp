#include "transport/furnace_scene.hpp"

struct World : gmis_test::FurnaceScene<float> {
#ifndef GMIS_EXPECT_OK
  int visible(const gmis::Ray<float>&) const;  // hides the one that is asked for, and does not answer with a bool
#endif
};

static_assert(gmis::Scene<World>);
