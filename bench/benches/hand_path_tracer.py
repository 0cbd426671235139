"""Instructions an iteration of the engine as path tracer (pt) beside those of a path tracer written
by hand over the same scene.

The one by hand is bench/hand/path_tracer.hpp. Counted by callgrind: the difference between runs of
3 and of 1 iterations. Both make the same pictures but for rounding, which is checked first. Fails
when the engine takes more than 2 % more.
"""

import math
import subprocess

from measuring import instructions_between

PROGRAM = "hand_path_tracer"
SCENES = ("box", "glossy", "sky", "point")
LIMIT = 1.02


def run(options):
    status = 0
    print(f"{'scene':7} {'by hand, M instr/it.':>20} {'pt, M instr/it.':>20} {'ratio':>7}")
    for scene in SCENES:
        command = lambda way, iterations: [options.program, way, scene, str(iterations)]
        sums = [float(subprocess.run(command(way, 4), check=True, capture_output=True, text=True).stdout) for way in ("hand", "pt")]
        if not (sums[0] > 0 and math.isclose(*sums, rel_tol=1e-6)):
            raise SystemExit(f"hand_path_tracer: the two pictures of {scene} differ: {sums}")
        hand, engine = (instructions_between(lambda n, way=way: command(way, n), 1, 3) for way in ("hand", "pt"))
        print(f"{scene:7} {hand / 1e6:20.2f} {engine / 1e6:20.2f} {engine / hand:7.4f}", flush=True)
        status |= engine > LIMIT * hand
    return status
