#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "gmis/result/error_estimate.hpp"
#include "gmis/result/image_error.hpp"
#include "support/catch.hpp"
#include "support/choices.hpp"
#include "support/load_scene.hpp"
#include "support/progressive_render.hpp"
#include "support/seed.hpp"
#include "support/session.hpp"

// Does a stated error mean what it says? Many small renderings of a scene; the truth of each is its
// own error against the mean of the others, of which there are many more.
// `./run bench stated_errors` does the same with more scenes and longer references.

using namespace gmis::tools;

namespace {

struct Calibration {
  std::vector<double> stated_over_true;
  int runs = 0, shown = 0, covered = 0;

  [[nodiscard]] double median() const {
    std::vector<double> sorted = stated_over_true;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

Calibration calibration_of(const std::filesystem::path& scene_file, IntegratorChoice integrator,
                           std::uint32_t iterations, std::array<int, 2> size, int runs) {
  const LoadedScene scene = load_scene(scene_file, size);
  Options options;
  options.connects_paired_tree = true;
  RenderRequest request;
  request.integrator = options.integrator = integrator;
  request.settings.max_depth = 6;
  request.settings.radius = 0.003 * scene.built->half_diagonal();
  set_counts(request, options, *scene.built);
  request.intervals = true;
  ThreadedExecutor executor(1);
  std::vector<Image> images;
  std::vector<gmis::ErrorEstimate> estimates;
  for (int run = 0; run < runs; ++run) {
    request.settings.seed = gmis_test::seed(500) + static_cast<std::uint64_t>(run);
    ProgressiveRender rendering(*scene.built, request);
    for (std::uint32_t i = 0; i < iterations; ++i) REQUIRE(rendering.advance(executor));
    images.push_back(rendering.image());
    const auto estimate = rendering.error();
    REQUIRE(estimate.has_value());
    estimates.push_back(*estimate);
  }
  // The sums of the even and of the odd runs: two references whose errors are independent, so that
  // the product of the differences to both has no part of either.
  const std::size_t values = images[0].rgb.size();
  std::vector<std::vector<double>> sums(2, std::vector<double>(values, 0.0));
  for (std::size_t run = 0; run < images.size(); ++run)
    for (std::size_t i = 0; i < values; ++i) sums[run % 2][i] += static_cast<double>(images[run].rgb[i]);
  Calibration result;
  result.runs = runs;
  for (std::size_t run = 0; run < images.size(); ++run) {
    double square = 0;
    for (std::size_t i = 0; i < values; ++i) {
      const double value = static_cast<double>(images[run].rgb[i]), count = runs / 2;
      const double own_half = (sums[run % 2][i] - value) / (count - 1), other = sums[1 - run % 2][i] / count;
      const double reference = (own_half + other) / 2;
      square += (value - own_half) * (value - other) / (reference * reference + gmis::relative_error_floor);
    }
    const double truth = std::sqrt(std::max(0.0, square / static_cast<double>(values)));
    const gmis::ErrorEstimate& estimate = estimates[run];
    result.stated_over_true.push_back(estimate.relative_error / truth);
    if (!estimate.is_calibrated()) continue;
    ++result.shown;
    if (estimate.interval.lower <= truth && truth <= estimate.interval.upper) ++result.covered;
  }
  return result;
}

std::ostream& operator<<(std::ostream& stream, const Calibration& calibration) {
  return stream << "stated / true " << calibration.median() << "; " << calibration.shown << " of " << calibration.runs
                << " intervals are shown, " << calibration.covered << " cover the true error";
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

/// The least number of `shown` intervals that cover the truth in all but 1 of 20,000 seeds, were
/// each to cover it with a probability of 95 %: 85 of 100.
int least_covered(int shown) {
  int covered = 0;
  double below = 0.0, here = std::pow(0.05, shown);  // probabilities of fewer, and of that many
  while (below + here <= 1.0 / 20000.0) {
    below += here;
    here *= 19.0 * (shown - covered) / (covered + 1.0);
    ++covered;
  }
  return covered;
}

}  // namespace

// At 16 iterations samples are still too rare for many intervals to be shown.
TEST_CASE("Without fireflies stated errors are true, and their intervals cover the truth") {
  const SceneFile sky(sky_over_balls), hall(glossy_hall);
  struct Case {
    const char* name;
    std::filesystem::path file;
  };
  for (const Case& c : {Case{"sky over balls", sky.path}, Case{"glossy hall", hall.path}}) {
    for (const std::uint32_t iterations : {16U, 64U}) {
      const Calibration calibration = calibration_of(c.file, IntegratorChoice::pt, iterations, {24, 24}, 100);
      INFO(c.name << ", " << iterations << " iterations: " << calibration);
      CHECK(calibration.median() > 0.9);
      CHECK(calibration.median() < 1.15);
      if (iterations >= 64) CHECK(calibration.shown >= 80);
      CHECK(calibration.covered >= least_covered(calibration.shown));
    }
  }
}

// What has not been seen cannot be estimated: path tracing meets the caustics of this scene so
// rarely that many runs know little of them. Then there must be no interval.
TEST_CASE("With fireflies there is no interval") {
  const Calibration calibration = calibration_of(scenes / "paper1.pbrt", IntegratorChoice::pt, 64, {24, 24}, 40);
  INFO(calibration);
  CHECK(calibration.shown <= 4);
  CHECK(calibration.median() > 0.7);
}
