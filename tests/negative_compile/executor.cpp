#include "gmis/core/concepts.hpp"

struct Pool {
#ifdef GMIS_EXPECT_OK
  template <class Work>
  void parallel_for(std::size_t, Work&&) {}
#endif
};

static_assert(gmis::Executor<Pool>);
