"""The mean of the picture that --integrator auto makes, over that of an unbiased one.

Every scene is rendered with several seeds by auto, and by bidirectional path tracing, which merges
nothing, until its mean is known to a fifth of a per cent or it has had its time. Where caustics of
point, spot or directional lights are seen in mirrors or through glass, which it cannot make, gmis
with a quarter of its merging radius takes its place. Lights are chosen
for their receiver in both: which light is sampled has no part in this. The standard error of the
ratio is from the spread between the seeds of both. A scene passes when auto's mean is within two
standard errors or half a per cent of the other; where the standard error itself is above half a per
cent the table says so, for then passing means little.

Writes the table in docs/effects.md.
"""

import math
import os
import statistics

from measuring import TWENTY_FOUR, Table, publish, read_pfm, render

PROGRAM = "gmis-render"
OPTIONS = {"seeds": 6, "size": "128x128", "iterations": 48, "scenes": TWENTY_FOUR}
DOCUMENT = "docs/effects.md"
OUT_OF_REACH = ("mixed", "paper4")  # of bidirectional path tracing
ENOUGH = 0.002  # relative standard error at which the unbiased mean is known
LIMIT = 0.005


def mean_of_picture(options, scene, integrator, iterations, seed):
    render(options, scene, f"--integrator {integrator} --lights receiver --size {options.size} --seed {seed} --iterations {iterations}",
           threads=os.cpu_count())
    values = read_pfm(options.out / "picture.pfm")
    return math.fsum(values) / len(values)


def mean_and_error(values):
    return statistics.fmean(values), statistics.stdev(values) / math.sqrt(len(values))


def measure(options, name):
    ours = mean_and_error([mean_of_picture(options, name, "auto", options.iterations, seed) for seed in range(1, options.seeds + 1)])
    true = []
    while len(true) < options.most_reference_seeds:
        true += [mean_of_picture(options, name, "gmis --radius 0.8" if name in OUT_OF_REACH else "bpt", options.iterations, 1000 + len(true) + k) for k in range(options.seeds)]
        mean, error = mean_and_error(true)
        if error < ENOUGH * mean:
            break
    return ours[0] / mean - 1, math.hypot(ours[1] / ours[0], error / mean)


def add_options(parser):
    parser.add_argument("--most-reference-seeds", type=int, default=72)


def run(options):
    table = Table("", "auto's mean over the true one, less 1", "its standard error", "within")
    passed = vague = 0
    for name in options.scenes:
        off, error = measure(options, name)
        passes = abs(off) <= max(2 * error, LIMIT)
        passed += passes
        vague += error > LIMIT
        said = "no" if not passes else "yes" if error <= LIMIT else "too noisy to say"
        table.add(name, f"{100 * off:+.2f} %", f"{100 * error:.2f} %", said)
    table.note(
        f"{options.size} pixels, {options.iterations} iterations, {options.seeds} seeds of auto. Within two standard errors or "
        f"{100 * LIMIT:g} %: {passed} of {len(options.scenes)} scenes; in {vague} of them the standard error is above {100 * LIMIT:g} %.")
    publish(options, table, DOCUMENT)
    return passed < len(options.scenes)

