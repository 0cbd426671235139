#!/usr/bin/env python3
"""Compiles every header of include/ and of tests/support/ as the first of a file, or after headers
that it includes itself: it finds nothing there that it does not ask for.

    alone.py COMPILER [OPTION ...]

One compilation takes a chain of headers, each of which includes the one before it: two hundred and
seventy headers take a third as many compilations. The chains are those that leave least to compile.
Prints those that fail.
"""

import concurrent.futures
import functools
import os
import pathlib
import re
import subprocess
import sys

PROJECT = pathlib.Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
STANDARD_BYTES = 20000  # of this library take about as long as a header of the standard library


class Headers:
    def __init__(self):
        self.path = {}
        for root, folder in (("include", "gmis"), ("tests", "support")):
            for path in (PROJECT / root / folder).rglob("*.hpp"):
                self.path[path.relative_to(PROJECT / root).as_posix()] = path

    @functools.cache
    def text(self, name):
        return self.path[name].read_text(encoding="utf-8")

    @functools.cache
    def below(self, name):
        """All that a header includes, itself too; names of other people's headers among them."""
        if name not in self.path:
            return frozenset([name])
        return frozenset([name]).union(*(self.below(ours or theirs) for ours, theirs in INCLUDE.findall(self.text(name))))

    def cost(self, name):
        return sum(len(self.text(other)) if other in self.path else STANDARD_BYTES for other in self.below(name))


def chains(headers):
    """Lists of headers, each header in one of them, first or after one that it includes. A list
    costs what its last header costs, so the dearest headers get another after them first."""
    users = {name: [] for name in headers.path}
    for user in headers.path:
        for name in headers.below(user) - {user}:
            if name in users:
                users[name].append(user)
    before = {}

    def takes_place(name, seen):
        """Finds a header to come after this one, moving others if need be."""
        for user in users[name]:
            if user not in seen:
                seen.add(user)
                if user not in before or takes_place(before[user], seen):
                    before[user] = name
                    return True
        return False

    for name in sorted(headers.path, key=lambda name: (-headers.cost(name), name)):
        takes_place(name, set())
    found = []
    for last in sorted(set(headers.path) - set(before.values())):
        chain = [last]
        while chain[-1] in before:
            chain.append(before[chain[-1]])
        found.append(chain[::-1])
    return found


def compile_chain(command, chain):
    program = "".join(f'#include "{name}"\n' for name in chain)
    return subprocess.run(command, input=program, capture_output=True, text=True, check=False)


def main():
    ours = (f"-I{PROJECT}/{root}" for root in ("include", "tests"))
    command = [*sys.argv[1:], *ours, "-fsyntax-only", "-x", "c++", "-"]
    headers = Headers()
    found = chains(headers)
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for chain, result in zip(found, pool.map(functools.partial(compile_chain, command), found)):
            if result.returncode:
                failed += 1
                print(f"{' → '.join(chain)}:\n{result.stderr}")
    print(f"{len(headers.path)} headers in {len(found)} chains; {failed} do not compile")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
