#pragma once

#include <type_traits>

namespace gmis {

/// The techniques of an integrator, composed at compile time: what is not in the list is not compiled into the hot
/// loop.
template <class... Ts>
struct Techniques {
  template <class T>
  static constexpr bool contains = (std::is_same_v<T, Ts> || ...);
};

}  // namespace gmis
