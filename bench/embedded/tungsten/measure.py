"""Inside Tungsten (github.com/tunabrain/tungsten): means, instructions a pixel, efficiency.

Builds Tungsten's library by its own CMakeLists.txt, without optional packages, and links check.cpp
and main.cpp with it. Over each scene, on one thread, with a box as the filter:

check       what `gmis::check_scene` finds in the adapted scene
means       of pictures by path tracing, by bidirectional path tracing and by `auto`, and by
            Tungsten's bidirectional path tracer, beside those by Tungsten's path tracer: their
            distance in standard errors, told by other seeds
counts      instructions a pixel and sample of path tracing and of bidirectional path tracing, ours
            over theirs (callgrind; the difference of two runs)
efficiency  1 / (relMSE × processor seconds) of `auto` over the better one of Tungsten's two, in
            about the same processor time. The truth is a long run of bidirectional path tracing
            here, of vertex connection and merging where that misses paths; two halves of it keep
            their own noise out of the errors

Writes the table in docs/your-renderer.md.
"""

import json
import pathlib
import statistics
import subprocess
import sys

from embedded.comparing import apart, average, mean_of, relmse
from measuring import Table, instructions_between, processor_cost, publish, read_pfm

here = pathlib.Path(__file__).resolve().parent
root = here.parents[2]
A_FILE = "src/core/renderer/TraceableScene.hpp"
DOCUMENT = "docs/your-renderer.md"
# For the oldest processors that Tungsten's CMakeLists.txt takes: it does not know those of today.
CMAKE = ["-DCMAKE_BUILD_TYPE=Release", "-DTARGET_ARCHITECTURE=nehalem",
         *(f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in ("OpenEXR", "JPEG", "OpenVDB", "Eigen3", "OpenGL"))]
OPTIONS = ["-O3", "-march=nehalem", "-std=gnu++20", "-DNDEBUG", "-ffp-contract=off", "-g1", "-w", "-DCONSTEXPR=constexpr", "-DEMBREE_STATIC_LIB=1",
           "-DRAPIDJSON_HAS_STDSTRING=1", "-DSTBI_NO_STDIO=1"]
INCLUDES = ("src/core", "src/thirdparty", "src/thirdparty/embree/include", "src")
# Name: file of the checkout, what path tracing finds hard in it, and what makes the truth.
SCENES = {
    "cornell-box": ("data/example-scenes/cornell-box/scene.json", "–", "bpt"),
    "materialtest": ("data/materialtest/materialtest.json", "–", "bpt"),
    "water-caustic": ("data/example-scenes/water-caustic/scene.json", "a caustic under water", "vcm"),
}
WIDTH, MAX_DEPTH = 64, 10
SEEDS, SAMPLES = 8, 192
# Of the truth, all its runs together. In water-caustic a lamp is seen through the water by one
# sample in millions: 6 runs of the truth do not know of the pixel where they or another picture
# have one.
TRUE_SEEDS, TRUE_ITERATIONS = 24, 256
LESS, MORE = 1, 3  # samples a pixel whose instructions are counted
THEIRS = {"pt": "tungsten", "bpt": "tungsten_bdpt"}


def build(checkout, out):
    """The two programs, and the processor seconds that g++ takes for each source here."""
    theirs = out / "tungsten"
    subprocess.run(["cmake", "-S", str(checkout), "-B", str(theirs), "-G", "Ninja", *CMAKE], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", str(theirs), "--target", "core", "thirdparty", "embree"], check=True, stdout=subprocess.DEVNULL)
    libraries = [theirs / "libcore.a", theirs / "libthirdparty.a", *sorted(theirs.glob("**/libembree*.a")), *sorted(theirs.glob("**/libs*.a")),
                 *sorted(theirs.glob("**/liblexers.a"))]
    seconds = {}
    for name in ("check", "main"):
        includes = [word for folder in (root / "include", *(checkout / folder for folder in INCLUDES)) for word in ("-I", str(folder))]
        seconds[name], _ = processor_cost(["g++", *OPTIONS, *includes, "-c", str(here / f"{name}.cpp"), "-o", str(out / f"{name}.o")])
        subprocess.run(["g++", str(out / f"{name}.o"), "-Wl,--start-group", *map(str, libraries), "-Wl,--end-group", "-lpthread", "-ldl", "-o", str(out / name)],
                       check=True)
    return seconds


def small(options, scene, file):
    """A copy of a scene beside it, narrow, with a box as its filter: its path."""
    described = json.loads(file.read_text(encoding="utf-8"))
    camera = described["camera"]
    width, height = camera["resolution"] if isinstance(camera["resolution"], list) else [camera["resolution"]] * 2
    camera |= {"resolution": [WIDTH, round(height * WIDTH / width)], "reconstruction_filter": "box"}
    described["integrator"] = {"type": "path_tracer", "max_bounces": MAX_DEPTH}
    folder = options.out / scene
    folder.mkdir(exist_ok=True)
    for other in file.parent.iterdir():
        if other.is_file() and not (folder / other.name).exists():
            (folder / other.name).symlink_to(other)
    copy = folder / "small.json"
    copy.write_text(json.dumps(described), encoding="utf-8")
    return copy


def command(options, file, integrator, count, seed):
    return [str(options.out / "main"), str(file), str(MAX_DEPTH), integrator, str(count), str(seed), str(options.out / "picture.pfm")]


def render(options, file, integrator, count, seed):
    """Picture, processor seconds."""
    said = subprocess.run(command(options, file, integrator, count, seed), check=True, capture_output=True, text=True).stdout
    return read_pfm(options.out / "picture.pfm"), float(said.split()[-1])


def instructions(options, file, integrator):
    """A pixel and sample."""
    count = instructions_between(lambda samples: command(options, file, integrator, samples, 1), LESS, MORE)
    return count / (len(read_pfm(options.out / "picture.pfm")) // 3)


def run(options):
    seconds = build(options.checkout, options.out)
    table = Table("scene", "hard", "means apart: pt", "bpt", "auto", "Tungsten, bpt", "instructions, gmis / Tungsten: pt", "bpt", "relMSE: Tungsten, pt",
                  "Tungsten, bpt", "auto", "efficiency", "trimmed", numbers_from=2)
    for scene, (name, hard, truth) in SCENES.items():
        file = small(options, scene, options.checkout / name)
        found = subprocess.run([str(options.out / "check"), str(file)], capture_output=True, text=True).stdout
        print(f"{scene}: check_scene finds {found or 'nothing'}", file=sys.stderr, flush=True)
        # The counts take the time of Tungsten's path tracer.
        wanted = render(options, file, "tungsten", SAMPLES, 0)[1]
        counts = {"tungsten": SAMPLES} | {i: max(8, round(SAMPLES // 4 * wanted / render(options, file, i, SAMPLES // 4, 0)[1]))
                                          for i in ("tungsten_bdpt", "pt", "auto")} | {"bpt": TRUE_ITERATIONS, truth: TRUE_ITERATIONS}
        runs = {integrator: [] for integrator in counts}
        for seed in range(1, TRUE_SEEDS + 1):  # in turns
            for integrator, count in counts.items():
                if seed <= SEEDS or integrator == truth:
                    runs[integrator].append(render(options, file, integrator, count, seed))
        pictures = {integrator: [p for p, _ in of_it] for integrator, of_it in runs.items()}
        means = {integrator: mean_of(of_it) for integrator, of_it in pictures.items()}
        halves = [average(pictures[truth][side::2]) for side in (0, 1)]
        compared = ("tungsten", "tungsten_bdpt", "auto")
        errors = {i: [statistics.fmean(v) for v in zip(*(relmse(p, *halves) for p in pictures[i]))] for i in compared}
        works = {i: [error * statistics.fmean(s for _, s in runs[i]) for error in errors[i]] for i in compared}
        print(f"{scene}: {counts}, means {means}, errors {errors}, works {works}", file=sys.stderr, flush=True)
        ratios = [instructions(options, file, ours) / instructions(options, file, theirs) for ours, theirs in THEIRS.items()]
        table.add(scene, hard, *(apart(means[i], means["tungsten"]) for i in ("pt", "bpt", "auto", "tungsten_bdpt")), *(f"{r:.3f}" for r in ratios),
                  *(f"{errors[i][0]:.4f}" for i in compared), *(f"{min(works[i][k] for i in compared[:2]) / works['auto'][k]:.2f}" for k in (0, 1)))
    lines = len((here / "adapter.hpp").read_text(encoding="utf-8").splitlines())
    table.note(f"{WIDTH} pixels wide, at most {MAX_DEPTH} segments, {SAMPLES} samples a pixel by Tungsten's path tracer, {SEEDS} seeds, one thread.",
               f"The adapter is {lines} lines; g++ compiles `check.cpp` in {seconds['check']:.0f} processor seconds, `main.cpp`, with three engines, in "
               f"{seconds['main']:.0f}.")
    publish(options, table, DOCUMENT)
