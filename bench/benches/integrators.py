"""Every integrator on every paper scene for the same time: relMSE against a converged reference,
iterations, time of an iteration.

The reference of a scene is the mean of two long runs of vcm with other seeds and a quarter of the
usual merging radius, so a sixteenth of its bias: the sun's caustics seen in mirrors are out of
reach of any unbiased integrator here. The relMSE of the two runs against each other is four times
what noise the reference itself has. References are kept in out/integrators and used again.
"""

import datetime
import json
import os
import statistics

from measuring import Table, publish, read_pfm, render, write_pfm

PROGRAM = "gmis-render"
OPTIONS = {"seeds": 2, "size": "128x128", "scenes": ["paper1", "paper2", "paper3", "paper4"]}
INTEGRATORS = {name: f"--integrator {name}" for name in ("pt", "lt", "bpt", "ppm", "bpm", "vcm")} | {
    "gmis, local": "--integrator gmis --split local", "gmis, budgeted": "--integrator gmis --split budgeted"}


def add_options(parser):
    parser.add_argument("--time", type=float, default=10, help="seconds of a cell and seed, on all cores (10)")
    parser.add_argument("--reference-time", type=float, default=120, help="seconds of each of the two runs of a reference (120)")


def run_on_all_cores(options, scene, *arguments, **places):
    return render(options, scene, f"--size {options.size}", *arguments, threads=os.cpu_count(), **places)


def reference_of(options, scene):
    """The file, and how well its two halves agree."""
    file = options.out / f"{scene}_{options.size}.pfm"
    stats = file.with_suffix(".json")
    if not (file.exists() and stats.exists()):
        halves = [options.out / f"{scene}_{half}.pfm" for half in "ab"]
        for half, seed, extra in zip(halves, (1000001, 2000002), ("", f"--reference {halves[0]}")):
            run_on_all_cores(options, scene, f"--integrator vcm --seed {seed} --radius 0.1 --time {options.reference_time:g}", extra,
                             stats=stats, picture=half)
        a, b = map(read_pfm, halves)
        write_pfm(file, ((x + y) / 2 for x, y in zip(a, b)), options.size)
    error = json.loads(stats.read_text())["error"]
    return file, f"{error['relmse']:.2g} (trimmed {error['relmse_trimmed']:.2g})"


def run(options):
    tables = [f"{options.size} pixels, {options.time:g} s a run, the mean of {options.seeds} runs; {os.cpu_count()} threads, "
              f"{datetime.date.today()}.\n"]
    for scene in options.scenes:
        reference, agreement = reference_of(options, scene)
        head = f"**{scene}**; the two halves of its reference differ by a relMSE of {agreement}.\n"
        print(head)
        table = Table("integrator", "relMSE", "relMSE, trimmed", "iterations", "ms an iteration")
        for name, how in INTEGRATORS.items():
            runs = [run_on_all_cores(options, scene, how, f"--seed {seed} --time {options.time:g} --reference {reference}")
                    for seed in range(1, options.seeds + 1)]
            error, trimmed = (statistics.fmean(r["error"][m] for r in runs) for m in ("relmse", "relmse_trimmed"))
            iterations = [r["iterations"] for r in runs]
            table.add(name, f"{error:.3g}", f"{trimmed:.3g}", f"{statistics.fmean(iterations):.0f}",
                      f"{1000 * sum(r['seconds']['wall'] for r in runs) / sum(iterations):.1f}")
        tables += [head, str(table)]
    tables.append("`lt` does not make what is seen in mirrors or through glass: where there are some, its error is what is missing there.\n"
                  "`ppm`, `bpm`, `vcm` and `gmis` merge, with a radius that shrinks from 0.4 pixel widths (gmis, local: 3.2).\n")
    publish(options, "\n".join(tables))
