"""Lights chosen for their receiver beside lights chosen by power: variance at equal samples, and
instructions of a next event.

The variance is that of an iteration of 32x32 pixels in a town of lamps, by power over that for the
receiver. A next event is its receiver by a ray, the choice, a point on the light and a shadow ray,
counted by callgrind in the loop alone. Fails when one among 100000 lamps takes more than 4 times
the instructions of one among 10.

Writes the table in docs/weights.md.
"""

import subprocess

from measuring import Table, in_parallel, instructions_of, publish

PROGRAM = "light_choice"
DOCUMENT = "docs/weights.md"
EVENTS, LIMIT = 20000, 4


def run(options):
    said = subprocess.run([options.program], check=True, capture_output=True, text=True).stdout
    gains = {int(lamps): rest for lamps, *rest in map(str.split, said.splitlines())}
    count = lambda case: instructions_of([options.program, "loop", *case, EVENTS], "--toggle-collect=*next_events*") // EVENTS
    counts = dict(in_parallel(count, [(lamps, how) for lamps in (10, 1000, 100000) for how in ("by_power", "by_receiver")]))
    table = Table("lamps", "pt", "bpt", "vcm", "instructions by power", "by receiver", numbers_from=0)
    for lamps in sorted({*gains, *(lamps for lamps, _ in counts)}):
        table.add(lamps, *gains.get(lamps, ("",) * 3), *(counts.get((lamps, how), "") for how in ("by_power", "by_receiver")))
    publish(options, table, DOCUMENT)
    return counts[100000, "by_receiver"] > LIMIT * counts[10, "by_receiver"]
