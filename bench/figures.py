#!/usr/bin/env python3
"""Makes the tables of the documents anew, and tells which of them are older than their sources.

Usage: figures.py [NAME...]        runs the commands of these figures, or of all
       figures.py --stale [--quiet]   lists the figures whose sources have changed since
       figures.py --check             marks, registry and quoted values fit together
       figures.py --values            takes the values that sentences quote from their tables anew
       figures.py --confirm COMMIT    keeps the figures that were measured with the sources of a
                                      commit, where its program and that of now do the same work
                  [--but SCENE...]    in all other scenes: tables that name these are not kept
                                      where only runs differ that choose their counts: figures
                                      that have no such run are kept

A figure stands between two marks that name its command. Behind them stand a stamp and a small line
for the reader:

    <!-- samplers: written by ./run bench samplers -->
    | scene | squared error |
    ...
    <!-- end of samplers -->
    <!-- stamp of samplers: digest 0123456789ab; commit 0123456; 2026-11-24 -->
    <sub>Measured at commit 0123456 on 2026-11-24 by `./run bench samplers`.</sub>

The digest is one of the sources that bench/figures.ini names for the figure, without comments and
white space: words may change, code may not. A sentence quotes a cell of a table by figure, row and
column; the first cells of a row, joined by " / ", name it:

    it falls to <!-- value samplers: geometric mean: squared error -->0.73<!-- /value --> of that

Programs that measure call `put(name, command, text)`, which writes table and stamp.

A table of numbers outside of such marks is a fault, unless the line before it says why it has none:

    <!-- no measurement: worked out from the layout -->
    <!-- measured once: commit 0123456, 2026-11-24 -->
"""

import argparse
import concurrent.futures
import configparser
import contextlib
import dataclasses
import datetime
import fcntl
import hashlib
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import time

PROJECT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(PROJECT / "tests/words"))
from sentences import one_sentence_a_line  # noqa: E402

SUFFIXES = {".hpp", ".cpp", ".py", ".sh", ".cmake", ".txt", ".ini", ".pbrt", ".gltf", ".json", ".pfm", ".png"}

BEGIN = re.compile(r"<!-- (?P<name>[^:>]+): written by (?P<command>[^>]+?) -->\n")
STAMP = (
    r"(?:<!-- stamp of {name}: digest (?P<digest>\w+);(?: measured (?P<measured>\w+);)? commit (?P<commit>[\w+]+); (?P<date>[\d-]+) -->\n<sub>[^\n]*</sub>\n?)?"
)
VALUE = re.compile(r"<!-- value (?P<figure>[^:>]+): (?P<row>[^>]+?): (?P<column>[^:>]+?) -->(?P<text>.*?)<!-- /value -->")
NUMBER = re.compile(r"[-+−~<±]?\d*\.?\d[\d.,]*(?:e[-+−]?\d+)?(?: ?(?:[%×]|[nµm]?s|[kMG]?B|± ?[\d.e-]+))*")
EXEMPT = re.compile(r"<!-- (?:no measurement|measured once): [^>]*\w[^>]* -->")
CPP_NOISE = re.compile(r'(R"(?P<d>[^()\s]*)\(.*?\)(?P=d)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\')|//[^\n]*|/\*.*?\*/', re.DOTALL)


@dataclasses.dataclass
class Figure:
    """One figure of a page; digest, commit and date are None where it has no stamp. `measured`: the
    digest at its commit where it has been confirmed since."""

    page: pathlib.Path
    name: str
    command: str
    body: str
    start: int
    body_start: int
    body_end: int
    end: int
    digest: str
    commit: str
    date: str
    measured: str


def figures_in(page, text):
    """The figures of a page, in its order."""
    found = []
    for begin in BEGIN.finditer(text):
        name = begin.group("name")
        mark = f"<!-- end of {name} -->"
        body_end = text.find(mark, begin.end())
        if body_end < 0:
            raise ValueError(f"{page}: the figure {name} has no end")
        after = body_end + len(mark)
        if text[after : after + 1] == "\n":
            after += 1
        stamp = re.compile(STAMP.format(name=re.escape(name))).match(text, after)
        found.append(
            Figure(page, name, begin.group("command"), text[begin.end() : body_end], begin.start(), begin.end(), body_end, after if not stamp.group() else stamp.end(), stamp.group("digest"), stamp.group("commit"), stamp.group("date"), stamp.group("measured"))
        )
    return found


def cells_of(line):
    return [re.sub(r"[*`]", "", cell).strip() for cell in line.strip().strip("|").split("|")]


def value_in(body, row, column):
    """The cell of a table by the name of its row and of its column; None where there is none."""
    head = None
    for line in body.split("\n"):
        if not line.startswith("|"):
            head = None
            continue
        cells = cells_of(line)
        if head is None:
            head = cells
        elif column in head and any(" / ".join(cells[:k]) == row for k in range(1, len(cells))):
            return cells[head.index(column)]
    return None


def is_of_numbers(rows):
    """Whether at least half of the rows of a table have a number in a cell beyond the first."""
    return 2 * sum(any(NUMBER.fullmatch(cell) for cell in cells_of(row)[1:]) for row in rows) >= len(rows) > 0


def unmarked_tables(text):
    """The lines, from 1 on, of a page at which tables of numbers begin that have neither marks nor
    a reason why not."""
    is_marked, start, lines = False, None, [*text.split("\n"), ""]
    for k, line in enumerate(lines):
        if BEGIN.match(line + "\n"):
            is_marked = True
        elif line.startswith("<!-- end of "):
            is_marked = False
        if line.startswith("|") and not is_marked:
            start = k if start is None else start
        elif start is not None:
            if is_of_numbers(lines[start + 2 : k]) and not EXEMPT.fullmatch(lines[start - 1]):
                yield start + 1
            start = None


def minutes_since(begun):
    return f"{(time.monotonic() - begun) / 60:.1f} minutes"


@contextlib.contextmanager
def alone_with(file):
    """Waits until no other process is alone with a file. The file itself does not change."""
    with open(file, "rb") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        yield


class Project:
    """The pages of a project and the registry of their figures."""

    def __init__(self, root=PROJECT):
        self.root = root
        self.registry = configparser.ConfigParser(interpolation=None)
        self.registry.read(root / "bench" / "figures.ini", encoding="utf-8")

    def pages(self):
        return [*sorted(self.root.glob("*.md")), *sorted((self.root / "docs").glob("*.md"))]

    def figures(self):
        return [figure for page in self.pages() for figure in figures_in(page, page.read_text(encoding="utf-8"))]

    def minutes(self, name):
        return self.registry.getfloat(name, "minutes", fallback=0.0)

    def takes_one_processor(self, name):
        return self.registry.get(name, "processors", fallback="all") == "1"

    def lacks(self, name):
        """Says why the command of a figure cannot run here; None where it can."""
        variable = self.registry.get(name, "argument", fallback=None)
        if variable and not os.environ.get(variable):
            return f"set {variable} to its argument"
        program = self.registry.get(name, "needs", fallback=None)
        return f"install {program}" if program and not shutil.which(program) else None

    def sources(self, name):
        """The files that a figure depends on, its groups resolved; a word that begins with - takes
        its files out again."""
        found = set()
        for word in self.registry.get(name, "sources", fallback="").split():
            if word.startswith("@"):
                found.update(self.sources(word))
            elif word.startswith("-"):
                found -= self.files(word[1:])
            else:
                found |= self.files(word)
        return sorted(found)

    def files(self, pattern):
        """The sources that a pattern names, or that lie below a folder that it names."""
        found = (p for path in self.root.glob(pattern) for p in (path.rglob("*") if path.is_dir() else [path]))
        return {p for p in found if p.is_file() and p.suffix in SUFFIXES and "__pycache__" not in p.parts}

    def digest(self, name, below="."):
        """Digest of the sources of a figure below a folder, without comments and white space."""
        result = hashlib.sha256()
        for path in self.sources(name):
            if not path.is_relative_to(self.root / below):
                continue
            text = path.read_text(encoding="utf-8", errors="replace")
            if path.suffix in {".hpp", ".cpp"}:
                text = CPP_NOISE.sub(lambda match: match.group(1) or " ", text)
            elif path.suffix not in {".json", ".gltf"}:
                text = re.sub(r"^\s*#.*$", "", text, flags=re.MULTILINE)
            result.update(str(path.relative_to(self.root)).encode() + b"\0" + "".join(text.split()).encode() + b"\0")
        return result.hexdigest()[:12]

    def commit(self):
        """The commit at hand, with a + where something is not committed."""
        def git(*arguments):
            return subprocess.run(["git", "-C", str(self.root), *arguments], capture_output=True, text=True).stdout.strip()

        head = git("rev-parse", "--short=7", "HEAD") or "unknown"
        return head + ("+" if git("status", "--porcelain", "--untracked-files=no", "--", "include", "examples", "bench") else "")

    def stamp(self, name, command, measured=None):
        """The two lines behind a figure that was measured now; or at an earlier digest, commit and
        date, from where to now instructions have this ratio (`measured`)."""
        now, date, before, still = self.commit(), datetime.date.today().isoformat(), "", ""
        commit = now
        if measured:
            digest, commit, date, ratios = measured
            before = f" measured {digest};"
            still = f"; commit {now} makes the same pictures with {ratios} times the instructions"
        return (
            f"<!-- stamp of {name}: digest {self.digest(name)};{before} commit {commit}; {date} -->\n"
            f"<sub>Measured at commit {commit} on {date} by `{command}`{still}.</sub>\n"
        )

    def put(self, page, name, command, body=None, measured=None):
        """Writes a figure and its stamp into a page; the same body with a new stamp where none is
        given. `measured`: as in `stamp`."""
        with alone_with(self.root / "bench" / "figures.ini"):
            text = page.read_text(encoding="utf-8")
            figure = next((figure for figure in figures_in(page, text) if figure.name == name), None)
            if not figure:
                return False
            body = figure.body if body is None else one_sentence_a_line(body if body.endswith("\n") else body + "\n")
            marks = f"<!-- {name}: written by {command} -->\n{body}<!-- end of {name} -->\n"
            new = page.with_suffix(".new")  # who reads the page meanwhile finds all of it
            new.write_text(text[: figure.start] + marks + self.stamp(name, command, measured) + text[figure.end :], encoding="utf-8")
            new.replace(page)
            return True

    def state(self, figure):
        """None for a figure of the present sources, else why it is not."""
        if figure.digest is None:
            return "without a stamp: its age is not known"
        if figure.digest != self.digest(figure.name):
            return f"from commit {figure.commit}, {figure.date}: its sources have changed"
        return None

    def confirmable(self, before, but=(), only_fixed=False):
        """The stale figures that were measured with the sources of `before`, the project at a
        commit, and hold now if its program does the same work (`confirm` in the registry). A figure
        that is confirmed again is compared with the sources that it was measured with. `but`:
        scenes in which the programs differ; a figure that names one of them is not among them.
        `only_fixed`: only figures for which the registry has `confirm = fixed counts`."""
        allowed = {"fixed counts"} if only_fixed else {"yes", "fixed counts"}
        return [
            figure
            for figure in self.figures()
            if self.state(figure)
            and self.registry.get(figure.name, "confirm", fallback="no") in allowed
            and not any(re.search(rf"\b{scene}\b", figure.body) for scene in but)
            and self.digest(figure.name, "bench") == before.digest(figure.name, "bench")
            and (figure.measured or figure.digest) == before.digest(figure.name)
        ]

    def confirm(self, figures, ratios):
        """Stamps `confirmable` figures anew, and returns their names. `ratios`: of the instructions
        now to those then, as text."""
        for figure in figures:
            measured = figure.measured or figure.digest
            self.put(figure.page, figure.name, figure.command, measured=(measured, figure.commit, figure.date, ratios))
        return [figure.name for figure in figures]

    def take_values(self, write):
        """The quoted values that differ from their tables; takes the tables' where `write` is
        set."""
        bodies = {figure.name: figure.body for figure in self.figures()}
        faults = []
        for page in self.pages():
            text = page.read_text(encoding="utf-8")

            def replaced(match):
                body, (row, _, rest) = bodies.get(match["figure"], ""), match["row"].rpartition(": ")
                value = value_in(body, match["row"], match["column"]) or value_in(body, row, f"{rest}: {match['column']}")
                where = f"{page.relative_to(self.root)}:{text.count(chr(10), 0, match.start()) + 1}"
                what = f"{match['figure']}: {match['row']}: {match['column']}"
                if value is None:
                    faults.append(f"{where}: no value {what}")
                    return match.group()
                if text[: match.start()].endswith("\n"):
                    faults.append(f"{where}: a line must not begin with a value: Markdown would take it for HTML")
                if value != match["text"]:
                    if not write:
                        faults.append(f"{where}: the text says {match['text']}, the table {value} ({what})")
                    return match.group().replace(f"-->{match['text']}<!--", f"-->{value}<!--")
                return match.group()

            new = VALUE.sub(replaced, text)
            if write and new != text:
                page.write_text(new, encoding="utf-8")
        return faults

    def check(self):
        """Faults of marks, registry and values, and tables without marks."""
        faults = [
            f"{page.relative_to(self.root)}:{line}: a table of numbers without marks: which command writes it?"
            for page in self.pages()
            for line in unmarked_tables(page.read_text(encoding="utf-8"))
        ]
        figures = self.figures()
        for figure in figures:
            where = figure.page.relative_to(self.root)
            if not self.registry.has_section(figure.name):
                faults.append(f"{where}: {figure.name} has no section in bench/figures.ini")
            elif not self.sources(figure.name):
                faults.append(f"{where}: {figure.name} depends on no file (bench/figures.ini)")
        names = [figure.name for figure in figures]
        faults += [f"{name}: stands in more than one page" for name in sorted(set(names)) if names.count(name) > 1]
        for section in self.registry.sections():
            if not section.startswith("@") and section not in names:
                faults.append(f"bench/figures.ini: {section} stands in no page")
        return faults + self.take_values(write=False)

    def run(self, names):
        """Runs the commands of figures, each once: first those that take all processors, cheapest
        first, then those that take one (`processors = 1` in the registry), longest first and as
        many at a time as there are processors. False where one failed or could not run."""
        begun = time.monotonic()
        figures = [figure for figure in self.figures() if not names or figure.name in names]
        unknown = set(names) - {figure.name for figure in figures}
        if unknown:
            print(f"figures: no figure {', '.join(sorted(unknown))}; there are {', '.join(f.name for f in self.figures())}", file=sys.stderr)
            return False
        commands = {}
        for figure in figures:
            commands.setdefault(figure.command, []).append(figure)
        lacking = {command: lack for command, of_command in commands.items() if (lack := self.lacks(of_command[0].name))}
        for command, lack in lacking.items():  # before hours of work
            print(f"figures: {command}: skipped, {lack}", file=sys.stderr, flush=True)
            del commands[command]
        by_minutes = sorted(commands.values(), key=lambda of_command: self.minutes(of_command[0].name))
        beside = [of_command for of_command in reversed(by_minutes) if self.takes_one_processor(of_command[0].name)]
        good = [self.run_command(of_command) for of_command in by_minutes if of_command not in beside]
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as lanes:
            good += lanes.map(lambda of_command: self.run_command(of_command, is_beside=len(beside) > 1), beside)
        print(f"figures: all took {minutes_since(begun)}", file=sys.stderr, flush=True)
        faults = self.take_values(write=True)
        for fault in faults:
            print(fault, file=sys.stderr)
        return all(good) and not faults and not lacking

    def run_command(self, figures, is_beside=False):
        """Runs the command of figures; false where it failed, could not run or left one out. With
        `is_beside` others run meanwhile, and what it prints comes when it has ended."""
        command, arguments = figures[0].command, shlex.split(figures[0].command)
        variable = self.registry.get(figures[0].name, "argument", fallback=None)
        arguments += shlex.split(os.environ[variable]) if variable else []
        print(f"figures: {command} (about {self.minutes(figures[0].name):g} minutes)", file=sys.stderr, flush=True)
        begun = time.monotonic()
        ended = subprocess.run(arguments, cwd=self.root, text=True, **({"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT} if is_beside else {}))
        if ended.stdout:
            print(f"figures: {command}:\n{ended.stdout}", end="", flush=True)
        print(f"figures: {command} took {minutes_since(begun)}", file=sys.stderr, flush=True)
        if ended.returncode != 0:
            print(f"figures: {command} failed", file=sys.stderr)
            return False
        stale = {figure.name for figure in self.figures() if self.state(figure)}
        for figure in figures:
            if figure.name in stale:
                print(f"figures: {command} did not write {figure.name}", file=sys.stderr)
        return not any(figure.name in stale for figure in figures)


def digests(project=None):
    """The digests of the sources of all figures."""
    project = project or Project()
    return {figure.name: project.digest(figure.name) for figure in project.figures()}


def put(name, command, text, document=None):
    """Writes a figure and its stamp between its marks in whichever page has them, or in `document`.
    False where there are none."""
    project = Project()
    pages = [pathlib.Path(document)] if document else project.pages()
    return any([project.put(page, name, command, text) for page in pages])


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stale", action="store_true")
    parser.add_argument("--quiet", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--values", action="store_true")
    parser.add_argument("--confirm", metavar="COMMIT")
    parser.add_argument("--but", metavar="SCENE", nargs="+", default=[])
    parser.add_argument("names", nargs="*")
    options = parser.parse_args(arguments)
    project = Project()
    if options.stale:
        figures = project.figures()
        states = [(figure, project.state(figure)) for figure in figures]
        for figure, state in states:
            if state:
                print(figure.name if options.quiet else f"{figure.page.relative_to(project.root)}: {figure.name}: {state} ({figure.command})")
        if not options.quiet:
            print(f"{sum(1 for _, state in states if state)} of {len(figures)} figures are stale")
        return 0
    if options.confirm:
        import same_work  # which imports this file

        out = project.root / "out" / "figures"
        with same_work.checkout(options.confirm, project.root, out / "before") as before:
            if not project.confirmable(Project(before), options.but):
                print(f"figures: no stale figure that can be kept was measured with the sources of {options.confirm}", file=sys.stderr)
                return 1
            found, ratios = same_work.differences(before, project.root, out, options.but)
            for scene, run, what in found:
                print(f"figures: {scene} {run}: {what}", file=sys.stderr)
            if any(run not in same_work.CHOOSING for _, run, _ in found):
                print("figures: the programs differ: measure anew", file=sys.stderr)
                return 1
            kept = project.confirm(project.confirmable(Project(before), options.but, only_fixed=bool(found)), ratios)
            print(f"{ratios} of the instructions; kept: " + (", ".join(kept) or "none, for all have runs that choose their counts"))
        return 0
    if options.check or options.values:
        faults = project.check() if options.check else project.take_values(write=True)
        for fault in faults:
            print(fault)
        print(f"{len(project.figures())} figures, {len(faults)} faults")
        return 1 if faults else 0
    return 0 if project.run(options.names) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
