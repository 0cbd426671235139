"""What a pilot costs: its processor time over that of the iterations of the run.

Every scene is rendered by `auto` with 8, 16 and 64 iterations, in turns. The processor time after two iterations, less that of two such
as come later, is the pilot's: with it come the first numbers of light vertices, cold caches and whatever else a run begins with. The least
of several runs counts.

Writes out/pilot/table.md and, when all scenes took part, the table in docs/effects.md.
"""

import argparse
import csv
import pathlib
import statistics
import subprocess

from measuring import FOREIGN, FOURTEEN, write_into

DOCUMENT = pathlib.Path("docs/effects.md")
BEGIN, END = "<!-- pilot: written by ./run bench pilot -->", "<!-- end of pilot -->"
LENGTHS = (8, 16, 64)
SCENES = FOURTEEN | FOREIGN


def seconds(options, name, iterations):
    """Processor seconds of the run's beginning that later iterations do not take, and of one of those."""
    log = options.out / "log.csv"
    subprocess.run([options.renderer, SCENES[name], "--size", options.size, "--iterations", str(iterations), "--threads", "1", "--quiet", "--log",
                    str(log), "--out", str(options.out / "picture.pfm")], check=True, stdin=subprocess.DEVNULL)
    with log.open() as file:
        after = {int(row["iteration"]): float(row["cpu_seconds"]) for row in csv.DictReader(file)}
    later = (after[iterations] - after[2]) / (iterations - 2)
    return after[2] - 2 * later, later


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renderer", required=True)
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--runs", type=int, default=3, help="of each length")
    parser.add_argument("--scenes", nargs="*", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/pilot"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    lines = ["| | an iteration, ms | " + " | ".join(f"pilot of {n}, ms | of the iterations" for n in LENGTHS) + " |",
             "|" + " --- |" * (2 + 2 * len(LENGTHS))]
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
        lines.append(f"| {' | '.join(cells)} |")
        print(lines[-1], flush=True)
    lines.append("| mean | | " + " | ".join(f" | {100 * statistics.fmean(shares[n]):.1f} %" for n in LENGTHS) + " |")
    table = "\n".join(lines) + f"\n\n{options.size} pixels, the least of {options.runs} runs.\n"
    (options.out / "table.md").write_text(table)
    if options.scenes == list(SCENES):
        write_into(DOCUMENT, BEGIN, END, table)
    print(lines[-1])


main()
