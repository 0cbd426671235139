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
    {"--integrator pt", "c718a256c41bdee3", "faf5aec42e60abcb"},
    {"--integrator lt", "1389812d6df2e4a2", "b49fd7efb21e54c9"},
    {"--integrator bpt --connections 1", "de7b629b1f37685c", "c0e6c236432dcc81"},
    {"--integrator bpt --connections 2", "5c413c574e0392fc", "acc258c95cfa1d5b"},
    {"--integrator bpt --connections 4", "a23dba06a26bd6c2", "1932f4e0dc7eeaf4"},
    {"--integrator bpt --connections paired", "332800a9ec4de18c", "1afd415b644e3429"},
    {"--integrator ppm", "397fa2341ff79ee0", "7d4de068d6e85a71"},
    {"--integrator bpm", "16296b7047ed86aa", "fb8138c88c157142"},
    {"--integrator vcm --connections 1", "f54bc97bb45dad79", "0f664971b7f55670"},
    {"--integrator vcm --connections 2", "e7f4321bbeb16c79", "c4601a1935334646"},
    {"--integrator vcm --connections 4", "424b01f7bc563129", "f8f9a2b17e3eab10"},
    {"--integrator vcm --connections paired", "4a1081b5626c326c", "fb749330edceaff7"},
    {"--integrator gmis --split none --connections 1", "f54bc97bb45dad79", "0f664971b7f55670"},
    {"--integrator gmis --split budgeted --connections 1", "fdad0b67962956a7", "c7e9cdd76e814ea8"},
    {"--integrator gmis --split budgeted --connections paired --camera-split 2", "fb7f33e54b971525", "3fbefd5e4403f196"},
    {"--integrator gmis --split paper --scheme R2 --connections 2", "3f287ca24f9d12e8", "e69349fcb0cf6bab"},
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
