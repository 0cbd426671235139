"""The cost of accuracy: time and variance of every scheme, of groups of proposals between N1 and
N3, and of weights in float and in double (bench/schemes.cpp).

Writes three tables in docs/accuracy-and-time.md.
"""

import json
import subprocess

from measuring import Table, publish

PROGRAM = "schemes"
DOCUMENT = "docs/accuracy-and-time.md"
SCHEMES = ("R1", "R2", "R3", "N1", "N2", "N3")


def two_digits(value):
    return f"{float(f'{value:.2g}'):g}"


def of_schemes(problems):
    table = Table("N = 16", "mismatch", *SCHEMES, numbers_from=2)
    rows = {problem["problem"]: {row["contender"]: row for row in problem["rows"]} for problem in problems}
    table.add("densities a round", "any", *(f"{rows['low'][scheme]['density_evaluations']:.0f}" for scheme in SCHEMES))
    for name, schemes in rows.items():
        table.add("variance of a round", name, *(two_digits(schemes[scheme]["variance"]) for scheme in SCHEMES))
    for name, schemes in rows.items():
        seconds = [schemes[scheme]["seconds_to_1_percent"] for scheme in SCHEMES]
        table.add("time to an error, N3 = 1", name, *(two_digits(value / seconds[-1]) for value in seconds))
    table.note("Variances are exact, but those of R2 and N2, which are averaged over random indices.")
    return table


def of_groups(problems):
    table = Table("mismatch", "cost of a density", *(f"P = {row['contender'].rpartition(' ')[2]}" for row in problems[0]["rows"]), numbers_from=1)
    for problem in problems:
        rows = problem["rows"]
        # The cost of one density, from the times of groups of one and of a single group.
        first, last = rows[0], rows[-1]
        density = (last["nanoseconds_per_round"] - first["nanoseconds_per_round"]) / (last["density_evaluations"] - first["density_evaluations"])
        for factor in (1, 256):
            works = [row["variance"] * (row["nanoseconds_per_round"] + (factor - 1) * density * row["density_evaluations"]) for row in rows]
            table.add(problem["problem"], f"{density:.0f} ns" if factor == 1 else f"{factor} times that", *(two_digits(min(works) / work) for work in works))
    return table


def of_numbers(rows):
    table = Table("", "numbers", "time", "error, rms", "largest", numbers_from=2)
    for row in rows:
        table.add(row["what"], row["numbers"], f"{row['ns'] / 1000:.2g} µs", f"{row['rms']:.0e}", f"{row['largest']:.0e}")
    return table


def run(options):
    figures = json.loads(subprocess.run([options.program], check=True, capture_output=True, text=True).stdout)
    for name, table_of in (("schemes", of_schemes), ("groups", of_groups), ("numbers", of_numbers)):
        publish(options, table_of(figures[name]), DOCUMENT, name)
        print()
