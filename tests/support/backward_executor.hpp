#pragma once

#include <cstddef>

namespace gmis_test {

/// Calls `work` in the order opposite to that of gmis::SerialExecutor.
struct BackwardExecutor {
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) const {
    while (count-- > 0) work(count);
  }
};

}  // namespace gmis_test
