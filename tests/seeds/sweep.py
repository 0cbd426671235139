#!/usr/bin/env python3
"""Runs the tests that draw random numbers with GMIS_TEST_SEED=1 to N and reports which cases fail,
and how often.

A statistical test raises a false alarm in a thousandth of the seeds or less. A case that fails in
more runs than that rate explains (with a chance below 1e-3) is a finding: then the exit code is 1.
Single failures are listed with the seed that replays them. Build first: `./run test --seeds N` does
both.
"""

import argparse
import concurrent.futures
import json
import math
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as xml

RATE = 1e-3  # false alarms of a test case, in seeds
LEAST_CHANCE = 1e-3


def chance_of(failures, runs, rate=RATE):
    """Probability that a case with this rate fails this number of times or more often."""
    return sum(math.comb(runs, k) * rate**k * (1 - rate) ** (runs - k) for k in range(failures, runs + 1))


def seeded_tests(build, pattern, part, with_slow):
    """Names and commands, from CTest: the programs whose sources take their seeds from
    gmis_test::seed."""
    listed = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True, check=True)
    tests = []
    for test in json.loads(listed.stdout)["tests"]:
        properties = {p["name"]: p["value"] for p in test.get("properties", [])}
        labels = properties.get("LABELS", [])
        if "seeded" not in labels or ("slow" in labels and not with_slow) or not re.search(pattern, test["name"]):
            continue
        if part and part not in labels:
            continue
        if "command" not in test or not os.path.exists(test["command"][0]):
            print(f"not built: {test['name']}", file=sys.stderr)
            continue
        tests.append((test["name"], test["command"], properties.get("WORKING_DIRECTORY")))
    return tests


def failed_cases(output):
    """Names of the failed cases in Catch's XML; where the program died, the case that was
    running."""
    try:
        root = xml.fromstring(output)
    except xml.ParseError:
        names = re.findall(r'<TestCase name="([^"]*)"', output)
        return [names[-1] + " (the program died)"] if names else ["(the program died)"]
    return [
        case.get("name") for case in root.iter("TestCase")
        if case.find("OverallResult") is not None and case.find("OverallResult").get("success") == "false"
    ]


def run(job):
    name, command, folder, seed = job
    result = subprocess.run([*command, "--reporter", "xml"], capture_output=True, text=True, errors="replace",
                            env={**os.environ, "GMIS_TEST_SEED": str(seed)}, cwd=folder)
    cases = failed_cases(result.stdout)
    if result.returncode != 0 and not cases:
        cases = [f"(ends with {result.returncode})"]
    return name, seed, cases


def main():
    parser = argparse.ArgumentParser(prog="tests/seeds/sweep.py", description=__doc__.split("\n\n")[0])
    parser.add_argument("build", help="a build folder, such as build/release")
    parser.add_argument("seeds", type=int, help="how many seeds")
    parser.add_argument("--tests", default="", help="only tests whose name has a match of this regular expression")
    parser.add_argument("--part", help="only tests of this folder of tests/")
    parser.add_argument("--slow", action="store_true", help="the slow tests too")
    parser.add_argument("--first", type=int, default=1, help="the first seed (1)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()

    tests = seeded_tests(options.build, options.tests, options.part, options.slow)
    if not tests:
        sys.exit("no such tests are built")
    jobs = [(*test, seed) for test in tests for seed in range(options.first, options.first + options.seeds)]
    print(f"{len(tests)} programs, {options.seeds} seeds", flush=True)
    seeds_of = {}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for name, seed, cases in pool.map(run, jobs):
            for case in cases:
                print(f"{name}: {case}: fails with GMIS_TEST_SEED={seed}", flush=True)
                seeds_of.setdefault((name, case), []).append(seed)

    findings = 0
    print(f"\n{len(jobs)} runs, {sum(map(len, seeds_of.values()))} failures of {len(seeds_of)} cases")
    for (name, case), seeds in sorted(seeds_of.items(), key=lambda item: -len(item[1])):
        chance = chance_of(len(seeds), options.seeds)
        is_finding = chance < LEAST_CHANCE
        findings += is_finding
        print(f"  {len(seeds):3} of {options.seeds}  {name}: {case}: seeds {' '.join(map(str, seeds))}; by chance "
              f"{chance:.1e}" + ("  TOO OFTEN" if is_finding else ""))
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
