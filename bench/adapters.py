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
import collections
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile

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


def owners_of(program, addresses):
    """The owner of the code at each address of the program, by its stack of inlined calls, innermost first."""
    text = "".join(f"0x{a:x}\n" for a in addresses)
    output = subprocess.run(["addr2line", "-a", "-i", "-e", program], input=text, capture_output=True, text=True, check=True).stdout
    result, address = {}, None
    for line in output.splitlines():
        if re.fullmatch(r"0x[0-9a-f]+", line):
            address = int(line, 16)
            result[address] = None
        elif result[address] is None:
            result[address] = owner(os.path.normpath(line.rsplit(":", 1)[0]))
    return result


class Profile:
    """Callgrind's counts: of every function its own by address, and its calls with their inclusive counts."""

    def __init__(self, path):
        self.own = collections.Counter()  # (function, address)
        self.calls = collections.Counter()  # (function, address, called)
        self.object_of = {}
        names = {}

        def named(kind, text):
            found = re.match(r"\((\d+)\)(?: (.*))?", text)
            if found.group(2) is not None:
                names[kind, found.group(1)] = found.group(2)
            return names[kind, found.group(1)]

        current = called = here = called_object = None
        is_call = False
        address = 0
        for line in open(path, encoding="utf-8", errors="replace"):
            line = line.rstrip("\n")
            if line.startswith("ob="):
                here = named("ob", line[3:])
            elif line.startswith("cob="):
                called_object = named("ob", line[4:])
            elif line.startswith("fn="):
                current = (here, named("fn", line[3:]))
                called_object = None
            elif line.startswith("cfn="):
                called = (called_object or here, named("fn", line[4:]))
                called_object = None
            elif line.startswith(("fl=", "fi=", "fe=")):
                named("fl", line[3:])
            elif line.startswith(("cfi=", "cfl=")):
                named("fl", line[4:])
            elif line.startswith("calls="):
                is_call = True
            elif line and (line[0] in "0123456789+-*"):
                words = line.split()
                first = words[0]
                if first.startswith("+"):
                    address += int(first[1:], 0)
                elif first.startswith("-"):
                    address -= int(first[1:], 0)
                elif first != "*":
                    address = int(first, 0)
                cost = int(words[2]) if len(words) > 2 else 0
                if is_call:
                    self.calls[current, address, called] += cost
                else:
                    self.own[current, address] += cost
                is_call = False


def shares(program, *arguments):
    profiles = []
    with tempfile.TemporaryDirectory() as folder:
        for iterations in (1, 3):
            out = f"{folder}/{iterations}"
            subprocess.run(["valgrind", "--tool=callgrind", "--dump-instr=yes", f"--callgrind-out-file={out}", program, *arguments,
                            str(iterations)], check=True, capture_output=True)
            profiles.append(Profile(out))
    one, three = profiles
    three.own.subtract(one.own)
    three.calls.subtract(one.calls)
    own = {key: count for key, count in three.own.items() if count > 0}
    calls = {key: count for key, count in three.calls.items() if count > 0}

    mine = lambda function: os.path.basename(function[0]) == os.path.basename(program)
    addresses = sorted({a for f, a in own if mine(f)} | {a for f, a, _ in calls if mine(f)})
    by_address = owners_of(program, addresses)  # as linked: the program is no position-independent one
    owner_at = lambda function, address: by_address[address] if mine(function) else None

    # Functions without an owner: whoever calls them, by inclusive counts; repeated, as they call each other.
    callers = collections.defaultdict(list)
    for (function, address, called), count in calls.items():
        if called != function:
            callers[called].append((function, owner_at(function, address), count))
    part = collections.defaultdict(lambda: 0.0)  # share of the library in what the callers of a function are
    for function in {f for f, _ in own} | set(callers):
        part[function] = 0.5
    for _ in range(50):
        for function, sites in callers.items():
            total = sum(count for _, _, count in sites)
            part[function] = sum(count * (1.0 if o == library else 0.0 if o == renderer else part[caller])
                                 for caller, o, count in sites) / total
    sums = collections.Counter()
    for (function, address), count in own.items():
        whose = owner_at(function, address)
        if whose:
            sums[whose] += count
        else:
            sums[library] += count * part[function]
            sums[renderer] += count * (1 - part[function])
    return sums


def share():
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for adapter in filter(Adapter.is_here, adapters):
            program = f"{folder}/{adapter.macro.lower()}"
            subprocess.run(["g++", *options, "-march=x86-64-v3", "-g1", "-no-pie", "-D" + adapter.macro,
                            str(root / "bench/adapters/main.cpp"), "-o", program, *adapter.libraries], check=True)
            for counts in ("pt", "vcm"):
                sums = shares(program, counts)
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
