#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "support/catch.hpp"
#include "support/progressive_render.hpp"
#include "support/seed.hpp"
#include "support/session.hpp"

// Does the interval around an estimated error mean what it says? A thousand small renderings of a scene, a few pixels
// each; the truth is what all of them together say, which is a thousand times longer a run. The number of intervals that
// cover it is binomial: were the coverage exactly 95 %, 0.4 % of all seeds would give less than 93 % or more than 97 %, and
// 1.2 % would on one of the three scenes. The seeds are fixed.

using namespace gmis::tools;

namespace {

struct Coverage {
  int covered = 0, too_low = 0, too_high = 0, unknown = 0;
  double truth = 0;
};

Coverage coverage_of(const std::filesystem::path& scene_file, IntegratorChoice integrator, std::uint32_t iterations,
                     std::array<int, 2> size, int runs) {
  const LoadedScene scene = load_scene(scene_file, size);
  RenderRequest request;
  request.integrator = integrator;
  request.settings.max_depth = 6;
  request.settings.radius = 0.003 * scene.built->half_diagonal();
  request.settings.connections = gmis::paired_connections;
  request.intervals = true;
  ThreadedExecutor executor(1);
  gmis::Film<FrameSource::Spectrum> all({size[0], size[1]});
  std::vector<std::optional<gmis::Interval>> intervals;
  for (int run = 0; run < runs; ++run) {
    request.settings.seed = gmis_test::seed(500 + static_cast<std::uint64_t>(run));
    ProgressiveRender rendering(*scene.built, request);
    for (std::uint32_t i = 0; i < iterations; ++i) {
      REQUIRE(rendering.advance(executor));
      all.add_iteration(rendering.frame());
    }
    intervals.push_back(rendering.interval());
  }
  Coverage coverage;
  // The variance of the mean of all runs is that of one run over their number.
  coverage.truth = gmis::estimate_of(all).relative_error * std::sqrt(static_cast<double>(runs));
  for (const auto& interval : intervals) {
    if (!interval)
      ++coverage.unknown;
    else if (interval->upper < coverage.truth)
      ++coverage.too_low;
    else if (interval->lower > coverage.truth)
      ++coverage.too_high;
    else
      ++coverage.covered;
  }
  return coverage;
}

std::ostream& operator<<(std::ostream& stream, const Coverage& coverage) {
  return stream << "the true error is " << coverage.truth << "; " << coverage.covered << " intervals cover it, "
                << coverage.too_low << " are below, " << coverage.too_high << " above, " << coverage.unknown
                << " are not known";
}

const std::filesystem::path scenes = GMIS_SCENE_FOLDER;

/// A file that is gone at the end.
struct SceneFile {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("gmis_calibration_" + std::to_string(std::random_device{}()) + ".pbrt");
  explicit SceneFile(const std::string& text) { std::ofstream(path) << text; }
  ~SceneFile() {
    std::error_code error;
    std::filesystem::remove(path, error);
  }
};

const std::string sky_over_balls = R"(
LookAt 0 2 -7  0 .8 0  0 1 0
Camera "perspective" "float fov" 30
WorldBegin
LightSource "infinite" "rgb L" [ .5 .6 .9 ]
LightSource "distant" "point3 from" [ 3 5 -4 ] "point3 to" [ 0 0 0 ] "rgb L" [ 2 1.8 1.5 ]
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "bilinearmesh" "point3 P" [ -9 0 -9  9 0 -9  -9 0 9  9 0 9 ]
AttributeBegin
  Material "diffuse" "rgb reflectance" [ .7 .2 .1 ]
  Translate -1 1 0
  Shape "sphere" "float radius" 1
AttributeEnd
AttributeBegin
  Material "diffuse" "rgb reflectance" [ .1 .4 .6 ]
  Translate 1.2 .8 -.5
  Shape "sphere" "float radius" .8
AttributeEnd
)";

const std::string glossy_hall = R"(
LookAt 0 1 -2.8  0 1 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
Material "conductor" "rgb reflectance" [ .8 .7 .5 ] "float roughness" .4
Shape "bilinearmesh" "point3 P" [ -1 0 -3  1 0 -3  -1 0 1  1 0 1 ]
Material "diffuse" "rgb reflectance" [ .6 .6 .65 ]
Shape "bilinearmesh" "point3 P" [ -1 0 1  1 0 1  -1 2 1  1 2 1 ]
Shape "bilinearmesh" "point3 P" [ -1 0 -3  -1 0 1  -1 2 -3  -1 2 1 ]
Shape "bilinearmesh" "point3 P" [ 1 0 -3  1 0 1  1 2 -3  1 2 1 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
AreaLightSource "diffuse" "rgb L" [ 3 3 3 ]
Shape "bilinearmesh" "point3 P" [ -1 2 -3  1 2 -3  -1 2 1  1 2 1 ]
)";

}  // namespace

TEST_CASE("The 95 % interval covers the true error in 93 to 97 % of 1,000 runs on scenes without fireflies") {
  const SceneFile sky(sky_over_balls), hall(glossy_hall);
  struct Case {
    const char* name;
    std::filesystem::path file;
    IntegratorChoice integrator;
  };
  const std::vector<Case> cases{{"cornell", scenes / "cornell.pbrt", IntegratorChoice::bpt},
                                {"sky over balls", sky.path, IntegratorChoice::pt},
                                {"glossy hall", hall.path, IntegratorChoice::pt}};
  for (const Case& c : cases) {
    const Coverage coverage = coverage_of(c.file, c.integrator, 64, {3, 3}, 1000);
    INFO(c.name << ": " << coverage);
    CHECK(coverage.covered >= 930);
    CHECK(coverage.covered <= 970);
  }
}

// What has not been seen cannot be estimated: path tracing meets the caustics of this scene so rarely that most runs know
// nothing of them. The interval is then too low, never too high. That it is stays on record here.
TEST_CASE("With fireflies the interval covers the true error in half of the runs only") {
  const Coverage coverage = coverage_of(scenes / "paper1.pbrt", IntegratorChoice::pt, 64, {3, 3}, 1000);
  INFO(coverage);
  CHECK(coverage.covered > 300);
  CHECK(coverage.covered < 700);
  CHECK(coverage.too_high < 25);
}
