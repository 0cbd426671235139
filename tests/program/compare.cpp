// gmis-compare beside gmis-render: the same pictures by the command lines that it prints, and the
// same pixels of a reference.

#include <fstream>
#include <string>
#include <vector>

#include "program.hpp"
#include "support/catch.hpp"
#include "support/image/formats.hpp"
#include "support/image/image.hpp"

using namespace program;
using gmis::tools::read_image;

namespace {

Outcome compare(const ScratchFolder& folder, const std::string& arguments) {
  return run_program(GMIS_COMPARE_PROGRAM, folder, arguments);
}

std::string unescaped(std::string text) {
  for (const auto& [coded, plain] :
       {std::pair("&#39;", "'"), std::pair("&quot;", "\""), std::pair("&lt;", "<"), std::pair("&amp;", "&")})
    for (std::size_t at = 0; (at = text.find(coded, at)) != std::string::npos; ++at)
      text.replace(at, std::string(coded).size(), plain);
  return text;
}

/// The arguments of gmis-render in the report, run by run.
std::vector<std::string> commands_in(const std::string& page) {
  const std::string start = "<code>gmis-render ", end = "</code>";
  std::vector<std::string> commands;
  for (std::size_t at = 0; (at = page.find(start, at)) != std::string::npos;) {
    at += start.size();
    commands.push_back(unescaped(page.substr(at, page.find(end, at) - at)));
  }
  return commands;
}

const std::string kept_ending = gmis::tools::has_exr() ? ".exr" : ".pfm";

}  // namespace

TEST_CASE("The command lines of a report give its pictures, bit by bit") {
  const ScratchFolder folder;
  // Two lamps over a floor show how next events choose; a mirror ball and a lamp far away, where
  // light subpaths start.
  std::ofstream(folder / "it's three lamps.pbrt") << program::two_lamps_over_a_floor << R"(Material "conductor"
Translate 0 1 1 Shape "sphere" "float radius" 0.7
AreaLightSource "diffuse" "rgb L" [ 60 56 48 ]
Translate 500 800 -300
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "sphere" "float radius" 100
)";
  const std::vector<std::string> integrators{"auto", "pt", "vcm", "gmis/budgeted"};
  for (const char* settings : {"", " --radius 0.412345678 --alpha 0.7123456789 --light-paths 0.3456789"}) {
    const Outcome outcome = compare(folder,
                                    "\"it's three lamps.pbrt\" --integrators auto,pt,vcm,gmis/budgeted --size 12x10 "
                                    "--time 0.1 --reference-time 0.01 --seeds 1 --seed 5 --threads 1 --out here" +
                                        std::string(settings));
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    const std::vector<std::string> commands = commands_in(text_of(folder.path / "here/report.html"));
    REQUIRE(commands.size() == integrators.size());
    for (std::size_t i = 0; i < commands.size(); ++i) {
      CAPTURE(commands[i]);
      const std::string name = integrators[i].substr(integrators[i].find('/') + 1);
      const Outcome again = run(folder, commands[i] + " --quiet --out a.pfm");
      INFO(again.err);
      REQUIRE(again.exit_code == 0);
      CHECK(image_hash(read_image(folder / "a.pfm")) ==
            image_hash(read_image(folder / ("here/it_s_three_lamps_" + name + kept_ending))));
    }
  }
}

TEST_CASE("A reference is compared with the part of the picture that the film's crop window leaves") {
  using namespace gmis::tools;
  const ScratchFolder folder;
  std::ofstream(folder / "part.pbrt") << "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 4\n"
                                         "  \"float cropwindow\" [ 0.25 0.75 0.5 1 ]\n"
                                         "Camera \"perspective\" WorldBegin\n"
                                         "LightSource \"infinite\" Translate 0 0 -5 Shape \"sphere\"\n";
  Image whole(8, 4);
  for (std::size_t i = 0; i < whole.rgb.size(); ++i) whole.rgb[i] = static_cast<float>(i);
  const Image part = cropped(whole, 2, 2, 6, 4);
  write_image(whole, folder / "whole.pfm");
  write_image(part, folder / "part.pfm");
  for (const std::string reference : {"part.pfm", "whole.pfm"}) {
    const Outcome outcome =
        compare(folder, "part.pbrt --integrators pt --time 0.01 --seeds 1 --out here --reference " + reference);
    CAPTURE(reference, outcome.err);
    REQUIRE(outcome.exit_code == 0);
    CHECK(image_hash(read_image(folder / ("here/part_reference" + kept_ending))) == image_hash(part));
    CHECK(read_image(folder / ("here/part_pt" + kept_ending)).width == 4);
  }
}
