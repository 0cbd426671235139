"""Wraps the paragraphs of comments and docstrings, and leaves everything else of a file as it is.

A paragraph is filled anew where one of its lines is longer than the limit. Lists, tables, code,
drawings (lines with an indentation or with gaps of their own), commands such as `\\file` and rules
keep their lines.
"""

import dataclasses
import re

from text_blocks import source_of

LIMIT = 100

FENCE = re.compile(r"\s*(```|~~~)")
BEGIN = re.compile(r"\s*[@\\](code|verbatim|f\[|f\{|dot|msc)")
END = re.compile(r"\s*[@\\](endcode|endverbatim|f\]|f\}|enddot|endmsc)")
LIST = re.compile(r"(\s*)([-*+]|\d+[.)])(\s+)(?=\S)")
KEPT = re.compile(
    r"\s*(\||#!|[@\\](file|name|section|subsection|page|defgroup|addtogroup|ingroup|anchor|cond|endcond|\{|\})"
    r"|Usage:|NOLINT|clang-format |IWYU|shellcheck |SPDX|[-=~*_#\"+]{3,})"
)
COMMAND = re.compile(r"\s*[@\\](param|tparam|return|returns|retval|brief|note|warning|throws|see|sa|pre|post)\b")
GAP = re.compile(r"\S {2,}\S")
# A line must not begin with these: it would read as a list, a heading, a table, a quotation, a
# command.
NOT_FIRST = re.compile(r"([-*+>|=#]+|\d+[.)]|#\S*|\|.*|[@\\](?!f\$)\w.*)$")


def tokens_of(text):
    """The words of a text; a code span, and what may not stand at the beginning of a line, stay
    with their neighbours."""
    words = []
    for match in re.finditer(r"\S+", text):
        word = match.group()
        if words and (words[-1].count("`") % 2 == 1 or NOT_FIRST.match(word)):
            words[-1] += " " + word
        else:
            words.append(word)
    return words


def fill(words, first_width, width):
    """Lines of words: the first of at most `first_width` characters, the others of at most
    `width`."""
    lines, room = [], first_width
    for word in words:
        if lines and len(lines[-1]) + 1 + len(word) <= room:
            lines[-1] += " " + word
        else:
            if lines:
                room = width
            lines.append(word)
    return lines


@dataclasses.dataclass
class Paragraph:
    """Lines begin to end of a block; the indentation of the first line, and of the others."""

    begin: int
    end: int
    first: int
    further: int


def indent_of(line):
    return len(line) - len(line.lstrip())


def is_kept(line):
    return not line.strip() or FENCE.match(line) or BEGIN.match(line) or KEPT.match(line) or GAP.search(line)


def paragraphs(lines):
    """The runs of lines that may be filled anew."""
    base = min((indent_of(line) for line in lines if line.strip()), default=0)
    found, number, in_code = [], 0, False
    hanging = base  # where the text of the list item at hand goes on
    while number < len(lines):
        line, indent = lines[number], indent_of(lines[number])
        if in_code or is_kept(line):
            if FENCE.match(line) or (BEGIN.match(line) and not in_code) or (END.match(line) and in_code):
                in_code = not in_code
            number += 1
            continue
        item = LIST.match(line)
        if not item and indent not in (base, hanging):
            number += 1
            continue
        hanging = item.end() if item else indent
        end = number + 1

        def goes_on(text):
            return not is_kept(text) and not LIST.match(text) and not COMMAND.match(text)

        if (item or COMMAND.match(line)) and end < len(lines) and goes_on(lines[end]) and indent_of(lines[end]) > indent:
            hanging = indent_of(lines[end])
        while end < len(lines) and goes_on(lines[end]) and indent_of(lines[end]) == hanging:
            end += 1
        found.append(Paragraph(number, end, indent, hanging))
        number = end
    return found


def next_prefix_of(block, number):
    """The prefix of the line after `number`, also where there is none: without the quotation mark
    of a docstring."""
    if block.kind == "docstring" and number == 0:
        return re.match(r"\s*", block.prefixes[0]).group()
    return block.prefixes[number]


def wrapped(path, text):
    """The text of a C++, Python, CMake or shell file with its comments wrapped."""
    lines = text.split("\n")
    for block in reversed(source_of(path, text).blocks):
        for k, line in enumerate(block.lines):
            spare = len(block.prefixes[k]) + len(line) - LIMIT
            if spare > 0 and re.search(r"-{%d}$" % (spare + 3), line):  # a rule behind a title
                lines[block.first + k] = lines[block.first + k][:-spare]
        for paragraph in reversed(paragraphs(block.lines)):
            old = block.lines[paragraph.begin : paragraph.end]
            prefix, next_prefix = block.prefixes[paragraph.begin], next_prefix_of(block, paragraph.begin)
            if all(len(p) + len(line) <= LIMIT for p, line in zip(block.prefixes[paragraph.begin :], old)):
                continue
            item = LIST.match(old[0])
            marker = item.group(2) + item.group(3) if item else ""
            words = tokens_of(" ".join([old[0][paragraph.first + len(marker) :], *old[1:]]))
            head = prefix + " " * paragraph.first + marker
            indentation = next_prefix + " " * paragraph.further
            filled = fill(words, LIMIT - len(head), LIMIT - len(indentation))
            lines[block.first + paragraph.begin : block.first + paragraph.end] = [
                (indentation if k else head) + line for k, line in enumerate(filled)
            ]
    return "\n".join(lines)
