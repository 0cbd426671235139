"""Low-discrepancy numbers beside independent ones, over fourteen scenes.

Every scene is rendered with --sampler independent and with --sampler sobol, in turns, with many
seeds. The squared error of a run is against the mean of the other seeds, which differ from it by
noise alone; that without the worst 0.1 % of the pixels is the one that runs state themselves, with
`sobol` from 8 replications, as any user sees it. Times are the least of all seeds, of both in
turns.

Writes the table in docs/numerics.md.
"""

import math
import statistics

from measuring import FOURTEEN, Table, own_errors, publish, read_pfm, render

PROGRAM = "gmis-render"
OPTIONS = {"seeds": 8, "size": "64x64", "iterations": 64, "scenes": FOURTEEN}
DOCUMENT = "docs/numerics.md"
SAMPLERS = ("independent", "sobol")


def sampled(options, name, sampler, seed):
    """Statistics and picture."""
    stats = render(options, name, f"--integrator {options.integrator} --sampler {sampler} --seed {seed} --size {options.size} "
                                  f"--iterations {options.iterations}")
    return stats, read_pfm(options.out / "picture.pfm")


def add_options(parser):
    parser.add_argument("--integrator", default="auto")


def ratios(options, name):
    """Sobol' over independent: squared error, the same without the worst pixels, processor time."""
    runs = {sampler: [] for sampler in SAMPLERS}
    for seed in range(1, options.seeds + 1):
        for sampler in SAMPLERS:
            runs[sampler].append(sampled(options, name, sampler, seed))
    figures = []
    for sampler in SAMPLERS:
        errors = own_errors([picture for _, picture in runs[sampler]])
        stated = [stats["estimate"]["relative_error_trimmed"] for stats, _ in runs[sampler]]
        figures.append((statistics.fmean(error**2 for error in errors), statistics.fmean(error**2 for error in stated),
                        min(stats["seconds"]["cpu"] for stats, _ in runs[sampler])))
    return [sobol / independent for independent, sobol in zip(*figures)]


def run(options):
    table = Table("", "squared error", "without the worst 0.1 % of the pixels", "processor time", "error × time", "without the worst")
    rows = []
    for name in options.scenes:
        error, trimmed, time = ratios(options, name)
        rows.append((error, trimmed, time, error * time, trimmed * time))
        table.add(name, *(f"{value:.2f}" for value in rows[-1]))
    means = [math.exp(statistics.fmean(math.log(value) for value in column)) for column in zip(*rows)]
    table.add("geometric mean", *(f"{value:.2f}" for value in means))
    table.note(f"`{options.integrator}`, Sobol' points over independent numbers: {options.size} pixels, {options.iterations} iterations, "
               f"{options.seeds} seeds.")
    publish(options, table, DOCUMENT if options.integrator == "auto" else None)

