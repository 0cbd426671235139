#pragma once

#include "gmis/core/instruction_set.hpp"

namespace gmis::tools {

using gmis::instruction_set;

/// False where this processor lacks what the program is compiled for.
[[nodiscard]] inline bool processor_has_instruction_set() {
#if defined(__AVX2__) && defined(__FMA__) && (defined(__GNUC__) || defined(__clang__))
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
#else
  return true;
#endif
}

}  // namespace gmis::tools
