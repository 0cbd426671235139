#pragma once

namespace gmis_test {

/// The factor by which a long test divides its samples: 1, but under the sanitizers 4, since code
/// runs ten times as long there. The bounds on standard errors, which say what a test would notice,
/// grow by its root there; no other bound does. Some thirty values stay behind each standard error:
/// with fewer, Student's limit lets faults pass.
#ifdef GMIS_FEWER_SAMPLES
constexpr int fewer = 4;
#else
constexpr int fewer = 1;
#endif

}  // namespace gmis_test
