"""Shared by the benchmarks: the scenes, runs of gmis-render, its pictures, tables, documents,
counts of instructions."""

import array
import concurrent.futures
import hashlib
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import figures

OWN = ["all_glossy", "caustic_pool", "light_behind_glass", "many_lights", "mirror_hall", "mixed", "one_point_light", "open_sky",
       "slit"]
TEMPTING = ["all_narrow", "camera_in_water", "far_sun", "huge_ground", "keyhole", "none_narrow", "panes", "rare_caustic",
            "telephoto", "two_scales"]
BUILT_IN = ["cornell", "paper1", "paper2", "paper3", "paper4"]
# Name: the scene argument of gmis-render.
FOURTEEN = {name: name for name in BUILT_IN} | {name: f"bench/scenes/{name}.pbrt" for name in OWN}
# Scenes of other renderers, with their pictures, of 128x128 pixels and paths of at most 10
# segments.
FOREIGN = {name: f"tests/program/reference/{name}.pbrt" for name in ("svcm0", "svcm1", "tung1", "tung2")}
TWENTY_FOUR = FOURTEEN | {name: f"bench/scenes/tempting/{name}.pbrt" for name in TEMPTING}
EXAMPLES = {name: f"examples/scenes/{name}.pbrt" for name in ("leaves", "metals", "shade", "studio", "tinted")}
SMALLVCM = {f"smallvcm_{name}": f"bench/scenes/smallvcm/{name}.pbrt" for name in ("background", "point")}
ALL = TWENTY_FOUR | FOREIGN | EXAMPLES | SMALLVCM


def scene_file(scene):
    """The file of one of ALL."""
    return pathlib.Path(f"examples/scenes/{scene}.pbrt" if scene in BUILT_IN else ALL[scene])


def depth_of(scene, otherwise=None):
    """The option for the greatest length of paths: scenes of other renderers have that of their
    pictures."""
    depth = 10 if scene in FOREIGN else otherwise
    return ["--max-depth", str(depth)] if depth else []


def build(target, folder="bench"):
    """Builds a program of the preset `bench`, or of GMIS_BENCH_PRESET, and returns its path; gmis-…
    are in examples/."""
    preset = os.environ.get("GMIS_BENCH_PRESET", "bench")
    subprocess.run(["cmake", "--preset", preset, "--log-level=WARNING"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", "--preset", preset, "--target", target], check=True, stdout=subprocess.DEVNULL)
    folder = "examples" if target.startswith("gmis-") else folder
    return f"build/{preset}/{folder}/{target}"


def render(options, scene, *arguments, threads=1, stats=None, picture=None):
    """Runs gmis-render: its statistics. `scene` is one of ALL, or a file. Without a place of their
    own, picture and statistics are left in options.out."""
    stats = stats or options.out / "stats.json"
    picture = picture or options.out / "picture.pfm"
    words = [word for argument in arguments for word in (argument.split() if isinstance(argument, str) else map(str, argument))]
    subprocess.run([options.program, str(ALL.get(scene, scene)), "--threads", str(threads), "--quiet", *words, "--stats", str(stats), "--out",
                    str(picture)], check=True, stdin=subprocess.DEVNULL)
    return json.loads(pathlib.Path(stats).read_text(encoding="utf-8"))


def render_once(options, scene, *arguments, stem):
    """Like `render`, with picture and statistics in STEM.pfm and STEM.json; a run is taken from
    there that was made by the same words, for the same scene file, since the program was built."""
    if stem.suffix:  # from the dot on, another stem would share its files
        raise ValueError(f"{stem}: a stem must not have a dot")
    stats, picture = stem.with_suffix(".json"), stem.with_suffix(".pfm")
    built, key = pathlib.Path(options.program).stat().st_mtime, stem.with_suffix(".key")
    file = scene_file(scene) if scene in ALL else pathlib.Path(scene)
    made_by = hashlib.sha256(f"{arguments} {file.read_text(encoding='utf-8')}".encode()).hexdigest()
    if all(file.exists() and file.stat().st_mtime > built for file in (stats, picture, key)) and key.read_text() == made_by:
        return json.loads(stats.read_text(encoding="utf-8"))
    facts = render(options, scene, *arguments, stats=stats, picture=picture)
    key.write_text(made_by)
    return facts


# --- Pictures -------------------------------------------------------------------------------------


def read_pfm(file):
    """All channels of all pixels, as an array of floats."""
    *head, rest = pathlib.Path(file).read_bytes().split(b"\n", 3)
    values = array.array("f", rest)
    if (float(head[2]) < 0) != (sys.byteorder == "little"):
        values.byteswap()
    return values


def write_pfm(file, values, size):
    """`size`: WIDTHxHEIGHT; three channels."""
    scale = b"-1.0" if sys.byteorder == "little" else b"1.0"
    pathlib.Path(file).write_bytes(b"\n".join((b"PF", size.replace("x", " ").encode(), scale, array.array("f", values).tobytes())))


def own_errors(pictures, longer=None):
    """The error of every picture, relative as a run states it, against the mean of the other
    seeds: of their pictures, or of `longer` runs with the same mean. The two halves a and
    b of the others, and (x - a) (x - b) in place of a square, keep the noise of the others out;
    merging's bias, which all seeds have alike, is not in it either."""
    longer = pictures if longer is None else longer
    count, squares = len(pictures), [0.0] * len(pictures)
    sizes = (len(longer[0::2]), len(longer[1::2]))
    for k in range(len(pictures[0])):
        others = [picture[k] for picture in longer]
        sums = (sum(others[0::2]), sum(others[1::2]))
        for seed, own in enumerate(others):
            a, b = ((sums[side] - own) / (sizes[side] - 1) if side == seed % 2 else sums[side] / sizes[side] for side in (0, 1))
            mean = (sums[0] + sums[1] - own) / (count - 1)
            x = pictures[seed][k]
            squares[seed] += (x - a) * (x - b) / (mean * mean + 0.01)
    return [math.sqrt(max(square, 0.0) / len(pictures[0])) for square in squares]


# --- Tables ---------------------------------------------------------------------------------------


class Table:
    """A table in Markdown that prints every row when it is added."""

    def __init__(self, *head, numbers_from=None):
        """Columns from `numbers_from` on are aligned to the right."""
        left = len(head) if numbers_from is None else numbers_from
        self.rows = []
        self.add(*head)
        self.put("|" + " --- |" * left + " ---: |" * (len(head) - left))

    def put(self, line):
        self.rows.append(line)
        print(line, flush=True)

    def add(self, *cells):
        self.put("| " + " | ".join(map(str, cells)) + " |")

    def note(self, *lines):
        self.put("")
        for line in lines:
            self.put(line)

    def __str__(self):
        return "\n".join(self.rows) + "\n"


def publish(options, table, document=None, name=None):
    """Keeps a table in out/, and puts it into a document if the run had default options."""
    name = name or options.name
    (options.out / (name.replace(" ", "_") + ".md")).write_text(str(table))
    if not document or not options.is_whole:
        return
    if figures.digests().get(name) != options.digests.get(name):
        print(f"bench: the sources of {name} have changed meanwhile: the table is only in out/", file=sys.stderr)
        return
    write_into(document, name, str(table))


def write_into(document, name, table):
    """Puts a table, with its stamp, between the marks of a figure in a document (figures.py)."""
    text = pathlib.Path(document).read_text(encoding="utf-8")
    command = next((figure.command for figure in figures.figures_in(document, text) if figure.name == name), None)
    if not command or not figures.put(name, command, table, document):
        print(f"bench: {document} has no place for {name}: the table is only in out/", file=sys.stderr)


# --- Instructions and processor time --------------------------------------------------------------


def instructions_of(command, *callgrind_options):
    """Instructions that a command executes, counted by callgrind; with --toggle-collect= in one
    function."""
    said = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *callgrind_options, *map(str, command)],
                          capture_output=True, text=True, check=True, stdin=subprocess.DEVNULL).stderr
    return int(re.search(r"Collected : (\d+)", said)[1])


def in_parallel(count, cases):
    """(case, count(case)) for every case, in order; as many at a time as there are processors. For
    what does not depend on who else runs, as instructions do not."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as threads:
        yield from zip(cases, threads.map(count, cases))


def instructions_between(command_of, few, many):
    """Instructions of one round: the difference between runs of `many` and of `few`, so that what a
    run begins with does not count."""
    return (instructions_of(command_of(many)) - instructions_of(command_of(few))) / (many - few)


def processor_cost(command, **popen_options):
    """Processor seconds and megabytes of a command with all its children; exits where it fails."""
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=said, stderr=said, **popen_options)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = status
        if status != 0:
            said.seek(0)
            raise SystemExit(said.read().decode(errors="replace")[-2000:] + "\nbench: failed: " + " ".join(map(str, command)))
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def has_avx2():
    flags = pathlib.Path("/proc/cpuinfo")
    return not flags.exists() or " avx2 " in flags.read_text()


def compiler_name():
    compiler = os.environ.get("CXX", "g++")
    version = subprocess.run([compiler, "-dumpfullversion", "-dumpversion"], capture_output=True, text=True, check=True).stdout
    return f"{os.path.basename(compiler)} {version.strip()}"
