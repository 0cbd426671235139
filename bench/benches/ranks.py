"""One run over ranks of MPI with one thread each: wall time by the number of ranks, how much of it
ranks wait for each other, and the bytes and seconds of their exchanges.

In turns, so that all numbers of ranks have the same machine; the median counts. The pictures must
have the same bits. With fewer processors than ranks the times say nothing. Rank 0 is measured; a
barrier before each exchange keeps waiting and exchange apart.

Writes the table in docs/many-machines.md.
"""

import json
import os
import pathlib
import statistics
import subprocess

from measuring import ALL, Table, publish

PROGRAM = "gmis-render-mpi"
OPTIONS = {"runs": 3, "size": "512x512", "iterations": 24}
DOCUMENT = "docs/many-machines.md"


def add_options(parser):
    parser.add_argument("--ranks", nargs="+", type=int, default=[1, 2], help="numbers of ranks (1 2)")
    parser.add_argument("--scene", default="cornell", choices=list(ALL), help="(cornell)")


def run_once(options, integrator, ranks):
    """Wall seconds, peak megabytes of a rank, and the traffic of a run; its picture's bytes."""
    stats, picture = options.out / "stats.json", options.out / "picture.pfm"
    environment = os.environ | {"GMIS_MPI_TIMES": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    said = subprocess.run(["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), options.program, ALL[options.scene], "--integrator", integrator, "--size", options.size,
                           "--iterations", str(options.iterations), "--threads", "1", "--quiet", "--stats", str(stats), "--out", str(picture)],
                          env=environment, capture_output=True, text=True, check=True, stdin=subprocess.DEVNULL).stderr
    facts = json.loads(stats.read_text(encoding="utf-8"))
    traffic = json.loads(said[said.index("{"):said.index("}") + 1])
    return {"wall": facts["seconds"]["wall"], "memory": facts["memory"]["peak_bytes"] / 2**20, **traffic}, picture.read_bytes()


def run(options):
    options.program = str(pathlib.Path(options.program).resolve())
    table = Table("integrator", "ranks", "wall seconds", "speed-up", "seconds waiting", "MB exchanged", "seconds exchanging",
                  "MB gathered", "seconds gathering", "MB of rank 0", numbers_from=1)
    for integrator in ("vcm", "auto"):
        runs = {ranks: [] for ranks in options.ranks}
        pictures = set()
        for _ in range(options.runs):
            for ranks in options.ranks:
                facts, picture = run_once(options, integrator, ranks)
                runs[ranks].append(facts)
                pictures.add(picture)
        if len(pictures) != 1:
            raise SystemExit("bench: the pictures differ")
        alone = [facts["wall"] for facts in runs[options.ranks[0]]]
        for ranks, all_facts in runs.items():
            median = {key: statistics.median(facts[key] for facts in all_facts) for key in all_facts[0]}
            ratio = statistics.median(first / facts["wall"] for first, facts in zip(alone, all_facts))
            table.add(integrator, ranks, f"{median['wall']:.2f}", f"{ratio:.2f}", f"{median['waiting']:.2f}", f"{median['exchange_bytes'] / 1e6:.0f}",
                      f"{median['exchange_seconds']:.2f}", f"{median['gather_bytes'] / 1e6:.0f}", f"{median['gather_seconds']:.2f}",
                      f"{median['memory']:.0f}")
    table.note(f"`{options.scene}`, {options.size} pixels, {options.iterations} iterations, one thread a rank, {os.cpu_count()} processors; "
               f"medians of {options.runs} runs in turns; all pictures of an integrator have the same bits.")
    publish(options, table, DOCUMENT)
