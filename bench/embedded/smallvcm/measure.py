"""Inside SmallVCM (github.com/SmallVCM/SmallVCM): instructions a pixel.

Compiles main.cpp with the headers of the checkout: one program, so both sides have the same
options. First it compares the means of the pictures, whose sides must agree. Then callgrind counts;
the difference of two runs leaves out the construction of the scene. The instructions of the
engine's side are the library's (transport, result, render) or the renderer's (the checkout, the
adapter), as the line tables say of the innermost call that is either's. What both use (core, GLM,
the standard library, the C library) counts for whoever calls it.

Writes the table in docs/smallvcm.md.
"""

import pathlib
import subprocess
import sys
import tempfile

import callgrind
from measuring import Table, publish

here = pathlib.Path(__file__).resolve().parent
root = here.parents[2]
A_FILE = "src/scene.hxx"
DOCUMENT = "docs/smallvcm.md"
# In the order of SmallVCM's numbers; the names are those of bench/benches/smallvcm.py.
SCENES = ("svcm0", "svcm1", "point", "background")
INTEGRATORS = ("pt", "bpt", "vcm")
PIXELS = 64 * 64
COMPILE_OPTIONS = ["-O3", "-march=x86-64-v3", "-std=gnu++20", "-DNDEBUG", "-ffp-contract=off", "-g1", "-no-pie", "-w"]
LESS, MORE = 1, 3  # iterations
ITERATIONS_OF_MEANS, TOLERANCE = 64, 0.03

# Owners. Rays are part of the renderer; our numbers are part of the library, SmallVCM's of its
# side.
library, renderer, rays, numbers = "library", "renderer", "rays", "numbers"


def build(checkout, program):
    subprocess.run(["g++", *COMPILE_OPTIONS, "-I", str(root / "include"), "-I", str(checkout / "src"), str(here / "main.cpp"), "-o",
                    program], check=True)


def arguments(side, scene, integrator, iterations):
    return [side, str(SCENES.index(scene)), integrator, str(iterations)]


def mean(program, side, scene, integrator):
    said = subprocess.run([program, *arguments(side, scene, integrator, ITERATIONS_OF_MEANS)], check=True, capture_output=True, text=True)
    return float(said.stdout)


def pictures_that_differ(program, cases):
    differing = []
    for case in cases:
        ours, theirs = (mean(program, side, *case) for side in ("gmis", "smallvcm"))
        difference = ours / theirs - 1
        print(f"{' '.join(case)}: means {ours:.5f} and {theirs:.5f}, {100 * difference:+.2f} %", file=sys.stderr, flush=True)
        if not abs(difference) <= TOLERANCE:
            differing.append(" ".join(case))
    return differing


def owner_in(checkout):
    """A function from a file to its owner; None for code that works for whoever calls it, such as
    SmallVCM's vectors."""
    headers, theirs = f"{root}/include/gmis/", f"{checkout}/src/"
    owners = {headers + part: library for part in ("transport/", "result/", "render/")}
    owners |= {headers + part: numbers for part in ("core/random.hpp", "core/wyrand.hpp")}
    owners |= {theirs + part: None for part in ("math.hxx", "utils.hxx")}
    owners |= {theirs + "rng.hxx": numbers, theirs + "geometry.hxx": rays, theirs + "scene.hxx": rays}
    owners |= {theirs: renderer, f"{here}/": renderer}
    return lambda file: next((whose for start, whose in owners.items() if file.startswith(start)), None)


def runs(side, case):
    return [arguments(side, *case, iterations) for iterations in (LESS, MORE)]


def percents(values):
    low, high = 100 * min(values), 100 * max(values)
    return f"{low:.0f}–{high:.0f} %"


def run(options):
    checkout = options.checkout
    owner = owner_in(checkout)
    cases = [(scene, integrator) for scene in SCENES for integrator in INTEGRATORS]
    parts, alike = {(side, part): [] for side in ("gmis", "smallvcm") for part in (rays, numbers)}, {i: [] for i in INTEGRATORS}
    table = Table("scene", "integrator", "gmis", "SmallVCM", "ratio", "library", "renderer", "library / renderer", numbers_from=2)
    with tempfile.TemporaryDirectory() as folder:
        program = f"{folder}/embedded"
        build(checkout, program)
        differing = pictures_that_differ(program, cases)
        if differing:
            raise SystemExit(f"embedded: more than {100 * TOLERANCE:.0f} % between the means: {', '.join(differing)}: nothing is counted")
        for case in cases:
            sums = {side: callgrind.shares(program, *runs(side, case), owner) for side in ("gmis", "smallvcm")}
            ours, theirs = (sum(s.values()) for s in sums.values())
            of_library, of_renderer = (sums["gmis"][a] + sums["gmis"][b] for a, b in ((library, numbers), (renderer, rays)))
            for side, part in parts:
                parts[side, part].append(sums[side][part] / sum(sums[side].values()))
            alike[case[1]].append(ours / (theirs - sums["smallvcm"][numbers] + sums["gmis"][numbers]))
            ours, theirs, of_library, of_renderer = (n / ((MORE - LESS) * PIXELS) for n in (ours, theirs, of_library, of_renderer))
            table.add(*case, f"{ours:.0f}", f"{theirs:.0f}", f"{ours / theirs:.3f}", f"{of_library:.0f}", f"{of_renderer:.0f}",
                      f"{of_library / of_renderer:.3f}")
    table.note(f"Rays are {percents(parts['gmis', rays])} of the instructions of gmis and {percents(parts['smallvcm', rays])} of SmallVCM's, random "
               f"numbers {percents(parts['gmis', numbers])} and {percents(parts['smallvcm', numbers])}.",
               "With numbers on SmallVCM's side that cost what ours do, the ratio would be at most " +
               ", ".join(f"{max(ratios):.3f} ({integrator})" for integrator, ratios in alike.items()) + ".")
    publish(options, table, DOCUMENT)
