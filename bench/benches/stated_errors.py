"""The error that a run states over the true one of that very run, and how often its interval covers
it.

For every scene and number of iterations the same run is made with many seeds. Its true error is the
square root of its relMSE against the other seeds: against all that they rendered, or, where
something merges, against what they have after the same number of iterations, since the error that a
run states is without merging's bias, which shrinks with the radius.

Writes out/stated_errors/runs.json, and the table in docs/accuracy-and-time.md when all cases took
part.
"""

import concurrent.futures
import json
import os
import statistics

from measuring import FOURTEEN, Table, own_errors, publish, read_pfm, render_once

# Name: scene, options of the run.
BPT = ["--integrator", "bpt", "--connections", "1"]
VCM = ["--integrator", "vcm", "--connections", "1"]
CASES = {
    "cornell, bpt": ("cornell", BPT),
    "paper2, bpt": ("paper2", BPT),
    "all_glossy, bpt": (FOURTEEN["all_glossy"], BPT),
    "open_sky, bpt": (FOURTEEN["open_sky"], BPT),
    "one_point_light, bpt": (FOURTEEN["one_point_light"], BPT),
    "slit, bpt": (FOURTEEN["slit"], BPT),
    "mixed, vcm": (FOURTEEN["mixed"], VCM),
    "paper1, vcm": ("paper1", VCM),
    "paper1, bpt": ("paper1", BPT),
    "paper3, bpt": ("paper3", BPT),
    "paper4, vcm": ("paper4", VCM),
    "caustic_pool, vcm": (FOURTEEN["caustic_pool"], VCM),
    "light_behind_glass, vcm": (FOURTEEN["light_behind_glass"], VCM),
    "mirror_hall, bpt": (FOURTEEN["mirror_hall"], BPT),
    "many_lights, bpt": (FOURTEEN["many_lights"], BPT),
}
ITERATIONS = (8, 16, 32, 128)
FIRST_SEED = 1000  # the constants of the estimate were chosen with seeds below 100
PROGRAM = "gmis-render"
OPTIONS = {"seeds": 50, "size": "32x32"}
DOCUMENT = "docs/accuracy-and-time.md"


def made_once(options, scene, extra, stem):
    """The picture and the statistics of a run."""
    stats = render_once(options, scene, f"--size {options.size} --max-depth 8", extra, stem=stem)
    return read_pfm(stem.with_suffix(".pfm")), stats


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def row_of(name, runs):
    """The cells of the table for all runs of one case; intervals shown, and those that cover."""
    cells, shown, covered = [], 0, 0
    for iterations in ITERATIONS:
        own = [r for r in runs if r["iterations"] == iterations]
        ratios = [r["stated"] / r["true"] for r in own if r["true"] > 0]
        cells.append(f"{statistics.median(ratios):.2f} ({percentile(ratios, 0.1):.2f} to {percentile(ratios, 0.9):.2f})")
        shown += sum(r["interval"] is not None for r in own)
        covered += sum(r["interval"] is not None and r["interval"][0] <= r["true"] <= r["interval"][1] for r in own)
    last = statistics.median(r["true"] for r in runs if r["iterations"] == ITERATIONS[-1])
    return [name, f"{100 * last:.1f} %", *cells, f"{shown} of {len(runs)}", covered], shown, covered


def measure(options, pool, name):
    scene, run_options = CASES[name]
    folder = options.out / name.replace(", ", "_")
    folder.mkdir(parents=True, exist_ok=True)
    seeds = range(FIRST_SEED, FIRST_SEED + options.seeds)
    jobs = {(seed, iterations): pool.submit(
        made_once, options, scene, [*run_options, "--iterations", str(iterations), "--seed", str(seed)],
        folder / f"run_{options.size}_{iterations}_{seed}") for seed in seeds for iterations in ITERATIONS}
    made = {key: job.result() for key, job in jobs.items()}
    pictures = {n: [made[seed, n][0] for seed in seeds] for n in ITERATIONS}
    every = [[sum(n * value for n, value in zip(ITERATIONS, values)) / sum(ITERATIONS) for values in zip(*of_seed)]
             for of_seed in zip(*pictures.values())]
    runs = []
    for n in ITERATIONS:
        true = own_errors(pictures[n], None if run_options is VCM else every)
        for seed, true_error in zip(seeds, true):
            estimate = made[seed, n][1]["estimate"]
            runs.append({"seed": seed, "iterations": n, "true": true_error, "stated": estimate["relative_error"],
                         "interval": estimate["interval"]})
    return runs


def add_options(parser):
    parser.add_argument("--cases", nargs="+", default=list(CASES), choices=list(CASES))


def run(options):
    table = Table("", "true error, 128", "stated / true, 8 iterations", *ITERATIONS[1:], "intervals shown", "that cover")
    all_runs, shown, covered = {}, 0, 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for name in options.cases:
            all_runs[name] = measure(options, pool, name)
            cells, its_shown, its_covered = row_of(name, all_runs[name])
            table.add(*cells)
            shown, covered = shown + its_shown, covered + its_covered
    total = sum(len(runs) for runs in all_runs.values())
    share = f"{100 * covered / shown:.1f} %" if shown else "–"
    table.add("all", *[""] * (1 + len(ITERATIONS)), f"{shown} of {total}", f"{covered}, {share}")
    table.note(f"{options.size} pixels, {options.seeds} seeds. Medians, with the range of eight runs in ten.")
    (options.out / "runs.json").write_text(json.dumps(all_runs, indent=1))
    publish(options, table, DOCUMENT if options.cases == list(CASES) else None)

