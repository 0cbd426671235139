#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gmis/core/random.hpp"
#include "program.hpp"
#include "support/catch.hpp"
#include "support/image/image.hpp"
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
  // Where nothing gets as far as a checkpoint, the moments are later ones.
  while (kills < 50 || (went_on == 0 && finished < 50)) {
    if (fs::exists(folder / "c.checkpoint")) ++went_on;
    const pid_t child = start(folder);
    // Any moment will do: in the pilot, after it, while a file is written.
    usleep((1000U * static_cast<unsigned>(1 + kills / 50)) << gmis::uniform_index(source, 9));
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
  CHECK(went_on > 0);
}

TEST_CASE("a run goes on to more iterations, on other threads, and keeps what it had") {
  const ScratchFolder folder;
  const std::string same = "cornell --size 16x16 --integrator vcm --connections 1 --quiet ";
  REQUIRE(run(folder, same + "--iterations 6 --out whole.pfm").exit_code == 0);
  REQUIRE(run(folder, same + "--iterations 3 --out a.pfm --checkpoint a.checkpoint --threads 1").exit_code == 0);
  const Outcome longer = run(folder, same + "--iterations 6 --out b.pfm --resume a.checkpoint --threads 2 --log b.csv");
  INFO(longer.err);
  CHECK(longer.exit_code == 0);
  CHECK(text_of(folder / "b.pfm") == text_of(folder / "whole.pfm"));
  // Iteration 1 of the checkpoint, then 4 and 6, below the header.
  CHECK(line_count(text_of(folder / "b.csv")) == 4);
  // What is done already is not done again.
  CHECK(run(folder, same + "--iterations 2 --out c.pfm --resume a.checkpoint").exit_code == 0);
  CHECK(text_of(folder / "c.pfm") == text_of(folder / "a.pfm"));
}

TEST_CASE("a checkpoint that does not fit: exit code 2, and a message that names what differs") {
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
  refused(same + "--resume a.checkpoint --halves",
          "what is kept differs: picture + errors, not picture + errors + halves");
  refused(same + "--resume none.checkpoint", "none.checkpoint: there is no such file");
  fs::copy_file(folder / "a.pfm", folder / "b.pfm");
  refused(same + "--resume b.pfm", "--resume b.pfm: this is no checkpoint of this version");
  refused(
      "cornell --size 8x8 --integrator bpt --connections 1 --iterations 2 --quiet --out a.pfm --resume a.checkpoint",
      "--resume a.checkpoint: the checkpoint is of another run: the integrator differs: vcm, not bpt");
  refused(
      "cornell --size 8x8 --integrator vcm --connections 2 --iterations 2 --quiet --out a.pfm --resume a.checkpoint",
      "connections 1, splats 1, merges 1, ");
  refused("paper1 --size 8x8 --integrator vcm --connections 1 --iterations 2 --quiet --out b.pfm --resume a.checkpoint",
          "the scene differs");
  const std::string whole = text_of(folder / "a.checkpoint");
  std::ofstream(folder / "short.checkpoint", std::ios::binary) << whole.substr(0, whole.size() - 7);
  refused(same + "--resume short.checkpoint", "cut short");
  std::string damaged = whole;
  damaged[whole.size() - 100] = static_cast<char>(damaged[whole.size() - 100] ^ 1);
  std::ofstream(folder / "damaged.checkpoint", std::ios::binary) << damaged;
  refused(same + "--resume damaged.checkpoint", "damaged");
  // In what says which run it is of, too: no message quotes damaged bytes.
  damaged = whole;
  damaged[100] = static_cast<char>(damaged[100] ^ 1);
  std::ofstream(folder / "damaged.checkpoint", std::ios::binary) << damaged;
  refused(same + "--resume damaged.checkpoint", "damaged: its digest differs");
  const Outcome nowhere = run(folder, same + "--checkpoint no/folder/a.checkpoint");
  CHECK(nowhere.exit_code == 2);
}

TEST_CASE("Runs with seeds of their own are joined into one picture") {
  const ScratchFolder folder;
  const std::string same = "cornell --size 12x12 --halves --quiet ";
  REQUIRE(run(folder, same + "--seed 1 --iterations 6 --out a.pfm --checkpoint a.ck").exit_code == 0);
  REQUIRE(run(folder, same + "--seed 2 --iterations 18 --out b.pfm --checkpoint b.ck").exit_code == 0);
  REQUIRE(run(folder, same + "--resume a.ck --resume b.ck --out c.pfm --stats c.json --log c.csv").exit_code == 0);
  // Of the longer run iterations 1, 4, 6, 8, 12 and 16, then all 24, below the header.
  CHECK(line_count(text_of(folder / "c.csv")) == 8);
  for (const std::string part : {"", "_a", "_b"}) {
    const auto a = gmis::tools::read_image(folder / ("a" + part + ".pfm"));
    const auto b = gmis::tools::read_image(folder / ("b" + part + ".pfm"));
    const auto c = gmis::tools::read_image(folder / ("c" + part + ".pfm"));
    REQUIRE(c.rgb.size() == 3 * 144);
    for (std::size_t i = 0; i < c.rgb.size(); ++i) {
      const double mean = 0.25 * static_cast<double>(a.rgb[i]) + 0.75 * static_cast<double>(b.rgb[i]);
      // Each of the three was rounded to float.
      REQUIRE(std::abs(static_cast<double>(c.rgb[i]) - mean) <= 2 * std::ldexp(mean, -24));
    }
  }
  const auto json = nlohmann::json::parse(text_of(folder / "c.json"));
  CHECK(json["iterations"] == 24);
  CHECK(json["stopped_by"] == "joined");
  CHECK(json["seed"] == nlohmann::json({1, 2}));
  CHECK(json["estimate"]["relative_error"].is_number());
  CHECK(json["prices"].size() == 5);

  const auto refused = [&](const std::string& arguments, const std::string& part) {
    const Outcome outcome = run(folder, same + arguments + " --out d.pfm");
    INFO(arguments << ": " << outcome.err);
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.err.find(part) != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "d.pfm"));
  };
  refused("--resume a.ck --resume b.ck --resume a.ck",
          "--resume a.ck, b.ck, a.ck: checkpoints 1 and 3 are of runs with the same seed, 1");
  refused("--resume a.ck --resume b.ck --max-depth 3",
          "checkpoint 1: the checkpoint is of another run: the greatest depth");
  refused("--resume a.ck --resume b.ck --checkpoint d.ck", "several are joined");
  REQUIRE(run(folder, "cornell --size 8x8 --halves --quiet --seed 3 --iterations 2 --out e.pfm --checkpoint e.ck")
              .exit_code == 0);
  refused("--resume a.ck --resume e.ck",
          "--resume a.ck, e.ck: checkpoint 2: the checkpoint is of another run: the size of the picture differs");
}

TEST_CASE("A change in any file of the scene is refused by its name") {
  const ScratchFolder folder;
  for (const char* name : {"leaf_color.png", "leaf_alpha.png", "sky.pfm"})
    fs::copy_file(fs::path(GMIS_SCENE_FOLDER) / name, folder / name);
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(folder / name) << text; };
  write("scene.pbrt", R"(LookAt 0 0 -4 0 0 0 0 1 0 Camera "perspective"
WorldBegin
LightSource "infinite" "string filename" "sky.pfm"
Include "part.pbrt"
Material "diffuse" "spectrum reflectance" "paper.spd"
Shape "plymesh" "string filename" "triangle.ply"
)");
  write("part.pbrt", R"(Texture "leaf" "spectrum" "imagemap" "string filename" "leaf_color.png"
Material "diffuse" "texture reflectance" "leaf"
Shape "sphere"
)");
  write("paper.spd", "400 .5\n700 .75\n");
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  write("triangle.ply", ply + "-2 -1 0\n2 -1 0\n0 2 0\n3 0 1 2\n");
  const std::string same = "scene.pbrt --size 6x6 --iterations 2 --quiet --out a.pfm ";
  const Outcome first = run(folder, same + "--checkpoint a.ck");
  INFO(first.err);
  REQUIRE(first.exit_code == 0);
  CHECK(run(folder, same + "--resume a.ck").exit_code == 0);
  const auto check_refused = [&](const std::string& name, const std::string& content) {
    const std::string before = text_of(folder / name);
    std::ofstream(folder / name, std::ios::binary) << content;
    const Outcome outcome = run(folder, same + "--resume a.ck");
    INFO(outcome.err);
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.err.find("the content of " + name + " differs") != std::string::npos);
    std::ofstream(folder / name, std::ios::binary) << before;
  };
  check_refused("scene.pbrt", text_of(folder / "scene.pbrt") + "# a word\n");
  check_refused("part.pbrt", text_of(folder / "part.pbrt") + "# a word\n");
  check_refused("leaf_color.png", text_of(folder / "leaf_alpha.png"));
  check_refused("triangle.ply", ply + "-2 -1 0\n2 -1 0\n0 2.0 0\n3 0 1 2\n");  // the same numbers, in other words
  check_refused("paper.spd", "400 .5\n700 .76\n");
  std::string sky = text_of(folder / "sky.pfm");
  sky[sky.size() - 3] = static_cast<char>(sky[sky.size() - 3] ^ 1);
  check_refused("sky.pfm", sky);
  CHECK(run(folder, same + "--resume a.ck").exit_code == 0);
}

#if GMIS_HAS_TINYGLTF
TEST_CASE("A change in any file of a glTF scene is refused by its name") {
  const ScratchFolder folder;
  fs::copy_file(fs::path(GMIS_SCENE_FOLDER) / "leaf_color.png", folder / "leaf.png");
  const float corners[]{-2, -1, 0, 2, -1, 0, 0, 2, 0, /* texture coordinates */ 0, 0, 1, 0, 0, 1};
  const auto write = [&](const char* name, std::string_view text) {
    std::ofstream(folder / name, std::ios::binary) << text;
  };
  write("corners.bin", {reinterpret_cast<const char*>(corners), sizeof corners});
  const std::string scene = R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}],
"textures": [{"source": 0}], "images": [{"uri": "leaf.png"}],
"buffers": [{"byteLength": 60, "uri": "corners.bin"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-2, -1, 0], "max": [2, 2, 0]},
{"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}]}
)";
  write("scene.gltf", scene);
  const std::string same = "scene.gltf --size 6x6 --iterations 2 --quiet --out a.pfm ";
  const Outcome first = run(folder, same + "--checkpoint a.ck");
  INFO(first.err);
  REQUIRE(first.exit_code == 0);
  CHECK(run(folder, same + "--resume a.ck").exit_code == 0);
  const auto check_refused = [&](const char* name, const std::string& content) {
    const std::string before = text_of(folder / name);
    write(name, content);
    const Outcome outcome = run(folder, same + "--resume a.ck");
    INFO(name << ": " << outcome.err);
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.err.find("the content of " + std::string(name) + " differs") != std::string::npos);
    write(name, before);
  };
  check_refused("scene.gltf", scene + "\n");
  std::string moved = text_of(folder / "corners.bin");
  moved[33] = static_cast<char>(moved[33] ^ 1);
  check_refused("corners.bin", moved);
  check_refused("leaf.png", text_of(fs::path(GMIS_SCENE_FOLDER) / "leaf_alpha.png"));
  CHECK(run(folder, same + "--resume a.ck").exit_code == 0);
}
#endif
