#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <type_traits>
#include <vector>

#include "gmis/core/executor_ref.hpp"

namespace gmis {

/// Runs the loops of the engine on a pool of `std::thread`s. Models `Executor` and
/// `StoppableExecutor`. The threads are started by the constructor and wait between loops.
///
/// One loop runs at a time: `parallel_for` must not be called from two threads at once, nor from
/// inside `work`. When `work` throws, the calls under way are finished, the others are left out,
/// and the first exception is thrown to the caller of `parallel_for`.
///
/// This header is not part of gmis/gmis.hpp: no other header of the library starts a thread.
class ThreadExecutor {
 public:
  /// `threads`: the calling thread included; 0 stands for all cores. Where the system refuses a
  /// thread, the pool is smaller.
  explicit ThreadExecutor(int threads = 0) {
    const int wanted = threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    threads_.reserve(static_cast<std::size_t>(wanted - 1));
#if defined(__cpp_exceptions)
    try {
      start(wanted - 1);
    } catch (const std::system_error&) {
    }
#else
    start(wanted - 1);
#endif
  }
  ThreadExecutor(const ThreadExecutor&) = delete;
  ThreadExecutor& operator=(const ThreadExecutor&) = delete;
  ~ThreadExecutor() {
    {
      const std::lock_guard lock(mutex_);
      is_ending_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  /// Threads that run a loop, the calling one included.
  [[nodiscard]] int thread_count() const noexcept {
    return static_cast<int>(threads_.size()) + 1;
  }

  /// From now on, no further call of `work` begins while `*stop` is true. A null pointer ends this.
  void stop_when(const std::atomic<bool>* stop) noexcept {
    stop_ = stop;
  }
  /// True while the flag of `stop_when` is set.
  [[nodiscard]] bool is_stopped() const noexcept {
    return stop_ != nullptr && stop_->load(std::memory_order_relaxed);
  }

  /// Calls `work(i)` once for each i from 0 to `count` − 1 and returns when all calls are done.
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) {
    Loop loop;
    loop.count = count;
    loop.work = std::addressof(work);
    loop.call = [](const void* closure, std::size_t i) {
      (*static_cast<std::remove_reference_t<Work>*>(const_cast<void*>(closure)))(i);
    };
    if (count > 1 && !threads_.empty()) {
      {
        const std::lock_guard lock(mutex_);
        loop_ = &loop;
        busy_ = threads_.size();
        ++loop_number_;
      }
      wake_.notify_all();
      take_part(loop);
      std::unique_lock lock(mutex_);
      done_.wait(lock, [this] { return busy_ == 0; });
    } else {
      take_part(loop);
    }
    if (loop.failure) std::rethrow_exception(loop.failure);
  }

 private:
  struct Loop {
    std::size_t count = 0;
    const void* work = nullptr;
    void (*call)(const void* closure, std::size_t i) = nullptr;
    std::atomic<std::size_t> next{0};
    std::mutex failing;
    std::exception_ptr failure;
  };

  void start(int count) {
    for (int t = 0; t < count; ++t) threads_.emplace_back([this] { serve(); });
  }

  /// Runs indices of the loop until none is left.
  void take_part(Loop& loop) {
    for (std::size_t i = loop.next++; i < loop.count; i = loop.next++) {
      if (is_stopped()) continue;
#if defined(__cpp_exceptions)
      try {
        loop.call(loop.work, i);
      } catch (...) {
        const std::lock_guard lock(loop.failing);
        if (!loop.failure) loop.failure = std::current_exception();
        loop.next = loop.count;
      }
#else
      loop.call(loop.work, i);
#endif
    }
  }

  /// The loop of a thread of the pool.
  void serve() {
    std::uint64_t served = 0;
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [&] { return is_ending_ || loop_number_ != served; });
      if (is_ending_) return;
      served = loop_number_;
      Loop& loop = *loop_;
      lock.unlock();
      take_part(loop);
      lock.lock();
      if (--busy_ == 0) done_.notify_one();
    }
  }

  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  Loop* loop_ = nullptr;           // guarded by mutex_, as are the next three
  std::uint64_t loop_number_ = 0;  // of loops so far
  std::size_t busy_ = 0;           // threads of the pool that have not left the loop
  bool is_ending_ = false;
  const std::atomic<bool>* stop_ = nullptr;  // written between loops only
};

static_assert(StoppableExecutor<ThreadExecutor>);

}  // namespace gmis
