#include "gmis/core/concepts.hpp"

struct Pool {
#ifdef GMIS_EXPECT_OK
  template <class Work>
  void parallel_for(std::size_t, Work&&) {}
#else
  void parallel_for(std::size_t, void (*)(std::size_t)) {}  // the engine's lambdas have captures
#endif
};

static_assert(gmis::Executor<Pool>);
