"""Lights chosen for their receiver beside lights chosen by power: variance at equal samples, and
instructions of a next event.

A next event is its receiver by a ray, the choice, a point on the light and a shadow ray, among 10,
1000 and 100000 lamps, counted by callgrind in the loop alone. Fails when one among 100000 lamps
takes more than 4 times the instructions of one among 10.
"""

import subprocess

from measuring import instructions_of

PROGRAM = "light_choice"
EVENTS, LIMIT = 20000, 4


def add_options(parser):
    parser.add_argument("what", nargs="?", choices=("both", "gains", "instructions"), default="both")


def run(options):
    if options.what != "instructions":
        subprocess.run([options.program], check=True)
    if options.what == "gains":
        return 0
    per_event = lambda lights, selection: instructions_of([options.program, "loop", lights, selection, EVENTS], "--toggle-collect=*next_events*") // EVENTS
    print(f"{'lamps':10} {'by power':>12} {'by receiver':>12}   instructions of a next event")
    by_receiver = {}
    for lights in (10, 1000, 100000):
        by_receiver[lights] = per_event(lights, "by_receiver")
        print(f"{lights:<10} {per_event(lights, 'by_power'):12} {by_receiver[lights]:12}", flush=True)
    growth = by_receiver[100000] / by_receiver[10]
    print(f"100000 lamps over 10: {growth:.2f}")
    return growth > LIMIT
