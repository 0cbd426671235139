#!/usr/bin/env python3
"""What each adapter of examples/ costs, as Markdown tables.

lines    Lines of the adapter, and of the complete program.
compile  Processor seconds and greatest resident memory of one compilation of the complete program at -O2, with g++ and, where
         it is installed, clang++. Processor time does not count what other programs do meanwhile.
share    Of the instructions of an iteration, how many are the library's, how many the renderer's. Callgrind counts the
         instructions at each address; line tables with inlined calls say whose source each comes from: the innermost call
         that lies in the library (core, transport) or in the renderer (examples, or gmis/scene for the built-in one).
         Functions that both use (GLM, the standard library, the C library, Embree) count for whoever calls them. The
         difference of two runs leaves out the construction of the scene.
"""
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile

import callgrind

root = pathlib.Path(__file__).resolve().parents[1]
options = ["-std=c++20", "-O2", "-I", str(root / "include"), "-I", str(root / "examples"), "-ffp-contract=off"]


class Adapter:
    def __init__(self, name, lines, program, macro, libraries=()):
        self.name, self.lines, self.program, self.macro, self.libraries = name, lines, program, macro, list(libraries)

    def is_here(self):
        return "-lembree3" not in self.libraries or pathlib.Path("/usr/include/embree3/rtcore.h").exists()


adapters = [
    Adapter("the built-in scene", None, "render_a_scene.cpp", "GMIS_OVER_BUILT_IN"),
    Adapter("a renderer of another style", "bring_your_own/adapter.hpp", "bring_your_own/main.cpp", "GMIS_OVER_BRING_YOUR_OWN"),
    Adapter("lamps chosen for their receiver", "many_lights/adapter.hpp", "many_lights/main.cpp", "GMIS_OVER_MANY_LIGHTS"),
    Adapter("Embree's intersector", "embree/embree_scene.hpp", "embree/main.cpp", "GMIS_OVER_EMBREE", ["-lembree3"]),
]


def count_lines(name):
    return len((root / "examples" / name).read_text(encoding="utf-8").splitlines()) if name else "–"


def table(head, rows):
    print("| " + " | ".join(head) + " |")
    print("| --- |" + " ---: |" * (len(head) - 1))
    for row in rows:
        print("| " + " | ".join(str(cell) for cell in row) + " |", flush=True)
    print()


def lines():
    table(["over", "lines of the adapter", "lines of the program"],
          [(a.name, count_lines(a.lines), count_lines(a.program)) for a in adapters])


def measured(command):
    """Processor seconds and megabytes of a command."""
    pid = os.fork()
    if pid == 0:
        os.execvp(command[0], command)
    _, status, usage = os.wait4(pid, 0)
    if status != 0:
        sys.exit("adapters: failed: " + " ".join(command))
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def compile_():
    compilers = [c for c in ("g++", "clang++") if shutil.which(c)]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for adapter in filter(Adapter.is_here, adapters):
            row = [adapter.name]
            for compiler in compilers:
                seconds, megabytes = measured([compiler, *options, "-c", str(root / "examples" / adapter.program), "-o",
                                               folder + "/program.o"])
                row.append(f"{seconds:.1f} s, {megabytes:.0f} MB")
            rows.append(row)
    table(["program over", *compilers], rows)


# --- Shares ---------------------------------------------------------------------------------------------------------------

library, renderer = "library", "renderer"


def owner(file):
    """Whose code this is; None for code that works for whoever calls it."""
    if "/include/gmis/" in file:
        part = file.split("/include/gmis/")[1]
        if part.startswith("scene/"):
            return renderer
        return library if part.startswith(("transport/", "result/", "render/")) else None
    if "/examples/" in file:
        return renderer
    return None


def share():
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for adapter in filter(Adapter.is_here, adapters):
            program = f"{folder}/{adapter.macro.lower()}"
            subprocess.run(["g++", *options, "-march=x86-64-v3", "-g1", "-no-pie", "-D" + adapter.macro,
                            str(root / "bench/adapters/main.cpp"), "-o", program, *adapter.libraries], check=True)
            for counts in ("pt", "vcm"):
                sums = callgrind.shares(program, [counts, "1"], [counts, "3"], owner)
                total = sum(sums.values())
                rows.append((adapter.name, counts, f"{total / 2e6:.2f}", f"{sums[library] / 2e6:.2f}",
                             f"{sums[renderer] / 2e6:.2f}", f"{100 * sums[library] / total:.0f} %"))
                print(*rows[-1], file=sys.stderr, flush=True)
    table(["over", "counts", "M instructions an iteration", "library", "renderer", "library's share"], rows)


if __name__ == "__main__":
    tasks = {"lines": lines, "compile": compile_, "share": share}
    wanted = sys.argv[1:] or list(tasks)
    for name in wanted:
        if name not in tasks:
            sys.exit(f"adapters: no {name}: lines, compile or share")
    for name in wanted:
        tasks[name]()
