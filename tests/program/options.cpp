// Options that cannot be meant as they stand, because they have no use or write one file twice; and
// endings of files in capitals.

#include <fstream>
#include <string>

#include "program.hpp"
#include "support/catch.hpp"
#include "support/image/formats.hpp"
#include "support/image/image.hpp"

using namespace program;

namespace {

void check_refused(const ScratchFolder& folder, const std::string& arguments, const std::string& message) {
  const Outcome outcome = run(folder, arguments);
  CAPTURE(arguments, outcome.err);
  CHECK(outcome.exit_code == 2);
  CHECK(outcome.err == "gmis-render: " + message + "\n");
  CHECK(outcome.out.empty());
}

}  // namespace

TEST_CASE("An option that the integrator has no use for is refused, and the message says which have one") {
  const ScratchFolder folder;
  struct Case {
    const char* arguments;
    const char* message;
  };
  for (const auto& [arguments, message] :
       {Case{"--integrator pt --radius 1", "--radius needs auto, ppm, bpm, vcm or gmis: pt merges nothing"},
        Case{"--integrator bpt --radius 1u", "--radius needs auto, ppm, bpm, vcm or gmis: bpt merges nothing"},
        Case{"--integrator lt --alpha 0.5", "--alpha needs auto, ppm, bpm, vcm or gmis: lt merges nothing"},
        Case{"--integrator pt --light-paths 2",
             "--light-paths needs auto, lt, bpt, ppm, bpm, vcm or gmis: pt traces no light"},
        Case{"--integrator pt --emission learned",
             "--emission needs auto, lt, bpt, ppm, bpm, vcm or gmis: pt traces no light"},
        Case{"--integrator lt --lights receiver", "--lights needs auto, pt, bpt, vcm or gmis: lt samples no lights"},
        Case{"--integrator bpm --lights power", "--lights needs auto, pt, bpt, vcm or gmis: bpm samples no lights"},
        Case{"--integrator ppm --connections auto",
             "--connections needs auto, bpt, vcm or gmis: ppm makes no connections"},
        Case{"--integrator pt --expected-iterations 8",
             "--expected-iterations needs auto, bpt, vcm or gmis: pt has no pilot"},
        Case{"--expected-iterations 0", "--expected-iterations \"0\" must be a whole number from 1 to 4294967295"},
        Case{"--integrator vcm --scheme R1", "--scheme needs --integrator gmis: vcm does not split"},
        Case{"--integrator auto --scheme N3", "--scheme needs --integrator gmis: auto does not split"},
        Case{"--split local --scheme R1", "--scheme needs --split budgeted or paper: local splits no subpaths"},
        Case{"--split none --scheme R1", "--scheme needs --split budgeted or paper: none splits no subpaths"}})
    check_refused(folder, "cornell --size 8x8 " + std::string(arguments), message);

  for (const char* arguments :
       {"--integrator ppm --radius 1 --alpha 0.5 --light-paths 2", "--split paper --scheme R1",
        "--integrator lt --light-paths 0.5 --emission learned", "--integrator pt --lights receiver",
        "--radius 1 --alpha 0.5 --light-paths 1 --expected-iterations 8", "--scheme R2"}) {
    const Outcome outcome =
        run(folder, "cornell --size 8x8 --iterations 1 --quiet --out a.pfm " + std::string(arguments));
    CAPTURE(arguments, outcome.err);
    CHECK(outcome.exit_code == 0);
  }
}

TEST_CASE("A file that is written beside an output is named by no other option") {
  const ScratchFolder folder;
  fs::create_directory(folder.path / "x_classes");
  fs::create_directory(folder.path / "parts");
  const std::string ending = gmis::tools::has_exr() ? ".exr" : ".pfm";
  const auto refused = [&](const std::string& arguments, const std::string& one, const std::string& other) {
    check_refused(folder, "cornell --size 8x8 --iterations 1 " + arguments,
                  one + " and " + other + " are the same file: give each a name of its own");
  };
  refused("--halves --out x.pfm --out x_a.pfm", "--out x_a.pfm", "--halves x_a.pfm");
  refused("--halves --out x.pfm --out ./x_b.pfm", "--out ./x_b.pfm", "--halves x_b.pfm");
  refused("--halves --out x.pfm --log x_b.pfm", "--log x_b.pfm", "--halves x_b.pfm");
  refused("--aov classes --out x.pfm --out x_classes/LDE" + ending, "--out x_classes/LDE" + ending,
          "--aov classes x_classes/LDE" + ending);
  refused("--techniques parts --out parts/merge_s2_t2" + ending, "--out parts/merge_s2_t2" + ending,
          "--techniques parts/merge_s2_t2" + ending);
  // The film's file name, too, has halves.
  std::ofstream(folder / "named.pbrt") << "Film \"rgb\" \"string filename\" \"mine.pfm\"\nWorldBegin\n"
                                          "LightSource \"point\"\nTranslate 0 0 3 Shape \"sphere\"\n";
  check_refused(folder, "named.pbrt --size 4x4 --iterations 1 --halves --log mine_a.pfm",
                "--log mine_a.pfm and --halves mine_a.pfm are the same file: give each a name of its own");
  CHECK_FALSE(fs::exists(folder / "x.pfm"));

  for (const std::string arguments :
       {"--out x.pfm --out x_a.pfm", "--halves --out x.pfm --out x_c.pfm",
        "--techniques parts --aov classes --out parts/x.pfm --out x_classes/picture.pfm"}) {
    const Outcome outcome = run(folder, "cornell --size 8x8 --iterations 2 --quiet " + arguments);
    CAPTURE(arguments, outcome.err);
    CHECK(outcome.exit_code == 0);
  }
}

TEST_CASE("An output overwrites no input, but a checkpoint the one that the run goes on from") {
  const ScratchFolder folder;
  const std::string scene = "Camera \"perspective\" WorldBegin LightSource \"infinite\" Include \"ball.pbrt\"\n";
  std::ofstream(folder / "s.pbrt") << scene;
  std::ofstream(folder / "ball.pbrt") << "Translate 0 0 -5 Shape \"sphere\"\n";
  const std::string small = "s.pbrt --size 8x8 --iterations 1 --quiet ";
  REQUIRE(run(folder, small + "--out r.pfm --checkpoint 1.ck").exit_code == 0);
  const auto refused = [&](const std::string& arguments, const std::string& one, const std::string& other) {
    check_refused(folder, small + arguments, one + " and " + other + " are the same file: give each a name of its own");
  };
  refused("--reference r.pfm --out ./r.pfm", "--out ./r.pfm", "--reference r.pfm");
  refused("--sky r.pfm --out r.pfm", "--out r.pfm", "--sky r.pfm");
  refused("--out a.pfm --log s.pbrt", "--log s.pbrt", "the scene's s.pbrt");
  refused("--out a.pfm --log ball.pbrt", "--log ball.pbrt", "the scene's ball.pbrt");
  refused("--resume 1.ck --resume 2.ck --out a.pfm --stats 1.ck", "--stats 1.ck", "--resume 1.ck");
  CHECK(text_of(folder / "s.pbrt") == scene);
  CHECK(run(folder, small + "--resume 1.ck --checkpoint 1.ck --out r.pfm").exit_code == 0);
}

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
