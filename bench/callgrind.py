"""Callgrind's profiles by the source that instructions come from, which line tables with inlined
calls tell."""

import collections
import os
import re
import subprocess
import tempfile


def frames_of(program, addresses):
    """The source files at each address of the program, by its stack of inlined calls, innermost
    first."""
    text = "".join(f"0x{a:x}\n" for a in addresses)
    output = subprocess.run(["addr2line", "-a", "-i", "-e", program], input=text, capture_output=True, text=True, check=True).stdout
    result, address = {}, None
    for line in output.splitlines():
        if re.fullmatch(r"0x[0-9a-f]+", line):
            address = int(line, 16)
            result[address] = []
        else:
            result[address].append(os.path.normpath(line.rsplit(":", 1)[0]))
    return result


def owners_of(program, addresses, owner):
    """The answer of `owner` for the innermost file at each address that it says anything of; None
    where it says nothing."""
    return {address: next((o for o in map(owner, frames) if o is not None), None)
            for address, frames in frames_of(program, addresses).items()}


class Profile:
    """Callgrind's counts: of every function its own by address, and its calls with their inclusive
    counts."""

    def __init__(self, path):
        self.own = collections.Counter()  # (function, address)
        self.calls = collections.Counter()  # (function, address, called)
        self.object_of = {}
        names = {}

        def named(kind, text):
            found = re.match(r"\((\d+)\)(?: (.*))?", text)
            if found.group(2) is not None:
                names[kind, found.group(1)] = found.group(2)
            return names[kind, found.group(1)]

        current = called = here = called_object = None
        is_call = False
        address = 0
        for line in open(path, encoding="utf-8", errors="replace"):
            line = line.rstrip("\n")
            if line.startswith("ob="):
                here = named("ob", line[3:])
            elif line.startswith("cob="):
                called_object = named("ob", line[4:])
            elif line.startswith("fn="):
                current = (here, named("fn", line[3:]))
                called_object = None
            elif line.startswith("cfn="):
                called = (called_object or here, named("fn", line[4:]))
                called_object = None
            elif line.startswith(("fl=", "fi=", "fe=")):
                named("fl", line[3:])
            elif line.startswith(("cfi=", "cfl=")):
                named("fl", line[4:])
            elif line.startswith("calls="):
                is_call = True
            elif line and (line[0] in "0123456789+-*"):
                words = line.split()
                first = words[0]
                if first.startswith("+"):
                    address += int(first[1:], 0)
                elif first.startswith("-"):
                    address -= int(first[1:], 0)
                elif first != "*":
                    address = int(first, 0)
                cost = int(words[2]) if len(words) > 2 else 0
                if is_call:
                    self.calls[current, address, called] += cost
                else:
                    self.own[current, address] += cost
                is_call = False


def counted(command):
    """(instructions of its own by function and address, inclusive ones by call) of a command."""
    with tempfile.TemporaryDirectory() as folder:
        out = f"{folder}/profile"
        subprocess.run(["valgrind", "--tool=callgrind", "--dump-instr=yes", f"--callgrind-out-file={out}", *command], check=True,
                       capture_output=True)
        profile = Profile(out)
    return profile.own, profile.calls


def counted_more(program, less, more):
    """Counts of a run of `program` with the arguments `more`, less those with the arguments
    `less`."""
    pairs = zip(counted([program, *more]), counted([program, *less]))
    return [collections.Counter({key: count - fewer[key] for key, count in many.items() if count > fewer[key]}) for many, fewer in pairs]


def shares(program, less, more, owner):
    """The instructions of that difference by owner. Functions that nobody owns count for whoever
    calls them. Give the program a fixed address (-no-pie): addresses are looked up as linked."""
    own, calls = counted_more(program, less, more)
    mine = lambda function: os.path.basename(function[0]) == os.path.basename(program)
    addresses = sorted({a for f, a in own if mine(f)} | {a for f, a, _ in calls if mine(f)})
    by_address = owners_of(program, addresses, owner)
    owner_at = lambda function, address: by_address[address] if mine(function) else None

    # Functions without an owner are charged to their callers, by inclusive counts; repeated, since
    # they call each other.
    callers = collections.defaultdict(list)
    for (function, address, called), count in calls.items():
        if called != function:
            callers[called].append((function, owner_at(function, address), count))
    owners = {o for o in by_address.values() if o is not None}
    part = {}  # what share of a function's callers is whose
    for function in {f for f, _ in own} | set(callers) | {f for f, _, _ in calls}:
        part[function] = dict.fromkeys(owners, 1 / max(1, len(owners)))
    for _ in range(50):
        for function, sites in callers.items():
            total = sum(count for _, _, count in sites)
            sums = collections.Counter()
            for caller, whose, count in sites:
                for other, share in ({whose: 1.0} if whose is not None else part[caller]).items():
                    sums[other] += share * count / total
            part[function] = dict(sums)
    sums = collections.Counter()
    for (function, address), count in own.items():
        whose = owner_at(function, address)
        for other, share in ({whose: 1.0} if whose is not None else part[function]).items():
            sums[other] += share * count
    return sums
