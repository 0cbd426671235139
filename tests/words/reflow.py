#!/usr/bin/env python3
"""Wraps comments and docstrings at 100 columns and brings Markdown to one sentence a line.

Usage: reflow.py [--check] [FILE...]   (without files: those that git knows)

The words of every file stay, and so does their order: a file whose words would change is an error.
"""

import pathlib
import re
import subprocess
import sys

from sentences import one_sentence_a_line
from text_blocks import language_of, source_of
from wrap import wrapped

PROJECT = pathlib.Path(__file__).resolve().parents[2]


def project_files():
    """The files that git knows, and those that it does not ignore."""
    command = ["git", "-C", str(PROJECT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, capture_output=True)
    if listed.returncode != 0:
        sys.exit(f"git lists no files here, so comments and words are left alone: {listed.stderr.decode().strip()}")
    names = listed.stdout.decode().split("\0")
    files = [PROJECT / name for name in names if name and language_of(name)]
    return sorted({file for file in files if file.is_file() and not file.is_symlink()})


def reflowed(path, text):
    if language_of(path) == "markdown":
        return one_sentence_a_line(text)
    return wrapped(path, text)


def words_of(path, text):
    """The words of the file without the marks of its comments: reflowing must not change them. The
    length of a rule is no word."""
    if language_of(path) == "markdown":
        return text.split()
    lines = text.split("\n")
    for block in source_of(path, text).blocks:
        for k, line in enumerate(block.lines):
            opening = '"""' if '"""' in block.prefixes[k] else ""
            lines[block.first + k] = opening + line
    return re.sub(r"-{4,}", "---", "\n".join(lines)).split()


def main(arguments):
    check = "--check" in arguments
    names = [name for name in arguments if name != "--check"]
    changed, files = [], [pathlib.Path(name) for name in names] or project_files()
    for path in files:
        text = path.read_text(encoding="utf-8")
        new = reflowed(path, text)
        if new == text:
            continue
        if words_of(path, new) != words_of(path, text) or reflowed(path, new) != new:
            print(f"{path}: not reflowed: its words would change, or it would change again", file=sys.stderr)
            return 1
        changed.append(path)
        if not check:
            path.write_text(new, encoding="utf-8")
    for path in changed if check else []:
        print(f"{path}: ./run format would wrap it anew")
    print(f"{len(files)} files, {len(changed)} {'to wrap' if check else 'wrapped'} anew")
    return 1 if check and changed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
