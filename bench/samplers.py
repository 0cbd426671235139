"""Low-discrepancy numbers beside independent ones, over fourteen scenes.

Every scene is rendered with --sampler independent and with --sampler sobol, in turns, with many seeds. The squared error of a run is
against the mean of the other seeds, which differ from it by noise alone; that without the worst 0.1 % of the pixels is the one that runs state
themselves, with `sobol` from 8 replications, as any user sees it. Times are the least of all seeds, of both in turns.

Writes out/samplers/table.md and, when all scenes took part, the table in docs/numerics.md.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess

from measuring import FOURTEEN, own_errors, read_pfm, write_into

DOCUMENT = pathlib.Path("docs/numerics.md")
BEGIN, END = "<!-- samplers: written by ./run bench samplers -->", "<!-- end of samplers -->"
SAMPLERS = ("independent", "sobol")


def run(options, name, sampler, seed):
    """Statistics and picture."""
    picture, stats = options.out / "picture.pfm", options.out / "stats.json"
    subprocess.run([options.renderer, FOURTEEN[name], "--integrator", options.integrator, "--sampler", sampler, "--seed", str(seed), "--size",
                    options.size, "--iterations", str(options.iterations), "--threads", "1", "--quiet", "--stats", str(stats), "--out",
                    str(picture)], check=True, stdin=subprocess.DEVNULL)
    return json.loads(stats.read_text()), read_pfm(picture)


def ratios(options, name):
    """Sobol' over independent: squared error, the same without the worst pixels, processor time."""
    runs = {sampler: [] for sampler in SAMPLERS}
    for seed in range(1, options.seeds + 1):
        for sampler in SAMPLERS:
            runs[sampler].append(run(options, name, sampler, seed))
    figures = []
    for sampler in SAMPLERS:
        errors = own_errors([picture for _, picture in runs[sampler]])
        stated = [stats["estimate"]["relative_error_trimmed"] for stats, _ in runs[sampler]]
        figures.append((statistics.fmean(error**2 for error in errors), statistics.fmean(error**2 for error in stated),
                        min(stats["seconds"]["cpu"] for stats, _ in runs[sampler])))
    return [sobol / independent for independent, sobol in zip(*figures)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renderer", required=True)
    parser.add_argument("--integrator", default="auto")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--size", default="64x64")
    parser.add_argument("--iterations", type=int, default=64)
    parser.add_argument("--scenes", nargs="*", default=list(FOURTEEN), choices=list(FOURTEEN))
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/samplers"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    lines = ["| | squared error | without the worst 0.1 % of the pixels | processor time | error × time | without the worst |", "|" + " --- |" * 6]
    rows = []
    for name in options.scenes:
        error, trimmed, time = ratios(options, name)
        rows.append((error, trimmed, time, error * time, trimmed * time))
        lines.append(f"| {name} | {' | '.join(f'{value:.2f}' for value in rows[-1])} |")
        print(lines[-1], flush=True)
    means = [math.exp(statistics.fmean(math.log(value) for value in column)) for column in zip(*rows)]
    lines.append(f"| geometric mean | {' | '.join(f'{value:.2f}' for value in means)} |")
    note = (f"\n`{options.integrator}`, Sobol' points over independent numbers: {options.size} pixels, {options.iterations} iterations, "
            f"{options.seeds} seeds.\n")
    table = "\n".join(lines) + "\n" + note
    (options.out / "table.md").write_text(table)
    if options.scenes == list(FOURTEEN) and options.integrator == "auto":
        write_into(DOCUMENT, BEGIN, END, table)
    print(lines[-1] + "\n" + note)


main()
