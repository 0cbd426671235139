#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include "gmis/core/random.hpp"
#include "program.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace program;

namespace {

const std::string run_arguments = "cornell --size 16x16 --iterations 40 --seed 5 --quiet --write-every 0 ";

/// The run in a process of its own, with `--resume` when there is a checkpoint.
pid_t start(const ScratchFolder& folder) {
  const bool goes_on = fs::exists(folder / "c.checkpoint");
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    if (chdir(folder.path.c_str()) != 0) _exit(99);
    std::vector<const char*> arguments{
        "gmis-render",   "cornell", "--size", "16x16", "--iterations", "40",           "--seed",    "5", "--quiet",
        "--write-every", "0",       "--out",  "c.pfm", "--checkpoint", "c.checkpoint", "--threads", "1"};
    if (goes_on) arguments.insert(arguments.end(), {"--resume", "c.checkpoint"});
    arguments.push_back(nullptr);
    execv(GMIS_RENDER_PROGRAM, const_cast<char* const*>(arguments.data()));
    _exit(98);
  }
  return child;
}

}  // namespace

TEST_CASE("killed at 50 moments, the run ends with the bits of one that was never killed") {
  const ScratchFolder folder;
  REQUIRE(run(folder, run_arguments + "--out whole.pfm --threads 1").exit_code == 0);
  const std::string whole = text_of(folder / "whole.pfm");
  REQUIRE_FALSE(whole.empty());
  gmis::Philox source(gmis_test::seed(9));
  int kills = 0, finished = 0, went_on = 0;
  const auto finish = [&] {
    CHECK(text_of(folder / "c.pfm") == whole);
    fs::remove(folder / "c.checkpoint");
    fs::remove(folder / "c.pfm");
    ++finished;
  };
  while (kills < 50) {
    if (fs::exists(folder / "c.checkpoint")) ++went_on;
    const pid_t child = start(folder);
    // Any moment will do: before the first iteration, in the pilot, after it, while a file is written.
    usleep(1000U << gmis::uniform_index(source, 9));
    kill(child, SIGKILL);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    if (WIFSIGNALED(status)) {
      ++kills;
      continue;
    }
    REQUIRE(WEXITSTATUS(status) == 0);
    finish();
  }
  int status = 0;
  REQUIRE(waitpid(start(folder), &status, 0) > 0);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
  finish();
  INFO(went_on << " went on from a checkpoint, " << finished << " finished");
  CHECK(finished >= 1);
}

TEST_CASE("a run goes on to more iterations, on other threads, and keeps what it had") {
  const ScratchFolder folder;
  const std::string same = "cornell --size 16x16 --integrator vcm --connections 1 --quiet ";
  REQUIRE(run(folder, same + "--iterations 6 --out whole.pfm").exit_code == 0);
  REQUIRE(run(folder, same + "--iterations 3 --out a.pfm --checkpoint a.checkpoint --threads 1").exit_code == 0);
  const Outcome longer = run(folder, same + "--iterations 6 --out b.pfm --resume a.checkpoint --threads 2");
  INFO(longer.err);
  CHECK(longer.exit_code == 0);
  CHECK(text_of(folder / "b.pfm") == text_of(folder / "whole.pfm"));
  // What is done already is not done again.
  CHECK(run(folder, same + "--iterations 2 --out c.pfm --resume a.checkpoint").exit_code == 0);
  CHECK(text_of(folder / "c.pfm") == text_of(folder / "a.pfm"));
}

TEST_CASE("a checkpoint that does not fit: exit code 2, and the name of what differs") {
  const ScratchFolder folder;
  const std::string same = "cornell --size 8x8 --integrator vcm --connections 1 --iterations 2 --quiet --out a.pfm ";
  REQUIRE(run(folder, same + "--checkpoint a.checkpoint").exit_code == 0);
  const auto refused = [&](const std::string& arguments, const std::string& part) {
    const Outcome outcome = run(folder, arguments);
    INFO(arguments << ": " << outcome.err);
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.err.find(part) != std::string::npos);
    CHECK(line_count(outcome.err) == 1);
  };
  refused(same + "--resume a.checkpoint --seed 1", "the seed differs: 0, not 1");
  refused(same + "--resume a.checkpoint --max-depth 3", "the greatest depth differs: 16, not 3");
  refused(same + "--resume a.checkpoint --alpha 0.5", "alpha differs");
  refused(same + "--resume none.checkpoint", "none.checkpoint: there is no such file");
  refused(same + "--resume a.pfm", "this is no checkpoint of this version");
  refused("paper1 --size 8x8 --integrator vcm --connections 1 --iterations 2 --quiet --out b.pfm --resume a.checkpoint",
          "the scene differs");
  const std::string whole = text_of(folder / "a.checkpoint");
  std::ofstream(folder / "short.checkpoint", std::ios::binary) << whole.substr(0, whole.size() - 7);
  refused(same + "--resume short.checkpoint", "cut short");
  std::string damaged = whole;
  damaged[whole.size() - 100] = static_cast<char>(damaged[whole.size() - 100] ^ 1);
  std::ofstream(folder / "damaged.checkpoint", std::ios::binary) << damaged;
  refused(same + "--resume damaged.checkpoint", "damaged");
  const Outcome nowhere = run(folder, same + "--checkpoint no/folder/a.checkpoint");
  CHECK(nowhere.exit_code == 2);
}
