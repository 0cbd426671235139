#!/usr/bin/env python3
"""The lines and branches of include/ that the tests run: reads the counts of programs built with
--coverage.

Usage: coverage.py BUILD-FOLDER [OUTPUT-FOLDER]

Asks gcov about every program part that ran and adds the counts up: a line of a template runs when
it runs in any instantiation, and a branch is taken when it is in any. Branches that only an
exception takes are left out. Prints the share of each header that is not wholly run, and the total;
OUTPUT-FOLDER/lines.txt has the lines that never run.
"""

import collections
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys

PROJECT = pathlib.Path(__file__).resolve().parents[2]


def counts_of(data):
    """{header: {line: (count, [taken, …])}} of one .gcda file."""
    command = ["gcov", "--json-format", "--branch-probabilities", "--stdout", str(data)]
    answer = subprocess.run(command, capture_output=True, text=True, cwd=data.parent)
    headers = {}
    for text in answer.stdout.splitlines():
        if not text.startswith("{"):
            continue
        answer_of_part = json.loads(text)
        compiled_in = pathlib.Path(answer_of_part["current_working_directory"])
        for file in answer_of_part["files"]:
            path = pathlib.Path(os.path.normpath(compiled_in / file["file"]))
            if not path.is_relative_to(PROJECT / "include"):
                continue
            lines = headers.setdefault(str(path.relative_to(PROJECT / "include")), {})
            for line in file["lines"]:
                taken = [branch["count"] > 0 for branch in line["branches"] if not branch["throw"]]
                count, before = lines.get(line["line_number"], (0, []))
                lines[line["line_number"]] = (count + line["count"], merge(before, taken))
    return headers


def merge(a, b):
    """Branch by branch; instantiations that have more of them keep theirs."""
    longer, shorter = (a, b) if len(a) >= len(b) else (b, a)
    return [taken or (i < len(shorter) and shorter[i]) for i, taken in enumerate(longer)]


def ranges(numbers):
    """5, 7-9"""
    runs = []
    for number in sorted(numbers):
        if runs and number == runs[-1][1] + 1:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    return ", ".join(str(first) if first == last else f"{first}-{last}" for first, last in runs)


def percent(part, whole):
    return f"{100 * part / whole:6.1f} %" if whole else "     – "


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    output = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else "out/coverage")
    data = sorted(build.rglob("*.gcda"))
    if not data:
        sys.exit(f"coverage: nothing has run in {build}")
    headers = collections.defaultdict(dict)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 2) as pool:
        for part in pool.map(counts_of, data):
            for header, lines in part.items():
                for number, (count, taken) in lines.items():
                    before = headers[header].get(number, (0, []))
                    headers[header][number] = (before[0] + count, merge(before[1], taken))

    report, totals = [], [0, 0, 0, 0]
    for header, lines in sorted(headers.items()):
        missing = [number for number, (count, _) in lines.items() if count == 0]
        branches = [taken for _, all_taken in lines.values() for taken in all_taken]
        figures = [len(lines) - len(missing), len(lines), sum(branches), len(branches)]
        totals = [a + b for a, b in zip(totals, figures)]
        report.append(f"{header:42} {percent(*figures[:2])} {percent(*figures[2:])}  {ranges(missing)}")
    report.append(f"{'all of include/':42} {percent(*totals[:2])} {percent(*totals[2:])}  "
                  f"{totals[0]} of {totals[1]} lines, {totals[2]} of {totals[3]} branches")
    output.mkdir(parents=True, exist_ok=True)
    (output / "lines.txt").write_text("header                                        lines  branches  lines that never run\n"
                                      + "\n".join(report) + "\n")
    print("\n".join(line for line in report if " 100.0 %" not in line[42:52]))


if __name__ == "__main__":
    main()
