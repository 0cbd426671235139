"""Error × time of --integrator auto over that of the best fixed integrator, scene by scene.

Every configuration renders every scene for the same time, on one thread, several seeds; the configurations of a scene take
turns, so that a busy machine is fair to all. Work is relMSE × processor seconds, so a ratio below 1 means that auto needs
less time for the same error. Of the seconds an iteration takes the least of all seeds counts, since what else runs on the
machine can only add to them; relMSE × iterations is the mean of all. The errors are against a reference that auto had no part in: the mean of two long
runs of bpt, which has no bias, or, where that cannot make or hardly finds some paths, of vcm with a quarter of the merging
radius. The best fixed configuration is chosen by the very figures it is shown with, which favours it.

Writes out/effects/table.md and out/effects/runs.json.
"""

import argparse
import array
import concurrent.futures
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys

from measuring import FOURTEEN, read_pfm

# Who makes the reference: bpt, but where it hardly finds some of the paths.
FOUND_BY_MERGING = {"paper1", "paper2", "paper4", "caustic_pool", "light_behind_glass", "mixed"}

FIXED = {"pt": ["--integrator", "pt"], "lt": ["--integrator", "lt"],
         "vcm 2 1": ["--integrator", "vcm", "--light-paths", "2", "--connections", "1"]}
for name in ("bpt", "vcm"):
    for light_paths in (0.25, 1):
        for connections in (1, 2):
            FIXED[f"{name} {light_paths:g} {connections}"] = [
                "--integrator", name, "--light-paths", str(light_paths), "--connections", str(connections)]
# A local count of merging: light trees a pixel, factor on the radius.
for light_paths, factor in ((0.25, 4), (0.25, 12), (0.5, 8), (1, 8)):
    FIXED[f"local {light_paths:g} x{factor}"] = [
        "--integrator", "gmis", "--split", "local", "--connections", "1", "--light-paths", str(light_paths), "--radius",
        f"{0.4 * factor:g}"]
PLAIN = {"vcm": ["--integrator", "vcm"], "auto": ["--integrator", "auto"]}


def render(options, scene, extra, stats, keep=False):
    if keep and stats.exists():
        return json.loads(stats.read_text())
    command = [options.renderer, scene, "--size", options.size, "--threads", "1", "--quiet", "--stats", str(stats), *extra]
    subprocess.run(command, check=True, stdin=subprocess.DEVNULL)
    return json.loads(stats.read_text())


def make_reference(options, pool, name):
    """The mean of two runs, kept for the next time; how far they are apart says how noisy it is."""
    integrator = "vcm" if name in FOUND_BY_MERGING else "bpt"
    folder = options.out / "references"
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{name}_{options.size}_{options.reference_time:g}.pfm"
    if file.exists():
        return file
    extra = ["--integrator", integrator, "--time", str(options.reference_time)]
    if integrator == "vcm":
        extra += ["--radius", "0.1"]
    halves = [folder / f"{name}_{half}.pfm" for half in "ab"]
    jobs = [pool.submit(render, options, FOURTEEN[name], [*extra, "--seed", str(1000 + i), "--out", str(half)],
                        half.with_suffix(".json")) for i, half in enumerate(halves)]
    for job in jobs:
        job.result()
    a, b = (read_pfm(half) for half in halves)
    mean = array.array("f", ((x + y) / 2 for x, y in zip(a, b)))
    scale = b"-1.0" if sys.byteorder == "little" else b"1.0"
    width_and_height = options.size.replace("x", " ").encode()
    file.write_bytes(b"PF\n" + width_and_height + b"\n" + scale + b"\n" + mean.tobytes())
    noise = statistics.fmean((x - y) ** 2 / 4 / (m * m + 0.01) for x, y, m in zip(a, b, mean))
    print(f"{name}: reference by {integrator}, relMSE of its own about {noise:.2g}", flush=True)
    return file


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(v) for v in values))


def describe(stats):
    """What auto chose, from the statistics of a run."""
    choice = stats.get("choice")
    if not choice:
        return "by the rules: " + stats["plan"], 0.0
    chosen = choice["chosen"]
    words = f"{chosen['light_paths']:g} light paths, {chosen['connections']} connections, merging " + (
        "on" if chosen["merges"] else "off") if chosen["light_paths"] > 0 else "pt"
    if chosen["merges"] and chosen["local_merges"]:
        words += f" x{chosen['radius_factor']:g}"
    if chosen["camera_children"] > 1:
        words += f", {chosen['camera_children']} children"
    return words, choice["pilot_share"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renderer", required=True)
    parser.add_argument("--time", type=float, default=4, help="seconds of a run")
    parser.add_argument("--reference-time", type=float, default=40, help="seconds of each half of a reference")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--size", default="64x64")
    parser.add_argument("--keep", action="store_true", help="take the runs that are there already, and add what is missing")
    parser.add_argument("--scenes", nargs="*", default=list(FOURTEEN), choices=list(FOURTEEN))
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/effects"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    configurations = FIXED | PLAIN
    rows, all_runs = [], {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for name in options.scenes:
            reference = make_reference(options, pool, name)
            scene = FOURTEEN[name]
            jobs = {}
            for seed in range(options.seeds):
                for label, extra in configurations.items():
                    place = str(options.out / f"{name}_{label.replace(' ', '_')}_{seed}")
                    jobs[label, seed] = pool.submit(
                        render, options, scene,
                        [*extra, "--time", str(options.time), "--seed", str(seed), "--reference", str(reference), "--out",
                         place + ".pfm"], pathlib.Path(place + ".json"), options.keep)
            runs = {key: job.result() for key, job in jobs.items()}
            work = {}
            for measure in ("relmse", "relmse_trimmed"):
                for label in configurations:
                    own = [runs[label, seed] for seed in range(options.seeds)]
                    work[measure, label] = statistics.fmean(r["error"][measure] * r["iterations"] for r in own) * min(
                        r["seconds"]["cpu"] / r["iterations"] for r in own)
            all_runs[name] = {f"{measure} {label}": value for (measure, label), value in work.items()}
            choice, share = describe(runs["auto", 0])
            best = {m: min(FIXED, key=lambda label: work[m, label]) for m in ("relmse", "relmse_trimmed")}
            rows.append({
                "name": name, "choice": choice, "pilot": share, "best": best,
                "over_best": {m: work[m, "auto"] / work[m, best[m]] for m in best},
                "over_vcm": {m: work[m, "auto"] / work[m, "vcm"] for m in best}})
            print(f"{name}: {rows[-1]}", flush=True)
    (options.out / "runs.json").write_text(json.dumps(all_runs, indent=1))

    lines = ["| scene | auto chose | best fixed | auto / best | auto / vcm | best fixed, trimmed | auto / best, trimmed | "
             "auto / vcm, trimmed | pilot |", "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    for row in rows:
        lines.append(
            f"| {row['name']} | {row['choice']} | {row['best']['relmse']} | {row['over_best']['relmse']:.2f} | "
            f"{row['over_vcm']['relmse']:.2f} | {row['best']['relmse_trimmed']} | {row['over_best']['relmse_trimmed']:.2f} | "
            f"{row['over_vcm']['relmse_trimmed']:.2f} | {100 * row['pilot']:.1f} % |")
    means = [geometric_mean([row[over][m] for row in rows])
             for m in ("relmse", "relmse_trimmed") for over in ("over_best", "over_vcm")]
    lines.append(f"| geometric mean | | | {means[0]:.2f} | {means[1]:.2f} | | {means[2]:.2f} | {means[3]:.2f} | |")
    table = "\n".join(lines) + "\n"
    (options.out / "table.md").write_text(table)
    print(table)


main()
