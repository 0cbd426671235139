#include "gmis/render/thread_executor.hpp"

#include <numeric>
#include <stdexcept>
#include <vector>

#include "support/catch.hpp"

static_assert(gmis::Executor<gmis::ThreadExecutor>);

TEST_CASE("every index is run once, whatever the numbers of threads and of indices") {
  for (const int threads : {1, 2, 3, 8}) {
    gmis::ThreadExecutor executor(threads);
    CHECK(executor.thread_count() == threads);
    // The same pool serves many loops, one after the other.
    for (const std::size_t count : {0U, 1U, 2U, 7U, 64U, 1000U, 3U}) {
      std::vector<std::atomic<int>> runs(count);
      executor.parallel_for(count, [&](std::size_t i) { ++runs[i]; });
      for (std::size_t i = 0; i < count; ++i) REQUIRE(runs[i] == 1);
    }
  }
  CHECK(gmis::ThreadExecutor(0).thread_count() >= 1);
  CHECK(gmis::ThreadExecutor(-3).thread_count() >= 1);
}

TEST_CASE("what work wrote is seen after the loop, without locks of its own") {
  gmis::ThreadExecutor executor(4);
  std::vector<int> values(10'000);
  for (int round = 0; round < 50; ++round) {
    executor.parallel_for(values.size(), [&](std::size_t i) { values[i] += static_cast<int>(i); });
    const long long sum = std::accumulate(values.begin(), values.end(), 0LL);
    REQUIRE(sum == (round + 1) * (9'999LL * 10'000LL / 2));
  }
}

TEST_CASE("an exception of work reaches the caller, and the pool serves on") {
  for (const int threads : {1, 4}) {
    gmis::ThreadExecutor executor(threads);
    std::atomic<int> runs{0};
    CHECK_THROWS_AS(executor.parallel_for(1'000'000,
                                          [&](std::size_t i) {
                                            ++runs;
                                            if (i == 10) throw std::runtime_error("ten");
                                          }),
                    std::runtime_error);
    CHECK(runs < 1'000'000);
    std::atomic<int> later{0};
    executor.parallel_for(100, [&](std::size_t) { ++later; });
    CHECK(later == 100);
  }
}

TEST_CASE("no work begins after a stop, until the stop is taken back") {
  for (const int threads : {1, 3}) {
    gmis::ThreadExecutor executor(threads);
    std::atomic<bool> stop{false};
    executor.stop_when(&stop);
    CHECK_FALSE(executor.is_stopped());
    std::atomic<int> begun{0};
    executor.parallel_for(100'000, [&](std::size_t) {
      if (++begun == 10) stop = true;
    });
    CHECK(begun >= 10);
    CHECK(begun < 10 + threads);
    CHECK(executor.is_stopped());
    executor.parallel_for(10, [&](std::size_t) { ++begun; });
    CHECK(begun < 10 + threads);
    executor.stop_when(nullptr);
    executor.parallel_for(10, [&](std::size_t) { ++begun; });
    CHECK(begun >= 20);
  }
}
