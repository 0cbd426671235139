"""Error × time of --integrator auto in interiors, over pt, bpt, vcm and the best fixed counts.

The argument is a folder with the scenes of gonsolo/bitterli, NAME/pbrt/scene-v4.pbrt. Missing
textures become grey; missing meshes and included files are left out (bench/interiors/prepare.py).

All configurations render for the same processor time on one thread. The error of a run is against
two long runs of bpt: the product of its differences from the two. Bias² is the mean product of the
errors of two seeds, one against either long run, so that no noise of a run or of the reference is
in it; noise² is the rest of relMSE, both without the thousandth of the pixels that lie farthest
off. The best fixed configuration is picked with one seed and scored with another. Auto states a
bound on its bias: the table says in how many runs it is not surely broken, by two standard errors
of bias². A fixed configuration that takes 1.5 times the work of the best one in a run of eight
iterations is out.

Writes out/interiors/runs.json, and the table in docs/effects.md.
"""

import concurrent.futures
import itertools
import json
import os
import pathlib
import statistics

import errors
import measuring
from benches.effects import FIXED, geometric_mean, not_hopeless
from interiors.prepare import prepare
from measuring import Table, publish, read_pfm, write_pfm

PROGRAM = "gmis-render"
OPTIONS = {"seeds": 2, "scenes": ["bathroom", "bedroom", "classroom", "house", "kitchen"]}
BY_ITSELF = False
DOCUMENT = "docs/effects.md"
NAMED = {name: ["--integrator", name] for name in ("auto", "pt", "bpt", "vcm")}


def add_options(parser):
    parser.add_argument("folder", type=pathlib.Path, metavar="FOLDER", help="of the interiors")
    parser.add_argument("--sizes", nargs="+", default=["128x72"], help="of the pictures in pixels, WIDTHxHEIGHT")
    parser.add_argument("--seconds", type=float, default=2, help="processor time of a run 128 pixels wide; it goes with the width")
    parser.add_argument("--reference-time", type=float, default=8, help="processor time of each half of a reference, in times of a run")
    parser.add_argument("--no-fixed", action="store_true", help="leave out the fixed counts other than those of pt, bpt and vcm")


def render(options, scene, size, extra, stem):
    """The statistics of a run. Statements of the file that are not understood are left out."""
    return measuring.render_once(options, scene, "--lenient", f"--size {size} --max-depth 12", " ".join(extra), stem=stem)


def iterations_for(options, scene, size, extra, seconds, stem):
    """The number of iterations that takes `seconds` of processor time, and the statistics of the
    run that showed it."""
    tried = 8
    stats = render(options, scene, size, [*extra, f"--iterations {tried}"], stem)
    return max(4, round(tried * seconds / stats["seconds"]["cpu"])), stats


def summary(runs, references, width):
    """Figures of the runs of one configuration: works by seed, means, and bias² with its standard
    error."""
    pictures = [read_pfm(picture) for _, picture in runs]
    squares = [errors.relmse(picture, references) for picture in pictures]
    cpu = statistics.fmean(stats["seconds"]["cpu"] for stats, _ in runs)
    bias, spread = errors.squared_bias(pictures, references, width)
    return {"works": [all_pixels * cpu for all_pixels, _ in squares], "works_trimmed": [trimmed * cpu for _, trimmed in squares],
            "bias2": bias, "bias2_error": spread, "noise2": statistics.fmean(trimmed for _, trimmed in squares) - bias,
            "energy": statistics.fmean(map(sum, pictures)) / statistics.fmean(map(sum, references)) - 1,
            "megabytes": max(stats["memory"]["peak_bytes"] for stats, _ in runs) / 2**20,
            "bounds": [stats["estimate"]["merging_bias_bound"] for stats, _ in runs]}


def best_of(figures, pool, measure):
    """The least mean work among configurations, picked with all other seeds and scored with one,
    for each in turn: the mean, and what was picked."""
    picked, scores = [], []
    for seed in range(len(figures["auto"][measure])):
        best = min(pool, key=lambda label: sum(work for k, work in enumerate(figures[label][measure]) if k != seed))
        picked.append(best)
        scores.append(figures[best][measure][seed])
    return statistics.fmean(scores), ", ".join(dict.fromkeys(picked))


def measure(options, name, size):
    """The figures of all configurations, by their names."""
    scene, missing = prepare(options.folder / name / "pbrt/scene-v4.pbrt", options.out / "scenes" / name)
    print(f"{name}: {len(missing)} missing files", *missing, flush=True)
    stem = options.out / f"{name}_{size}"
    seconds = options.seconds * int(size.split("x")[0]) / 128
    configurations = NAMED | ({} if options.no_fixed else FIXED)

    def place(label, end):
        return pathlib.Path(f"{stem}_{label.replace(' ', '_').replace('.', '')}_{end}")

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        paces = {label: pool.submit(iterations_for, options, scene, size, extra, seconds, place(label, "pace")) for label, extra in configurations.items()}
        counts, short = ({label: pace.result()[k] for label, pace in paces.items()} for k in (0, 1))
        halves = {seed: place("reference", seed) for seed in (1001, 1002)}
        long = f"--iterations {round(counts['bpt'] * options.reference_time)}"
        jobs = [pool.submit(render, options, scene, size, [*NAMED["bpt"], f"{long} --seed {seed}"], half) for seed, half in halves.items()]
        for job in jobs:
            job.result()
        references = [read_pfm(half.with_suffix(".pfm")) for half in halves.values()]
        errors_of = {label: errors.relmse(read_pfm(place(label, "pace").with_suffix(".pfm")), references) for label in FIXED.keys() & configurations.keys()}
        hopeful = not_hopeless({label: [error * short[label]["seconds"]["cpu"] for error in both] for label, both in errors_of.items()})
        kept = {label: extra for label, extra in configurations.items() if label in NAMED or label in hopeful}
        runs = {label: [] for label in kept}
        for seed in range(options.seeds):  # they take turns
            for label, extra in kept.items():
                file = place(label, seed)
                job = pool.submit(render, options, scene, size, [*extra, f"--iterations {counts[label]} --seed {seed}"], file)
                runs[label].append((job, file.with_suffix(".pfm")))
        runs = {label: [(job.result(), picture) for job, picture in own] for label, own in runs.items()}
    write_pfm(place("reference", "mean").with_suffix(".pfm"), [(a + b) / 2 for a, b in zip(*references)], size)
    return {label: summary(own, references, int(size.split("x")[0])) for label, own in runs.items()}


def run(options):
    table = Table("scene", "size", "auto / pt", "/ bpt", "/ vcm", "/ best fixed", "untrimmed / best fixed", "best fixed", "noise²", "bias²",
                  "bounds not broken", "energy", "MB", numbers_from=2)
    every, ratios = {}, []
    for name, size in itertools.product(options.scenes, options.sizes):
        figures = every[f"{name} {size}"] = measure(options, name, size)
        auto, pool = figures["auto"], [label for label in figures if label in FIXED] or ["pt", "bpt", "vcm"]
        best, names = best_of(figures, pool, "works_trimmed")
        work, trimmed = (statistics.fmean(auto[measure]) for measure in ("works", "works_trimmed"))
        row = [trimmed / statistics.fmean(figures[label]["works_trimmed"]) for label in ("pt", "bpt", "vcm")]
        row += [trimmed / best, work / best_of(figures, pool, "works")[0]]
        ratios.append(row)
        held = sum(bound**2 >= auto["bias2"] - 2 * auto["bias2_error"] for bound in auto["bounds"])
        table.add(name, size, *(f"{value:.2f}" for value in row), names, f"{auto['noise2']:.4f}", f"{auto['bias2']:.4f} ± {auto['bias2_error']:.4f}",
                  f"{held} of {options.seeds}", f"{auto['energy']:+.4f}", f"{auto['megabytes']:.0f}")
        (options.out / "runs.json").write_text(json.dumps(every, indent=1))
    table.add("geometric mean", "", *(f"{geometric_mean(column):.2f}" for column in zip(*ratios)), *[""] * 6)
    table.note(f"{options.seconds:g} processor seconds a run 128 pixels wide, {options.seeds} seeds, at most 12 segments. Ratios are those of work, "
               "relMSE × processor seconds without the worst thousandth of the pixels where not said otherwise.")
    publish(options, table, DOCUMENT)
