#include <cmath>
#include <string>

#include "gmis/result/film.hpp"
#include "transport/ways.hpp"
#include "support/catch.hpp"
#include "transport/furnace_scene.hpp"

// The uniform furnace has a closed form at every depth, for every integrator, scalar and way of splitting.
// Each case compares the image mean, an average over iterations, with it: |mean − truth| < 4.5 standard errors, a false
// alarm in 7e-6 of the cases (some 100 here: 7e-4 in all); merging adds its bias, at most 1 % at radius 0.1 by the curvature.

namespace {

struct Measured {
  double mean, standard_error;
  gmis::Counters counters;
};

template <class I, class T>
Measured render(const gmis_test::FurnaceScene<T>& scene, const gmis::RenderSettings& settings, int iterations) {
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
  return {mean, std::sqrt(variance), engine.counters()};
}

double truth(double albedo, int depth) {
  double sum = 0.0;
  for (int i = 0; i < depth; ++i) sum += std::pow(albedo, i);
  return sum;
}

template <class I, class T>
void check(int lobes, double bias, gmis::RenderSettings settings = {}) {
  const double albedo = 0.7;
  const gmis_test::FurnaceScene<T> scene(T(albedo), T(1), 16, lobes);
  settings.radius = 0.1;
  for (const int depth : {1, 2, 3, 4, 8}) {
    settings.max_depth = depth;
    const Measured measured = render<I>(scene, settings, 24);
    CAPTURE(depth, lobes, measured.mean, truth(albedo, depth), measured.standard_error);
    CHECK(std::abs(measured.mean - truth(albedo, depth)) <
          4.5 * measured.standard_error + bias * truth(albedo, depth) + 1e-6);
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
    settings.counts.connections = gmis::paired_connections;
    check<Vcm, float>(2, 0.01, settings);
  }
  SECTION("vcm, two lobes") {
    check<Vcm, float>(2, 0.01);
  }
  SECTION("gmis, two lobes, budgeted") {
    check<Gmis, float>(2, 0.01);
  }
  SECTION("gmis, two lobes, small budget") {
    gmis::RenderSettings settings;
    settings.light_tree_budget = 5;
    settings.rounds = 2;
    check<Gmis, float>(2, 0.01, settings);
  }
  SECTION("gmis, two lobes, the camera subpath split too") {
    gmis::RenderSettings settings;
    settings.counts.camera_children = 4;
    check<Gmis, float>(2, 0.01, settings);
  }
  SECTION("gmis, two lobes, numbers of children as measured") {
    gmis::RenderSettings settings;
    settings.adapts_split = true;
    check<Gmis, float>(2, 0.01, settings);
  }
  for (const gmis::Scheme scheme : gmis::all_schemes)
    SECTION("gmis, two lobes, scheme " + std::string(gmis::name_of(scheme))) {
      gmis::RenderSettings settings;
      settings.scheme = scheme;
      check<Gmis, float>(2, 0.01, settings);
    }
  SECTION("gmis, double") {
    check<Gmis, double>(2, 0.01);
  }
}

TEST_CASE("where merging makes nearly all of the light it makes the right amount") {
  // Emitter hits and merging alone, with so many photons that merging has nine tenths of all that is not seen directly: a
  // wrong area of its disk or number of photons shows in full.
  gmis::RenderSettings settings;
  settings.max_depth = 4;
  settings.radius = 0.05;
  settings.alpha = 1.0;
  settings.counts.light_paths = 64.0;
  const gmis_test::FurnaceScene<float> scene(0.7F, 1.0F, 16);
  const Measured measured = render<gmis_test::ways::Bpm>(scene, settings, 24);
  CAPTURE(measured.mean, measured.standard_error, truth(0.7, 4));
  CHECK(std::abs(measured.mean - truth(0.7, 4)) < 4.5 * measured.standard_error + 0.003 * truth(0.7, 4));
  CHECK(measured.standard_error < 0.004 * truth(0.7, 4));  // so that 2 % would show
  CHECK(measured.counters.merges > measured.counters.camera_paths);
}
