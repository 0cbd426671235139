// What accuracy costs: time and variance of every scheme, of groups of proposals and of types of
// number, as JSON; benches/schemes.py makes tables of it.
#include <cstdio>
#include <string>
#include <vector>

#include "gmis/benchmark.hpp"
#include "gmis/mis.hpp"
#include "schemes/numbers.hpp"
#include "schemes/problems.hpp"

namespace {

/// The comparisons of one kind over all problems, as a JSON array.
template <class Contenders>
std::string over_all_problems(std::size_t n, const gmis::ComparisonSettings& settings, const Contenders& contenders) {
  std::string result;
  for (const bench::Problem& problem : bench::problems) {
    const gmis::ComparedProblem over(problem.name, problem, problem.proposals(n), problem.nodes());
    result += (result.empty() ? "" : ",\n") + gmis::compare(over, contenders(over), settings).json();
  }
  return result;
}

std::string numbers(const gmis::ComparisonSettings& settings) {
  std::string result;
  for (const auto& part : {bench::numbers_of_estimators(settings), bench::numbers_of_path_weights(settings)})
    for (const bench::NumbersRow& row : part) {
      char line[240];
      std::snprintf(line, sizeof(line), R"({"what": "%s", "numbers": "%s", "ns": %.9g, "rms": %.9g, "largest": %.9g})",
                    row.what.c_str(), row.numbers.c_str(), row.nanoseconds, row.error_rms, row.error_largest);
      result += (result.empty() ? "" : ",\n") + std::string(line);
    }
  return result;
}

}  // namespace

int main() {
  const gmis::ComparisonSettings settings{.slices = 15};
  const auto schemes = over_all_problems(16, settings, [](const auto& over) { return over.schemes(); });
  const auto groups = over_all_problems(64, settings, [](const auto& over) {
    std::vector<gmis::Contender> contenders;
    for (std::size_t size = 1; size <= 64; size *= 2) contenders.push_back(over.groups(size));
    return contenders;
  });
  std::printf("{\"schemes\": [%s],\n\"groups\": [%s],\n\"numbers\": [%s]}\n", schemes.c_str(), groups.c_str(),
              numbers(settings).c_str());
  return 0;
}
