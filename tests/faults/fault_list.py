"""The list of faults, and how one is planted in the text of a header.

A line is a fault:

    SYMBOL/NAME: tokens «old → new» tokens

In the function or class SYMBOL (`follow`, `CameraSubpath::follow`, or `follow@camera_subpath.hpp`
where several headers have one), wherever in include/gmis that stands, `old` becomes `new` between
the tokens on both sides. Tokens decide: whitespace, line breaks and comments do not matter. The
sequence must stand there once. Without `old` something is added, without `new` left out.

A line `@ TEST …` says which tests are to catch the faults below it, the nearest first. Below `@`
alone those are tried whose sources include the header and that include least else.
"""

import dataclasses
import pathlib
import re
import sys

from tokens import Scopes, tokens_of

FAULTS = pathlib.Path(__file__).resolve().parent / "faults.txt"


@dataclasses.dataclass
class Fault:
    name: str
    tests: list
    before: list
    old: list
    new: str
    after: list
    text: str = ""  # as the list has it
    number: int = 0
    line: int = 0

    @property
    def symbol(self):
        return self.name.rsplit("/", 1)[0].partition("@")[0]

    @property
    def header(self):
        return self.name.rsplit("/", 1)[0].partition("@")[2]


def words_of(text):
    return [token.text for token in tokens_of(text)]


def read_faults(path=FAULTS):
    faults, tests, names = [], [], set()
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if line.startswith("@"):
            tests = line[1:].split()
        elif line.strip() and not line.startswith("#"):
            found = re.fullmatch(r"(\S+/[\w-]+): (.*?)«(.*?) ?→ ?(.*?)»(.*)", line)
            if not found:
                sys.exit(f"{path}:{number}: this is no fault: SYMBOL/NAME: tokens «old → new» tokens")
            if found[1] in names:
                sys.exit(f"{path}:{number}: two faults are called {found[1]}")
            names.add(found[1])
            faults.append(Fault(found[1], tests, words_of(found[2]), words_of(found[3]), found[4], words_of(found[5]), line, len(faults) + 1, number))
    return faults


@dataclasses.dataclass
class Place:
    """Where a fault is planted: from token `first` on, before token `last`."""

    header: object
    first: int
    last: int

    def range(self):
        """In characters."""
        tokens = self.header.tokens
        if self.first == self.last:
            start = tokens[self.first - 1].end
            return start, start
        return tokens[self.first].start, tokens[self.last - 1].end

    def planted(self, new):
        start, end = self.range()
        return self.header.text[:start] + " " + new + " " + self.header.text[end:]


def place_of(fault, headers):
    """The place of a fault; or None and why there is none."""
    of_name = [header for name, header in headers.items() if not fault.header or name == fault.header or name.endswith("/" + fault.header)]
    if fault.header and not of_name:
        return None, f"there is no header {fault.header}"
    # A function that has moved to another class is found by its own name.
    for symbol in (fault.symbol, fault.symbol.rsplit("::", 1)[-1]):
        words = fault.before + fault.old + fault.after
        found = [(header, first) for header in of_name for first in header.positions(words, symbol)]
        if found:
            break
    if not found:
        known = any(header.scopes_called(fault.symbol) for header in of_name)
        return None, f"its tokens are no longer in {fault.symbol}" if known else f"there is no {fault.symbol}"
    if len(found) > 1:
        return None, f"its tokens are {len(found)} times in {symbol}"
    header, first = found[0]
    first += len(fault.before)
    return Place(header, first, first + len(fault.old)), ""


# --- Mechanical faults ----------------------------------------------------------------------------

FLIPS = {"+": "-", "-": "+", "*": "/", "/": "*", "<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||", "||": "&&",
         "forward": "reverse", "reverse": "forward", "radiance": "importance", "importance": "radiance", "to_prev": "to_next", "to_next": "to_prev",
         "true": "false", "false": "true", "geometric_normal": "shading_normal", "shading_normal": "geometric_normal", "min": "max", "max": "min",
         "sin": "cos", "cos": "sin", "++": "--", "--": "++"}


def mutations(header, symbol):
    """Mechanical faults of a function: one token for its opposite, a factor of 1.01, a statement
    left out, a condition negated."""
    for scope in header.scopes_called(symbol):
        if not scope.body:
            continue
        words, begin = header.words, scope.body[0] + 1
        statement = begin  # the first token of the statement
        for i in range(begin, scope.body[1]):
            word = words[i]
            if word in FLIPS and not (word in "<>" and angle_brackets(words, i)) and words[i - 1] not in ("operator", "::"):
                yield i, i + 1, FLIPS[word], f"{word} → {FLIPS[word]}"
            elif word in ("return", "=") and words[i + 1] not in ("{", ";"):
                end = i + 1
                while words[end] != ";" and end < scope.body[1]:
                    end = closing(words, end) + 1 if words[end] in "([{" else end + 1
                text = header.text[header.tokens[i + 1].start:header.tokens[end - 1].end]
                if "*" in words[i + 1:end] or "/" in words[i + 1:end]:
                    yield i + 1, end, f"gmis_fault::scaled({text})", "× 1.01"
            elif word == "if" and words[i + 1] == "(":
                close = closing(words, i + 1)
                text = header.text[header.tokens[i + 2].start:header.tokens[close - 1].end]
                if "=" not in words[i + 2:close] and ";" not in words[i + 2:close]:
                    yield i + 2, close, f"!({text})", "condition negated"
            if word == ";" or word in "{}":
                if word == ";" and is_dropped_alone(words[statement:i]):
                    yield statement, i, "", "statement left out"
                statement = i + 1


def angle_brackets(words, i):
    """Whether a < or > is probably of template arguments: a name stands before it, and no sum or
    number around."""
    return words[i - 1] in ("static_cast", "vector", "optional", "array", "span", "numeric_limits") or words[i + 1] in ("(", ">", "::", "{")


def closing(words, i):
    depth = 0
    for k in range(i, len(words)):
        depth += words[k] in "([{"
        depth -= words[k] in ")]}"
        if depth == 0:
            return k
    return len(words) - 1


def is_dropped_alone(statement):
    """Calls and assignments; declarations and what returns is needed to compile."""
    if not statement or statement[0] in ("return", "const", "auto", "if", "else", "for", "while", "static_assert", "using", "case", "default", "break"):
        return False
    return statement[-1] == ")" and statement[0].isidentifier() and len(statement) > 1 and statement[1] in ("(", ".", "::", "->") or any(
        sign in statement for sign in ("+=", "-=", "*=", "/=", "++", "--"))
