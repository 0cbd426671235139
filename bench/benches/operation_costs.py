"""Fits processor time to counted operations over scenes and integrators that do them in different
proportions.

Relative least squares with coefficients that are not negative, by coordinate descent. Prints each
operation's cost as a multiple of a ray's, beside the constant in the source (the struct of
operation costs, which choices by cost use), and how far the fit is from the times it was made of.
"""

import math
import pathlib
import re
import statistics

from measuring import FOREIGN, FOURTEEN, render

PROGRAM = "gmis-render"
OPTIONS = {"scenes": FOURTEEN | FOREIGN}
# Few and many light trees, connections and photons; merging with global and with local counts, as
# `auto` has it.
RUNS = [["pt"], ["lt"], ["ppm"], ["ppm", "--light-paths", "0.25"], ["bpt", "--connections", "1"],
        ["bpt", "--connections", "2", "--light-paths", "0.25"], ["vcm", "--connections", "1"], ["vcm", "--connections", "4"],
        ["vcm", "--connections", "1", "--radius", "1.3", "--light-paths", "0.25"]]
RUNS += [["gmis", "--split", "local", "--connections", connections, "--radius", radius, "--light-paths", light_paths]
         for connections, radius, light_paths in (("1", "1.6", "1"), ("1", "4.8", "0.25"), ("2", "3.2", "0.5"), ("1", "3.2", "1"))]
# The operation, and the counter of how often it was done.
OPERATIONS = {
    "ray": lambda c: c["rays"],
    "shadow_ray": lambda c: c["shadow_rays"],
    "connection": lambda c: c["connections"],
    "merge_query": lambda c: c["merge_queries"],
    "merge": lambda c: c["merges"],
    "photon_stored": lambda c: c["photons_stored"],
    "projection": lambda c: c["projections"],
}


def measure(options, scene, run):
    facts = render(options, scene, "--size 128x128 --time 0.4 --integrator", run)
    return facts["seconds"]["cpu"], [count(facts["counts"]) for count in OPERATIONS.values()]


def fit(rows):
    """Minimises Σ (Σ x_j n_j / t − 1)² over x ≥ 0."""
    scaled = [[n / time for n in counts] for time, counts in rows]
    x = [0.0] * len(OPERATIONS)
    for _ in range(20000):
        for j in range(len(x)):
            square = sum(row[j] ** 2 for row in scaled)
            if square == 0:
                continue
            rest = sum(row[j] * (1 - sum(a * b for k, (a, b) in enumerate(zip(x, row)) if k != j)) for row in scaled)
            x[j] = max(0.0, rest / square)
    errors = [sum(a * b for a, b in zip(x, row)) - 1 for row in scaled]
    return x, errors


def run(options):
    source = next(pathlib.Path("include/gmis").rglob("operation_costs.hpp")).read_text()
    of_scene = {name: [measure(options, name, way) for way in RUNS] for name in options.scenes}
    rows = [row for rows_here in of_scene.values() for row in rows_here]
    x, errors = fit(rows)
    print(f"{'operation':14} {'here':>6} {'source':>7}")
    constants = [float(re.search(rf"double {name} = ([0-9.]+);", source).group(1)) for name in OPERATIONS]
    for name, cost, constant in zip(OPERATIONS, x, constants):
        print(f"{name:14} {cost / x[0]:6.2f} {constant:7.2f}")
    print(f"a ray takes {1e9 * x[0]:.0f} ns; the fit is off by {100 * (sum(e * e for e in errors) / len(errors)) ** 0.5:.0f} % "
          f"(root mean square), at most {100 * max(map(abs, errors)):.0f} %, over {len(rows)} runs")
    # A choice compares costs of different counts in one scene: how far these are from being in
    # proportion to their times.
    spreads = [statistics.pstdev(math.log(time / sum(c * n for c, n in zip(constants, counts))) for time, counts in rows_here)
               for rows_here in of_scene.values()]
    print(f"within a scene, costs by the source are off by {100 * statistics.fmean(spreads):.0f} % (root mean square, mean of scenes)")

