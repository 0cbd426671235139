"""How the time of a run grows with light vertices, lights and the depth of paths.

Light vertices: the classic box with more and more light trees, merging within a small disk; seconds
of tracing, storing and sorting, per vertex. Lights: a floor under points of light, a camera ray and
a next event a pixel, chosen by power and for the receiver. Depth: a ball of albedo 1 with a lamp in
it, in which every path has its greatest length, and every vertex one connection. The scenes are
written by this script. The least of several runs counts. Triangles are in docs/bvh.md.

Threads: the wall time of a whole run by one thread over that by two, and what the machine gives at
most: twice the time of one run with one thread over that of two such runs at once. In turns, the
median counts.

Writes the tables in docs/accuracy-and-time.md.
"""

import json
import math
import statistics
import subprocess

from measuring import Table, publish, render

PROGRAM = "gmis-render"
OPTIONS = {"runs": 3}
DOCUMENT = "docs/accuracy-and-time.md"
HEAD = 'LookAt 0 -2 1.5  0 0 0  0 0 1\nCamera "perspective" "float fov" [ 40 ]\nFilm "rgb" "integer xresolution" [ 128 ] "integer yresolution" [ 128 ]\nWorldBegin\n'


def lights_scene(folder, count):
    side = math.isqrt(count - 1) + 1
    at = ((2 * (k % side + 0.5) / side - 1, 2 * (k // side + 0.5) / side - 1) for k in range(count))
    lights = "".join(f'LightSource "point" "rgb I" [ {3 / count:.3g} {2 / count:.3g} {1 / count:.3g} ] "point3 from" [ {x:.6g} {y:.6g} 0.4 ]\n' for x, y in at)
    file = folder / f"lights_{count}.pbrt"
    file.write_text(HEAD + lights + 'Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]\nShape "trianglemesh" "integer indices" [ 0 1 2 2 3 0 ] '
                    '"point3 P" [ -9 -9 0  9 -9 0  9 9 0  -9 9 0 ]\n')
    return file


def ball_scene(folder):
    file = folder / "ball.pbrt"
    file.write_text(HEAD + 'AttributeBegin\nAreaLightSource "diffuse" "rgb L" [ 1 1 1 ]\nTranslate 0 0 2\nShape "sphere" "float radius" [ .2 ]\nAttributeEnd\n'
                    'Material "diffuse" "rgb reflectance" [ 1 1 1 ]\nShape "sphere" "float radius" [ 4 ]\n')
    return file


def runs_of(options, scene, arguments):
    """The statistics of equal runs."""
    return [render(options, scene, "--size 128x128", arguments) for _ in range(options.runs)]


def wall_of(phase, runs):
    """The least wall seconds of a phase."""
    return min(run["seconds"]["phase"][phase] for run in runs)


def wall_seconds(options, scene, threads, processes):
    """Wall time of several runs at once."""
    files = [options.out / f"stats_{k}.json" for k in range(processes)]
    begun = [subprocess.Popen([options.program, scene, "--integrator", "vcm", "--connections", "paired", "--size", "256x256", "--iterations", "32", "--threads",
                               str(threads), "--quiet", "--stats", str(file), "--out", str(file.with_suffix(".pfm"))], stdin=subprocess.DEVNULL) for file in files]
    if any([run.wait() for run in begun]):
        raise SystemExit("a run failed")
    return max(json.loads(file.read_text())["seconds"]["wall"] for file in files)


def threads_table(options):
    table = Table("scene", "one thread, s", "two threads, s", "ratio", "two runs at once: ratio")
    for scene in ("cornell", "paper1", "paper4"):
        rounds = [[wall_seconds(options, scene, *how) for how in ((1, 1), (2, 1), (1, 2))] for _ in range(options.runs)]
        one, two = (statistics.median(times[k] for times in rounds) for k in (0, 1))
        ratio = statistics.median(times[0] / times[1] for times in rounds)
        given = statistics.median(2 * times[0] / times[2] for times in rounds)
        table.add(scene, f"{one:.1f}", f"{two:.1f}", f"{ratio:.2f}", f"{given:.2f}")
    table.note(f"256x256 pixels, vcm, 32 iterations; wall time with all estimates of the error, medians of {options.runs} rounds.")
    publish(options, table, DOCUMENT, "threads")


def add_options(parser):
    parser.add_argument("what", nargs="?", choices=("all", "growth", "threads"), default="all")


def run(options):
    if options.what in ("threads", "all"):
        threads_table(options)
    if options.what == "threads":
        return
    table = Table("what grows", "how many", "time of each", "bytes of each")

    def add(what, number, time, unit, size=""):
        table.add(what, number, f"{time:.3g} {unit}", size)

    for trees in (4, 40, 280):
        runs = runs_of(options, "cornell", f"--integrator vcm --connections 1 --radius 0.05 --iterations 2 --light-paths {trees}")
        vertices = runs[0]["counts"]["photons_stored"] / runs[0]["iterations"]
        for what, phase in (("light vertices: traced", "light"), ("light vertices: sorted into the grid", "grid")):
            add(what, f"{vertices:.2g}", 1e9 * wall_of(phase, runs) / runs[0]["iterations"] / vertices, "ns",
                f"{runs[0]['memory']['photon_bytes'] / vertices:.0f}" if phase == "grid" else "")
    for way in ("power", "receiver"):
        for count in (10, 1000, 100000):
            runs = runs_of(options, lights_scene(options.out, count), f"--integrator pt --max-depth 2 --sampler independent --iterations 16 --lights {way}")
            add(f"lights, chosen by {way}: a path of two segments", count, 1e9 * wall_of("camera", runs) / runs[0]["counts"]["camera_paths"], "ns")
    ball = ball_scene(options.out)
    for integrator in ("pt", "bpt", "vcm"):
        for depth in (16, 64, 256):
            connections = {"pt": "", "bpt": "--connections 1", "vcm": "--connections 1 --radius 0.05"}[integrator]
            runs = runs_of(options, ball, f"--integrator {integrator} {connections} --sampler independent --iterations {1024 // depth} --max-depth {depth}")
            add(f"depth, {integrator}: a segment of a subpath", depth, 1e9 * min(run["seconds"]["cpu"] for run in runs) / runs[0]["counts"]["rays"], "ns")
    table.note(f"128x128 pixels, the least of {options.runs} runs, one thread. Wall time of light vertices and lights, processor time of depth.")
    publish(options, table, DOCUMENT)

