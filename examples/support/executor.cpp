#include "support/executor.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

#if GMIS_HAS_TBB
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace gmis::tools {

#if GMIS_HAS_TBB
const bool ThreadedExecutor::has_threads = true;
struct ThreadedExecutor::Arena {
  explicit Arena(int threads) : tasks(threads) {}
  oneapi::tbb::task_arena tasks;
};
#else
const bool ThreadedExecutor::has_threads = false;
struct ThreadedExecutor::Arena {
  explicit Arena(int) {}
};
#endif

struct ThreadedExecutor::Reporter {
  explicit Reporter(std::function<void(std::size_t)> receiver) : report(std::move(receiver)) {}

  /// A thread does not wait while another one reports: its piece is counted in the next report.
  void add_one() {
    const std::size_t number = ++done;
    if (const std::unique_lock lock(reporting, std::try_to_lock); lock.owns_lock()) report(number);
  }

  std::function<void(std::size_t)> report;
  std::atomic<std::size_t> done{0};
  std::mutex reporting;
};

namespace {

/// oneTBB starts no more threads than there are processors, and warns of a request for many more.
int thread_count_for(int threads) {
#if GMIS_HAS_TBB
  const int all = std::max(1, oneapi::tbb::info::default_concurrency());
  return threads > 0 ? std::min(threads, all) : all;
#else
  (void)threads;
  return 1;
#endif
}

}  // namespace

ThreadedExecutor::ThreadedExecutor(int threads, const std::atomic<bool>* stop)
    : thread_count_(thread_count_for(threads)), stop_(stop), arena_(std::make_unique<Arena>(thread_count_)) {}

ThreadedExecutor::~ThreadedExecutor() = default;

void ThreadedExecutor::report_to(std::function<void(std::size_t)> report) {
  reporter_ = report ? std::make_unique<Reporter>(std::move(report)) : nullptr;
}

void ThreadedExecutor::run(std::size_t count, void (*work)(void*, std::size_t), void* closure) {
  const auto unless_stopped = [&](std::size_t i) {
    if (is_stopped()) return;
    work(closure, i);
    if (reporter_) reporter_->add_one();
  };
#if GMIS_HAS_TBB
  if (thread_count_ > 1) {
    arena_->tasks.execute([&] { oneapi::tbb::parallel_for(std::size_t{0}, count, unless_stopped); });
    return;
  }
#endif
  for (std::size_t i = 0; i < count; ++i) unless_stopped(i);
}

}  // namespace gmis::tools
