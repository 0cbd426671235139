#pragma once

#include <cstdlib>
#include <stdexcept>

#include "gmis/core/attributes.hpp"

namespace gmis {

/// Rejects a wrong argument: throws std::invalid_argument, whose message says what to change. A
/// program that is compiled without exceptions (`-fno-exceptions`) ends by std::abort, as the
/// standard library's own functions do there.
///
/// Arguments are checked where they are given: once a call of `estimate`, once a construction, once
/// a round of your own loop, never once a sample.
[[noreturn]] GMIS_RARE inline void reject_argument([[maybe_unused]] const char* message) {
#if defined(__cpp_exceptions)
  throw std::invalid_argument(message);
#else
  std::abort();
#endif
}

/// Rejects the argument that `message` speaks of unless `holds`.
constexpr void require_argument(bool holds, const char* message) {
  if (!holds) [[unlikely]]
    reject_argument(message);
}

}  // namespace gmis
