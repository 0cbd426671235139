#!/usr/bin/env python3
"""Renders the built-in scenes, and makes a page of the pictures with what each cost: time, error,
plan.

Every figure comes from the statistics that gmis-render writes. Usage: gallery.py PROGRAM [--time
SECONDS] [--width PIXELS] [--out FOLDER] [--docs]; --docs takes small pictures and a number of
iterations, so that they are the same on all machines, and writes them into docs/gallery.md, with
the pictures in docs/gallery/.
"""

import argparse
import html
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

PROJECT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(PROJECT / "bench"))
import figures  # noqa: E402

SCENES = PROJECT / "examples" / "scenes"
# Name, and what the picture needs besides the options that all have.
PICTURES = [
    ("cornell", []),
    ("paper1", []),
    ("paper2", []),
    ("paper3", []),
    ("paper4", []),
    ("studio", []),
    ("tinted", ["--exposure", "1", "--tone", "filmic"]),
    ("metals", ["--tone", "filmic"]),
    ("shade", ["--exposure", "2", "--tone", "filmic"]),
    ("leaves", ["--exposure", "0.5", "--tone", "filmic"]),
]


def film_size(text):
    return [int(re.search(rf'"integer {axis}resolution" \[?\s*(\d+)', text).group(1)) for axis in "xy"]


def time_words(seconds):
    return f"{seconds:.1f} s" if seconds < 90 else f"{seconds / 60:.1f} min"


def error_words(estimate):
    error = estimate["relative_error"]
    if not error:
        return "not known"
    words = f"{100 * error:.1f} %"
    if estimate["is_calibrated"]:
        lower, upper = estimate["interval"]
        return f"{words} ({100 * lower:.1f} to {100 * upper:.1f} %)"
    return words + ", without an interval: rare, bright samples rule it"


def render(program, folder, name, options, budget, width):
    text = (SCENES / f"{name}.pbrt").read_text()
    film_width, film_height = film_size(text)
    size = f"{width}x{round(width * film_height / film_width)}"
    exposure = [] if "--exposure" in options else ["--exposure", "0"]
    arguments = [name, "--size", size, *budget, *exposure, *options]
    files = ["--out", str(folder / f"{name}.png"), "--out", str(folder / f"{name}.exr"), "--stats", str(folder / f"{name}.json")]
    print("gmis-render", *arguments, file=sys.stderr, flush=True)
    subprocess.run([program, *arguments, *files, "--quiet"], check=True)
    facts = json.loads((folder / f"{name}.json").read_text())
    return {
        "name": name,
        "title": text.splitlines()[0].lstrip("# "),
        "command": "gmis-render " + " ".join(arguments),
        "size": size.replace("x", " × "),
        "time": f"{time_words(facts['seconds']['cpu'])} of processor time",
        "error": error_words(facts["estimate"]),
        "plan": facts["plan"],
        "iterations": facts["iterations"],
        "version": facts["version"],
    }


def page_of(pictures):
    cards = []
    for p in pictures:
        rows = "".join(
            f"<tr><th>{what}</th><td>{html.escape(str(value))}</td></tr>"
            for what, value in (
                ("size", p["size"]), ("time", p["time"]), ("iterations", p["iterations"]), ("relative error", p["error"]),
                ("plan", p["plan"]), ("command", p["command"]),
            )
        )
        cards.append(
            f'<section><img src="{p["name"]}.png" alt="{html.escape(p["title"])}"><div><h2>{p["name"]}</h2>'
            f'<p>{html.escape(p["title"])}</p><table>{rows}</table><p><a href="{p["name"]}.exr">{p["name"]}.exr</a></p></div></section>'
        )
    style = (
        "body{font:15px/1.4 sans-serif;margin:2em auto;max-width:70em;padding:0 1em;background:#fff;color:#222}"
        "section{display:flex;gap:1.5em;margin:0 0 2em}img{width:24em;align-self:flex-start}h2{margin:0}"
        "th{text-align:left;vertical-align:top;padding-right:1em;white-space:nowrap}"
    )
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>gmis: gallery</title><style>{style}</style>'
        f"<h1>Gallery</h1><p>gmis-render {pictures[0]['version']}; integrator auto. The error is that of the whole picture, "
        "estimated without a reference, with its interval of 95 % where it has one.</p>" + "".join(cards) + "</html>\n"
    )


def markdown_of(pictures):
    lines = [f"The built-in scenes, {pictures[0]['iterations']} iterations each.", ""]
    for p in pictures:
        lines += [
            f"## {p['name']}",
            "",
            f"![{p['title']}](gallery/{p['name']}.png)",
            "",
            p["title"],
            f"{p['size']} pixels in {p['time']}; relative error {p['error']}.",
            f"By {p['plan']}.",
            "",
        ]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--time", type=float)
    parser.add_argument("--width", type=int)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/gallery"))
    parser.add_argument("--docs", action="store_true")
    options = parser.parse_args()
    budget = ["--iterations", "128"] if options.docs else ["--time", f"{options.time or 30:g}"]
    width = options.width or (104 if options.docs else 480)
    # Relative where it can be, because a picture keeps its command line as a note.
    os.chdir(PROJECT)
    options.out.mkdir(parents=True, exist_ok=True)
    pictures = [render(options.program, options.out, name, extra, budget, width) for name, extra in PICTURES]
    page = options.out / "gallery.html"
    page.write_text(page_of(pictures))
    print(page)
    if options.docs:
        folder = PROJECT / "docs" / "gallery"
        folder.mkdir(exist_ok=True)
        for p in pictures:
            shutil.copy(options.out / f"{p['name']}.png", folder)
        figures.put("gallery", "./run gallery --docs", markdown_of(pictures), PROJECT / "docs" / "gallery.md")


if __name__ == "__main__":
    main()
