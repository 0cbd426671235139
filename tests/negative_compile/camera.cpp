#include "transport/furnace_scene.hpp"

struct Pinhole : gmis_test::FurnaceScene<float>::Camera {
#ifndef GMIS_EXPECT_OK
  void project() const;  // hides the one that is asked for
#endif
};

static_assert(gmis::Camera<Pinhole>);
