"""Efficiency of --emission learned over --emission power: relMSE × processor seconds of the second over that of the first.

Each scene is rendered with both by several seeds in turns, 64x64 pixels, and compared with a reference: vertex connection and
merging with a small radius and many iterations. Writes a table.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile

from measuring import ALL

SCENES = ["far_sun", "telephoto", "huge_ground", "open_sky", "cornell"]


def render(options, scene, arguments, folder):
    subprocess.run([options.renderer, ALL[scene], "--size", "64x64", "--max-depth", "10", "--threads",
                    "1", "--quiet", "--stats", folder / "stats.json", *arguments], check=True)
    return json.loads((folder / "stats.json").read_text(encoding="utf-8"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renderer", required=True)
    parser.add_argument("--scenes", nargs="+", default=SCENES)
    parser.add_argument("--integrators", nargs="+", default=["vcm", "auto"])
    parser.add_argument("--iterations", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=4)
    options = parser.parse_args()
    print("| scene | integrator | relMSE by power | learned | without the worst 0.1 % of the pixels | learned | "
          "processor seconds | learned | efficiency | without the worst |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for scene in options.scenes:
            reference = folder / f"{scene}.pfm"
            render(options, scene, ["--integrator", "vcm", "--emission", "learned", "--radius", "0.2", "--iterations",
                                    "3000", "--seed", "77", "--out", reference], folder)
            for integrator in options.integrators:
                sums = {"power": [0.0] * 3, "learned": [0.0] * 3}
                for seed in range(options.seeds):
                    for emission, sum_of in sums.items():
                        stats = render(options, scene, ["--integrator", integrator, "--emission", emission,
                                                        "--iterations", str(options.iterations), "--seed", str(seed + 1),
                                                        "--reference", reference, "--out", folder / "x.pfm"], folder)
                        for i, value in enumerate((stats["error"]["relmse"], stats["error"]["relmse_trimmed"],
                                                   stats["seconds"]["cpu"])):
                            sum_of[i] += value / options.seeds
                power, learned = sums["power"], sums["learned"]
                gains = [power[i] * power[2] / (learned[i] * learned[2]) for i in (0, 1)]
                cells = [f"{power[i]:.4f} | {learned[i]:.4f}" for i in (0, 1)]
                print(f"| {scene} | {integrator} | {cells[0]} | {cells[1]} | {power[2]:.2f} | {learned[2]:.2f} | "
                      f"{gains[0]:.2f} | {gains[1]:.2f} |", flush=True)


if __name__ == "__main__":
    main()
