#!/usr/bin/env python3
"""Checks every scene below a folder, and renders a small picture of each that is understood.

A line for each file, counts by folder and by reason at the end, and a page with the pictures:
FOLDER of --out, index.html.

Usage: wild.py PROGRAM FOLDER [--only PATTERN] [--out OUT] [--lenient] [--pictures N] [--size WxH]
               [--iterations N] [--seconds LIMIT] [--jobs N] [--max-memory BYTES]
               [--reference NAME] [--silhouettes]

--only '*/glTF/*' takes the files alone whose path below FOLDER matches. --pictures 0 checks alone.
--reference TungstenRender.exr compares each picture with the image of that name beside its scene,
an .exr, in a size 8 times smaller (means of 8 x 8 pixels): the line then holds the trimmed relMSE
and the ratio of the means.

--silhouettes compares contours alone: every picture that a Manifest.json names (as those of the
glTF-Asset-Generator do) with the first hits from the camera stated there, at the start of an
animation. A line for each model holds the share of the pixels on our contour that are within 2
pixels of an edge in that picture. Needs numpy and PIL.

understood  no error; with a picture: rendered, exit code 0
in part     errors, but a picture with --lenient
refused     errors
older       glTF 1.0, pbrt-v2 or v3
incomplete  a file that the scene names is not there (rendered with --lenient all the same)
no scene    no triangle
failed      a crash, exit code 1, or --seconds exceeded
blank       a picture of one colour
"""

import argparse
import collections
import concurrent.futures
import fnmatch
import html
import json
import pathlib
import re
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile
import time

ENDINGS = {".pbrt", ".gltf", ".glb"}
# What a file lacks is not what the program lacks: a scene without triangles, a part of a scene, a
# file that is not there.
NO_SCENE = re.compile(r"holds no triangle|points and lines alone|no WorldBegin|must stand after WorldBegin|holds no shape")
INCOMPLETE = re.compile(r"is missing: check its name")
OLDER = re.compile(r"this is a file of glTF 1|(is|scene) of pbrt-v[23]")
VERDICTS = ("understood", "in part", "refused", "failed", "blank", "older", "incomplete", "no scene")


class Outcome:
    def __init__(self, file):
        self.file = file
        self.verdict = "understood"
        self.reasons = []
        self.seconds = 0.0
        self.picture = None
        self.comparison = ""


def scenes_below(folder, pattern):
    found = [file for file in folder.rglob("*") if file.suffix.lower() in ENDINGS and file.is_file()]
    found = [file for file in found if fnmatch.fnmatch(str(file.relative_to(folder)), pattern)]
    # A part that another file includes is no scene of its own.
    return sorted(file for file in found if file.suffix.lower() != ".pbrt" or b"WorldBegin" in file.read_bytes())


def run(arguments, limit):
    start = time.monotonic()
    try:
        done = subprocess.run(arguments, capture_output=True, timeout=limit, text=True, errors="replace")
        return done.returncode, done.stdout, done.stderr, time.monotonic() - start
    except subprocess.TimeoutExpired:
        return None, "", "", time.monotonic() - start


def reasons_of(output, error):
    lines = [line.split("error: ", 1)[1] for line in output.splitlines() if "error: " in line]
    return lines or [error.strip().splitlines()[-1] if error.strip() else "no reason"]


def check(options, file):
    outcome = Outcome(file)
    memory = ["--max-memory", options.max_memory] if options.max_memory else []
    code, output, error, outcome.seconds = run([options.program, "--check", *memory, str(file)], options.seconds)
    if code is None:
        outcome.verdict, outcome.reasons = "failed", [f"took more than {options.seconds} seconds"]
    elif code < 0 or code == 1:
        outcome.verdict, outcome.reasons = "failed", [f"exit code {code}: {error.strip()[-200:]}"]
    elif code != 0:
        outcome.reasons = reasons_of(output, error)
        outcome.verdict = "refused"
        if all(NO_SCENE.search(reason) for reason in outcome.reasons):
            outcome.verdict = "no scene"
        elif any(OLDER.search(reason) for reason in outcome.reasons):
            outcome.verdict = "older"
        elif all(INCOMPLETE.search(reason) or NO_SCENE.search(reason) for reason in outcome.reasons):
            outcome.verdict = "incomplete"
    return outcome


def is_blank(pixels):
    """All pixels of a .pfm are the same, or nearly so."""
    values = sorted(pixels)
    return values[-1] - values[0] <= 0.02 * max(abs(values[-1]), 1e-6)


def floats_of(file):
    import array

    data = file.read_bytes()
    header = data.split(b"\n", 3)
    values = array.array("f")
    values.frombytes(header[3][: len(header[3]) // 4 * 4])
    return values


def size_of(exr):
    """Width and height of an .exr, from its data window."""
    head = exr.read_bytes()[:4096]
    at = head.find(b"dataWindow\0box2i\0")
    left, top, right, bottom = struct.unpack_from("<4i", head, at + 21)
    return right - left + 1, bottom - top + 1


def render(options, number, outcome):
    picture = options.out / f"{number:04d}.png"
    values = options.out / f"{number:04d}.pfm"
    arguments = [options.program, str(outcome.file), "--iterations", str(options.iterations), "--quiet"]
    arguments += ["--lenient"] if options.lenient else []
    arguments += ["--max-memory", options.max_memory] if options.max_memory else []
    reference = outcome.file.parent / options.reference
    statistics = options.out / f"{number:04d}.json"
    if options.reference and reference.is_file():
        width, height = size_of(reference)
        factor = next(n for n in (8, 10, 5, 4, 2, 1) if width % n == 0 and height % n == 0)
        arguments += ["--size", f"{width // factor}x{height // factor}"]
        arguments += ["--reference", str(reference), "--stats", str(statistics)]
    else:
        arguments += ["--size", options.size]
    code, _, error, outcome.seconds = run([*arguments, "--out", str(picture), "--out", str(values)], options.seconds)
    if code == 0:
        outcome.picture = picture.name
        if is_blank(floats_of(values)):
            outcome.verdict, outcome.reasons = "blank", ["the picture is of one colour"]
        elif outcome.verdict == "refused":
            outcome.verdict = "in part"
        if statistics.is_file():
            difference = json.loads(statistics.read_text())["error"]
            outcome.comparison = f"relMSE {difference['relmse_trimmed']:.3g}, mean {difference['ratio_of_means']:.3g} times"
    elif code != 2:  # 2: not understood, --lenient or not
        outcome.verdict = "failed"
        outcome.reasons = [error.strip()[-300:] or f"took more than {options.seconds} seconds"]
    elif outcome.verdict == "understood":
        outcome.verdict, outcome.reasons = "failed", ["--check accepts it, rendering does not: " + error.strip()[-200:]]
    values.unlink(missing_ok=True)


def without_names(reason):
    return re.sub(r'"[^"]*"|[^\s"]*/[^\s"]*|\d+', "*", reason)


def write_page(options, outcomes):
    cells = []
    for outcome in outcomes:
        name = html.escape(str(outcome.file.relative_to(options.folder)))
        image = f'<img src="{outcome.picture}" loading="lazy">' if outcome.picture else ""
        reason = html.escape("; ".join(([outcome.comparison] if outcome.comparison else []) + outcome.reasons[:3]))
        cells.append(f"<figure>{image}<figcaption><b>{outcome.verdict}</b> {name}<br><small>{reason}</small></figcaption></figure>")
    style = "body{font:14px sans-serif}figure{display:inline-block;width:200px;vertical-align:top;margin:6px;word-wrap:break-word}img{width:200px}"
    (options.out / "index.html").write_text(
        f"<!doctype html><meta charset=utf-8><title>{html.escape(str(options.folder))}</title><style>{style}</style>" + "\n".join(cells))


def camera_at(position):
    """A node that looks at the origin from there, the transform column by column."""
    length = sum(x * x for x in position) ** 0.5
    back = [x / length for x in position]
    flat = (back[0] ** 2 + back[2] ** 2) ** 0.5
    right = [back[2] / flat, 0, -back[0] / flat]
    up = [back[1] * right[2], back[2] * right[0] - back[0] * right[2], -back[1] * right[0]]
    return {"camera": 0, "matrix": [*right, 0, *up, 0, *back, 0, *position, 1]}


def silhouettes(options):
    try:
        import numpy
        from PIL import Image
    except ImportError as error:
        sys.exit(f"wild.py: --silhouettes: {sys.executable} has no {error.name} (Debian: python3-numpy, python3-pil)")

    def near(mask, radius):
        """True within this distance of a pixel that is."""
        (height, width), steps = mask.shape, range(-radius, radius + 1)
        padded = numpy.pad(mask, radius, "edge")
        disk = [(y + radius, x + radius) for y in steps for x in steps if x * x + y * y <= radius * radius]
        return numpy.any([padded[y:y + height, x:x + width] for y, x in disk], axis=0)

    def share(picture, copy, camera):
        """None without a contour."""
        scene = json.loads(copy.read_text())
        # The field of view of Babylon.js, which made the pictures.
        scene["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 1, "znear": 0.01}}]
        for material in scene.get("materials", []):
            if material.get("alphaMode") == "BLEND":  # a surface by chance would have holes
                del material["alphaMode"]
        nodes = scene.setdefault("nodes", [])
        for node in nodes:
            node.pop("camera", None)
        nodes.append(camera_at(camera["translation"]))
        for part in scene.setdefault("scenes", [{}]):
            part.setdefault("nodes", []).append(len(nodes) - 1)
        copy.write_text(json.dumps(scene))
        theirs = numpy.asarray(Image.open(picture).convert("RGB"), float)
        height, width = theirs.shape[:2]
        sky, out = copy.with_name("sky.pfm"), copy.with_name("first_hits.pfm")
        sky.write_bytes(b"PF\n2 1\n-1\n" + struct.pack("<6f", *[1000] * 6))  # brighter than what shines
        arguments = ["--size", f"{width}x{height}", "--integrator", "pt", "--max-depth", "1", "--iterations", "8", "--at", "0"]
        arguments += ["--sky", str(sky), "--lenient", "--quiet", "--out", str(out)]
        code, _, error, _ = run([options.program, str(copy), *arguments], options.seconds)
        if code != 0:
            raise RuntimeError(error.strip()[-150:] or "no picture in time")
        ours = numpy.asarray(floats_of(out)).reshape(height, width, 3)[::-1].min(axis=2) < 999
        contour = ours & near(~ours, 1)
        steps = [abs(numpy.diff(theirs, axis=axis, append=theirs.take([-1], axis))).max(axis=2) for axis in (0, 1)]
        return near(numpy.maximum(*steps) > 14, 2)[contour].mean() if contour.any() else None

    shares = {}
    for manifest in sorted(options.folder.rglob("Manifest.json")):
        group = json.loads(manifest.read_text())
        if isinstance(group, list):  # of the groups below, which have their own
            continue
        with tempfile.TemporaryDirectory() as scratch:
            folder = shutil.copytree(manifest.parent, pathlib.Path(scratch) / "copy")
            for model in group["models"]:
                name, picture = model["fileName"], manifest.parent / model.get("sampleImageName", "-")
                if not fnmatch.fnmatch(name, options.only) or not picture.is_file():
                    continue
                try:
                    value = share(picture, folder / name, model["camera"])
                    print(f"no contour  {name}" if value is None else f"{value:10.1%}  {name}", flush=True)
                    shares.update({name: value} if value is not None else {})
                except RuntimeError as error:
                    print(f"not read    {name}  {error}", flush=True)
    if not shares:
        sys.exit(f"wild.py: no pictures with cameras below {options.folder}")
    low = sorted((value, name) for name, value in shares.items() if value < 0.9)
    print(f"\n{len(shares)} contours, mean {statistics.fmean(shares.values()):.1%}, below 90 %: {len(low)}")
    for value, name in low:
        print(f"{value:10.1%}  {name}")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--only", default="*", metavar="PATTERN", help="files whose path below FOLDER matches")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/wild"))
    parser.add_argument("--lenient", action="store_true", help="render also what is understood in part")
    parser.add_argument("--pictures", type=int, default=-1, help="the largest number of pictures; all if it is not given")
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--iterations", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=120, help="most time for one file")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--max-memory", default="")
    parser.add_argument("--reference", default="", metavar="NAME", help="image beside each scene to compare with")
    parser.add_argument("--silhouettes", action="store_true", help="compare contours with pictures of stated cameras, and no more")
    options = parser.parse_args()
    if not options.folder.is_dir():
        sys.exit(f"wild.py: {options.folder} is no folder")
    if options.silhouettes:
        return silhouettes(options)
    options.out.mkdir(parents=True, exist_ok=True)

    files = scenes_below(options.folder, options.only)
    outcomes, number = [], 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for outcome in pool.map(lambda file: check(options, file), files):
            outcomes.append(outcome)
            rendered = ("understood", "refused", "incomplete") if options.lenient else ("understood",)
            if outcome.verdict in rendered and (options.pictures < 0 or number < options.pictures):
                render(options, number, outcome)  # one after the other: the program uses all cores itself
                number += 1
            name, reasons = outcome.file.relative_to(options.folder), "; ".join(outcome.reasons[:2])
            print(f"{outcome.verdict:10}  {outcome.seconds:6.1f} s  {name}  {outcome.comparison}  {reasons}", flush=True)
    print()
    by_folder = collections.defaultdict(collections.Counter)
    for outcome in outcomes:
        kind = "pbrt" if outcome.file.suffix.lower() == ".pbrt" else "glTF"
        parts = outcome.file.relative_to(options.folder).parts
        by_folder[(kind, parts[0] if len(parts) > 1 else ".")][outcome.verdict] += 1
        by_folder[(kind, "all")][outcome.verdict] += 1
    print(f"| kind | folder | {' | '.join(VERDICTS)} | accepted |\n|{' --- |' * (len(VERDICTS) + 3)}")
    for (kind, folder), counts in sorted(by_folder.items()):
        accepted = counts["understood"] + counts["in part"]
        whole = accepted + counts["refused"] + counts["failed"] + counts["blank"]
        share = f"{100 * accepted / whole:.0f} %" if whole else "–"
        print(f"| {kind} | {folder} | {' | '.join(str(counts[name]) for name in VERDICTS)} | {share} |")
    print()
    reasons = collections.Counter(reason for o in outcomes if o.verdict != "understood" for reason in set(map(without_names, o.reasons)))
    for reason, count in reasons.most_common(40):
        print(f"{count:5}  {reason[:160]}")
    write_page(options, outcomes)
    print(f"\nThe pictures: {options.out}/index.html")
    return 1 if any(o.verdict in ("failed", "blank") for o in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
