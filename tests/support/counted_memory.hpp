#pragma once

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

/// \file
/// Counts the bytes that `new` gives out: a program includes this in one file. Memory asked for in
/// other ways is not counted.

namespace counted_memory {

inline std::atomic<std::size_t> now{0}, peak{0};
inline constexpr std::size_t header = 64;  // keeps what follows aligned as much as anything here asks for

inline void* allocate(std::size_t size) {
  void* const block = std::aligned_alloc(header, (size + 2 * header - 1) / header * header);
  if (block == nullptr) return nullptr;
  *static_cast<std::size_t*>(block) = size;
  const std::size_t sum = now += size;
  for (std::size_t most = peak; most < sum && !peak.compare_exchange_weak(most, sum);) {
  }
  return static_cast<char*>(block) + header;
}
inline void* allocate_or_throw(std::size_t size) {
  void* const pointer = allocate(size);
  if (pointer == nullptr) throw std::bad_alloc();
  return pointer;
}
inline void release(void* pointer) noexcept {
  if (pointer == nullptr) return;
  void* const block = static_cast<char*>(pointer) - header;
  now -= *static_cast<std::size_t*>(block);
  std::free(block);
}

}  // namespace counted_memory

void* operator new(std::size_t size) {
  return counted_memory::allocate_or_throw(size);
}
void* operator new(std::size_t size, std::align_val_t) {
  return counted_memory::allocate_or_throw(size);
}
// ThreadSanitizer has one of its own, which would not call the one above.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return counted_memory::allocate(size);
}
void operator delete(void* pointer) noexcept {
  counted_memory::release(pointer);
}
void operator delete(void* pointer, std::size_t) noexcept {
  counted_memory::release(pointer);
}
void operator delete(void* pointer, std::align_val_t) noexcept {
  counted_memory::release(pointer);
}
void operator delete(void* pointer, std::size_t, std::align_val_t) noexcept {
  counted_memory::release(pointer);
}
