// The MIS core for Python: schemes, exact moments, weights, allocation and comparison over numpy
// arrays and over functions that take whole arrays.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "batched_rounds.hpp"
#include "gmis/benchmark.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/mis/location_scale.hpp"
#include "gmis/mis/methods.hpp"

namespace py = pybind11;

namespace gmis::python {
namespace {

using Normals = LocationScaleSet<shapes::Normal>;
using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// A new array of these numbers.
Array array_of(std::span<const double> numbers) {
  return Array(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}
std::span<const double> numbers_of(const Array& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}
std::size_t rows_of(const py::array& array) {
  return array.ndim() == 0 ? 1 : static_cast<std::size_t>(array.shape(0));
}

/// One value, or one row of values, for each of `count` samples.
Array values_for(const py::object& f, const py::object& x, std::size_t count) {
  Array values = Array::ensure(f(x));
  if (!values) throw py::error_already_set();
  const bool is_row = values.ndim() == 1 || values.ndim() == 2;
  if (!is_row || rows_of(values) != count)
    throw py::value_error("f(x) must return one number, or one row of numbers, for each of the " +
                          std::to_string(count) + " samples in x");
  return values;
}

/// Samples of one proposal of Python's: `rvs(size=…, random_state=…)`, the first axis over samples.
py::object drawn_from(const py::object& proposal, std::size_t count, const py::object& generator) {
  using namespace py::literals;
  const py::array x = py::array::ensure(proposal.attr("rvs")("size"_a = count, "random_state"_a = generator));
  if (!x) throw py::error_already_set();
  // scipy leaves out the axis of a single sample in many dimensions.
  if (count == 1 && (x.ndim() == 0 || x.shape(0) != 1)) return x.attr("__getitem__")(py::none());
  if (rows_of(x) != count || x.ndim() == 0)
    throw py::value_error("rvs(size=n) of a proposal must return n samples along the first axis");
  return x;
}

/// The densities of a proposal of Python's: `pdf(x)`.
void write_densities(const py::object& proposal, const py::object& x, std::span<double> out) {
  const Array densities = Array::ensure(proposal.attr("pdf")(x));
  if (!densities) throw py::error_already_set();
  if (numbers_of(densities).size() != out.size())
    throw py::value_error("pdf(x) of a proposal must return one density for each sample in x");
  std::copy_n(densities.data(), out.size(), out.begin());
}

/// The densities of all proposals at x: an array with a row for each proposal.
Array densities_at(const py::object& proposals, const py::object& x) {
  const py::array points = py::array::ensure(x);
  if (!points) throw py::error_already_set();
  const std::size_t count = rows_of(points), size = py::len(proposals);
  Array result({size, count});
  for (std::size_t i = 0; i < size; ++i) {
    const std::span<double> out(result.mutable_data() + i * count, count);
    if (py::isinstance<Normals>(proposals)) {
      const Array on_line = Array::ensure(points);
      if (!on_line || on_line.ndim() != 1) throw py::value_error("normals are on the line: x must have one axis");
      const auto& set = proposals.cast<const Normals&>();
      std::transform(on_line.data(), on_line.data() + count, out.begin(),
                     [&](double each) { return set.pdf(i, each); });
    } else {
      write_densities(proposals.attr("__getitem__")(i), points, out);
    }
  }
  return result;
}

/// A problem and the rounds to run.
struct Rounds {
  py::object proposals, f;
  Method method;
  AnyAllocation allocation;
};

// Samples in one call of Python: arrays of 64 kB stay in a near cache, and the system is not asked
// for their memory each time.
constexpr std::uint64_t chunk_size = 1U << 13U;

/// Runs rounds in chunks: `consume(used, sample_count, values)` gets the samples that can be used
/// and f at each, one row a sample.
template <class Consume>
void run_rounds(const Rounds& asked, std::uint64_t rounds, std::uint64_t seed, Consume&& consume) {
  require_rounds(rounds);
  const std::size_t size = py::len(asked.proposals);
  Philox source(seed);
  const bool is_native = py::isinstance<Normals>(asked.proposals);
  const py::object generator =
      is_native ? py::object(py::none()) : py::module_::import("numpy.random").attr("default_rng")(seed);
  const auto run = [&](const auto& allocation) {
    allocation.require_fits(size, selection_of(asked.method));
    const std::size_t sample_count = allocation.sample_count(size);
    const std::uint64_t chunk = std::max<std::uint64_t>(1, chunk_size / sample_count);
    for (std::uint64_t done = 0; done < rounds; done += chunk) {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      const std::uint64_t now = std::min(chunk, rounds - done);
      if (is_native) {
        const auto used = draw_rounds(asked.method, asked.proposals.cast<const Normals&>(), allocation, now, source);
        if (used.x.empty()) continue;
        const Array x(static_cast<py::ssize_t>(used.x.size()), used.x.data());
        consume(used, sample_count, values_for(asked.f, x, used.x.size()));
        continue;
      }
      DrawnSamples drawn(samples_of_rounds(asked.method, allocation, size, now, source));
      py::list parts;
      std::vector<py::object> part_of(size);
      for (std::size_t i = 0; i < size; ++i) {
        if (drawn.count(i) == 0) continue;
        part_of[i] = drawn_from(asked.proposals.attr("__getitem__")(i), drawn.count(i), generator);
        parts.append(part_of[i]);
      }
      const py::object x = py::module_::import("numpy").attr("concatenate")(parts);
      std::size_t first = 0;
      for (std::size_t i = 0; i < size; ++i) {
        const py::object proposal = asked.proposals.attr("__getitem__")(i);
        if (!needs_own_density_alone(asked.method))
          write_densities(proposal, x, drawn.densities(i));
        else if (drawn.count(i) > 0)
          write_densities(proposal, part_of[i], drawn.densities(i).subspan(first, drawn.count(i)));
        first += drawn.count(i);
      }
      const Array values = values_for(asked.f, x, drawn.total());
      consume(draw_rounds(asked.method, drawn, allocation, now, source), sample_count, values);
    }
  };
  std::visit(run, asked.allocation);
}

/// The place of a sample in the array of values: the order of drawing for samples of Python's, the
/// order of use for others.
template <class X>
std::size_t row_of(const UsedSamples<X>& used, std::size_t k) {
  if constexpr (std::is_same_v<X, DrawnSamples::Value>)
    return used.x[k];
  else
    return k;
}

AnyAllocation allocation_of(const std::optional<std::vector<std::int64_t>>& counts,
                            const std::optional<std::vector<double>>& fractions, std::optional<std::int64_t> samples) {
  require_argument(!counts || (!fractions && !samples), "give counts, or fractions with samples, and not both");
  require_argument(fractions.has_value() == samples.has_value(), "fractions and samples go together");
  if (counts) return SampleAllocation<double>(*counts);
  if (!fractions) return EqualAllocation{};
  require_argument(*samples > 0, "a round of no samples: ask for at least one");
  return SampleAllocation<double>(*fractions, static_cast<std::size_t>(*samples));
}

std::string name_of_pair(SelectionAndWeighting pair) {
  return std::string(name_of(pair.selection)) + std::string(name_of(pair.weighting));
}

Method method_of(const py::object& method) {
  if (!py::isinstance<py::str>(method)) return method.cast<Method>();
  const auto name = method.cast<std::string>();
  for (const Scheme scheme : all_schemes)
    if (name == name_of(scheme)) return cheapest_pair(scheme);
  for (const Selection selection : all_selections)
    for (const Weighting weighting : all_weightings)
      if (name == name_of_pair({selection, weighting})) return SelectionAndWeighting{selection, weighting};
  throw py::value_error(
      "the method is one of R1, R2, R3, N1, N2, N3, a pair from S1W1 to S3W5, or an object such as gmis.Power(2)");
}

py::dict estimate(const py::object& method, const py::object& f, const py::object& proposals, std::uint64_t rounds,
                  std::uint64_t seed, const std::optional<std::vector<std::int64_t>>& counts,
                  const std::optional<std::vector<double>>& fractions, std::optional<std::int64_t> samples) {
  const Rounds asked{proposals, f, method_of(method), allocation_of(counts, fractions, samples)};
  std::vector<EstimateAccumulator<double>> channels(1);
  bool has_rows = false;
  run_rounds(asked, rounds, seed, [&](const auto& used, std::size_t sample_count, const Array& values) {
    has_rows = values.ndim() == 2;
    const std::size_t width = has_rows ? static_cast<std::size_t>(values.shape(1)) : 1;
    if (channels[0].result().rounds == 0) channels.resize(width);
    require_argument(width == channels.size() && width > 0, "f(x) must return rows of one length");
    const double* const first = values.data();
    for (std::size_t c = 0; c < width; ++c) {
      const auto value = [&](std::size_t k) { return first[row_of(used, k) * width + c]; };
      add_rounds(channels[c], used, sample_count, value);
    }
  });
  using namespace py::literals;
  std::vector<double> means, variances, errors;
  Rejected rejected{};  // of the channel that has most, by cause
  for (const auto& channel : channels) {
    const Estimate<double> result = channel.result();
    for (const auto cause : {&Rejected::non_finite_integrand, &Rejected::zero_density, &Rejected::non_finite_density,
                             &Rejected::non_finite_contribution})
      rejected.*cause = std::max(rejected.*cause, result.rejected.*cause);
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    means.push_back(result.mean);
    variances.push_back(result.variance.value_or(unknown));
    errors.push_back(result.standard_error.value_or(unknown));
  }
  const auto shaped = [&](const std::vector<double>& numbers) {
    return has_rows ? py::object(array_of(numbers)) : py::object(py::float_(numbers[0]));
  };
  const Estimate<double> facts = channels[0].result();
  return py::dict("mean"_a = shaped(means), "variance"_a = shaped(variances), "standard_error"_a = shaped(errors),
                  "rounds"_a = facts.rounds, "samples"_a = facts.samples,
                  "density_evaluations"_a = facts.density_evaluations,
                  "integrand_evaluations"_a = facts.integrand_evaluations,
                  "rejected"_a = py::dict("non_finite_integrand"_a = rejected.non_finite_integrand,
                                          "zero_density"_a = rejected.zero_density,
                                          "non_finite_density"_a = rejected.non_finite_density,
                                          "non_finite_contribution"_a = rejected.non_finite_contribution));
}

/// False where the estimate is biased, or its variance a sum over too many draws.
bool has_exact_moments(const TabulatedProblem& problem, const Method& method) {
  const std::size_t size = problem.proposal_count();
  if (const auto* const groups = std::get_if<GroupsOf>(&method))
    return has_full_support(Groups<>(size, groups->size), problem);
  const auto* const pair = std::get_if<SelectionAndWeighting>(&method);
  if (pair == nullptr) return true;
  const Scheme scheme = scheme_of(pair->selection, pair->weighting);
  if (needs_full_support(scheme) && !problem.has_full_support()) return false;
  return !(scheme == Scheme::R2 && size > max_exact_r2) && !(scheme == Scheme::N2 && size > max_exact_n2);
}

/// Mean and variance of one round.
std::pair<double, double> exact_moments_of(const TabulatedProblem& problem, const py::object& method,
                                           const std::optional<std::vector<std::int64_t>>& counts,
                                           const std::optional<std::vector<double>>& fractions,
                                           std::optional<std::int64_t> samples) {
  const AnyAllocation any = allocation_of(counts, fractions, samples);
  const auto with_allocation = [&](const auto& allocation) {
    const auto with_method = [&]<class M>(const M& chosen) {
      constexpr bool is_equal = std::is_same_v<std::remove_cvref_t<decltype(allocation)>, EqualAllocation>;
      if constexpr (std::is_same_v<M, SelectionAndWeighting>) {
        const Scheme scheme = scheme_of(chosen.selection, chosen.weighting);
        if constexpr (is_equal)
          return gmis::exact_moments(scheme, problem);
        else
          return gmis::exact_moments(scheme, allocation, problem);
      } else if constexpr (std::is_same_v<M, GroupsOf>) {
        require_argument(is_equal, "groups take one sample of each proposal");
        return gmis::exact_moments(Groups<>(problem.proposal_count(), chosen.size), problem);
      } else {
        allocation.require_fits(problem.proposal_count(), Selection::S3);
        std::vector<std::uint32_t> numbers;
        for (std::size_t i = 0; i < problem.proposal_count(); ++i) numbers.push_back(allocation.count(i));
        return exact_moments_with_weights(RatioWeights<M>{chosen}, numbers, problem);
      }
    };
    return std::visit(with_method, method_of(method));
  };
  const ExactMoments moments = std::visit(with_allocation, any);
  return {moments.mean, moments.variance};
}

/// The weights of all proposals at points: densities and result have a row for each proposal.
Array weights_at(const py::object& heuristic, const std::vector<std::int64_t>& counts, const Array& densities) {
  require_argument(densities.ndim() == 2, "densities must have a row for each proposal and a column for each point");
  const std::size_t size = rows_of(densities), points = static_cast<std::size_t>(densities.shape(1));
  const SampleAllocation<double> allocation(counts);
  allocation.require_fits(size, Selection::S3);
  std::vector<std::uint32_t> numbers;
  for (std::size_t i = 0; i < size; ++i) numbers.push_back(allocation.count(i));
  Array result({size, points});
  std::vector<double> at(size);
  const auto write = [&]<class M>(const M& chosen) {
    if constexpr (std::is_same_v<M, SelectionAndWeighting> || std::is_same_v<M, GroupsOf>) {
      throw py::value_error("weights are those of a heuristic: gmis.Balance(), gmis.Power(2), …");
    } else {
      require_heuristic(chosen);
      for (std::size_t point = 0; point < points; ++point) {
        for (std::size_t i = 0; i < size; ++i) at[i] = densities.data()[i * points + point];
        heuristic_weights(chosen, std::span<const std::uint32_t>(numbers), std::span<const double>(at), std::span(at));
        for (std::size_t i = 0; i < size; ++i) result.mutable_data()[i * points + point] = at[i];
      }
    }
  };
  std::visit(write, method_of(heuristic));
  return result;
}

/// A contender whose rounds run in chunks.
Contender contender_of(std::string name, const TabulatedProblem& problem, const py::object& f,
                       const py::object& proposals, const py::object& method,
                       const std::optional<std::vector<std::int64_t>>& counts,
                       const std::optional<std::vector<double>>& fractions, std::optional<std::int64_t> samples) {
  const Rounds asked{proposals, f, method_of(method), allocation_of(counts, fractions, samples)};
  std::optional<double> variance;
  if (has_exact_moments(problem, asked.method))
    variance = exact_moments_of(problem, method, counts, fractions, samples).second;
  return Contender(std::move(name),
                   Contender::Run([asked](std::uint64_t rounds, std::span<double> values, ComparisonSource& source) {
                     std::vector<double> estimates(rounds);
                     std::size_t done = 0;
                     RoundValue sum{0.0, 0.0};
                     run_rounds(asked, rounds, source(), [&](const auto& used, std::size_t size, const Array& f_at) {
                       require_argument(f_at.ndim() == 1, "a comparison is for an integrand with one channel");
                       const double* const first = f_at.data();
                       const std::span<double> out = std::span(estimates).subspan(done, used.in_round.size());
                       write_rounds(
                           used, size, [&](std::size_t k) { return first[row_of(used, k)]; }, out);
                       done += out.size();
                       sum.density_evaluations += static_cast<double>(used.counts.density_evaluations);
                     });
                     for (std::size_t i = 0; i < rounds; ++i) {
                       sum.value += estimates[i];
                       if (i < values.size()) values[i] = estimates[i];
                     }
                     return sum;
                   }),
                   variance);
}

/// A contender of Python's: `rounds(count, seed)` returns the estimates of `count` rounds.
Contender own_contender(std::string name, const py::object& rounds_of) {
  return Contender(
      std::move(name),
      Contender::Run([rounds_of](std::uint64_t rounds, std::span<double> values, ComparisonSource& source) {
        RoundValue sum{0.0, std::numeric_limits<double>::quiet_NaN()};
        // A 32-bit seed: every generator of numpy takes one.
        const Array estimates = Array::ensure(rounds_of(rounds, source() >> 32U));
        if (!estimates) throw py::error_already_set();
        require_argument(numbers_of(estimates).size() == rounds, "a contender must return one estimate for each round");
        for (std::size_t i = 0; i < rounds; ++i) {
          sum.value += estimates.data()[i];
          if (i < values.size()) values[i] = estimates.data()[i];
        }
        return sum;
      }));
}

Comparison compare_all(const std::string& name, double integral, const std::vector<Contender>& contenders,
                       double seconds, std::uint64_t seed) {
  ComparisonSettings settings;
  settings.measure_seconds = seconds;
  settings.slice_seconds = seconds / 20.0;
  settings.seed = seed;
  return compare(name, integral, contenders, settings);
}

std::pair<Array, Array> arrays_of(const std::vector<QuadratureNode>& nodes) {
  std::vector<double> x, weights;
  for (const QuadratureNode& node : nodes) {
    x.push_back(node.x);
    weights.push_back(node.weight);
  }
  return {array_of(x), array_of(weights)};
}

}  // namespace
}  // namespace gmis::python

PYBIND11_MODULE(_mis, module) {
  using namespace gmis;
  using namespace gmis::python;
  using namespace py::literals;

  py::class_<Normals>(module, "Normals", "Normal proposals on the line, drawn and evaluated without a call of Python.")
      .def(py::init([](const Array& means, const Array& deviations) {
             return Normals(numbers_of(means), numbers_of(deviations));
           }),
           "means"_a, "deviations"_a)
      .def("__len__", &Normals::size);

  py::class_<GroupsOf>(module, "Groups", "The partial deterministic mixture in groups of `size` proposals.")
      .def(py::init<std::size_t>(), "size"_a)
      .def("__repr__", [](const GroupsOf& groups) { return "groups of " + std::to_string(groups.size); });
  py::class_<Balance>(module, "Balance", "w_i = d_i / Σ d.").def(py::init<>());
  py::class_<Power>(module, "Power", "w_i = d_i^beta / Σ d^beta.").def(py::init<double>(), "beta"_a = 2.0);
  py::class_<Cutoff>(module, "Cutoff", "Balance among densities of at least threshold times the largest.")
      .def(py::init<double>(), "threshold"_a = 0.1);
  py::class_<Maximum>(module, "Maximum", "All weight to the largest density.").def(py::init<>());

  module.def("estimate", &python::estimate);
  module.def("densities", &densities_at, "proposals"_a, "x"_a,
             "Densities of all proposals at x: a row for each proposal.");
  module.def("weights", &weights_at, "heuristic"_a, "counts"_a, "densities"_a,
             "Weights of all proposals at points; `densities` has a row for each proposal.");
  module.def(
      "line_rule",
      [](double centre, double scale, std::size_t panels, const std::vector<double>& breakpoints, std::size_t order) {
        return arrays_of(gauss_legendre_over_line(centre, scale, panels, breakpoints, order));
      },
      "centre"_a, "scale"_a, "panels"_a, "breakpoints"_a = std::vector<double>{}, "order"_a = 16,
      "Points and weights of a quadrature rule over the whole line, tails as heavy as 1/x² included.");
  module.def(
      "interval_rule",
      [](const std::vector<double>& breakpoints, std::size_t panels, std::size_t order) {
        return arrays_of(composite_gauss_legendre(breakpoints, panels, order));
      },
      "breakpoints"_a, "panels"_a, "order"_a = 16,
      "Points and weights of a quadrature rule over the intervals between breakpoints.");

  py::class_<TabulatedProblem>(module, "TabulatedProblem")
      .def(py::init([](const Array& values, const Array& weights, const Array& densities) {
        require_argument(values.ndim() == 1, "a problem is for an integrand with one channel: make one for each");
        const std::span<const double> f = numbers_of(values), q = numbers_of(densities);
        return TabulatedProblem(std::vector<double>(f.begin(), f.end()), numbers_of(weights),
                                std::vector<double>(q.begin(), q.end()));
      }))
      .def_property_readonly("integral", &TabulatedProblem::integral)
      .def("moments", &exact_moments_of)
      .def("optimal_fractions", [](const TabulatedProblem& problem, const std::vector<double>& costs,
                                   double least) { return array_of(gmis::optimal_fractions(problem, costs, least)); })
      .def("optimal_counts", [](const TabulatedProblem& problem, std::int64_t total, const std::vector<double>& costs) {
        require_argument(total > 0, "give a round at least one sample");
        return gmis::optimal_counts(problem, static_cast<std::size_t>(total), costs);
      });

  py::class_<Comparison>(module, "Comparison")
      .def("text", &Comparison::text)
      .def("csv", &Comparison::csv)
      .def("json", &Comparison::json)
      .def("__repr__", &Comparison::text);
  py::class_<Contender>(module, "Contender");
  module.def("contender", &contender_of, "name"_a, "problem"_a, "f"_a, "proposals"_a, "method"_a, "counts"_a,
             "fractions"_a, "samples"_a);
  module.def("own_contender", &own_contender);
  module.def("compare", &compare_all);
}
