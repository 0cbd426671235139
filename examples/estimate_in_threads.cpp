// One estimate on several threads, with the same bits for any number of them.
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <gmis/mis.hpp>
#include <thread>
#include <vector>

struct Exponential {
  double rate;
  double sample(gmis::UniformSource auto& source) const {
    return -std::log(1.0 - gmis::uniform<double>(source)) / rate;
  }
  double pdf(double x) const { return x >= 0.0 ? rate * std::exp(-rate * x) : 0.0; }
};

auto estimate_in_threads(unsigned thread_count) {
  const std::array<Exponential, 2> proposals{{{0.5}, {2.0}}};
  const auto f = [](double x) { return x * std::exp(-x); };
  using Accumulator = gmis::AccumulatorFor<decltype(f), decltype(proposals)>;
  constexpr std::uint32_t blocks = 64;
  std::vector<Accumulator> parts(blocks);
  std::atomic<std::uint32_t> next{0};
  const auto work = [&] {
    for (std::uint32_t block = next++; block < blocks; block = next++) {
      gmis::Philox source(42, 0, block);  // the stream of this block
      Accumulator part;                   // of this thread alone, until the block is done
      gmis::add_rounds<gmis::Scheme::N3>(part, f, proposals, 2'000, source);
      parts[block] = part;
    }
  };
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < thread_count; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  Accumulator whole;
  for (const Accumulator& part : parts) whole.merge(part);  // in the order of the blocks, whoever did them
  return whole.result();
}

int main() {
  const auto alone = estimate_in_threads(1);
  const auto together = estimate_in_threads(4);
  std::printf("1 thread:  %.17g ± %.2g\n", alone.mean, alone.standard_error.value());
  std::printf("4 threads: %.17g ± %.2g\n", together.mean, together.standard_error.value());
  const bool is_right = std::abs(alone.mean - 1.0) < 6.0 * alone.standard_error.value();
  return is_right && alone.mean == together.mean && alone.variance == together.variance ? 0 : 1;
}
