"""The mean of the picture that --integrator auto makes, over that of an unbiased one.

Every scene is rendered with several seeds by auto, and by bidirectional path tracing, which merges nothing, until its mean is
known to a fifth of a per cent or it has had its time. Lights are chosen for their receiver in both: which light is sampled has no
part in this. The standard error of the ratio is from the spread between the seeds of both. A scene passes when auto's mean is within
two standard errors or half a per cent of the other; where the standard error itself is above half a per cent the table says so,
for then passing means little.

Writes out/energy/table.md and, when all scenes took part, the table in docs/effects.md.
"""

import argparse
import math
import pathlib
import statistics
import subprocess
import sys

from measuring import ALL, read_pfm, write_into

DOCUMENT = pathlib.Path("docs/effects.md")
BEGIN, END = "<!-- energy: written by ./run bench energy -->", "<!-- end of energy -->"
ENOUGH = 0.002  # relative standard error at which the unbiased mean is known
LIMIT = 0.005


def render(options, scene, integrator, iterations, seed):
    picture = options.out / "picture.pfm"
    subprocess.run([options.renderer, scene, "--integrator", integrator, "--lights", "receiver", "--size", options.size, "--quiet",
                    "--seed", str(seed), "--iterations", str(iterations), "--out", str(picture)],
                   check=True, stdin=subprocess.DEVNULL)
    values = read_pfm(picture)
    return math.fsum(values) / len(values)


def mean_and_error(values):
    return statistics.fmean(values), statistics.stdev(values) / math.sqrt(len(values))


def measure(options, name):
    scene = ALL[name]
    ours = mean_and_error([render(options, scene, "auto", options.iterations, seed) for seed in range(1, options.seeds + 1)])
    true = []
    while len(true) < options.most_reference_seeds:
        true += [render(options, scene, "bpt", options.iterations, 1000 + len(true) + k) for k in range(options.seeds)]
        mean, error = mean_and_error(true)
        if error < ENOUGH * mean:
            break
    return ours[0] / mean - 1, math.hypot(ours[1] / ours[0], error / mean)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renderer", required=True)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--most-reference-seeds", type=int, default=24)
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--iterations", type=int, default=64)
    parser.add_argument("--scenes", nargs="*", default=list(ALL), choices=list(ALL))
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/energy"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    lines = ["| | auto's mean over the true one, less 1 | its standard error | within |", "| --- | --- | --- | --- |"]
    passed = vague = 0
    for name in options.scenes:
        off, error = measure(options, name)
        passes = abs(off) <= max(2 * error, LIMIT)
        passed += passes
        vague += error > LIMIT
        said = "no" if not passes else "yes" if error <= LIMIT else "too noisy to say"
        lines.append(f"| {name} | {100 * off:+.2f} % | {100 * error:.2f} % | {said} |")
        print(lines[-1], flush=True)
    table = "\n".join(lines) + (
        f"\n\n{options.size} pixels, {options.iterations} iterations, {options.seeds} seeds of auto. Within two standard errors or "
        f"{100 * LIMIT:g} %: {passed} of {len(options.scenes)} scenes; in {vague} of them the standard error is above {100 * LIMIT:g} %.\n")
    (options.out / "table.md").write_text(table)
    if options.scenes == list(ALL):
        write_into(DOCUMENT, BEGIN, END, table)
    print(table.rsplit("\n\n", 1)[1])
    sys.exit(passed < len(options.scenes))


main()
