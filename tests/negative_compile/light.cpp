#include "transport/furnace_scene.hpp"

struct Lamp : gmis_test::FurnaceScene<float>::Light {
#ifndef GMIS_EXPECT_OK
  float next_event_density() const;  // hides the one that is asked for
#endif
};

static_assert(gmis::Light<Lamp>);
