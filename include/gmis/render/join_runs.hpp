#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "gmis/render/checkpoint.hpp"
#include "gmis/render/run_record.hpp"

namespace gmis {

/// Joins runs of the same scene and request, each with a seed of its own, into one result: the
/// picture is the mean over the iterations of all, the error is estimated from the parts of all.
/// `checkpoints`: at least one, of either run's end or of any moment before. `request`: that of the
/// runs; its seed is ignored, and no rendering is done. `resolution`: of the camera. The iterations
/// of a run are independent of the iterations of the other runs. Only two things are worse than in
/// one run with all the iterations: every run spends time on a pilot of its own, and merging's
/// radius is that of the shorter runs.
///
/// Times are sums over the runs. The log is that of the longest run, with one point more for all
/// runs together.
///
/// Throws `std::invalid_argument`, which names the number of the checkpoint, from 1, and what
/// differs; and when two runs have the same seed: they would be the same samples twice.
template <Spectrum S>
[[nodiscard]] RenderResult join_runs(const RenderRequest& request, glm::ivec2 resolution,
                                     std::span<const std::vector<std::byte>> checkpoints) {
  require_argument(!checkpoints.empty(), "join_runs needs at least one checkpoint");
  const RunIdentity expected = identity_of(request, resolution, Film<S>::channel_count, sizeof(ScalarOf<S>));
  // Other bits of the same numbers are as good where samples are independent.
  constexpr std::array<std::string_view, 2> may_differ{RunIdentity::seed, RunIdentity::instruction_set};
  std::vector<std::string> seeds;
  RunRecord<S> all(request, resolution);
  for (std::size_t i = 0; i < checkpoints.size(); ++i) {
    RunRecord<S> one(request, resolution);
    const auto read = [&] {
      const Checkpoint checkpoint = open_checkpoint(checkpoints[i], expected, may_differ);
      StateReader state(checkpoint.state);
      one.exchange_state(state);
      if (state.is_broken() || one.state.iterations == 0) reject_argument("the checkpoint is damaged");
      seeds.push_back(checkpoint.identity.value_of(RunIdentity::seed));
    };
#if defined(__cpp_exceptions)
    try {
      read();
    } catch (const std::invalid_argument& error) {
      reject_argument(("checkpoint " + std::to_string(i + 1) + ": " + error.what()).c_str());
    }
#else
    read();
#endif
    for (std::size_t k = 0; k < i; ++k)
      if (seeds[k] == seeds[i])
        reject_argument(("checkpoints " + std::to_string(k + 1) + " and " + std::to_string(i + 1) +
                         " are of runs with the same seed, " + seeds[i] + ": the same samples twice")
                            .c_str());
    if (i == 0)
      all = std::move(one);
    else
      all.join(one);
  }

  const std::optional<ErrorEstimate> error = all.error();
  const std::vector<ConvergencePoint>& points = all.log.points();
  if (points.empty() || points.back().iteration < all.state.iterations) all.log.add(all.point(request, error));
  RenderResult result = all.result(request, StopReason::joined, error);
  for (const std::string& seed : seeds) {
    std::uint64_t number = 0;
    std::from_chars(seed.data(), seed.data() + seed.size(), number);
    result.joined_seeds.push_back(number);
  }
  return result;
}

}  // namespace gmis
