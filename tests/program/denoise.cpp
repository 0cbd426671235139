// `--denoise`: what Open Image Denoise is given, by a stand-in that shows it, and the refusal where
// the program is built without it.

#include "support/denoise.hpp"

#include <filesystem>
#include <string>

#include "program.hpp"
#include "support/catch.hpp"

namespace {
constexpr bool has_library = GMIS_HAS_OIDN != 0;
}

#undef GMIS_HAS_OIDN
#define GMIS_HAS_OIDN 1
#include "support/denoise.cpp"

TEST_CASE("The denoiser is given picture, albedo and normals") {
  using gmis::tools::Image;
  Image noisy(3, 2), albedo(3, 2), normal(3, 2);
  for (std::size_t i = 0; i < noisy.rgb.size(); ++i) {
    noisy.rgb[i] = static_cast<float>(i);
    albedo.rgb[i] = static_cast<float>(i % 2);
    normal.rgb[i] = static_cast<float>(i % 3);
  }
  const Image smooth = gmis::tools::denoised(noisy, albedo, normal);
  REQUIRE(smooth.rgb.size() == noisy.rgb.size());
  for (std::size_t i = 0; i < noisy.rgb.size(); ++i)
    CHECK(smooth.rgb[i] == noisy.rgb[i] + 10 * albedo.rgb[i] + 100 * normal.rgb[i]);

  try {
    static_cast<void>(gmis::tools::denoised(noisy, Image(2, 2), normal));
    FAIL("an albedo of another size passes");
  } catch (const gmis::tools::OutputError& error) {
    CHECK(std::string(error.what()).find("sizes differ: albedo") != std::string::npos);
  }
}

TEST_CASE("--denoise is refused before the work, or writes a picture beside each output") {
  const program::ScratchFolder folder;
  const auto outcome = program::run(folder, "cornell --size 8x8 --iterations 1 --quiet --denoise --out a.pfm");
  if (has_library) {
    CHECK(outcome.exit_code == 0);
    CHECK(std::filesystem::exists(folder / "a_denoised.pfm"));
    const auto twice = program::run(folder, "cornell --size 8x8 --denoise --out b.pfm --log b_denoised.pfm");
    CHECK(twice.exit_code == 2);
    CHECK(twice.err.find("--log b_denoised.pfm and --denoise b_denoised.pfm are the same file") != std::string::npos);
  } else {
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.err.find("--denoise: this program is built without Open Image Denoise") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder / "a.pfm"));
  }
}
