#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "program/block_statistics.hpp"
#include "support/build_scene.hpp"
#include "support/catch.hpp"
#include "support/choices.hpp"
#include "support/image/image.hpp"
#include "support/pbrt/reader.hpp"
#include "support/render.hpp"
#include "support/seed.hpp"

// Do the integrators agree with each other, and with images that renderers which share no code with
// this one have made?

using namespace gmis::tools;

namespace {

const std::filesystem::path references = GMIS_REFERENCE_FOLDER;
const std::filesystem::path scenes = GMIS_SCENE_FOLDER;

std::unique_ptr<BuiltScene> load(const std::filesystem::path& file, int size,
                                 gmis::scene::Masking masking = gmis::scene::Masking::height_correlated) {
  Diagnostics diagnostics;
  SceneDescription description = read_pbrt_scene(file, diagnostics);
  for (MaterialDescription& material : description.materials)
    if (auto* metal = std::get_if<ConductorDescription>(&material.kind)) metal->masking = masking;
  description.film.width = description.film.height = size;
  return build_scene(description, diagnostics);
}

RenderRequest request_for(const BuiltScene& scene, IntegratorChoice integrator, double radius, int max_depth) {
  Options options;
  RenderRequest request;
  request.integrator = options.integrator = integrator;
  request.split = options.split;
  request.expected_iterations = 64;
  request.settings.max_depth = max_depth;
  request.settings.radius = radius * scene.half_diagonal();
  request.settings.alpha = 0.75;
  set_counts(request, options, scene);
  return request;
}

/// `runs` independent images of `iterations` each: seeds `seed`, `seed` + 1, …
gmis_test::BlockStatistics blocks_of(const BuiltScene& scene, RenderRequest request, int block_size, int runs,
                                     std::uint32_t iterations, std::uint64_t seed) {
  const glm::ivec2 resolution = scene.scene().camera().resolution();
  gmis_test::BlockStatistics statistics(resolution, block_size);
  ThreadedExecutor executor(0);
  request.budget.iterations = iterations;
  std::vector<glm::vec3> frame(static_cast<std::size_t>(resolution.x * resolution.y));
  for (int run = 0; run < runs; ++run) {
    request.settings.seed = gmis_test::seed(seed + static_cast<std::uint64_t>(run));
    const RenderResult result = render(scene, request, executor);
    REQUIRE(result.counters.rejected_non_finite == 0);
    REQUIRE(result.counters.rejected_negative == 0);
    for (std::size_t i = 0; i < frame.size(); ++i) {
      frame[i] = {result.image.rgb[3 * i], result.image.rgb[3 * i + 1], result.image.rgb[3 * i + 2]};
      REQUIRE(gmis::is_finite(frame[i]));
    }
    statistics.add(frame);
  }
  return statistics;
}

}  // namespace

// Blocks of 16×16 pixels, three channels, all pairs of integrators: Welch's t per block and channel
// at the Šidák level of a false-alarm rate of 1e-3 for the whole family. Merging is biased: where
// it takes part, its bound is allowed for besides, 3 radii over half the scene's diagonal (0.9 % at
// the default radius of 0.003), which the next test shows to hold.
TEST_CASE("pt, bpt, vcm and gmis agree on the Cornell box") {
  const double radius = 0.003;
  const auto scene = load(scenes / "cornell.pbrt", 64);
  const std::vector<IntegratorChoice> integrators{IntegratorChoice::pt, IntegratorChoice::bpt, IntegratorChoice::vcm,
                                                  IntegratorChoice::gmis};
  std::vector<gmis_test::BlockStatistics> images;
  std::uint64_t seed = 1000;
  for (const IntegratorChoice integrator : integrators) {
    images.push_back(blocks_of(*scene, request_for(*scene, integrator, radius, 8), 16, 40,
                               integrator == IntegratorChoice::pt ? 24 : 8, seed));
    seed += 1000;
  }
  const std::size_t comparisons = 6 * images[0].count();
  const double level = gmis::sidak_level(1e-3, comparisons);
  for (std::size_t a = 0; a < images.size(); ++a)
    for (std::size_t b = a + 1; b < images.size(); ++b) {
      const bool merges = b >= 2;
      double smallest_p = 1.0, worst_difference = 0.0;
      for (std::size_t i = 0; i < images[a].count(); ++i) {
        const double bias = merges ? 3.0 * radius * images[a].mean(i) : 0.0;
        const double difference = std::max(0.0, std::abs(images[a].mean(i) - images[b].mean(i)) - bias);
        const double error = std::hypot(images[a].standard_error(i), images[b].standard_error(i));
        smallest_p = std::min(smallest_p, gmis::student_t_p_value(difference / error, images[a].frames() - 1.0));
        worst_difference = std::max(worst_difference, std::abs(images[a].mean(i) / images[b].mean(i) - 1.0));
      }
      INFO(name_of(integrators[a]) << " and " << name_of(integrators[b]) << ": smallest p " << smallest_p << ", level "
                                   << level << ", largest difference of a block " << worst_difference);
      CHECK(smallest_p > level);
    }
}

// The bias of merging: the mean over all blocks of |vcm − pt| with a radius that stays what it is
// (α = 1), less what noise makes of it. It must lie within the bound used above and fall with the
// radius.
TEST_CASE("merging's bias stays within its bound and falls with the radius") {
  const auto scene = load(scenes / "cornell.pbrt", 64);
  const auto truth = blocks_of(*scene, request_for(*scene, IntegratorChoice::pt, 0.003, 8), 16, 16, 128, 77000);
  double previous = 1e9;
  for (const double radius : {0.1, 0.025, 0.00625}) {
    RenderRequest request = request_for(*scene, IntegratorChoice::vcm, radius, 8);
    request.settings.alpha = 1.0;
    const auto merged = blocks_of(*scene, request, 16, 12, 8, 88000);
    double sum = 0.0, noise = 0.0, worst = 0.0;
    for (std::size_t i = 0; i < truth.count(); ++i) {
      const double difference = (merged.mean(i) - truth.mean(i)) / truth.mean(i);
      sum += difference * difference;
      noise += gmis::square(std::hypot(merged.standard_error(i), truth.standard_error(i)) / truth.mean(i));
      worst = std::max(worst, std::abs(difference) -
                                  4.5 * std::hypot(merged.standard_error(i), truth.standard_error(i)) / truth.mean(i));
    }
    const double count = static_cast<double>(truth.count());
    const double bias = std::sqrt(std::max(0.0, sum - noise) / count);
    const double uncertainty = std::sqrt(noise / count);
    CAPTURE(radius, bias, uncertainty, worst);
    CHECK(worst < 3.0 * radius);
    CHECK(bias < previous);
    previous = std::max(0.5 * bias, 2.0 * uncertainty);  // four times smaller a radius: less than half the bias
  }
}

namespace {

struct ReferenceCase {
  std::string name;
  gmis::scene::Masking masking;
  int runs;
  std::uint32_t iterations;
};

// Some thirty runs each, so that Student's t is near a normal deviate, and long enough for the 2 %
// to decide in most blocks.

/// One family: 256 blocks of 3 channels, 4 scenes, 2 integrators. A false alarm in a thousandth of
/// the seeds.
const double block_level = gmis::sidak_level(1e-3, 256 * 3 * 4 * 2);

/// Means of 8×8 blocks within the standard errors that the family allows, of the reference (from
/// its two halves) and of gmis together, or within 2 %, whichever is larger. Returns a description
/// of every block that is not.
std::vector<std::string> blocks_that_differ(const ReferenceCase& reference, IntegratorChoice integrator) {
  const auto scene = load(references / (reference.name + ".pbrt"), 128, reference.masking);
  const auto ours =
      blocks_of(*scene, request_for(*scene, integrator, 0.003, 10), 8, reference.runs, reference.iterations, 4000);
  const Image mean = read_image(references / (reference.name + ".pfm"));
  const Image a = read_image(references / (reference.name + "_a.pfm"));
  const Image b = read_image(references / (reference.name + "_b.pfm"));
  const auto at = [](const Image& image, int x, int y, int c) {
    return static_cast<double>(image.rgb[static_cast<std::size_t>(3 * (y * image.width + x) + c)]);
  };
  const auto expected = ours.block_means([&](int x, int y, int c) { return at(mean, x, y, c); });
  // Of one pixel: ((a − b)/2)² estimates the variance of the mean of both halves; of the mean of 64
  // pixels, a 64th of it.
  const auto variance = ours.block_means(
      [&](int x, int y, int c) { return gmis::square((at(a, x, y, c) - at(b, x, y, c)) / 2.0) / 64.0; });
  std::vector<std::string> different;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const double error = std::sqrt(variance[i] + gmis::square(ours.standard_error(i)));
    const double allowed =
        std::max(gmis::student_t_quantile(1 - block_level / 2, reference.runs - 1) * error, 0.02 * expected[i]);
    const double difference = ours.mean(i) - expected[i];
    if (std::abs(difference) > allowed)
      different.push_back("block " + std::to_string(i / 3 % 16) + "," + std::to_string(i / 48) + " channel " +
                          std::to_string(i % 3) + ": " + std::to_string(ours.mean(i)) + " for " +
                          std::to_string(expected[i]) + ", allowed ±" + std::to_string(allowed));
  }
  return different;
}

}  // namespace

TEST_CASE("vcm and gmis match the images that other renderers made") {
  // svcm0, svcm1: SmallVCM; tung1, tung2: an independent path tracer and Tungsten, whose GGX
  // multiplies the two Smith terms.
  using gmis::scene::Masking;
  const std::vector<ReferenceCase> cases{{"svcm0", Masking::height_correlated, 32, 12},
                                         {"svcm1", Masking::height_correlated, 32, 6},
                                         {"tung1", Masking::separable, 32, 8},
                                         {"tung2", Masking::separable, 32, 16}};
  for (const ReferenceCase& reference : cases)
    for (const IntegratorChoice integrator : {IntegratorChoice::vcm, IntegratorChoice::gmis}) {
      const auto different = blocks_that_differ(reference, integrator);
      std::string list;
      for (const std::string& block : different) list += "\n  " + block;
      INFO(reference.name << " with " << name_of(integrator) << ": " << different.size() << " of 768 differ" << list);
      CHECK(different.empty());
    }
}
