#include <algorithm>
#include <atomic>
#include <cctype>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "gmis/render/expected_law.hpp"
#include "program.hpp"
#include "support/catch.hpp"
#include "support/executor.hpp"
#include "support/first_hit_layers.hpp"
#include "support/image/formats.hpp"
#include "support/image/image.hpp"
#include "support/load_scene.hpp"
#include "support/plan_text.hpp"
#include "support/progress_bar.hpp"
#include "support/seed.hpp"
#include "support/session.hpp"
#include "support/technique_sheet.hpp"

#if GMIS_HAS_OPENEXR
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#endif

using namespace program;
using Json = nlohmann::json;

namespace {

const std::string small = "cornell --size 8x8 --iterations 2 --threads 1 ";
/// A scene without fireflies, whose errors have an interval soon.
const std::string quiet_scene = "'" GMIS_SCENE_FOLDER "/../../bench/scenes/open_sky.pbrt'";

Json statistics(const ScratchFolder& folder, const std::string& arguments) {
  const Outcome outcome = run(folder, arguments + " --out a.pfm --stats s.json");
  INFO(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  return Json::parse(text_of(folder / "s.json"));
}

}  // namespace

TEST_CASE("Bad usage: exit code 2 and one line that says what to change") {
  const ScratchFolder folder;
  gmis::tools::Image nan(1, 1);
  nan.rgb[1] = std::numeric_limits<float>::quiet_NaN();
  gmis::tools::write_image(nan, folder / "nan.pfm");
  fs::create_directory_symlink(folder.path, folder / "linked");
  struct Case {
    const char* arguments;
    const char* part;
  };
  const std::vector<Case> cases{
      {"", "name a scene"},
      {"no_such_scene", "--list-scenes"},
      {"no/such/file.pbrt", "no/such/file.pbrt"},
      {"cornell --frobnicate", "--frobnicate"},
      {"cornell second", "second"},
      {"cornell --integrator magic", "use auto, pt"},
      {"cornell --integrator pt --connections 2",
       "--connections needs auto, bpt, vcm or gmis: pt makes no connections"},
      {"cornell --connections 2x", "auto, paired or a whole number"},
      {"cornell --connections 0", "auto, paired or a whole number"},
      {"cornell --effects no-fog", "no-fog"},
      {"cornell --effects caustics", "use no-NAME or NAME-only"},
      {"cornell --effects no-caustics,", "(nothing)"},
      {"cornell --effects emission-only,no-emission", "leaves nothing to render"},
      {"cornell --split sideways", "use local"},
      {"cornell --integrator vcm --split paper", "needs --integrator gmis"},
      {"cornell --scheme N4", "use R1"},
      {"cornell --size 10", "WIDTHxHEIGHT"},
      {"cornell --size 0x10", "WIDTHxHEIGHT"},
      {"cornell --size 10x-5", "WIDTHxHEIGHT"},
      {"cornell --size 10x10x10", "WIDTHxHEIGHT"},
      {"cornell --size 99999x99999", "32768"},
      {"cornell --size 99999999999999999999x1", "WIDTHxHEIGHT"},
      {"cornell --max-depth 0", "from 1 to 256"},
      {"cornell --max-depth 257", "from 1 to 256"},
      {"cornell --max-depth many", "--max-depth"},
      {"cornell --radius 0", "above 0"},
      {"cornell --radius nan", "above 0"},
      {"cornell --radius inf", "above 0"},
      {"cornell --radius 3m", "in pixel widths, or with the suffix u"},
      {"cornell --alpha 0", "--alpha"},
      {"cornell --alpha 1.5", "--alpha"},
      {"cornell --light-paths -1", "above 0"},
      {"cornell --light-paths 1e9", "at most 1000"},
      {"cornell --size 4096x4096 --light-paths 257", "more than 4294967295 light trees"},
      {"cornell --seed -1", "--seed"},
      {"cornell --threads 0", "from 1"},
      {"cornell --iterations 0", "\"0\" must be a whole number from 1 to 4294967295"},
      {"cornell --iterations -3", "\"-3\" must be a whole number from 1 to 4294967295"},
      {"cornell --iterations 2.5", "--iterations"},
      {"cornell --time 0", "above 0"},
      {"cornell --time nan", "above 0"},
      {"cornell --time inf", "--time must be above 0 and finite"},
      {"cornell --aov ''", "--aov is empty"},
      {"cornell --stats ''", "--stats is empty"},
      {"cornell --error 0", "above 0"},
      {"cornell --crop 1,2,3", "X0,Y0,X1,Y1"},
      {"cornell --crop 5,5,5,9", "X0,Y0,X1,Y1"},
      {"cornell --size 8x8 --crop 0,0,9,8", "8x8"},
      {"cornell --out a.jpg", ".exr, .pfm or .png"},
      {"cornell --out", "--out"},
      {"cornell --out no_such_folder/a.pfm", "does not exist"},
      {"cornell --stats no_such_folder/s.json", "does not exist"},
      {"cornell --log no_such_folder/l.csv", "does not exist"},
      {"cornell --techniques stdout.txt", "--techniques"},
      {"cornell --reference absent.pfm", "absent.pfm"},
      {"cornell --reference a.png", "missing"},
      {"cornell --size 1x1 --reference nan.pfm", "nan.pfm: this reference has a value that is no number"},
      {"cornell --out a.pfm --stats a.pfm", "--out a.pfm and --stats a.pfm are the same file"},
      {"cornell --out a.pfm --out ./a.pfm", "--out a.pfm and --out ./a.pfm are the same file"},
      {"cornell --out a.pfm --log l --checkpoint linked/l", "--log l and --checkpoint linked/l are the same file"},
      {"cornell --radius 1e30 --integrator vcm", "the diagonal of the scene"},
      {"cornell --radius 1e30u", "--radius 1e+30u is 1e+30 scene units, and the diagonal of the scene"},
      {"cornell --max-memory 0", "from 1 to 2^50"},
      {"cornell --max-memory 1", "gmis-render: the file"},
      {"cornell --max-memory 1", "and 0 bytes of 1 byte are taken"},
      {"cornell --tev localhost:99999", "the port must be a whole number from 1 to 65535"},
      {"cornell --at 1", "--at needs a .gltf or .glb file"},
      {"cornell --max-rejected 2", "a share from 0 to 1"},
      {"cornell --iterations 4 --replay 9:5", "the run has 4 iterations"},
      {"cornell --replay 65:5", "the run has 64 iterations"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.arguments);
    const Outcome outcome = run(folder, c.arguments);
    CAPTURE(outcome.err);
    CHECK(outcome.exit_code == 2);
    CHECK(line_count(outcome.err) == 1);
    CHECK(outcome.err.find(c.part) != std::string::npos);
    CHECK(outcome.out.empty());
  }
}

TEST_CASE("A bad scene: exit code 2 and one line with file and line") {
  const ScratchFolder folder;
  std::ofstream(folder / "bad.pbrt") << "WorldBegin\n\nMaterial \"velvet\"\n";
  const Outcome outcome = run(folder, "bad.pbrt --quiet --out a.pfm");
  CHECK(outcome.exit_code == 2);
  CHECK(line_count(outcome.err) == 1);
  CHECK(outcome.err.find("bad.pbrt:3: ") != std::string::npos);
  CHECK_FALSE(fs::exists(folder / "a.pfm"));
}

TEST_CASE("What cannot be written keeps nothing else from being written: exit code 1 and one line") {
  const ScratchFolder folder;
  // No file may be longer than 512 bytes (in some shells 1024): the log is, in the middle of the
  // run, and the picture is not. What counts coverage must not try to write here.
  const Outcome cut = run(folder, "cornell --size 2x2 --iterations 400 --threads 1 --quiet --out c.pfm --log long.csv",
                          "export GCOV_PREFIX=. GCOV_ERROR_FILE=/dev/null && trap '' XFSZ && ulimit -f 1");
  CHECK(cut.exit_code == 1);
  CHECK(line_count(cut.err) == 1);
  CHECK(cut.err.find("long.csv: this file cannot be written") != std::string::npos);
  CHECK(gmis::tools::read_image(folder / "c.pfm").width == 2);
  const std::string log = text_of(folder / "long.csv");  // as far as it came, in whole lines
  CHECK(log.starts_with("cpu_seconds,"));
  CHECK(log.ends_with("\n"));

  // A picture that is too large leaves the old one as it was, and what fits is written.
  fs::remove(folder / "long.csv");
  const std::string old = text_of(folder / "c.pfm");
  const Outcome full = run(folder, "cornell --size 32x32 --iterations 2 --threads 1 --out c.pfm --log short.csv",
                           "export GCOV_PREFIX=. GCOV_ERROR_FILE=/dev/null && trap '' XFSZ && ulimit -f 1");
  CHECK(full.exit_code == 1);
  CHECK(full.err.find("c.pfm: this file cannot be written") != std::string::npos);
  CHECK(full.out.find("wrote c.pfm") == std::string::npos);
  CHECK(text_of(folder / "c.pfm") == old);
  CHECK(line_count(text_of(folder / "short.csv")) == 3);
  for (const auto& entry : fs::directory_iterator(folder.path))
    CHECK(entry.path().string().find(".part") == std::string::npos);
}

TEST_CASE("What cannot be written is said before the work: exit code 2 and one line") {
  const ScratchFolder folder;
  fs::create_directory(folder.path / "a.pfm");
  fs::create_directory(folder.path / "s.json");
  for (const char* outputs : {"--out a.pfm --out b.pfm", "--out b.pfm --stats s.json", "--out b.pfm --log s.json"}) {
    CAPTURE(outputs);
    const Outcome outcome = run(folder, "cornell --size 8x8 --iterations 100000000 " + std::string(outputs));
    CHECK(outcome.exit_code == 2);
    CHECK(line_count(outcome.err) == 1);
    CHECK(outcome.err.find("this file cannot be written") != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "b.pfm"));
  }
}

TEST_CASE("A standard output that takes nothing is a failure: exit code 1 and one line") {
  const ScratchFolder folder;
  for (const std::string arguments : {"--list-scenes", "--check cornell", "--version"}) {
    CAPTURE(arguments);
    const Outcome outcome = run(folder, arguments + " >/dev/full 2>stderr.txt #");
    CHECK(outcome.exit_code == 1);
    CHECK(outcome.err == "gmis-render: standard output cannot be written: check that it has space\n");
  }
}

TEST_CASE("A run that found nothing is finished by --error late, and says so") {
  const ScratchFolder folder;
  // Light that is seen directly and nothing else: every iteration is the same.
  const Outcome constant =
      run(folder,
          "cornell --integrator pt --effects emission-only --size 32x32 --crop 0,0,2,2 --iterations 40 --error 0.5 "
          "--out a.pfm --stats s.json");
  CHECK(constant.exit_code == 0);
  CHECK(constant.out.find("nothing has been found yet") != std::string::npos);
  const Json json = Json::parse(text_of(folder / "s.json"));
  CHECK(json["stopped_by"] == "iterations");
  CHECK(json["estimate"]["is_calibrated"] == false);
  CHECK(json["estimate"]["doubt"] == "nothing_found");
  CHECK(json["estimate"]["relative_error"] == 0);
  CHECK(json["prices"].empty());
  const Outcome late = run(folder,
                           "cornell --integrator pt --effects emission-only --size 32x32 --crop 0,0,2,2 --error "
                           "0.5 --out a.pfm --stats s.json");
  CHECK(late.out.find("nothing has been found yet") != std::string::npos);
  const Json later = Json::parse(text_of(folder / "s.json"));
  CHECK(later["stopped_by"] == "error");
  CHECK(later["iterations"] >= 256);
  CHECK(later["iterations"] < 300);
  CHECK(later["estimate"]["doubt"] == "nothing_found");
  // Where the plan knows that nothing will ever be found, --error alone does not wait for it.
  const Outcome black = run(folder, "cornell --size 2x2 --effects caustics-only --error 0.5 --out a.pfm");
  CHECK(black.exit_code == 0);
}

TEST_CASE("Effects that a scene does not have: a black picture, and a line that says so") {
  const ScratchFolder folder;
  const Outcome outcome = run(folder, small + "--effects caustics-only --out a.pfm");
  CHECK(outcome.exit_code == 0);
  CHECK(line_count(outcome.err) == 1);
  CHECK(outcome.err.find("--effects keeps no path that this scene has") != std::string::npos);
  CHECK(run(folder, small + "--effects caustics-only --quiet --out a.pfm").err.empty());
}

TEST_CASE("A viewer that is not there is a warning, of which --quiet says nothing") {
  const ScratchFolder folder;
  for (const bool is_quiet : {false, true}) {
    const Outcome outcome = run(folder, small + "--tev localhost:1 --out a.pfm" + (is_quiet ? " --quiet" : ""));
    CAPTURE(outcome.err);
    CHECK(outcome.exit_code == 0);
    CHECK(outcome.err.empty() == is_quiet);
  }
}

TEST_CASE("Help, version and the list of scenes go to standard output") {
  const ScratchFolder folder;
  const Outcome help = run(folder, "--help");
  CHECK(help.exit_code == 0);
  for (const char* option :
       {"--integrator", "--effects",     "--split",       "--scheme",  "--size",       "--max-depth", "--radius",
        "--alpha",      "--light-paths", "--seed",        "--threads", "--iterations", "--time",      "--error",
        "--crop",       "--techniques",  "--halves",      "--out",     "--stats",      "--log",       "--reference",
        "--explain",    "--quiet",       "--list-scenes", "--check",   "--lenient",    "--exposure",  "--aov",
        "--lights",     "--resume",      "--emission"}) {
    CAPTURE(option);
    CHECK(help.out.find(option) != std::string::npos);
  }
  CHECK(run(folder, "--version").exit_code == 0);
  const Outcome list = run(folder, "--list-scenes");
  CHECK(list.exit_code == 0);
  for (const char* line :
       {"cornell     The classic box", "paper1      Two metal balls", "paper2      ", "paper3      The back wall",
        "paper4      A glossy floor", "studio      Rough glass", "leaves      Leaves cut out",
        "metals      Five metals by name", "shade       A lamp in a paper", "tinted      Coloured glass absorbs"}) {
    CAPTURE(line);
    CHECK(list.out.find(line) != std::string::npos);
  }
  CHECK(std::count(list.out.begin(), list.out.end(), '\n') == 10);
}

TEST_CASE("The statistics hold every key that scripts rely on") {
  const ScratchFolder folder;
  REQUIRE(run(folder, small + "--quiet --out ref.pfm").exit_code == 0);
  const Json json = statistics(folder, small + "--integrator gmis --split budgeted --seed 9 --reference ref.pfm");
  for (const char* key : {"/integrator",
                          "/plan",
                          "/version",
                          "/isa",
                          "/sampler",
                          "/seed",
                          "/threads",
                          "/iterations",
                          "/stopped_by",
                          "/image_hash",
                          "/seconds/wall",
                          "/seconds/cpu",
                          "/seconds/phase",
                          "/counts/camera_paths",
                          "/counts/light_subpaths",
                          "/counts/rays",
                          "/counts/shadow_rays",
                          "/counts/connections",
                          "/counts/projections",
                          "/counts/splats",
                          "/counts/merge_queries",
                          "/counts/merges",
                          "/counts/photons_stored",
                          "/counts/grids_built",
                          "/rejected/non_finite",
                          "/rejected/negative",
                          "/rejected/zero_pdf",
                          "/estimate/mean",
                          "/estimate/variance",
                          "/estimate/relative_error",
                          "/memory/peak_bytes",
                          "/memory/photon_bytes",
                          "/error/relmse",
                          "/error/relmse_trimmed",
                          "/error/rmse"}) {
    CAPTURE(key);
    CHECK(json.contains(Json::json_pointer(key)));
  }
  CHECK(json["integrator"] == "gmis");
  CHECK(json["seed"] == 9);
  CHECK(json["iterations"] == 2);
  CHECK(json["stopped_by"] == "iterations");
  CHECK(json["threads"] == 1);
  CHECK(json["counts"]["camera_paths"] == (2 + 2) * 64);           // those of the pilot and of the picture
  CHECK(json["counts"]["light_subpaths"] == 2 * 64 / 8 + 2 * 64);  // an eighth of a tree a pixel in a pilot
  CHECK(json["counts"]["grids_built"] == 2 + 2);
  CHECK(json["estimate"]["mean"].get<double>() > 0);
  CHECK(json["estimate"]["variance"].get<double>() > 0);
  CHECK(json["error"]["relmse"].get<double>() > 0);
  CHECK(json["error"]["relmse"].get<double>() >= json["error"]["relmse_trimmed"].get<double>());
  CHECK(json["rejected"]["non_finite"] == 0);
  // What was not done is exactly 0.
  const Json pt = statistics(folder, small + "--integrator pt");
  for (const char* key : {"light_subpaths", "connections", "projections", "splats", "merge_queries", "merges",
                          "photons_stored", "grids_built"})
    CHECK(pt["counts"][key] == 0);
  const Json bpt = statistics(folder, small + "--integrator bpt");
  CHECK(bpt["counts"]["connections"].get<int>() > 0);
  CHECK(bpt["counts"]["merge_queries"] == 0);
  CHECK(bpt["counts"]["grids_built"] == 0);
  // One iteration knows nothing of its variance.
  CHECK(statistics(folder, "cornell --size 8x8 --iterations 1")["estimate"]["variance"].is_null());
}

TEST_CASE("Without an integrator, auto chooses; what only gmis does asks for gmis") {
  const ScratchFolder folder;
  const Json json = statistics(folder, "cornell --size 16x16 --iterations 4");
  CHECK(json["integrator"] == "auto");
  REQUIRE(json.contains("choice"));
  CHECK(json["choice"]["pilot_iterations"] == 2);
  CHECK(json["choice"]["pilot_share"].get<double>() > 0.1);
  CHECK(json["choice"]["pilot_share"].get<double>() < 1.0);
  CHECK(json["choice"]["forecasts"].size() == 1 + 4 * 3);  // nothing to merge in that scene
  CHECK(statistics(folder, small + "--scheme R3")["integrator"] == "gmis");
  CHECK(statistics(folder, small + "--split paper")["integrator"] == "gmis");
  const auto explained = run(folder, "cornell --size 16x16 --iterations 4 --explain --out a.pfm");
  CHECK(explained.exit_code == 0);
  CHECK(explained.out.find("measured    in 2 iterations") != std::string::npos);
  CHECK(explained.out.find("for the same error with") != std::string::npos);
  CHECK(run(folder, "cornell --size 16x16 --replay 1:5").exit_code == 0);
}

TEST_CASE("The image named by --out is the one the statistics speak of, in every format") {
  const ScratchFolder folder;
  const Json json = statistics(
      folder, small + (gmis::tools::has_exr() ? "--out b.exr " : "") + (gmis::tools::has_png() ? "--out c.png" : ""));
  const auto image = gmis::tools::read_image(folder / "a.pfm");
  CHECK(image.width == 8);
  CHECK(image.height == 8);
  CHECK(gmis::tools::image_hash(image) == json["image_hash"]);
  if (gmis::tools::has_exr())
    CHECK(gmis::tools::image_hash(gmis::tools::read_image(folder / "b.exr")) == json["image_hash"]);
  if (gmis::tools::has_png()) CHECK(fs::file_size(folder / "c.png") > 50);
  double mean = 0;
  for (const float value : image.rgb) mean += static_cast<double>(value);
  CHECK(mean / static_cast<double>(image.rgb.size()) == Approx(json["estimate"]["mean"].get<double>()).epsilon(1e-5));
}

TEST_CASE("The same seed gives the same bits for any number of threads, another seed others") {
  const ScratchFolder folder;
  for (const char* integrator : {"pt", "bpt", "vcm", "gmis", "gmis --split paper"}) {
    CAPTURE(integrator);
    const std::string common = "cornell --size 24x24 --iterations 2 --integrator " + std::string(integrator);
    const Json one = statistics(folder, common + " --threads 1");
    const Json two = statistics(folder, common + " --threads 2");
    const Json five = statistics(folder, common + " --threads 5");
    CHECK(one["image_hash"] == two["image_hash"]);
    CHECK(one["image_hash"] == five["image_hash"]);
    CHECK(one["counts"] == two["counts"]);
    CHECK(statistics(folder, common + " --seed 1")["image_hash"] != one["image_hash"]);
  }
}

TEST_CASE("gmis without splitting is vcm, bit by bit") {
  const ScratchFolder folder;
  for (const char* scene : {"cornell", "paper1"}) {
    const std::string common = std::string(scene) + " --size 16x16 --iterations 2 --integrator ";
    CHECK(statistics(folder, common + "gmis --split none")["image_hash"] ==
          statistics(folder, common + "vcm")["image_hash"]);
  }
}

TEST_CASE("A crop shows what the whole picture shows there") {
  const ScratchFolder folder;
  // With counts that are given: a pilot chooses for the pixels that it sees.
  for (const char* integrator : {"pt", "vcm --connections 1"}) {
    CAPTURE(integrator);
    const std::string common = "cornell --size 16x12 --iterations 2 --integrator " + std::string(integrator);
    (void)statistics(folder, common);
    const auto whole = gmis::tools::read_image(folder / "a.pfm");
    (void)statistics(folder, common + " --crop 3,2,11,9");
    const auto part = gmis::tools::read_image(folder / "a.pfm");
    REQUIRE(part.width == 8);
    REQUIRE(part.height == 7);
    CHECK(part.rgb == gmis::tools::cropped(whole, 3, 2, 11, 9).rgb);
  }
}

TEST_CASE("The halves are independent and their mean is the image") {
  const ScratchFolder folder;
  (void)statistics(folder, "cornell --size 8x8 --iterations 4 --halves");
  const auto whole = gmis::tools::read_image(folder / "a.pfm");
  const auto a = gmis::tools::read_image(folder / "a_a.pfm");
  const auto b = gmis::tools::read_image(folder / "a_b.pfm");
  CHECK(a.rgb != b.rgb);
  for (std::size_t i = 0; i < whole.rgb.size(); ++i)
    CHECK((a.rgb[i] + b.rgb[i]) / 2 == Approx(whole.rgb[i]).epsilon(1e-5).margin(1e-7));
}

TEST_CASE("The images of all techniques add up to the image") {
  struct Case {
    const char* arguments;
    std::vector<std::string> names;  ///< all that there are, up to 3 edges
  };
  const std::string hits[] = {"emitter_hit_s0_t2", "emitter_hit_s0_t3", "emitter_hit_s0_t4"};
  const std::string events[] = {"next_event_s1_t2", "next_event_s1_t3"};
  const std::string splats[] = {"splat_s2_t1", "splat_s3_t1"};
  const std::string merges[] = {"merge_s2_t2", "merge_s2_t3", "merge_s3_t2"};
  const std::string connection = "connect_s2_t2";
  const std::vector<std::string> all{hits[0],   hits[1],   hits[2],   events[0], events[1], connection,
                                     splats[0], splats[1], merges[0], merges[1], merges[2]};
  const std::vector<Case> cases{
      {"--integrator pt", {hits[0], hits[1], hits[2], events[0], events[1]}},
      {"--integrator lt", {hits[0], splats[0], splats[1]}},
      {"--integrator bpt", {hits[0], hits[1], hits[2], events[0], events[1], connection, splats[0], splats[1]}},
      {"--integrator ppm --radius 2", {hits[0], merges[0], merges[2]}},
      {"--integrator bpm --radius 2", {hits[0], hits[1], hits[2], merges[0], merges[1], merges[2]}},
      {"--integrator vcm --radius 2", all},
      {"--integrator vcm --radius 2 --halves", all},
      {"--integrator vcm --radius 2 --crop 2,3,20,22", all},
      {"--integrator gmis --radius 2 --split budgeted", all},
  };
  for (const Case& c : cases) {
    CAPTURE(c.arguments);
    const ScratchFolder folder;
    (void)statistics(
        folder, "cornell --size 24x24 --iterations 4 --max-depth 3 --techniques parts " + std::string(c.arguments));
    const auto whole = gmis::tools::read_image(folder / "a.pfm");
    std::vector<double> sum(whole.rgb.size());
    std::set<std::string> names;
    std::string ending;
    for (const auto& entry : fs::directory_iterator(folder.path / "parts"))
      if (entry.path().extension() != ".png") {
        names.insert(entry.path().stem().string());
        ending = entry.path().extension().string();
      }
    int above = 0;
    for (const std::string& name : c.names) {
      CAPTURE(name);
      REQUIRE(names.erase(name) == 1);
      REQUIRE(names.erase(name + "_unweighted") == 1);
      const auto weighted = gmis::tools::read_image(folder / ("parts/" + name + ending));
      const auto unweighted = gmis::tools::read_image(folder / ("parts/" + name + "_unweighted" + ending));
      REQUIRE(weighted.rgb.size() == sum.size());
      REQUIRE(unweighted.rgb.size() == sum.size());
      for (std::size_t i = 0; i < sum.size(); ++i) {
        sum[i] += static_cast<double>(weighted.rgb[i]);
        above += weighted.rgb[i] > unweighted.rgb[i] * 1.0001F ? 1 : 0;  // a weight is at most 1
      }
    }
    CHECK(above == 0);
    const std::string sheet_ending = gmis::tools::has_png() ? ".png" : ".pfm";
    CHECK(fs::file_size(folder / ("parts/pyramid" + sheet_ending)) > 1000);
    CHECK(fs::file_size(folder / ("parts/pyramid_unweighted" + sheet_ending)) > 1000);
    names.erase("pyramid");
    names.erase("pyramid_unweighted");
    CHECK(names.empty());
    // A frame is a sum of some hundred floats a pixel, each rounded by 6e-8 of the sum so far.
    for (std::size_t i = 0; i < sum.size(); ++i)
      CHECK(sum[i] == Approx(static_cast<double>(whole.rgb[i])).epsilon(1e-5).margin(1e-7));
  }
}

TEST_CASE("The sheet of all techniques: a row per path length, connections left, merges right") {
  using gmis::Technique;
  const auto image = [](float value) {
    gmis::tools::Image result(64, 40);
    std::fill(result.rgb.begin(), result.rgb.end(), value);
    return result;
  };
  std::vector<gmis::tools::TechniqueImage> techniques;
  techniques.push_back({{Technique::emitter_hit, 0, 2}, image(0.1F), image(0.5F)});
  techniques.push_back({{Technique::splat, 2, 1}, image(0.2F), image(0.6F)});
  techniques.push_back({{Technique::merge, 2, 2}, image(0.3F), image(0.7F)});
  CHECK(gmis::tools::edges_of(techniques[0].id) == 1);
  CHECK(gmis::tools::edges_of(techniques[1].id) == 2);
  CHECK(gmis::tools::edges_of(techniques[2].id) == 2);
  for (const bool is_weighted : {true, false}) {
    const auto sheet = gmis::tools::technique_sheet(techniques, is_weighted);
    // Two rows; columns s = 0, 1, 2, then the one of the merges.
    REQUIRE(sheet.width > 4 * 64);
    REQUIRE(sheet.width < 5 * 64);
    REQUIRE(sheet.height > 2 * 40);
    const int row = (sheet.height - 4) / 2;
    const auto value_at = [&](int x, int y) { return sheet.rgb[sheet.index(x, y)]; };
    const float offset = is_weighted ? 0.0F : 0.4F;
    CHECK(value_at(4 + 30, row - 20) == Approx(0.1F + offset));
    CHECK(value_at(4 + 2 * 68 + 30, 2 * row - 20) == Approx(0.2F + offset));
    CHECK(value_at(sheet.width - 34, 2 * row - 20) == Approx(0.3F + offset));
    CHECK(value_at(4 + 68 + 30, 2 * row - 20) < 0.05F);  // no path was made with s = 1
  }
  // Small images are enlarged, large ones reduced.
  techniques.resize(1);
  techniques[0].weighted = gmis::tools::Image(8, 8);
  CHECK(gmis::tools::technique_sheet(techniques, true).width == 4 + 64 + 4);
  techniques[0].weighted = gmis::tools::Image(512, 256);
  CHECK(gmis::tools::technique_sheet(techniques, true).width == 4 + 128 + 4);
}

TEST_CASE("Stopping rules: the first one met") {
  const ScratchFolder folder;
  const Json timed = statistics(folder, "cornell --size 8x8 --time 0.3 --iterations 100000000 --threads 1");
  CHECK(timed["stopped_by"] == "time");
  CHECK(timed["iterations"].get<int>() >= 1);
  const Json exact = statistics(folder, quiet_scene + " --integrator bpt --size 24x24 --error 0.15 --iterations 4000");
  CHECK(exact["stopped_by"] == "error");
  CHECK(exact["estimate"]["relative_error"].get<double>() <= 0.15);
  CHECK(exact["estimate"]["is_calibrated"] == true);
  // The value printed, logged, stopped on and in the middle of the interval is one.
  const double error = exact["estimate"]["relative_error"].get<double>();
  CHECK(std::sqrt(exact["estimate"]["interval"][0].get<double>() * exact["estimate"]["interval"][1].get<double>()) ==
        Approx(error).epsilon(1e-9));
  CHECK(exact["iterations"].get<int>() >= 8);
  CHECK(statistics(folder, "cornell --size 4x4 --threads 1")["iterations"] == 64);
}

TEST_CASE("The log has a line per point, with and without a reference, and the last one is what the statistics say") {
  const ScratchFolder folder;
  const Json plain =
      statistics(folder, quiet_scene + " --integrator bpt --size 24x24 --iterations 41 --log l.csv --seed " +
                             std::to_string(gmis_test::seed(3)));
  const std::string log = text_of(folder / "l.csv");
  CHECK(line_count(log) == 1 + 9);  // 1 4 6 8 12 16 24 32, and the end
  CHECK(log.starts_with("cpu_seconds,wall_seconds,iteration,estimated_error,"));
  CHECK(log.ends_with(",\n"));  // nothing to compare with
  const auto interval = plain["estimate"]["interval"];
  REQUIRE(interval.is_array());
  CHECK(interval[0].get<double>() < interval[1].get<double>());
  CHECK(interval[0].get<double>() < 1.5 * plain["estimate"]["relative_error"].get<double>());
  CHECK(interval[1].get<double>() > plain["estimate"]["relative_error"].get<double>() / 1.5);
  CHECK(plain["prediction"]["slope"].get<double>() < -0.37);

  fs::rename(folder / "a.pfm", folder / "reference.pfm");
  const Json compared = statistics(
      folder, quiet_scene + " --integrator bpt --size 24x24 --iterations 9 --log l.csv --reference reference.pfm");
  const std::string text = text_of(folder / "l.csv");
  CHECK(line_count(text) == 1 + 5);
  const std::string last = text.substr(text.rfind(',') + 1);
  CHECK(std::stod(last) == Approx(std::sqrt(compared["error"]["relmse"].get<double>())).epsilon(1e-4));
}

TEST_CASE("What the scene has and calls for is said, in words and in the statistics") {
  const ScratchFolder folder;
  const std::string direct = small + "--effects direct-only ";
  const Outcome told = run(folder, direct + "--explain --out a.pfm");
  CHECK(told.exit_code == 0);
  for (const char* part : {"integrator  auto", "effects     diffuse; area lights", "segments: LE LDE LDD+E",
                           "of these: LDE", "merging      off: only direct light is rendered"}) {
    CAPTURE(part);
    CHECK(told.out.find(part) != std::string::npos);
  }
  // Of an integrator asked for by name: what it is, beside what the scene calls for.
  CHECK(run(folder, small + "--integrator pt --explain --out a.pfm")
            .out.find("not in pt; the scene alone would have it on") != std::string::npos);

  const Json json = statistics(folder, direct + "--seed 3");
  CHECK(json["integrator"] == "auto");
  CHECK(json["plan"] == "emitter hits, next event");
  CHECK(json["effects"]["diffuse"] == true);
  CHECK(json["effects"]["specular_reflection"] == false);
  CHECK(json["effects"]["roughness"].is_null());
  CHECK(json["path_classes"]["occurring"] == Json::array({"LE", "LDE", "LDD+E"}));
  CHECK(json["path_classes"]["rendered"] == Json::array({"LDE"}));
  for (const char* technique : {"connect", "splat", "merge"}) CHECK(json["techniques"][technique]["on"] == false);
  CHECK(json["techniques"]["next_event"]["on"] == true);
  CHECK(json["techniques"]["next_event"]["makes"] == Json::array({"LDE", "LDD+E"}));
  for (const char* count : {"light_subpaths", "connections", "projections", "splats", "merge_queries", "merges",
                            "photons_stored", "grids_built"})
    CHECK(json["counts"][count] == 0);
  CHECK(json["memory"]["photon_bytes"] == 0);
}

TEST_CASE("What is said: explanations, warnings, nothing when quiet") {
  const ScratchFolder folder;
  const Outcome told = run(folder, small + "--integrator gmis --split budgeted --explain --out a.pfm");
  CHECK(told.exit_code == 0);
  for (const char* part : {"integrator  gmis", "8x8", "budgeted", "after 2 iterations", "wrote a.pfm"}) {
    CAPTURE(part);
    CHECK(told.out.find(part) != std::string::npos);
  }
  CHECK(told.err.empty());  // no progress bar: this is no terminal
  std::ofstream(folder / "odd.pbrt")
      << "Sampler \"halton\"\nWorldBegin\nFoo 1 2\n"
         "LightSource \"point\" \"point3 from\" [ 0 0 -3 ]\nTranslate 0 0 3 Shape \"sphere\"\n";
  const Outcome refused = run(folder, "odd.pbrt --size 4x4 --iterations 1 --out b.pfm");
  CHECK(refused.exit_code == 2);
  CHECK(refused.err.find("odd.pbrt:3: the directive \"Foo\"") != std::string::npos);
  CHECK_FALSE(fs::exists(folder / "b.pfm"));
  const Outcome checked = run(folder, "odd.pbrt --check --out b.pfm");
  CHECK(checked.exit_code == 2);
  CHECK(checked.out.find("odd.pbrt:1: note: ") != std::string::npos);
  CHECK(checked.out.find("odd.pbrt:3: error: the directive \"Foo\"") != std::string::npos);
  CHECK(checked.err.find("cannot be rendered: 1 error") != std::string::npos);
  CHECK_FALSE(fs::exists(folder / "b.pfm"));
  CHECK(run(folder, "cornell --check").exit_code == 0);
  std::ofstream(folder / "note.pbrt") << "Sampler \"halton\"\nWorldBegin\nShape \"sphere\"\n";
  const Outcome with_a_note = run(folder, "note.pbrt --check");
  CHECK(with_a_note.exit_code == 0);
  CHECK(with_a_note.out.find("note.pbrt: can be rendered; notes and warnings above: ") != std::string::npos);
  const Outcome warned = run(folder, "odd.pbrt --size 4x4 --iterations 1 --out a.pfm --lenient");
  CHECK(warned.exit_code == 0);
  CHECK(warned.err.find("odd.pbrt:1: note: ") != std::string::npos);
  CHECK(warned.err.find("odd.pbrt:3: warning: ") != std::string::npos);
  const Outcome quiet = run(folder, "odd.pbrt --size 4x4 --iterations 1 --out a.pfm --quiet --lenient");
  CHECK(quiet.exit_code == 0);
  CHECK(quiet.out.empty());
  CHECK(quiet.err.empty());
}

TEST_CASE("The manual page and the completions of all shells have every option that there is", "[long]") {
  const ScratchFolder folder;
  const std::string help = run(folder, "--help").out;
  // Options are what stands at the beginning of the lines of --help, with their long names.
  std::vector<std::string> options;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find_first_not_of(' ');
    const std::size_t name = line.find("--");
    if (first == std::string::npos || line[first] != '-' || name == std::string::npos || name > first + 4) continue;
    options.push_back(line.substr(name, line.find_first_of(" ,=", name) - name));
  }
  REQUIRE(options.size() > 35);
  CHECK(std::count(options.begin(), options.end(), "--man") == 1);
  CHECK(std::count(options.begin(), options.end(), "--help") == 1);
  const auto has_word = [](const std::string& text, const std::string& word) {
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
      if (std::isalnum(static_cast<unsigned char>(text[at + word.size()])) == 0 && text[at + word.size()] != '-')
        return true;
    return false;
  };
  const Outcome manual = run(folder, "--man");
  REQUIRE(manual.exit_code == 0);
  for (const char* part : {".TH GMIS\\-RENDER 1", ".SH NAME", ".SH SYNOPSIS", ".SH OPTIONS", ".SH \"EXIT STATUS\""})
    CHECK(manual.out.find(part) != std::string::npos);
  std::string plain = manual.out;
  for (std::size_t at = plain.find("\\-"); at != std::string::npos; at = plain.find("\\-")) plain.erase(at, 1);
  for (const std::string& option : options) {
    CAPTURE(option);
    CHECK(has_word(plain, "\\fB" + option));
    for (const char* shell : {"bash", "zsh"}) {
      CAPTURE(shell);
      CHECK(has_word(run(folder, std::string("--completion ") + shell).out, option));
    }
    CHECK(has_word(run(folder, "--completion fish").out, "-l " + option.substr(2)));
  }
  const Outcome unknown = run(folder, "--completion tcsh");
  CHECK(unknown.exit_code == 2);
  CHECK(unknown.err.find("use bash, zsh or fish") != std::string::npos);
}

TEST_CASE("bash completes options, the words of their values, files and scenes") {
  const ScratchFolder folder;
  if (std::system("bash -c 'type mapfile' >/dev/null 2>&1") != 0) return;
  REQUIRE(run(folder, "--completion bash", ": >a.pfm").exit_code == 0);
  fs::copy_file(folder.path / "stdout.txt", folder.path / "completion.bash");
  const auto completed = [&](const std::string& words, int number) {
    const std::string script =
        "cd '" + folder.path.string() +
        "'; gmis-render() { '" GMIS_RENDER_PROGRAM "' \"$@\"; }; . ./completion.bash; COMP_WORDS=(gmis-render " +
        words + "); COMP_CWORD=" + std::to_string(number) + "; _gmis_render; echo \"${COMPREPLY[*]}\" >found.txt";
    std::ofstream(folder.path / "try.bash") << script;
    REQUIRE(std::system(("bash '" + (folder / "try.bash") + "'").c_str()) == 0);
    return text_of(folder.path / "found.txt");
  };
  CHECK(completed("--integrator b", 2) == "bpt bpm\n");
  CHECK(completed("--emis", 1) == "--emission\n");
  CHECK(completed("--out a.", 2) == "a.pfm\n");
  CHECK(completed("corn", 1) == "cornell\n");
  CHECK(completed("--seed ''", 2) == "\n");
  CHECK(completed("--scheme ''", 2) == "R1 R2 R3 N1 N2 N3\n");
}

TEST_CASE("Exposure changes a .png alone, and layers are what is seen first") {
  const ScratchFolder folder;
  std::ofstream(folder / "square.pbrt")
      << "Camera \"orthographic\" \"float screenwindow\" [ -1 1 -1 1 ]\nWorldBegin\nLightSource \"infinite\"\n"
         "Material \"diffuse\" \"rgb reflectance\" [ .125 .25 .5 ]\nTranslate 0 0 4\nShape \"trianglemesh\" \"integer "
         "indices\" [ 0 1 2 ]"
         " \"point3 P\" [ -9 -9 0  9 -9 0  0 9 0 ]\n";
  const std::string options = "square.pbrt --size 8x8 --iterations 4 --integrator pt --quiet ";
  REQUIRE(run(folder, options + "--out a.pfm --out a.png").exit_code == 0);
  REQUIRE(run(folder, options + "--out b.pfm --out b.png --exposure 1").exit_code == 0);
  CHECK(text_of(folder / "a.pfm") == text_of(folder / "b.pfm"));
  CHECK(text_of(folder / "a.png") != text_of(folder / "b.png"));
  CHECK(run(folder, options + "--exposure many").exit_code == 2);
  REQUIRE(run(folder, options + "--out c.pfm --out c.png --tone filmic").exit_code == 0);
  CHECK(text_of(folder / "a.pfm") == text_of(folder / "c.pfm"));
  CHECK(text_of(folder / "a.png") != text_of(folder / "c.png"));
  CHECK(run(folder, options + "--tone aces").err.find("use clamp, reinhard or filmic") != std::string::npos);
  CHECK(run(folder, options + "--aov depths").exit_code == 2);
  using namespace gmis::tools;
  Diagnostics diagnostics;
  const LoadedScene loaded = load_scene(folder / "square.pbrt", std::array{8, 8});
  ThreadedExecutor executor(1);
  const auto layers = first_hit_layers(*loaded.built, {}, executor);
  REQUIRE(layers.size() == 3);
  const std::size_t middle = layers[0].image.index(4, 4);
  CHECK(layers[0].image.rgb[middle] == Approx(.125));
  CHECK(layers[0].image.rgb[middle + 2] == Approx(.5));
  CHECK(layers[1].image.rgb[middle + 2] == Approx(-1));
  CHECK(layers[2].image.rgb[middle] == Approx(4));
  CHECK(layers[2].image.rgb[layers[2].image.index(0, 0)] == 4.0F);
}

TEST_CASE("A caution names the pixels that rule the error, and what made the first of them") {
  using namespace gmis::tools;
  RenderResult result;
  result.image = Image(10, 5);
  result.error.emplace();
  result.error->doubt = gmis::ErrorDoubt::few_pixels;
  result.error->worst = {{{23, 0.5}, {7, 0.25}}};
  const RenderRequest request;
  const gmis::Plan plan{};
  std::string caution = caution_of(result, request, plan);
  CHECK(caution.find("75 % of the squared error is in the pixels 3,2 7,0; ") != std::string::npos);
  CHECK(caution.find("--integrator auto") == std::string::npos);
  gmis::Plan with_merging = plan;
  with_merging.techniques.back() = {gmis::Technique::merge, true, gmis::PlanRule::helps, {}};
  result.counts = gmis::integrators::bpt;
  CHECK(caution_of(result, request, with_merging)
            .find("--integrator auto would add merging, which this scene calls for") != std::string::npos);
  result.counts = gmis::integrators::vcm;
  CHECK(caution_of(result, request, with_merging).find("--integrator auto") == std::string::npos);
  TechniqueImage splat, connect;
  splat.id = {gmis::Technique::splat, 2, 1};
  connect.id = {gmis::Technique::connect, 2, 2};
  splat.weighted = connect.weighted = Image(10, 5);
  splat.weighted.rgb[3 * 23 + 1] = 9;
  connect.weighted.rgb[3 * 23] = 1;
  connect.weighted.rgb[3 * 7] = 50;
  result.techniques = {connect, splat};
  caution = caution_of(result, request, plan);
  CHECK(caution.find("(the first mostly by splats (s = 2, t = 1))") != std::string::npos);
  result.error->doubt = gmis::ErrorDoubt::none;
  CHECK(caution_of(result, request, plan).empty());
  result.error->doubt = gmis::ErrorDoubt::nothing_found;
  CHECK(caution_of(result, request, plan).find("nothing has been found yet") != std::string::npos);
}

TEST_CASE("Prices in words") {
  using namespace gmis::tools;
  CHECK(duration_text(0.0421) == "42 ms");
  CHECK(duration_text(1.52) == "1.5 s");
  CHECK(duration_text(94) == "94 s");
  CHECK(duration_text(18 * 60 + 20) == "18 min");
  CHECK(duration_text(3.2 * 3600) == "3.2 h");
  CHECK(duration_text(std::numeric_limits<double>::infinity()) == "never");
  gmis::PriceTable table;
  table.prices = {{0.05, 96, 12, 6, true},
                  {0.005, std::numeric_limits<double>::infinity(), 0, 0, false},
                  {0.02, 640, 80, 40, false}};
  const std::string text = text_of(std::optional(table));
  CHECK(text.find("5 %                   96        12 s       6.0 s  reached") != std::string::npos);
  CHECK(text.find("not in sight") != std::string::npos);
  CHECK(text.find("half of this         640        80 s        40 s  predicted") != std::string::npos);
  CHECK(text_of(std::optional<gmis::PriceTable>()).empty());
}

TEST_CASE("A choice tells its prices before the run, and a run with merging its bias beside its noise") {
  const ScratchFolder folder;
  const auto told = run(folder, "paper4 --size 16x16 --iterations 12 --explain --out a.pfm --stats a.json");
  INFO(told.err << told.out);
  REQUIRE(told.exit_code == 0);
  const auto json = nlohmann::json::parse(text_of(folder / "a.json"));
  // The law of the forecasts in the file.
  gmis::Choice choice;
  choice.expected_iterations = 12;
  const auto& chosen = json["choice"]["chosen"];
  for (const auto& one : json["choice"]["forecasts"]) {
    gmis::Forecast forecast;
    forecast.counts = {one["light_paths"], one["connections"], one["splats"], one["merges"]};
    forecast.counts.local_merges = one["local_merges"];
    forecast.counts.radius_factor = one["radius_factor"];
    forecast.variance = one["variance"];
    if (one == chosen) choice.chosen = choice.forecasts.size();
    choice.forecasts.push_back(forecast);
  }
  REQUIRE(choice.chosen.has_value());
  gmis::RenderSettings settings;
  settings.alpha = json["alpha"].get<double>();
  settings.sampler = gmis::Sampler::sobol;  // the default
  const auto law = gmis::expected_law(choice, choice.forecasts[*choice.chosen].counts, settings);
  CHECK(law.merging > 0);
  REQUIRE(json["forecast"].size() == 5);
  for (const auto& price : json["forecast"]) {
    const double error = price["error"];
    CHECK(price["iterations"].get<double>() == Approx(std::max(1.0, std::ceil(law.iterations_to_reach(error)))));
    CHECK(price["wall_seconds"].get<double>() > 0);
    CHECK_FALSE(price["is_reached"].get<bool>());
  }
  const std::size_t before = told.out.find("price       the pilot's forecast"), after = told.out.find("noise ");
  CHECK(before < told.out.find("12 iterations in "));
  CHECK(told.out.find("0.5 %", before) < after);
  REQUIRE(after != std::string::npos);
  CHECK(told.out.find(" %, bias of merging at most ", after) < told.out.find('\n', after));
  CHECK(json["estimate"]["merging_bias_bound"].get<double>() > json["estimate"]["merging_bias"].get<double>());

  const auto fixed =
      run(folder, "paper4 --size 16x16 --iterations 12 --integrator vcm --connections 1 --out a.pfm --stats a.json");
  CHECK(fixed.out.find(" %, bias of merging at most ") != std::string::npos);
  const auto fixed_json = nlohmann::json::parse(text_of(folder / "a.json"));
  CHECK(fixed_json["estimate"]["merging_bias_bound"].get<double>() > 0);
  CHECK(fixed_json["estimate"]["merging_bias_of_mean_error"].get<double>() > 0);
  CHECK(fixed_json["forecast"].empty());
  const auto unbiased =
      run(folder, "cornell --size 16x16 --iterations 12 --integrator bpt --connections 1 --out a.pfm --stats a.json");
  CHECK(unbiased.out.find("bias") == std::string::npos);
  const auto no_bias = nlohmann::json::parse(text_of(folder / "a.json"));
  for (const char* key : {"merging_bias", "merging_bias_bound", "merging_bias_of_mean", "merging_bias_of_mean_error",
                          "merging_bias_made_up"})
    CHECK(no_bias["estimate"][key] == 0.0);
}

TEST_CASE("--lights: how next events choose a light") {
  const ScratchFolder folder;
  std::ofstream(folder / "lamps.pbrt") << program::two_lamps_over_a_floor;
  const std::string same = "lamps.pbrt --size 16x16 --integrator pt --max-depth 2 --iterations 200 --out a.pfm ";
  const auto by_power = run(folder, same + "--explain --stats power.json");
  const auto by_receiver = run(folder, same + "--lights receiver --explain --stats receiver.json --checkpoint a.ck");
  INFO(by_power.err << by_receiver.err);
  REQUIRE(by_power.exit_code == 0);
  REQUIRE(by_receiver.exit_code == 0);
  CHECK(by_power.out.find("as the receiver sees them") == std::string::npos);
  CHECK(
      by_receiver.out.find("lights      of next events by power, distance and orientation as the receiver sees them") !=
      std::string::npos);
  const auto power = nlohmann::json::parse(text_of(folder / "power.json"));
  const auto receiver = nlohmann::json::parse(text_of(folder / "receiver.json"));
  CHECK(power["lights"] == "power");
  CHECK(receiver["lights"] == "receiver");
  // The same light with less noise: near a lamp the other one is hardly ever chosen. Means of
  // 51,200 samples: six standard errors are a false alarm in 1e9 pictures.
  const double variance = power["estimate"]["variance"], other = receiver["estimate"]["variance"];
  CHECK(other < variance / 2);
  CHECK(std::abs(power["estimate"]["mean"].get<double>() - receiver["estimate"]["mean"].get<double>()) <
        6 * std::sqrt((variance + other) / 256));
  const auto refused = run(folder, same + "--resume a.ck");
  CHECK(refused.exit_code == 2);
  CHECK(refused.err.find("the choice of lights differs: receiver, not power") != std::string::npos);
  CHECK(run(folder, same + "--lights all").err.find("--lights \"all\" is not known: use power, receiver or learned") !=
        std::string::npos);
  // A run that measures the gain takes the better one; auto does so by itself, and again when it is
  // resumed.
  const auto by_gain = run(folder, same + "--lights learned --explain --stats learned.json");
  REQUIRE(by_gain.exit_code == 0);
  CHECK(by_gain.out.find("lights      for next events chosen for the receiver: ") != std::string::npos);
  const auto learned = nlohmann::json::parse(text_of(folder / "learned.json"));
  CHECK(learned["image_hash"] == receiver["image_hash"]);
  CHECK(learned["light_use"]["chooses_for_receiver"] == true);
  CHECK(learned["light_use"]["receiver_gain"] > 1.25);
  CHECK(learned["light_use"]["emission_gain"].is_null());
  CHECK(power["light_use"]["chooses_for_receiver"] == false);
  CHECK(power["light_use"]["receiver_gain"].is_null());
  CHECK(receiver["light_use"]["chooses_for_receiver"] == true);
  const std::string automatic = "lamps.pbrt --size 16x16 --max-depth 3 --out a.pfm --quiet ";
  REQUIRE(run(folder, automatic + "--iterations 6 --stats whole.json").exit_code == 0);
  REQUIRE(run(folder, automatic + "--iterations 3 --checkpoint b.ck").exit_code == 0);
  REQUIRE(run(folder, automatic + "--iterations 6 --resume b.ck --stats resumed.json").exit_code == 0);
  const auto whole = nlohmann::json::parse(text_of(folder / "whole.json"));
  CHECK(whole["lights"] == "learned");
  CHECK(whole["emission"] == "learned");
  const auto resumed = nlohmann::json::parse(text_of(folder / "resumed.json"));
  CHECK(resumed["image_hash"] == whole["image_hash"]);
  CHECK(resumed["light_use"] == whole["light_use"]);
  CHECK(whole["light_use"]["emission_gain"].is_number());
  // A checkpoint holds it: runs are joined without learning anything.
  REQUIRE(run(folder, automatic + "--iterations 3 --seed 5 --checkpoint c.ck").exit_code == 0);
  REQUIRE(run(folder, automatic + "--iterations 3 --resume b.ck --resume c.ck --stats joined.json").exit_code == 0);
  CHECK(nlohmann::json::parse(text_of(folder / "joined.json"))["light_use"] == whole["light_use"]);
}

TEST_CASE("--emission: where light subpaths start") {
  const ScratchFolder folder;
  std::ofstream(folder / "far.pbrt") << R"(LookAt 0 2 -6 0 0 0 0 1 0 Camera "perspective" "float fov" 60
WorldBegin
Shape "bilinearmesh" "point3 P" [ -3 0 -3  3 0 -3  -3 0 3  3 0 3 ]
AreaLightSource "diffuse" "rgb L" [ 60 56 48 ]
Translate 500 800 -300
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "sphere" "float radius" 100
)";
  const std::string same = "far.pbrt --size 16x16 --integrator vcm --connections 1 --out a.pfm ";
  const auto by_power = run(folder, same + "--iterations 6 --stats power.json --explain");
  const auto learned = run(folder, same + "--iterations 6 --emission learned --stats learned.json --explain");
  INFO(by_power.err << learned.err);
  REQUIRE(by_power.exit_code == 0);
  REQUIRE(learned.exit_code == 0);
  CHECK(by_power.out.find("learned: where their light is needed") == std::string::npos);
  CHECK(learned.out.find("learned: where their light is needed") != std::string::npos);
  const auto power = nlohmann::json::parse(text_of(folder / "power.json"));
  const auto other = nlohmann::json::parse(text_of(folder / "learned.json"));
  CHECK(power["emission"] == "power");
  CHECK(other["emission"] == "learned");
  CHECK(power["light_use"]["guides_emission"] == false);
  CHECK(other["light_use"]["guides_emission"] == true);
  CHECK(other["light_use"]["emission_gain"] > 2.5);
  CHECK(learned.out.find("emission    guided: the learned guide divides the second moment of arriving light by ") !=
        std::string::npos);
  // By power a light subpath meets the floor with a probability of 36/(4π 990²) · 0.8 = 2.4e-6: of
  // 1536, hardly one in 270 runs.
  CHECK(power["counts"]["photons_stored"] < 3);
  CHECK(other["counts"]["photons_stored"] > 400);

  // A run that goes on has the same bits: it learns the same.
  REQUIRE(run(folder, same + "--iterations 3 --emission learned --quiet --checkpoint a.ck").exit_code == 0);
  const auto resumed =
      run(folder, same + "--iterations 6 --emission learned --quiet --resume a.ck --stats resumed.json");
  INFO(resumed.err);
  REQUIRE(resumed.exit_code == 0);
  CHECK(nlohmann::json::parse(text_of(folder / "resumed.json"))["image_hash"] == other["image_hash"]);
  const auto refused = run(folder, same + "--iterations 6 --resume a.ck");
  CHECK(refused.exit_code == 2);
  CHECK(refused.err.find("the emission differs") != std::string::npos);
  CHECK(run(folder, same + "--emission all").err.find("--emission \"all\" is not known: use power or learned") !=
        std::string::npos);
}

TEST_CASE("Progress: within an iteration, and what is not known is not 0") {
  using gmis::tools::Progress;
  gmis::Budget goal;
  goal.iterations = 10;
  Progress progress(goal, 50);
  CHECK(progress.fraction_done(0, 0) == 0);
  CHECK_FALSE(progress.seconds_left(0, 0).has_value());
  CHECK(progress.line(0, 0).find("0 iterations  0.0 s  left –  error –") != std::string::npos);
  CHECK(progress.fraction_done(1, 25) == Approx(0.05));  // half of the first of ten
  CHECK(*progress.seconds_left(1, 25) == Approx(19));    // half took one second
  CHECK(progress.fraction_done(9, 500) == Approx(0.099));
  // It had 80 pieces after all, and took 4 s.
  progress.end_iteration({1, 4.0, 0.0, false}, 80);
  CHECK(progress.fraction_done(0, 80) == Approx(0.1));
  CHECK(progress.fraction_done(1, 100) == Approx(0.125));
  CHECK(*progress.seconds_left(1, 100) == Approx(8.75 * 4));
  CHECK(progress.line(1, 100).find("1 iterations  5.0 s  left 35 s  error –") != std::string::npos);
  progress.end_iteration({2, 6.0, 0.25, false}, 160);
  CHECK(*progress.seconds_left(0, 160) == Approx(8 * (4 + 0.3 * (2 - 4))));  // the latest iterations count most
  CHECK(progress.line(0, 160).find("error 0.250") != std::string::npos);
  // Between two estimates the last one stays.
  progress.end_iteration({3, 8.0, 0.0, false}, 240);
  CHECK(progress.line(0, 240).find("error 0.250") != std::string::npos);

  // A time, and an error: the nearest limit counts.
  Progress timed({{}, 20.0, 0.05}, 1);
  CHECK(*timed.seconds_left(5, 0) == Approx(15));
  CHECK(timed.fraction_done(5, 0) == Approx(0.25));
  timed.end_iteration({16, 8.0, 0.1, true}, 16);  // of a run that was resumed: four times as many iterations are needed
  CHECK(timed.fraction_done(0, 16) == Approx(0.4));
  CHECK(*timed.seconds_left(0, 16) == Approx(12));
  timed.end_iteration({32, 10.0, 0.0505, true}, 32);
  CHECK(timed.fraction_done(0, 32) > 0.97);
  CHECK(*timed.seconds_left(0, 32) < 1);
  // Nothing but an error, which is not known yet.
  Progress blind({{}, {}, 0.05}, 10);
  blind.end_iteration({1, 2.0, 0.0, false}, 10);
  CHECK_FALSE(blind.seconds_left(0, 10).has_value());
  CHECK(blind.fraction_done(0, 10) == 0);
}

TEST_CASE("Pieces of work are reported, by no two threads at once") {
  for (const int threads : {1, 3}) {
    gmis::tools::ThreadedExecutor executor(threads);
    std::size_t last = 0, reports = 0;
    std::atomic<int> inside{0};
    bool is_alone = true;
    executor.report_to([&](std::size_t done) {
      is_alone = is_alone && ++inside == 1;
      last = std::max(last, done);
      ++reports;
      --inside;
    });
    for (int loop = 0; loop < 3; ++loop) executor.parallel_for(100, [](std::size_t) {});
    CHECK(is_alone);
    CHECK(reports >= 1);
    CHECK(last <= 300);
    if (threads == 1) CHECK((last == 300 && reports == 300));
    executor.report_to({});
    const std::size_t before = reports;
    executor.parallel_for(100, [](std::size_t) {});
    CHECK(reports == before);
  }
}

TEST_CASE("Without --out the film's file name is used") {
  const ScratchFolder folder;
  std::ofstream(folder / "named.pbrt") << "Film \"rgb\" \"string filename\" \"mine.pfm\"\nWorldBegin\n"
                                          "LightSource \"point\"\nTranslate 0 0 3 Shape \"sphere\"\n";
  CHECK(run(folder, "named.pbrt --size 4x4 --iterations 1").exit_code == 0);
  CHECK(fs::exists(folder / "mine.pfm"));
  std::ofstream(folder / "odd.pbrt") << "Film \"rgb\" \"string filename\" \"odd.tga\"\nWorldBegin\n"
                                        "LightSource \"point\"\nTranslate 0 0 3 Shape \"sphere\"\n";
  CHECK(run(folder, "odd.pbrt --size 4x4 --iterations 1").exit_code == 0);
  CHECK(fs::exists(folder / "odd.pfm"));
}

TEST_CASE("The picture on disk is current while the run goes on") {
  const ScratchFolder folder;
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    if (chdir(folder.path.c_str()) != 0) _exit(99);
    execl(GMIS_RENDER_PROGRAM, "gmis-render", "cornell", "--size", "16x16", "--iterations", "100000000", "--quiet",
          "--write-every", "0", "--out", "c.pfm", static_cast<char*>(nullptr));
    _exit(98);
  }
  // Whenever it is looked at, it is whole; and it changes.
  std::string first, latest;
  for (int i = 0; i < 600 && (first.empty() || first == latest); ++i) {
    usleep(100'000);
    if (!fs::exists(folder / "c.pfm")) continue;
    CHECK(gmis::tools::read_image(folder / "c.pfm").width == 16);
    latest = text_of(folder / "c.pfm");
    if (first.empty()) first = latest;
  }
  CHECK(first != latest);
  REQUIRE(kill(child, SIGKILL) == 0);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(gmis::tools::read_image(folder / "c.pfm").width == 16);
}

TEST_CASE("Ctrl-C writes what there is") {
  const ScratchFolder folder;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      if (chdir(folder.path.c_str()) != 0) _exit(99);
      std::signal(SIGINT, SIG_IGN);
      std::signal(signal, SIG_DFL);  // what runs this test may ignore it
      execl(GMIS_RENDER_PROGRAM, "gmis-render", "cornell", "--size", "32x32", "--iterations", "100000000", "--quiet",
            "--out", "c.pfm", "--stats", "c.json", "--log", "c.csv", static_cast<char*>(nullptr));
      _exit(98);
    }
    // The header, and three iterations.
    int status = 0;
    REQUIRE(wait_for(child, folder / "c.csv", "\n", 4, status));
    if (signal != SIGINT) {  // what is ignored stays ignored: the log grows
      REQUIRE(kill(child, SIGINT) == 0);
      REQUIRE(wait_for(child, folder / "c.csv", "\n", 8, status));
    }
    REQUIRE(kill(child, signal) == 0);
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
    const Json json = Json::parse(text_of(folder / "c.json"));
    CHECK(json["stopped_by"] == "interrupt");
    const int iterations = json["iterations"].get<int>();
    CHECK(iterations >= 3);
    const int of_pilot = json["choice"]["pilot_iterations"].get<int>();  // of all pixels of so small a picture
    CHECK(json["counts"]["camera_paths"].get<long>() == 1024L * (iterations + of_pilot));
    const auto image = gmis::tools::read_image(folder / "c.pfm");
    CHECK(image.width == 32);
    CHECK(gmis::tools::image_hash(image) == json["image_hash"]);
    fs::remove(folder / "c.pfm");
    fs::remove(folder / "c.csv");
  }
}

#if GMIS_HAS_OPENEXR

TEST_CASE(
    "One .exr has the picture, what is seen first, the variance, the classes and the techniques, and how it was made") {
  using namespace gmis::tools;
  const ScratchFolder folder;
  const std::string common =
      "cornell --size 16x16 --max-depth 4 --iterations 8 --integrator bpt --connections 1 --seed 3 ";
  REQUIRE(run(folder, common + "--quiet --halves --out a.exr --out a.pfm --aov layers,classes,techniques").exit_code ==
          0);
  const auto layer = [&](const std::string& name, const std::string& channels) {
    Imf::InputFile file((folder / "a.exr").c_str());
    Image image(16, 16);
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const std::string channel = name + "." + channels[c];
      CAPTURE(channel);
      REQUIRE(file.header().channels().findChannel(channel.c_str()) != nullptr);
      frame.insert(channel.c_str(), {Imf::FLOAT, reinterpret_cast<char*>(image.rgb.data() + c), 3 * sizeof(float),
                                     std::size_t{3} * sizeof(float) * 16});
    }
    file.setFrameBuffer(frame);
    file.readPixels(0, 15);
    return image;
  };
  for (const auto& [name, channels] :
       {std::pair("albedo", "RGB"), std::pair("normal", "XYZ"), std::pair("depth", "Z"), std::pair("variance", "RGB")})
    (void)layer(name, channels);
  const Image picture = read_image(folder / "a.exr");
  // Techniques add up to the picture, as classes do.
  Imf::InputFile file((folder / "a.exr").c_str());
  Image techniques(16, 16), classes(16, 16);
  int technique_count = 0, class_count = 0;
  for (auto i = file.header().channels().begin(); i != file.header().channels().end(); ++i) {
    const std::string channel = i.name();
    if (channel.size() < 3 || channel.substr(channel.size() - 2) != ".R") continue;
    const std::string name = channel.substr(0, channel.size() - 2);
    if (name == "albedo" || name == "variance") continue;
    const bool is_technique = name.find("_s") != std::string::npos;
    (is_technique ? technique_count : class_count) += 1;
    const Image part = layer(name, "RGB");
    Image& sum = is_technique ? techniques : classes;
    for (std::size_t k = 0; k < part.rgb.size(); ++k) sum.rgb[k] += part.rgb[k];
  }
  CHECK(technique_count > 5);
  CHECK(class_count > 1);
  for (std::size_t k = 0; k < picture.rgb.size(); ++k) {
    CHECK(techniques.rgb[k] == Approx(picture.rgb[k]).margin(1e-5));
    CHECK(classes.rgb[k] == Approx(picture.rgb[k]).margin(1e-5));
  }
  // The variance, against that of two halves: E (a − b)² / 4, pixel by pixel too noisy, but not in
  // the mean.
  const Image a = read_image(folder / "a_a.exr"), b = read_image(folder / "a_b.exr"),
              variance = layer("variance", "RGB");
  double by_halves = 0, stated = 0;
  for (std::size_t k = 0; k < a.rgb.size(); ++k) {
    // Each pixel by the size of its value, so that few do not rule.
    const double scale = 1 / (0.01 + double(picture.rgb[k]) * double(picture.rgb[k]));
    by_halves += scale * std::pow(double(a.rgb[k]) - double(b.rgb[k]), 2) / 4;
    stated += scale * double(variance.rgb[k]);
  }
  CHECK(stated > 0.4 * by_halves);
  CHECK(stated < 2.5 * by_halves);
  for (const char* note :
       {"gmis:version", "gmis:commandLine", "gmis:seed", "gmis:iterations", "gmis:plan", "gmis:radius"})
    CHECK(file.header().findTypedAttribute<Imf::StringAttribute>(note) != nullptr);
  CHECK(file.header().typedAttribute<Imf::StringAttribute>("gmis:seed").value() == "3");
  CHECK(file.header().typedAttribute<Imf::StringAttribute>("gmis:commandLine").value().find("--halves") !=
        std::string::npos);
}

#endif

TEST_CASE("Surfaces that enclose the camera and no light are said") {
  const ScratchFolder folder;
  const auto write = [&](const std::string& shape) {
    std::ofstream(folder / "closed.pbrt") << "LookAt 0 0 0  0 0 1  0 1 0\nCamera \"perspective\"\nWorldBegin\n"
                                             "LightSource \"infinite\"\nMaterial \"diffuse\"\n"
                                          << shape;
  };
  const std::string line = "surfaces enclose the camera";
  const std::string arguments = "closed.pbrt --size 8x8 --iterations 2 --out a.pfm";
  write("Shape \"sphere\"\n");
  CHECK(run(folder, arguments).err.find(line) != std::string::npos);
  CHECK(run(folder, arguments + " --quiet").err.empty());
  write("Shape \"sphere\" \"float zmax\" .8\n");  // open at the top
  CHECK(run(folder, arguments).err.find(line) == std::string::npos);
  write("AreaLightSource \"diffuse\"\nReverseOrientation\nShape \"sphere\"\n");  // it shines inwards
  CHECK(run(folder, arguments).err.find(line) == std::string::npos);
}

TEST_CASE("A reference that is a whole number of times as large is compared by its blocks") {
  using namespace gmis::tools;
  using gmis::PixelBounds;
  const ScratchFolder folder;
  // Every pixel of a sky of radiance 0.5 is exact, so that the error is exactly that of the
  // numbers.
  std::ofstream(folder / "sky.pbrt") << "Camera \"perspective\"\nWorldBegin\n"
                                        "LightSource \"infinite\" \"rgb L\" [.5 .5 .5]\n"
                                        "Translate 0 0 -5 Shape \"sphere\"\n";
  const std::string plain = "sky.pbrt --iterations 1 --quiet ";
  REQUIRE(run(folder, plain + "--size 12x8 --out large.pfm").exit_code == 0);
  const Json json = statistics(folder, plain + "--size 6x4 --reference large.pfm");
  CHECK(json["error"]["relmse"] == 0);
  CHECK(json["error"]["ratio_of_means"] == 1);
  for (const char* size : {"--size 5x4", "--size 6x8"}) {
    CAPTURE(size);
    const Outcome refused = run(folder, plain + size + " --out a.pfm --reference large.pfm");
    CHECK(refused.exit_code == 2);
    CHECK(refused.err.find("this reference is 12x8") != std::string::npos);
  }

  // The same picture against one that has another value in every texel: 1 + x² + 20 y + x y + c/4,
  // x to the right, y downwards, c the channel. The mean over the block of 2 × 2 that begins at
  // (2 X, 2 Y) is, by hand,
  // 1 + (4 X² + 2 X + 1/2) + 20 (2 Y + 1/2) + (2 X + 1/2) (2 Y + 1/2) + c/4.
  Image slope(12, 8);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 12; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        slope.rgb[slope.index(x, y) + c] = static_cast<float>(1 + x * x + 20 * y + x * y) + 0.25F * float(c);
  write_image(slope, folder / "slope.pfm");
  const auto block = [](int x, int y, std::size_t c) {
    return 1 + (4 * x * x + 2 * x + 0.5) + 20 * (2 * y + 0.5) + (2 * x + 0.5) * (2 * y + 0.5) + 0.25 * double(c);
  };
  CHECK(block(0, 0, 0) == (1 + 2 + 21 + 23) / 4.0);  // texels (0, 0), (1, 0), (0, 1), (1, 1)
  CHECK(block(5, 3, 0) == (1 + 100 + 120 + 60 + 1 + 121 + 120 + 66 + 1 + 100 + 140 + 70 + 1 + 121 + 140 + 77) / 4.0);
  for (const PixelBounds& part :
       {PixelBounds{{0, 0}, {6, 4}}, PixelBounds{{4, 1}, {5, 2}}, PixelBounds{{1, 2}, {4, 4}}}) {
    RenderRequest request;
    request.crop = part;
    const glm::ivec2 size = part.upper - part.lower;
    const Image reduced = read_reference(folder / "slope.pfm", request, {6, 4});
    REQUIRE(reduced.width == size.x);
    REQUIRE(reduced.height == size.y);
    double error = 0, sum = 0;
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        for (std::size_t c = 0; c < 3; ++c) {
          CAPTURE(x, y, c);
          const double wanted = block(part.lower.x + x, part.lower.y + y, c);
          CHECK(reduced.rgb[reduced.index(x, y) + c] == static_cast<float>(wanted));  // exact in float
          error += std::pow(0.5 - wanted, 2) / (wanted * wanted + 0.01) / (3.0 * size.x * size.y);
          sum += wanted / (3.0 * size.x * size.y);
        }
    const auto number = [](int i) { return std::to_string(i); };
    const Json sloping =
        statistics(folder, plain + "--size 6x4 --reference slope.pfm --crop " + number(part.lower.x) + "," +
                               number(part.lower.y) + "," + number(part.upper.x) + "," + number(part.upper.y));
    // The picture is 0.5 in float, a reference as stated above.
    CHECK(sloping["error"]["relmse"].get<double>() == Approx(error).epsilon(1e-6));
    CHECK(sloping["error"]["ratio_of_means"].get<double>() == Approx(0.5 / sum).epsilon(1e-6));
  }
}

TEST_CASE("A glTF camera that surfaces hide from the sky moves out, and from glass or a lamp it does not") {
  const ScratchFolder folder;
  // A box of 12 triangles from -1 to 1, the camera at its middle.
  const std::string box =
      "AACAvwAAgL8AAIC/AACAPwAAgL8AAIC/AACAvwAAgD8AAIC/AACAPwAAgD8AAIC/AACAvwAAgL8AAIA/AACAPwAAgL8AAIA/AACAvwAAgD8AAIA/"
      "AACAPwAAgD8AAIA/AAECAQMCBAYFBQYHAAQBAQQFAgMGAwcGAAIEAgYEAQUDAwUH";
  const auto write = [&](const std::string& material) {
    std::ofstream(folder / "box.gltf")
        << R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],"scene":0,"nodes":[{"mesh":0},{"camera":0}],)"
        << R"("cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],)"
        << R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],)"
        << R"("accessors":[{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]},)"
        << R"({"bufferView":1,"componentType":5121,"count":36,"type":"SCALAR"}],)"
        << R"("bufferViews":[{"buffer":0,"byteLength":96},{"buffer":0,"byteOffset":96,"byteLength":36}],)"
        << R"("buffers":[{"byteLength":132,"uri":"data:application/octet-stream;base64,)" << box << R"("}],)"
        << R"("materials":[)" << material << "]}";
  };
  const auto mean_and_text = [&](const std::string& more = "") {
    const std::string arguments = "box.gltf --size 16x16 --iterations 2 --out a.pfm --stats s.json" + more;
    const Outcome outcome = run(folder, arguments);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    const double mean = Json::parse(text_of(folder / "s.json"))["estimate"]["mean"];
    return std::pair{mean, outcome.err.find("surfaces enclose the camera") != std::string::npos};
  };
  write("{}");
  CHECK(mean_and_text().second);
  CHECK(mean_and_text().first > 0);
  write(R"({"emissiveFactor":[1,1,1]})");
  CHECK(!mean_and_text().second);
  write(
      R"({"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}})");
  CHECK(!mean_and_text().second);
}

TEST_CASE("A coat of index 1 may have a texture of roughness") {
  const ScratchFolder folder;
  std::ofstream(folder / "plain.pbrt")
      << "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n"
         "Texture \"r\" \"float\" \"checkerboard\" \"float tex1\" .2 \"float tex2\" .8\n"
         "Material \"coateddiffuse\" \"texture roughness\" \"r\" \"float eta\" 1\n"
         "Translate 0 0 3 Shape \"sphere\"\n";
  const Outcome outcome = run(folder, "plain.pbrt --size 4x4 --iterations 1 --quiet --out a.pfm");
  INFO(outcome.err);
  CHECK(outcome.exit_code == 0);
}

TEST_CASE("A camera whose axes are rounded to six digits is accepted") {
  const ScratchFolder folder;
  // Products of the axes: 1.4e-7, 9.2e-6, 6.6e-9.
  std::ofstream(folder / "rounded.pbrt")
      << "Transform [-0.00561587 -0.488405 -0.872599 0  0 0.872613 -0.488413 0  -0.999984 0.00273835 0.00489243 0  "
         "-0.0423531 -2.39555 27.8941 1]\nCamera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n"
         "Shape \"sphere\"\n";
  const Outcome outcome = run(folder, "rounded.pbrt --size 4x4 --iterations 1 --quiet --out a.pfm");
  INFO(outcome.err);
  CHECK(outcome.exit_code == 0);
}
