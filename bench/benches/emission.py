"""Efficiency of --emission learned over --emission power: relMSE × processor seconds of the second
over that of the first.

Each scene is rendered with both by several seeds in turns, and compared with a reference: vertex
connection and merging with a small radius and many iterations.
"""

from measuring import TWENTY_FOUR, Table, publish, render
from pairs import Pair

PROGRAM = "gmis-render"
OPTIONS = {"seeds": 4, "size": "64x64", "iterations": 64, "scenes": ["far_sun", "telephoto", "huge_ground", "open_sky", "cornell"]}


def add_options(parser):
    parser.add_argument("--integrators", nargs="+", default=["vcm", "auto"])


def run(options):
    pair = Pair("emission", "power", "learned")
    table = Table("scene", "integrator", *pair.head())
    settings = f"--size {options.size} --max-depth 10"
    for scene in options.scenes:
        reference = options.out / f"{scene}.pfm"
        render(options, scene, settings, "--integrator vcm --emission learned --radius 0.2 --iterations 3000 --seed 77", picture=reference)
        for integrator in options.integrators:
            table.add(scene, integrator, *pair.cells(options, scene, settings, f"--integrator {integrator} --reference {reference}"))
    publish(options, table)
