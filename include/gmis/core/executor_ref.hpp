#pragma once

#include <atomic>
#include <concepts>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/concepts.hpp"

namespace gmis {

/// An executor that can be told to begin no further work. `stop_when(flag)`: from now on, or never
/// again for a null pointer, work that has not begun is left out while `*flag` is true.
/// `is_stopped()`: whether work is being left out.
template <class E>
concept StoppableExecutor = Executor<E> && requires(E& executor, const std::atomic<bool>* flag) {
  executor.stop_when(flag);
  { executor.is_stopped() } -> std::convertible_to<bool>;
};

/// A reference to an executor of any type, so that code which runs work need not be a template of
/// that type. One call by pointer for each part of the work. The executor must outlive the
/// reference. Models `StoppableExecutor`; an executor that cannot be stopped is never stopped.
class ExecutorRef {
 public:
  /// Refers to `executor`, which must outlive this.
  template <class E>
  requires(!std::same_as<std::remove_const_t<E>, ExecutorRef> && Executor<E>) ExecutorRef(E& executor)
  noexcept
      : executor_(std::addressof(executor)),
        run_([](const void* of, std::size_t count, void* work, void (*call)(void*, std::size_t)) {
          executor_of<E>(of).parallel_for(count, [work, call](std::size_t i) { call(work, i); });
        }) {
    if constexpr (StoppableExecutor<E>) {
      stop_when_ = [](const void* of, const std::atomic<bool>* flag) { executor_of<E>(of).stop_when(flag); };
      is_stopped_ = [](const void* of) { return static_cast<bool>(executor_of<E>(of).is_stopped()); };
    }
  }

  /// Calls `work(i)` for each i from 0 to `count` − 1, as the executor does.
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) const {
    using W = std::remove_reference_t<Work>;
    run_(executor_, count, const_cast<std::remove_const_t<W>*>(std::addressof(work)),
         [](void* of, std::size_t i) { (*static_cast<W*>(of))(i); });
  }
  /// Calls `work(i)` for each i even when the executor is stopped meanwhile: calls that it leaves
  /// out run on the calling thread.
  template <class Work>
  void parallel_for_all(std::size_t count, Work&& work) const {
    using W = std::remove_reference_t<Work>;
    run_all(count, const_cast<std::remove_const_t<W>*>(std::addressof(work)),
            [](void* of, std::size_t i) { (*static_cast<W*>(of))(i); });
  }
  /// Leaves out work that has not begun while `*flag` is true; a null pointer ends this. It does
  /// nothing when the executor is no `StoppableExecutor`.
  void stop_when(const std::atomic<bool>* flag) const {
    if (stop_when_ != nullptr) stop_when_(executor_, flag);
  }
  /// True while work is being left out; false when the executor is no `StoppableExecutor`.
  [[nodiscard]] bool is_stopped() const { return is_stopped_ != nullptr && is_stopped_(executor_); }

 private:
  GMIS_RARE void run_all(std::size_t count, void* work, void (*call)(void*, std::size_t)) const {
    std::vector<char> is_done(count, 0);
    parallel_for(count, [&](std::size_t i) {
      call(work, i);
      is_done[i] = 1;
    });
    for (std::size_t i = 0; i < count; ++i)
      if (is_done[i] == 0) call(work, i);
  }
  template <class E>
  static E& executor_of(const void* executor) noexcept {
    return *const_cast<E*>(static_cast<const E*>(executor));
  }

  const void* executor_;
  void (*run_)(const void*, std::size_t, void*, void (*)(void*, std::size_t));
  void (*stop_when_)(const void*, const std::atomic<bool>*) = nullptr;
  bool (*is_stopped_)(const void*) = nullptr;
};

}  // namespace gmis
