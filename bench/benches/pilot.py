"""The cost of a pilot, with all that is learned before it: its processor time over that of the
iterations of the run.

Every scene is rendered by `auto` for 8, 16 and 64 iterations, and for MORE iterations beyond, with
the choice of the shorter run (--expected-iterations). Two lengths tell what an iteration takes, and
what a run takes besides. Without statistics and log no error is estimated. What path tracing takes
besides its iterations, which is to read the scene and to write the picture, is subtracted. Runs
take turns, and the least of several counts.

Writes the table in docs/effects.md.
"""

import statistics

from measuring import ALL, FOREIGN, FOURTEEN, Table, processor_cost, publish

PROGRAM = "gmis-render"
OPTIONS = {"runs": 3, "size": "128x128", "scenes": FOURTEEN | FOREIGN}
DOCUMENT = "docs/effects.md"
LENGTHS = (8, 16, 64)
MORE = 64


def run(options):
    table = Table("", "an iteration, ms", *(cell for n in LENGTHS for cell in (f"pilot of {n}, ms", "of the iterations")))
    shares = {n: [] for n in LENGTHS}
    for name in options.scenes:
        kinds = {"pt": (8, ["pt"])} | {n: (n, ["auto", "--expected-iterations", str(n)]) for n in LENGTHS}
        seconds = {}
        for _ in range(options.runs):
            for kind, (length, words) in kinds.items():
                for n in (length, length + MORE):
                    command = [options.program, str(ALL[name]), "--threads", "1", "--quiet", "--size", options.size, "--iterations", str(n),
                               "--out", str(options.out / "picture.pfm"), "--integrator", *words]
                    seconds.setdefault((kind, n), []).append(processor_cost(command)[0])
        one, besides = {}, {}
        for kind, (length, _) in kinds.items():
            short, long = (min(seconds[kind, n]) for n in (length, length + MORE))
            one[kind] = (long - short) / MORE
            besides[kind] = short - length * one[kind]
        cells = [name, f"{1000 * one[LENGTHS[-1]]:.1f}"]
        for n in LENGTHS:
            pilot = besides[n] - besides["pt"]
            shares[n].append(pilot / (n * one[n]))
            cells += [f"{1000 * pilot:.1f}", f"{100 * shares[n][-1]:.1f} %"]
        table.add(*cells)
    table.add("mean", "", *(cell for n in LENGTHS for cell in ("", f"{100 * statistics.fmean(shares[n]):.1f} %")))
    table.note(f"{options.size} pixels, the least of {options.runs} runs.")
    publish(options, table, DOCUMENT)
