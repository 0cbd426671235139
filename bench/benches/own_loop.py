"""Instructions a round of N3 by `estimate` and by a loop by hand with the same checks and sums
(bench/own_loop/loops.hpp).

Counted by callgrind: the difference between runs of 3000 and of 1000 rounds (300 and 100 for large
N). Both have the same mean, which is checked first. Fails when `estimate` takes more than 2 % more.
The last kinds: vector instructions, over densities side by side and over batches of samples, beside
the same loop by hand.
"""

import math
import subprocess
import tempfile

from measuring import instructions_between

KINDS = ("static", "dynamic", "cauchy", "cauchy-side-by-side", "cauchy-batches", "side-by-side", "batches")
JUDGED, LIMIT = ("static", "dynamic"), 1.02


def add_options(parser):
    parser.add_argument("--compiler", default="g++")
    parser.add_argument("--flags", default="", help="for the compiler, such as --flags=-march=x86-64-v3")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--sizes", nargs="+", type=int, default=(1, 2, 4, 8, 16, 64), help="numbers of proposals")


def run(options):
    status = 0
    with tempfile.TemporaryDirectory() as folder:
        program = f"{folder}/own_loop"
        subprocess.run([options.compiler, "-std=c++20", "-O3", "-DNDEBUG", "-ffp-contract=off", *options.flags.split(), "-I", "include", "-I", "bench",
                        "bench/own_loop/main.cpp", "-o", program], check=True)
        print(f"{'proposals':19} {'N':>4} {'by hand':>14} {'estimate':>14} {'ratio':>7}   ({options.compiler}, instructions a round)")
        for kind in options.kinds:
            for n in options.sizes:
                command = lambda way, rounds: [program, way, kind, str(n), str(rounds)]
                said = [subprocess.run(command(way, 500), check=True, capture_output=True, text=True).stdout.split() for way in ("hand", "library")]
                if not (float(said[0][0]) > 0 and math.isclose(float(said[0][0]), float(said[1][0]), rel_tol=1e-9) and said[0][2] == said[1][2] == "0"):
                    raise SystemExit(f"own_loop: the two means of {kind} {n} differ")
                few = 100 if n > 8 else 1000
                hand, library = (instructions_between(lambda rounds, way=way: command(way, rounds), few, 3 * few) for way in ("hand", "library"))
                print(f"{kind:19} {n:4} {hand:14.1f} {library:14.1f} {library / hand:7.4f}", flush=True)
                status |= kind in JUDGED and library > LIMIT * hand
    return status
