#include "timing.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <limits>

namespace bench {
namespace {

/// Keeps the least time of each benchmark, prints nothing.
class Least : public benchmark::BenchmarkReporter {
 public:
  explicit Least(const std::vector<Timed>& bodies)
      : bodies_(bodies), nanoseconds_(bodies.size(), std::numeric_limits<double>::infinity()) {}
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      for (std::size_t i = 0; i < bodies_.size(); ++i)
        if (run.run_name.function_name == bodies_[i].name)
          nanoseconds_[i] = std::min(nanoseconds_[i], run.GetAdjustedCPUTime());
    }
  }
  [[nodiscard]] const std::vector<double>& nanoseconds() const { return nanoseconds_; }

 private:
  const std::vector<Timed>& bodies_;
  std::vector<double> nanoseconds_;
};

}  // namespace

std::vector<double> nanoseconds_of(const std::vector<Timed>& bodies, int slices, double slice_seconds) {
  static const bool initialised = [] {
    std::string program = "schemes", interleave = "--benchmark_enable_random_interleaving=true";
    char* arguments[] = {program.data(), interleave.data(), nullptr};
    int count = 2;
    benchmark::Initialize(&count, arguments);
    return true;
  }();
  static_cast<void>(initialised);

  benchmark::ClearRegisteredBenchmarks();
  for (const Timed& body : bodies)
    benchmark::RegisterBenchmark(
        body.name.c_str(),
        [&body](benchmark::State& state) {
          // One call for all repetitions: no call through a pointer is in the time of one.
          while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(state.max_iterations)))
            benchmark::DoNotOptimize(body.run(static_cast<long>(state.max_iterations)));
        })
        ->Unit(benchmark::kNanosecond)
        ->Repetitions(slices)
        ->MinTime(slice_seconds);
  Least least(bodies);
  benchmark::RunSpecifiedBenchmarks(&least);
  benchmark::ClearRegisteredBenchmarks();
  return least.nanoseconds();
}

}  // namespace bench
