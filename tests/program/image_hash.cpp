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
    {"--integrator pt", "c857090fb57696a9", "da9b9e0bae83f739"},
    {"--integrator lt", "15238bd36471c6c0", "d623d98e32901224"},
    {"--integrator bpt --connections 1", "cbff657aa1240dad", "eda5d54699d62dfd"},
    {"--integrator bpt --connections 2", "1bee8977aace3b12", "8ed0b43d104f2936"},
    {"--integrator bpt --connections 4", "4e7ef2797ca07c64", "a8a1a779dbaaa1f9"},
    {"--integrator bpt --connections paired", "a2213c29d51c9ed7", "605d104fca12922d"},
    {"--integrator ppm", "908fe40cecb58f3c", "0374bbe1065abbec"},
    {"--integrator bpm", "0dd982b06e195cca", "5f9352b9853fd759"},
    {"--integrator vcm --connections 1", "dc7a49164b768b60", "4009fb62a83b26f6"},
    {"--integrator vcm --connections 2", "dd1ba3b009d76de9", "830e6d2d663cf8f3"},
    {"--integrator vcm --connections 4", "99d224fb30bbc6af", "848ddd3024e541a5"},
    {"--integrator vcm --connections paired", "f4c6892a0ead399f", "0fb67a85017a9116"},
    {"--integrator gmis --split none --connections 1", "dc7a49164b768b60", "4009fb62a83b26f6"},
    {"--integrator gmis --split budgeted --connections 1", "a9c54d6ff0a34b8e", "6043062a9123108d"},
    {"--integrator gmis --split paper --scheme R2 --connections 2", "0376ee79d7f9f778", "e2c0b150030aafc8"},
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
