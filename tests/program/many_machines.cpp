#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "gmis/core/random.hpp"
#include "program.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace program;

namespace {

#ifdef GMIS_RENDER_MPI_PROGRAM
/// Open MPI starts nothing for root, nor more ranks than processors, unless it is told to.
const std::string mpirun =
    "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 "
    "'" GMIS_MPIRUN_PROGRAM "' ";

Outcome run_shell(const ScratchFolder& folder, const std::string& command) {
  const int status =
      std::system(("cd '" + folder.path.string() + "' && " + command + " >stdout.txt 2>stderr.txt </dev/null").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(folder / "stdout.txt"), text_of(folder / "stderr.txt")};
}

Outcome run_on(const ScratchFolder& folder, int ranks, const std::string& arguments) {
  return run_shell(folder, mpirun + "-n " + std::to_string(ranks) + " '" GMIS_RENDER_MPI_PROGRAM "' " + arguments);
}
#endif

}  // namespace

TEST_CASE("the script that renders parts of a run writes the picture of one command") {
  const ScratchFolder folder;
  const std::string same = "cornell --size 12x10 --integrator vcm --connections 1 --seed 3 --threads 1 --quiet";
  REQUIRE(run(folder, same + " --iterations 12 --out whole.pfm").exit_code == 0);
  const std::string path = fs::path(GMIS_RENDER_PROGRAM).parent_path().string();
  const std::string command = "cd '" + folder.path.string() + "' && PATH='" + path +
                              "':\"$PATH\" sh '" GMIS_PARTS_SCRIPT "' parts.pfm 4 2 3 " + same +
                              " >stdout.txt 2>stderr.txt";
  const int status = std::system(command.c_str());
  INFO(text_of(folder / "stderr.txt"));
  REQUIRE(status == 0);
  CHECK(text_of(folder / "parts.pfm") == text_of(folder / "whole.pfm"));
  CHECK(text_of(folder / "parts.pfm.1.pfm") != text_of(folder / "whole.pfm"));
}

TEST_CASE("a part of a run that cannot be rendered apart is refused with exit code 2 and a message") {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& arguments, const std::string& part) {
    const Outcome outcome = run(folder, "paper1 --size 8x8 --quiet --out a.pfm " + arguments);
    INFO(arguments << ": " << outcome.err);
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.err.find(part) != std::string::npos);
    CHECK(line_count(outcome.err) == 1);
  };
  refused("--checkpoint a.ck --iterations 1..2/4", "merging");
  refused("--checkpoint a.ck --iterations 1..2", "must be FIRST..LAST/OF");
  refused("--checkpoint a.ck --iterations 3..2/4", "must be FIRST..LAST/OF");
  refused("--checkpoint a.ck --iterations 1..5/4", "must be FIRST..LAST/OF");
  refused("--checkpoint a.ck --iterations x..2/4", "must be FIRST..LAST/OF");
  refused("--iterations 1..2/4", "needs --checkpoint");
  refused("--checkpoint a.ck --iterations 1..2/4 --time 1", "excludes --time");
  const std::string pt = "paper1 --size 8x8 --quiet --integrator pt --out a.pfm ";
  REQUIRE(run(folder, pt + "--checkpoint a.ck --iterations 1..2/6").exit_code == 0);
  REQUIRE(run(folder, pt + "--checkpoint b.ck --iterations 5..6/6").exit_code == 0);
  refused("--integrator pt --resume a.ck --resume b.ck", "iterations 3 to 4 of the run are missing");
}

#ifdef GMIS_RENDER_MPI_PROGRAM
TEST_CASE("several ranks write the picture and the statistics of one command") {
  const ScratchFolder folder;
  for (const std::string scene : {"paper1", "cornell --integrator vcm", "paper2 --emission learned",
                                  "cornell --split budgeted --integrator gmis", "paper4 --crop 2,3,15,9"}) {
    INFO(scene);
    const std::string same = scene + " --size 20x14 --iterations 9 --threads 1 --quiet --halves ";
    REQUIRE(run(folder, same + "--out whole.pfm --stats whole.json").exit_code == 0);
    const Outcome outcome = run_on(folder, 3, same + "--out c.pfm --stats c.json");
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    for (const std::string part : {"", "_a", "_b"})
      CHECK(text_of(folder / ("c" + part + ".pfm")) == text_of(folder / ("whole" + part + ".pfm")));
    const auto one = nlohmann::json::parse(text_of(folder / "whole.json")),
               three = nlohmann::json::parse(text_of(folder / "c.json"));
    for (const char* key : {"image_hash", "plan", "iterations", "counts", "rejected", "estimate"})
      CHECK(one[key].dump() == three[key].dump());
  }
}

TEST_CASE("a checkpoint of two ranks is resumed by three, and by gmis-render") {
  const ScratchFolder folder;
  const std::string same = "paper1 --size 16x16 --threads 1 --quiet ";
  REQUIRE(run(folder, same + "--iterations 12 --out whole.pfm").exit_code == 0);
  // The pilot chooses for the length of the run that the checkpoint is of.
  REQUIRE(run_on(folder, 2, same + "--iterations 12 --out a.pfm --checkpoint a.ck --write-every 0").exit_code == 0);
  CHECK(text_of(folder / "a.pfm") == text_of(folder / "whole.pfm"));
  REQUIRE(run_on(folder, 2, same + "--iterations 5 --out b.pfm --checkpoint b.ck").exit_code == 0);
  REQUIRE(run(folder, same + "--iterations 5 --out short.pfm").exit_code == 0);
  CHECK(text_of(folder / "b.pfm") == text_of(folder / "short.pfm"));
  REQUIRE(run(folder, same + "--iterations 12 --out c.pfm --resume b.ck").exit_code == 0);
  REQUIRE(run_on(folder, 3, same + "--iterations 12 --out d.pfm --resume b.ck").exit_code == 0);
  CHECK(text_of(folder / "d.pfm") == text_of(folder / "c.pfm"));
}

TEST_CASE("ranks that differ, and requests that several ranks cannot do, are refused by name") {
  const ScratchFolder folder;
  const std::string same = "cornell --size 8x8 --iterations 2 --quiet --out a.pfm ";
  const auto refused = [&](const Outcome& outcome, const std::string& part) {
    INFO(outcome.err);
    CHECK(outcome.exit_code == 2);
    const std::size_t at = outcome.err.find(part);
    CHECK(at != std::string::npos);
    if (at != std::string::npos) CHECK(outcome.err.find(part, at + 1) == std::string::npos);  // said once
    CHECK_FALSE(fs::exists(folder / "a.pfm"));
  };
  const std::string program = " '" GMIS_RENDER_MPI_PROGRAM "' ";
  refused(run_shell(folder, mpirun + "-n 2" + program + same + ": -n 1" + program + same + "--seed 1"),
          "rank 2 has another run than rank 0: the seed differs: 1, not 0");
  refused(run_shell(folder, mpirun + "-n 1" + program + same + ": -n 1" + program + "nowhere" + same.substr(7)),
          "rank 1: nowhere: there is no such file");
  refused(run_on(folder, 2, "nowhere"), "gmis-render: nowhere: there is no such file");
  refused(run_on(folder, 2, same + "--techniques t"), "several ranks make no pictures of techniques");
  refused(run_on(folder, 2, same + "--aov classes"), "several ranks make no pictures of techniques");
  refused(run_on(folder, 2, same + "--check"), "--check, --replay");
  refused(run_on(folder, 2, same + "--replay 1:3"), "--check, --replay");
}

TEST_CASE("killed by a rank at 20 moments, the run ends with the bits of one that was never killed", "[.][slow]") {
  const ScratchFolder folder;
  const std::string same = "paper1 --size 16x16 --iterations 200 --seed 5 --threads 1 --quiet --write-every 0 ";
  REQUIRE(run(folder, same + "--out whole.pfm").exit_code == 0);
  gmis::Philox source(gmis_test::seed(19));
  int kills = 0, finished = 0, went_on = 0;
  while (kills < 20) {
    const int ranks = 1 + static_cast<int>(gmis::uniform_index(source, 3));
    const bool goes_on = fs::exists(folder / "c.ck");
    went_on += goes_on ? 1 : 0;
    // The mpirun of Open MPI 4.1 may not notice the death of a rank: the limit ends it. A rank
    // writes its number, waits a moment in the background, and then kills itself; or the run ends
    // before.
    const double wait = 0.5 + 0.02 * static_cast<double>(1U << gmis::uniform_index(source, 8));
    std::ofstream(folder / "rank.sh") << "if [ $OMPI_COMM_WORLD_RANK = "
                                      << gmis::uniform_index(source, static_cast<std::uint32_t>(ranks))
                                      << " ]; then me=$$; (sleep " << wait
                                      << "; kill -9 $me 2>killed.txt && echo killed >killed.txt) & fi\n"
                                      << "exec '" GMIS_RENDER_MPI_PROGRAM "' \"$@\"\n";
    fs::remove(folder / "killed.txt");
    const Outcome outcome = run_shell(folder, mpirun + "-n " + std::to_string(ranks) + " sh rank.sh " + same +
                                                  "--out c.pfm --checkpoint c.ck" + (goes_on ? " --resume c.ck" : ""));
    if (outcome.exit_code != 0) {
      INFO(outcome.err);
      REQUIRE(outcome.err.find("gmis-render:") == std::string::npos);  // it was killed, and did not fail
      ++kills;
      continue;
    }
    CHECK(text_of(folder / "c.pfm") == text_of(folder / "whole.pfm"));
    fs::remove(folder / "c.ck");
    ++finished;
  }
  const Outcome last = run_on(folder, 2, same + "--out c.pfm" + (fs::exists(folder / "c.ck") ? " --resume c.ck" : ""));
  INFO(went_on << " went on from a checkpoint, " << finished << " finished; " << last.err);
  REQUIRE(last.exit_code == 0);
  CHECK(text_of(folder / "c.pfm") == text_of(folder / "whole.pfm"));
  CHECK(went_on > 0);
}
#endif
