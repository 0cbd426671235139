"""The built-in tree beside Embree 3: five meshes of a hundred thousand to a million triangles, then
of ten times as many (bench/bvh.cpp says how). With arguments: what they ask for alone, without the
documents."""

import argparse
import subprocess
import sys

from measuring import publish

PROGRAM = "bvh"
DOCUMENT = "docs/bvh.md"


def add_options(parser):
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="-- --scale S, --size PIXELS, --rounds N, --threads N, --mesh NAME")


def table_of(options, *arguments):
    lines = []
    with subprocess.Popen([options.program, *arguments], stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            sys.stdout.write(line)
            lines.append(line)
    if process.returncode:
        raise SystemExit(process.returncode)
    return "".join(lines)


def run(options):
    arguments = [word for word in options.arguments if word != "--"]
    if arguments:
        table_of(options, *arguments)
        return
    table, ten_times = table_of(options), table_of(options, "--scale", "10", "--rounds", "2")
    document = DOCUMENT if "over Embree" in table else None
    publish(options, table, document)
    publish(options, ten_times, document, "ten times")
