"""Whether MIS compensation of a sky pays (bench/sky.cpp says how)."""

import subprocess

PROGRAM = "sky"


def run(options):
    return subprocess.run([options.program], check=False).returncode
