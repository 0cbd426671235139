#include <cmath>
#include <string>

#include "gmis/core/statistics.hpp"
#include "gmis/result/film.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/ways.hpp"

// The uniform furnace has a closed form at every depth, for every integrator, scalar and way of
// splitting. Each case compares the image mean, an average over iterations, with it, by Student's
// t: a false alarm of all cases together in a thousandth of the seeds; merging adds its bias, at
// most 1 % at radius 0.1 by the curvature.

namespace {

constexpr std::size_t comparisons = 200;
const double level = gmis::sidak_level(1e-3, comparisons);

struct Measured {
  double mean, standard_error;
  int iterations;
  gmis::Counters counters;
};

template <class I, class T>
Measured render(const gmis_test::FurnaceScene<T>& scene, const gmis_test::ways::Settings& settings, int iterations) {
  typename I::template Engine<gmis_test::FurnaceScene<T>> engine(scene, I::settings(settings));
  gmis::SerialExecutor executor;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    double mean = 0.0;
    for (const T value : engine.frame()) mean += static_cast<double>(value);
    mean /= static_cast<double>(engine.frame().size());
    sum += mean;
    squares += mean * mean;
  }
  const double mean = sum / iterations;
  const double variance = std::max(0.0, squares / iterations - mean * mean) / (iterations - 1);
  return {mean, std::sqrt(variance), iterations, engine.counters()};
}

/// The largest difference between a mean and its true value that chance explains at `level`.
double chance(const Measured& measured) {
  return gmis::student_t_quantile(1 - level / 2, measured.iterations - 1) * measured.standard_error;
}

double truth(double albedo, int depth) {
  double sum = 0.0;
  for (int i = 0; i < depth; ++i) sum += std::pow(albedo, i);
  return sum;
}

template <class I, class T>
void check(int lobes, double bias, gmis_test::ways::Settings settings = {}) {
  const double albedo = 0.7;
  const gmis_test::FurnaceScene<T> scene(T(albedo), T(1), 16, lobes);
  settings.radius = 0.1;
  settings.seed = gmis_test::seed(21);
  for (const int depth : {1, 2, 3, 4, 8}) {
    settings.max_depth = depth;
    const Measured measured = render<I>(scene, settings, 24);
    CAPTURE(depth, lobes, measured.mean, truth(albedo, depth), measured.standard_error);
    CHECK(std::abs(measured.mean - truth(albedo, depth)) < chance(measured) + bias * truth(albedo, depth) + 1e-6);
    CHECK(measured.counters.rejected_non_finite + measured.counters.rejected_negative == 0);
  }
}

}  // namespace

TEST_CASE("every integrator finds the closed form of the uniform furnace at every depth") {
  using namespace gmis_test::ways;
  SECTION("pt") {
    check<Pt, float>(1, 0.0);
  }
  SECTION("pt, double") {
    check<Pt, double>(2, 0.0);
  }
  SECTION("bpt") {
    check<Bpt, float>(1, 0.0);
  }
  SECTION("bpt, double") {
    check<Bpt, double>(2, 0.0);
  }
  SECTION("lt") {
    check<Lt, float>(1, 0.0);
  }
  SECTION("ppm") {
    check<Ppm, float>(1, 0.01);
  }
  SECTION("bpm") {
    check<Bpm, float>(1, 0.01);
  }
  SECTION("vcm") {
    check<Vcm, float>(1, 0.01);
  }
  SECTION("vcm, two lobes, connections paired") {
    gmis::RenderSettings settings;
    settings.counts.connects_paired_tree = true;
    check<Vcm, float>(2, 0.01, settings);
  }
  SECTION("vcm, two lobes") {
    check<Vcm, float>(2, 0.01);
  }
  SECTION("gmis, two lobes, budgeted") {
    check<Gmis, float>(2, 0.01);
  }
  SECTION("gmis, two lobes, small budget") {
    Settings settings;
    settings.sampler.budget = 5;
    settings.sampler.rounds = 2;
    check<Gmis, float>(2, 0.01, settings);
  }
  for (const gmis::Scheme scheme : gmis::all_schemes)
    SECTION("gmis, two lobes, scheme " + std::string(gmis::name_of(scheme))) {
      Settings settings;
      settings.sampler.scheme = scheme;
      check<Gmis, float>(2, 0.01, settings);
    }
  SECTION("gmis, double") {
    check<Gmis, double>(2, 0.01);
  }
}

TEST_CASE("where merging makes nearly all of the light it makes the right amount") {
  // Emitter hits and merging alone, with enough photons that merging has nine tenths of all that is
  // not seen directly: a wrong area of its disk or number of photons shows in full.
  gmis::RenderSettings settings;
  settings.max_depth = 4;
  settings.radius = 0.05;
  settings.alpha = 1.0;
  settings.counts.light_paths = 64.0;
  settings.seed = gmis_test::seed(22);
  const gmis_test::FurnaceScene<float> scene(0.7F, 1.0F, 16);
  const Measured measured = render<gmis_test::ways::Bpm>(scene, settings, 24);
  CAPTURE(measured.mean, measured.standard_error, truth(0.7, 4));
  CHECK(std::abs(measured.mean - truth(0.7, 4)) < chance(measured) + 0.003 * truth(0.7, 4));
  CHECK(measured.standard_error < 0.004 * truth(0.7, 4));  // so that 2 % would show
  CHECK(measured.counters.merges > measured.counters.camera_paths);
}

TEST_CASE("each iteration merges within the radius of its own") {
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
    double sum = 0.0, squares = 0.0;
    for (int run = 0; run < runs; ++run) {
      settings.seed = gmis_test::seed(static_cast<std::uint64_t>(1000 * last + run));
      gmis::Engine<gmis_test::FurnaceScene<float>> engine(scene, gmis_test::ways::Bpm::settings(settings));
      gmis::SerialExecutor executor;
      for (int i = 0; i < last; ++i) engine.iterate(executor);
      double mean = 0.0;
      for (const float value : engine.frame()) mean += static_cast<double>(value);
      mean /= static_cast<double>(engine.frame().size());
      sum += mean;
      squares += mean * mean;
    }
    const double mean = sum / runs;
    const Measured measured{mean, std::sqrt(std::max(0.0, squares / runs - mean * mean) / (runs - 1)), runs, {}};
    CAPTURE(last, measured.mean, measured.standard_error, truth(0.7, 4));
    CHECK(std::abs(measured.mean - truth(0.7, 4)) < chance(measured) + 0.003 * truth(0.7, 4));
    CHECK(measured.standard_error < 0.005 * truth(0.7, 4));
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
