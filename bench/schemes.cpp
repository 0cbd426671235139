// What accuracy costs: time and variance of every scheme, side by side, with a loop by hand beside
// the library.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "gmis/benchmark.hpp"
#include "gmis/mis.hpp"
#include "schemes/by_hand.hpp"
#include "schemes/methods.hpp"
#include "schemes/numbers.hpp"
#include "schemes/problems.hpp"

namespace {

using bench::Problem;
using bench::Words;
using gmis::Scheme;

volatile std::sig_atomic_t interrupted = 0;
void on_interrupt(int) {
  interrupted = 1;
}

struct Options {
  bool pairs = false;
  std::size_t largest = 256;
  gmis::ComparisonSettings times;
  std::string out = "out/schemes";
};

/// First under another name, so that what lies there is whole at every moment.
void write_file(const std::string& path, const std::string& text) {
  const auto folder = std::filesystem::path(path).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder);
  {
    std::ofstream file(path + ".part", std::ios::binary);
    file << text;
    file.flush();
    if (!file) throw std::runtime_error("cannot write " + path + ".part");
  }
  std::filesystem::rename(path + ".part", path);
}

/// Prints comparisons, and keeps them in one file of each kind.
class Report {
 public:
  explicit Report(std::string prefix) : prefix_(std::move(prefix)) {}
  void keep(const gmis::Comparison& comparison) {
    std::printf("%s\n", comparison.text().c_str());
    std::fflush(stdout);
    const std::string csv = comparison.csv();
    csv_ += csv_.empty() ? csv : csv.substr(csv.find('\n') + 1);
    json_ += (json_.empty() ? "" : ",\n") + comparison.json();
    write_file(prefix_ + ".csv", csv_);
    write_file(prefix_ + ".json", "[" + json_ + "]\n");
  }

 private:
  std::string prefix_, csv_, json_;
};

auto compared(const Problem& problem, std::size_t n, const char* part = "") {
  return gmis::ComparedProblem(problem.name + std::string(part) + ", N = " + std::to_string(n), problem,
                               problem.proposals(n), problem.nodes());
}

template <Scheme scheme, bool checked>
gmis::Contender by_hand(const Problem& problem, std::size_t n) {
  return {std::string(name_of(scheme)) + (checked ? " by hand, checked" : " by hand"),
          [problem, proposals = problem.proposals(n), scratch = bench::Scratch(n),
           unusable = std::uint64_t{0}](Words& source) mutable {
            return bench::round_by_hand<scheme, checked>(std::span<const bench::Logistic<double>>(proposals), problem,
                                                         source, scratch, unusable);
          }};
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2.0;
}

void compare_schemes(const Options& options, Report& report) {
  std::map<std::size_t, std::vector<double>> plain, checked;  // library over loop by hand, by N
  for (const Problem& problem : bench::problems)
    for (std::size_t n = 1; n <= options.largest && !interrupted; n *= 2) {
      const auto over = compared(problem, n);
      std::vector<gmis::Contender> contenders;
      if (options.pairs)
        for (const auto selection : gmis::all_selections)
          for (const auto weighting : gmis::all_weightings) contenders.push_back(over.pair(selection, weighting));
      else
        contenders = over.schemes();
      const std::size_t of_library = contenders.size();
      for (const Scheme scheme : gmis::all_schemes)
        dispatch(scheme, [&](auto fixed) {
          contenders.push_back(by_hand<decltype(fixed)::value, false>(problem, n));
          contenders.push_back(by_hand<decltype(fixed)::value, true>(problem, n));
        });
      for (std::size_t i = of_library; i < contenders.size(); ++i)
        contenders[i].exact_variance = over.scheme(gmis::all_schemes[(i - of_library) / 2]).exact_variance;
      const auto comparison = gmis::compare(over, contenders, options.times);
      report.keep(comparison);
      if (options.pairs) continue;
      for (std::size_t i = 0; i < of_library; ++i) {
        const auto time = [&](std::size_t row) { return comparison.rows[row].nanoseconds; };
        plain[n].push_back(time(i) / time(of_library + 2 * i));
        checked[n].push_back(time(i) / time(of_library + 2 * i + 1));
      }
    }
  for (const auto& [n, ratios] : plain)
    std::printf("N = %3zu: the library takes %.3f of a loop by hand, %.3f of one with the same checks (medians)\n", n,
                median(ratios), median(checked[n]));
}

/// Efficiency over P, for densities that cost what they do here and multiples of that. The cost of
/// one density is that of going from groups of one to a single group.
void compare_groups(const Options& options, Report& report) {
  std::printf("\nGroups of P, from N1 (P = 1) to N3 (P = N)\n");
  for (const Problem& problem : bench::problems)
    for (const std::size_t n : {std::size_t{16}, std::size_t{64}}) {
      if (n > options.largest || interrupted) continue;
      const auto over = compared(problem, n, ", groups");
      std::vector<gmis::Contender> contenders;
      for (std::size_t size = 1; size <= n; size *= 2) contenders.push_back(over.groups(size));
      const auto comparison = gmis::compare(over, contenders, options.times);
      report.keep(comparison);
      const auto &first = comparison.rows.front(), &last = comparison.rows.back();
      const double per_density =
          (last.nanoseconds - first.nanoseconds) / (last.density_evaluations - first.density_evaluations);
      std::printf("one density takes %.2f ns; the most efficient P when it takes", per_density);
      for (const double factor : {1.0, 4.0, 16.0, 64.0, 256.0}) {
        const auto score = [&](const gmis::ComparisonRow& row) {
          return row.variance * (row.nanoseconds + (factor - 1.0) * per_density * row.density_evaluations);
        };
        const auto best = std::min_element(comparison.rows.begin(), comparison.rows.end(),
                                           [&](const auto& a, const auto& b) { return score(a) < score(b); });
        std::printf("  %g times that: %s", factor, best->name.c_str());
      }
      std::printf("\n\n");
    }
}

/// Prints the scheme that `best_scheme` picks from a pilot, the best by the exact variances, and
/// the ratio of their variance × cost.
void judge_choices(const Options& options) {
  std::printf("best_scheme from a pilot of 100 rounds\n");
  const auto name = [](const gmis::SchemeCandidate& candidate) {
    return std::string(name_of(candidate.scheme)) +
           (candidate.group_size > 0 ? " in groups of " + std::to_string(candidate.group_size) : "");
  };
  for (const Problem& problem : bench::problems)
    for (const std::size_t n : {std::size_t{4}, std::size_t{16}, std::size_t{64}}) {
      if (n > options.largest || interrupted) continue;
      const auto over = compared(problem, n);
      const auto rows = gmis::compare(over, {over.scheme(Scheme::N1), over.scheme(Scheme::N3)}, options.times).rows;
      const double count = static_cast<double>(n);
      const double per_density = std::max(0.1, (rows[1].nanoseconds - rows[0].nanoseconds) / (count * count - count));
      for (const double factor : {1.0, 16.0, 256.0}) {
        const gmis::CostModel costs{factor * per_density, std::max(0.1, rows[0].nanoseconds / count - per_density)};
        Words source(options.times.seed);
        const gmis::PilotSamples pilot(problem, problem.proposals(n), 100, source);
        const auto choice = gmis::best_scheme(pilot.problem(), costs, source);
        const auto exact = gmis::best_scheme(over.table(), costs, source);
        std::printf("%-7s %4zu %5g×  picked %-20s best %-20s variance × cost over the least: %.3f\n", problem.name, n,
                    factor, name(choice.chosen()).c_str(), name(exact.chosen()).c_str(),
                    exact.candidates[choice.best].variance_times_cost() / exact.chosen().variance_times_cost());
      }
    }
}

void compare_numbers(const Options& options) {
  std::printf("\nNumbers                            in                             ns   error: rms      largest\n");
  for (const auto& part : {bench::numbers_of_estimators(options.times), bench::numbers_of_path_weights(options.times)})
    for (const bench::NumbersRow& row : part)
      std::printf("%-34s %-26s %7.1f   %10.2g   %10.2g\n", row.what.c_str(), row.numbers.c_str(), row.nanoseconds,
                  row.error_rms, row.error_largest);
}

void run(const Options& options) {
  Report report(options.out);
  compare_schemes(options, report);
  compare_groups(options, report);
  judge_choices(options);
  std::printf("\nMethods: a round is an estimate of 64 rounds of N samples, pilots apart\n");
  for (const Problem& problem : bench::problems)
    for (const std::size_t n : {std::size_t{4}, std::size_t{16}, std::size_t{64}})
      if (n <= options.largest && !interrupted) report.keep(bench::compare_methods(problem, n, options.times));
  if (!interrupted) compare_numbers(options);
  std::printf("\n%s.json and %s.csv%s\n", options.out.c_str(), options.out.c_str(),
              interrupted ? ": what there was when it was interrupted" : "");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Time and variance of the sampling schemes, side by side; JSON and CSV");
  app.add_flag("--pairs", options.pairs, "all fifteen pairs of selection and weighting, not only one for each scheme");
  app.add_option("--largest", options.largest, "the largest N: 1, 2, 4, … up to it")->check(CLI::Range(1, 4096));
  app.add_option("--slices", options.times.slices, "interleaved slices of time each loop gets")
      ->check(CLI::Range(1, 1000));
  app.add_option("--slice-seconds", options.times.slice_seconds, "length of one")->check(CLI::Range(1e-5, 10.0));
  app.add_option("--measure-seconds", options.times.measure_seconds, "time to measure one variance in")
      ->check(CLI::Range(1e-4, 1000.0));
  app.add_option("--seed", options.times.seed, "of all samples");
  app.add_option("--out", options.out, "beginning of the names of the files that are written");
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGINT, on_interrupt);
  try {
    run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "schemes: %s\n", error.what());
    return 1;
  }
  return 0;
}
