"""Efficiency beside SmallVCM, the reference implementation of vertex connection and merging.

Takes a checkout of SmallVCM (github.com/SmallVCM/SmallVCM), copies it, sets the size of the
picture, one thread and the seed in its source, compiles it as the programs here are, and renders
its four scenes with its own algorithms and with --integrator auto of gmis-render. Efficiency is 1 /
(relMSE × processor seconds), means over seeds. An error is the product of the differences from two
references, so that their noise is not in it. The references of two scenes are in
tests/program/reference. SmallVCM makes the others first, with other seeds: under a point light by
vcm, for bpt lacks the caustics that are seen in mirrors, under a background by bpt. A fault of its
own, if there is one, is then in the reference, to our disadvantage.

Writes the table in docs/smallvcm.md. Without a checkout nothing is measured.
"""

import array
import os
import pathlib
import re
import shutil
import statistics
import subprocess

from errors import relmse
from measuring import Table, publish, read_pfm, render

PROGRAM = "gmis-render"
OPTIONS = {"seeds": 6, "iterations": 64}
BY_ITSELF = False
DOCUMENT = "docs/smallvcm.md"
REFERENCES = pathlib.Path("tests/program/reference")
# Name: file, number in SmallVCM, and what makes the references where there are none.
SCENES = {"svcm0": (REFERENCES / "svcm0.pbrt", 0, None), "svcm1": (REFERENCES / "svcm1.pbrt", 1, None),
          "point": (pathlib.Path("bench/scenes/smallvcm/point.pbrt"), 2, "vcm"),
          "background": (pathlib.Path("bench/scenes/smallvcm/background.pbrt"), 3, "bpt")}
ALGORITHMS = ("pt", "ppm", "bpm", "bpt", "vcm")
EDITS = {"Vec2i(512, 512)": "Vec2i(128, 128)", "mNumThreads    = 0;": "mNumThreads    = 1;",
         "mBaseSeed      = 1234;": 'mBaseSeed      = atoi(getenv("SMALLVCM_SEED"));'}


def build(checkout, out):
    source = out / "source"
    shutil.rmtree(source, ignore_errors=True)
    shutil.copytree(checkout / "src", source)
    config = source / "config.hxx"
    text = config.read_text()
    for old, new in EDITS.items():
        if old not in text:
            raise SystemExit(f"smallvcm: {config} has no {old}: another version?")
        text = text.replace(old, new)
    config.write_text("#include <cstdlib>\n" + text)
    program = (out / "smallvcm").absolute()
    subprocess.run(["g++", "-O3", "-march=x86-64-v3", "-fno-math-errno", "-std=c++11", "-fopenmp", "-w", "-o", str(program), str(source / "smallvcm.cxx")], check=True)
    return program


def read_hdr(file):
    """All channels of all pixels, by rows from the bottom, as in a .pfm."""
    head, rest = file.read_bytes().split(b"+X ", 1)
    width, pixels = rest.split(b"\n", 1)
    width, height = int(width), int(re.search(rb"-Y (\d+)", head)[1])
    values = array.array("f")
    for y in reversed(range(height)):
        for k in range(4 * y * width, 4 * (y + 1) * width, 4):
            *colour, exponent = pixels[k:k + 4]
            values.extend((c + 0.5) * 2.0 ** (exponent - 136) if exponent else 0.0 for c in colour)
    return values


def theirs(program, options, scene, algorithm, seed, iterations):
    picture = options.out / "picture.hdr"
    said = subprocess.run([str(program), "-s", str(SCENES[scene][1]), "-a", algorithm, "-i", str(iterations), "-o", str(picture)], check=True,
                          capture_output=True, text=True, env=os.environ | {"SMALLVCM_SEED": str(1000 * seed)}).stdout
    return read_hdr(picture), float(re.search(r"done in ([0-9.]+) s", said)[1])


def ours(options, scene, iterations, seed):
    stats = render(options, SCENES[scene][0], f"--integrator auto --max-depth 10 --iterations {iterations} --seed {seed}")
    return read_pfm(options.out / "picture.pfm"), stats["seconds"]["cpu"]


def references_of(program, options, scene):
    """Two pictures of independent noise."""
    file, _, algorithm = SCENES[scene]
    if algorithm is None:
        return [read_pfm(file.with_name(f"{file.stem}_{half}.pfm")) for half in "ab"]
    return [theirs(program, options, scene, algorithm, seed, options.reference_iterations)[0] for seed in (998, 999)]


def add_options(parser):
    parser.add_argument("checkout", type=pathlib.Path, help="of SmallVCM")
    parser.add_argument("--reference-iterations", type=int, default=1000, help="of each picture that SmallVCM makes for comparison")


def run(options):
    program = build(options.checkout, options.out)
    table = Table("scene", "", "relMSE", "trimmed", "processor seconds", "efficiency over SmallVCM's vcm", "trimmed")
    for scene in SCENES:
        references = references_of(program, options, scene)
        runs = {f"SmallVCM, {algorithm}": (lambda seed, a=algorithm: theirs(program, options, scene, a, seed, options.iterations)) for algorithm in ALGORITHMS}
        for times in (1, 3):
            runs[f"auto, {times * options.iterations} iterations"] = lambda seed, n=times * options.iterations: ours(options, scene, n, seed)
        figures = {label: [] for label in runs}
        for seed in range(1, options.seeds + 1):  # in turns
            for label, run in runs.items():
                picture, seconds = run(seed)
                figures[label].append((*relmse(picture, references), seconds))
        means = {label: [statistics.fmean(column) for column in zip(*rows)] for label, rows in figures.items()}
        base = means["SmallVCM, vcm"]
        for label, (error, trimmed, seconds) in means.items():
            efficiencies = [base[m] * base[2] / (value * seconds) for m, value in enumerate((error, trimmed))]
            table.add(scene, label, f"{error:.4f}", f"{trimmed:.4f}", f"{seconds:.2f}", *(f"{e:.2f}" for e in efficiencies))
    table.note(f"128x128 pixels, {options.iterations} iterations, {options.seeds} seeds, one thread.")
    publish(options, table, DOCUMENT, "efficiency")
