#include <cmath>
#include <cstdint>
#include <cstdio>
#include <initializer_list>
#include <limits>
#include <span>

#include "gmis/mis/moments.hpp"
#include "gmis/result/batch_means.hpp"
#include "gmis/result/film.hpp"
#include "support/catch.hpp"

// Streams of up to 1e9 samples through everything that adds samples up. The means are sums of few
// different values, known exactly.

namespace {

/// A value, and another in its place every `period` samples.
struct Stream {
  const char* name;
  float usual, rare;
  std::uint64_t period;

  [[nodiscard]] float at(std::uint64_t i) const { return (i + 1) % period == 0 ? rare : usual; }
  [[nodiscard]] long double mean(std::uint64_t count) const {
    const auto n = static_cast<long double>(count), rares = static_cast<long double>(count / period);
    return (rares * static_cast<long double>(rare) + (n - rares) * static_cast<long double>(usual)) / n;
  }
};

void check(const Stream& stream, std::uint64_t count, double variance_bound, bool is_reported) {
  gmis::Film<float> film({1, 1});
  gmis::BatchMeans<float> batches({1, 1});
  gmis::Moments<double> moments;
  for (std::uint64_t i = 0; i < count; ++i) {
    const float value = stream.at(i);
    film.add_iteration(std::span(&value, 1));
    batches.add_iteration(std::span(&value, 1));
    moments.add(static_cast<double>(value));
  }
  const long double mean = stream.mean(count);
  const auto error = [](double value, long double truth) {
    return static_cast<double>(std::abs(static_cast<long double>(value) / truth - 1.0L));
  };
  const double of_film = error(film.mean(0, 0), mean), of_moments = error(moments.mean(), mean);
  double of_complete_batches = 0.0;
  for (std::size_t b = 0; b < batches.batch_count(); ++b)
    of_complete_batches += static_cast<double>(batches.value(b, 0)) / static_cast<double>(batches.batch_count());
  const double of_batches = error(of_complete_batches, stream.mean(batches.batch_count() * batches.iterations_of(0)));
  CAPTURE(stream.name, count, of_film, of_moments, of_batches);
  // Each sample may cost a mean in double half its last place, which adds up to 1e-7 after 1e9 of
  // them; it is less.
  CHECK(of_film < (stream.usual == stream.rare ? 1e-15 : 1.2e-16 * static_cast<double>(count)));
  CHECK(of_moments < 1e-13);
  CHECK(of_batches < 1e-7);  // each batch is a float, rounded once whenever it is joined

  // The variance, too: p (1 − p) (rare − usual)².
  const long double share = static_cast<long double>(count / stream.period) / static_cast<long double>(count);
  const long double difference = static_cast<long double>(stream.rare) - static_cast<long double>(stream.usual);
  const long double variance = share * (1.0L - share) * difference * difference;
  const double of_variance =
      variance > 0.0L ? error(film.variance_of_mean(0, 0) * (static_cast<double>(count) - 1.0), variance) : 0.0;
  CAPTURE(of_variance);
  CHECK(of_variance < variance_bound);
  if (stream.usual == stream.rare) CHECK(film.variance_of_mean(0, 0) == 0.0);
  if (is_reported)
    std::printf("%s, %llu samples: film %.2g, its variance %.2g, moments %.2g, batches %.2g\n", stream.name,
                static_cast<unsigned long long>(count), of_film, of_variance, of_moments, of_batches);
}

constexpr Stream streams[] = {{"constant", 0.1F, 0.1F, 2},
                              {"two values", 0.1F, 1e4F, 2},
                              {"a firefly in 100,000", 0.1F, 1e6F, 100000},
                              {"small beside a large mean", 1e6F, 1e6F + 1.0F, 3}};

}  // namespace

TEST_CASE("hostile: streams of two million samples", "[hostile]") {
  for (const Stream& stream : streams) check(stream, 2'000'000, 1e-10, false);
}

TEST_CASE("hostile: variances of numbers whose squares are too large", "[hostile]") {
  const auto moments_of = [](std::initializer_list<double> values, int rounds) {
    gmis::Moments<double> moments;
    for (int i = 0; i < rounds; ++i)
      for (const double value : values) moments.add(value);
    return moments;
  };
  for (const int rounds : {1, 2, 1000}) {  // less than a block, and several
    CAPTURE(rounds);
    CHECK(moments_of({1e300, 1e300}, rounds).mean() == 1e300);
    CHECK(moments_of({1e300, 1e300}, rounds).variance() == 0.0);
    CHECK(moments_of({1e300, 0.0}, rounds).mean() == Approx(5e299));
    CHECK(moments_of({1e300, 0.0}, rounds).variance() == std::numeric_limits<double>::infinity());
  }
  gmis::Moments<double> both = moments_of({1e300, 1e300}, 500);
  both.merge(moments_of({-1e300, -1e300}, 500));
  CHECK(std::abs(both.mean()) <= 1e285);
  CHECK(both.variance() == std::numeric_limits<double>::infinity());
}

TEST_CASE("hostile: streams of 1e9 samples", "[.][slow]") {
  for (const Stream& stream : streams) check(stream, 1'000'000'000, 1e-5, true);
}
