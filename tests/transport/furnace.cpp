#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "gmis/core/statistics.hpp"
#include "gmis/result/film.hpp"
#include "support/catch.hpp"
#include "support/family.hpp"
#include "support/seed.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/mean_of_iterations.hpp"
#include "transport/ways.hpp"

// The uniform furnace has a closed form at every depth, for every integrator, scalar and way of
// splitting. Each case compares the image mean, an average over iterations, with it, by Student's
// t: a false alarm of all cases together in a thousandth of the seeds.
//
// Merging is biased by the curvature, and the bias has a bound. The part of a sphere of radius 1
// within the distance r of a point of it has the area π r² exactly, so the number of photons is
// right. But the normal at the distance d is turned by an angle whose cosine is 1 - d²/2, and a
// share of the light there, half of 1 less this cosine or d²/4, comes from below the surface at
// the point: black. The mean over the disk, where d² is r²/2, is r²/8 of the merged light.

namespace {

constexpr int iterations = 64;
constexpr std::size_t sections = 19, depths = 5;
// The sections at every depth, merging alone, and the second and third iteration.
gmis_test::Family family(1e-3, sections* depths + 1 + 2);

/// The share of the merged light that the curvature takes away.
double merging_bias(double radius) {
  return radius * radius / 8;
}

template <class I, class T>
gmis_test::Mean render(const gmis_test::FurnaceScene<T>& scene, const gmis_test::ways::Settings& settings) {
  typename I::template Engine<gmis_test::FurnaceScene<T>> engine(scene, I::settings(settings));
  return gmis_test::mean_of_iterations(engine, iterations);
}

/// The largest difference between a mean and its true value that chance explains.
double chance(double standard_error, std::size_t count = iterations) {
  return family.limit(count) * standard_error;
}

double truth(double albedo, int depth) {
  double sum = 0.0;
  for (int i = 0; i < depth; ++i) sum += std::pow(albedo, i);
  return sum;
}

template <class I, class T>
void check(int lobes, gmis_test::ways::Settings settings = {}) {
  const double albedo = 0.7;
  const gmis_test::FurnaceScene<T> scene(T(albedo), T(1), 16, lobes);
  settings.radius = 0.1;
  settings.seed = gmis_test::seed(21);
  const double bias = I::has(gmis::Technique::merge) ? merging_bias(settings.radius.value()) : 0.0;
  for (const int depth : {1, 2, 3, 4, 8}) {
    settings.max_depth = depth;
    const gmis_test::Mean measured = render<I>(scene, settings);
    const double expected = truth(albedo, depth), by_chance = chance(measured.standard_error);
    CAPTURE(depth, lobes, measured.value, expected, measured.standard_error);
    // Photons make what has been reflected; in a picture of constant pixels float rounds.
    CHECK(std::abs(measured.value - expected) < by_chance + bias * (expected - 1.0) + 1e-6);
    CHECK(by_chance < 0.08 * expected);  // so that 8 % would show in every case
    CHECK(measured.counters.rejected_non_finite + measured.counters.rejected_negative == 0);
  }
}

}  // namespace

TEST_CASE("every integrator finds the closed form of the uniform furnace at every depth") {
  using namespace gmis_test::ways;
  SECTION("pt") {
    check<Pt, float>(1);
  }
  SECTION("pt, double") {
    check<Pt, double>(2);
  }
  SECTION("bpt") {
    check<Bpt, float>(1);
  }
  SECTION("bpt, double") {
    check<Bpt, double>(2);
  }
  SECTION("lt") {
    check<Lt, float>(1);
  }
  SECTION("ppm") {
    check<Ppm, float>(1);
  }
  SECTION("bpm") {
    check<Bpm, float>(1);
  }
  SECTION("vcm") {
    check<Vcm, float>(1);
  }
  SECTION("vcm, two lobes, connections paired") {
    gmis::RenderSettings settings;
    settings.counts.connects_paired_tree = true;
    check<Vcm, float>(2, settings);
  }
  SECTION("vcm, two lobes") {
    check<Vcm, float>(2);
  }
  SECTION("gmis, two lobes, budgeted") {
    check<Gmis, float>(2);
  }
  SECTION("gmis, two lobes, small budget") {
    Settings settings;
    settings.sampler.budget = 5;
    settings.sampler.rounds = 2;
    check<Gmis, float>(2, settings);
  }
  for (const gmis::Scheme scheme : gmis::all_schemes)
    SECTION("gmis, two lobes, scheme " + std::string(gmis::name_of(scheme))) {
      Settings settings;
      settings.sampler.scheme = scheme;
      check<Gmis, float>(2, settings);
    }
  SECTION("gmis, double") {
    check<Gmis, double>(2);
  }
}

TEST_CASE("where merging makes nearly all of the light it makes the right amount", "[long]") {
  // Emitter hits and merging alone, with enough photons that merging has nine tenths of all that is
  // not seen directly: a wrong area of its disk or number of photons shows in full.
  gmis::RenderSettings settings;
  settings.max_depth = 4;
  settings.radius = 0.05;
  settings.alpha = 1.0;
  settings.counts.light_paths = 64.0;
  settings.seed = gmis_test::seed(22);
  const gmis_test::FurnaceScene<float> scene(0.7F, 1.0F, 16);
  const gmis_test::Mean measured = render<gmis_test::ways::Bpm>(scene, settings);
  const double expected = truth(0.7, 4), by_chance = chance(measured.standard_error);
  CAPTURE(measured.value, measured.standard_error, expected);
  CHECK(std::abs(measured.value - expected) < by_chance + merging_bias(settings.radius.value()) * (expected - 1.0));
  CHECK(by_chance < 0.01 * expected);  // so that 2 % of the merged light would show
  CHECK(measured.counters.merges > measured.counters.camera_paths);
}

TEST_CASE("each iteration merges within the radius of its own", "[long]") {
  // As above, with a radius that shrinks fast, iterations 2 and 3 of many runs: photons found
  // within the radius of the iteration before would be 1.7 and 1.4 times too many, photons divided
  // by the number of another disk likewise.
  gmis::RenderSettings settings;
  settings.max_depth = 4;
  settings.radius = 0.08;
  settings.alpha = 0.2;
  settings.counts.light_paths = 64.0;
  const gmis_test::FurnaceScene<float> scene(0.7F, 1.0F, 8);
  constexpr int runs = 60;
  for (const int last : {2, 3}) {
    gmis_test::Series measured;
    for (int run = 0; run < runs; ++run) {
      settings.seed = gmis_test::seed(static_cast<std::uint64_t>(1000 * last + run));
      gmis::Engine<gmis_test::FurnaceScene<float>> engine(scene, gmis_test::ways::Bpm::settings(settings));
      gmis::SerialExecutor executor;
      for (int i = 0; i < last; ++i) engine.iterate(executor);
      measured.add(gmis_test::mean_of_pixels(engine.frame()));
    }
    const double expected = truth(0.7, 4), by_chance = chance(measured.standard_error(), runs);
    CAPTURE(last, measured.mean(), measured.standard_error(), expected);
    CHECK(std::abs(measured.mean() - expected) < by_chance + merging_bias(settings.radius.value()) * (expected - 1.0));
    CHECK(by_chance < 0.03 * expected);
  }
}

TEST_CASE("iterations added up in a film, with few lines") {
  const gmis_test::FurnaceScene<float> scene(0.7F, 1.0F, 8);
  gmis::RenderSettings settings;
  settings.seed = gmis_test::seed(23);
  settings.counts = gmis::integrators::bpt;
  gmis::Engine<gmis_test::FurnaceScene<float>> engine(scene, settings);
  gmis::Film<float> film(scene.camera().resolution());
  gmis::SerialExecutor executor;
  for (int i = 0; i < 4; ++i) {
    engine.iterate(executor);
    film.add_iteration(engine.frame());
  }
  gmis::Engine<gmis_test::FurnaceScene<float>> again(scene, settings);
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    again.iterate(executor);
    sum += static_cast<double>(again.frame()[5]);
  }
  CHECK(film.iterations() == 4);
  CHECK(film.mean(5, 0) == Approx(sum / 4));
}
