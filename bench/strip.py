"""A strip of pictures at equal time, with their errors under them, as a table for the README.

Renders one scene with pt, vcm and auto, each for the same processor seconds on one thread. An error
is the product of the differences from two long runs of vcm, on all processors, with other seeds and
a quarter of its merging radius, so a sixteenth of its bias. The pictures go to docs/strip/, and
with default options the table between its marks in the document.

Usage: strip.py PROGRAM [options]   (--help lists them)
"""

import argparse
import hashlib
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import zlib

import errors
import figures
from measuring import read_pfm

PROJECT = pathlib.Path(__file__).resolve().parents[1]
CONTENDERS = [("pt", "path tracing"), ("vcm", "vertex connection and merging"), ("auto", "gmis chooses")]
COMMAND = "./run bench strip"


def write_png(ppm, file):
    """A text PPM of 8 bits as PNG."""
    _, width, height, _, *values = ppm.split()
    row = 3 * int(width)
    data = bytes(min(255, int(value)) for value in values)
    lines = b"".join(b"\0" + data[y * row : (y + 1) * row] for y in range(int(height)))

    def chunk(name, content):
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    header = struct.pack(">IIBBBBB", int(width), int(height), 8, 2, 0, 0, 0)
    png = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines, 9)) + chunk(b"IEND", b"")
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + png)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--scene", default="paper1")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--time", type=float, default=20)
    parser.add_argument("--reference-time", type=float, default=150)
    parser.add_argument("--first-render", metavar="PROGRAM", help="make the picture of examples/first_render.cpp, too")
    parser.add_argument("--document", type=pathlib.Path, help="write into this page alone")
    options = parser.parse_args()
    # Relative, because a picture keeps its command line as a note.
    os.chdir(PROJECT)
    folder, pictures = pathlib.Path("out/strip"), pathlib.Path("docs/strip")
    folder.mkdir(parents=True, exist_ok=True)
    pictures.mkdir(exist_ok=True)
    size = f"{options.size}x{options.size}"

    if options.first_render:
        result = subprocess.run([options.first_render], check=True, capture_output=True, text=True)
        write_png(result.stdout, pictures / "first_render.png")

    def run(integrator, seed, iterations, threads, more):
        statistics = folder / "statistics.json"
        arguments = [options.scene, "--size", size, "--integrator", integrator, "--seed", seed, "--threads", threads]
        arguments += ["--iterations", iterations, "--quiet", "--stats", statistics, *more]
        subprocess.run([options.program, *map(str, arguments)], check=True)
        return json.loads(statistics.read_text())

    def render(integrator, seed, seconds, threads, *more):
        """A run of the given processor seconds, within a tenth: the number of iterations is found
        by trying."""
        iterations = 4
        for _ in range(8):
            facts = run(integrator, seed, iterations, threads, more)
            ratio = seconds / facts["seconds"]["cpu"]
            if abs(ratio - 1) < 0.1 or (iterations == 1 and ratio < 1):
                break
            iterations = max(1, round(iterations * min(ratio, 16)))
        return facts

    file = pathlib.Path(f"examples/scenes/{options.scene}.pbrt")
    key = hashlib.sha256(f"{file.read_text()} {options.reference_time}".encode()).hexdigest()[:8]
    halves = [folder / f"{options.scene}_{size}_{key}_{half}.pfm" for half in "ab"]
    for seed, half in zip((1000001, 2000002), halves):
        if not half.exists():
            render("vcm", seed, options.reference_time / 2, os.cpu_count(), "--radius", 0.1, "--out", half)
    references = [read_pfm(half) for half in halves]

    cells = []
    for integrator, _ in CONTENDERS:
        picture = folder / f"strip_{integrator}.png"
        facts = render(integrator, 1, options.time, 1, "--out", picture, "--out", picture.with_suffix(".pfm"))
        shutil.copy(picture, pictures)
        cells.append(f"relMSE {errors.relmse(read_pfm(picture.with_suffix('.pfm')), references)[0]:.2g} in {facts['seconds']['cpu']:.1f} s")
    table = [
        "| " + " | ".join(f"`{integrator}`" for integrator, _ in CONTENDERS) + " |",
        "| " + " | ".join("---" for _ in CONTENDERS) + " |",
        "| " + " | ".join(f"![{words}](docs/strip/strip_{integrator}.png)" for integrator, words in CONTENDERS) + " |",
        "| " + " | ".join(cells) + " |",
        "",
        f"`{options.scene}`, {size} pixels, processor seconds of one thread.",
        "",
    ]
    print("\n".join(table))
    is_whole = all(getattr(options, name) == parser.get_default(name) for name in ("scene", "size", "time", "reference_time"))
    if is_whole and not figures.put("strip", COMMAND, "\n".join(table), options.document):
        print("no page has marks for the strip", file=sys.stderr)


if __name__ == "__main__":
    main()
