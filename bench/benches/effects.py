"""Error × time of --integrator auto over that of the best fixed choice, scene by scene; and what
auto loses by its own choices.

Every configuration renders every scene for the processor time of 32 iterations of `vcm`, on one
thread, several seeds; the configurations of a scene take turns, so that a busy machine is fair to
all. Work is relMSE × processor seconds, so a ratio below 1 means that auto needs less time for the
same error. The time of an iteration is the mean of all timings, over seeds and configurations, of
iterations that do the same. With the first of the picking seeds, auto has 32 iterations and a
fixed configuration eight: one that takes 1.5 times the work of the best fixed one is out. The best
one is picked on some seeds and scored on others. An interval is one of 90 %, from the spread of
both over the seeds and that of the timings.

The regret is auto's work over that of the best of the fixed configurations and of auto with
emission by power or learned and lights by power or by the light tree, each fixed.

An error is the product of the differences from two references that auto had no part in, so that
their noise is not in it: svcm0, svcm1, tung1 and tung2 have those of other renderers; otherwise
they are two long runs of bpt, which has no bias, or, where that cannot make or hardly finds some
paths, of gmis, which merges locally, with a quarter of its merging radius.

Writes out/effects/runs.json, and two tables in docs/effects.md: `effects`, of eighteen scenes, and
`regret`, of all.
"""

import concurrent.futures
import dataclasses
import hashlib
import itertools
import json
import math
import os
import pathlib
import statistics

import errors
import measuring
from measuring import ALL, FOREIGN, FOURTEEN, Table, depth_of, publish, read_pfm, scene_file

PROGRAM = "gmis-render"
OPTIONS = {"seeds": 4, "size": "128x128", "scenes": ALL}
DOCUMENT = "docs/effects.md"
EIGHTEEN = FOURTEEN | FOREIGN
ITERATIONS_OF_VCM = 32
HOPELESS = 1.5
STUDENT_T = (6.314, 2.920, 2.353, 2.132, 2.015, 1.943, 1.895)  # 95 %, for 1, 2 … degrees of freedom
NORMAL = 1.645  # 95 %

# The reference is by bpt, except in these scenes, where bpt hardly finds some of the paths.
FOUND_BY_MERGING = {"paper1", "paper3", "paper4", "caustic_pool", "light_behind_glass", "mirror_hall", "mixed", "camera_in_water", "panes",
                    "rare_caustic", "smallvcm_point", "studio", "telephoto"}

FIXED = {"pt": ["--integrator", "pt"]}
for name, light_paths, connections in (("bpt", 0.25, 1), ("bpt", 1, 1), ("bpt", 1, 2), ("vcm", 0.25, 1), ("vcm", 1, 1), ("vcm", 1, 2)):
    FIXED[f"{name} {light_paths:g} {connections}"] = [
        "--integrator", name, "--light-paths", str(light_paths), "--connections", str(connections)]
# A local count of merging: light trees a pixel, factor on the radius.
for light_paths, factor in ((0.25, 4), (0.25, 12), (0.5, 8), (1, 8)):
    FIXED[f"local {light_paths:g} x{factor}"] = [
        "--integrator", "gmis", "--split", "local", "--connections", "1", "--light-paths", str(light_paths), "--radius",
        f"{0.4 * factor:g}"]
OPEN = {f"auto, emission {emission}, lights {lights}": ["--integrator", "auto", "--emission", emission, "--lights", lights]
        for emission, lights in itertools.product(("power", "learned"), ("power", "receiver"))}
POOLS = {"fixed": FIXED, "any": FIXED | OPEN}
MEASURES = ("relMSE", "trimmed")
OLD = "vcm, independent numbers"
PLAIN = {"vcm": ["--integrator", "vcm"], OLD: ["--integrator", "vcm", "--sampler", "independent"], "auto": ["--integrator", "auto"]}


def render(options, scene, extra, stats):
    return measuring.render(options, scene, f"--size {options.size}", depth_of(scene), extra, stats=stats, picture=stats.with_suffix(".pfm"))


def references_of(options, pool, name):
    """The two references of a scene. References made here are kept, for the same scene file and
    settings."""
    if name in FOREIGN:
        file = pathlib.Path(FOREIGN[name])
        return [read_pfm(file.with_name(f"{file.stem}_{half}.pfm")) for half in "ab"]
    extra = ["--time", str(options.reference_time), *("--integrator gmis --radius 0.8" if name in FOUND_BY_MERGING else "--integrator bpt").split()]
    folder = options.out / "references"
    folder.mkdir(parents=True, exist_ok=True)
    key = hashlib.sha256("\n".join([scene_file(name).read_text(), options.size, *extra]).encode()).hexdigest()[:8]
    halves = [folder / f"{name}_{key}_{half}.pfm" for half in "ab"]
    missing = [(k, half) for k, half in enumerate(halves) if not half.exists()]
    for job in [pool.submit(render, options, name, [*extra, "--seed", str(1000 + k)], half.with_suffix(".json")) for k, half in missing]:
        job.result()
    pictures = [read_pfm(half) for half in halves]
    noise = statistics.fmean((x - y) ** 2 / 4 / (((x + y) / 2) ** 2 + 0.01) for x, y in zip(*pictures))
    print(f"{name}: references with {' '.join(extra)}, relMSE of their mean about {noise:.2g}", flush=True)
    return pictures


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(v) for v in values))


def describe(stats):
    """The choice of auto, from the statistics of a run."""
    choice = stats.get("choice")
    if not choice:
        return "by the rules: " + stats["plan"], 0.0
    chosen = choice["chosen"]
    words = f"{chosen['light_paths']:g} light paths, {chosen['connections']} connections, merging " + (
        "on" if chosen["merges"] else "off") if chosen["light_paths"] > 0 else "pt"
    if chosen["merges"] and chosen["local_merges"]:
        words += f" x{chosen['radius_factor']:g}"
    return words, choice["pilot_share"]


def work_done(stats):
    """All on which the time of an iteration depends: the counts, the use of lights, the numbers,
    what is learned, whether there is a pilot."""
    use = {key: chosen for key, chosen in stats["light_use"].items() if isinstance(chosen, bool)}
    return json.dumps([stats["sample_counts"], use, stats["sampler"], stats["emission"], stats["lights"], bool(stats.get("choice"))], sort_keys=True)


class Clock:
    """The processor seconds an iteration, by what is done in it."""

    def __init__(self):
        self.runs = {}  # seconds, iterations

    def take(self, did, seconds, iterations):
        self.runs.setdefault(did, []).append((seconds, iterations))

    def pace(self, did):
        """The seconds of all runs that do the same over their iterations."""
        return sum(seconds for seconds, _ in self.runs[did]) / sum(iterations for _, iterations in self.runs[did])

    def scatter(self):
        """The relative standard deviation of the pace of one run, from all that do the same as
        another."""
        squares = [(seconds / iterations / self.pace(did) - 1) ** 2 for did, runs in self.runs.items() if len(runs) > 1 for seconds, iterations in runs]
        return math.sqrt(sum(squares) / sum(len(runs) - 1 for runs in self.runs.values())) if squares else math.inf

    def error(self, dids):
        """The relative standard error of a mean pace."""
        return self.scatter() / math.sqrt(sum(len(self.runs[did]) for did in set(dids)))


@dataclasses.dataclass
class Work:
    """relMSE × processor seconds of a configuration: the mean over seeds, its relative standard
    errors from the spread over them and from the clock, and all that was done."""

    mean: float
    spread: float
    clock: float
    did: list[str]


def work(runs, measure, clock):
    works, did = [run[measure] * run["iterations"] * clock.pace(run["did"]) for run in runs], sorted({run["did"] for run in runs})
    mean = statistics.fmean(works)
    return Work(mean, statistics.stdev(works) / mean / math.sqrt(len(works)) if len(works) > 1 else math.inf, clock.error(did), did)


def ratio(one, other, seeds):
    """The ratio of two works and its interval of 90 %: for the seeds by Student's t with as many
    degrees of freedom as those of one have, for the clock by the normal distribution. Where both
    do the same, the clock has no part in it."""
    value, spread = one.mean / other.mean, STUDENT_T[min(seeds - 1, len(STUDENT_T)) - 1] * math.hypot(one.spread, other.spread)
    if one.did != other.did:
        spread = math.hypot(spread, NORMAL * one.clock, NORMAL * other.clock)
    return value, value * math.exp(-spread), value * math.exp(spread)


def not_hopeless(works):
    """The configurations that do not take HOPELESS times the work of the best one by every measure.
    `works`: by configuration, a work for each measure."""
    least = [min(of_measure) for of_measure in zip(*works.values())]
    return [label for label, own in works.items() if any(w < HOPELESS * l for w, l in zip(own, least))]


def add_options(parser):
    parser.add_argument("--reference-time", type=float, default=8, help="seconds of each half of a reference")
    parser.add_argument("--picking-seeds", type=int, default=2)


def compare(options, pool, name):
    """Runs all configurations for the same processor time. The best of each of POOLS by each
    measure is picked on some seeds; it and the plain ones are scored on further ones. Returns the
    names of the best, the works by measure and configuration, the statistics and pictures of the
    runs of auto, and the references."""
    references = references_of(options, pool, name)
    candidates, others = POOLS["any"], PLAIN if name in EIGHTEEN else {"auto": PLAIN["auto"], OLD: PLAIN[OLD]}
    configurations = candidates | others
    clock = Clock()

    def run_one(label, iterations, seed):
        stats = options.out / f"{name}_{label.replace(' ', '_').replace(',', '')}_{seed}.json"
        picture = stats.with_suffix(".pfm")
        facts = render(options, name, [*configurations[label], "--iterations", str(iterations), "--seed", str(seed)], stats)
        did = work_done(facts)
        clock.take(did, facts["seconds"]["cpu"], iterations)
        return dict(zip(MEASURES, errors.relmse(read_pfm(picture), references))) | {"did": did, "iterations": iterations, "stats": facts, "picture": picture}

    def runs_of(labels, seeds, iterations_of):  # they take turns
        counts = {label: iterations_of(label) for label in labels}
        jobs = [(label, pool.submit(run_one, label, counts[label], seed)) for seed in seeds for label in counts]
        runs = {label: [] for label in counts}
        for label, job in jobs:
            runs[label].append(job.result())
        return runs

    picking = range(options.picking_seeds)
    scoring = range(picking.stop, picking.stop + options.seeds)
    tried = runs_of(configurations, picking[:1],
                    lambda label: ITERATIONS_OF_VCM if label == OLD or "auto" in configurations[label] else ITERATIONS_OF_VCM // 4)

    def iterations(label):
        """The number of iterations that take as long as those of OLD."""
        return max(4, round(ITERATIONS_OF_VCM * clock.pace(tried[OLD][0]["did"]) / clock.pace(tried[label][0]["did"])))

    hopeful = not_hopeless({label: [work(tried[label], m, clock).mean for m in MEASURES] for label in FIXED})
    kept = [*hopeful, *OPEN]
    picked = runs_of(hopeful, picking[:1], iterations)
    for label, later in runs_of(kept, picking[1:], iterations).items():
        picked[label] = picked.get(label, tried[label]) + later
    best = {(of, m): min((label for label in kept if label in labels), key=lambda label: work(picked[label], m, clock).mean)
            for of, labels in POOLS.items() for m in MEASURES}
    runs = runs_of([*best.values(), *(others if name in EIGHTEEN else ["auto"])], scoring, iterations)
    works = {(m, label): work(of_label, m, clock) for m in MEASURES for label, of_label in runs.items()}
    return best, works, [(run["stats"], run["picture"]) for run in runs["auto"]], references


def bounds_held(options, name, runs, references):
    """In how many of the runs that merge, with their pictures, the stated bound of the bias is not
    surely broken, by two standard errors; and how many merge."""
    merging = [(stats["estimate"]["merging_bias_bound"], picture) for stats, picture in runs if stats["sample_counts"]["merges"]]
    if len(merging) < 2:
        return 0, 0
    width = int(options.size.split("x")[0])
    square, error = errors.squared_bias([read_pfm(picture) for _, picture in merging], references, width)
    print(f"{name}: squared bias {square:.2g} ± {error:.2g}, bounds", *(f"{bound:.4f}" for bound, _ in merging), flush=True)
    return sum(bound**2 >= square - 2 * error for bound, _ in merging), len(merging)


def cell(value):
    return f"{value[0]:.2f} ({value[1]:.2f}–{value[2]:.2f})"


def of_all(rows, column):
    return f"{geometric_mean([row[column][0] for row in rows]):.2f}"


def not_surely_dear(rows, column):
    return f"{sum(row[column][1] <= 1.1 for row in rows)} of {len(rows)} scenes"


def table_of_effects(options, rows):
    ratios = ("auto / best", "auto / vcm", "auto / vcm, independent")
    table = Table("scene", "auto chose", "pilot", "best fixed", *ratios, "best fixed, trimmed", *ratios)
    for row in rows:
        cells = [row["name"], row["choice"], f"{100 * row['pilot']:.1f} %"]
        for m in MEASURES:
            cells += [row["best"]["fixed", m], *(cell(row[m, other]) for other in ("fixed", "vcm", OLD))]
        table.add(*cells)
    table.add("geometric mean", "", "", *(cell for m in MEASURES for cell in ("", *(of_all(rows, (m, other)) for other in ("fixed", "vcm", OLD)))))
    table.note(f"{options.size} pixels, the time of {ITERATIONS_OF_VCM} iterations of `vcm` with independent numbers, {options.picking_seeds} seeds to pick "
               f"and {options.seeds} to score; in brackets intervals of 90 %. Auto is not surely more than 1.10 times as dear as the best in "
               f"{not_surely_dear(rows, ('relMSE', 'fixed'))}, trimmed in {not_surely_dear(rows, ('trimmed', 'fixed'))}.")
    publish(options, table, DOCUMENT)


def table_of_regret(options, rows):
    table = Table("scene", "best of all", "regret", "best of all, trimmed", "regret, trimmed")
    for row in rows:
        table.add(row["name"], *(text for m in MEASURES for text in (row["best"]["any", m], cell(row[m, "any"]))))
    table.add("geometric mean", *(cell for m in MEASURES for cell in ("", of_all(rows, (m, "any")))))
    held, merging = (sum(column) for column in zip(*(row["bounds"] for row in rows)))
    table.note(f"As above. Auto is not surely more than 1.10 times as dear as the best in {not_surely_dear(rows, ('relMSE', 'any'))}, trimmed in "
               f"{not_surely_dear(rows, ('trimmed', 'any'))}. Bounds of the bias of merging, as auto's runs state them, were not broken in {held} "
               f"of {merging} runs that merge.")
    publish(options, table, DOCUMENT, "regret")


def run(options):
    if options.size != "128x128":  # the pictures of other renderers have that size
        options.scenes = [name for name in options.scenes if name not in FOREIGN]
    rows, all_runs = [], {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for name in options.scenes:
            best, works, of_auto, references = compare(options, pool, name)
            all_runs[name] = {f"{m} {label}": dataclasses.asdict(value) for (m, label), value in works.items()}
            choice, share = describe(of_auto[0][0])
            row = {"name": name, "choice": choice, "pilot": share, "best": best, "bounds": bounds_held(options, name, of_auto, references)}
            for m in MEASURES:
                for other in (*POOLS, *((OLD, "vcm") if name in EIGHTEEN else ())):
                    row[m, other] = ratio(works[m, "auto"], works[m, best[other, m] if other in POOLS else other], options.seeds)
            rows.append(row)
            print(f"{name}: {row}", flush=True)
            (options.out / "runs.json").write_text(json.dumps(all_runs, indent=1))
    if of_eighteen := [row for row in rows if row["name"] in EIGHTEEN]:
        table_of_effects(options, of_eighteen)
    table_of_regret(options, rows)
