"""The price of an error as a run states it, over the price that it turns out to have.

For every scene the same run is made with many seeds, and its picture is kept after a sixteenth and a quarter of the iterations and at
the end, each time from the checkpoint of the last. The error at each of these is the root mean square over the seeds, from the
differences between their pictures: no reference is needed, and merging's bias, which all seeds have alike, is not in it. From one
stage to the next the error halves, or nearly so. What a run said that the error of a later stage costs is divided by what it
then took: by the pilot's forecast before the run, by its log at a quarter of the iterations (half the error), and by its log at a
sixteenth (a quarter of the error).

Writes out/prices/table.md and runs.json and, when all scenes took part, the table in docs/accuracy-and-time.md.
"""

import argparse
import concurrent.futures
import json
import math
import os
import pathlib
import statistics
import subprocess

from measuring import FOURTEEN, read_pfm, write_into

STAGES = (16, 4, 1)  # the whole run over each
DOCUMENT = pathlib.Path("docs/accuracy-and-time.md")
BEGIN, END = "<!-- prices: written by ./run bench prices -->", "<!-- end of prices -->"
FORECAST, HALF, QUARTER = "forecast", "half the error", "a quarter of the error"
LIMITS = {FORECAST: 0.3, HALF: 0.2, QUARTER: 0.2}


def run(options, name, seed):
    """Statistics and picture of every stage."""
    stem = options.out / f"{name}_{seed}"
    checkpoint, picture, stats = (stem.with_suffix(s) for s in (".checkpoint", ".pfm", ".json"))
    stages, extra = [], ["--checkpoint", str(checkpoint)]
    for part in STAGES:
        subprocess.run([options.renderer, FOURTEEN[name], "--size", options.size, "--threads", "1", "--quiet", "--seed", str(seed),
                        "--iterations", str(options.iterations // part), "--out", str(picture), "--stats", str(stats), *extra],
                       check=True, stdin=subprocess.DEVNULL)
        stages.append((json.loads(stats.read_text()), read_pfm(picture)))
        extra = ["--resume", str(checkpoint), "--checkpoint", str(checkpoint)]
    for file in (checkpoint, picture, stats):
        file.unlink()
    return stages


def price_of(error, prices, slope):
    """Iterations and processor seconds of an error, from those of the two smallest errors of a table: iterations by the power
    law, and time as a straight line over iterations."""
    a, b = prices[-2:]
    if a["iterations"] is None or b["iterations"] is None:
        return math.inf, math.inf
    iterations = b["iterations"] * (error / b["error"]) ** (1 / slope)
    rate = (b["cpu_seconds"] - a["cpu_seconds"]) / (b["iterations"] - a["iterations"])
    return iterations, b["cpu_seconds"] + rate * (iterations - b["iterations"])


def error_between(pictures):
    """The root mean square over runs, relative as a run states it."""
    count, square = len(pictures), 0.0
    for values in zip(*pictures):
        mean = sum(values) / count
        square += sum((x - mean) ** 2 for x in values) / (count - 1) / (mean * mean + 0.01)
    return math.sqrt(square / len(pictures[0]))


def measure(runs):
    """The errors of the stages; what was said over what it took, in iterations and in processor time, a pair for every run."""
    errors = [error_between([stages[k][1] for stages in runs]) for k in range(len(STAGES))]
    said = {FORECAST: [], HALF: [], QUARTER: []}
    for stages in runs:
        sixteenth, quarter, whole = (stats for stats, _ in stages)

        def ratio(prices, slope, stage, then):
            iterations, seconds = price_of(errors[stage], prices, slope)
            return iterations / then["iterations"], seconds / then["seconds"]["cpu"]

        said[FORECAST].append(ratio(sixteenth["forecast"], -0.5, 2, whole))
        said[HALF].append(ratio(quarter["prices"], quarter["prediction"]["slope"], 2, whole))
        said[QUARTER].append(ratio(sixteenth["prices"], sixteenth["prediction"]["slope"], 2, whole))
    return errors, said


def is_within(ratio, limit):
    return 1 / (1 + limit) <= ratio <= 1 + limit


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renderer", required=True)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--size", default="64x64")
    parser.add_argument("--iterations", type=int, default=1024)
    parser.add_argument("--scenes", nargs="*", default=list(FOURTEEN), choices=list(FOURTEEN))
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/prices"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    lines = ["| | error at the end | forecast: iterations | processor time | half the error: iterations | processor time | runs within 1.2 | "
             "a quarter of it: iterations | processor time | runs within 1.2 |", "|" + " --- |" * 10]
    everything, within, medians_within = {}, {HALF: 0, QUARTER: 0}, 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = {name: [pool.submit(run, options, name, seed) for seed in range(1, options.seeds + 1)] for name in options.scenes}
        for name in options.scenes:
            errors, said = measure([job.result() for job in jobs.pop(name)])
            everything[name] = {"errors": errors, **said}
            cells = [name, f"{100 * errors[-1]:.1f} %"]
            for key, pairs in said.items():
                cells += [f"{statistics.median(column):.2f}" for column in zip(*pairs)]
                if key == FORECAST:
                    medians_within += is_within(statistics.median(seconds for _, seconds in pairs), LIMITS[key])
                else:
                    count = sum(is_within(seconds, LIMITS[key]) for _, seconds in pairs)
                    within[key] += count
                    cells.append(f"{count} of {len(pairs)}")
            lines.append(f"| {' | '.join(cells)} |")
            print(lines[-1], flush=True)
    total = options.seeds * len(options.scenes)
    note = (f"\n{options.size} pixels, {options.iterations} iterations, {options.seeds} seeds, medians over them. Processor time within a factor "
            f"of 1.3 by the forecast: {medians_within} of {len(options.scenes)} scenes; within 1.2 by the log: {within[HALF]} of {total} runs "
            f"for half the error, {within[QUARTER]} of {total} for a quarter.\n")
    table = "\n".join(lines) + "\n" + note
    (options.out / "table.md").write_text(table)
    (options.out / "runs.json").write_text(json.dumps(everything, indent=1))
    if options.scenes == list(FOURTEEN):
        write_into(DOCUMENT, BEGIN, END, table)
    print(note)


main()
