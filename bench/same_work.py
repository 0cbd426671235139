"""Whether the program of another commit does the same work as the one at hand: the same pictures
with the same counts, and nearly the same instructions. A table of errors and times that was
measured with one of them then holds for the other."""

import contextlib
import json
import pathlib
import subprocess

from measuring import ALL, in_parallel, instructions_of

RUNS = {name: ["--integrator", name] for name in ("pt", "bpt", "vcm", "auto")}
CHOOSING = ("bpt", "vcm", "auto")  # their connections, or all counts, by a pilot
RUNS |= {f"{name}, 1 connection": [*RUNS[name], "--connections", "1"] for name in ("bpt", "vcm")}
COUNTED = ("cornell", "paper1", "light_behind_glass", "many_lights")
# In the scenes COUNTED alone.
FURTHER = {"ppm": ["--integrator", "ppm"], "splitting": ["--integrator", "gmis", "--split", "budgeted", "--connections", "1"],
           "local": ["--integrator", "gmis", "--split", "local", "--connections", "1", "--light-paths", "0.25"],
           "independent": ["--integrator", "vcm", "--connections", "1", "--sampler", "independent"],
           "learned": ["--integrator", "vcm", "--connections", "1", "--emission", "learned", "--lights", "receiver"]}
LIMIT = 0.01  # as that of instructions.py
# The length of most tables' runs, for which a pilot takes its pixels. Instructions are counted over
# half of it: a statistic at the end of a run must not weigh much more.
ITERATIONS, COUNTED_ITERATIONS = 64, 32


def program_of(root):
    """Builds gmis-render of the preset bench in a checkout, and returns its path."""
    for words in (["--preset", "bench", "--log-level=WARNING"], ["--build", "--preset", "bench", "--target", "gmis-render"]):
        subprocess.run(["cmake", *words], cwd=root, check=True, stdout=subprocess.DEVNULL)
    return root / "build/bench/examples/gmis-render"


def command_of(root, program, scene, run, iterations, *more):
    where = ALL[scene] if scene == ALL[scene] else root / ALL[scene]
    expected = ["--expected-iterations", str(ITERATIONS)] if run in CHOOSING and iterations < ITERATIONS else []
    return [program, where, *(RUNS | FURTHER)[run], *expected, "--size", "64x64", "--iterations", str(iterations), "--threads", "1", "--quiet", *more]


def facts_of(root, program, scene, run, out):
    """Picture, counts, choices and errors of a run, as its statistics state them, without times."""
    stats = out / f"{root.name}_{scene}_{run}.json"
    subprocess.run(list(map(str, command_of(root, program, scene, run, ITERATIONS, "--stats", stats, "--out", stats.with_suffix(".pfm")))),
                   check=True, stdin=subprocess.DEVNULL)
    facts = json.loads(stats.read_text(encoding="utf-8"))
    return {key: facts[key] for key in ("image_hash", "iterations", "sample_counts", "counts")} | {
        # Not the gains that decided: they cost nothing and are in no table.
        "light_use": {key: chosen for key, chosen in facts["light_use"].items() if isinstance(chosen, bool)},
        **{key: without_times(facts.get(key)) for key in ("estimate", "prices", "prediction", "forecast")}}


def without_times(value):
    """A part of the statistics without its seconds, and with eight digits of every number."""
    if isinstance(value, dict):
        return {key: without_times(part) for key, part in value.items() if "seconds" not in key}
    if isinstance(value, list):
        return [without_times(part) for part in value]
    return float(f"{value:.8g}") if isinstance(value, float) else value


def differences(before, now, out, but=()):
    """The differences between the programs of two checkouts: scene, run, what; and the range of the
    ratio of their instructions, as text. The scenes `but` are left out."""
    out.mkdir(parents=True, exist_ok=True)
    programs = {root: program_of(root) for root in (before, now)}
    found = []
    cases = [(scene, run) for scene in ALL for run in RUNS if scene not in but]
    cases += [(scene, run) for scene in COUNTED for run in FURTHER if scene not in but]

    def changed(case):
        old, new = (facts_of(root, program, *case, out) for root, program in programs.items())
        return [key for key in old if old[key] != new[key]]

    for case, keys in in_parallel(changed, cases):
        if keys:
            found.append((*case, f"other {', '.join(keys)}"))

    def ratio(case):
        place = [(root, program, out / f"{root.name}_{'_'.join(case)}") for root, program in programs.items()]
        old, new = (instructions_of(command_of(root, program, *case, COUNTED_ITERATIONS, "--stats", f"{file}.json", "--out", f"{file}.pfm"))
                    for root, program, file in place)
        return new / old

    ratios = dict(in_parallel(ratio, [(scene, run) for scene in COUNTED for run in RUNS]))
    found += [(*case, f"{one:.4f} of the instructions") for case, one in ratios.items() if abs(one - 1) > LIMIT]
    return found, f"{min(ratios.values()):.3f} to {max(ratios.values()):.3f}"


@contextlib.contextmanager
def checkout(commit, root, folder):
    """A checkout of a commit, removed at the end of the with statement."""
    folder = pathlib.Path(folder)
    subprocess.run(["git", "-C", root, "worktree", "remove", "--force", folder], stderr=subprocess.DEVNULL)
    subprocess.run(["git", "-C", root, "worktree", "add", "--quiet", "--detach", folder, commit], check=True)
    try:
        yield folder
    finally:
        subprocess.run(["git", "-C", root, "worktree", "remove", "--force", folder])
