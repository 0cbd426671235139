"""Finds the comments, docstrings and strings of a source file, with their places.

A block is a run of consecutive lines that hold one comment or docstring and nothing else:
    Block(kind, first, prefixes, lines)
`first` is the number of its first line, from 0; `prefixes[i] + lines[i]` is line first + i of the
file.
"""

import ast
import dataclasses
import pathlib
import re


@dataclasses.dataclass
class Block:
    kind: str  # "///", "//", "#" or "docstring"
    first: int
    prefixes: list
    lines: list
    is_file_header: bool = False


@dataclasses.dataclass
class Source:
    blocks: list
    trailing: list  # (line, column of the mark, text after the mark): comments behind code
    strings: list  # (line, text)


CPP = {".hpp", ".cpp", ".h", ".inc"}
HASH = {".cmake", ".sh", ".txt"}


def language_of(path):
    """"cpp", "python", "hash", "markdown", or None where nothing is read."""
    path = pathlib.Path(path)
    if path.suffix in CPP:
        return "cpp"
    if path.suffix == ".py":
        return "python"
    if path.suffix == ".md":
        return "markdown"
    if path.suffix in {".cmake", ".sh"} or path.name in {"CMakeLists.txt", "run", ".clang-tidy"}:
        return "hash"
    return None


def source_of(path, text):
    """The comments, docstrings and strings of C++, Python, CMake and shell files."""
    language = language_of(path)
    if language == "cpp":
        return cpp_source(text)
    if language == "python":
        return python_source(text)
    return hash_source(text)


CPP_TOKEN = re.compile(
    r"""(?P<raw>(?:u8|[uUL])?R"(?P<delimiter>[^()\s\\"]*)\(.*?\)(?P=delimiter)")"""
    r"""|(?P<string>"(?:\\.|[^"\\\n])*")"""
    r"""|(?P<line>//(?:\\\n|[^\n])*)"""
    r"""|(?P<block>/\*.*?\*/)"""
    r"""|(?P<number>\b\d(?:'?[\w.])*)"""
    r"""|(?P<char>'(?:\\.|[^'\\\n])+')""",
    re.DOTALL,
)


def cpp_source(text):
    lines = text.split("\n")
    starts = line_starts(lines)
    full, trailing, strings = {}, [], []
    line = 0
    for match in CPP_TOKEN.finditer(text):
        while line + 1 < len(starts) and starts[line + 1] <= match.start():
            line += 1
        column = match.start() - starts[line]
        if match.lastgroup == "string" or match.group("string"):
            strings.append((line, match.group()[1:-1]))
        elif match.group("raw"):
            strings.append((line, match.group()))
        elif match.group("line") is not None:
            mark = re.match(r"//[/!]?<?", match.group()).group()
            if "\n" in match.group():
                continue
            if lines[line][:column].strip():
                trailing.append((line, column, match.group()[len(mark):].strip()))
            else:
                full[line] = (lines[line][: column + len(mark)], mark)
    return Source(group(lines, full, {t[0]: t[1] for t in trailing}), trailing, strings)


def line_starts(lines):
    starts, at = [], 0
    for line in lines:
        starts.append(at)
        at += len(line) + 1
    return starts


def group(lines, full, trailing_columns):
    """Runs of full-line comments with one prefix; not those that continue a comment behind code."""
    blocks = []
    continued = None
    for number in range(len(lines)):
        if number in trailing_columns:
            continued = trailing_columns[number]
        if number not in full:
            if number not in trailing_columns:
                continued = None
            continue
        prefix, mark = full[number]
        if continued is not None and len(prefix) - len(mark) == continued:
            continue
        continued = None
        rest = lines[number][len(prefix):]
        last = blocks[-1] if blocks else None
        if last and last.first + len(last.lines) == number and last.prefixes[0] == prefix:
            last.prefixes.append(prefix)
            last.lines.append(rest)
        else:
            kind = "///" if mark.startswith("///") or mark.startswith("//!") else mark
            blocks.append(Block(kind, number, [prefix], [rest], number == 0))
    return blocks


def python_source(text):
    """Comments by tokens; docstrings by the syntax tree. Text that does not parse has neither."""
    import io
    import tokenize

    lines = text.split("\n")
    full, trailing = {}, []
    try:
        tree = ast.parse(text)
        tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    except (SyntaxError, tokenize.TokenError):
        return Source([], [], [])
    for token in tokens:
        if token.type != tokenize.COMMENT or token.string.startswith("#!"):
            continue
        line, column = token.start[0] - 1, token.start[1]
        if lines[line][:column].strip():
            trailing.append((line, column, token.string[1:].strip()))
        else:
            full[line] = (lines[line][: column + 1], "#")
    blocks = group(lines, full, {t[0]: t[1] for t in trailing})
    for node in ast.walk(tree):
        if not isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) or ast.get_docstring(node) is None:
            continue
        value = node.body[0].value
        first, last = value.lineno - 1, value.end_lineno - 1
        opening = re.match(r'\s*[rR]?"""', lines[first])
        if not opening:
            continue
        indent = re.match(r"\s*", lines[first]).group()
        prefixes, rest = [opening.group()], [lines[first][opening.end():]]
        for line in lines[first + 1 : last + 1]:
            prefix = indent if line.startswith(indent) else ""
            prefixes.append(prefix)
            rest.append(line[len(prefix):])
        blocks.append(Block("docstring", first, prefixes, rest))
    return Source(sorted(blocks, key=lambda block: block.first), trailing, [])


def hash_source(text):
    lines = text.split("\n")
    full = {}
    for number, line in enumerate(lines):
        match = re.match(r"\s*#(?=\s|$)", line)
        if match:
            full[number] = (match.group(), "#")
    return Source(group(lines, full, {}), [], [])
