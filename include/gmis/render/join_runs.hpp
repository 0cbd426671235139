#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gmis/render/checkpoint.hpp"
#include "gmis/render/run_record.hpp"

namespace gmis {

namespace detail {

/// Puts the parts of one run (`RenderRequest::part`) together, in any order: the record of that
/// run.
template <Spectrum S>
[[nodiscard]] RunRecord<S> whole_of_parts(const RenderRequest& request, glm::ivec2 resolution,
                                          std::vector<RunRecord<S>> parts) {
  std::sort(parts.begin(), parts.end(),
            [](const RunRecord<S>& a, const RunRecord<S>& b) { return a.part.first < b.part.first; });
  const auto refuse = [](std::uint32_t first, std::uint32_t last, const char* problem) {
    reject_argument(
        ("iterations " + std::to_string(first) + " to " + std::to_string(last) + " of the run " + problem).c_str());
  };
  RunRecord<S> whole(request, resolution);
  std::uint32_t expected = 1;
  RejectionLog rejections;
  for (RunRecord<S>& part : parts) {
    if (part.part.of != parts.front().part.of) reject_argument("the parts are of runs of different lengths");
    if (!(part.counts == parts.front().counts)) reject_argument("the pilots of the parts have chosen other counts");
    if (part.part.first > expected) refuse(expected, part.part.first - 1, "are missing");
    if (part.part.first < expected) refuse(part.part.first, expected - 1, "are there twice");
    expected = part.part.first + part.state.iterations;
    if (expected <= part.part.last)
      refuse(expected, part.part.last, "are missing: go on from the checkpoint of their part");
    if (&part == &parts.front()) {
      // All parts have run the same pilot: its work counts once.
      static_cast<RunFacts&>(whole) = part;
      whole.cpu_seconds = 0.0;
      whole.expected_law = part.expected_law;
      whole.light_work = part.light_work;
    } else {
      for (const KeptIteration<S>& one : part.kept) {
        whole.counters += one.numbers.work.counters;
        whole.light_work += one.numbers.work.light_work;
        whole.phases += one.numbers.work.seconds;
      }
    }
    whole.photon_bytes = std::max(whole.photon_bytes, part.photon_bytes);
    whole.film_seconds += part.film_seconds;
    for (const KeptIteration<S>& one : part.kept) {
      whole.add(one.result(), whole.film.pixel_count(), one.radius, 0.0);
      whole.state.seconds += part.state.seconds / part.state.iterations;
      whole.cpu_seconds += part.cpu_seconds / part.state.iterations - one.numbers.cpu_seconds;
      rejections.append(one.numbers.work.rejections);
      if (whole.log.is_due(whole.state.iterations)) whole.log.add(whole.point(request, whole.error()));
    }
  }
  if (expected <= parts.front().part.of) refuse(expected, parts.front().part.of, "are missing");
  whole.rejected_paths.assign(rejections.paths().begin(), rejections.paths().end());
  return whole;
}

}  // namespace detail

/// Joins runs of the same scene and request, each with a seed of its own, into one result: the
/// picture is the mean over the iterations of all, the error is estimated from the parts of all.
/// `checkpoints`: at least one, each taken at the end of a run or at any moment before. `request`:
/// that of the runs; its seed is ignored, and no rendering is done. `resolution`: of the camera.
/// `properties`: those of the engines (`EngineMaker::properties`). The iterations of a run are
/// independent of the iterations of the other runs. Only two things are worse than in one run with
/// all the iterations: every run spends time on a pilot of its own, and merging's radius is that of
/// the shorter runs.
///
/// Times are sums over the runs. The log is that of the longest run, with one point more for all
/// runs together.
///
/// Checkpoints may also be of the parts of one run (`RenderRequest::part`), in any order. Picture,
/// error and all statistics but times then have the bits of a run that was never divided.
///
/// Throws `std::invalid_argument`, which names the number of the checkpoint, from 1, and what
/// differs; when two runs have the same seed: they would be the same samples twice; when
/// iterations of a divided run are missing or there twice; and for a reference of another size than
/// the crop.
template <Spectrum S>
[[nodiscard]] RenderResult join_runs(const RenderRequest& request, glm::ivec2 resolution,
                                     std::span<const std::vector<std::byte>> checkpoints,
                                     const std::vector<std::pair<std::string, std::string>>& properties = {}) {
  require_argument(!checkpoints.empty(), "join_runs needs at least one checkpoint");
  RunIdentity expected = identity_of(request, resolution, Film<S>::channel_count, sizeof(ScalarOf<S>));
  for (const auto& [name, value] : properties) expected.add(name, value);
  // Other bits of the same numbers are as good where samples are independent.
  constexpr std::array<std::string_view, 3> may_differ{RunIdentity::seed, RunIdentity::instruction_set,
                                                       RunIdentity::part};
  std::vector<std::string> seeds, instruction_sets;
  std::vector<RunRecord<S>> parts;
  RunRecord<S> all(request, resolution);
  require_argument(
      request.reference.empty() || request.reference.size() == all.film.pixel_count() * Film<S>::channel_count,
      "RenderRequest::reference must have the pixels and channels of the crop");
  for (std::size_t i = 0; i < checkpoints.size(); ++i) {
    RunRecord<S> one(request, resolution);
    const auto read = [&] {
      const Checkpoint checkpoint = open_checkpoint(checkpoints[i], expected, may_differ);
      StateReader state(checkpoint.state);
      one.exchange_state(state);
      if (state.is_broken()) reject_argument("the checkpoint is damaged");
      if (one.state.iterations == 0) reject_argument("the checkpoint has no iteration yet");
      seeds.push_back(checkpoint.identity.value_of(RunIdentity::seed));
      instruction_sets.push_back(checkpoint.identity.value_of(RunIdentity::instruction_set));
      if (one.kept.empty() != parts.empty() && i > 0) reject_argument("parts of a run are joined with its parts alone");
      if (one.kept.empty()) return;
      if (one.kept.size() != one.state.iterations) reject_argument("the checkpoint is damaged");
      if (seeds[i] != seeds[0]) reject_argument("the seed of this part differs from that of checkpoint 1");
      if (instruction_sets[i] != instruction_sets[0])
        reject_argument("the instruction set of this part differs from that of checkpoint 1");
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
    if (!one.kept.empty()) {
      parts.push_back(std::move(one));
      continue;
    }
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

  if (!parts.empty()) {
    all = detail::whole_of_parts(request, resolution, std::move(parts));
    seeds.resize(1);
  }
  const std::optional<ErrorEstimate> error = all.error();
  const std::vector<ConvergencePoint>& points = all.log.points();
  if (points.empty() || points.back().iteration < all.state.iterations) all.log.add(all.point(request, error));
  RenderResult result = all.result(request, StopReason::joined, error, all.variances(request));
  for (const std::string& seed : seeds) {
    std::uint64_t number = 0;
    std::from_chars(seed.data(), seed.data() + seed.size(), number);
    result.joined_seeds.push_back(number);
  }
  return result;
}

}  // namespace gmis
