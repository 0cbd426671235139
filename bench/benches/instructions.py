"""Instructions an iteration of all integrators on svcm0 and svcm1 (128×128, 10 segments), beside
those of SmallVCM for the same settings, which are kept in this file.

They are counted by callgrind, because seconds differ from machine to machine: the difference
between runs of 3 and of 1 iterations, so that reading the scene and building its tree do not count.

  instructions   writes its table into docs/smallvcm.md
  parts          where the instructions go, by part of the library (instruction_parts.py); also
                 writes its table into docs/smallvcm.md
  --check        counts small pictures anew (instructions/main.cpp: the engines alone) and compares
                 with the figures kept in bench/instructions.txt: fails when one is above by more
                 than 1 %. The level of the processor is fixed (preset bench: x86-64-v3), and
                 valgrind shows every program the same processor, so the figures depend on the
                 compiler and the C library, not on the machine.
  --keep         counts them and keeps the figures
"""

import pathlib
import sys

import instruction_parts
from measuring import Table, build, compiler_name, has_avx2, in_parallel, instructions_between, publish

DOCUMENT = "docs/smallvcm.md"
KEPT = pathlib.Path("bench/instructions.txt")
REFERENCE = "tests/program/reference"
SCENES = ("svcm0", "svcm1")
INTEGRATORS = ("pt", "lt", "ppm", "bpm", "bpt", "vcm")
LIMIT = 1.01
# The settings of SmallVCM, whose numbers are independent and which connects with every vertex of
# one light path: half the diagonal of its bounding box is 2.21705961, radius 0.003 of it, α = 0.75.
SETTINGS = "--max-depth 10"
OF_MERGING = "--alpha 0.75 --radius 0.00665118u"

# Millions of instructions an iteration of SmallVCM, in the order of INTEGRATORS.
SMALLVCM_INSTRUCTIONS = {"svcm0": (203, 112, 145, 283, 385, 414), "svcm1": (223, 207, 201, 334, 572, 608)}


def add_options(parser):
    parser.add_argument("what", nargs="?", choices=("instructions", "parts"), default="instructions")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--keep", action="store_true")


def how(integrator):
    return (f"--integrator {integrator}" + (" --connections paired" if integrator in ("bpt", "vcm") else "") +
            (f" {OF_MERGING}" if integrator in ("ppm", "bpm", "vcm") else ""))


# --- Figures kept ---------------------------------------------------------------------------------


def small_figures(program):
    """(case, figure), in order."""
    cases = [(scene, integrator) for scene in SCENES for integrator in INTEGRATORS]

    def count(case):
        scene, integrator = case
        return instructions_between(lambda n: [program, f"{REFERENCE}/{scene}.pbrt", integrator, n, 48], 1, 2) / 1e6

    for case, figure in in_parallel(count, cases):
        yield " ".join(case), figure


def keep(program):
    lines = ["# Millions of instructions an iteration, 48x48 pixels. Written by ./run bench instructions --keep; checked by --check.",
             f"# {compiler_name()}", *(f"{case} {figure:.3f}" for case, figure in small_figures(program))]
    KEPT.write_text("\n".join(lines) + "\n")
    print(KEPT.read_text(), end="")


def check(program):
    lines = KEPT.read_text().splitlines()
    kept = {line.rsplit(" ", 1)[0]: float(line.rsplit(" ", 1)[1]) for line in lines if not line.startswith("#")}
    has_grown = False
    for case, figure in small_figures(program):
        grown = case not in kept or figure > LIMIT * kept[case]
        has_grown |= grown
        change = 100 * (figure / kept.get(case, figure) - 1)
        print(f"{case:11} {figure:9.3f}  kept {kept.get(case, 0):9.3f}  {change:+6.2f} %{'  GROWN' if grown else ''}", flush=True)
    if has_grown:
        print("instructions: a figure grew by more than 1 %. Find out why; if it must be, ./run bench instructions --keep", file=sys.stderr)
    return has_grown


# --- Beside SmallVCM ------------------------------------------------------------------------------


def count(options, program):
    table = Table("scene", "integrator", "gmis", "SmallVCM", "ratio")
    cases = [(scene, integrator) for scene in SCENES for integrator in INTEGRATORS]

    def ours_in(case):
        scene, integrator = case
        command = [program, f"{REFERENCE}/{scene}.pbrt", *how(integrator).split(), *SETTINGS.split(), "--threads", "1", "--quiet", "--sampler",
                   "independent", "--out", options.out / f"{scene}_{integrator}.pfm", "--iterations"]
        return instructions_between(lambda n: [*command, n], 1, 3) / 1e6

    for case, ours in in_parallel(ours_in, cases):
        theirs = SMALLVCM_INSTRUCTIONS[case[0]][INTEGRATORS.index(case[1])]
        table.add(*case, f"{ours:.1f}", theirs, f"{ours / theirs:.2f}")
    publish(options, table, DOCUMENT)


def run(options):
    if not has_avx2():
        print("instructions: this processor has no AVX2: nothing is counted", file=sys.stderr)
        return 0
    if options.check and KEPT.read_text().splitlines()[1] != f"# {compiler_name()}":
        print(f"instructions: the figures kept are those of {KEPT.read_text().splitlines()[1][2:]}, this is {compiler_name()}: not compared",
              file=sys.stderr)
        return 0
    if options.check or options.keep:
        return (check if options.check else keep)(build("instruction_counts"))
    if options.what == "parts":
        return publish(options, instruction_parts.table(build("instruction_counts")), DOCUMENT, "parts")
    return count(options, build("gmis-render"))
