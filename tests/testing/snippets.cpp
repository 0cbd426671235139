#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/testing.hpp"
#include "support/catch.hpp"

// The code of docs/test-your-estimator.md that is in no other file, verbatim, and checks that it
// does what the text says.

namespace {

struct Exponential {
  double rate;
  double sample(gmis::UniformSource auto& source) const {
    return -std::log(1.0 - gmis::uniform<double>(source)) / rate;
  }
  double pdf(double x) const { return x >= 0.0 ? rate * std::exp(-rate * x) : 0.0; }
};

void check_the_rule() {
  const std::array<Exponential, 2> proposals{{{0.5}, {2.0}}};
  const auto f = [](double x) { return x < 0.0 ? 0.0 : x * std::exp(-x); };
  const std::array<double, 1> jump{0.0};
  const auto nodes = gmis::gauss_legendre_over_line(0.0, 2.0, 16, jump);
  const auto finer = gmis::gauss_legendre_over_line(0.0, 2.0, 32, jump);
  const gmis::ProblemCheck check = gmis::check_problem(f, proposals, nodes, finer);
  if (!check.passes()) std::puts(check.finding().data());
}

std::vector<double> variance_in_the_plane() {
  struct Square {
    glm::dvec2 sample(gmis::Philox& source) const {
      const double x = gmis::uniform<double>(source);
      return {x, gmis::uniform<double>(source)};
    }
    double pdf(const glm::dvec2&) const { return 1.0; }
  };
  const std::array<Square, 1> proposals{};
  const std::array<double, 2> ends{0.0, 1.0};
  const auto side = gmis::composite_gauss_legendre(ends, 4);
  const auto f = [](const glm::dvec2& p) { return glm::dvec3(p.x, p.x * p.y, 1.0); };
  std::vector<double> variances;
  for (const auto& channel : gmis::tabulate_channels(f, proposals, gmis::tensor_rule(side, side)))
    variances.push_back(gmis::exact_variance(gmis::Scheme::N3, channel));
  return variances;  // 1/12, 7/144, 0
}

bool my_weights_are_sound(const std::vector<Exponential>& proposals, gmis::CountsByProposal counts) {
  const auto my_weights = [&](double x, std::span<double> out) {
    double sum = 0.0;
    for (std::size_t k = 0; k < out.size(); ++k) sum += out[k] = counts[k] * proposals[k].pdf(x);
    for (double& weight : out) weight /= sum;
  };
  gmis::Philox source = gmis::seeded("my weights");
  const gmis::WeightCheck check = gmis::check_weights(my_weights, proposals, counts, 1000, source);
  return check.passes();  // check.text() says where the sums are off
}

/// The text that `work` prints.
template <class Work>
std::string printed_by(const Work& work) {
  std::FILE* const file = std::tmpfile();
  REQUIRE(file != nullptr);
  std::fflush(stdout);
  const int usual = dup(STDOUT_FILENO);
  dup2(fileno(file), STDOUT_FILENO);
  work();
  std::fflush(stdout);
  dup2(usual, STDOUT_FILENO);
  close(usual);
  std::rewind(file);
  std::string text;
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text.push_back(static_cast<char>(c));
  std::fclose(file);
  return text;
}

}  // namespace

TEST_CASE("the rule on the page about tests fits its problem, and one that does not is found", "[testing]") {
  CHECK(printed_by([] { std::puts("a finding"); }) == "a finding\n");
  CHECK(printed_by(check_the_rule).empty());
  const std::array<Exponential, 2> proposals{{{0.5}, {2.0}}};
  const auto f = [](double x) { return x < 0.0 ? 0.0 : x * std::exp(-x); };
  const std::array<double, 1> jump{0.0};
  const auto over_line = [&](std::size_t panels) { return gmis::gauss_legendre_over_line(0.0, 2.0, panels, jump); };
  const gmis::ProblemCheck check = gmis::check_problem(f, proposals, over_line(16), over_line(32));
  CHECK(check.passes());
  CHECK(check.finding().empty());
  CHECK(check.integral == Approx(1.0).epsilon(1e-9));  // ∫ x exp(−x) from 0
  REQUIRE(check.density_integrals.size() == 2);
  for (const double mass : check.density_integrals) CHECK(mass == Approx(1.0).epsilon(1e-9));
  // A range that ends at 5 has 1 − exp(−5/2) of the first density.
  const std::array<double, 2> ends{0.0, 5.0};
  const auto cut = gmis::check_problem(f, proposals, gmis::composite_gauss_legendre(ends, 16),
                                       gmis::composite_gauss_legendre(ends, 32));
  CHECK_FALSE(cut.passes());
  CHECK(cut.finding().starts_with("a density integrates to less than one"));
  CHECK(cut.density_integrals.at(0) == Approx(1.0 - std::exp(-2.5)).epsilon(1e-9));
  // A jump within a panel.
  const std::array<double, 1> elsewhere{0.3};
  const auto jumps = gmis::check_problem(f, proposals, gmis::gauss_legendre_over_line(0.0, 2.0, 16, elsewhere),
                                         gmis::gauss_legendre_over_line(0.0, 2.0, 32, elsewhere));
  CHECK_FALSE(jumps.passes());
}

TEST_CASE("the code of the page about tests", "[testing]") {
  const auto variances = variance_in_the_plane();
  REQUIRE(variances.size() == 3);
  CHECK(variances[0] == Approx(1.0 / 12.0).epsilon(1e-12));
  CHECK(variances[1] == Approx(7.0 / 144.0).epsilon(1e-12));
  CHECK(std::abs(variances[2]) < 1e-12);
  CHECK(my_weights_are_sound({{0.5}, {2.0}}, std::vector<std::uint32_t>{2, 1}));
}
