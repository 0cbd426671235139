"""The cost of a pilot: its processor time over that of the iterations of the run.

Every scene is rendered by `auto` with 8, 16 and 64 iterations, in turns. The log has the processor
time after 4, 6, 8, 12, 16 … iterations, with an estimate of the error in each. Between two points
the least of several runs counts; what an estimate takes is told by intervals of unequal length in
the longest run. The pilot has the time after four iterations that four iterations and an estimate
do not explain: with it come the first numbers of light vertices, cold caches and whatever else a
run begins with.

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


def times_of(options, name, iterations):
    """Processor seconds of a run up to its point after FIRST iterations, and from each point to the
    next, by the iteration that it ends with."""
    log = options.out / "log.csv"
    render(options, name, f"--size {options.size} --iterations {iterations} --log {log}")
    with log.open() as file:
        points = [(int(row["iteration"]), float(row["cpu_seconds"])) for row in csv.DictReader(file)]
    points = [point for point in points if point[0] >= FIRST]
    return {points[0][0]: points[0][1]} | {n: seconds - before for (_, before), (n, seconds) in zip(points, points[1:])}


def line_through(points):
    """Slope and height of the line of least squares."""
    xs, ys = zip(*points)
    x, y = statistics.fmean(xs), statistics.fmean(ys)
    slope = sum((a - x) * (b - y) for a, b in points) / sum((a - x) ** 2 for a in xs)
    return slope, y - slope * x


def lengths(least):
    """(iterations, seconds) of each interval after the first point."""
    ends = sorted(least)
    return [(end - begin, least[end]) for begin, end in zip(ends, ends[1:])]


def run(options):
    table = Table("", "an iteration, ms", *(cell for n in LENGTHS for cell in (f"pilot of {n}, ms", "of the iterations")))
    shares = {n: [] for n in LENGTHS}
    for name in options.scenes:
        runs = {n: [] for n in LENGTHS}
        for _ in range(options.runs):
            for n in LENGTHS:
                runs[n].append(times_of(options, name, n))
        least = {n: {end: min(times[end] for times in runs[n]) for end in runs[n][0]} for n in LENGTHS}
        iteration, estimate = line_through(lengths(least[LENGTHS[-1]]))
        cells = [name, f"{1000 * iteration:.1f}"]
        for n in LENGTHS:  # the counts of shorter runs may be others
            intervals = lengths(least[n])
            one = sum(seconds - estimate for _, seconds in intervals) / (n - FIRST)
            pilot = least[n][FIRST] - FIRST * one - estimate
            shares[n].append(pilot / (n * one))
            cells += [f"{1000 * pilot:.1f}", f"{100 * shares[n][-1]:.1f} %"]
        table.add(*cells)
    table.add("mean", "", *(cell for n in LENGTHS for cell in ("", f"{100 * statistics.fmean(shares[n]):.1f} %")))
    table.note(f"{options.size} pixels, the least of {options.runs} runs.")
    publish(options, table, DOCUMENT)
