#pragma once

#include <string_view>

#include "gmis/core/attributes.hpp"

#if defined(__AVX2__) && defined(__FMA__)
#define GMIS_INSTRUCTION_SET "x86-64-v3"
#define GMIS_MARK_OF_COMPILED compiled_for_x86_64_v3
#elif defined(__x86_64__) || defined(_M_X64)
#define GMIS_INSTRUCTION_SET "x86-64"
#define GMIS_MARK_OF_COMPILED compiled_for_x86_64
#else
#define GMIS_INSTRUCTION_SET "default"
#define GMIS_MARK_OF_COMPILED compiled_for_default
#endif

namespace gmis {

/// The level of the processor that this is compiled for, as far as it changes the bits of results:
/// "x86-64-v3" (AVX2 and FMA: intersection rounds a product and a sum at once), "x86-64", or
/// "default" on another architecture.
inline constexpr std::string_view instruction_set = GMIS_INSTRUCTION_SET;

#ifdef GMIS_COMPILED
/// The target `gmis::compiled` defines the mark of the level that it is compiled for. A file that
/// is compiled for another one then fails to link: the layout of the built-in scene differs.
extern const char GMIS_MARK_OF_COMPILED;
namespace detail {
GMIS_KEPT inline const char* const mark_of_compiled = &GMIS_MARK_OF_COMPILED;
}
#endif

}  // namespace gmis

#undef GMIS_INSTRUCTION_SET
