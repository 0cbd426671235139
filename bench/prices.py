"""The price of an error as a run states it, over the price that it turns out to have.

For every scene the same run is made with many seeds: for a quarter of the iterations, and from its checkpoint to the end. The
error at the end is the root mean square over the seeds, from the differences between their pictures: no reference is needed, and
merging's bias, which all seeds have alike, is not in it. What the first quarter says that this error costs is divided by what
the run then took: by the pilot's forecast before the run, and by the log of the quarter. Medians over the seeds.

Writes out/prices/table.md and, when all scenes took part, the table in docs/accuracy-and-time.md.
"""

import argparse
import array
import itertools
import json
import math
import pathlib
import statistics
import subprocess
import sys

OWN = ["all_glossy", "caustic_pool", "light_behind_glass", "many_lights", "mirror_hall", "mixed", "one_point_light", "open_sky",
       "slit"]
SCENES = ["cornell", "paper1", "paper2", "paper3", "paper4", *OWN]
DOCUMENT = pathlib.Path("docs/accuracy-and-time.md")
BEGIN, END = "<!-- prices: written by ./run bench prices -->", "<!-- end of prices -->"


def read_pfm(file):
    *head, rest = file.read_bytes().split(b"\n", 3)
    values = array.array("f", rest)
    if (float(head[2]) < 0) != (sys.byteorder == "little"):
        values.byteswap()
    return values


def render(options, scene, seed, iterations, stem, extra):
    image, stats = stem.with_suffix(".pfm"), stem.with_suffix(".json")
    subprocess.run([options.renderer, scene, "--size", options.size, "--threads", "1", "--quiet", "--seed", str(seed),
                    "--iterations", str(iterations), "--out", str(image), "--stats", str(stats), *extra],
                   check=True, stdin=subprocess.DEVNULL)
    return json.loads(stats.read_text())


def price_of(error, prices, slope):
    """Iterations and processor seconds of an error, from those of the two smallest errors of a table: iterations by the power
    law, and time as a straight line over iterations."""
    a, b = prices[-2:]
    if a["iterations"] is None or b["iterations"] is None:
        return math.inf, math.inf
    iterations = b["iterations"] * (error / b["error"]) ** (1 / slope)
    rate = (b["cpu_seconds"] - a["cpu_seconds"]) / (b["iterations"] - a["iterations"])
    return iterations, b["cpu_seconds"] + rate * (iterations - b["iterations"])


def measure(options, name):
    scene = f"bench/scenes/{name}.pbrt" if name in OWN else name
    pictures, early, late = [], [], []
    for seed in range(1, options.seeds + 1):
        stem, checkpoint = options.out / f"{name}_{seed}", options.out / "run.checkpoint"
        early.append(render(options, scene, seed, options.iterations // 4, stem, ["--checkpoint", str(checkpoint)]))
        late.append(render(options, scene, seed, options.iterations, stem, ["--resume", str(checkpoint)]))
        pictures.append(read_pfm(stem.with_suffix(".pfm")))
    count = len(pictures)
    square = 0.0
    for values in zip(*pictures):
        mean = sum(values) / count
        square += sum((x - mean) ** 2 for x in values) / (count - 1) / (mean * mean + 0.01)
    error = math.sqrt(square / len(pictures[0]))
    ratios = {"forecast": [], "log": []}
    for first, whole in zip(early, late):
        time = whole["seconds"]["cpu"]
        for key, prices, slope in (("forecast", first["forecast"], -0.5),
                                   ("log", first["prices"], first["prediction"]["slope"])):
            iterations, seconds = price_of(error, prices, slope)
            ratios[key].append((iterations / options.iterations, seconds / time))
    return error, {key: [statistics.median(column) for column in zip(*pairs)] for key, pairs in ratios.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renderer", required=True)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--size", default="64x64")
    parser.add_argument("--iterations", type=int, default=256)
    parser.add_argument("--scenes", nargs="*", default=SCENES, choices=SCENES)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/prices"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    lines = ["| | error at the end | forecast: iterations | processor time | by the log of a quarter: iterations | processor time |",
             "| --- | --- | --- | --- | --- | --- |"]
    all_ratios = {"forecast": [], "log": []}
    for name in options.scenes:
        error, ratios = measure(options, name)
        cells = [f"{value:.2f}" for value in itertools.chain(ratios["forecast"], ratios["log"])]
        lines.append(f"| {name} | {100 * error:.1f} % | {' | '.join(cells)} |")
        print(lines[-1], flush=True)
        for key, pair in ratios.items():
            all_ratios[key].append(pair[1])
    within = {key: sum(1 / (1 + limit) <= ratio <= 1 + limit for ratio in all_ratios[key])
              for key, limit in (("forecast", 0.3), ("log", 0.2))}
    note = (f"\n{options.size} pixels, {options.iterations} iterations, {options.seeds} seeds. Processor time within a factor of 1.3 by the "
            f"forecast: {within['forecast']} of {len(options.scenes)} scenes; within 1.2 by the log: {within['log']}.\n")
    table = "\n".join(lines) + "\n" + note
    (options.out / "table.md").write_text(table)
    text = DOCUMENT.read_text()
    if options.scenes == SCENES and BEGIN in text:
        before, rest = text.split(BEGIN, 1)
        DOCUMENT.write_text(before + BEGIN + "\n" + table + END + rest.split(END, 1)[1])
    print(note)


main()
