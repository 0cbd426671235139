#include <cstring>
#include <vector>

#include "gmis/render/thread_executor.hpp"
#include "gmis/transport/allocation/engines_with_pilot.hpp"
#include "gmis/transport/allocation/render_engine.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/ways.hpp"

namespace {

/// Connections draw from the cache of all trees.
gmis_test::ways::Settings settings() {
  gmis_test::ways::Settings result;
  result.max_depth = 6;
  result.radius = 0.05;
  result.seed = gmis_test::seed(3);
  return result;
}

template <class I>
std::vector<float> frame_with(int threads, const gmis_test::ways::Settings& render_settings, int iterations) {
  const gmis_test::FurnaceScene<float> scene(0.7F, 1.0F, 40, 2);
  typename I::template Engine<gmis_test::FurnaceScene<float>> engine(scene, I::settings(render_settings));
  gmis::ThreadExecutor executor(threads);
  for (int i = 0; i < iterations; ++i) engine.iterate(executor);
  return {engine.frame().begin(), engine.frame().end()};
}

template <class I>
void check_threads(const gmis_test::ways::Settings& render_settings = settings(), int iterations = 2) {
  const auto one = frame_with<I>(1, render_settings, iterations);
  for (const int threads : {2, 7, 16}) {
    const auto many = frame_with<I>(threads, render_settings, iterations);
    CAPTURE(threads);
    CHECK(std::memcmp(one.data(), many.data(), one.size() * sizeof(float)) == 0);
  }
}

}  // namespace

TEST_CASE("the same seed gives the same bits for any number of threads") {
  using namespace gmis_test::ways;
  SECTION("pt") {
    check_threads<Pt>();
  }
  SECTION("bpt") {
    check_threads<Bpt>();
  }
  SECTION("lt") {
    check_threads<Lt>();
  }
  SECTION("ppm") {
    check_threads<Ppm>();
  }
  SECTION("bpm") {
    check_threads<Bpm>();
  }
  SECTION("vcm") {
    check_threads<Vcm>();
  }
  SECTION("vcm, a fixed number of connections from the cache") {
    auto cached = settings();
    cached.counts.connections = 3;
    check_threads<Vcm>(cached);
  }
  SECTION("vcm, connections paired") {
    auto paired = settings();
    paired.counts.connects_paired_tree = true;
    check_threads<Vcm>(paired);
  }
  SECTION("gmis") {
    check_threads<Gmis>();
  }
  SECTION("a pilot and the counts that it chooses") {
    const auto frames_with = [](int threads) {
      const gmis_test::FurnaceScene<float> scene(0.7F, 1.0F, 40, 2);
      gmis::RenderEngine<float> engine(gmis::engines_with_pilot(scene), settings(), gmis::all_candidates(), 64);
      gmis::ThreadExecutor executor(threads);
      std::vector<float> frames;
      for (int i = 0; i < 4; ++i) {
        engine.iterate(executor);
        const auto frame = engine.engine().frame();
        frames.insert(frames.end(), frame.begin(), frame.end());
      }
      return frames;
    };
    const auto one = frames_with(1);
    for (const int threads : {2, 7}) {
      const auto many = frames_with(threads);
      CAPTURE(threads);
      CHECK(std::memcmp(one.data(), many.data(), one.size() * sizeof(float)) == 0);
    }
  }
}

TEST_CASE("a pilot forecasts the same for any number of threads") {
  const gmis_test::FurnaceScene<float> scene(0.7F, 1.0F, 24, 2);
  const auto forecasts_with = [&](int threads) {
    gmis::RenderPilot<gmis_test::FurnaceScene<float>> pilot(scene, settings(), gmis::all_candidates(), 8);
    gmis::ThreadExecutor executor(threads);
    for (int i = 0; i < 2; ++i) pilot.iterate(executor);
    return pilot.forecasts();
  };
  const auto one = forecasts_with(1);
  for (const int threads : {2, 7}) {
    const auto many = forecasts_with(threads);
    CAPTURE(threads);
    REQUIRE(many.size() == one.size());
    int differences = 0;
    for (std::size_t c = 0; c < one.size(); ++c)
      differences += many[c].variance != one[c].variance || many[c].cost != one[c].cost;
    CHECK(differences == 0);
  }
}

TEST_CASE("other seeds and other iterations give other images") {
  const gmis_test::FurnaceScene<float> scene(0.7F, 1.0F, 8);
  using Engine = gmis::Engine<gmis_test::FurnaceScene<float>>;
  gmis::SerialExecutor executor;
  auto other = settings();
  other.seed = gmis_test::seed(4);
  Engine first(scene, settings()), second(scene, other);
  first.iterate(executor);
  second.iterate(executor);
  const std::vector<float> iteration1(first.frame().begin(), first.frame().end());
  CHECK(iteration1 != std::vector<float>(second.frame().begin(), second.frame().end()));
  first.iterate(executor);
  CHECK(iteration1 != std::vector<float>(first.frame().begin(), first.frame().end()));
}

TEST_CASE("a crop is the same rectangle of the whole image, bit by bit") {
  const gmis_test::FurnaceScene<float> scene(0.7F, 1.0F, 24, 2);
  using Gmis = gmis_test::ways::Gmis;
  using Engine = Gmis::Engine<gmis_test::FurnaceScene<float>>;
  gmis::SerialExecutor executor;
  const gmis::PixelBounds crop{{5, 3}, {17, 9}};
  Engine whole(scene, Gmis::settings(settings())), part(scene, Gmis::settings(settings()), crop);
  whole.iterate(executor);
  part.iterate(executor);
  int differences = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x) {
      const auto i = static_cast<std::size_t>(y * 24 + x);
      const bool inside = x >= crop.lower.x && x < crop.upper.x && y >= crop.lower.y && y < crop.upper.y;
      differences += part.frame()[i] != (inside ? whole.frame()[i] : 0.0F);
    }
  CHECK(differences == 0);
}

TEST_CASE("light trees without splitting are light paths, bit by bit") {
  using namespace gmis_test::ways;
  const auto paths = frame_with<Vcm>(1, settings(), 2);
  gmis_test::ways::Settings with_trees = settings();
  with_trees.sampler.budget = 1;  // a budget that allows no vertex of two lobes its two children
  const auto trees = frame_with<Gmis>(1, with_trees, 2);
  CHECK(std::memcmp(paths.data(), trees.data(), paths.size() * sizeof(float)) == 0);
}
