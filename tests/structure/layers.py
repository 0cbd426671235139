#!/usr/bin/env python3
"""Checks that each layer of include/gmis includes only layers below it, and that folders form no
cycle: layers.py INCLUDE-FOLDER.

Prints every include that its layer may not have, every arrow between rooms that points up, and one
cycle between the folders of a layer.
"""

import pathlib
import re
import sys

# From the bottom: each layer, and the layers that it may include.
LAYERS = {
    "core": [],
    "mis": ["core"],
    "result": ["core"],
    "scene": ["core"],
    "transport": ["core", "result", "mis"],
    "render": ["core", "result", "transport"],
    "check": ["core", "mis", "transport"],
    "testing": ["core", "mis"],
    "benchmark": ["core", "mis"],
}
# The folders of a layer from the bottom, where their order is fixed: each includes those before it
# only. Headers directly in the layer's folder are the room ".", but for ROOM.hpp, which belongs to
# the room it is called after. A layer that is not here must be without a cycle, and no more.
ROOMS = {
    "transport": ["state", "emission", "plan", "weights", "photons", "context", "techniques", "walk", "engine", "replay", "allocation",
                  "splitting"],
}
# Rooms that alone in their layer may include a further layer.
ONLY = {("transport", "mis"): ["splitting"]}
# Beside the layers stand gmis.hpp, which includes any of them, and for each layer LAYER.hpp, which
# includes what is in it.


def includes_of(root):
    """(including header, line, included header), each below the folder gmis."""
    for file in sorted((root / "gmis").rglob("*.hpp")):
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            found = re.match(r'\s*#\s*include\s*["<]gmis/([^">]+)[">]', line)
            if found:
                yield file.relative_to(root / "gmis"), number, pathlib.PurePath(found[1])


def layer_of(header):
    return header.parts[0] if len(header.parts) > 1 else ""


def rooms_with(root):
    """A function from a header to its room."""
    folders = {folder.relative_to(root / "gmis") for folder in (root / "gmis").glob("*/*") if folder.is_dir()}

    def room_of(header):
        if len(header.parts) == 2 and header.with_suffix("") in folders:
            return header.stem
        return "/".join(header.parts[1:-1]) or "."

    return room_of


def cycle_in(arrows):
    """The nodes of one cycle, from a node to itself; None where there is none."""
    state, path = {}, []

    def visit(node):
        state[node] = "open"
        path.append(node)
        for other in sorted(arrows.get(node, ())):
            if state.get(other) == "open":
                return path[path.index(other):] + [other]
            if other not in state:
                found = visit(other)
                if found:
                    return found
        state[node] = "closed"
        path.pop()
        return None

    for node in sorted(arrows):
        if node not in state:
            found = visit(node)
            if found:
                return found
    return None


def faults_of(root):
    room_of = rooms_with(root)
    rooms = {}  # layer: {room: {included room: where}}
    for header, line, included in includes_of(root):
        place = f"{header}:{line}"
        layer, other = layer_of(header), layer_of(included)
        if not layer:
            if header.name != "gmis.hpp" and (header.stem not in LAYERS or (other or included.stem) not in [header.stem, *LAYERS[header.stem]]):
                yield f"{place}: {header} includes {included}"
            continue
        if layer not in LAYERS:
            yield f"{place}: {layer} is no layer"
        elif not other:
            yield f"{place}: {layer} includes {included}, which includes layers above it"
        elif other != layer:
            if other not in LAYERS[layer]:
                yield f"{place}: {layer} includes {included}, but may include only {', '.join(LAYERS[layer]) or 'itself'}"
            elif room_of(header) not in ONLY.get((layer, other), [room_of(header)]):
                yield f"{place}: {room_of(header)} includes {included}, but of {layer} only {', '.join(ONLY[layer, other])} may include {other}"
        elif room_of(header) != room_of(included):
            rooms.setdefault(layer, {}).setdefault(room_of(header), {}).setdefault(room_of(included), f"{place} includes {included}")
    for layer, arrows in rooms.items():
        order = ROOMS.get(layer)
        for room, others in arrows.items() if order else ():
            for other, where in others.items():
                if room not in order or other not in order:
                    yield f"{where}: {room if room not in order else other} is not among the rooms of {layer}"
                elif order.index(other) > order.index(room):
                    yield f"{where}: an arrow up, from {room} to {other}"
        cycle = cycle_in(arrows)
        if cycle:
            yield f"{layer}: a cycle of folders: " + "; ".join(f"{a} → {b} ({arrows[a][b]})" for a, b in zip(cycle, cycle[1:]))


def main():
    faults = list(faults_of(pathlib.Path(sys.argv[1])))
    for fault in faults:
        print(fault)
    print(f"{len(faults)} faults")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
