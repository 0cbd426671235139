"""Instructions an iteration of the engine as path tracer (pt) beside those of a path tracer written
by hand over the same scene.

The one by hand is bench/hand/path_tracer.hpp. Counted by callgrind: the difference between runs of
3 and of 1 iterations. Both make the same pictures but for rounding, which is checked first.

Writes the table in docs/effects.md.
"""

import math
import subprocess

from measuring import Table, compiler_name, instructions_between, publish

PROGRAM = "hand_path_tracer"
DOCUMENT = "docs/effects.md"
SCENES = {"box": "area light, mirror and glass", "glossy": "area light, glossy", "sky": "sky", "point": "point light"}


def run(options):
    table = Table("scene", "by hand, M instructions", "`pt`", "ratio", numbers_from=1)
    for scene, name in SCENES.items():
        command = lambda way, iterations: [options.program, way, scene, str(iterations)]
        sums = [float(subprocess.run(command(way, 4), check=True, capture_output=True, text=True).stdout) for way in ("hand", "pt")]
        if not (sums[0] > 0 and math.isclose(*sums, rel_tol=1e-6)):
            raise SystemExit(f"hand_path_tracer: the two pictures of {scene} differ: {sums}")
        hand, engine = (instructions_between(lambda n, way=way: command(way, n), 1, 3) for way in ("hand", "pt"))
        table.add(name, f"{hand / 1e6:.2f}", f"{engine / 1e6:.2f}", f"{engine / hand:.3f}")
    table.note(f"64x64 pixels, 8 segments, {compiler_name()}, x86-64-v3.")
    publish(options, table, DOCUMENT)
