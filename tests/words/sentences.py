"""Brings Markdown to one sentence a line. Code, tables, HTML, formulas set apart, headings and
quotations keep their lines."""

import dataclasses
import re

ABBREVIATIONS = {
    "e.g.", "i.e.", "etc.", "cf.", "vs.", "fig.", "figs.", "eq.", "eqs.", "sec.", "no.", "nos.", "p.", "pp.", "vol.", "ch.",
    "al.", "approx.", "resp.", "incl.", "ed.", "eds.", "ref.", "refs.", "thm.",
}
LIST = re.compile(r"(\s*)([-*+]|\d{1,9}[.)])(\s+)(?=\S)")
FENCE = re.compile(r"\s*(```+|~~~+)")
OTHER_BLOCK = re.compile(r"\s*(#{1,6}\s|\||<|>|\$\$|\[[^\]]+\]:\s|(?:[-*_]\s*){3,}$|=+\s*$|([-*+]|\d{1,9}[.)])\s*$)")
# A sentence must not begin with these on a line of its own: they would begin another block.
BLOCK_START = re.compile(r"([-*+]\s|\d{1,9}[.)](\s|$)|#{1,6}\s|\||<|>|\$\$|=+$|```|~~~)")
END = re.compile(r"""[.?!][)\]}"'”’*_`]*$""")
START = re.compile(r"""\[|[("'“‘*_{!]*[A-Z0-9À-ÖØ-ÞΑ-Ω`$\\]""")


def split_sentences(text):
    """The sentences of one paragraph without line breaks."""
    sentences = cut(text, heed_brackets=True)
    return sentences if sentences is not None else cut(text, heed_brackets=False)


def cut(text, heed_brackets):
    """None where brackets do not match."""
    sentences, begin, depth, at = [], 0, 0, 0
    while at < len(text):
        c = text[at]
        if c == "`":
            ticks = re.match(r"`+", text[at:]).group()
            close = re.compile(r"(?<!`)" + ticks + r"(?!`)").search(text, at + len(ticks))
            at = close.end() if close else at + len(ticks)
            continue
        if c == "$":
            close = text.find("$", at + 1)
            at = close + 1 if close > 0 else at + 1
            continue
        if c == "<" and text.startswith("<!--", at):
            close = text.find("-->", at)
            at = close + 3 if close > 0 else at + 4
            continue
        if c in "([{":
            depth += 1
        elif c in ")]}":
            depth -= 1
            if depth < 0 and heed_brackets:
                return None
        elif c == " " and (depth == 0 or not heed_brackets) and ends_sentence(text[begin:at], text[at + 1 :]):
            sentences.append(text[begin:at])
            begin = at + 1
        at += 1
    if depth != 0 and heed_brackets:
        return None
    return [*sentences, text[begin:]]


def ends_sentence(before, after):
    if not END.search(before) or not START.match(after) or BLOCK_START.match(after):
        return False
    # A run-in heading, or the mark of a list inside an item.
    if re.fullmatch(r"\*\*[^*]*\*\*|\d+[.)]", before):
        return False
    word = before.rsplit(" ", 1)[-1].lstrip("([{\"'“‘*_")
    if word.lower() in ABBREVIATIONS or word.endswith("..."):
        return False
    return True


@dataclasses.dataclass
class Paragraph:
    """Lines begin to end of the page; what stands before its first line, and before the others."""

    begin: int
    end: int
    head: str
    indentation: str


def paragraphs(lines):
    found, number = [], 0
    levels = [0]  # the indentations at which the text of open list items goes on
    blank = True
    while number < len(lines):
        line = lines[number]
        indent = len(line) - len(line.lstrip())
        if not line.strip():
            blank = True
            number += 1
            continue
        fence = FENCE.match(line)
        if fence:
            number += 1
            while number < len(lines) and not re.match(r"\s*" + re.escape(fence.group(1)), lines[number]):
                number += 1
            number += 1
            continue
        if number == 0 and line.strip() == "---":  # the settings of a form
            number = next((k + 1 for k in range(1, len(lines)) if lines[k].strip() == "---"), 1)
            continue
        if line.lstrip().startswith("$$"):
            if line.count("$$") < 2:
                number += 1
                while number < len(lines) and "$$" not in lines[number]:
                    number += 1
            number += 1
            continue
        if line.lstrip().startswith("<!--"):
            while number < len(lines) and "-->" not in lines[number]:
                number += 1
            number += 1
            blank = False
            continue
        if line.lstrip().startswith("<"):  # until an empty line, as CommonMark has it
            while number < len(lines) and lines[number].strip():
                number += 1
            continue
        item = LIST.match(line)
        if not item and OTHER_BLOCK.match(line):
            blank = False
            number += 1
            continue
        levels = [level for level in levels if level <= indent] or [0]
        if indent >= levels[-1] + 4 and blank:  # code by indentation
            number += 1
            continue
        if item:
            levels.append(item.end())
            head, indentation = item.group(), " " * item.end()
        else:
            head, indentation = line[:indent], line[:indent]
        end = number + 1
        while end < len(lines) and lines[end].strip():
            text = lines[end]
            if LIST.match(text) or FENCE.match(text) or OTHER_BLOCK.match(text):
                break
            end += 1
        if end < len(lines) and re.fullmatch(r"(=+|-+)\s*", lines[end]):  # a heading by its underline
            number = end + 1
            continue
        found.append(Paragraph(number, end, head, indentation))
        blank = False
        number = end
    return found


def sentence_lines(paragraph, lines):
    """The lines of a paragraph with one sentence each; forced line breaks stay."""
    parts, part = [], []
    for k in range(paragraph.begin, paragraph.end):
        line = lines[k][len(paragraph.head) :] if k == paragraph.begin else lines[k]
        part.append(line.strip())
        if k + 1 < paragraph.end and (line.endswith("  ") or line.endswith("\\")):
            parts.append((" ".join(part), "  " if line.endswith("  ") else ""))
            part = []
    parts.append((" ".join(part), ""))
    result = []
    for text, end in parts:
        sentences = split_sentences(text)
        sentences[-1] += end
        result += sentences
    return [(paragraph.indentation if k else paragraph.head) + line for k, line in enumerate(result)]


def differing_paragraphs(text):
    """(number of the first line, new lines) of each paragraph that is not one sentence a line."""
    lines = text.split("\n")
    for paragraph in paragraphs(lines):
        new = sentence_lines(paragraph, lines)
        if new != lines[paragraph.begin : paragraph.end]:
            yield paragraph, new


def one_sentence_a_line(text):
    lines = text.split("\n")
    for paragraph, new in reversed(list(differing_paragraphs(text))):
        lines[paragraph.begin : paragraph.end] = new
    return "\n".join(lines)
