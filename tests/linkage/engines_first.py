#!/usr/bin/env python3
"""A program keeps one copy of an inline function that several files have compiled. This checks that
for every function that the engines' objects define, the program has a copy from these objects: one
with the size of a copy there."""

import collections
import subprocess
import sys


def functions(nm, file):
    """The size of every weak function (they are the ones that several files can define)."""
    lines = subprocess.run([nm, "--defined-only", "--print-size", file], check=True, capture_output=True, text=True)
    for line in lines.stdout.splitlines():
        words = line.split()
        if len(words) == 4 and words[2] == "W":
            yield words[3], int(words[1], 16)


def main():
    nm, program, *objects = sys.argv[1:]
    optimised = collections.defaultdict(set)
    for file in objects:
        for name, size in functions(nm, file):
            optimised[name].add(size)
    in_program = dict(functions(nm, program))
    checked = [name for name in optimised if name in in_program]
    others = [name for name in checked if in_program[name] not in optimised[name]]
    print(f"{len(checked)} functions of the engines are in the program; {len(others)} of them come from other files")
    for name in others:
        print(f"  {name}: {in_program[name]} bytes, optimised {sorted(optimised[name])}")
    return 1 if others or len(checked) < 50 else 0


sys.exit(main())
