#include "transport/furnace_scene.hpp"

struct Lobes : gmis_test::FurnaceScene<float>::Bsdf {
#ifndef GMIS_EXPECT_OK
  void lobe_pdfs() const;  // hides the one that is asked for
#endif
};

static_assert(gmis::BsdfWithLobes<Lobes>);
