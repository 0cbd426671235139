#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <utility>

#if GMIS_HAS_TBB
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace gmis::tools {

/// Runs the engine's loops on a number of threads; on one, when this build has no oneTBB. Once `stop` is set, what has
/// not begun is left out: the iteration under way is then worth nothing and must be thrown away.
class ThreadedExecutor {
 public:
  static constexpr bool has_threads = GMIS_HAS_TBB;

  /// `threads` 0 stands for all cores.
  explicit ThreadedExecutor(int threads, const std::atomic<bool>* stop = nullptr)
      : thread_count_(choose(threads)),
        stop_(stop)
#if GMIS_HAS_TBB
        ,
        arena_(thread_count_)
#endif
  {
  }

  [[nodiscard]] int thread_count() const {
    return thread_count_;
  }
  void stop_when(const std::atomic<bool>* stop) {
    stop_ = stop;
  }
  [[nodiscard]] bool is_stopped() const {
    return stop_ != nullptr && stop_->load(std::memory_order_relaxed);
  }

  template <class Work>
  void parallel_for(std::size_t count, Work&& work) {
    const auto unless_stopped = [&](std::size_t i) {
      if (!is_stopped()) work(i);
    };
#if GMIS_HAS_TBB
    if (thread_count_ > 1) {
      arena_.execute([&] { oneapi::tbb::parallel_for(std::size_t{0}, count, unless_stopped); });
      return;
    }
#endif
    for (std::size_t i = 0; i < count; ++i) unless_stopped(i);
  }

 private:
  [[nodiscard]] static int choose(int threads) {
    if (!has_threads) return 1;
    return threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  }

  int thread_count_;
  const std::atomic<bool>* stop_;
#if GMIS_HAS_TBB
  oneapi::tbb::task_arena arena_;
#endif
};

}  // namespace gmis::tools
