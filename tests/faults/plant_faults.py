#!/usr/bin/env python3
"""Plants the faults of faults.txt in a copy of the library and sees which test catches each.

Faults inside functions are compiled together: the body of a function stands once for every fault in
it and once without, and a run of the test chooses one. A fault for which that does not compile,
such as one in a signature, and one that no test caught so, is planted alone. A fault's tests are
tried in turn; the first that fails has caught it. Each test must pass without a fault. Prints a
line per fault, writes a report, and exits with 1 when fewer than 98 % were caught, or when a fault
could not be planted.

`--mutate SYMBOL` plants mechanical faults of a function in place of the list: an operator
or a name for its opposite, a factor of 1.01, a statement left out, a condition negated. What no
test catches is either harmless or a gap; it decides nothing by itself.
"""

import argparse
import collections
import concurrent.futures
import dataclasses
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from fault_list import FAULTS, Fault, mutations, place_of, read_faults
from tokens import headers_in

PROJECT = pathlib.Path(__file__).resolve().parents[2]
REQUIRED = 0.98
# A test with a fault that takes more processor time than this factor times that without a fault,
# and these seconds, does not end. One that only waits is given longer: how busy the machine is
# decides nothing.
RUN_LIMIT_FACTOR, RUN_LIMIT_SECONDS, WAITING_LIMIT_FACTOR = 10, 20, 20
MOST_TOGETHER = 40  # faults in one program
MOST_TESTS_FOUND = 4
COMPILE = ["-std=c++20", "-w", "-fmax-errors=100"]
# What no fault touches, parsed once; and what a program asks for its fault.
FRAMEWORK = """#include "support/catch.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <type_traits>
#include <vector>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
namespace gmis_fault {
inline const int number = std::getenv("GMIS_FAULT") == nullptr ? 0 : std::atoi(std::getenv("GMIS_FAULT"));
constexpr bool is(int fault) { return !__builtin_is_constant_evaluated() && fault == number; }
template <class X> constexpr X scaled(const X& x) {
  if constexpr (std::is_floating_point_v<X>) return X(1.01) * x;
  else if constexpr (requires { x * typename X::value_type(1.01); }) return x * typename X::value_type(1.01);
  else return x;
}
}  // namespace gmis_fault
"""


def test_sources(copy):
    """From the name of a test to its folder, its sources and whether it is optimised, as the CMake
    files declare it."""
    sources = {}
    for cmake in (copy / "tests").glob("*/CMakeLists.txt"):
        text = "".join(part.read_text() for part in [cmake, *cmake.parent.glob("*.cmake")])
        for call in re.finditer(r"gmis_add_test\(\s*(\w+)([^)]*)\)", text):
            files = [word for word in call[2].split() if word.endswith(".cpp")]
            sources[call[1]] = (cmake.parent, files, "UNOPTIMIZED" not in call[2].split())
    return sources


def undeclared(tests, sources):
    """The complaint about tests that no CMake file declares; empty where all are declared."""
    return ", ".join(f"no CMake file declares {name}" for name in tests if name not in sources)


class Includes:
    """The headers of the library that a source includes, with all that those include."""

    def __init__(self, copy):
        self.copy, self.known = copy, {}

    def closure(self, file):
        file = file.resolve()
        if file not in self.known:
            self.known[file] = set()
            for quoted in re.findall(r'^#include ["<]([^">]+)[">]', file.read_text(encoding="utf-8"), re.MULTILINE):
                for folder in (file.parent, *(self.copy / part for part in ("include", "tests", "examples"))):
                    if (folder / quoted).is_file():
                        included = (folder / quoted).resolve()
                        self.known[file] |= {included} | self.closure(included)
                        break
        return self.known[file]


@dataclasses.dataclass
class Result:
    fault: Fault
    caught: str = None  # by which test and case; "" for not caught; None where the fault could not be planted
    note: str = ""
    place: object = None
    tests: list = dataclasses.field(default_factory=list)


class Planter:
    def __init__(self, copy, compiler, headers):
        self.copy, self.headers = copy, headers
        self.sources = test_sources(copy)
        self.includes = Includes(copy)
        self.build = copy / "build"
        self.build.mkdir()
        self.compile = [compiler, *COMPILE]
        if "clang" not in compiler:
            self.compile += ["--param=ggc-min-heapsize=524288"]  # as CMakeLists.txt has it
        tests = ["-I", str(copy / "tests"), "-I", str(copy / "include")]
        for level in ("-O0", "-O1"):
            (self.build / level).mkdir()
            header = self.build / level / "framework.hpp"
            header.write_text(FRAMEWORK)
            subprocess.run([*self.compile, level, *tests, "-x", "c++-header", str(header)], check=True)
        self.main = self.build / "main.o"
        subprocess.run([*self.compile, "-O0", *tests, "-c", str(copy / "tests/support/main.cpp"), "-o", str(self.main)], check=True)
        self.libraries = []
        if any((pathlib.Path(p) / "catch2/catch_all.hpp").exists() for p in ("/usr/include", "/usr/local/include")):
            self.libraries = ["-lCatch2"]
        self.seconds = {}  # of a test without a fault, by optimisation
        self.folders = 0
        self.compilations = 0
        self.spent = collections.Counter()

    def tests_of(self, fault, header):
        """The tests to try: those that are named; else those that include the header and least
        else."""
        if fault.tests:
            return fault.tests
        header = (self.copy / "include/gmis" / header.name).resolve()
        found = []
        for name, (place, files, _) in self.sources.items():
            closure = set().union(*(self.includes.closure(place / file) for file in files)) if all((place / f).exists() for f in files) else set()
            if header in closure:
                found.append((len(closure), name))
        return [name for _, name in sorted(found)[:MOST_TESTS_FOUND]]

    def level(self, name):
        return "-O1" if self.sources[name][2] else "-O0"

    def new_folder(self):
        self.folders += 1
        folder = self.build / f"run_{self.folders}"
        folder.mkdir()
        return folder

    def compiled(self, name, folder, level):
        """Compiles a test against the headers of a folder: its program, or what the compiler
        says."""
        started = time.monotonic()
        place, files, _ = self.sources[name]
        program = folder / name
        command = [*self.compile, level, "-include", str(self.build / level / "framework.hpp"), "-I", str(folder / "include")]
        for part in ("include", "tests", "examples"):
            command += ["-I", str(self.copy / part)]
        command += ["-I", str(place), *(str(place / file) for file in files), str(self.main), "-o", str(program), "-pthread", *self.libraries]
        result = subprocess.run(command, capture_output=True, text=True, errors="replace")
        self.compilations += 1
        self.spent["compiling"] += time.monotonic() - started
        return (program, "") if result.returncode == 0 else (None, result.stderr)

    def sound(self, name, program, level, folder):
        """Whether the program passes without a fault."""
        started = time.monotonic()
        passed = subprocess.run([str(program)], capture_output=True, cwd=folder, env=os.environ | {"GMIS_FAULT": "0"}).returncode == 0
        self.seconds[name, level] = time.monotonic() - started
        self.spent["running"] += time.monotonic() - started
        return passed

    def run(self, name, program, level, folder, number):
        """Runs a test with a fault: (passed, what happened)."""
        started = time.monotonic()
        limit = int(RUN_LIMIT_SECONDS + RUN_LIMIT_FACTOR * self.seconds[name, level])
        try:
            result = subprocess.run(["bash", "-c", 'ulimit -S -t "$0" -v 8000000 && exec "$@"', str(limit), str(program), "--abort", "--reporter", "xml"],
                                    capture_output=True, text=True, errors="replace", timeout=WAITING_LIMIT_FACTOR * limit, cwd=folder,
                                    env=os.environ | {"GMIS_FAULT": str(number)})
        except subprocess.TimeoutExpired:
            return False, "does not end"
        finally:
            self.spent["running"] += time.monotonic() - started
        if result.returncode == 0:
            return True, ""
        if result.returncode == -signal.SIGXCPU:
            return False, "does not end"
        # The case that was running when the first check failed, or when the program died.
        cases = re.findall(r'<TestCase name="([^"]*)"', result.stdout)
        return False, unescape(cases[-1]) if cases else f"ends with {result.returncode}"

    # --- Many faults in one program ---------------------------------------------------------------

    def write_together(self, results, folder):
        """Writes headers in which every function with faults has its body once for each. Returns of
        every header the lines of each fault."""
        lines = {}
        by_header = collections.defaultdict(lambda: collections.defaultdict(list))
        for result in results:
            header = result.place.header
            scope = header.function_around(result.place.first, result.place.last - 1 if result.place.last > result.place.first else result.place.first)
            by_header[header.name][scope.body].append(result)
        for name, functions in by_header.items():
            header, text, at = self.headers[name], "", 0
            lines[name] = []
            for body, its_results in sorted(functions.items()):
                begin, end = header.tokens[body[0]].end, header.tokens[body[1]].start
                text += header.text[at:begin]
                for result in its_results:
                    start, stop = result.place.range()
                    text += f"\nif (gmis_fault::is({result.fault.number})) {{"
                    first = text.count("\n")
                    text += header.text[begin:start] + " " + result.fault.new + " " + header.text[stop:end] + "\n} else"
                    lines[name].append((first + 1, text.count("\n") + 1, result))
                text += "\n{" + header.text[begin:end] + "\n}\n"
                at = end
            path = folder / "include/gmis" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text + header.text[at:])
        return lines

    def try_together(self, name, results):
        """Plants faults in one program of a test; returns those that have to be planted alone."""
        alone, level = [], self.level(name)
        folder = self.new_folder()
        while results:
            shutil.rmtree(folder)
            folder.mkdir()
            lines = self.write_together(results, folder)
            program, said = self.compiled(name, folder, level)
            if program:
                break
            wrong = {id(result): result for header, ranges in lines.items() for first, last, result in ranges
                     for line in re.findall(rf"{re.escape(header)}:(\d+):", "\n".join(l for l in said.splitlines() if "error" in l) or said)
                     if first <= int(line) <= last}
            wrong = list(wrong.values()) or results
            alone += wrong
            results = [result for result in results if not any(result is other for other in wrong)]
        else:
            shutil.rmtree(folder)
            return alone
        if not self.sound(name, program, level, folder):
            shutil.rmtree(folder)
            return alone + results
        for result in results:
            passed, note = self.run(name, program, level, folder, result.fault.number)
            if not passed:
                result.caught = f"{name}: {note}"
        shutil.rmtree(folder)
        return alone

    # --- One --------------------------------------------------------------------------------------

    def try_alone(self, result):
        folder = self.new_folder()
        (folder / "include/gmis").mkdir(parents=True)
        header = folder / "include/gmis" / result.place.header.name
        header.parent.mkdir(parents=True, exist_ok=True)
        for name in result.tests:
            level = self.level(name)
            if (name, level) not in self.seconds:
                program, said = self.compiled(name, folder, level)
                if not program or not self.sound(name, program, level, folder):
                    result.note = f"{name} without a fault: " + (shorten(first_error(said)) if not program else "fails")
                    break
            header.write_text(result.place.planted(result.fault.new))
            program, said = self.compiled(name, folder, level)
            if not program:
                result.note = "does not compile: " + shorten(first_error(said))
                break
            passed, note = self.run(name, program, level, folder, 0)
            header.unlink()
            if not passed:
                result.caught = f"{name}: {note}"
                break
            result.caught = ""
        if result.note:
            result.caught = None
        shutil.rmtree(folder)


def first_error(said):
    return next((line for line in said.splitlines() if "error" in line), "").strip()


def shorten(text, most=200):
    return text if len(text) <= most else text[: most - 1] + "…"


def unescape(text):
    for code, letter in (("&quot;", '"'), ("&apos;", "'"), ("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")):
        text = text.replace(code, letter)
    return text


def without_forced_inlining(copy):
    """Bodies stand many times; inlined everywhere they would take minutes to compile. Attributes do
    not change what is computed."""
    for header in (copy / "include").rglob("*.hpp"):
        text = header.read_text(encoding="utf-8")
        changed = re.sub(r"\b(always_inline|flatten)\b", "unused", text)
        if changed != text:
            header.write_text(changed, encoding="utf-8")


def say(result):
    said = result.caught or ("NOT CAUGHT" if result.caught == "" else "ERROR: " + result.note)
    print(f"{result.fault.text}\n    {said}", flush=True)


def plant_all(planter, results, jobs):
    """The faults with a place, in rounds: all those whose turn it is for a test go into programs of
    that test."""
    together = [r for r in results if r.place.header.function_around(r.place.first, max(r.place.first, r.place.last - 1))]
    alone = [r for r in results if not any(r is other for other in together)]
    waiting = {id(r): list(r.tests) for r in together}
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        while waiting:
            of_test = collections.defaultdict(list)
            for result in together:
                if id(result) in waiting:
                    of_test[waiting[id(result)].pop(0)].append(result)
            chunks = [(name, its[k:k + MOST_TOGETHER]) for name, its in of_test.items() for k in range(0, len(its), MOST_TOGETHER)]
            chunks.sort(key=lambda chunk: -len(chunk[1]))
            tried = pool.map(lambda chunk: (chunk[1], planter.try_together(*chunk)), chunks)
            for chunk, failed in tried:
                for result in chunk:
                    is_alone = any(result is other for other in failed)
                    if is_alone or (not result.caught and not waiting[id(result)]):
                        # A fault in a constant that the compiler computed did nothing.
                        alone.append(result)
                    if is_alone or result.caught or not waiting[id(result)]:
                        del waiting[id(result)]
                    if result.caught:
                        say(result)
        for result in pool.map(lambda result: (planter.try_alone(result), result)[1], alone):
            say(result)


def mechanical(headers, symbol):
    """Mechanical faults of a function, with their places."""
    from fault_list import Place
    results = []
    for header in headers.values():
        for first, last, new, what in mutations(header, symbol):
            line = header.text.count("\n", 0, header.tokens[first].start) + 1
            name = f"{symbol}@{header.name}:{line}/{what}"
            fault = Fault(name, [], [], [], new, [], name, len(results) + 1)
            results.append(Result(fault, place=Place(header, first, last)))
    return results


def main():
    parser = argparse.ArgumentParser(prog="./run faults", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", metavar="NAME", help="only faults whose name holds this text")
    parser.add_argument("--sample", type=int, metavar="N", help="N of them, spread over the list")
    parser.add_argument("--list", action="store_true", help="list the faults; fails where one cannot be planted, or names a test that no CMake file declares")
    parser.add_argument("--prune", action="store_true", help="remove those from the list that cannot be planted, and name them")
    parser.add_argument("--mutate", metavar="SYMBOL", help="mechanical faults of a function")
    parser.add_argument("--tests", nargs="+", help="with --mutate: the tests to try; else those that include the header and least else")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 2)
    parser.add_argument("--report", type=pathlib.Path, default=PROJECT / "out" / "faults.md", help="(out/faults.md)")
    parser.add_argument("--faults", type=pathlib.Path, default=FAULTS, help=argparse.SUPPRESS)
    options = parser.parse_args()

    headers = headers_in(PROJECT / "include/gmis")
    if options.list or options.prune:
        sys.exit(show(options, headers))
    with tempfile.TemporaryDirectory(prefix="gmis_faults_") as folder:
        copy = pathlib.Path(folder)
        for part in ("include", "tests", "examples"):
            shutil.copytree(PROJECT / part, copy / part)
        without_forced_inlining(copy)
        headers = headers_in(copy / "include/gmis")
        if options.mutate:
            results = mechanical(headers, options.mutate)
        else:
            results = [Result(fault) for fault in read_faults(options.faults) if not options.only or options.only in fault.name]
        if options.sample:
            results = [results[k * len(results) // options.sample] for k in range(min(options.sample, len(results)))]
        if not results:
            sys.exit("there is no such fault")
        started = time.monotonic()
        planter = Planter(copy, os.environ.get("CXX", "g++"), headers)
        for result in results:
            if not result.place:
                result.place, result.note = place_of(result.fault, headers)
            if result.place:
                result.fault.tests = options.tests or result.fault.tests
                result.tests = planter.tests_of(result.fault, result.place.header)
                result.note = undeclared(result.tests, planter.sources) or ("" if result.tests else "no test includes its header")
                if result.note:
                    result.place = None
            if not result.place:
                say(result)
        print(f"{len(results)} faults", flush=True)
        plant_all(planter, [result for result in results if result.place], options.jobs)
    return report(options, results, planter, time.monotonic() - started, resource.getrusage(resource.RUSAGE_CHILDREN))


def show(options, headers):
    lost = [(fault, why) for fault in read_faults(options.faults) for place, why in [place_of(fault, headers)] if not place]
    if options.list:
        for fault in read_faults(options.faults):
            if not options.only or options.only in fault.name:
                print(fault.text)
    sources = test_sources(PROJECT)
    orphans = [(fault, why) for fault in read_faults(options.faults) if (why := undeclared(fault.tests, sources))]
    for fault, why in lost + orphans:
        print(f"{options.faults.name}:{fault.line}: {fault.name}: {why}", file=sys.stderr)
    print(f"{len(read_faults(options.faults))} faults; {len(lost)} cannot be planted", file=sys.stderr)
    if options.prune:
        gone = {fault.line for fault, _ in lost}
        lines = options.faults.read_text(encoding="utf-8").splitlines(keepends=True)
        options.faults.write_text("".join(line for number, line in enumerate(lines, 1) if number not in gone), encoding="utf-8")
        return 0
    return 1 if lost or orphans else 0


def report(options, results, planter, seconds, usage):
    errors = [result for result in results if result.caught is None]
    missed = [result for result in results if result.caught == ""]
    caught = len(results) - len(errors) - len(missed)
    share = caught / max(1, caught + len(missed))
    summary = (f"{caught} of {caught + len(missed)} faults were caught ({100 * share:.1f} %), {len(errors)} could not be planted; {seconds / 60:.1f} "
               f"minutes with {options.jobs} at a time, {(usage.ru_utime + usage.ru_stime) / 60:.1f} of processor time; {planter.compilations} "
               f"compilations took {100 * planter.spent['compiling'] / (sum(planter.spent.values()) or 1):.0f} % of it.")
    lines = ["# Planted faults", "", "Planted in a copy of the library (`./run faults`). " + summary, "", "| fault | caught by |", "| --- | --- |"]
    for result in results:
        said = result.caught or ("**not caught**" if result.caught == "" else "**error**: " + result.note)
        lines.append("| " + result.fault.text.replace("|", "\\|") + " | " + said + " |")
    options.report.parent.mkdir(parents=True, exist_ok=True)
    options.report.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(summary + f"\nThe report is in {options.report}")
    return 0 if options.mutate or (share >= REQUIRED and not errors) else 1


if __name__ == "__main__":
    sys.exit(main())
