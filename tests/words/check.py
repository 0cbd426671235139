#!/usr/bin/env python3
"""Checks words and widths: comments, docstrings, Markdown, messages, commit subjects.

Usage: check.py [--counts] [--commits BASE | --no-commits] [--subject FILE] [FILE...]

Prints file:line, what is wrong and the better form, and the counts at the end; fails where anything
was found. Without files: those that git knows. `--counts` prints the counts alone. `--subject`
checks one commit message and nothing else, for a hook. Commit subjects are checked since BASE: by
default the last release, or else FIRST_BASE.
"""

import argparse
import collections
import pathlib
import re
import subprocess
import sys

from reflow import PROJECT, project_files
from sentences import differing_paragraphs
from sentences import paragraphs as markdown_paragraphs
from text_blocks import language_of, source_of

COMMENT_LIMIT, CODE_LIMIT, SUBJECT_LIMIT = 100, 120, 72
HERE = pathlib.Path(__file__).resolve().parent
# Not prose of this project, or planted on purpose.
EXEMPT = {"tests/words/self_check.py", "tests/words/patterns.txt"}
# Older subjects were written before the rule.
FIRST_BASE = "bff2631c9fc7877468ba247452bf3b3802359c70"
SUBJECT = re.compile(r"[\w./+-]+(, ?[\w./+-]+)*: \S")


class Pattern:
    """One record of patterns.txt."""

    def __init__(self, fields):
        self.text, self.where = fields["pattern"], fields["where"]
        self.reason, self.better = fields["reason"], fields["better"]
        spaced = re.sub(r"(?<!\?) ", r"\\s+", self.text.replace("(?<=[.;:] )", "(?<=[.;:]\\s)"))
        self.regex = re.compile(spaced, re.IGNORECASE if self.where == "text" and "(?<=" not in self.text else 0)


def read_patterns(path=HERE / "patterns.txt"):
    """The records of the file, in its order."""
    found = []
    for record in re.split(r"\n\s*\n", path.read_text(encoding="utf-8")):
        lines = [line for line in record.split("\n") if line.strip() and not line.startswith("#")]
        if lines:
            found.append(Pattern({key: value for key, value in (line.split(": ", 1) for line in lines)}))
    return found


def without_code(text):
    """The text with code spans, links' targets and formulas blanked, of the same length."""

    def blank(match):
        return re.sub(r"[^\n]", "\u00b7", match.group())

    return re.sub(r"(`+)[^`]+?\1|\]\([^)\s]*\)|\$[^$\n]+\$|https?://\S+", blank, text)


class Checker:
    def __init__(self, patterns):
        self.patterns = patterns
        self.findings = []  # (file, line from 1, kind, message)

    def add(self, path, line, kind, message):
        self.findings.append((path, line + 1, kind, message))

    def phrases(self, path, first, text):
        """Looks for the patterns of prose in a text that begins in line `first`."""
        shown = without_code(text)
        for pattern in self.patterns:
            if pattern.where != "text":
                continue
            for match in pattern.regex.finditer(shown):
                line = first + shown.count("\n", 0, match.start())
                words = " ".join(match.group().split())
                self.add(path, line, f"phrase {pattern.text}", f'"{words}": {pattern.reason}. Better: {pattern.better}')

    def opening(self, path, line, text):
        """Looks at the first words of a docstring."""
        shown = text.strip()
        for pattern in self.patterns:
            if pattern.where == "docstring" and pattern.regex.match(shown):
                words = " ".join(shown.split()[:6])
                self.add(path, line, f"opening {pattern.text}", f'"{words} …": {pattern.reason}. Better: {pattern.better}')

    def source(self, path, text):
        """A file of C++, Python, CMake or shell."""
        source = source_of(path, text)
        lines = text.split("\n")
        for block in source.blocks:
            for k, line in enumerate(block.lines):
                width = len(block.prefixes[k]) + len(line)
                breakable = len(line.split()) > 1
                if width > COMMENT_LIMIT and breakable and not line.lstrip().startswith("|"):
                    self.add(path, block.first + k, "width of comments", f"{width} columns; comments have at most {COMMENT_LIMIT}")
            body = "\n".join(line.strip() for line in block.lines)
            if block.kind in ("///", "docstring"):
                self.opening(path, block.first, re.sub(r"^\\file\s*", "", body.strip()))
            self.phrases(path, block.first, body)
        commented = {block.first + k for block in source.blocks for k in range(len(block.lines))}
        trailing = {line for line, _, _ in source.trailing}
        for line, column, comment in source.trailing:
            if len(lines[line]) > CODE_LIMIT:
                self.add(path, line, "width of code", f"{len(lines[line])} columns; code and what stands behind it have at most {CODE_LIMIT}")
            if lines[line][column:].startswith("///"):
                self.opening(path, line, comment)
            self.phrases(path, line, comment)
        for line, string in source.strings:
            if " " in string:
                self.phrases(path, line, string)
        return commented | trailing

    def markdown(self, path, text):
        for paragraph, new in differing_paragraphs(text):
            count = paragraph.end - paragraph.begin
            self.add(path, paragraph.begin, "Markdown lines", f"{count} lines for {len(new)} sentences: one sentence a line (./run format)")
        lines = text.split("\n")
        for paragraph in markdown_paragraphs(lines):
            self.phrases(path, paragraph.begin, "\n".join(line.strip() for line in lines[paragraph.begin : paragraph.end]))

    def file(self, path, name, text):
        if name in EXEMPT:
            return
        if language_of(path) == "markdown":
            self.markdown(name, text)
        else:
            self.source(name, text)

    def subject(self, commit, subject):
        """One commit subject."""
        if len(subject) > SUBJECT_LIMIT:
            self.add(commit, 0, "commit subjects", f'"{subject}": {len(subject)} characters; at most {SUBJECT_LIMIT}')
        if not SUBJECT.match(subject):
            self.add(commit, 0, "commit subjects", f'"{subject}": write "area: what changed", with one word for the area')


def git(*arguments):
    result = subprocess.run(["git", "-C", str(PROJECT), *arguments], capture_output=True, text=True)
    return result.stdout.strip() if result.returncode == 0 else None


def base_of_commits():
    """The last release, or else the first base; None without a history."""
    tag = git("describe", "--tags", "--abbrev=0", "--match", "v[0-9]*")
    if tag:
        return tag
    return FIRST_BASE if git("cat-file", "-t", FIRST_BASE) == "commit" else None


def subjects_since(base):
    log = git("log", "--no-merges", "--format=%h\t%s", f"{base}..HEAD")
    return [line.split("\t", 1) for line in log.split("\n") if line] if log else []


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counts", action="store_true")
    parser.add_argument("--commits", metavar="BASE")
    parser.add_argument("--no-commits", action="store_true")
    parser.add_argument("--subject", type=pathlib.Path, metavar="FILE")
    parser.add_argument("files", nargs="*", type=pathlib.Path)
    options = parser.parse_args(arguments)

    checker = Checker(read_patterns())
    if options.subject:
        checker.subject("commit message", options.subject.read_text(encoding="utf-8").split("\n")[0])
    else:
        given = [path.resolve() for path in options.files]
        files = [f for f in project_files() if any(f.is_relative_to(g) for g in given if g.is_dir())]
        for full in files + [g for g in given if not g.is_dir()] if given else project_files():
            name = str(full.relative_to(PROJECT)) if full.is_relative_to(PROJECT) else str(full)
            checker.file(full, name, full.read_text(encoding="utf-8"))
        base = None if options.no_commits or options.files else options.commits or base_of_commits()
        for commit, subject in subjects_since(base) if base else []:
            checker.subject(commit, subject)

    counts = collections.Counter()
    for path, line, kind, message in sorted(checker.findings, key=lambda f: (f[0], f[1])):
        counts[kind] += 1
        if not options.counts:
            print(f"{path}:{line}: {message}")
    for kind, count in counts.most_common():
        print(f"{count:6d}  {kind}")
    print(f"{len(checker.findings):6d}  in all")
    return 1 if checker.findings else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
