#pragma once

/// \file
/// Attributes of compilers, which no other header names. A compiler without them ignores them.

#if defined(__GNUC__)
/// Inlined at every call: on the hot path, where the compiler judges by size alone.
#define GMIS_ALWAYS_INLINE [[gnu::always_inline]]
/// Never inlined: what seldom runs must not take registers of the code around it.
#define GMIS_NEVER_INLINE [[gnu::noinline]]
/// Runs seldom: compiled for size, apart from the code around it. Takes less time to compile, too.
#define GMIS_RARE [[gnu::cold, gnu::noinline]]
/// Inlines all that the function calls: the walks where nearly all time is spent.
#define GMIS_FLATTEN [[gnu::flatten]]
#else
#define GMIS_ALWAYS_INLINE
#define GMIS_NEVER_INLINE
#define GMIS_RARE
#define GMIS_FLATTEN
#endif
