#pragma once

namespace gmis_test {

/// The factor by which a long test divides its iterations: 1, but under the sanitizers 4. They look
/// at how memory is used, and take twenty times as long. A standard error is then twice as large,
/// and so may be the bounds that a test sets on it.
#ifdef GMIS_UNDER_SANITIZERS
constexpr int fewer = 4;
#else
constexpr int fewer = 1;
#endif

}  // namespace gmis_test
