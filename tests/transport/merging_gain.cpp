#include "gmis/render/merging_gain.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "gmis/core/state_archive.hpp"
#include "gmis/render/render.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/sun_on_square.hpp"

// What later iterations multiply merging with so that the mean of the picture comes out right.

namespace {

/// Sum of r_i over the iterations from `first` to `last`, for r_1 = 1.
double radii(std::uint32_t first, std::uint32_t last, double alpha) {
  double sum = 0;
  for (std::uint32_t i = first; i <= last; ++i) sum += std::pow(i, 0.5 * (alpha - 1));
  return sum;
}

}  // namespace

TEST_CASE("The gain makes up for a bias in proportion to the radius, whenever it is chosen and however disks change") {
  for (const double alpha : {2.0 / 3, 0.75, 1.0})
    for (const double bias : {-0.3, 0.02, 0.11}) {
      CAPTURE(alpha, bias);
      constexpr std::uint32_t length = 64;
      constexpr double light = 0.7;  // merged by a disk without extent
      gmis::MergingGain gain;
      double of_disks = 0, factor = 0.08, mean = 0;  // of the radius
      for (std::uint32_t i = 1; i <= length; ++i) {
        const double radius = factor * std::pow(i, 0.5 * (alpha - 1));
        const double merged = (light + bias * radius) * (1 + gain.per_radius() * radius);
        of_disks += bias * radius;
        mean += merged / length;
        gain.add_iteration(merged, radius);
        if (i == 8) factor = 0.05;
        if (i == 4 || i == 8 || i == 16 || i == 32)
          gain.choose(of_disks, factor * radii(i + 1, length, alpha), factor * std::pow(i + 1, 0.5 * (alpha - 1)));
      }
      // The remaining bias is of second order: the bias of the light that the gain adds.
      const double without = std::abs(of_disks / length);
      CHECK(std::abs(mean - light) < 0.03 * without);
      CHECK(gain.made_up() == Approx(-of_disks).epsilon(0.03));
    }
}

TEST_CASE("The gain is none where nothing is known, and never large") {
  gmis::MergingGain gain;
  gain.choose(0.1, 3.0, 0.1);
  CHECK(gain.per_radius() == 0);  // nothing was merged
  for (int i = 0; i < 4; ++i) gain.add_iteration(0.5, 0.1);
  gain.choose(-0.02, 6.0, 0.1);
  CHECK(gain.per_radius() > 0);
  gmis::StateWriter writer;
  writer(gain);
  gmis::StateReader reader(writer.bytes());
  gmis::MergingGain read;
  reader(read);
  CHECK(read.per_radius() == gain.per_radius());
  gain.choose(-100, 6.0, 0.1);
  CHECK(gain.per_radius() * 0.1 == Approx(gmis::MergingGain::most_change));
  gain.choose(100, 6.0, 0.1);
  CHECK(gain.per_radius() * 0.1 == Approx(-gmis::MergingGain::most_change));
  gain.choose(-0.02, 0.0, 0.1);
  CHECK(gain.per_radius() == 0);  // nothing is to come
  gain.choose(0, 6.0, 0.1);
  CHECK(gain.per_radius() == 0);
}

TEST_CASE("An engine multiplies what it merges, and nothing else, and says how much it merged") {
  using Scene = gmis_test::FurnaceScene<float>;
  const Scene scene(0.6F, 1.0F, 12, 2);
  gmis::RenderSettings settings;
  settings.counts = gmis::integrators::vcm;
  settings.max_depth = 5;
  settings.radius = 0.2;
  settings.seed = gmis_test::seed(91);
  gmis::Engine<Scene> plain(scene, settings), scaled(scene, settings);
  scaled.scale_merging(0.5);
  gmis::SerialExecutor executor;
  for (int i = 0; i < 3; ++i) {
    std::array<double, gmis::technique_count> sums[2]{};
    for (auto* engine : {&plain, &scaled}) {
      engine->keep_contributions(true);
      engine->iterate(executor);
      engine->for_each_contribution([&](const gmis::Contribution<float>& one) {
        sums[engine == &scaled][static_cast<std::size_t>(one.id.technique)] +=
            static_cast<double>(one.value) * static_cast<double>(one.weight);
      });
    }
    const double factor = 1 + 0.5 * plain.merge_radius(plain.iteration());
    constexpr auto merge = static_cast<std::size_t>(gmis::Technique::merge);
    REQUIRE(sums[0][merge] > 0);
    for (std::size_t k = 0; k < gmis::technique_count; ++k)
      CHECK(sums[1][k] == Approx(sums[0][k] * (k == merge ? factor : 1.0)).epsilon(k == merge ? 1e-5 : 0));
    CHECK(plain.merged_light() == Approx(sums[0][merge]));
    CHECK(scaled.merged_light() == Approx(sums[1][merge]));
  }
}

TEST_CASE("A run makes up for what merging loses at the edges of a surface") {
  // What the run measures is 2 (L(ρ) − L(ρ/2)), so that at most 2 c ρ² is left; without a gain it
  // would be 4.2 %, or seven tenths of it where disks shrink.
  using namespace gmis_test::sun_on_square;
  const Scene scene = make_scene();
  gmis::RenderRequest request = merging_alone(GENERATE(1.0, 0.9), gmis_test::seed(92));
  request.expected_iterations = *request.budget.iterations;
  request.candidates.assign(2, request.settings.counts);
  gmis::SerialExecutor executor;
  const gmis::RenderResult result = gmis::Render(scene, request).run(executor);
  REQUIRE(result.choice.has_value());
  CHECK(result.counts.radius_factor == 1);  // the disk stays as it is
  REQUIRE(result.merging_bias.has_value());
  const double sure_of_bias = sure(result), off = result.estimate.mean / truth - 1;
  CAPTURE(off, noise(result), sure_of_bias, result.merging_bias->of_mean);
  // The gain was last chosen after 1024 of the 1600 iterations.
  const double sure_then = 1.25 * sure_of_bias;
  CHECK(std::abs(off) < noise(result) + sure_then + 2 * gmis::square(share * rho));
  CHECK(noise(result) + sure_of_bias < 0.6 * 4 * share * rho * (request.settings.alpha == 1.0 ? 1.0 : 0.7));
  // It says what is left, and what it has made up for.
  CHECK(std::abs(result.merging_bias->of_mean) < sure_of_bias);
  CHECK(result.merging_bias->made_up > 4 * share * rho * 0.5 - sure_of_bias);
}
