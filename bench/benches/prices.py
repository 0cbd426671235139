"""The price of an error as a run states it, over the price that it turns out to have.

For every scene the same run is made with many seeds, and its picture is kept after a sixteenth and
a quarter of the iterations and at the end, each time from the checkpoint of the last; from one to
the next the error halves, or nearly so. The run is planned for the sixteenth: its pilot chooses and
forecasts for that many iterations, and the rest has the same counts. The error of a run at its end
is against the mean of the other seeds, which differ from it by noise alone: no reference is needed,
and merging's bias, which all seeds have alike, is not in it. What the run said that this error
costs is divided by what it then took: by the pilot's forecast before the run, by its log at a
quarter of the iterations (half the error), and by its log at a sixteenth (a quarter of the error).

Writes out/prices/runs.json, and the table in docs/accuracy-and-time.md.
"""

import concurrent.futures
import json
import math
import os
import statistics

from measuring import FOURTEEN, Table, own_errors, publish, read_pfm, render

STAGES = (16, 4, 1)  # the whole run over each
FIRST_SEED = 201  # the constants of the law were chosen with seeds 1 to 8 and 101 to 108
PROGRAM = "gmis-render"
OPTIONS = {"seeds": 4, "size": "96x96", "iterations": 512, "scenes": FOURTEEN}
DOCUMENT = "docs/accuracy-and-time.md"
FORECAST, HALF, QUARTER = "forecast", "half the error", "a quarter of the error"
LIMITS = {FORECAST: 0.3, HALF: 0.2, QUARTER: 0.2}


def stages_of(options, name, seed):
    """Statistics and picture of every stage."""
    stem = options.out / f"{name}_{seed}"
    checkpoint, picture, stats = (stem.with_suffix(s) for s in (".checkpoint", ".pfm", ".json"))
    stages, extra = [], ""
    for part in STAGES:
        facts = render(options, name, f"--size {options.size} --seed {seed} --iterations {options.iterations // part}",
                       f"--checkpoint {checkpoint}", extra, stats=stats, picture=picture)
        stages.append((facts, read_pfm(picture)))
        extra = f"--resume {checkpoint}"
    for file in (checkpoint, picture, stats):
        file.unlink()
    return stages


def squared_error(law, n):
    power = 2 - law["alpha"]
    remaining = 1 - law["evenness"] * (1 - math.sqrt(min(1, 8 / n)))
    return remaining * (law["independent"] * n + law["merging"] * ((n + 0.5) ** power - 0.5**power) / power) / n**2


def iterations_by(law, error):
    lower, upper = 0.0, 50.0  # logarithms
    for _ in range(60):
        middle = (lower + upper) / 2
        lower, upper = (middle, upper) if squared_error(law, math.exp(middle)) > error**2 else (lower, middle)
    return math.exp(upper)


def iterations_between(error, prices):
    """Iterations to an error between, or beyond, those of a table, by a power law through the two
    entries nearest to it."""
    nearest = sorted(prices, key=lambda price: abs(math.log(price["error"] / error)))[:2]
    a, b = nearest
    slope = math.log(a["iterations"] / b["iterations"]) / math.log(a["error"] / b["error"])
    return a["iterations"] * (error / a["error"]) ** slope


def seconds_of(iterations, prices):
    """Processor seconds, a straight line over iterations through the two smallest errors of a
    table."""
    a, b = prices[-2:]
    rate = (b["cpu_seconds"] - a["cpu_seconds"]) / (b["iterations"] - a["iterations"])
    return b["cpu_seconds"] + rate * (iterations - b["iterations"])


def measure(runs):
    """The errors of the runs at their end; what was said over what it took, in iterations and in
    processor time, a pair for every run."""
    errors = own_errors([stages[-1][1] for stages in runs])
    said = {FORECAST: [], HALF: [], QUARTER: []}
    for error, stages in zip(errors, runs):
        sixteenth, quarter, whole = (stats for stats, _ in stages)

        def ratio(iterations, prices):
            return iterations / whole["iterations"], seconds_of(iterations, prices) / whole["seconds"]["cpu"]

        said[FORECAST].append(ratio(iterations_between(error, sixteenth["forecast"]), sixteenth["forecast"]))
        for key, stats in ((HALF, quarter), (QUARTER, sixteenth)):
            said[key].append(ratio(iterations_by(stats["prediction"], error), stats["prices"]))
    return errors, said


def is_within(ratio, limit):
    return abs(ratio - 1) <= limit


def run(options):
    table = Table("", "error at the end", "forecast: iterations", "processor time", "half the error: iterations", "processor time",
                  "runs within 20 %", "a quarter of it: iterations", "processor time", "runs within 20 %")
    everything, within, medians_within = {}, {HALF: 0, QUARTER: 0}, 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = {name: [pool.submit(stages_of, options, name, seed) for seed in range(FIRST_SEED, FIRST_SEED + options.seeds)] for name in options.scenes}
        for name in options.scenes:
            errors, said = measure([job.result() for job in jobs.pop(name)])
            everything[name] = {"errors": errors, **said}
            cells = [name, f"{100 * statistics.fmean(errors):.1f} %"]
            for key, pairs in said.items():
                cells += [f"{statistics.median(column):.2f}" for column in zip(*pairs)]
                if key == FORECAST:
                    medians_within += is_within(statistics.median(seconds for _, seconds in pairs), LIMITS[key])
                else:
                    count = sum(is_within(seconds, LIMITS[key]) for _, seconds in pairs)
                    within[key] += count
                    cells.append(f"{count} of {len(pairs)}")
            table.add(*cells)
    total = options.seeds * len(options.scenes)
    table.note(f"{options.size} pixels, {options.iterations} iterations, {options.seeds} seeds, medians over them. Processor time within 30 % "
               f"by the forecast: {medians_within} of {len(options.scenes)} scenes; within 20 % by the log: {within[HALF]} of {total} runs "
               f"for half the error, {within[QUARTER]} of {total} for a quarter.")
    (options.out / "runs.json").write_text(json.dumps(everything, indent=1))
    publish(options, table, DOCUMENT)

