#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"

namespace gmis {

/// The capacity of something whose size is known at run time only.
inline constexpr std::size_t dynamic_capacity = static_cast<std::size_t>(-1);

/// Room for up to `Capacity` items, inside the object: no allocation, and not initialised.
template <class T, std::size_t Capacity>
class Storage {
 public:
  /// Must be called before use. Throws std::invalid_argument when `size` exceeds the capacity.
  constexpr void prepare(std::size_t size) {
    require_argument(size <= Capacity,
                     "more proposals or samples than the fixed capacity holds: raise the capacity of "
                     "the set, Workspace, SampleAllocation or Groups, or use dynamic_capacity");
  }
  [[nodiscard]] constexpr T* data() noexcept { return items_.data(); }
  [[nodiscard]] constexpr const T* data() const noexcept { return items_.data(); }
  [[nodiscard]] constexpr T& operator[](std::size_t i) noexcept { return items_[i]; }
  [[nodiscard]] constexpr const T& operator[](std::size_t i) const noexcept { return items_[i]; }

 private:
  std::array<T, Capacity> items_;
};

/// Room on the heap: `prepare(size)` allocates when `size` exceeds what was prepared before, and
/// only then.
template <class T>
class Storage<T, dynamic_capacity> {
 public:
  void prepare(std::size_t size) {
    if (items_.size() < size) [[unlikely]]
      grow(size);
  }
  [[nodiscard]] T* data() noexcept { return items_.data(); }
  [[nodiscard]] const T* data() const noexcept { return items_.data(); }
  [[nodiscard]] T& operator[](std::size_t i) noexcept { return items_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const noexcept { return items_[i]; }

 private:
  // Out of line: rounds prepare their workspace each time, and almost never need to.
  GMIS_RARE void grow(std::size_t size) { items_.resize(size); }

  std::vector<T> items_;
};

}  // namespace gmis
