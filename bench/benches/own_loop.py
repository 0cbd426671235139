"""Instructions a round of N3 by `estimate` over those of a loop by hand with the same checks and
sums (bench/own_loop/loops.hpp).

Counted by callgrind: the difference between runs of 3000 and of 1000 rounds (300 and 100 for large
N). Both have the same mean, which is checked first. Fails when `estimate` takes more than 2 % more
over an array or a vector. The other kinds: vector instructions, over densities side by side and
over batches of samples, beside the same loop by hand; in the last column, with AVX2.

Writes the table in docs/mis-methods.md.
"""

import math
import subprocess
import tempfile

from measuring import Table, in_parallel, instructions_between, publish

KINDS = {
    "static": "`std::array`, logistic",
    "dynamic": "`std::vector`, logistic",
    "side-by-side": "`LocationScaleSet<Logistic>`",
    "batches": "the same, `estimate_in_batches`",
    "cauchy": "`std::vector`, Cauchy (no call in a density)",
    "cauchy-side-by-side": "`LocationScaleSet<Cauchy>`",
    "cauchy-batches": "`std::vector`, Cauchy, `estimate_in_batches`",
}
JUDGED, LIMIT = ("static", "dynamic"), 1.02
SIZES = (1, 2, 4, 8, 16, 64)
DOCUMENT = "docs/mis-methods.md"


def add_options(parser):
    parser.add_argument("--compiler", default="g++", help="with another than g++ the table stays out of the document")
    parser.add_argument("--sizes", nargs="+", type=int, choices=SIZES, default=SIZES, help="numbers of proposals; the same for some of them")


def ratio(case):
    """`estimate` over the loop by hand: instructions a round."""
    program, kind, n = case
    command = lambda way, rounds: [program, way, kind, str(n), str(rounds)]
    said = [subprocess.run(command(way, 500), check=True, capture_output=True, text=True).stdout.split() for way in ("hand", "library")]
    if not (float(said[0][0]) > 0 and math.isclose(float(said[0][0]), float(said[1][0]), rel_tol=1e-9) and said[0][2] == said[1][2] == "0"):
        raise SystemExit(f"own_loop: the two means of {kind} {n} differ")
    few = 100 if n > 8 else 1000
    hand, library = (instructions_between(lambda rounds, way=way: command(way, rounds), few, 3 * few) for way in ("hand", "library"))
    return library / hand


def run(options):
    status = 0
    with tempfile.TemporaryDirectory() as folder:
        programs = {}
        for level in ("x86-64", "x86-64-v3"):
            programs[level] = f"{folder}/own_loop-{level}"
            subprocess.run([options.compiler, "-std=c++20", "-O3", "-DNDEBUG", "-ffp-contract=off", f"-march={level}", "-I", "include", "-I", "bench",
                            "bench/own_loop/main.cpp", "-o", programs[level]], check=True)
        columns = [(programs["x86-64"], n) for n in options.sizes] + [(programs["x86-64-v3"], options.sizes[-1])]
        table = Table("proposals", *(f"N = {n}" for n in options.sizes), f"N = {options.sizes[-1]}, AVX2", numbers_from=1)
        for kind, label in KINDS.items():
            ratios = [value for _, value in in_parallel(ratio, [(program, kind, n) for program, n in columns])]
            table.add(label, *(f"{value:.3f}" for value in ratios))
            status |= kind in JUDGED and max(ratios) > LIMIT
    publish(options, table, DOCUMENT if options.compiler == "g++" and options.sizes == SIZES else None)
    return status
