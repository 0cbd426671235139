#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "program.hpp"
#include "support/catch.hpp"

// Pictures with fixed counts, bit by bit: the same for g++ and clang, optimised or not, under the sanitizers, and for any number
// of threads (docs/numerics.md, "The same bits"). What changes them on purpose is pinned anew: build with both compilers, run
//   render_image_hash_test "[pin]"
// in both build folders, and replace the table where the two agree. The scene has no two surfaces that meet, so the order in
// which the tree holds them does not matter.

using namespace program;

namespace {

struct Pinned {
  const char* arguments;
  const char* hash;
};

const std::vector<Pinned> pinned{
    // clang-format off
    {"--integrator pt", "?"},
    {"--integrator lt", "?"},
    {"--integrator bpt --connections 1", "?"},
    {"--integrator bpt --connections 2", "?"},
    {"--integrator bpt --connections 4", "?"},
    {"--integrator bpt --connections paired", "?"},
    {"--integrator ppm", "?"},
    {"--integrator bpm", "?"},
    {"--integrator vcm --connections 1", "?"},
    {"--integrator vcm --connections 2", "?"},
    {"--integrator vcm --connections 4", "?"},
    {"--integrator vcm --connections paired", "?"},
    {"--integrator gmis --split none --connections 1", "?"},
    {"--integrator gmis --connections 1", "?"},
    {"--integrator gmis --connections paired --camera-split 2", "?"},
    {"--integrator gmis --split paper --scheme R2 --connections 2", "?"},
    // clang-format on
};

std::string hash_of(const ScratchFolder& folder, const std::string& arguments, int threads) {
  const Outcome outcome =
      run(folder, "'" GMIS_TEST_SCENE_FOLDER "/no_equal_hits.pbrt' --iterations 3 --seed 7 --max-depth 7 --quiet " +
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
    CHECK(hash_of(folder, picture.arguments, 1) == picture.hash);
    CHECK(hash_of(folder, picture.arguments, 5) == picture.hash);
  }
}

TEST_CASE("The table of hashes, as it would be pinned", "[.][pin]") {
  const ScratchFolder folder;
  for (const Pinned& picture : pinned)
    std::printf("    {\"%s\", \"%s\"},\n", picture.arguments, hash_of(folder, picture.arguments, 1).c_str());
}
