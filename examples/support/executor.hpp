#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <type_traits>

namespace gmis::tools {

/// Runs the engine's loops on a number of threads by oneTBB; on one, when this build has no oneTBB.
/// Once `stop` is set, no further work begins: the iteration under way is then incomplete and must
/// be discarded.
class ThreadedExecutor {
 public:
  static const bool has_threads;

  /// `threads` 0 stands for all cores; no more than that are used.
  explicit ThreadedExecutor(int threads, const std::atomic<bool>* stop = nullptr);
  ~ThreadedExecutor();
  ThreadedExecutor(const ThreadedExecutor&) = delete;
  ThreadedExecutor& operator=(const ThreadedExecutor&) = delete;

  [[nodiscard]] int thread_count() const { return thread_count_; }
  void stop_when(const std::atomic<bool>* stop) { stop_ = stop; }
  /// From now on `report` is called after pieces of work, by one of the threads that work and by no
  /// two at once, with the number of pieces done since this call. An empty function ends this. Not
  /// to be called while work is done.
  void report_to(std::function<void(std::size_t done)> report);
  [[nodiscard]] bool is_stopped() const { return stop_ != nullptr && stop_->load(std::memory_order_relaxed); }

  template <class Work>
  void parallel_for(std::size_t count, Work&& work) {
    const auto call = [](void* closure, std::size_t i) { (*static_cast<std::remove_reference_t<Work>*>(closure))(i); };
    run(count, call, const_cast<void*>(static_cast<const void*>(std::addressof(work))));
  }

 private:
  /// The arena of threads, kept out of this header: oneTBB takes long to compile.
  struct Arena;
  struct Reporter;

  void run(std::size_t count, void (*work)(void*, std::size_t), void* closure);

  int thread_count_;
  const std::atomic<bool>* stop_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<Reporter> reporter_;  ///< null: nobody asks
};

}  // namespace gmis::tools
