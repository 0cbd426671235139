"""The cost of accuracy: time and variance of every scheme, side by side, with a loop by hand beside
the library (bench/schemes.cpp says how, and `-- --help` its options)."""

import argparse
import subprocess

PROGRAM = "schemes"


def add_options(parser):
    parser.add_argument("arguments", nargs=argparse.REMAINDER)


def run(options):
    return subprocess.run([options.program, *(word for word in options.arguments if word != "--")], check=False).returncode
