#include <fstream>
#include <string>

#include "program/program.hpp"
#include "support/catch.hpp"

// gmis-compare as a user runs it.

using namespace program;

namespace {

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// One page, whole, that asks for nothing from elsewhere.
void check_page(const std::string& page) {
  CHECK(page.starts_with("<!doctype html>"));
  CHECK(page.ends_with("</html>\n"));
  CHECK(occurrences(page, "<section") == occurrences(page, "</section>"));
  CHECK(occurrences(page, "<table") == occurrences(page, "</table>"));
  CHECK(occurrences(page, "<svg") == occurrences(page, "</svg>"));
  CHECK(occurrences(page, "src=\"") == 0);
  CHECK(occurrences(page, "<link") == 0);
  CHECK(occurrences(page, "http") == occurrences(page, "http://www.w3.org/"));  // the names of namespaces
}

}  // namespace

TEST_CASE("Bad usage of gmis-compare: exit code 2 and one line that says what to change") {
  const ScratchFolder folder;
  std::ofstream(folder / "nan.pfm", std::ios::binary) << "PF\n1 1\n-1.0\n" << std::string(12, '\xFF');
  struct Case {
    const char* arguments;
    const char* start;  ///< of the line, after the name of the program
    const char* end;    ///< of the line
  };
  // Lines of our own are there word by word; of those that end with "see --help" the parser of
  // options words the middle.
  for (const auto& [arguments, start, end] :
       {Case{"", "", "scenes is required; see --help"},
        Case{"no_such_scene", "no_such_scene: there is no such file and no built-in scene of that name: ",
             "see gmis-render --list-scenes"},
        Case{"cornell no_such_scene", "no_such_scene: there is no such file and no built-in scene of that name: ",
             "see gmis-render --list-scenes"},
        Case{"cornell --integrators pt,magic",
             "--integrators \"magic\" is not known: ", "use auto, pt, lt, bpt, ppm, bpm, vcm or gmis"},
        Case{"cornell --integrators vcm/paper", "\"vcm/paper\": ", "only gmis splits"},
        Case{"cornell --integrators gmis/odd",
             "--integrators \"odd\" is not known: ", "use local, none, paper or budgeted"},
        Case{"cornell --reference-integrator magic",
             "--reference-integrator \"magic\" is not known: ", "use auto, pt, lt, bpt, ppm, bpm, vcm or gmis"},
        Case{"cornell --size 1x1 --reference nan.pfm",
             "nan.pfm: ", "this reference has a value that is no number or above 1e20"},
        Case{"cornell --out /proc/x", "--out /proc/x: ", "this folder cannot be created"},
        Case{"cornell cornell.pbrt", "cornell and cornell.pbrt would write the same files, cornell_*: ",
             "rename one, or compare them one by one, each with a folder of its own in --out"},
        Case{"cornell --time 0", "--time ", "must be above 0 and finite"},
        Case{"cornell --error inf", "--error ", "must be above 0 and finite"},
        Case{"cornell --light-paths nan", "--light-paths ", "must be above 0 and finite"},
        Case{"cornell --alpha nan", "--alpha ", "must be above 0 and at most 1"},
        Case{"cornell --seed -1", "--seed \"-1\" ", "must be a whole number from 0 to 18446744073709551615"},
        Case{"cornell --seeds 0", "--seeds: ", "; see --help"},
        Case{"cornell --size big", "--size \"big\" ", "must be WIDTHxHEIGHT, each from 1 to 32768"},
        Case{"cornell paper1 --reference a.pfm", "--reference is for one scene: ", "name one, or leave the option out"},
        Case{"cornell --reference absent.pfm", "absent.pfm: ", "this image is missing: check its name"},
        Case{"cornell --reference-integrator bpt,pt", "--reference-integrator ",
             "must name one integrator, or one for each scene"},
        Case{"cornell --frobnicate", "", "--frobnicate; see --help"}}) {
    const Outcome outcome = run(folder, arguments);
    CAPTURE(arguments, outcome.err);
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.out.empty());
    CHECK(line_count(outcome.err) == 1);
    const std::string first = "gmis-compare: " + std::string(start), last = std::string(end) + "\n";
    CHECK(outcome.err.starts_with(first));
    CHECK(outcome.err.ends_with(last));
    if (!last.ends_with("see --help\n")) CHECK(outcome.err == first + last);
  }
}

TEST_CASE("A comparison leaves a report, its tables, its logs and a reference that is used again") {
  const ScratchFolder folder;
  const std::string command =
      "cornell --integrators pt,vcm,gmis/none --size 8x6 --radius 0.02u --time 0.1 --seeds 2 --out here";
  const Outcome first = run(folder, command);
  INFO(first.err);
  REQUIRE(first.exit_code == 0);
  CHECK(first.out.find("making a reference") != std::string::npos);
  CHECK(first.out.find("efficiency, vcm = 1") != std::string::npos);
  const std::string page = text_of(folder.path / "here/report.html");
  check_page(page);
  for (const char* part : {"gmis-render cornell --integrator pt --size 8x6", "href=\"cornell_vcm.exr\"", "SMAPE",
                           "too few seeds", " --radius 0.02u", "data-loupe", "data-stops", "gmis/none",
                           "bpt (unbiased)", "<td data-name=\"slope\">", "2 seeds", "merging bias"}) {
    CAPTURE(part);
    CHECK(page.find(part) != std::string::npos);
  }
  CHECK(page.find("interrupted:") == std::string::npos);
  CHECK(text_of(folder.path / "here/report.md").starts_with("### cornell\n\n| integrator |"));
  for (const char* name : {"cornell_pt_seed0.csv", "cornell_vcm_seed1.csv", "cornell_none_seed0.csv"}) {
    CAPTURE(name);
    const std::string log = text_of(folder.path / "here" / name);
    CHECK(log.starts_with("cpu_seconds,"));
    CHECK(line_count(log) > 1);  // the first iteration has a line, however slow the machine is
  }
  const Outcome second = run(folder, command);
  CHECK(second.exit_code == 0);
  CHECK(second.out.find("making a reference") == std::string::npos);
  CHECK(second.out.find("seed 2 of 2") != std::string::npos);
}

TEST_CASE("A scene that was edited gets a reference of its own") {
  const ScratchFolder folder;
  std::ofstream(folder / "a.pbrt") << "LookAt 0 0 -4 0 0 0 0 1 0 Camera \"perspective\" WorldBegin\n"
                                      "LightSource \"infinite\" Shape \"sphere\"\n";
  const std::string command = "a.pbrt --integrators pt --size 8x6 --time 0.05 --seeds 1 --out here";
  const auto makes_reference = [&] {
    const Outcome outcome = run(folder, command);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    return outcome.out.find("making a reference") != std::string::npos;
  };
  CHECK(makes_reference());
  CHECK_FALSE(makes_reference());
  std::ofstream(folder / "a.pbrt", std::ios::app) << "# a word\n";
  CHECK(makes_reference());
}

TEST_CASE("The curves of all scenes as one picture") {
  const ScratchFolder folder;
  const Outcome nowhere = run(folder, "cornell --figure absent/all.svg");
  CHECK(nowhere.exit_code == 2);
  CHECK(nowhere.out.empty());  // before the first rendering
  const Outcome drawn =
      run(folder, "cornell paper2 --integrators pt,vcm --size 8x6 --time 0.05 --seeds 1 --out here --figure all.svg");
  if (drawn.err.find("gnuplot was not found") != std::string::npos) {
    CHECK(drawn.exit_code == 2);
    CHECK(drawn.err.find("--figure all.svg") != std::string::npos);
    return;
  }
  INFO(drawn.err);
  REQUIRE(drawn.exit_code == 0);
  const std::string svg = text_of(folder.path / "all.svg");
  CHECK(svg.starts_with("<svg xmlns"));
  CHECK(svg.ends_with("</svg>\n"));
  CHECK(occurrences(svg, "<svg") == 3);
  CHECK(occurrences(svg, "</svg>") == 3);
  for (const char* part : {">cornell</text>", ">paper2</text>", "--series-2", "prefers-color-scheme:dark"})
    CHECK(svg.find(part) != std::string::npos);
}

TEST_CASE("Ctrl-C in the middle of a comparison leaves a valid report of the results so far") {
  const ScratchFolder folder;
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    if (chdir(folder.path.c_str()) != 0) _exit(99);
    std::signal(SIGINT, SIG_DFL);  // what runs this test may ignore it
    if (std::freopen("said.txt", "w", stdout) == nullptr) _exit(97);
    execl(GMIS_RENDER_PROGRAM, "gmis-compare", "cornell", "paper1", "--size", "8x8", "--time", "1000",
          "--reference-time", "0.2", "--out", "here", static_cast<char*>(nullptr));
    _exit(98);
  }
  int status = 0;
  REQUIRE(wait_for(child, folder / "said.txt", "seed 1 of", 1, status));
  REQUIRE(kill(child, SIGINT) == 0);
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  const std::string page = text_of(folder.path / "here/report.html");
  check_page(page);
  CHECK(page.find("interrupted:") != std::string::npos);
  CHECK(page.find("<td data-name=\"slope\">") != std::string::npos);
}
