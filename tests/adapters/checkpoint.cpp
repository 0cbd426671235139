#include <stdexcept>
#include <string>

#include "gmis/render.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"

namespace {

using Furnace = gmis_test::FurnaceScene<float>;
using Render = gmis::Render<Furnace>;

const Furnace furnace(0.7F, 1.0F, 10, 2);

/// With a pilot of 4 iterations, unless `with_pilot` is false; then with everything that may be
/// kept.
gmis::RenderRequest request(bool with_pilot, std::uint32_t iterations = 9) {
  gmis::RenderSettings settings;
  settings.max_depth = 4;
  settings.radius = 0.05;
  settings.seed = gmis_test::seed(21);
  gmis::RenderRequest result = gmis::automatic_request(furnace, {.iterations = iterations}, 1, settings);
  result.scene_name = "furnace";
  result.halves = true;
  result.expected_iterations = 200 * iterations / 9;
  if (with_pilot) return result;
  result.candidates.clear();
  result.techniques = result.class_pictures = result.light_pictures = true;
  result.settings.path_classes = gmis::PathClassSet::all();
  return result;
}

std::string refusal(const gmis::RenderRequest& other, const std::vector<std::byte>& bytes) {
  Render render(furnace, other);
  try {
    render.resume(bytes);
  } catch (const std::invalid_argument& error) {
    // The rendering is as if nothing had been tried.
    gmis::SerialExecutor executor;
    CHECK(render.progress().iterations == 0);
    CHECK(render.advance(executor));
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a run that goes on from any of its iterations has the bits of one that was never interrupted") {
  gmis::SerialExecutor executor;
  for (const bool with_pilot : {true, false}) {
    const gmis::RenderResult whole = Render(furnace, request(with_pilot)).run(executor);
    REQUIRE(whole.iterations == 9);
    CHECK(whole.choice.has_value() == with_pilot);
    for (const int interrupted_after : {0, 1, 2, 6}) {  // before the pilot and after it
      INFO("pilot " << with_pilot << ", interrupted after " << interrupted_after);
      Render first(furnace, request(with_pilot));
      for (int i = 0; i < interrupted_after; ++i) REQUIRE(first.advance(executor));
      const std::vector<std::byte> bytes = first.checkpoint();
      // The run that goes on was asked for with another limit, which a pilot would choose
      // differently for.
      gmis::RenderRequest longer = request(with_pilot, 900);
      longer.budget.iterations = 9;
      Render second(furnace, longer);
      second.resume(bytes);
      CHECK(second.progress().iterations == static_cast<std::uint32_t>(interrupted_after));
      CHECK(second.checkpoint() == bytes);
      const gmis::RenderResult result = second.run(executor);
      CHECK(result.iterations == 9);
      CHECK(result.picture.values == whole.picture.values);
      CHECK(result.half_a.values == whole.half_a.values);
      CHECK(result.half_b.values == whole.half_b.values);
      CHECK(result.counts == whole.counts);
      CHECK(result.counters.contributions == whole.counters.contributions);
      CHECK(result.counters.rays == whole.counters.rays);
      CHECK(result.estimate.variance == whole.estimate.variance);
      CHECK(result.error->relative_error == whole.error->relative_error);
      REQUIRE(result.log.size() == whole.log.size());
      for (std::size_t i = 0; i < result.log.size(); ++i)
        CHECK(result.log[i].estimated_error == whole.log[i].estimated_error);
      REQUIRE(result.techniques.size() == whole.techniques.size());
      for (std::size_t i = 0; i < result.techniques.size(); ++i)
        CHECK(result.techniques[i].weighted.values == whole.techniques[i].weighted.values);
      REQUIRE(result.by_light.size() == whole.by_light.size());
      for (std::size_t i = 0; i < result.by_light.size(); ++i)
        CHECK(result.by_light[i].picture.values == whole.by_light[i].picture.values);
      REQUIRE(result.classes.classes.size() == whole.classes.classes.size());
      for (std::size_t i = 0; i < result.classes.classes.size(); ++i)
        CHECK(result.classes.classes[i].picture.values == whole.classes.classes[i].picture.values);
      if (with_pilot) {
        REQUIRE(result.choice.has_value());
        CHECK(result.choice->chosen == whole.choice->chosen);
        for (std::size_t i = 0; i < whole.choice->forecasts.size(); ++i) {
          CHECK(result.choice->forecasts[i].variance == whole.choice->forecasts[i].variance);
          CHECK(result.choice->forecasts[i].squared_bias == whole.choice->forecasts[i].squared_bias);
          CHECK(result.choice->forecasts[i].cost == whole.choice->forecasts[i].cost);
        }
      }
    }
  }
}

TEST_CASE("a checkpoint that does not fit is refused, and the message names what differs") {
  gmis::SerialExecutor executor;
  Render render(furnace, request(true));
  REQUIRE(render.advance(executor));
  const std::vector<std::byte> bytes = render.checkpoint();
  CHECK(refusal(request(true), bytes).empty());

  gmis::RenderRequest other = request(true);
  ++other.settings.seed;
  CHECK(refusal(other, bytes).find("the seed differs: ") != std::string::npos);
  other = request(true);
  other.scene_name = "kiln";
  CHECK(refusal(other, bytes).find("the scene differs: furnace, not kiln") != std::string::npos);
  other = request(true);
  other.settings.max_depth = 5;
  CHECK(refusal(other, bytes).find("the greatest depth differs: 4, not 5") != std::string::npos);
  other = request(true);
  other.crop = gmis::PixelBounds{{0, 0}, {5, 5}};
  CHECK(refusal(other, bytes).find("the crop differs: 0,0,10,10, not 0,0,5,5") != std::string::npos);
  other = request(true);
  other.candidates.pop_back();
  CHECK(refusal(other, bytes).find("the set of candidates differs") != std::string::npos);
  other = request(true);
  other.settings.radius = 0.06;
  CHECK(refusal(other, bytes).find("the merging radius differs: 0.05, not 0.06") != std::string::npos);
  other = request(true);
  other.halves = false;
  CHECK(refusal(other, bytes).find("what is kept differs") != std::string::npos);

  // Cut short anywhere, or with any byte changed.
  gmis::Philox source(gmis_test::seed(4));
  for (int i = 0; i < 200; ++i) {
    const std::size_t place = gmis::uniform_index(source, static_cast<std::uint32_t>(bytes.size()));
    Render fresh(furnace, request(true));
    CHECK_THROWS_AS(fresh.resume(std::span(bytes).first(place)), std::invalid_argument);
    std::vector<std::byte> damaged = bytes;
    damaged[place] ^= std::byte{0x10};
    CHECK_THROWS_AS(fresh.resume(damaged), std::invalid_argument);
  }
  std::vector<std::byte> longer = bytes;
  longer.push_back(std::byte{0});
  CHECK(refusal(request(true), longer).find("longer than it says") != std::string::npos);
  CHECK(refusal(request(true), {}).find("no checkpoint") != std::string::npos);
}
