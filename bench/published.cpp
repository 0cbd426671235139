// Problems of the literature: the figures that were published, or found by programs apart from this
// library, beside ours.
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "gmis/benchmark.hpp"
#include "gmis/mis.hpp"
#include "gmis/mis/location_scale.hpp"

namespace {

using gmis::Scheme;

/// A density in proportion to `shape` on [low, high], drawn by rejection.
struct InProportion {
  double low, high, mass, highest;
  double (*shape)(double);

  InProportion(double from, double to, double (*unnormalised)(double))
      : low(from), high(to), mass(0.0), highest(0.0), shape(unnormalised) {
    const std::array<double, 2> ends{low, high};
    for (const auto& node : gmis::composite_gauss_legendre(ends, 64)) {
      mass += node.weight * shape(node.x);
      highest = std::max(highest, shape(node.x));
    }
    highest *= 1.001;  // the largest value lies between nodes
  }
  double sample(gmis::UniformSource auto& source) const {
    for (;;) {
      const double x = low + (high - low) * gmis::uniform<double>(source);
      if (gmis::uniform<double>(source) * highest < shape(x)) return x;
    }
  }
  double pdf(double x) const { return x >= low && x <= high ? shape(x) / mass : 0.0; }
};

struct Normal {
  double mean, deviation;
  double sample(gmis::UniformSource auto& source) const {
    return mean + deviation * gmis::shapes::Normal::sample<double>(source);
  }
  double pdf(double x) const { return gmis::shapes::Normal::pdf<double>((x - mean) / deviation) / deviation; }
};

void row(const char* figure, double known, double ours) {
  std::printf("  %-40s %12.6g %12.6g %9.1e\n", figure, known, ours, std::abs(ours / known - 1.0));
}

constexpr std::array<const char*, 6> variances{"variance of R1", "variance of R2", "variance of R3",
                                               "variance of N1", "variance of N2", "variance of N3"};

template <class F, class P>
void by_oracle(const char* title, const F& f, const P& proposals, const std::array<double, 6>& known) {
  std::printf("\n%s\n", title);
  const gmis::TabulatedProblem problem(f, proposals, gmis::gauss_legendre_over_line(0.0, 3.0, 48));
  for (std::size_t i = 0; i < 6; ++i) row(variances[i], known[i], exact_variance(gmis::all_schemes[i], problem));
}

}  // namespace

int main() {
  std::printf("%-42s %12s %12s %9s\n", "", "known", "ours", "apart");
  constexpr double pi = std::numbers::pi;
  {
    std::printf("\nSbert, Havran, Szirmay-Kalos 2018: (x² − x/π) sin²x on [3/(2π), π] by x, x² − x/π and sin²x\n");
    const double low = 1.5 / pi, high = pi;
    const auto bow = [](double x) { return x * x - x / pi; };
    const std::vector<InProportion> proposals{{low, high, [](double x) { return x; }},
                                              {low, high, +bow},
                                              {low, high, [](double x) { return std::sin(x) * std::sin(x); }}};
    const std::array<double, 2> ends{low, high};
    const gmis::ComparedProblem problem(
        "", [bow](double x) { return bow(x) * std::sin(x) * std::sin(x); }, proposals,
        gmis::composite_gauss_legendre(ends, 64));
    row("integral (three digits published)", 3.60, problem.integral());
    std::printf("%s", gmis::compare(problem, problem.schemes()).text().c_str());
  }
  {
    std::printf("\nSbert, Havran, Szirmay-Kalos 2018: sqrt(x) + sin x on [0.01, π/2] by 2 − x and sin²x\n");
    const double low = 0.01, high = pi / 2.0;
    const std::vector<InProportion> proposals{{low, high, [](double x) { return 2.0 - x; }},
                                              {low, high, [](double x) { return std::sin(x) * std::sin(x); }}};
    const std::array<double, 2> ends{low, high};
    const gmis::ComparedProblem problem(
        "", [](double x) { return std::sqrt(x) + std::sin(x); }, proposals, gmis::composite_gauss_legendre(ends, 64));
    row("integral (six digits published)", 2.31175, problem.integral());
    std::printf("%s", gmis::compare(problem, problem.schemes()).text().c_str());
  }
  // As in the examples of Elvira, Martino, Luengo, Bugallo: normal proposals, mixtures of normals
  // as targets. The figures were found twice by programs that share nothing with this library, and
  // correct the paper's N2 (docs/paper-corrections.md).
  by_oracle("Elvira et al.: three modes, three normal proposals, one over each",
            [](double x) {
              return (Normal{-3, 1}.pdf(x) + Normal{0, 1}.pdf(x) + Normal{3, 1}.pdf(x)) / 3.0;
            },
            std::array<Normal, 3>{{{-3, 2}, {0, 2}, {3, 2}}},
            {6.54749, 0.886525, 0.0513829, 6.54749, 2.27007, 0.0505404});
  by_oracle("Elvira et al.: two unequal modes, two normal proposals",
            [](double x) {
              return 0.7 * Normal{-2, 1}.pdf(x) + 0.3 * Normal{3, 0.8}.pdf(x);
            },
            std::array<Normal, 2>{{{-2.5, 2}, {2.5, 2}}}, {5.60486, 2.96171, 0.350401, 5.60486, 2.97763, 0.318557});
  return 0;
}
