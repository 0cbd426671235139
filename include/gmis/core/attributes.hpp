#pragma once

/// \file
/// Attributes and builtins of compilers. No other header names one.

#if defined(__GNUC__)
/// Inlined at every call: on the hot path, where the compiler judges by size alone.
#define GMIS_ALWAYS_INLINE [[gnu::always_inline]]
/// Never inlined: what seldom runs must not take registers of the code around it.
#define GMIS_NEVER_INLINE [[gnu::noinline]]
/// Runs seldom: compiled for size, apart from the code around it. It takes less time to compile,
/// too.
#define GMIS_RARE [[gnu::cold, gnu::noinline]]
/// Kept in the object file although nothing uses it.
#define GMIS_KEPT [[gnu::used]]
/// Inlines all that the function calls: the walks where nearly all time is spent.
#define GMIS_FLATTEN [[gnu::flatten]]
/// `GMIS_ALWAYS_INLINE` and `GMIS_RARE` for lambdas, after their parameters.
#define GMIS_ALWAYS_INLINE_LAMBDA __attribute__((always_inline))
/// Marks a lambda that runs seldom, after its parameters: compiled for size, never inlined.
#define GMIS_RARE_LAMBDA __attribute__((cold, noinline))
/// A vector of this many bytes, after the name in an alias of its element type; arithmetic is by
/// element.
#define GMIS_VECTOR_OF_BYTES(count) __attribute__((vector_size(count)))
/// Asks for memory that is read soon.
#define GMIS_PREFETCH(address) __builtin_prefetch(address)
/// A division by 0 that is meant: its result is infinite or not a number, as IEEE 754 has it.
#define GMIS_INTENDED_IEEE_DIVISION __attribute__((no_sanitize("float-divide-by-zero")))
#else
#define GMIS_ALWAYS_INLINE
#define GMIS_NEVER_INLINE
#define GMIS_RARE
#define GMIS_KEPT
#define GMIS_FLATTEN
#define GMIS_ALWAYS_INLINE_LAMBDA
#define GMIS_RARE_LAMBDA
#define GMIS_PREFETCH(address) static_cast<void>(address)
#define GMIS_INTENDED_IEEE_DIVISION
#endif
