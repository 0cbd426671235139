#!/usr/bin/env python3
"""Writes all headers of gmis as one file, which needs GLM and the standard library alone.

Usage: amalgamate.py [--root FOLDER] [--out FILE] [HEADER...]

HEADER: what to gather, with all that it includes; by default every header. gmis/mis.hpp gives the
MIS core, gmis/gmis.hpp everything but what nothing else includes (the checks of a scene,
ThreadExecutor). Headers stand in the order in which the compiler would read them. A header of gmis
that is included under a condition is refused: its lines would be lost where the condition does not
hold.
"""
import argparse
import pathlib
import re
import sys

own_include = re.compile(r'\s*#\s*include\s+["<](gmis/[^">]+)[">]')
system_include = re.compile(r"\s*#\s*include\s+(<[^>]+>)")
condition_begins = re.compile(r"\s*#\s*if")
condition_ends = re.compile(r"\s*#\s*endif")


def main():
    parser = argparse.ArgumentParser(description="All headers of gmis as one file.")
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2])
    parser.add_argument("--out", type=pathlib.Path, help="the file to write (default: standard output)")
    parser.add_argument("headers", nargs="*", help="such as gmis/mis.hpp (default: all)")
    options = parser.parse_args()

    include = options.root / "include"
    every = (path.relative_to(include).as_posix() for path in include.rglob("*.hpp"))
    headers = options.headers or sorted(name for name in every if name != "gmis/testing/catch.hpp")  # needs Catch2
    seen, outer, own = set(), set(), []
    for header in headers:
        own += gather(include, header, seen, outer)
    text = "\n".join(head(options.root) + [f"#include {name}" for name in sorted(outer)] + [""] + own) + "\n"
    if options.out:
        options.out.write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)


def head(root):
    version = re.search(r"project\(gmis VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text(encoding="utf-8"))
    if not version:
        sys.exit("amalgamate: CMakeLists.txt states no version")
    licence = (root / "LICENSE").read_text(encoding="utf-8").splitlines()
    return [
        "#pragma once",
        "",
        f"// gmis {version.group(1)}, all headers in one file, made by examples/packaging/amalgamate.py. Do not edit.",
        "//",
        *(("// " + line).rstrip() for line in licence),
        "",
    ]


def gather(include, header, seen, outer):
    """The lines of a header with what it includes in front, or nothing if they stand already. What
    it includes of others goes into `outer`, unless it does so under a condition."""
    if header in seen:
        return []
    path = include / header
    if not path.is_file():
        sys.exit(f"amalgamate: there is no header {header}")
    seen.add(header)
    before, own = [], []
    depth = 0
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if line.strip() == "#pragma once":
            continue
        depth += bool(condition_begins.match(line)) - bool(condition_ends.match(line))
        inner = own_include.match(line)
        system = system_include.match(line)
        if inner and depth:
            sys.exit(f"amalgamate: {header}:{number}: a header of gmis is included under a condition")
        if inner:
            before += gather(include, inner.group(1), seen, outer)
        elif system and not depth:
            outer.add(system.group(1))
        else:
            own.append(line)
    while own and not own[0].strip():
        own.pop(0)
    return before + [f"// --- {header} ---", "", *own, ""] if own else before


if __name__ == "__main__":
    main()
