// gmis-compare beside gmis-render: the same pixels of a reference.

#include <fstream>
#include <string>

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

const std::string kept_ending = gmis::tools::has_exr() ? ".exr" : ".pfm";

}  // namespace

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
