#pragma once

#include <string_view>

namespace gmis::tools {

/// The level of the processor that this file is compiled for: "x86-64-v3" (AVX2 and FMA), "x86-64", or "default" on another
/// architecture.
inline constexpr std::string_view instruction_set =
#if defined(__AVX2__) && defined(__FMA__)
    "x86-64-v3";
#elif defined(__x86_64__) || defined(_M_X64)
    "x86-64";
#else
    "default";
#endif

/// False where this processor lacks what the program is compiled for.
[[nodiscard]] inline bool processor_has_instruction_set() {
#if defined(__AVX2__) && defined(__FMA__) && (defined(__GNUC__) || defined(__clang__))
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
#else
  return true;
#endif
}

}  // namespace gmis::tools
