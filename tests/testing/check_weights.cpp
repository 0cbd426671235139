#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/methods.hpp"
#include "gmis/testing.hpp"
#include "gmis/testing/catch.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"

namespace {

using Counts = std::vector<std::uint32_t>;
const std::vector<test::Uniform> halves{{0.0, 0.6}, {0.4, 1.0}};
const Counts counts{3, 1};

/// Balance, with one number for each count and a floor under each weight: what a user might write,
/// and get wrong.
struct Mine {
  std::array<double, 2> n;
  double floor = 0.0;
  void operator()(double x, std::span<double> out) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < 2; ++k) sum += n[k] * halves[k].pdf(x);
    for (std::size_t k = 0; k < 2; ++k) {
      const double balance = sum > 0 ? n[k] * halves[k].pdf(x) / sum : 0.0;
      out[k] = std::max(floor, balance);
    }
  }
};

}  // namespace

TEST_CASE("check_weights: sound weights pass, drawn and given", "[testing]") {
  gmis::Philox source = gmis::seeded("sound weights");
  CHECK_THAT(gmis::check_weights(Mine{{3.0, 1.0}}, halves, counts, 100, source), gmis::SumsToOne());
  // Other counts in the weights are no error of this kind: they sum to one.
  CHECK_THAT(gmis::check_weights(Mine{{1.0, 1.0}}, halves, counts, 100, source), gmis::SumsToOne());
  const std::vector<double> points{0.1, 0.5, 0.9, 1.5};
  const auto check = gmis::check_weights_at(points, Mine{{3.0, 1.0}}, halves, counts);
  CHECK(check.points() == 4);
  CHECK(check.unreached() == 1);
  CHECK(check.passes());
}

// Samples from one engine of the standard library alone.
struct OfOneEngine {
  double sample(std::mt19937& engine) const { return gmis::uniform<double>(engine); }
  double pdf(double) const { return 1.0; }
};

TEST_CASE("check_weights: proposals that take another source", "[testing]") {
  std::mt19937 engine(3);
  const std::array<OfOneEngine, 1> proposals{};
  const auto one = [](double, std::span<double> out) { out[0] = 1.0; };
  CHECK_THAT(gmis::check_weights(one, proposals, Counts{1}, 10, engine), gmis::SumsToOne());
  CHECK(gmis::check_weights_at<std::mt19937>(std::vector<double>{0.5}, one, proposals, Counts{1}).passes());
}

TEST_CASE("check_weights: weights that do not sum to one, or stand where no sample comes from", "[testing]") {
  gmis::Philox source = gmis::seeded("unsound weights");
  const auto floored = gmis::check_weights(Mine{{3.0, 1.0}, 0.1}, halves, counts, 100, source);
  CHECK_FALSE(floored.passes());
  CHECK(floored.without_density() == Approx(0.1));
  // A proposal without samples must have no weight.
  const auto left_out = gmis::check_weights(Mine{{3.0, 1.0}}, halves, Counts{3, 0}, 100, source);
  CHECK_FALSE(left_out.passes());
  const auto half = [](double x, std::span<double> out) {
    Mine{{3.0, 1.0}}(x, out);
    out[0] *= 0.5;
  };
  const auto check = gmis::check_weights_at(std::vector<double>{0.9, 0.5}, half, halves, counts);
  CHECK(check.sum_error() == Approx(0.375));
  CHECK(check.worst() == 1);
  // What is not written is found.
  CHECK_FALSE(gmis::check_weights([](double, std::span<double>) {}, halves, counts, 10, source).passes());
  CHECK_FALSE(gmis::WeightCheck().passes());
}

TEST_CASE("check_weights: a density that is not finite, or is negative, is no density of 0", "[testing]") {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -1.0}) {
    gmis::WeightCheck check;
    check.add(std::vector<double>{1.0, 3.0}, std::vector<double>{0.25, 0.75});
    CHECK(check.passes());
    check.add(std::vector<double>{1.0, bad}, std::vector<double>{1.0, 0.0});
    CHECK_FALSE(check.passes());
    check.add(std::vector<double>{bad, bad}, std::vector<double>{1.0, 0.0});
    CHECK(check.not_finite() == 2);
    CHECK(check.unreached() == 0);
  }
}

TEST_CASE("check_weights: densities given as logarithms", "[testing]") {
  const std::array<test::Normal3, 2> normals{{{{0.0, 0.0, 0.0}, 1.0}, {{60.0, 0.0, 0.0}, 1.0}}};
  gmis::Philox source = gmis::seeded("logarithms");
  const auto balance = [&](const glm::dvec3& x, std::span<double> out) {
    const std::array<double, 2> logs{normals[0].log_pdf(x), normals[1].log_pdf(x)};
    gmis::heuristic_weights_from_logs(gmis::Balance{}, std::array<std::uint32_t, 2>{3, 1},
                                      std::span<const double>(logs), out);
  };
  CHECK_THAT(gmis::check_weights(balance, normals, counts, 50, source), gmis::SumsToOne());
}

// States its density as a logarithm: 0 inside, `bad` beyond 1.
struct BrokenLog {
  double bad;

  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  double log_pdf(double x) const { return x < 1.0 ? 0.0 : bad; }
};

TEST_CASE("check_weights: logarithms that are no density", "[testing]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> points{0.5, 1.5};
  const auto one = [](double, std::span<double> out) { out[0] = 1.0; };
  const auto check_of = [&](double bad) {
    return gmis::check_weights_at(points, one, std::array<BrokenLog, 1>{{{bad}}}, Counts{1});
  };
  CHECK(check_of(-infinity).unreached() == 1);
  CHECK(check_of(-infinity).not_finite() == 0);
  for (const double bad : {infinity, std::nan("")}) {
    CHECK(check_of(bad).not_finite() == 1);
    CHECK(check_of(bad).unreached() == 0);
  }
}

TEST_CASE("weights of the library sum to one", "[testing]") {
  gmis::Philox source = gmis::seeded("weights of the library");
  const std::vector<test::Bump> bumps{{0.0, 0.3, 0.2}, {0.2, 0.7, 0.2}, {0.6, 1.0, 0.2}};
  const Counts three{2, 1, 4};
  const auto check = [&](const auto& heuristic) {
    const auto weights = [&](double x, std::span<double> out) {
      std::array<double, 3> densities{};
      for (std::size_t k = 0; k < 3; ++k) densities[k] = bumps[k].pdf(x);
      heuristic.weights(three, densities, out);
    };
    CHECK_THAT(gmis::check_weights(weights, bumps, three, 200, source), gmis::SumsToOne(1e-12));
  };
  check(gmis::RatioWeights<gmis::Balance>{});
  check(gmis::RatioWeights<gmis::Power>{});
  check(gmis::RatioWeights<gmis::Maximum>{});
  check(gmis::ScaledBalance{{1.0, 5.0, 0.3}});
  check(gmis::Pairwise{1});
}
