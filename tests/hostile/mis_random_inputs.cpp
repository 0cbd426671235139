#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "gmis/mis.hpp"
#include "hostile/denominator_oracle.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// Weights for random hard inputs: densities all over the range of their type or near one place in
// it, some of them zero, all fifteen pairs, and the heuristics; against long double. A few in each
// run, 1e8 of each type in the slow test.

namespace {

using Wide = long double;
using gmis::Scheme;

/// `count` proposals; the density of proposal k at x is the table's entry x + 67 k, so that every x
/// is an input of its own.
template <class T>
struct TableSet {
  using Value = std::uint32_t;
  using Density = T;
  static constexpr std::uint32_t entries = 4096;
  std::array<T, entries> table;
  std::size_t count = 1;

  [[nodiscard]] std::size_t size() const { return count; }
  [[nodiscard]] T pdf(std::size_t k, std::uint32_t x) const {
    return table[(x + 67U * static_cast<std::uint32_t>(k)) % entries];
  }
  /// Any x where proposal k has a density: the samples of a proposal with a density of zero are its
  /// own fault.
  [[nodiscard]] std::uint32_t sample(std::size_t k, gmis::UniformSource auto& source) const {
    auto x = static_cast<std::uint32_t>(source()) % entries;
    while (!(pdf(k, x) > T(0))) x = (x + 1) % entries;
    return x;
  }
};

/// The same densities by their logarithms.
template <class T>
struct LogTableSet {
  using Value = std::uint32_t;
  using Density = T;
  TableSet<T> logarithms;

  [[nodiscard]] std::size_t size() const { return logarithms.size(); }
  [[nodiscard]] T log_pdf(std::size_t k, std::uint32_t x) const { return logarithms.pdf(k, x); }
  [[nodiscard]] std::uint32_t sample(std::size_t k, gmis::UniformSource auto& source) const {
    auto x = static_cast<std::uint32_t>(source()) % TableSet<T>::entries;
    while (!(log_pdf(k, x) > -std::numeric_limits<T>::infinity())) x = (x + 1) % TableSet<T>::entries;
    return x;
  }
};

struct Tally {
  std::uint64_t weights = 0;
  std::uint64_t non_finite = 0;
  double worst = 0.0;

  void add(Wide value, Wide expected) {
    ++weights;
    const auto error = static_cast<double>(std::abs(value / expected - 1.0L));
    if (!std::isfinite(error))  // a maximum would lose it
      ++non_finite;
    else
      worst = std::max(worst, error);
  }
  void report(const char* what) const {
    std::printf("%s: %llu weights, worst relative error %.2g, %llu not finite\n", what,
                static_cast<unsigned long long>(weights), worst, static_cast<unsigned long long>(non_finite));
  }
};

/// One round of one pair over `set`; `exact(k, x)` is a density relative to anything, and `read(φ)`
/// relative to the same.
template <class Set, class Exact, class Read>
void check_round(const Set& set, gmis::Selection selection, gmis::Weighting weighting, gmis::Philox& source,
                 Tally& tally, Exact exact, Read read) {
  static thread_local gmis::Workspace<typename Set::Density, gmis::dynamic_capacity> workspace;
  static thread_local std::vector<std::size_t> drawn;
  static thread_local std::vector<std::uint32_t> points;
  static thread_local std::vector<Wide> denominators;
  drawn.clear();
  points.clear();
  denominators.clear();
  dispatch(selection, weighting, [&](auto s, auto w) {
    gmis::sample_round<decltype(s)::value, decltype(w)::value>(set, gmis::EqualAllocation{}, source, workspace,
                                                               [&](std::uint32_t x, auto phi, std::size_t index) {
                                                                 drawn.push_back(index);
                                                                 points.push_back(x);
                                                                 denominators.push_back(read(phi));
                                                               });
  });
  if (drawn.size() != set.size()) {  // a sample that was not visited had a weight that is not finite
    tally.non_finite += set.size() - drawn.size();
    return;
  }
  for (std::size_t n = 0; n < drawn.size(); ++n)
    tally.add(denominators[n], hostile::denominator(gmis::scheme_of(selection, weighting), set.size(), drawn, n,
                                                    [&](std::size_t k) { return exact(k, points[n]); }));
}

/// Few, so that also a short run sees many tables.
constexpr int rounds_per_table = 4;

/// `check_round`, for all pairs of a selection and a weighting.
template <class Set, class Exact, class Read>
void check_rounds(const Set& set, gmis::Philox& source, Tally& tally, const Exact& exact, const Read& read) {
  for (int round = 0; round < rounds_per_table; ++round)
    for (const auto selection : gmis::all_selections)
      for (const auto weighting : gmis::all_weightings)
        check_round(set, selection, weighting, source, tally, exact, read);
}

/// Powers of ten within which densities are drawn: to the ends of the range of T as far as the sum
/// of `count` densities and the share of one of them in the mean allow. (docs/numerics.md says what
/// happens beyond.)
template <class T>
struct Range {
  double low, high;
  Range(std::size_t count, bool has_zeros) {
    const double n = std::log10(static_cast<double>(count));
    if (sizeof(T) == 4) {
      low = has_zeros ? -37.9 + n : -38.0;
      high = std::min(38.0, 38.5 - n);
    } else {
      low = -300.0;
      high = 300.0;
    }
  }
};

/// Exponents of one table: all over the range, or near one place in it; or all alike.
template <class T>
struct Exponents {
  std::mt19937_64& source;
  Range<T> range;
  double centre, spread;

  Exponents(std::mt19937_64& random, Range<T> in) : source(random), range(in) {
    std::uniform_real_distribution<double> place(range.low, range.high);
    centre = place(source);
    const std::array<double, 5> spreads{0.0, 0.3, 3.0, 30.0, range.high - range.low};
    spread = spreads[source() % spreads.size()];
  }
  double operator()() {
    std::uniform_real_distribution<double> near(-spread, spread);
    return std::clamp(centre + near(source), range.low, range.high);
  }
};

template <class T>
std::size_t random_count(std::mt19937_64& source) {
  return source() % 8 == 0 ? 9 + source() % 56 : 1 + source() % 8;
}

template <class T>
Tally denominators(std::uint64_t weights, std::uint64_t seed) {
  Tally tally;
  std::mt19937_64 random(gmis_test::seed(seed));
  gmis::Philox source(random());
  TableSet<T> set;
  while (tally.weights + tally.non_finite < weights) {
    set.count = random_count<T>(random);
    const bool has_zeros = random() % 3 == 0;
    Exponents<T> exponents(random, Range<T>(set.count, has_zeros));
    for (T& density : set.table)
      density = has_zeros && random() % 4 != 0 ? T(0) : static_cast<T>(std::pow(10.0L, static_cast<Wide>(exponents())));
    set.table[0] = static_cast<T>(std::pow(10.0L, static_cast<Wide>(exponents())));  // never zero alone
    check_rounds(
        set, source, tally, [&](std::size_t k, std::uint32_t x) { return static_cast<Wide>(set.pdf(k, x)); },
        [](T phi) { return static_cast<Wide>(phi); });
  }
  return tally;
}

template <class T>
Tally log_denominators(std::uint64_t weights, std::uint64_t seed) {
  Tally tally;
  std::mt19937_64 random(gmis_test::seed(seed));
  gmis::Philox source(random());
  LogTableSet<T> set;
  std::array<Wide, TableSet<T>::entries> exact;
  while (tally.weights + tally.non_finite < weights) {
    set.logarithms.count = random_count<T>(random);
    const bool has_zeros = random() % 3 == 0;
    Range<T> range(1, false);
    if (sizeof(T) == 4) range.high = 38.0;
    Exponents<T> exponents(random, range);
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const bool is_zero = i > 0 && has_zeros && random() % 4 != 0;
      const double log = is_zero ? -std::numeric_limits<double>::infinity() : exponents() * std::log(10.0);
      set.logarithms.table[i] = static_cast<T>(log);
      exact[i] = std::exp(static_cast<Wide>(set.logarithms.table[i]));
    }
    check_rounds(
        set, source, tally,
        [&](std::size_t k, std::uint32_t x) {
          return exact[(x + 67U * static_cast<std::uint32_t>(k)) % TableSet<T>::entries];
        },
        [](gmis::LogDensity<T> phi) { return std::exp(static_cast<Wide>(phi.log)); });
  }
  return tally;
}

/// Balance and power weights with counts; those too small for T are compared in absolute terms.
template <class T>
Tally heuristics(std::uint64_t weights, std::uint64_t seed) {
  Tally tally;
  std::mt19937_64 random(gmis_test::seed(seed));
  std::vector<T> densities, result;
  std::vector<std::uint32_t> counts;
  std::vector<Wide> exact;
  while (tally.weights + tally.non_finite < weights) {
    const std::size_t n = random() % 200 == 0 ? 4096 : random_count<T>(random);
    Range<T> range(1, false);
    Exponents<T> exponents(random, range);
    densities.resize(n);
    result.resize(n);
    counts.resize(n);
    exact.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      densities[i] = random() % 8 == 0 ? T(0) : static_cast<T>(std::pow(10.0, exponents()));
      counts[i] = static_cast<std::uint32_t>(random() % 5);
    }
    for (const bool is_power : {false, true}) {
      const std::span<const T> in(densities);
      const std::span<T> out(result);
      if (is_power)
        gmis::heuristic_weights(gmis::Power{}, counts, in, out);
      else
        gmis::heuristic_weights(gmis::Balance{}, counts, in, out);
      Wide sum = 0.0L;
      for (std::size_t i = 0; i < n; ++i) {
        const Wide d = static_cast<Wide>(counts[i]) * static_cast<Wide>(densities[i]);
        sum += exact[i] = is_power ? d * d : d;
      }
      for (std::size_t i = 0; i < n; ++i) {
        const Wide expected = sum > 0.0L ? exact[i] / sum : 0.0L;
        if (expected > static_cast<Wide>(std::numeric_limits<T>::min()) * 1e6L)
          tally.add(static_cast<Wide>(result[i]), expected);
        else
          tally.add(1.0L + static_cast<Wide>(result[i]), 1.0L + expected);
      }
    }
  }
  return tally;
}

template <class T>
void check(const char* name, std::uint64_t weights, double tolerance) {
  const auto judge = [&](const char* what, const Tally& tally) {
    CAPTURE(name, what, tally.weights, tally.worst);
    CHECK(tally.non_finite == 0);
    CHECK(tally.worst <= tolerance);
    if (weights > 1'000'000) tally.report((std::string(name) + ", " + what).c_str());
  };
  judge("denominators", denominators<T>(weights, 21));
  judge("denominators by logarithms", log_denominators<T>(weights / 10, 22));
  judge("heuristics", heuristics<T>(weights / 10, 23));
}

/// A density near the end of float's range, and the same by its logarithm.
struct Plain {
  float density;
  int sample(gmis::UniformSource auto&) const { return 0; }
  float pdf(int) const { return density; }
};
struct Logarithm {
  float density;
  int sample(gmis::UniformSource auto&) const { return 0; }
  float log_pdf(int) const { return std::log(density); }
};

}  // namespace

TEST_CASE("hostile: every weight of random hard inputs", "[hostile]") {
  check<float>("float", 200'000, 1e-5);
  check<double>("double", 200'000, 1e-13);
}

TEST_CASE("hostile: every weight of 1e8 random hard inputs", "[.][slow]") {
  check<float>("float", 100'000'000, 1e-5);
  check<double>("double", 100'000'000, 1e-13);
}

// The sums are plain ones, so N equal densities are the worst there is: each addition rounds the
// same way.
TEST_CASE("hostile: the mixture of 4096 densities that are all alike", "[hostile]") {
  double worst_float = 0.0, worst_double = 0.0;
  std::mt19937_64 random(gmis_test::seed(24));
  std::uniform_real_distribution<double> mantissa(1.0, 2.0);
  for (int run = 0; run < 300; ++run) {
    gmis::MixtureSum<float, false> single;
    gmis::MixtureSum<double, false> twice;
    const double density = mantissa(random);
    for (int k = 0; k < 4096; ++k) {
      single.add(static_cast<float>(density));
      twice.add(density);
    }
    worst_float =
        std::max(worst_float, std::abs(static_cast<double>(single.over(4096.0F)) / static_cast<float>(density) - 1.0));
    worst_double = std::max(worst_double, std::abs(twice.over(4096.0) / density - 1.0));
  }
  std::printf("4096 equal densities: %.2g in float, %.2g in double\n", worst_float, worst_double);
  CHECK(worst_float < 1e-4);
  CHECK(worst_double < 2e-13);
}

TEST_CASE("hostile: float densities whose sum is infinite are counted, and held by their logarithms", "[hostile]") {
  const std::vector<Plain> plain(8, {3e38F});
  const std::vector<Logarithm> logs(8, {3e38F});
  gmis::Philox source(gmis_test::seed(1));
  for (const Scheme scheme : gmis::all_schemes) {
    CAPTURE(name_of(scheme));
    const auto sum = gmis::estimate(
        scheme, [](int) { return 3e38; }, plain, 4, source);
    CHECK(std::isfinite(sum.mean));
    const std::uint64_t expected = scheme == Scheme::R1 || scheme == Scheme::N1 ? 0U : scheme == Scheme::N2 ? 28U : 32U;
    CHECK(sum.rejected.non_finite_density == expected);
    const auto in_logs = gmis::estimate(
        scheme, [](int) { return 3e38; }, logs, 4, source);
    CHECK(in_logs.rejected.total() == 0);
    CHECK(in_logs.mean == Approx(1.0).epsilon(1e-5));
  }
}
