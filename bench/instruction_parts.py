#!/usr/bin/env python3
"""Where the instructions of an iteration go, by part of the library: instruction_parts.py PROGRAM SCENE INTEGRATOR.

PROGRAM is instructions/main.cpp compiled with -g1 -no-pie. An instruction belongs to the part whose file is innermost in its stack of
inlined calls; GLM and the standard library belong to whoever calls them. Prints instructions a pixel and iteration, a line a part.
"""
import re
import sys

import callgrind

SIZE = 64
ITERATIONS = 8
PARTS = [  # name, files below include/gmis/
    ("rays: tree, packets", r"scene/(bvh|packets|lanes)\.hpp"),
    ("hits and offsets", r"scene/(bvh_scene|edge_margin|surface_coordinates)\.hpp|core/interaction\.hpp|transport/walk/first_hit\.hpp"),
    ("random numbers", r"core/(random|wyrand|sobol_numbers)\.hpp"),
    ("weights", r"transport/weights/|core/extended\.hpp"),
    ("BSDF", r"scene/(bsdf|material|fresnel|microfacet|rough_dielectric|either_bsdf|varying_material|texture)\.hpp"),
    ("lights", r"scene/(light|alias_table|spot_cone|environment_map)\.hpp|core/light_choice\.hpp"),
    ("camera", r"scene/camera\.hpp"),
    ("scatter", r"transport/(walk/)?scatter\.hpp"),
    ("next event", r"transport/(techniques/)?next_event\.hpp"),
    ("connect", r"transport/(techniques/)?connect\.hpp"),
    ("merge", r"transport/(techniques/)?merge\.hpp"),
    ("splat, emitter hit", r"transport/(techniques/)?(splat|emitter_hit)\.hpp"),
    ("photons: cache, grid", r"transport/(photons/)?(light_vertex_(cache|grid)|fit)\.hpp"),
    ("walks", r"transport/(walk/)?(camera_subpath|light_tree|vertex|context|children|split|light_subpath)\.hpp"),
    ("engine, film", r"transport/(engine|output/|[a-z_]*output|film)|result/"),
]
MATCHERS = [(name, re.compile(files)) for name, files in PARTS]


def part_of(file):
    if "/include/gmis/" not in file:
        return "the program itself" if "/bench/" in file or "/examples/" in file else None
    below = file.split("/include/gmis/")[1]
    return next((name for name, files in MATCHERS if files.match(below)), None)


def main():
    program, scene, integrator = sys.argv[1:]
    run = lambda iterations: [scene, integrator, str(iterations), str(SIZE)]
    sums = callgrind.shares(program, run(1), run(1 + ITERATIONS), part_of)
    pixels = SIZE * SIZE * ITERATIONS
    for name in [name for name, _ in PARTS] + ["the program itself"]:
        print(f"{name}\t{sums[name] / pixels:.0f}")
    print(f"all\t{sum(sums.values()) / pixels:.0f}")


if __name__ == "__main__":
    main()
