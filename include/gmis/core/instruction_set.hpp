#pragma once

#include <string_view>

namespace gmis {

/// The level of the processor that this is compiled for, as far as it changes the bits of results:
/// "x86-64-v3" (AVX2 and FMA: intersection rounds a product and a sum at once), "x86-64", or
/// "default" on another architecture.
inline constexpr std::string_view instruction_set =
#if defined(__AVX2__) && defined(__FMA__)
    "x86-64-v3";
#elif defined(__x86_64__) || defined(_M_X64)
    "x86-64";
#else
    "default";
#endif

}  // namespace gmis
