"""The cost of a pilot: its processor time over that of the iterations of the run.

Every scene is rendered by `auto` with 8, 16 and 64 iterations, in turns. The processor time after
four iterations, the second point of the log, less that of four such as come later, is the pilot's:
with it come the first numbers of light vertices, cold caches and whatever else a run begins with.
Estimates of the error, which the log asks for, are in the times of iterations. The least of several
runs counts.

Writes the table in docs/effects.md.
"""

import csv
import statistics

from measuring import FOREIGN, FOURTEEN, Table, publish, render

PROGRAM = "gmis-render"
OPTIONS = {"runs": 3, "size": "128x128", "scenes": FOURTEEN | FOREIGN}
DOCUMENT = "docs/effects.md"
LENGTHS = (8, 16, 64)
FIRST = 4


def seconds(options, name, iterations):
    """Processor seconds of the run's beginning that later iterations do not take, and of one of
    those."""
    log = options.out / "log.csv"
    render(options, name, f"--size {options.size} --iterations {iterations} --log {log}")
    with log.open() as file:
        after = {int(row["iteration"]): float(row["cpu_seconds"]) for row in csv.DictReader(file)}
    later = (after[iterations] - after[FIRST]) / (iterations - FIRST)
    return after[FIRST] - FIRST * later, later


def run(options):
    table = Table("", "an iteration, ms", *(cell for n in LENGTHS for cell in (f"pilot of {n}, ms", "of the iterations")))
    shares = {n: [] for n in LENGTHS}
    for name in options.scenes:
        runs = {n: [] for n in LENGTHS}
        for _ in range(options.runs):
            for n in LENGTHS:
                runs[n].append(seconds(options, name, n))
        cells = [name, f"{1000 * min(later for _, later in runs[LENGTHS[-1]]):.1f}"]
        for n in LENGTHS:
            pilot, later = (min(column) for column in zip(*runs[n]))
            shares[n].append(pilot / (n * later))
            cells += [f"{1000 * pilot:.1f}", f"{100 * shares[n][-1]:.1f} %"]
        table.add(*cells)
    table.add("mean", "", *(cell for n in LENGTHS for cell in ("", f"{100 * statistics.fmean(shares[n]):.1f} %")))
    table.note(f"{options.size} pixels, the least of {options.runs} runs.")
    publish(options, table, DOCUMENT)

