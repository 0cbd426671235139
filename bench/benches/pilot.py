"""The cost of a pilot, with all that is learned before it: its processor time over that of the
iterations of the run.

Renders every scene by `auto` for 1, 3 and N iterations, with the choice of a run of N
(--expected-iterations). No statistics and no log are written, so that no error is estimated. An
iteration takes half the difference between the runs of 3 and of 1. The rest of the run of 1 is the
pilot's, less the same rest of path tracing, which has no pilot: it reads the scene and writes the
picture. Runs take turns, and the least of several counts.

Writes the table in docs/effects.md.
"""

import statistics

from measuring import ALL, FOREIGN, FOURTEEN, Table, processor_cost, publish

PROGRAM = "gmis-render"
OPTIONS = {"runs": 5, "size": "128x128", "scenes": FOURTEEN | FOREIGN}
DOCUMENT = "docs/effects.md"
LENGTHS = (8, 16, 64)


def run(options):
    table = Table("", "an iteration, ms", *(cell for n in LENGTHS for cell in (f"pilot of {n}, ms", "of the iterations")))
    shares = {n: [] for n in LENGTHS}
    for name in options.scenes:
        kinds = {"pt": (3, ["pt"])} | {n: (n, ["auto", "--expected-iterations", str(n)]) for n in LENGTHS}
        costs = {}
        for _ in range(options.runs):
            for kind, (length, words) in kinds.items():
                for n in {1, 3, length}:
                    command = [options.program, str(ALL[name]), "--threads", "1", "--quiet", "--size", options.size, "--iterations", str(n),
                               "--out", str(options.out / "picture.pfm"), "--integrator", *words]
                    costs.setdefault((kind, n), []).append(processor_cost(command)[0])
        least = {case: min(seconds) for case, seconds in costs.items()}
        besides = {kind: least[kind, 1] - (least[kind, 3] - least[kind, 1]) / 2 for kind in kinds}
        iterations = {n: least[n, n] - besides[n] for n in LENGTHS}
        cells = [name, f"{1000 * iterations[LENGTHS[-1]] / LENGTHS[-1]:.1f}"]
        for n in LENGTHS:
            pilot = besides[n] - besides["pt"]
            shares[n].append(pilot / iterations[n])
            cells += [f"{1000 * pilot:.1f}", f"{100 * shares[n][-1]:.1f} %"]
        table.add(*cells)
    table.add("mean", "", *(cell for n in LENGTHS for cell in ("", f"{100 * statistics.fmean(shares[n]):.1f} %")))
    table.note(f"{options.size} pixels, the least of {options.runs} runs.")
    publish(options, table, DOCUMENT)
