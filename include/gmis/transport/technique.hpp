#pragma once

#include <cstddef>
#include <cstdint>

#include "gmis/transport/path_class.hpp"

namespace gmis {

enum class Technique : std::uint8_t { emitter_hit, next_event, connect, splat, merge };
inline constexpr std::size_t technique_count = 5;

/// Which technique made a path, with `s` light and `t` camera vertices; a merged vertex counts on both sides. The class of
/// the path is known where the integrator is `Classified`.
struct TechniqueId {
  Technique technique;
  std::int16_t s;
  std::int16_t t;
  PathClass path_class = PathClass::unclassified;
};

}  // namespace gmis
