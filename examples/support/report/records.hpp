#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gmis/result/convergence_log.hpp"
#include "gmis/result/merging_bias.hpp"
#include "support/image/image.hpp"
#include "support/report/figures.hpp"
#include "support/report/metrics.hpp"

/// \file
/// The measurements of a comparison of integrators.

namespace gmis::tools {

/// One integrator with one seed.
struct RunRecord {
  std::uint64_t seed = 0;
  std::uint64_t iterations = 0;
  double cpu_seconds = 0;
  double wall_seconds = 0;
  std::string command;  ///< that renders the same again, with the same number of iterations
  std::vector<ConvergencePoint> points;
};

/// One integrator on one scene, with all seeds.
struct ContenderRecord {
  std::string name;
  bool is_merging = false;
  std::vector<RunRecord> runs;
  Image image;        ///< of the first seed, at the end
  Image pixel_error;  ///< its relative error pixel by pixel: against the reference, or estimated where there is none
  std::optional<MergingBias> bias;            ///< of the first seed's picture
  std::optional<PictureError> picture_error;  ///< of `image` against the reference, where there is one
  std::string file;                           ///< of the picture, in the report's folder; empty where none is written

  /// Error over processor seconds: against the reference, or estimated where there is none.
  [[nodiscard]] Courses courses() const {
    Courses all;
    for (const RunRecord& run : runs) {
      all.emplace_back();
      for (const ConvergencePoint& point : run.points)
        if (const auto error = point.reference_error ? point.reference_error : point.estimated_error)
          all.back().push_back({point.cpu_seconds, *error});
    }
    return all;
  }
};

struct SceneRecord {
  std::string name;
  std::string summary;
  Image reference;                        ///< empty where the errors are estimated
  std::string reference_file;             ///< in the report's folder; empty where none is written
  std::string reference_origin;           ///< where the reference is from, in words
  std::optional<double> reference_error;  ///< its own relative error, estimated, where it was made here
  std::vector<ContenderRecord> contenders;
};

struct Comparison {
  std::string limits;    ///< how long or how far every run went, in words
  std::string settings;  ///< depth, radius and the like, in words
  std::string machine;
  std::string version;
  std::size_t seeds = 0;
  bool is_whole = true;  ///< false when it was interrupted
  std::vector<SceneRecord> scenes;

  static constexpr const char* baseline = "vcm";
};

/// The integrator that efficiencies are relative to; null when it does not take part.
[[nodiscard]] inline const ContenderRecord* baseline_of(const SceneRecord& scene) {
  for (const ContenderRecord& contender : scene.contenders)
    if (contender.name == Comparison::baseline) return &contender;
  return nullptr;
}

}  // namespace gmis::tools
