// Which method? Mean squared error, evaluations and time of every method on four integrals whose
// values are known.
//   which_method [--runs N] [--budget N] [--curves FILE.svg]
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "mis/methods.hpp"

namespace {

struct Measured {
  double squared_error, bias, bias_error, integrand_evaluations, density_evaluations, seconds;
  [[nodiscard]] bool is_biased() const { return std::abs(bias) > 5.0 * bias_error + 1e-12; }
};

Measured measure(const methods::Method& method, const four::Problem& problem, std::uint32_t budget, int runs) {
  Measured sum{};
  const std::clock_t start = std::clock();  // processor time: other programs may run
  for (int run = 0; run < runs; ++run) {
    gmis::Philox source(1, static_cast<std::uint32_t>(run));
    const methods::Outcome outcome = method.run(problem, budget, source);
    const double error = outcome.mean - problem.integral;
    sum.squared_error += error * error / runs;
    sum.bias += error / runs;
    sum.integrand_evaluations += outcome.integrand_evaluations / runs;
    sum.density_evaluations += outcome.density_evaluations / runs;
  }
  sum.bias_error = std::sqrt(std::max(0.0, sum.squared_error - sum.bias * sum.bias) / runs);
  sum.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / runs;
  return sum;
}

// Root mean squared error against evaluations of f, drawn by gnuplot where it is installed; the
// numbers are in FILE.dat.
int draw_curves(const std::string& file, const std::vector<four::Problem>& problems, int runs) {
  const std::vector<methods::Method> all = methods::all();
  const std::string data = file + ".dat";
  std::ofstream out(data);
  std::string plots;
  int block = 0;
  for (const four::Problem& problem : problems) {
    plots += std::string("set title '") + problem.name + "'\nplot ";
    for (const methods::Method& method : all) {
      const std::string_view name = method.name;
      if (name != "N3" && name != "R3" && name != "optimal, direct" && name != "allocated counts" &&
          name != "scrambled Sobol'" && name != "population")
        continue;
      for (std::uint32_t budget = 384; budget <= 12288; budget *= 2) {
        const Measured m = measure(method, problem, budget, runs);
        out << m.integrand_evaluations << ' ' << std::sqrt(m.squared_error) + 1e-17 << '\n';
      }
      out << "\n\n";
      plots += "'" + data + "' index " + std::to_string(block++) + " with linespoints title \"" + method.name + "\", ";
    }
    plots += "\n";
  }
  out.close();
  const std::string script = file + ".gnuplot";
  std::ofstream(script) << "set terminal svg size 1000,800\nset output '" << file
                        << "'\nset logscale xy\nset xlabel 'evaluations of f'\nset ylabel 'root mean squared error'\n"
                           "set key bottom left\nset multiplot layout 2,2\n"
                        << plots << "unset multiplot\n";
  if (std::system("command -v gnuplot >/dev/null 2>&1") != 0) {
    std::printf("gnuplot is not installed: the numbers are in %s\n", data.c_str());
    return 0;
  }
  return std::system(("gnuplot '" + script + "'").c_str()) == 0 ? 0 : 1;
}

bool read_number(const char* text, int& number) {
  const std::string_view view = text;
  const auto [end, error] = std::from_chars(view.data(), view.data() + view.size(), number);
  return error == std::errc{} && end == view.data() + view.size() && number > 0;
}

}  // namespace

int main(int argc, char* argv[]) {
  int runs = 400, budget = 1536;
  std::string curves;
  for (int i = 1; i < argc; ++i) {
    const std::string_view option = argv[i];
    const bool has_value = i + 1 < argc;
    if (option == "--runs" && has_value && read_number(argv[i + 1], runs)) {
      ++i;
    } else if (option == "--budget" && has_value && read_number(argv[i + 1], budget) && budget >= 384) {
      ++i;
    } else if (option == "--curves" && has_value) {
      curves = argv[++i];
    } else {
      std::fprintf(stderr, "usage: which_method [--runs N] [--budget N (384 or more)] [--curves FILE.svg]\n");
      return 2;
    }
  }
  const std::vector<four::Problem> problems = four::problems();
  const std::vector<methods::Method> all = methods::all();
  std::vector<std::vector<Measured>> measured(all.size());
  for (std::size_t m = 0; m < all.size(); ++m)
    for (const four::Problem& problem : problems)
      measured[m].push_back(measure(all[m], problem, static_cast<std::uint32_t>(budget), runs));

  // The gain: how many times fewer evaluations of f reach N3's error, which is the ratio of squared
  // error × evaluations.
  const auto table = [&](const char* title, auto cost) {
    std::printf("%s\n\n| method |", title);
    for (const four::Problem& problem : problems) std::printf(" %s |", problem.name);
    std::printf(" densities per f |\n| --- |");
    for (std::size_t p = 0; p <= problems.size(); ++p) std::printf(" ---: |");
    std::printf("\n");
    for (std::size_t m = 0; m < all.size(); ++m) {
      std::printf("| %s |", all[m].name);
      for (std::size_t p = 0; p < problems.size(); ++p) {
        const Measured &n3 = measured[0][p], &own = measured[m][p];
        const double gain = n3.squared_error * cost(n3) / (own.squared_error * cost(own));
        if (own.is_biased())
          std::printf(" biased |");
        else if (gain > 1e6)
          std::printf(" exact |");
        else
          std::printf(gain >= 9.95 ? " %.0f |" : " %.2f |", gain);
      }
      double lowest = 1e300, highest = 0.0;
      for (const Measured& own : measured[m]) {
        const double each = own.density_evaluations / own.integrand_evaluations;
        lowest = std::min(lowest, each);
        highest = std::max(highest, each);
      }
      if (highest - lowest < 0.05)
        std::printf(" %.1f |\n", lowest);
      else
        std::printf(" %.1f–%.1f |\n", lowest, highest);
    }
    std::printf("\n");
  };
  table("Gain over N3 at equal evaluations of f (variance of N3 / mean squared error):",
        [](const Measured& m) { return m.integrand_evaluations; });
  table("Gain over N3 at equal time, as measured here:", [](const Measured& m) { return m.seconds; });

  std::printf("Least squared error × time:\n");
  for (std::size_t p = 0; p < problems.size(); ++p) {
    std::size_t best = 0;
    for (std::size_t m = 1; m < all.size(); ++m)
      if (!measured[m][p].is_biased() && measured[m][p].squared_error * measured[m][p].seconds <
                                             measured[best][p].squared_error * measured[best][p].seconds)
        best = m;
    std::printf("  %-10s %s\n", problems[p].name, all[best].name);
  }
  return curves.empty() ? 0 : draw_curves(curves, problems, std::max(1, runs / 5));
}
