"""The README's strip of pictures at equal time, with their errors (bench/strip.py says how, and
`-- --help` its options)."""

import argparse
import subprocess
import sys

from measuring import build

PROGRAM = "gmis-render"


def add_options(parser):
    parser.add_argument("arguments", nargs=argparse.REMAINDER)


def run(options):
    first_render = build("first_render", "examples")
    words = [word for word in options.arguments if word != "--"]
    command = [sys.executable, "bench/strip.py", options.program, "--first-render", first_render, *words]
    return subprocess.run(command, check=False).returncode
