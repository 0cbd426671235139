"""Efficiency of --pixel-counts learned over uniform: relMSE × processor seconds of the second over
that of the first.

Each scene is rendered with both by several seeds in turns, by auto, and compared with a reference:
svcm0, svcm1, tung1 and tung2 with those of tests/program/reference (128x128 pixels), the others
with one that is rendered first, or that lies in a folder. Writes the table in docs/effects.md.
"""

import pathlib

from measuring import FOREIGN, FOURTEEN, Table, depth_of, publish, render
from pairs import Pair

PROGRAM = "gmis-render"
OPTIONS = {"seeds": 3, "size": "128x128", "iterations": 64, "scenes": FOREIGN | FOURTEEN}
DOCUMENT = "docs/effects.md"


def add_options(parser):
    parser.add_argument("--references", type=pathlib.Path, help="folder with SCENE.pfm of this size")


def reference_of(options, scene, settings):
    if scene in FOREIGN:
        return pathlib.Path(FOREIGN[scene]).with_suffix(".pfm")
    if options.references:
        file = next(options.references.glob(f"{scene}_{options.size}*.pfm"), options.references / f"{scene}.pfm")
        if not file.exists():
            raise SystemExit(f"pixel_counts: there is no {file}")
        return file
    file = options.out / f"{scene}.pfm"
    render(options, scene, settings, "--integrator gmis --connections 1 --radius 0.8 --iterations 3000 --seed 7777", picture=file)
    return file


def run(options):
    pair = Pair("pixel-counts", "uniform", "learned")
    table = Table("scene", *pair.head())
    for scene in options.scenes:
        settings = [f"--size {options.size}", *depth_of(scene, 16)]
        reference = reference_of(options, scene, " ".join(settings))
        table.add(scene, *pair.cells(options, scene, *settings, f"--integrator auto --reference {reference}"))
    table.note(f"{options.size} pixels, {options.iterations} iterations, the means of {options.seeds} seeds, one thread.")
    publish(options, table, DOCUMENT)
