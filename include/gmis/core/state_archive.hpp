#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "gmis/core/attributes.hpp"

/// \file
/// The state of a run as bytes, to go on with it later in the same build of the same program on the
/// same kind of machine. A class that takes part has one member for both ways,
/// `exchange_state(archive)`, which names its data once: `archive(first_, second_)` writes them to
/// a `StateWriter` and reads them from a `StateReader`.

namespace gmis {

/// Writes the state of objects as bytes.
class StateWriter {
 public:
  /// It writes.
  static constexpr bool is_reading = false;

  template <class... Values>
  GMIS_RARE void operator()(Values&... values) {
    (exchange(values), ...);
  }
  /// The bytes that were written.
  [[nodiscard]] const std::vector<std::byte>& bytes() const noexcept { return bytes_; }

 private:
  template <class V>
  void exchange(V& value) {
    if constexpr (requires { value.exchange_state(*this); })
      value.exchange_state(*this);
    else
      raw(&value, sizeof(V));
    static_assert(requires { value.exchange_state(*this); } || std::is_trivially_copyable_v<V>);
  }
  template <class V>
  void exchange(std::vector<V>& values) {
    std::uint64_t size = values.size();
    raw(&size, sizeof size);
    if constexpr (std::is_trivially_copyable_v<V>)
      raw(values.data(), size * sizeof(V));
    else
      for (V& value : values) exchange(value);
  }
  template <class V>
  void exchange(std::optional<V>& value) {
    bool is_there = value.has_value();
    raw(&is_there, sizeof is_there);
    if (is_there) exchange(*value);
  }
  template <class V, std::size_t count>
  void exchange(std::array<V, count>& values) {
    for (V& value : values) exchange(value);
  }
  template <class K, class V>
  void exchange(std::map<K, V>& values) {
    std::uint64_t size = values.size();
    raw(&size, sizeof size);
    for (auto& [key, value] : values) {
      K copy = key;
      raw(&copy, sizeof copy);
      exchange(value);
    }
  }
  void exchange(std::string& text) {
    std::uint64_t size = text.size();
    raw(&size, sizeof size);
    raw(text.data(), text.size());
  }
  void raw(const void* data, std::size_t size) {
    const auto* first = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), first, first + size);
  }

  std::vector<std::byte> bytes_;
};

/// Reads the state of objects from bytes. Bytes that end too early set `is_broken`.
class StateReader {
 public:
  /// It reads.
  static constexpr bool is_reading = true;

  /// Reads these bytes, which must outlive it.
  explicit StateReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class... Values>
  GMIS_RARE void operator()(Values&... values) {
    (exchange(values), ...);
  }
  /// True when the bytes ended early or made no sense; what was read is then worth nothing.
  [[nodiscard]] bool is_broken() const noexcept { return is_broken_; }
  /// True when every byte has been read.
  [[nodiscard]] bool is_at_end() const noexcept { return bytes_.empty(); }
  /// The bytes that have not been read.
  [[nodiscard]] std::span<const std::byte> left() const noexcept { return bytes_; }

 private:
  template <class V>
  void exchange(V& value) {
    if constexpr (requires { value.exchange_state(*this); })
      value.exchange_state(*this);
    else
      raw(&value, sizeof(V));
  }
  template <class V>
  void exchange(std::vector<V>& values) {
    const std::uint64_t size = count();
    // Each element takes at least a byte: a size that lies asks for no memory.
    if (is_broken_ || size > bytes_.size()) {
      is_broken_ = true;
      return;
    }
    values.resize(size);
    if constexpr (std::is_trivially_copyable_v<V>)
      raw(values.data(), size * sizeof(V));
    else
      for (V& value : values) exchange(value);
  }
  template <class V>
  void exchange(std::optional<V>& value) {
    bool is_there = false;
    raw(&is_there, sizeof is_there);
    if (!is_there)
      value.reset();
    else
      exchange(value.emplace());
  }
  template <class V, std::size_t count>
  void exchange(std::array<V, count>& values) {
    for (V& value : values) exchange(value);
  }
  template <class K, class V>
  void exchange(std::map<K, V>& values) {
    values.clear();
    for (std::uint64_t left = count(); left > 0 && !is_broken_; --left) {
      K key{};
      raw(&key, sizeof key);
      exchange(values[key]);
    }
  }
  void exchange(std::string& text) {
    const std::uint64_t size = count();
    if (is_broken_ || size > bytes_.size()) {
      is_broken_ = true;
      return;
    }
    text.resize(size);
    raw(text.data(), text.size());
  }
  [[nodiscard]] std::uint64_t count() {
    std::uint64_t size = 0;
    raw(&size, sizeof size);
    return size;
  }
  void raw(void* data, std::size_t size) {
    if (is_broken_ || size > bytes_.size()) {
      is_broken_ = true;
      return;
    }
    if (size > 0) std::memcpy(data, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }

  std::span<const std::byte> bytes_;
  bool is_broken_ = false;
};

/// FNV-1a over the bytes, 64 bits: tells a damaged file from a whole one.
[[nodiscard]] inline std::uint64_t digest_of(std::span<const std::byte> bytes) noexcept {
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (const std::byte byte : bytes) hash = (hash ^ static_cast<std::uint64_t>(byte)) * 0x100000001B3ULL;
  return hash;
}

}  // namespace gmis
