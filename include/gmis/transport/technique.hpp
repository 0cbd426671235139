#pragma once

#include <cstdint>

namespace gmis {

enum class Technique : std::uint8_t { emitter_hit, next_event, connect, splat, merge };

/// Which technique made a path, with `s` light and `t` camera vertices; a merged vertex counts on both sides.
struct TechniqueId {
  Technique technique;
  std::int16_t s;
  std::int16_t t;
};

}  // namespace gmis
