#include "numbers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/transport/weights/path_densities.hpp"
#include "gmis/transport/weights/weight_recursion.hpp"
#include "problems.hpp"
#include "transport/synthetic_path.hpp"

namespace bench {
namespace {

using Wide = long double;

/// Largest and root mean square relative error.
class Errors {
 public:
  void add(Wide value, Wide reference) {
    const double error = static_cast<double>(std::abs(value / reference - 1.0L));
    largest_ = std::max(largest_, error);
    squares_ += error * error;
    ++count_;
  }
  [[nodiscard]] double largest() const { return largest_; }
  [[nodiscard]] double rms() const { return std::sqrt(squares_ / static_cast<double>(count_)); }

 private:
  double largest_ = 0.0, squares_ = 0.0;
  std::uint64_t count_ = 0;
};

/// Eight proposals, scheme N3: samples in X, densities and weights in D. The error is that of 1/ψ
/// at the sample drawn.
template <class X, class D>
struct Estimator {
  static constexpr std::size_t count = 8;
  std::array<Logistic<X, D>, count> proposals;

  Estimator() {
    for (std::size_t k = 0; k < count; ++k)
      proposals[k] = {X(5) * (X(2) * static_cast<X>(k) / X(count - 1) - X(1)), X(0.8)};
  }
  [[nodiscard]] double run(long rounds) const {
    Words source(3);
    double sum = 0.0;
    for (long round = 0; round < rounds; ++round)
      gmis::sample_round<gmis::Scheme::N3>(proposals, source, [&](X x, D psi, std::size_t) {
        sum += static_cast<double>(D(1) / (psi * (D(1) + D(x) * D(x))));
      });
    return sum;
  }
  [[nodiscard]] Errors errors() const {
    Words source(3);
    Errors result;
    for (int round = 0; round < 20000; ++round)
      gmis::sample_round<gmis::Scheme::N3>(proposals, source, [&](X x, D psi, std::size_t) {
        Wide exact = 0.0L;
        for (const auto& q : proposals)
          exact += Logistic<Wide>{static_cast<Wide>(q.centre), static_cast<Wide>(q.scale)}.pdf(static_cast<Wide>(x));
        result.add(static_cast<Wide>(D(1) / psi), static_cast<Wide>(count) / exact);
      });
    return result;
  }
};

/// Paths as a float renderer stores them; the recursion in T. Every weight of every technique.
template <class T>
struct PathWeights {
  std::vector<gmis_test::SyntheticPath<T>> paths;
  gmis::TechniqueCounts<T> counts{T(1), T(1), T(1), T(16384), T(0.01)};

  explicit PathWeights(int edges) {
    std::mt19937_64 source(17);
    for (int i = 0; i < 64; ++i) {
      const auto stored = gmis_test::random_path<float>(source, edges, 3.0, 0.2);
      gmis_test::SyntheticPath<T> path;
      const auto copy = [](const std::vector<float>& from) { return std::vector<T>(from.begin(), from.end()); };
      path.forward = copy(stored.forward);
      path.reverse = copy(stored.reverse);
      path.to_area_from_light = copy(stored.to_area_from_light);
      path.to_area_from_camera = copy(stored.to_area_from_camera);
      path.is_delta = stored.is_delta;
      path.makes_photons = stored.makes_photons;
      path.origin = static_cast<T>(stored.origin);
      path.first = static_cast<T>(stored.first);
      path.next_event = static_cast<T>(stored.next_event);
      path.camera = static_cast<T>(stored.camera);
      path.light_can_be_hit = stored.light_can_be_hit;
      paths.push_back(path);
    }
  }
  /// One repetition: one path, both ends, and one weight.
  [[nodiscard]] double run(long repetitions) const {
    double sum = 0.0;
    for (long i = 0; i < repetitions; ++i) {
      const auto& path = paths[static_cast<std::size_t>(i) % paths.size()];
      const gmis_test::RecursiveWeights<T, gmis::BalanceRatio> weights(path, counts);
      sum += static_cast<double>(weights.weight(gmis::TechniqueIndex{.s = 1}));
    }
    return sum;
  }
  [[nodiscard]] Errors errors() const {
    Errors result;
    for (const auto& path : paths) {
      const gmis_test::RecursiveWeights<T, gmis::BalanceRatio> weights(path, counts);
      const auto densities = gmis::technique_densities(gmis_test::path_densities<Wide>(path), counts);
      Wide total = 0.0L;
      for (const auto& technique : densities) total += technique.density;
      for (const auto& technique : densities)
        if (technique.density > 1e-30L * total)
          result.add(static_cast<Wide>(weights.weight(technique.technique)), technique.density / total);
    }
    return result;
  }
};

/// Times of all of them, beside each other.
template <class... Work>
std::vector<double> nanoseconds_of(const gmis::ComparisonSettings& settings, const Work&... works) {
  const std::vector<gmis::Contender> contenders{
      {"", gmis::Contender::Run([&works](std::uint64_t rounds, std::span<double>, Words&) {
         return gmis::RoundValue{works.run(static_cast<long>(rounds)), 0.0};
       })}...};
  std::vector<double> result;
  for (const auto& row : gmis::compare("", 1.0, contenders, settings).rows) result.push_back(row.nanoseconds);
  return result;
}

NumbersRow row(std::string what, std::string numbers, double nanoseconds, const Errors& errors) {
  return {std::move(what), std::move(numbers), nanoseconds, errors.rms(), errors.largest()};
}

}  // namespace

std::vector<NumbersRow> numbers_of_estimators(const gmis::ComparisonSettings& settings) {
  const Estimator<float, float> single;
  const Estimator<float, double> mixed;
  const Estimator<double, double> full;
  const auto times = nanoseconds_of(settings, single, mixed, full);
  const std::string what = "a round of N3, N = 8";
  return {row(what, "float", times[0], single.errors()),
          row(what, "float, weights in double", times[1], mixed.errors()),
          row(what, "double", times[2], full.errors())};
}

std::vector<NumbersRow> numbers_of_path_weights(const gmis::ComparisonSettings& settings) {
  std::vector<NumbersRow> rows;
  for (const int edges : {12, 64}) {
    const PathWeights<float> single(edges);
    const PathWeights<double> full(edges);
    const auto times = nanoseconds_of(settings, single, full);
    const std::string what = "weights of a path of " + std::to_string(edges) + " edges";
    // Paths are stored in float: recursion in double is "weights in double only".
    rows.push_back(row(what, "float", times[0], single.errors()));
    rows.push_back(row(what, "float, weights in double", times[1], full.errors()));
  }
  return rows;
}

}  // namespace bench
