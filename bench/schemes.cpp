// What accuracy costs: time and variance of every scheme, side by side, with a loop by hand beside the library.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "schemes/bootstrap.hpp"
#include "schemes/by_hand.hpp"
#include "schemes/methods.hpp"
#include "schemes/numbers.hpp"
#include "schemes/problems.hpp"
#include "schemes/report.hpp"
#include "schemes/timing.hpp"

namespace {

using bench::Problem;
using gmis::Scheme;
using gmis::Selection;
using gmis::Weighting;
using Json = nlohmann::ordered_json;
using Proposal = bench::Logistic<double>;
using Set = gmis::ProposalSpan<Proposal>;
using Workspace = gmis::Workspace<double, gmis::dynamic_capacity>;

volatile std::sig_atomic_t interrupted = 0;
void on_interrupt(int) {
  interrupted = 1;
}

struct Options {
  bool pairs = false;
  std::size_t largest = 256;
  int slices = 7;
  double slice_seconds = 0.002;
  double measure_seconds = 0.04;
  std::uint64_t seed = 1;
  std::string out = "out/schemes";
};

template <Selection selection, Weighting weighting>
[[gnu::always_inline]] inline double round_of_library(const Set& set, const Problem& f, bench::Words& source,
                                                      Workspace& workspace, std::uint64_t& unusable) {
  double sum = 0.0;
  const auto counts = gmis::sample_round<selection, weighting>(
      set, gmis::EqualAllocation{}, source, workspace,
      [&](double x, double denominator, std::size_t) { sum += f(x) / denominator; });
  unusable += counts.zero_density + counts.non_finite_density;
  return sum / static_cast<double>(set.size());
}

/// Calls `round()` so many times and adds up what it returns.
template <class Round>
bench::Timed repeated(const char* name, Round round) {
  return {name, [round](long repetitions) mutable {
            double sum = 0.0;
            for (long i = 0; i < repetitions; ++i) sum += round();
            return sum;
          }};
}

struct Variance {
  double value;
  double half_width;  ///< of the 99 % interval; 0 where it is exact
};
Variance variance_of(Scheme scheme, const gmis::TabulatedProblem& table, std::uint64_t seed) {
  const std::size_t n = table.proposal_count();
  if ((scheme == Scheme::R2 && n > gmis::max_exact_r2) || (scheme == Scheme::N2 && n > gmis::max_exact_n2)) {
    gmis::Philox source(seed);
    const auto averaged = averaged_variance(scheme, table, 512, source);
    return {averaged.value, averaged.half_width};
  }
  return {exact_variance(scheme, table), 0.0};
}

/// The values of as many rounds as fit the time, at least 400.
template <class Round>
std::vector<double> some_rounds(Round round, double nanoseconds, double seconds) {
  const double fit = seconds * 1e9 / nanoseconds;
  std::vector<double> values(static_cast<std::size_t>(std::clamp(fit, 400.0, 40000.0)));
  for (double& value : values) value = round();
  return values;
}

/// variance × seconds, and what follows from it; I = 1.
void add_efficiency(Json& row, double variance, double nanoseconds) {
  const double seconds = nanoseconds * 1e-9;
  row["efficiency"] = variance > 0.0 ? Json(1.0 / (variance * seconds)) : Json();
  row["seconds_to_1_percent"] = variance / 1e-4 * seconds;
}

template <Selection selection, Weighting weighting>
Json measure(const Problem& problem, const std::vector<Proposal>& proposals, const Variance& exact,
             const Options& options) {
  constexpr Scheme scheme = gmis::scheme_of(selection, weighting);
  const std::size_t n = proposals.size();
  const Set set(proposals.data(), n);
  const std::span<const Proposal> span(proposals);
  Workspace workspace;
  bench::Scratch scratch(n);
  std::uint64_t unusable = 0;
  bench::Words source(options.seed);

  const auto library = [&] {
    return round_of_library<selection, weighting>(set, problem, source, workspace, unusable);
  };
  const auto times = bench::nanoseconds_of(
      {repeated("library", library),
       repeated("by_hand",
                [&] { return bench::round_by_hand<scheme, false>(span, problem, source, scratch, unusable); }),
       repeated("checked",
                [&] { return bench::round_by_hand<scheme, true>(span, problem, source, scratch, unusable); })},
      options.slices, options.slice_seconds);

  bench::Words fresh(options.seed + n);
  source = fresh;
  const std::vector<double> values = some_rounds(library, times[0], options.measure_seconds);
  const auto measured = bench::bootstrap_variance(values, options.seed);

  const double distinct = static_cast<double>(n) * (1.0 - std::pow(1.0 - 1.0 / static_cast<double>(n), n));
  const double evaluations = scheme == Scheme::R2 ? static_cast<double>(n) * distinct
                                                  : static_cast<double>(gmis::density_evaluations_per_round(scheme, n));
  Json row{{"problem", problem.name},
           {"proposals", n},
           {"scheme", name_of(scheme)},
           {"selection", name_of(selection)},
           {"weighting", name_of(weighting)},
           {"density_evaluations", evaluations},
           {"nanoseconds_per_round", times[0]},
           {"nanoseconds_per_density_evaluation", times[0] / evaluations},
           {"by_hand_nanoseconds", times[1]},
           {"ratio_to_by_hand", times[0] / times[1]},
           {"ratio_to_checked_by_hand", times[0] / times[2]},
           {"exact_variance", exact.value},
           {"exact_variance_half_width", exact.half_width},
           {"measured_variance", measured.value},
           {"measured_low", measured.low},
           {"measured_high", measured.high},
           {"measured_rounds", values.size()},
           {"unusable_samples", unusable}};
  add_efficiency(row, exact.value, times[0]);
  std::printf("%-7s %4zu  %s %s%s %9.0f %11.1f %7.3f %7.3f  %11.4g  %11.4g [%.4g, %.4g] %11.3g\n", problem.name, n,
              name_of(scheme).data(), name_of(selection).data(), name_of(weighting).data(), evaluations, times[0],
              times[0] / times[1], times[0] / times[2], exact.value, measured.value, measured.low, measured.high,
              row["seconds_to_1_percent"].get<double>());
  std::fflush(stdout);
  return row;
}

/// Efficiency over P, for densities that cost what they do here and multiples of that.
Json measure_groups(const Problem& problem, std::size_t n, std::size_t group_size, const gmis::TabulatedProblem& table,
                    const Options& options) {
  const auto proposals = problem.proposals(n);
  const Set set(proposals.data(), n);
  const gmis::Groups<> groups(n, group_size);
  Workspace workspace;
  bench::Words source(options.seed);
  const auto round = [&] {
    double sum = 0.0;
    gmis::sample_partial_round(set, groups, source, workspace,
                               [&](double x, double denominator, std::size_t) { sum += problem(x) / denominator; });
    return sum / static_cast<double>(n);
  };
  const double nanoseconds =
      bench::nanoseconds_of({repeated("groups", round)}, options.slices, options.slice_seconds)[0];
  const auto measured =
      bench::bootstrap_variance(some_rounds(round, nanoseconds, options.measure_seconds), options.seed);
  const double variance = exact_moments(groups, table).variance;
  Json row{{"problem", problem.name},
           {"proposals", n},
           {"group_size", group_size},
           {"density_evaluations", groups.density_evaluations_per_round()},
           {"nanoseconds_per_round", nanoseconds},
           {"exact_variance", variance},
           {"measured_variance", measured.value},
           {"measured_low", measured.low},
           {"measured_high", measured.high}};
  add_efficiency(row, variance, nanoseconds);
  return row;
}

constexpr double cost_factors[] = {1.0, 4.0, 16.0, 64.0, 256.0};

/// Adds to the rows of one problem and N the efficiency where densities cost more, and prints where the top lies. The cost
/// of one density is that of going from groups of one to a single group.
void add_dearer_densities(std::vector<Json>& rows) {
  const auto number = [](const Json& row, const char* key) { return row[key].get<double>(); };
  const Json &first = rows.front(), &last = rows.back();
  const double per_density = (number(last, "nanoseconds_per_round") - number(first, "nanoseconds_per_round")) /
                             (number(last, "density_evaluations") - number(first, "density_evaluations"));
  std::printf("%-7s %4.0f  best P:", first["problem"].get<std::string>().c_str(), number(first, "proposals"));
  for (const double factor : cost_factors) {
    double best = 0.0, best_size = 0.0;
    for (Json& row : rows) {
      const double nanoseconds =
          number(row, "nanoseconds_per_round") + (factor - 1.0) * per_density * number(row, "density_evaluations");
      const double efficiency = 1e9 / (number(row, "exact_variance") * nanoseconds);
      row["efficiency_at_" + std::to_string(static_cast<int>(factor)) + "x"] = efficiency;
      if (efficiency > best) {
        best = efficiency;
        best_size = number(row, "group_size");
      }
    }
    std::printf("  %g× %g", factor, best_size);
  }
  std::printf("   (one density: %.2f ns)\n", per_density);
}

/// What `best_scheme` picks from a pilot, and what the exact variances say of it.
Json judge_choice(const Problem& problem, std::size_t n, double factor, gmis::CostModel costs,
                  const gmis::TabulatedProblem& table, const Options& options) {
  costs.per_density *= factor;
  bench::Words source(options.seed);
  constexpr std::uint64_t pilot_rounds = 100;
  const gmis::Pilot pilot(problem, problem.proposals(n), pilot_rounds, source);
  const auto choice = gmis::best_scheme(pilot.problem(), costs, source);
  const auto exact = gmis::best_scheme(table, costs, source);
  const auto name = [](const gmis::SchemeCandidate& candidate) {
    return std::string(name_of(candidate.scheme)) +
           (candidate.group_size > 0 ? " in groups of " + std::to_string(candidate.group_size) : "");
  };
  const double loss = exact.candidates[choice.best].variance_times_cost() / exact.chosen().variance_times_cost();
  std::printf("%-7s %4zu %5g×  picked %-20s best %-20s variance × cost over the least: %.3f\n", problem.name, n, factor,
              name(choice.chosen()).c_str(), name(exact.chosen()).c_str(), loss);
  return {{"problem", problem.name},
          {"proposals", n},
          {"density_cost_factor", factor},
          {"pilot_rounds", pilot_rounds},
          {"picked", name(choice.chosen())},
          {"best", name(exact.chosen())},
          {"loss", loss}};
}

void run(const Options& options) {
  Json report{{"complete", false}, {"seed", options.seed}, {"integral", 1.0}};
  for (const char* part : {"schemes", "partial", "choices", "methods", "numbers"}) report[part] = Json::array();
  const auto keep = [&](const char* part, Json row) {
    report[part].push_back(std::move(row));
    bench::write_report(report, options.out);
  };

  std::printf(
      "problem    N  scheme   densities    ns/round by hand checked  exact var.   measured [95 %%]   s to 1 %%\n");
  for (const Problem& problem : bench::problems)
    for (std::size_t n = 1; n <= options.largest; n *= 2) {
      const auto proposals = problem.proposals(n);
      const gmis::TabulatedProblem table(problem, proposals, problem.nodes());
      std::map<Scheme, Variance> exact;
      for (const Scheme scheme : gmis::all_schemes) exact[scheme] = variance_of(scheme, table, options.seed);
      const auto one = [&](Selection selection, Weighting weighting) {
        if (interrupted) return;
        keep("schemes", dispatch(selection, weighting, [&](auto s, auto w) {
               return measure<decltype(s)::value, decltype(w)::value>(problem, proposals, exact[gmis::scheme_of(s, w)],
                                                                      options);
             }));
      };
      if (options.pairs) {
        for (const Selection selection : gmis::all_selections)
          for (const Weighting weighting : gmis::all_weightings) one(selection, weighting);
      } else {
        for (const Scheme scheme : gmis::all_schemes)
          one(gmis::cheapest_pair(scheme).selection, gmis::cheapest_pair(scheme).weighting);
      }
    }

  std::printf("\nGroups of P, from N1 (P = 1) to N3 (P = N): the most efficient P as densities get dearer\n");
  for (const Problem& problem : bench::problems)
    for (const std::size_t n : {std::size_t{16}, std::size_t{64}}) {
      if (n > options.largest || interrupted) continue;
      const gmis::TabulatedProblem table(problem, problem.proposals(n), problem.nodes());
      std::vector<Json> rows;
      for (std::size_t size = 1; size <= n && !interrupted; size *= 2)
        rows.push_back(measure_groups(problem, n, size, table, options));
      if (interrupted) break;
      add_dearer_densities(rows);
      for (Json& row : rows) report["partial"].push_back(std::move(row));
      bench::write_report(report, options.out);
    }

  std::printf("\nbest_scheme from a pilot of 100 rounds\n");
  for (const Problem& problem : bench::problems)
    for (const std::size_t n : {std::size_t{4}, std::size_t{16}, std::size_t{64}}) {
      if (n > options.largest || interrupted) continue;
      const gmis::TabulatedProblem table(problem, problem.proposals(n), problem.nodes());
      std::optional<double> with_n1, with_n3;
      for (const Json& row : report["schemes"])
        if (row["problem"] == problem.name && row["proposals"] == n) {
          if (row["scheme"] == "N1") with_n1 = row["nanoseconds_per_round"].get<double>();
          if (row["scheme"] == "N3") with_n3 = row["nanoseconds_per_round"].get<double>();
        }
      const double count = static_cast<double>(n);
      const double per_density = std::max(0.1, (*with_n3 - *with_n1) / (count * count - count));
      const gmis::CostModel costs{per_density, std::max(0.1, *with_n1 / count - per_density)};
      for (const double factor : {1.0, 16.0, 256.0})
        if (!interrupted) keep("choices", judge_choice(problem, n, factor, costs, table, options));
    }

  std::printf(
      "\nMethods, rounds of N samples: error is the mean squared error × rounds, pilots apart\n"
      "problem    N  method                            densities    ns/round       error        bias  efficiency/N3\n");
  if (!interrupted)
    for (const Json& row :
         bench::measured_methods(options.largest, options.slices, options.slice_seconds, options.seed)) {
      std::printf("%-7s %4d  %-32s %10.1f %11.1f %11.4g %11.2g %14.3g\n", row["problem"].get<std::string>().c_str(),
                  row["proposals"].get<int>(), row["method"].get<std::string>().c_str(),
                  row["density_evaluations"].get<double>(), row["nanoseconds_per_round"].get<double>(),
                  row["error"].get<double>(), row["bias"].get<double>(), row["efficiency_over_n3"].get<double>());
      keep("methods", row);
    }

  std::printf(
      "\nNumbers                               size  in                             ns   error: rms       largest\n");
  const auto keep_numbers = [&](const Json& rows) {
    for (const Json& row : rows) {
      std::printf("%-37s %4d  %-26s %7.1f   %10.2g   %10.2g\n", row["what"].get<std::string>().c_str(),
                  row["size"].get<int>(), row["numbers"].get<std::string>().c_str(), row["nanoseconds"].get<double>(),
                  row["weight_error_rms"].get<double>(), row["weight_error_max"].get<double>());
      keep("numbers", row);
    }
  };
  if (!interrupted) keep_numbers(bench::numbers_of_estimators(options.slices, options.slice_seconds));
  if (!interrupted) keep_numbers(bench::numbers_of_path_weights(options.slices, options.slice_seconds));

  report["complete"] = interrupted == 0;
  bench::write_report(report, options.out);
  std::printf("\n%s.json and %s-*.csv%s\n", options.out.c_str(), options.out.c_str(),
              interrupted ? ": what there was when it was interrupted" : "");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Time and variance of the sampling schemes, side by side; JSON and CSV");
  app.add_flag("--pairs", options.pairs, "all fifteen pairs of selection and weighting, not only one for each scheme");
  app.add_option("--largest", options.largest, "the largest N: 1, 2, 4, … up to it")->check(CLI::Range(1, 4096));
  app.add_option("--slices", options.slices, "interleaved slices of time each loop gets")->check(CLI::Range(1, 1000));
  app.add_option("--slice-seconds", options.slice_seconds, "length of one")->check(CLI::Range(1e-5, 10.0));
  app.add_option("--measure-seconds", options.measure_seconds, "time to measure one variance in")
      ->check(CLI::Range(1e-4, 1000.0));
  app.add_option("--seed", options.seed, "of all samples");
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
