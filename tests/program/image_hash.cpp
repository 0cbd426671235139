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
    {"--integrator pt", "3f96870b3ed92567", "d276b1cf8206c0c4"},
    {"--integrator lt", "88665426eea08a52", "f897f5372ce06bad"},
    {"--integrator bpt --connections 1", "7d2777f5d91e0ab0", "5027e5d811072dec"},
    {"--integrator bpt --connections 2", "57a3a49f88b0a618", "787e07719ce22b95"},
    {"--integrator bpt --connections 4", "dd600aabae1d3ec3", "de291d9bc6ccab5e"},
    {"--integrator bpt --connections paired", "b4857d5349348519", "df5a12408bfcd839"},
    {"--integrator ppm", "73f50d5db804ed37", "36f489a76734c4a7"},
    {"--integrator bpm", "1b70283e25e8579d", "fd1241ad424585fd"},
    {"--integrator vcm --connections 1", "a88faed2e2d6c081", "cbe19edbb0ff797a"},
    {"--integrator vcm --connections 2", "f10dea171d30cde2", "0e2d1b578ae0dc87"},
    {"--integrator vcm --connections 4", "85d9e9557af97552", "e53e288b27e21aa1"},
    {"--integrator vcm --connections paired", "9cbc90859eaae192", "d67e1e2f33a0be0d"},
    {"--integrator gmis --split none --connections 1", "a88faed2e2d6c081", "cbe19edbb0ff797a"},
    {"--integrator gmis --split budgeted --connections 1", "ef07d76347fa3598", "3ddc06d05e4c594b"},
    {"--integrator gmis --split paper --scheme R2 --connections 2", "dba819de566e358d", "7e51919aac1fd51c"},
    // clang-format on
};

std::string hash_of(const ScratchFolder& folder, const std::string& arguments, int threads) {
  bool merges = false;
  for (const char* name : {"ppm", "bpm", "vcm", "gmis"})
    merges = merges || arguments.starts_with("--integrator " + std::string(name));
  const Outcome outcome =
      run(folder, "'" GMIS_TEST_SCENE_FOLDER "/no_equal_hits.pbrt' --iterations 3 --seed 7 --max-depth 7 --quiet " +
                      arguments + (merges ? " --radius 0.10936635635008926u" : "") +
                      " --sampler independent --threads " + std::to_string(threads) + " --out a.pfm --stats s.json");
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
