"""Inside lajolla (github.com/BachiLi/lajolla_public): means, instructions a pixel, efficiency.

Compiles lajolla's sources, with Debian's Embree 3 in place of Embree 4, and links check.cpp and
main.cpp with them. Over each scene, on one thread:

check       what `gmis::check_scene` finds in the adapted scene
means       of pictures by path tracing, by bidirectional path tracing and by `auto`, beside those
            by lajolla's path tracer: their distance in standard errors, told by other seeds
counts      instructions a pixel and sample of either path tracer (callgrind; the difference of two
            runs)
efficiency  1 / (relMSE × processor seconds) of `auto` over lajolla's path tracer in about the same
            processor time, against bidirectional path tracing, of which two halves keep their own
            noise out of the errors

Writes the table in docs/your-renderer.md.
"""

import pathlib
import statistics
import subprocess
import sys

from embedded.comparing import apart, average, mean_of, relmse
from measuring import Table, instructions_between, processor_cost, publish, read_pfm

here = pathlib.Path(__file__).resolve().parent
root = here.parents[2]
A_FILE = "src/path_tracing.h"
DOCUMENT = "docs/your-renderer.md"
OPTIONS = ["-O3", "-march=x86-64-v3", "-DNDEBUG", "-ffp-contract=off", "-g1", "-w"]
LIBRARIES = ["-lembree3", "-lpthread"]
LEFT_OUT = ("main.cpp", "render.cpp")  # of lajolla's: main.cpp here has both loops
# Name: file (of the checkout, or here) and what path tracing finds hard in it.
SCENES = {
    "cbox": ("scenes/cbox/cbox.xml", "–"),
    "veach_mi": ("scenes/veach_mi/mi.xml", "–"),
    "sponza": ("scenes/sponza/sponza.xml", "–"),
    "matpreview": ("scenes/matpreview/matpreview.xml", "glass under a sky"),
    "caustic": (None, "a caustic"),
}
WIDTH, MAX_DEPTH = 64, 10
SEEDS, SAMPLES = 8, 256
# Of bpt: all its runs are the reference. In veach_mi a few bright samples decide: with 4 runs
# errors come out two to three times as large as with 16 or 160.
REFERENCE_SEEDS, REFERENCE_ITERATIONS = 16, 192
LESS, MORE = 1, 3  # samples a pixel whose instructions are counted


# --- Building -------------------------------------------------------------------------------------


def compile_command(source, checkout, *more):
    language = [] if source.suffix == ".c" else ["-std=gnu++20", "-I", str(root / "include"), "-I", str(here), "-I", str(checkout / "src")]
    return ["gcc" if source.suffix == ".c" else "g++", *OPTIONS, *language, *more, str(source)]


def build(checkout, out):
    """The two programs, and the processor seconds that g++ takes for each source here. Objects of
    lajolla's are kept."""
    sources = [f for pattern in ("*.cpp", "parsers/*.cpp", "3rdparty/miniz.c", "3rdparty/pugixml.cpp") for f in sorted((checkout / "src").glob(pattern))
               if f.name not in LEFT_OUT]
    objects = []
    for source in sources:
        objects.append(out / (source.name + ".o"))
        if not objects[-1].exists() or objects[-1].stat().st_mtime < source.stat().st_mtime:
            subprocess.run([*compile_command(source, checkout, "-c"), "-o", str(objects[-1])], check=True, capture_output=True)
    seconds = {}
    for name in ("check", "main"):
        seconds[name], _ = processor_cost([*compile_command(here / f"{name}.cpp", checkout, "-c"), "-o", str(out / f"{name}.o")])
        subprocess.run(["g++", str(out / f"{name}.o"), *map(str, objects), *LIBRARIES, "-o", str(out / name)], check=True)
    return seconds


# --- Runs -----------------------------------------------------------------------------------------


def render(options, file, integrator, count, seed):
    """Picture, processor seconds."""
    picture = options.out / "picture.pfm"
    said = subprocess.run([str(options.out / "main"), str(file), str(WIDTH), str(MAX_DEPTH), integrator, str(count), str(seed), str(picture)], check=True,
                          capture_output=True, text=True).stdout
    return read_pfm(picture), float(said.split()[0])


def instructions(options, file, integrator):
    """A pixel and sample."""
    picture = options.out / "picture.pfm"
    command = lambda count: [str(options.out / "main"), str(file), str(WIDTH), str(MAX_DEPTH), integrator, str(count), "1", str(picture)]
    return instructions_between(command, LESS, MORE) / (len(read_pfm(picture)) // 3)


def lines_of_adapter():
    return sum(len((here / name).read_text(encoding="utf-8").splitlines()) for name in ("adapter.hpp", "embree4/rtcore.h"))


def run(options):
    seconds = build(options.checkout, options.out)
    table = Table("scene", "hard", "means apart: pt", "bpt", "auto", "instructions: lajolla", "gmis, pt", "ratio", "relMSE: lajolla", "auto",
                  "efficiency", "trimmed", numbers_from=2)
    for scene, (name, hard) in SCENES.items():
        file = options.checkout / name if name else here / "caustic.xml"
        found = subprocess.run([str(options.out / "check"), str(file)], capture_output=True, text=True).stdout
        print(f"{scene}: check_scene finds {found or 'nothing'}", file=sys.stderr, flush=True)
        # As many iterations of `auto` as take the time of lajolla's samples.
        wanted, tried = render(options, file, "lajolla", SAMPLES, 0)[1], render(options, file, "auto", SAMPLES // 2, 0)[1]
        counts = {"lajolla": SAMPLES, "pt": SAMPLES, "bpt": REFERENCE_ITERATIONS, "auto": max(8, round(SAMPLES // 2 * wanted / tried))}
        runs = {integrator: [] for integrator in counts}
        for seed in range(1, REFERENCE_SEEDS + 1):  # in turns
            for integrator, count in counts.items():
                if seed <= SEEDS or integrator == "bpt":
                    runs[integrator].append(render(options, file, integrator, count, seed))
        pictures = {integrator: [p for p, _ in of_it] for integrator, of_it in runs.items()}
        means = {integrator: mean_of(of_it) for integrator, of_it in pictures.items()}
        halves = [average(pictures["bpt"][side::2]) for side in (0, 1)]
        errors = {i: [statistics.fmean(v) for v in zip(*(relmse(p, *halves) for p in pictures[i]))] for i in ("lajolla", "auto")}
        spent = {i: statistics.fmean(s for _, s in runs[i]) for i in ("lajolla", "auto")}
        print(f"{scene}: {counts}, means {means}, errors {errors}, seconds {spent}", file=sys.stderr, flush=True)
        efficiency = [errors["lajolla"][k] * spent["lajolla"] / (errors["auto"][k] * spent["auto"]) for k in (0, 1)]
        theirs, ours = (instructions(options, file, i) for i in ("lajolla", "pt"))
        table.add(scene, hard, *(apart(means[i], means["lajolla"]) for i in ("pt", "bpt", "auto")), f"{theirs:.0f}", f"{ours:.0f}", f"{ours / theirs:.3f}",
                  *(f"{errors[i][0]:.4f}" for i in ("lajolla", "auto")), *(f"{e:.2f}" for e in efficiency))
    table.note(f"{WIDTH} pixels wide, at most {MAX_DEPTH} segments, {SAMPLES} samples a pixel by lajolla, {SEEDS} seeds, one thread.",
               f"The adapter is {lines_of_adapter()} lines; g++ compiles `check.cpp` in {seconds['check']:.0f} processor seconds, `main.cpp`, with three engines, in "
               f"{seconds['main']:.0f}.")
    publish(options, table, DOCUMENT)
