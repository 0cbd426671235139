"""The cost of compiling: processor seconds at -O2, their ratio to those of
examples/one_dimension.cpp, text in kB, and peak memory in MB.

With g++ and, where it is installed, clang++, without a compiler cache. A time is the least of
--runs compilations, as many for each program. The first program is compiled before each of them,
and the ratio is the median of those to it: a machine that grows slower slows both. Writes the table
in docs/your-renderer.md.

  --check        compiles with the default compiler, several at a time, and compares text with that
                 kept in bench/compile.txt: fails where it grew by more than 2 %. Seconds are not
                 compared: they belong to the machine.
  --keep         keeps the text of all programs
"""

import dataclasses
import os
import pathlib
import shutil
import statistics
import subprocess
import sys

from measuring import Table, compiler_name, in_parallel, processor_cost, publish

DOCUMENT = "docs/your-renderer.md"
KEPT = pathlib.Path("bench/compile.txt")
LIMIT = 1.02
FLAGS = ["-std=c++20", "-O2", "-ffp-contract=off", "-I", "include", "-I", "examples"]


@dataclasses.dataclass
class Program:
    name: str
    source: str
    needs: str = ""  # text that must be somewhere in include/
    header: str = ""  # a header that must be installed
    flags: tuple[str, ...] = ()
    is_checked: bool = True


FIRST = Program("`examples/one_dimension.cpp`", "examples/one_dimension.cpp")
PROGRAMS = [
    FIRST,
    Program("one engine over an adapter", "bench/compile/one_engine.cpp"),
    Program("`Render` over an adapter", "examples/bring_your_own/main.cpp"),
    Program("the same, engines declared", "bench/compile/engines_declared.cpp", needs="define GMIS_DECLARE_ENGINES"),
    Program("`Render` over an adapter, with `gmis::compiled`", "examples/bring_your_own/main.cpp", flags=("-DGMIS_COMPILED",), is_checked=False),
    Program("`examples/render_a_scene.cpp`", "examples/render_a_scene.cpp"),
    Program("`examples/render_a_scene.cpp`, with `gmis::compiled`", "examples/render_a_scene.cpp", flags=("-DGMIS_COMPILED",), is_checked=False),
    Program("Embree's intersector", "examples/embree/main.cpp", header="embree3/rtcore.h", is_checked=False),
]


def is_there(program):
    if program.header and not pathlib.Path("/usr/include", program.header).exists():
        return False
    return not program.needs or any(program.needs in file.read_text() for file in pathlib.Path("include").rglob("*.hpp"))


def text_of(objects):
    """Bytes of code and constants."""
    said = subprocess.run(["size", *objects], check=True, capture_output=True, text=True).stdout
    return sum(int(line.split()[0]) for line in said.splitlines()[1:])


def compiled(command, output):
    """Processor seconds, megabytes, text of one file. Without ccache: the command names the
    compiler itself."""
    return *processor_cost([*command, "-o", output]), text_of([output])


def measure(options, compiler, program):
    return compiled([compiler, *FLAGS, *program.flags, "-c", program.source], options.out / f"{pathlib.Path(program.source).stem}.o")


def measure_beside_first(options, compiler, program):
    """Seconds, ratio, text, megabytes."""
    pairs = []
    for _ in range(options.runs):
        first = measure(options, compiler, FIRST)
        pairs.append((first, first if program is FIRST else measure(options, compiler, program)))
    seconds, megabytes, text = zip(*(costs for _, costs in pairs))
    return min(seconds), statistics.median(costs[0] / first[0] for first, costs in pairs), text[0], max(megabytes)


def kept_figures():
    lines = KEPT.read_text().splitlines() if KEPT.exists() else ["", "#"]
    return lines[1][2:], {line.split("  ", 1)[1]: int(line.split("  ", 1)[0]) for line in lines if line and not line.startswith("#")}


def check(options):
    compiler, kept = kept_figures()
    if compiler != compiler_name():
        print(f"compile: the figures kept are those of {compiler}, this is {compiler_name()}: not compared", file=sys.stderr)
        return 0
    has_grown = False
    programs = [program for program in PROGRAMS if program.is_checked and is_there(program)]
    for program, (seconds, _, text) in in_parallel(lambda program: measure(options, os.environ.get("CXX", "g++"), program), programs):
        before = kept.get(program.name)
        grown = before is None or text > LIMIT * before
        has_grown |= grown
        said = "not kept: ./run bench compile --keep" if before is None else f"kept {before / 1000:8.1f}  {100 * (text / before - 1):+6.2f} %"
        print(f"{program.name:32} {seconds:6.1f} s  text {text / 1000:8.1f} kB  {said}{'  GROWN' if grown else ''}", flush=True)
    if has_grown:
        print("compile: text grew by more than 2 %. Find out why; if it must be, ./run bench compile --keep", file=sys.stderr)
    return has_grown


def keep(options):
    rows = [(program.name, measure(options, os.environ.get("CXX", "g++"), program)[2]) for program in PROGRAMS
            if program.is_checked and is_there(program)]
    KEPT.write_text("\n".join(["# Bytes of text at -O2. Written by ./run bench compile --keep; checked by --check.", f"# {compiler_name()}",
                               *(f"{text}  {name}" for name, text in rows)]) + "\n")
    print(KEPT.read_text(), end="")


def add_options(parser):
    parser.add_argument("--runs", type=int, default=2, help="compilations of each program (2)")
    parser.add_argument("--programs", nargs="+", help="words of the names of some programs")
    parser.add_argument("--compilers", nargs="+", default=["g++", "clang++"])
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--keep", action="store_true")


def run(options):
    if options.check or options.keep:
        return (check if options.check else keep)(options)
    wanted = lambda name: not options.programs or any(word in name for word in options.programs)
    compilers = [compiler for compiler in options.compilers if shutil.which(compiler)]
    table = Table("", *(f"{compiler}: {what}" for compiler in compilers for what in ("seconds", "ratio", "text, kB", "peak, MB")), numbers_from=1)

    for program in PROGRAMS:
        if wanted(program.name) and is_there(program):
            cells = []
            for compiler in compilers:
                seconds, ratio, text, megabytes = measure_beside_first(options, compiler, program)
                cells += [f"{seconds:.1f}", f"{ratio:.1f}", f"{text / 1000:.0f}", f"{megabytes:.0f}"]
            table.add(program.name, *cells)
    versions = ", ".join(subprocess.run([c, "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0] for c in compilers)
    table.note(f"At -O2, without a compiler cache. {versions}.")
    publish(options, table, DOCUMENT)
    return 0
