// Endings of files in capitals.

#include <fstream>
#include <string>

#include "program.hpp"
#include "support/catch.hpp"
#include "support/image/formats.hpp"
#include "support/image/image.hpp"

using namespace program;

TEST_CASE("The ending of a file means the same in capitals") {
  using namespace gmis::tools;
  const ScratchFolder folder;
  const std::string small = "cornell --size 8x8 --iterations 2 ";
  if (has_exr()) {
    const Outcome layers = run(folder, small + "--out L.EXR --aov layers");
    CHECK(layers.exit_code == 0);
    CHECK(layers.err.find("--aov layers writes nothing") == std::string::npos);
  }
  if (has_png()) CHECK(run(folder, small + "--out P.PNG").out.find("exposure of .png: ") != std::string::npos);
  Image sky(4, 2);
  for (float& value : sky.rgb) value = 0.25F;
  write_image(sky, folder / "S.PFM");
  std::ofstream(folder / "ball.pbrt") << "Camera \"perspective\" WorldBegin\n"
                                         "Translate 0 0 -5 Shape \"sphere\"\n";
  const Outcome outside = run(folder, "ball.pbrt --size 8x8 --iterations 1 --quiet --sky S.PFM --out a.pfm");
  INFO(outside.err);
  REQUIRE(outside.exit_code == 0);
  CHECK(mean_of(read_image(folder / "a.pfm")) == 0.25);
}
