#include "gmis/core/light_choice.hpp"
#include "transport/furnace_scene.hpp"

struct World : gmis_test::FurnaceScene<float> {
  using FurnaceScene::sample_light;
  using FurnaceScene::selection_probability;
  gmis::LightChoice<float, Light> sample_light(const gmis::SurfacePoint<float>&, float) const;
#ifdef GMIS_EXPECT_OK  // one of the two members without the other would be left unused, silently
  float selection_probability(const Light&, const gmis::SurfacePoint<float>&) const;
#endif
};

static_assert(gmis::chooses_for_receiver<World>());
