#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "program.hpp"
#include "support/catch.hpp"
#include "support/image/formats.hpp"
#include "support/replay_text.hpp"

// What gmis-render does with contributions that are not finite, negative or of density zero, and
// how it shows one path.

using namespace program;
using Json = nlohmann::json;

namespace {

const std::string too_bright = "'" GMIS_TEST_SCENE_FOLDER "/too_bright.pbrt' --integrator vcm ";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// The numbers that follow `key` in a line.
std::vector<float> numbers_after(const std::string& line, const std::string& key, std::size_t count) {
  const std::size_t place = line.find(key);
  REQUIRE(place != std::string::npos);
  std::istringstream stream(line.substr(place + key.size()));
  std::vector<float> numbers(count);
  for (float& number : numbers) {
    std::string text;
    stream >> text;
    number = std::strtof(text.c_str(), nullptr);
  }
  return numbers;
}

std::string replay(const ScratchFolder& folder, const std::string& arguments, const std::string& path) {
  const Outcome outcome = run(folder, arguments + " --replay " + path);
  INFO(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  return outcome.out;
}

}  // namespace

TEST_CASE("Past the limit the run ends early with exit code 1, says why, and keeps a clean image") {
  const ScratchFolder folder;
  const std::string common =
      too_bright + "--connections 1 --iterations 1000 --list-rejected --quiet --out a.pfm --stats s.json";
  const Outcome one = run(folder, common + " --threads 1");
  const Json json = Json::parse(text_of(folder / "s.json"));
  CHECK(one.exit_code == 1);
  CHECK(line_count(one.err) == 1);
  CHECK(one.err.find("not finite") != std::string::npos);
  CHECK(one.err.find("the limit is 0.01 %") != std::string::npos);
  CHECK(json["stopped_by"] == "rejected");
  CHECK(json["iterations"] < 20);
  CHECK(json["rejected"]["non_finite"] > 25);  // n − 5 √n > 0 needs as many
  CHECK(json["rejected"]["limit"] == 1e-4);
  for (const float value : gmis::tools::read_image(folder / "a.pfm").rgb) {
    REQUIRE(std::isfinite(value));
    REQUIRE(value >= 0.0F);
  }

  // The same paths by any number of threads, and each of them shows when it is replayed what was
  // counted.
  const auto list = lines_of(one.out);
  REQUIRE(list.size() == 16);
  REQUIRE(json["rejected"]["paths"].size() == 16);
  CHECK(run(folder, common + " --threads 5").out == one.out);
  CHECK(one.err.find("--replay " + json["rejected"]["paths"][0]["path"].get<std::string>() + " ") != std::string::npos);
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{15}}) {
    const Json& rejected = json["rejected"]["paths"][i];
    const std::string path = rejected["path"];
    CAPTURE(path);
    CHECK(list[i].find("rejected " + path + " (") == 0);
    const std::string shown = replay(folder, common, path);
    int count = 0;
    std::string first;
    for (const std::string& line : lines_of(shown))
      if (line.find("REJECTED: not finite") != std::string::npos && ++count == 1) first = line;
    CHECK(count == rejected["count"]);
    CHECK(first.find(rejected["technique"].get<std::string>()) == 2);
  }
}

TEST_CASE("A path of a run that has narrowed its merging disk is replayed within that disk") {
  const ScratchFolder folder;
  const std::string same =
      "'" GMIS_TEST_SCENE_FOLDER "/../../../bench/scenes/tempting/telephoto.pbrt' --size 32x32 --iterations 12 ";
  REQUIRE(run(folder, same + "--quiet --out a.pfm --stats s.json").exit_code == 0);
  const Json json = Json::parse(text_of(folder / "s.json"));
  const double chosen = json["choice"]["chosen"]["radius_factor"], at_end = json["sample_counts"]["radius_factor"];
  REQUIRE(at_end < chosen);
  const double unit = json["radius"].get<double>() / at_end;
  for (const auto& [iteration, factor] : {std::pair(12, at_end), std::pair(3, chosen)}) {
    CAPTURE(iteration, factor);
    const std::string shown = replay(folder, same, std::to_string(iteration) + ":5");
    const auto lines = lines_of(shown);
    const auto line =
        std::find_if(lines.begin(), lines.end(), [](const auto& one) { return one.find("radius ") == 0; });
    REQUIRE(line != lines.end());
    CHECK(static_cast<double>(numbers_after(*line, "radius", 1)[0]) ==
          Approx(unit * factor * std::pow(iteration, (json["alpha"].get<double>() - 1) / 2)).epsilon(1e-5));
  }
}

TEST_CASE("What a pilot rejects is not missing in the picture") {
  // All counts but those of path tracing reject something here, as the cases below show; a pilot
  // has all techniques.
  const ScratchFolder folder;
  const std::string scene = "'" GMIS_TEST_SCENE_FOLDER "/too_bright.pbrt' --size 16x16 --integrator auto ";
  const Outcome outcome = run(folder, scene + "--iterations 4 --quiet --list-rejected --out a.pfm --stats s.json");
  CHECK(outcome.exit_code == 0);
  const Json json = Json::parse(text_of(folder / "s.json"));
  REQUIRE(json["choice"]["pilot_iterations"] == 2);
  REQUIRE(json["choice"]["chosen"]["light_paths"] == 0);
  CHECK(json["rejected"]["non_finite"] == 0);
  CHECK(line_count(outcome.out) == 0);
}

TEST_CASE("A sum that is left out, of contributions that are not, shows in the path") {
  gmis::ReplayedPath<glm::vec3> path;
  path.name = {gmis::PathKind::camera, 1, 0};
  path.vertices.emplace_back();
  path.contributions.emplace_back();
  const auto text = [&] { return gmis::tools::replay_text(path, {}, {1, 1}); };
  CHECK(text().find("REJECTED") == std::string::npos);
  path.counters.rejected_non_finite = 1;
  CHECK(lines_of(text()).back().find("REJECTED: not finite") != std::string::npos);
  path.contributions[0].vertex = 0;
  path.contributions[0].rejected = gmis::RejectionCause::non_finite;
  CHECK(lines_of(text()).back().find("REJECTED") == std::string::npos);
}

TEST_CASE("The limit is the user's") {
  const ScratchFolder folder;
  const std::string common = too_bright + "--iterations 3 --quiet --out a.pfm --stats s.json --max-rejected ";
  CHECK(run(folder, common + "0.9").exit_code == 0);
  Json json = Json::parse(text_of(folder / "s.json"));
  CHECK(json["iterations"] == 3);
  CHECK(json["rejected"]["non_finite"] > 100);
  CHECK(run(folder, common + "inf").exit_code == 0);
  json = Json::parse(text_of(folder / "s.json"));
  CHECK(json["rejected"]["limit"] == nullptr);
  // A path tracer's numbers stay within the range.
  CHECK(run(folder, "'" GMIS_TEST_SCENE_FOLDER "/too_bright.pbrt' --integrator pt --iterations 3 --quiet --out a.pfm "
                    "--max-rejected 0")
            .exit_code == 0);
  for (const char* bad : {"-1", "nan", "some"}) {
    const Outcome outcome = run(folder, "cornell --max-rejected " + std::string(bad));
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.err.find("--max-rejected") != std::string::npos);
  }
}

TEST_CASE("The paths of an iteration, replayed one by one, make its image bit by bit", "[long]") {
  const ScratchFolder folder;
  constexpr int width = 6, height = 5;
  const std::string common =
      "cornell --size 6x5 --integrator gmis --split budgeted --connections 1 --max-depth 5 --radius 0.5 --seed 4 ";
  REQUIRE(run(folder, common + "--iterations 1 --quiet --out a.pfm").exit_code == 0);
  const auto image = gmis::tools::read_image(folder / "a.pfm");
  fs::remove(folder / "a.pfm");

  std::vector<float> sum(image.rgb.size(), 0.0F);
  for (int pixel = 0; pixel < width * height; ++pixel) {
    // Both ways to name a pixel.
    const std::string name =
        pixel % 2 == 0 ? std::to_string(pixel) : std::to_string(pixel % width) + "," + std::to_string(pixel / width);
    const auto lines = lines_of(replay(folder, common + "--out a.pfm --stats s.json", "1:" + name));
    CHECK(lines.front().find("path        1:" + std::to_string(pixel) + ", pixel ") == 0);
    const auto value = numbers_after(lines.back(), "adds to its pixel ", 3);
    for (int c = 0; c < 3; ++c) sum[static_cast<std::size_t>(3 * pixel + c)] += value[static_cast<std::size_t>(c)];
  }
  int splats = 0;
  for (int tree = 0; tree < width * height; ++tree)
    for (const std::string& line : lines_of(replay(folder, common, "1:light:" + std::to_string(tree)))) {
      if (line.find("  splat ") != 0) continue;
      ++splats;
      int x = 0, y = 0;
      REQUIRE(std::sscanf(line.c_str() + line.find("to pixel "), "to pixel %d,%d", &x, &y) == 2);
      const auto value = numbers_after(line, "adds ", 3);
      for (int c = 0; c < 3; ++c)
        sum[static_cast<std::size_t>(3 * (y * width + x) + c)] += value[static_cast<std::size_t>(c)];
    }
  CHECK(splats > 10);
  CHECK(sum == image.rgb);
  CHECK_FALSE(fs::exists(folder / "a.pfm"));
  CHECK_FALSE(fs::exists(folder / "s.json"));
}

TEST_CASE("A path that there is not: exit code 2 and one line") {
  const ScratchFolder folder;
  struct Case {
    const char* path;
    const char* part;
  };
  for (const Case& c : std::vector<Case>{{"3", "ITERATION:PIXEL"},
                                         {"0:3", "from 1 on"},
                                         {"1:-3", "ITERATION:PIXEL"},
                                         {"1:3,", "ITERATION:PIXEL"},
                                         {"1:light:3,4", "ITERATION:light:TREE"},
                                         {"1:dark:3", "ITERATION:light:TREE"},
                                         {"99999999999:3", "ITERATION:PIXEL"},
                                         {"1:64", "no such pixel"},
                                         {"1:8,0", "no such pixel"},
                                         {"1:light:64", "no light tree 64: an iteration has 64"}}) {
    CAPTURE(c.path);
    const Outcome outcome = run(
        folder, "cornell --size 8x8 --integrator gmis --connections 1 --light-paths 1 --replay " + std::string(c.path));
    CHECK(outcome.exit_code == 2);
    CHECK(line_count(outcome.err) == 1);
    CHECK(outcome.err.find(c.part) != std::string::npos);
    CHECK(outcome.out.empty());
  }
  const Outcome cropped =
      run(folder, "cornell --size 8x8 --integrator gmis --connections 1 --crop 2,2,4,4 --replay 1:1,3");
  CHECK(cropped.exit_code == 2);
  CHECK(cropped.err.find("2,2 to 3,3") != std::string::npos);
}
