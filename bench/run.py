#!/usr/bin/env python3
"""Runs benchmarks: `./run bench NAME [option ...]`; `./run bench` runs all that need no argument,
`./run bench --list` lists them.

A benchmark is a module of benches/, and that is its registration. It has a docstring, which is its
help, and

    run(options)          measures and prints; returns an exit status, or nothing

and may have

    PROGRAM = "NAME"      a program of the preset `bench`: built first; its path is options.program
    OPTIONS = {…}         the common options that it takes, with their values if none are given
    add_options(parser)   options of its own
    BY_ITSELF = False     it needs an argument or hours: run by name only

Tables go to out/NAME/table.md, and those of a run with default options into the document that has
marks for them (measuring.publish).
"""

import argparse
import importlib
import os
import pathlib
import sys

import figures
from measuring import build

PROJECT = pathlib.Path(__file__).resolve().parents[1]

COMMON = {
    "seeds": {"type": int, "help": "runs of each cell, with other random numbers"},
    "runs": {"type": int, "help": "runs of each cell; the fastest counts"},
    "size": {"help": "of the picture in pixels, WIDTHxHEIGHT"},
    "iterations": {"type": int, "help": "of a run"},
    "scenes": {"nargs": "+", "help": "some of them"},
}


def names():
    return sorted(file.stem for file in (PROJECT / "bench/benches").glob("*.py"))


def load(name):
    return importlib.import_module(f"benches.{name}")


def summary(module):
    return module.__doc__.strip().split("\n\n")[0].replace("\n", " ")


def parser_of(name, module):
    parser = argparse.ArgumentParser(prog=f"./run bench {name}", description=module.__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    for option, value in getattr(module, "OPTIONS", {}).items():
        scenes = {"choices": list(value)} if option == "scenes" and isinstance(value, dict) else {}
        default = list(value) if option == "scenes" else value
        shown = "" if option == "scenes" else f" ({value})"
        parser.add_argument(f"--{option}", default=default, **COMMON[option] | scenes | {"help": COMMON[option]["help"] + shown})
    if hasattr(module, "PROGRAM"):
        parser.add_argument("--program", help=f"take this {module.PROGRAM} in place of one that is built first")
    if hasattr(module, "add_options"):
        module.add_options(parser)
    return parser


def bench(name, arguments):
    module = load(name)
    parser = parser_of(name, module)
    options = parser.parse_args(arguments)
    options.name = name
    options.out = pathlib.Path("out") / name
    options.out.mkdir(parents=True, exist_ok=True)
    # Other tables stay out of the documents: their command would not say how they were made.
    options.is_whole = all(getattr(options, action.dest) == action.default for action in parser._actions
                           if action.option_strings and action.default is not argparse.SUPPRESS)
    if hasattr(module, "PROGRAM") and not options.program:
        with figures.alone_with(PROJECT / "CMakePresets.json"):  # another benchmark may begin meanwhile
            options.program = build(module.PROGRAM)
    options.digests = figures.digests()  # of the sources that are measured, whatever is edited meanwhile
    return module.run(options) or 0


def main():
    os.chdir(PROJECT)
    name, *arguments = sys.argv[1:] or [""]
    if name in ("--list", "--help", "-h"):
        print("\n".join(f"{n:18} {summary(load(n))}" for n in names()))
        return 0
    if name:
        if name not in names():
            print(f"bench: no {name}; there are: {' '.join(names())}", file=sys.stderr)
            return 2
        return bench(name, arguments)
    status = 0
    for name in (n for n in names() if getattr(load(n), "BY_ITSELF", True)):
        print(f"== {name}", file=sys.stderr, flush=True)
        status = max(status, bench(name, []))
    return status


if __name__ == "__main__":
    sys.exit(main())
