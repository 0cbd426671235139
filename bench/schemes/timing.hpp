#pragma once

#include <functional>
#include <string>
#include <vector>

namespace bench {

/// A loop to be timed: called with a number of repetitions of its body, returns something that depends on all of them.
struct Timed {
  std::string name;
  std::function<double(long)> run;
};

/// Nanoseconds of CPU time that one repetition of each takes: the least of `slices` slices of `slice_seconds`, the slices of
/// all of them interleaved in random order so that a noisy machine is fair to each. By Google Benchmark.
[[nodiscard]] std::vector<double> nanoseconds_of(const std::vector<Timed>& bodies, int slices, double slice_seconds);

}  // namespace bench
