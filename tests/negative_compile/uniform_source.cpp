#include <cstdint>

#include "gmis/core/random.hpp"

struct Source {
  using result_type = std::uint32_t;
#ifdef GMIS_EXPECT_OK
  static constexpr result_type min() {
    return 0;
  }
#endif
  static constexpr result_type max() {
    return 0xFFFFFFFFU;
  }
  result_type operator()() {
    return 4;
  }
};

static_assert(gmis::UniformSource<Source>);
