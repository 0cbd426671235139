#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "program.hpp"
#include "support/catch.hpp"
#include "support/instruction_set.hpp"

// Pictures with fixed counts, bit by bit: at one level of the processor the same for g++ and clang, optimised or not, under the
// sanitizers, and for any number of threads (docs/numerics.md, "The same bits"). What changes them on purpose is pinned anew:
// build with both compilers (presets release and clang, then portable and asan-ubsan), run
//   render_image_hash_test "[pin]"
// in the build folders, and replace the column of the level where the two compilers agree. The scene has no two surfaces that meet, so the order in
// which the tree holds them does not matter.

using namespace program;

namespace {

struct Pinned {
  const char* arguments;
  const char* hash;     ///< x86-64
  const char* hash_v3;  ///< x86-64-v3: intersection rounds a product and a sum at once
  [[nodiscard]] const char* here() const { return gmis::tools::instruction_set == "x86-64-v3" ? hash_v3 : hash; }
};

const std::vector<Pinned> pinned{
    // clang-format off
    {"--integrator pt", "1d2549e1fe99bcc2"},
    {"--integrator lt", "b461257d4f4ff52a"},
    {"--integrator bpt --connections 1", "a231786cc4c56110"},
    {"--integrator bpt --connections 2", "df49693db49f520c"},
    {"--integrator bpt --connections 4", "7fc51bbcd7a75e73"},
    {"--integrator bpt --connections paired", "43cdd09c41e47588"},
    {"--integrator ppm", "5b138b2c87b4f7f6"},
    {"--integrator bpm", "1a251c25da6feb3c"},
    {"--integrator vcm --connections 1", "1a084487d2efd9d8"},
    {"--integrator vcm --connections 2", "cd68257bce708f9b"},
    {"--integrator vcm --connections 4", "d4f488ad2413bbb6"},
    {"--integrator vcm --connections paired", "082db2db0e42bdb0"},
    {"--integrator gmis --split none --connections 1", "1a084487d2efd9d8"},
    {"--integrator gmis --split budgeted --connections 1", "146c73d06f4ffa5d"},
    {"--integrator gmis --split budgeted --connections paired --camera-split 2", "99d2bc80652c0722"},
    {"--integrator gmis --split paper --scheme R2 --connections 2", "bd9d1f6779fc9a4a"},
    // clang-format on
};

std::string hash_of(const ScratchFolder& folder, const std::string& arguments, int threads) {
  const Outcome outcome =
      run(folder, "'" GMIS_TEST_SCENE_FOLDER
                  "/no_equal_hits.pbrt' --iterations 3 --seed 7 --max-depth 7 --radius 0.10936635635008926u --quiet " +
                      arguments + " --threads " + std::to_string(threads) + " --out a.pfm --stats s.json");
  INFO(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  return nlohmann::json::parse(text_of(folder / "s.json"))["image_hash"];
}

}  // namespace

TEST_CASE("Pictures with fixed counts have the bits that they had with every compiler") {
  const ScratchFolder folder;
  for (const Pinned& picture : pinned) {
    CAPTURE(picture.arguments);
    CHECK(hash_of(folder, picture.arguments, 1) == picture.here());
    CHECK(hash_of(folder, picture.arguments, 5) == picture.here());
  }
}

TEST_CASE("The table of hashes, as it would be pinned", "[.][pin]") {
  const ScratchFolder folder;
  for (const Pinned& picture : pinned)
    std::printf("    {\"%s\", \"%s\"},  // %s\n", picture.arguments, hash_of(folder, picture.arguments, 1).c_str(),
                gmis::tools::instruction_set.data());
}
