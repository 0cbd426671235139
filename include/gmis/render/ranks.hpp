#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>

namespace gmis {

/// Processes that render one picture together. Each calls the same functions in the same order;
/// sizes are in bytes, and all that take part know them.
///
/// - `rank()`: of this process, from 0; `count()`: of the processes.
/// - `exchange(send, send_sizes, receive, receive_sizes)`: `send` holds one part for each rank in
///   their order; afterwards `receive` holds the parts that all ranks had for this one.
/// - `gather(send, receive, receive_sizes)`: afterwards `receive` holds at rank 0 what all ranks
///   have sent, in their order; elsewhere `receive` and its sizes are empty.
/// - `broadcast(bytes)`: afterwards all have the bytes of rank 0.
///
/// A process that cannot reach the others does not return from these functions.
template <class R>
concept Ranks = requires(R& ranks, std::span<const std::byte> send, std::span<std::byte> receive,
                         std::span<const std::size_t> sizes) {
  { ranks.rank() } -> std::convertible_to<int>;
  { ranks.count() } -> std::convertible_to<int>;
  ranks.exchange(send, sizes, receive, sizes);
  ranks.gather(send, receive, sizes);
  ranks.broadcast(receive);
};

/// A process that renders alone.
struct SingleRank {
  /// Its number.
  [[nodiscard]] static constexpr int rank() noexcept { return 0; }
  /// The number of ranks.
  [[nodiscard]] static constexpr int count() noexcept { return 1; }
  /// Copies `send` to `receive`.
  static void exchange(std::span<const std::byte> send, std::span<const std::size_t>, std::span<std::byte> receive,
                       std::span<const std::size_t>) {
    std::copy(send.begin(), send.end(), receive.begin());
  }
  /// Copies `send` to `receive`.
  static void gather(std::span<const std::byte> send, std::span<std::byte> receive, std::span<const std::size_t>) {
    std::copy(send.begin(), send.end(), receive.begin());
  }
  /// Leaves the bytes as they are.
  static constexpr void broadcast(std::span<std::byte>) noexcept {}
};

/// A reference to ranks of any type, so that code which renders over them need not be a template of
/// that type. The ranks must outlive the reference.
class RanksRef {
 public:
  /// A process that renders alone.
  RanksRef() noexcept : RanksRef(alone_) {}
  /// Refers to `ranks`, which must outlive this.
  template <class R>
  requires(!std::same_as<std::remove_const_t<R>, RanksRef> && Ranks<R>) RanksRef(R& ranks)
  noexcept
      : ranks_(std::addressof(ranks)),
        rank_(ranks.rank()),
        count_(ranks.count()),
        exchange_([](void* of, std::span<const std::byte> send, std::span<const std::size_t> send_sizes,
                     std::span<std::byte> receive, std::span<const std::size_t> receive_sizes) {
          static_cast<R*>(of)->exchange(send, send_sizes, receive, receive_sizes);
        }),
        gather_([](void* of, std::span<const std::byte> send, std::span<std::byte> receive,
                   std::span<const std::size_t> sizes) { static_cast<R*>(of)->gather(send, receive, sizes); }),
        broadcast_([](void* of, std::span<std::byte> bytes) { static_cast<R*>(of)->broadcast(bytes); }) {}

  /// Rank of this process.
  [[nodiscard]] int rank() const noexcept { return rank_; }
  /// Number of processes.
  [[nodiscard]] int count() const noexcept { return count_; }
  /// True for the rank that decides, and has the whole picture.
  [[nodiscard]] bool is_first() const noexcept { return rank_ == 0; }

  /// Exchanges a part with each rank, as in `Ranks`.
  void exchange(std::span<const std::byte> send, std::span<const std::size_t> send_sizes, std::span<std::byte> receive,
                std::span<const std::size_t> receive_sizes) const {
    exchange_(ranks_, send, send_sizes, receive, receive_sizes);
  }
  /// Gathers bytes at rank 0, as in `Ranks`.
  void gather(std::span<const std::byte> send, std::span<std::byte> receive, std::span<const std::size_t> sizes) const {
    gather_(ranks_, send, receive, sizes);
  }
  /// The value of rank 0, on all ranks.
  template <class V>
  requires std::is_trivially_copyable_v<V>
  [[nodiscard]] V of_first(V value) const {
    broadcast(std::as_writable_bytes(std::span(&value, 1)));
    return value;
  }
  /// Gives all ranks the bytes of rank 0.
  void broadcast(std::span<std::byte> bytes) const {
    if (count_ > 1) broadcast_(ranks_, bytes);
  }

 private:
  static inline SingleRank alone_;

  void* ranks_;
  int rank_, count_;
  void (*exchange_)(void*, std::span<const std::byte>, std::span<const std::size_t>, std::span<std::byte>,
                    std::span<const std::size_t>);
  void (*gather_)(void*, std::span<const std::byte>, std::span<std::byte>, std::span<const std::size_t>);
  void (*broadcast_)(void*, std::span<std::byte>);
};

}  // namespace gmis
