"""Efficiency beside Cycles, the path tracer of Blender.

Needs `blender` (Debian: apt-get install blender); without it nothing is measured. Both sides read
the same scene files (bench/cycles/description.py), in which a diffuse surface mixed with a metal
replaces each Phong material, for Cycles has none. Both render with one thread, without clamping,
denoising or adaptive sampling, with paths of at most 10 segments and a box filter of one pixel.

First the pictures of both sides are compared, as a whole and in blocks: where they differ by more
than chance and 2 %, the run fails. Efficiency is 1 / (relMSE × processor seconds), means over
seeds, against two long runs of gmis that merge within a quarter of its radius: an error is the
product of the differences from the two, so that their noise is not in it. Seconds of Cycles are
those of a run less those of one sample; seconds of gmis are those of its process, less what a run
of one iteration spends besides rendering. The last table has rays alone: a million triangles,
direct light, equal samples.

Writes the tables in docs/cycles.md.
"""

import array
import json
import math
import pathlib
import shutil
import statistics
import subprocess
import sys

from cycles import description
from errors import relmse
from measuring import Table, processor_cost, publish, read_pfm

PROGRAM = "gmis-render"
OWN = pathlib.Path("bench/cycles")
SCENES = {name: pathlib.Path("examples/scenes", f"{name}.pbrt") for name in ("cornell", "paper1", "paper2", "paper3", "paper4")}
SCENES |= {"glass_balls": OWN / "glass_balls.pbrt", "light_behind_glass": pathlib.Path("bench/scenes/light_behind_glass.pbrt"),
           "diffuse_balls": OWN / "diffuse_balls.pbrt"}
OPTIONS = {"seeds": 3, "iterations": 64, "size": "96x96", "scenes": list(SCENES)}
BY_ITSELF = False
DOCUMENT = "docs/cycles.md"
INTEGRATORS = ("auto", "pt", "vcm")
REFERENCE = ("gmis", "--radius", "0.8")
SEGMENTS = 10
# Rendered with the meshes of Cycles, too.
WITH_MESHES = ("glass_balls", "diffuse_balls")
# The sun makes caustics that no path from the camera finds: both sides are compared without them.
COMPARED_BY_PT = ("paper4",)
BLOCK = 16  # pixels
TOLERANCE = 0.02  # of a block's mean, for materials that are not quite alike
ERRORS = 4.5  # standard errors that count as chance
APART = 0.02  # share of blocks that may differ by more
VAGUE = 0.1  # share of blocks whose mean by Cycles may be unknown by TOLERANCE, for a reference
SQUARES = 707  # along a side of the landscape: a million triangles


def add_options(parser):
    parser.add_argument("--blender", default=shutil.which("blender"), help="the program")
    parser.add_argument("--samples", type=int, default=64, help="a pixel, of Cycles")
    parser.add_argument("--long", type=int, default=12, help="length of either half of our reference, in times of a run")
    parser.add_argument("--runs-of-cycles", type=int, default=4, help="with each seed; all of them together are its own reference")


# --- Both sides -----------------------------------------------------------------------------------


def prepared(options, name, file):
    """The file that both sides read."""
    made = options.out / f"{name}.pbrt"
    made.write_text(description.without_phong(file.read_text()))
    return made


def by_cycles(options, scene, runs, segments=SEGMENTS):
    """Pictures and processor seconds of runs, (samples, seed), of one Blender. A run of one sample
    comes before each, and its seconds are subtracted."""
    job, out = options.out / f"{scene.stem}.job.json", options.out / f"{scene.stem}.cycles.pfm"
    listed = []
    for k, (samples, seed) in enumerate(runs):
        listed += [{"samples": 1, "seed": seed}, {"samples": samples, "seed": seed, "out": f"{out}.{k}"}]
    job.write_text(json.dumps({"scene": str(scene), "size": [int(x) for x in options.size.split("x")], "segments": segments,
                               "runs": [{"samples": 1, "seed": 0}, *listed]}))
    said = subprocess.run([options.blender, "-b", "-t", "1", "--python-exit-code", "1", "--python", str(OWN / "in_blender.py"), "--", str(job)],
                          stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if said.returncode != 0:
        raise SystemExit(said.stdout[-1000:] + said.stderr[-3000:] + "\ncycles: Blender failed")
    done = json.loads(job.with_suffix(".done.json").read_text())["runs"][1:]
    pictures = []
    for k, (one, run) in enumerate(zip(done[0::2], done[1::2])):
        picture = pathlib.Path(f"{out}.{k}")
        pictures.append((read_pfm(picture), (run["seconds"] - one["seconds"]) * run["samples"] / (run["samples"] - 1)))
        picture.unlink()
    return pictures


def by_gmis(options, scene, integrator, iterations, seed, *more, segments=SEGMENTS):
    """Picture and processor seconds of a run: those of its process, less what a run of one
    iteration spends besides rendering."""
    def cost(n):
        stats, picture = options.out / "stats.json", options.out / "picture.pfm"
        command = [options.program, str(scene), "--threads", "1", "--quiet", "--integrator", integrator, *more, "--max-depth", str(segments), "--size", options.size,
                   "--iterations", str(n), "--seed", str(seed), "--stats", str(stats), "--out", str(picture)]
        return processor_cost(command)[0], json.loads(stats.read_text())["seconds"]["cpu"]

    one, stated = cost(1)
    spent, _ = cost(iterations)
    return read_pfm(options.out / "picture.pfm"), spent - max(0, one - stated)


# --- Are the pictures alike? ----------------------------------------------------------------------


def blocks(picture, size):
    """Means over square blocks and channels."""
    width, height = (int(x) for x in size.split("x"))
    return [statistics.fmean(picture[3 * (y * width + x) + c] for y in range(top, min(top + BLOCK, height)) for x in range(left, min(left + BLOCK, width)) for c in range(3))
            for top in range(0, height, BLOCK) for left in range(0, width, BLOCK)]


def compare(theirs, ours, size):
    """The ratio of the means, the median of the relative differences of blocks, the share of blocks
    that differ by more than TOLERANCE and chance, the share of blocks where chance is more than
    TOLERANCE, and whether the means of whole pictures differ. Both sides are lists of pictures."""
    sides = [[blocks(picture, size) for picture in side] for side in (theirs, ours)]
    scale = statistics.fmean(map(statistics.fmean, sides[1]))

    def difference(a, b):
        """Means of numbers of the two sides, and the size of differences that are chance."""
        chance = ERRORS * math.hypot(*(statistics.stdev(side) / math.sqrt(len(side)) for side in (a, b)))
        return statistics.fmean(a), statistics.fmean(b), chance

    found = [difference(*block) for block in zip(zip(*sides[0]), zip(*sides[1]))]
    relative = statistics.median(abs(t / o - 1) for t, o, _ in found if o > 0)
    apart = statistics.fmean(abs(t - o) > TOLERANCE * (o + 0.05 * scale) + c for t, o, c in found)
    vague = statistics.fmean(c > TOLERANCE * o for _, o, c in found)
    t, o, c = difference(*([statistics.fmean(picture) for picture in side] for side in sides))
    return t / o, relative, apart, vague, abs(t - o) > TOLERANCE * o + c


# --- Efficiency -----------------------------------------------------------------------------------


def halves_of(pictures, left_out=None):
    """Means of every second picture and of the others, without one."""
    kept = [picture for k, picture in enumerate(pictures) if k != left_out]
    return [array.array("f", map(statistics.fmean, zip(*half))) for half in (kept[0::2], kept[1::2])]


def measure(options, name, alike):
    """Figures of both sides by label: relMSE, trimmed, against Cycles's own pictures, seconds."""
    scene = prepared(options, name, SCENES[name])
    integrator, *radius = REFERENCE
    halves = [by_gmis(options, scene, integrator, options.long * options.iterations, seed, *radius)[0] for seed in (1001, 1002)]
    of_gmis = {integrator: (integrator, scene) for integrator in INTEGRATORS}
    if name in WITH_MESHES:
        meshes = options.out / f"{name}_meshes.pbrt"
        meshes.write_text(description.with_meshes(scene.read_text()))
        of_gmis["auto, spheres as meshes"] = "auto", meshes
    runs = {label: [] for label in ("Cycles", *of_gmis)}
    for seed in range(1, options.seeds + 1):  # in turns
        runs["Cycles"] += by_cycles(options, scene, [(options.samples, seed + 1000 * k) for k in range(options.runs_of_cycles)])
        for label, (integrator, file) in of_gmis.items():
            runs[label].append(by_gmis(options, file, integrator, options.iterations, seed))
    pictures = {label: [picture for picture, _ in of_label] for label, of_label in runs.items()}
    alike.take(name, pictures["Cycles"], pictures["pt"] if name in COMPARED_BY_PT else halves)
    own, figures = halves_of(pictures["Cycles"]), {}
    for label, of_label in runs.items():
        errors = [relmse(picture, halves) for picture in pictures[label]]
        to_own = [relmse(picture, halves_of(pictures["Cycles"], k) if label == "Cycles" else own)[1] for k, picture in enumerate(pictures[label])]
        figures[label] = [*map(statistics.fmean, zip(*errors)), statistics.fmean(to_own), statistics.fmean(seconds for _, seconds in of_label)]
    return figures


class Alike:
    """The table of the comparison in blocks, and its verdict."""

    def __init__(self, options):
        self.size, self.failed, self.vague = options.size, [], {}
        self.table = Table("scene", "mean of Cycles over gmis", "median difference of blocks", "blocks apart", "blocks in noise", numbers_from=1)

    def take(self, name, theirs, ours):
        ratio, median, apart, vague, is_off = compare(theirs, ours, self.size)
        self.table.add(name, f"{ratio:.4f}", f"{100 * median:.2f} %", f"{100 * apart:.0f} %", f"{100 * vague:.0f} %")
        self.vague[name] = vague
        if apart > APART or is_off:
            self.failed.append(name)

    def converges(self, name):
        """Whether the mean of all runs of Cycles is known well enough to be a reference."""
        return name not in COMPARED_BY_PT and self.vague[name] < VAGUE


# --- Rays alone -----------------------------------------------------------------------------------


def landscape(options):
    """A scene file of a million triangles in a .ply file beside it: rows of hills under a lamp."""
    side = SQUARES + 1
    points, faces = array.array("f"), bytearray()
    for j in range(side):
        for i in range(side):
            x, z = 4 * i / SQUARES - 2, 4 * j / SQUARES - 2
            points.extend((x, 0.15 * math.sin(5 * x) * math.cos(4 * z) + 0.02 * math.sin(61 * x + 40 * z) * math.sin(53 * z), z))
    for k in (i + j * side for j in range(SQUARES) for i in range(SQUARES)):
        faces += description.FACE.pack(3, k, k + side, k + 1) + description.FACE.pack(3, k + 1, k + side, k + side + 1)
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {side * side}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {2 * SQUARES * SQUARES}\nproperty list uchar int vertex_indices\nend_header\n")
    (options.out / "landscape.ply").write_bytes(head.encode() + points.tobytes() + faces)
    made = options.out / "landscape.pbrt"
    made.write_text((OWN / "landscape.pbrt").read_text())
    return made


def rays(options):
    """The table of a million triangles: camera rays and shadow rays alone."""
    scene = landscape(options)
    runs = {"Cycles": [], "gmis, pt": []}
    for seed in range(1, options.seeds + 1):
        runs["Cycles"] += by_cycles(options, scene, [(options.samples, seed)], segments=2)
        runs["gmis, pt"].append(by_gmis(options, scene, "pt", options.samples, seed, segments=2))
    table = Table("a million triangles, direct light", "processor seconds", "over Cycles", "relMSE", numbers_from=1)
    pictures = {label: [picture for picture, _ in of_label] for label, of_label in runs.items()}
    base = statistics.fmean(seconds for _, seconds in runs["Cycles"])
    for label, of_label in runs.items():
        # Each run against the others of both sides.
        errors = [relmse(picture, halves_of([p for other in pictures for j, p in enumerate(pictures[other]) if (other, j) != (label, k)]))[0]
                  for k, picture in enumerate(pictures[label])]
        seconds = statistics.fmean(seconds for _, seconds in of_label)
        table.add(label, f"{seconds:.2f}", f"{seconds / base:.2f}", f"{statistics.fmean(errors):.2g}")
    ratio = statistics.fmean(map(statistics.fmean, pictures["Cycles"])) / statistics.fmean(map(statistics.fmean, pictures["gmis, pt"]))
    table.note(f"{options.size} pixels, {options.samples} samples a pixel, {options.seeds} seeds, one thread; mean of Cycles over gmis: {ratio:.4f}.")
    return table


def run(options):
    if not options.blender:
        print("cycles: no blender here: apt-get install blender, or --blender PROGRAM", file=sys.stderr)
        return 1
    alike, measured = Alike(options), {}
    for name in options.scenes:
        measured[name] = measure(options, name, alike)
    if alike.failed:
        print(f"cycles: the pictures differ, so that nothing else is said: {', '.join(alike.failed)}", file=sys.stderr)
        return 1
    size = f"{options.size} pixels, {options.seeds} seeds, one thread"
    alike.table.note(f"{size}; Cycles: {options.seeds * options.runs_of_cycles} runs of {options.samples} samples.")
    publish(options, alike.table, DOCUMENT, "cycles alike")
    table = Table("scene", "", "relMSE", "trimmed", "processor seconds", "efficiency over Cycles", "trimmed efficiency", "by Cycles's pictures", numbers_from=2)
    for name, figures in measured.items():
        base = figures["Cycles"]
        for label, (*errors, seconds) in figures.items():
            gains = [f"{b * base[-1] / (error * seconds):.2f}" for b, error in zip(base, errors)]
            table.add(name, label, f"{errors[0]:.4f}", f"{errors[1]:.4f}", f"{seconds:.2f}", *gains[:2], gains[2] if alike.converges(name) else "–")
    table.note(f"{size}; {options.samples} samples a pixel of Cycles, {options.iterations} iterations of gmis.")
    publish(options, table, DOCUMENT, "cycles")
    publish(options, rays(options), DOCUMENT, "cycles rays")
    return 0
