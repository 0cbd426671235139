"""Whether MIS compensation of a sky pays (bench/sky.cpp): mean squared error of path tracing by the
fraction c of compensation, at equal paths.

Writes the table in docs/mis-methods.md.
"""

import subprocess

from measuring import Table, publish

PROGRAM = "sky"
DOCUMENT = "docs/mis-methods.md"


def run(options):
    said = subprocess.run([options.program], check=True, capture_output=True, text=True).stdout
    table = Table("sky", "depth", "c = 1", "c = 0.75", "c = 0.5", "error of c = 1 over c = 0.5", numbers_from=1)
    for sky, depth, *rest in map(str.split, said.splitlines()):
        errors, spreads = list(map(float, rest[0::2])), list(map(float, rest[1::2]))
        table.add(sky, depth, *(f"{error:.3g} ± {float(f'{spread:.1g}'):g}" for error, spread in zip(errors, spreads)), f"{errors[0] / errors[-1]:.2f}")
    table.note("Mean squared error × 10⁴ at 4 paths a pixel, 48 pixels wide, ± the standard error of 24 runs.")
    publish(options, table, DOCUMENT)
