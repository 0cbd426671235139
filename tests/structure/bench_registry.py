#!/usr/bin/env python3
"""Checks the registry of benchmarks: each says what it measures and takes its options, and
every table in a document, every program of bench/CMakeLists.txt and every `./run bench` in a
document belongs to one of them.
"""

import contextlib
import io
import os
import pathlib
import re
import sys

PROJECT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PROJECT / "bench"))
sys.dont_write_bytecode = True

import run


def faults():
    names = run.names()
    sources = {name: (PROJECT / f"bench/benches/{name}.py").read_text(encoding="utf-8") for name in names}
    for name in names:
        module = run.load(name)
        if not module.__doc__:
            yield f"{name}: no docstring"
        help_text = io.StringIO()
        try:
            with contextlib.redirect_stdout(help_text):
                run.parser_of(name, module).parse_args(["--help"])
        except SystemExit as ended:
            if ended.code:
                yield f"{name}: --help fails"
        for document in re.findall(r'"(docs/[\w-]+\.md)"', sources[name]):
            if not (PROJECT / document).exists():
                yield f"{name}: there is no {document}"
    for document in sorted([*PROJECT.glob("*.md"), *PROJECT.glob("docs/*.md")]):
        text = document.read_text(encoding="utf-8")
        place = document.relative_to(PROJECT)
        if document.name != "CHANGELOG.md" and ".next." not in document.name:  # history, and drafts
            for name in re.findall(r"\./run bench ([a-z_]+)", text):
                if name not in names:
                    yield f"{place}: there is no benchmark {name}"
        for table, name in re.findall(r"<!-- ([^\n]+?): written by \./run bench ([a-z_]+)", text):
            if f"<!-- end of {table} -->" not in text:
                yield f"{place}: the table {table} has no end"
            if name in names and "docs/" in sources[name] and str(place) not in sources[name]:
                yield f"{place}: {name} does not write here"
    for program in re.findall(r"gmis_add_benchmark\(([a-z]\w*)", (PROJECT / "bench/CMakeLists.txt").read_text(encoding="utf-8")):
        if program not in ("name",) and not any(f'"{program}"' in source for source in sources.values()):
            yield f"bench/CMakeLists.txt: no benchmark runs {program}"


os.chdir(PROJECT)
found = list(faults())
print("\n".join([*found, f"{len(found)} faults"]))
sys.exit(bool(found))
