"""Where the instructions of an iteration go, by part of the library.

The program is instructions/main.cpp compiled with -g1 -no-pie. An instruction belongs to the part
whose file is innermost in its stack of inlined calls; GLM, the standard library and the C library
belong to whoever calls them. The table has instructions a pixel and iteration.
"""
import re

import callgrind
from measuring import Table, in_parallel

PROGRAM = "the program itself"
SIZE = 64
ITERATIONS = 8
PARTS = [  # name, files below include/gmis/
    ("rays: tree, packets", r"scene/(bvh|packets|lanes|box)\.hpp|core/axis_lanes\.hpp"),
    ("hits and offsets", r"scene/(bvh_scene|edge_margin|surface_coordinates|position_error)\.hpp|core/interaction\.hpp|transport/state/first_hit\.hpp"),
    ("random numbers", r"core/(random|wyrand|sobol_numbers)\.hpp"),
    ("weights", r"transport/weights/|core/extended\.hpp"),
    ("BSDF", r"scene/(bsdf|material|fresnel|microfacet|rough_dielectric|either_bsdf|varying_material|texture)\.hpp"),
    ("lights", r"scene/(light[a-z_]*|alias_table|spot_cone|environment_map|emission_pattern)\.hpp|core/light_choice\.hpp|transport/emission/"),
    ("camera", r"scene/camera\.hpp"),
    ("scatter", r"transport/state/scatter\.hpp"),
    ("next event", r"transport/techniques/next_event\.hpp"),
    ("connect", r"transport/techniques/connect\.hpp"),
    ("merge", r"transport/techniques/merge\.hpp"),
    ("splat, emitter hit", r"transport/techniques/(splat|emitter_hit)\.hpp"),
    ("photons: cache, grid", r"transport/photons/"),
    ("walks", r"transport/(walk|context|splitting)/|transport/state/(vertex|sample_counts|path_filter|path_class)\.hpp"),
    ("engine, film", r"transport/(engine|state)/|result/"),
]
MATCHERS = [(name, re.compile(files)) for name, files in PARTS]


def part_of(file):
    if "/include/gmis/" not in file:
        return PROGRAM if "/bench/" in file or "/examples/" in file else None
    below = file.split("/include/gmis/")[1]
    return next((name for name, files in MATCHERS if files.match(below)), None)


def parts_of(program, scene, integrator):
    """Instructions a pixel and iteration, by part."""
    run = lambda iterations: [f"tests/program/reference/{scene}.pbrt", integrator, str(iterations), str(SIZE)]
    sums = callgrind.shares(program, run(1), run(1 + ITERATIONS), part_of)
    by_part = {name: sums[name] / (SIZE * SIZE * ITERATIONS) for name in [name for name, _ in PARTS] + [PROGRAM]}
    return by_part | {"all": sum(by_part.values())}


def table(program):
    cases = ["svcm0 vcm", "svcm1 vcm", "svcm1 pt"]
    columns = dict(in_parallel(lambda case: parts_of(program, *case.split()), cases))
    result = Table("part", *cases, numbers_from=1)
    for part in columns[cases[0]]:
        result.add(part, *(f"{columns[case][part]:.0f}" for case in cases))
    return result
