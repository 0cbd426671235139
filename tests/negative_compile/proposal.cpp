#include "gmis/mis/proposal.hpp"

struct Coin {
  float sample(gmis::UniformSource auto&) const { return 0.5F; }
#ifdef GMIS_EXPECT_OK
  float pdf(float) const {
    return 1.0F;
  }
#endif
};

static_assert(gmis::Proposal<Coin, float>);
