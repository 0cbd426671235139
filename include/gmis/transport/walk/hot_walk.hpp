#pragma once

#include <concepts>

#include "gmis/transport/state/film_output.hpp"

namespace gmis::detail {

/// True for the walks that take nearly all the time of a run: their calls are inlined into one
/// function. The walks of a pilot, of a replay and of light trees that split are not: a flat walk
/// takes seconds to compile.
template <class Context, class Output>
inline constexpr bool is_hot_walk =
    std::same_as<Output, FilmOutput<typename Context::S>> && !Context::Split::is_measured;

}  // namespace gmis::detail
