"""What the measuring scripts share: the scenes, the pictures that gmis-render writes, tables inside documents."""

import array
import math
import sys

OWN = ["all_glossy", "caustic_pool", "light_behind_glass", "many_lights", "mirror_hall", "mixed", "one_point_light", "open_sky",
       "slit"]
TEMPTING = ["all_narrow", "camera_in_water", "far_sun", "huge_ground", "keyhole", "none_narrow", "panes", "rare_caustic",
            "telephoto", "two_scales"]
BUILT_IN = ["cornell", "paper1", "paper2", "paper3", "paper4"]
# Name: what the renderer is told.
FOURTEEN = {name: name for name in BUILT_IN} | {name: f"bench/scenes/{name}.pbrt" for name in OWN}
# Scenes of other renderers, with their pictures, of 128x128 pixels and paths of at most 10 segments.
FOREIGN = {name: f"tests/program/reference/{name}.pbrt" for name in ("svcm0", "svcm1", "tung1", "tung2")}
ALL = FOURTEEN | {name: f"bench/scenes/tempting/{name}.pbrt" for name in TEMPTING}


def read_pfm(file):
    """All channels of all pixels, as an array of floats."""
    *head, rest = file.read_bytes().split(b"\n", 3)
    values = array.array("f", rest)
    if (float(head[2]) < 0) != (sys.byteorder == "little"):
        values.byteswap()
    return values


def own_errors(pictures, longer=None):
    """The error of every picture, relative as a run states it, against the mean of what the other seeds have: their pictures, or
    `longer` ones of theirs with the same mean. The two halves a and b of the others, and (x - a) (x - b) in place of a square,
    keep the noise of the others out; merging's bias, which all seeds have alike, is not in it either."""
    longer = pictures if longer is None else longer
    count, squares = len(pictures), [0.0] * len(pictures)
    sizes = (len(longer[0::2]), len(longer[1::2]))
    for k in range(len(pictures[0])):
        others = [picture[k] for picture in longer]
        sums = (sum(others[0::2]), sum(others[1::2]))
        for seed, own in enumerate(others):
            a, b = ((sums[side] - own) / (sizes[side] - 1) if side == seed % 2 else sums[side] / sizes[side] for side in (0, 1))
            mean = (sums[0] + sums[1] - own) / (count - 1)
            x = pictures[seed][k]
            squares[seed] += (x - a) * (x - b) / (mean * mean + 0.01)
    return [math.sqrt(max(square, 0.0) / len(pictures[0])) for square in squares]


def write_into(document, begin, end, table):
    """Puts a table between two marks of a document; nothing where the marks are not there."""
    text = document.read_text()
    if begin in text:
        before, rest = text.split(begin, 1)
        document.write_text(before + begin + "\n" + table + end + rest.split(end, 1)[1])
