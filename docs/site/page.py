#!/usr/bin/env python3
"""A page of docs/ as Doxygen reads it: formulas, headings with names, links between pages, and the
like of GitHub.

Usage: page.py FILE.md   (writes to standard output; called by Doxygen)
"""
import pathlib
import re
import sys

page = pathlib.Path(sys.argv[1])
root = pathlib.Path(__file__).resolve().parents[2]


def name_of(path):
    return "page_" + path.stem.lower().replace("-", "_")


def slug_of(heading):
    """The name that GitHub gives a heading."""
    text = re.sub(r"[`*]|\[|\]\([^)]*\)", "", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def anchor(path, slug):
    return f"{name_of(path)}_{slug}".replace("-", "_")


def link(match):
    text, target = match.group(1), match.group(2)
    if "://" in target:
        return match.group(0)
    file, _, slug = target.partition("#")
    path = (page.parent / file).resolve() if file else page.resolve()
    if path.suffix == ".md":
        return f'@ref {anchor(path, slug) if slug else name_of(path)} "{text.replace("`", "")}"'
    # A file of the project that is no page has no place in the site.
    return text


def inline(text):
    """Text outside of fenced blocks, code spans left as they are."""
    parts = re.split(r"(`[^`]*`)", text)
    text = "".join(part if part.startswith("`") else formulas(part) for part in parts)
    return re.sub(r"(?<!!)\[([^\]]*)\]\(([^)\s]+)\)", link, text)


def formulas(text):
    text = re.sub(r"\$\$(.+?)\$\$", r"\\f[\1\\f]", text, flags=re.DOTALL)
    return re.sub(r"\$([^$]+)\$", r"\\f$\1\\f$", text)


title_seen = False


def headed(text):
    """Headings with the names that links use; the title with the name of the page."""
    global title_seen
    lines = []
    for line in text.split("\n"):
        heading = re.match(r"(#+) (.*)", line)
        if heading and not title_seen:
            title_seen = True
            lines.append(f"# {heading.group(2)} {{#{name_of(page)}}}\n")
            if page.resolve().parent == root / "docs":
                lines.append("[TOC]\n")
        elif heading:
            title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.group(2)).replace("`", "")
            lines.append(f"{heading.group(1)} {title} {{#{anchor(page, slug_of(heading.group(2)))}}}")
        else:
            lines.append(line)
    return "\n".join(lines)


for number, part in enumerate(re.split(r"^```", page.read_text(encoding="utf-8"), flags=re.MULTILINE)):
    if number % 2 == 0:
        sys.stdout.write(headed(inline(part)))
        continue
    language, _, code = part.partition("\n")
    sys.stdout.write(("```{.%s}" % language if language in ("cpp", "cmake", "sh") else "```") + "\n" + code + "```")
