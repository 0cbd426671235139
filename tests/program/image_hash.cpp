#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "program.hpp"
#include "support/catch.hpp"
#include "support/instruction_set.hpp"

// Pictures with fixed counts, bit by bit: at one level of the processor the same for g++ and clang,
// optimised or not, under the sanitizers, and for any number of threads (docs/numerics.md, "The
// same bits"). What changes them on purpose is pinned anew: build with both compilers (presets
// release and clang, then portable and asan-ubsan), run
//   test_program_image_hash "[pin]"
// in the build folders, and replace the column of the level where the two compilers agree. The
// scene has no two surfaces that meet, so the order in which the tree holds them does not matter.

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
    {"--integrator pt", "a980661c81a446f8", "94c9cb91d37e9c89"},
    {"--integrator lt", "88665426eea08a52", "f897f5372ce06bad"},
    {"--integrator bpt --connections 1", "3f42ad9fd3c6e71b", "ae7820985643826f"},
    {"--integrator bpt --connections 2", "965cfcbe36322db4", "1bb4de54d995983c"},
    {"--integrator bpt --connections 4", "471678e8918025ef", "7161735952c03c1e"},
    {"--integrator bpt --connections paired", "647a5061063f9a05", "3b3b8a18669b53cf"},
    {"--integrator ppm", "73f50d5db804ed37", "36f489a76734c4a7"},
    {"--integrator bpm", "d723c0ac700c7cd2", "5d523594809a2ee7"},
    {"--integrator vcm --connections 1", "207a363b06b0b415", "830e54afe91120a5"},
    {"--integrator vcm --connections 2", "355794398f6d45b2", "c5ee738c329f1638"},
    {"--integrator vcm --connections 4", "1ff2fe3c40048eb9", "fab41114c41b7a51"},
    {"--integrator vcm --connections paired", "0395b106783027b9", "2ac0fbaec0a290ba"},
    {"--integrator gmis --split none --connections 1", "207a363b06b0b415", "830e54afe91120a5"},
    {"--integrator gmis --split budgeted --connections 1", "777e36c000dd0d7b", "b3350d7485d29401"},
    {"--integrator gmis --split paper --scheme R2 --connections 2", "d97bc2fbf546f84d", "65af1fff51899981"},
    // clang-format on
};

std::string hash_of(const ScratchFolder& folder, const std::string& arguments, int threads) {
  const Outcome outcome =
      run(folder, "'" GMIS_TEST_SCENE_FOLDER
                  "/no_equal_hits.pbrt' --iterations 3 --seed 7 --max-depth 7 --radius 0.10936635635008926u --quiet " +
                      arguments + " --sampler independent --threads " + std::to_string(threads) +
                      " --out a.pfm --stats s.json");
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
