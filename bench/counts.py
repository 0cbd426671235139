"""Efficiency of --counts learned, or --pixel-counts learned, over uniform: relMSE × processor seconds of the second over that of the first.

Each scene is rendered with both by several seeds in turns, with the same fixed counts (local merging with 3.2 pixel widths,
half a light tree a pixel, one connection a vertex) or by auto, and compared with a reference: svcm0, svcm1, tung1 and tung2 with those of tests/program/reference
(128x128 pixels), the others with one that is rendered first, or that lies in a folder. Prints a table, and writes that of pixel counts of all scenes into
docs/effects.md.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile

from measuring import FOURTEEN, write_into

FOREIGN = {name: f"tests/program/reference/{name}.pbrt" for name in ("svcm0", "svcm1", "tung1", "tung2")}
SCENES = FOREIGN | FOURTEEN
DOCUMENT = pathlib.Path("docs/effects.md")
MARKS = {"pixel-counts": ("<!-- pixel counts: written by ./run bench counts -->", "<!-- end of pixel counts -->")}
WAYS = {"gmis": ["--integrator", "gmis", "--connections", "1", "--light-paths", "0.5", "--radius", "3.2"], "auto": ["--integrator", "auto"]}


def render(options, scene, arguments, folder):
    depth = "10" if scene in FOREIGN else "16"
    subprocess.run([options.renderer, SCENES[scene], "--size", options.size, "--max-depth", depth, "--threads", "1", "--quiet",
                    "--stats", folder / "stats.json", *arguments], check=True)
    return json.loads((folder / "stats.json").read_text(encoding="utf-8"))


def reference_of(options, scene, folder):
    if scene in FOREIGN:
        return SCENES[scene].replace(".pbrt", ".pfm")
    if options.references:
        file = next(pathlib.Path(options.references).glob(f"{scene}_{options.size}*.pfm"), pathlib.Path(options.references) / f"{scene}.pfm")
        if not file.exists():
            raise SystemExit(f"counts: there is no {file}")
        return file
    file = folder / f"{scene}.pfm"
    render(options, scene, ["--integrator", "gmis", "--connections", "1", "--radius", "0.8", "--iterations", "3000", "--seed", "7777",
                            "--out", file], folder)
    return file


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renderer", required=True)
    parser.add_argument("--scenes", nargs="+", default=list(SCENES))
    parser.add_argument("--option", default="counts", choices=["counts", "pixel-counts"])
    parser.add_argument("--ways", nargs="+", choices=list(WAYS))
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--iterations", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--references", help="folder with SCENE.pfm of this size")
    options = parser.parse_args()
    ways = options.ways or {"counts": ["gmis"], "pixel-counts": ["auto"]}[options.option]
    lines = ["| scene | integrator | relMSE uniform | learned | processor seconds | learned | efficiency | without the worst 0.1 % of the pixels |",
             "|" + " --- |" * 8]
    print("\n".join(lines))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for scene in options.scenes:
            reference = reference_of(options, scene, folder)
            for way in ways:
                sums = {"uniform": [0.0] * 3, "learned": [0.0] * 3}
                for seed in range(options.seeds):
                    for counts, sum_of in sums.items():
                        stats = render(options, scene, [*WAYS[way], f"--{options.option}", counts, "--iterations", str(options.iterations),
                                                        "--seed", str(seed + 1), "--reference", reference, "--out", folder / "x.pfm"],
                                       folder)
                        for i, value in enumerate((stats["error"]["relmse"], stats["error"]["relmse_trimmed"],
                                                   stats["seconds"]["cpu"])):
                            sum_of[i] += value / options.seeds
                uniform, learned = sums["uniform"], sums["learned"]
                gains = [uniform[i] * uniform[2] / (learned[i] * learned[2]) for i in (0, 1)]
                lines.append(f"| {scene} | {way} | {uniform[0]:.5f} | {learned[0]:.5f} | {uniform[2]:.2f} | {learned[2]:.2f} | "
                             f"{gains[0]:.2f} | {gains[1]:.2f} |")
                print(lines[-1], flush=True)
    if options.option in MARKS and options.scenes == list(SCENES):
        said = f"{options.size} pixels, {options.iterations} iterations, the means of {options.seeds} seeds, one thread."
        write_into(DOCUMENT, *MARKS[options.option], "\n".join(lines) + f"\n\n{said}\n")


if __name__ == "__main__":
    main()
