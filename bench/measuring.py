"""What the measuring scripts share: the scenes, the pictures that gmis-render writes, tables inside documents."""

import array
import sys

OWN = ["all_glossy", "caustic_pool", "light_behind_glass", "many_lights", "mirror_hall", "mixed", "one_point_light", "open_sky",
       "slit"]
TEMPTING = ["all_narrow", "camera_in_water", "far_sun", "huge_ground", "keyhole", "none_narrow", "panes", "rare_caustic",
            "telephoto", "two_scales"]
BUILT_IN = ["cornell", "paper1", "paper2", "paper3", "paper4"]
# Name: what the renderer is told.
FOURTEEN = {name: name for name in BUILT_IN} | {name: f"bench/scenes/{name}.pbrt" for name in OWN}
ALL = FOURTEEN | {name: f"bench/scenes/tempting/{name}.pbrt" for name in TEMPTING}


def read_pfm(file):
    """All channels of all pixels, as an array of floats."""
    *head, rest = file.read_bytes().split(b"\n", 3)
    values = array.array("f", rest)
    if (float(head[2]) < 0) != (sys.byteorder == "little"):
        values.byteswap()
    return values


def write_into(document, begin, end, table):
    """Puts a table between two marks of a document; nothing where the marks are not there."""
    text = document.read_text()
    if begin in text:
        before, rest = text.split(begin, 1)
        document.write_text(before + begin + "\n" + table + end + rest.split(end, 1)[1])
