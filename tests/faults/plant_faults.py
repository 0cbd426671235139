#!/usr/bin/env python3
"""Plants the faults of faults.txt in a copy of the library, one at a time, and sees which test catches each.

Each fault is a text of one header that is replaced by another. The test programs named for it are compiled against the
faulty header in turn and run; the first one that fails has caught it. Before that every program must pass against the
sound library. Prints a line per fault, writes a report, and exits with 1 when fewer than 95 % were caught, or when a fault
could not be planted: its text is gone, or it does not compile.
"""

import argparse
import concurrent.futures
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

PROJECT = pathlib.Path(__file__).resolve().parents[2]
FAULTS = pathlib.Path(__file__).resolve().parent / "faults.txt"
REQUIRED = 0.95
# A test that takes so many times as much processor time with a fault in it as it takes seconds without, and a minute, does
# not end. One that only waits is given longer: how busy the machine is decides nothing.
RUN_LIMIT_FACTOR, RUN_LIMIT_SECONDS, WAITING_LIMIT_FACTOR = 30, 60, 20
# With a fault in it a test ends at the first check that fails, mostly soon: where it takes no more than this many seconds
# without, optimising it would take longer than it saves.
LONG_RUN_SECONDS = 5
COMPILE = ["-std=c++20", "-w"]


class Fault:
    def __init__(self, number, line, file, tests, old, new):
        self.number, self.line, self.file, self.tests, self.old, self.new = number, line, file, tests, old, new

    def title(self):
        old, new = " ".join(self.old.split()), " ".join(self.new.split())
        return f"`{shorten(old)}` → " + (f"`{shorten(new)}`" if new else "nothing")


def shorten(text, most=90):
    return text if len(text) <= most else text[: most - 1] + "…"


def read_faults(path):
    """A line `@ FILE : TEST …` says where the faults below it are planted and what is to catch them; lines `- …` hold the
    text to be replaced, lines `+ …` the text in its place. How it is broken into lines does not matter."""
    faults, file, tests, old, new = [], None, [], [], []
    start = 0

    def finish():
        if old:
            faults.append(Fault(len(faults) + 1, start, file, tests, "\n".join(old), "\n".join(new)))
        old.clear()
        new.clear()

    for number, line in enumerate(path.read_text().splitlines(), 1):
        if line.startswith("@"):
            finish()
            file, _, names = line[1:].partition(":")
            file, tests = file.strip(), names.split()
            if not tests:
                sys.exit(f"{path}:{number}: no tests are named")
        elif line.startswith("-"):
            if new:
                finish()
            if not old:
                start = number
            old.append(line[2:])
        elif line.startswith("+"):
            new.append(line[2:])
        elif line.strip() and not line.startswith("#"):
            sys.exit(f"{path}:{number}: this line starts with none of @ - + #")
        else:
            finish()
    finish()
    return faults


def header_of(include, fault):
    """The header of a fault: at its path below include/gmis, or elsewhere there if only one has its name."""
    header = include / "gmis" / fault.file
    if header.exists():
        return header
    found = list((include / "gmis").rglob(header.name))
    return found[0] if len(found) == 1 else None


def planted(text, fault):
    """`text` with the fault in it; a message when its old text is not there just once."""
    pattern = r"\s+".join(re.escape(word) for word in fault.old.split())
    found = list(re.finditer(pattern, text))
    if len(found) != 1:
        return None, "its text is no longer in the file" if not found else f"its text is {len(found)} times in the file"
    return text[: found[0].start()] + fault.new + text[found[0].end() :], ""


def test_sources(copy):
    """From the name of a test to its folder, its sources and whether it is optimised, as the CMake files declare it."""
    sources = {}
    for cmake in (copy / "tests").glob("*/CMake*.txt"):
        text = "".join(part.read_text() for part in [cmake, *cmake.parent.glob("*.cmake")])
        for call in re.finditer(r"gmis_add_test\(\s*(\w+)([^)]*)\)", text):
            files = [word for word in call[2].split() if word.endswith(".cpp")]
            sources[call[1]] = (cmake.parent, files, "UNOPTIMIZED" not in call[2].split())
    return sources


class Planter:
    def __init__(self, copy, compiler):
        self.copy = copy
        self.sources = test_sources(copy)
        self.build = copy / "build"
        self.build.mkdir()
        self.compile = [compiler, *COMPILE]
        if "clang" not in compiler:
            self.compile += ["--param=ggc-min-heapsize=524288"]  # as CMakeLists.txt has it
        # What no fault touches is parsed once.
        framework = (
            '#include "support/catch.hpp"\n#include <algorithm>\n#include <array>\n#include <cmath>\n#include <complex>\n'
            "#include <map>\n#include <optional>\n#include <random>\n#include <string>\n#include <vector>\n"
            "#include <glm/common.hpp>\n#include <glm/geometric.hpp>\n#include <glm/vec2.hpp>\n#include <glm/vec3.hpp>\n"
        )
        tests = ["-I", str(copy / "tests")]
        for level in ("-O0", "-O1"):
            (self.build / level).mkdir()
            header = self.build / level / "framework.hpp"
            header.write_text(framework)
            self.must([*self.compile, level, *tests, "-x", "c++-header", str(header)])
        self.seconds = {}  # of a test without a fault
        self.main = self.build / "main.o"
        self.must([*self.compile, "-O0", *tests, "-c", str(copy / "tests/support/main.cpp"), "-o", str(self.main)])
        self.libraries = []
        if any((pathlib.Path(p) / "catch2/catch_all.hpp").exists() for p in ("/usr/include", "/usr/local/include")):
            self.libraries = ["-lCatch2"]

    @staticmethod
    def must(command):
        subprocess.run(command, check=True)

    def run_test(self, name, folder, header_folder):
        """Compiles and runs one test: (passed, what happened). `header_folder` comes before the library's headers."""
        place, files, is_optimised = self.sources[name]
        is_sound = name not in self.seconds
        level = "-O1" if is_optimised and (is_sound or self.seconds[name] > LONG_RUN_SECONDS) else "-O0"
        program = folder / name
        command = [*self.compile, level, "-include", str(self.build / level / "framework.hpp")]
        if header_folder:
            command += ["-I", str(header_folder)]
        for part in ("include", "tests", "examples"):
            command += ["-I", str(self.copy / part)]
        command += ["-I", str(place)]
        command += [str(place / file) for file in files] + [str(self.main), "-o", str(program), "-pthread", *self.libraries]
        compiled = subprocess.run(command, capture_output=True, text=True)
        if compiled.returncode != 0:
            first = next((l for l in compiled.stderr.splitlines() if "error" in l), "").strip()
            return None, "does not compile: " + shorten(first, 200)
        limit = None if is_sound else int(RUN_LIMIT_SECONDS + RUN_LIMIT_FACTOR * self.seconds[name])
        started = time.monotonic()
        try:
            result = subprocess.run(
                ["bash", "-c", 'ulimit -S -t "$0" && exec "$@"', str(limit or "unlimited"), str(program), "--abort",
                 "--reporter", "xml"], capture_output=True, text=True, errors="replace",
                timeout=WAITING_LIMIT_FACTOR * limit if limit else None, cwd=folder)
            self.seconds.setdefault(name, time.monotonic() - started)
        except subprocess.TimeoutExpired:
            return False, "does not end"
        finally:
            program.unlink(missing_ok=True)
        if result.returncode == 0:
            return True, ""
        if result.returncode == -signal.SIGXCPU:
            return False, "does not end"
        # The case that was running when the first check failed, or when the program died.
        cases = re.findall(r'<TestCase name="([^"]*)"', result.stdout)
        return False, unescape(cases[-1]) if cases else f"ends with {result.returncode}"

    def try_fault(self, fault):
        started = time.monotonic()
        original = header_of(self.copy / "include", fault)
        if original is None:
            return fault, None, "there is no such header", 0.0
        text, problem = planted(original.read_text(), fault)
        if text is None:
            return fault, None, problem, 0.0
        unknown = [name for name in fault.tests if name not in self.sources]
        if unknown:
            return fault, None, "no such test: " + " ".join(unknown), 0.0
        folder = self.build / f"fault_{fault.number}"
        header = folder / original.relative_to(self.copy)
        header.parent.mkdir(parents=True)
        header.write_text(text)
        caught, note = None, ""
        for name in fault.tests:
            passed, note = self.run_test(name, folder, folder / "include")
            if passed is None:
                caught = None
                break
            if not passed:
                caught = f"{name}: {note}"
                break
        else:
            caught = ""
        shutil.rmtree(folder)
        return fault, caught, note, time.monotonic() - started


def unescape(text):
    for code, letter in (("&quot;", '"'), ("&apos;", "'"), ("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")):
        text = text.replace(code, letter)
    return text


def main():
    parser = argparse.ArgumentParser(prog="./run faults", description=__doc__.split("\n\n")[0])
    parser.add_argument("pattern", nargs="?", default="", help="only faults of headers whose path holds this text")
    parser.add_argument("--list", action="store_true", help="list the faults and check that each can be planted")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 2)
    parser.add_argument("--report", type=pathlib.Path, default=PROJECT / "out" / "faults.md", help="(out/faults.md)")
    parser.add_argument("--faults", type=pathlib.Path, default=FAULTS, help=argparse.SUPPRESS)
    options = parser.parse_args()

    faults = [fault for fault in read_faults(options.faults) if options.pattern in fault.file]
    if not faults:
        sys.exit(f"no fault is to be planted in a header like {options.pattern!r}")
    if options.list:
        broken = 0
        for fault in faults:
            header = header_of(PROJECT / "include", fault)
            problem = planted(header.read_text(), fault)[1] if header else "there is no such header"
            broken += bool(problem)
            print(f"{fault.number:4} {fault.file}: {fault.title()}" + (f"  [{problem}]" if problem else ""))
        sys.exit(1 if broken else 0)

    started = time.monotonic()
    compiler = os.environ.get("CXX", "g++")
    with tempfile.TemporaryDirectory(prefix="gmis_faults_") as folder:
        copy = pathlib.Path(folder)
        for part in ("include", "tests", "examples"):
            shutil.copytree(PROJECT / part, copy / part)
        planter = Planter(copy, compiler)
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            names = sorted({name for fault in faults for name in fault.tests if name in planter.sources})
            print(f"{len(faults)} faults, {len(names)} test programs; first without a fault", flush=True)
            sound = list(pool.map(lambda name: (name, *planter.run_test(name, planter.build, None)), names))
            failing = [f"{name}: {note}" for name, passed, note in sound if not passed]
            if failing:
                sys.exit("these fail without a fault:\n  " + "\n  ".join(failing))
            results = []
            for result in pool.map(planter.try_fault, faults):
                fault, caught, note, seconds = result
                results.append(result)
                said = caught if caught else "NOT CAUGHT" if caught == "" else "ERROR: " + note
                print(f"{fault.number:4} {fault.file}:\n       {fault.title()}\n       {said}  [{seconds:.0f} s]", flush=True)

    errors = [result for result in results if result[1] is None]
    missed = [result for result in results if result[1] == ""]
    caught = len(results) - len(errors) - len(missed)
    share = caught / max(1, caught + len(missed))
    minutes = (time.monotonic() - started) / 60
    summary = (f"{caught} of {caught + len(missed)} faults were caught ({100 * share:.1f} %), {len(errors)} could not be "
               f"planted; {minutes:.0f} minutes with {options.jobs} at a time.")
    lines = ["# Planted faults", "", "Each was planted alone in a copy of the library (`./run faults`). " + summary, "",
             "| | header | fault | caught by |", "| --- | --- | --- | --- |"]
    for fault, test, note, _ in results:
        said = test if test else "**not caught**" if test == "" else "**error**: " + note
        lines.append(f"| {fault.number} | `{fault.file}` | " + fault.title().replace("|", "\\|") + " | " + said + " |")
    options.report.parent.mkdir(parents=True, exist_ok=True)
    options.report.write_text("\n".join(lines) + "\n")
    print(summary + f"\nThe report is in {options.report}")
    sys.exit(0 if share >= REQUIRED and not errors else 1)


if __name__ == "__main__":
    main()
