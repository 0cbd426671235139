"""Tests of examples/wild.py --silhouettes: a square whose corners in the picture are computed here.

Usage: wild_test.py PROGRAM [unittest's options]
"""

import base64
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

WILD = pathlib.Path(__file__).resolve().parents[2] / "examples" / "wild.py"
PROGRAM = sys.argv.pop(1)
SIZE, SIDE, POSITION = 200, 0.4, (0.5, 0.2, 0.9)


def has_libraries(python):
    return subprocess.run([python, "-c", "import numpy, PIL"], capture_output=True).returncode == 0


PYTHON = next((python for python in (sys.executable, "/usr/bin/python3") if has_libraries(python)), None)


def corners():
    """Corners of the square |x|, |y| <= SIDE, z = 0, seen from POSITION towards the origin."""
    def dot(a, b):
        return sum(x * y for x, y in zip(a, b))

    def unit(a):
        return [x / math.sqrt(dot(a, a)) for x in a]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    ahead = unit([-x for x in POSITION])
    right = unit(cross(ahead, (0, 1, 0)))
    up = cross(right, ahead)
    for x, y in ((-SIDE, -SIDE), (SIDE, -SIDE), (SIDE, SIDE), (-SIDE, SIDE)):
        d = [x - POSITION[0], y - POSITION[1], -POSITION[2]]
        scale = SIZE / 2 / math.tan(0.4) / dot(d, ahead)
        yield SIZE / 2 + scale * dot(d, right), SIZE / 2 - scale * dot(d, up)


def write_models(folder):
    """A square with its picture, and the same with its picture 10 pixels to the right."""
    points = struct.pack("<12f", -SIDE, -SIDE, 0, SIDE, -SIDE, 0, SIDE, SIDE, 0, -SIDE, SIDE, 0)
    data = points + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    model = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.2]}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-SIDE, -SIDE, 0], "max": [SIDE, SIDE, 0]},
                      {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]}
    models = []
    for name, shift in (("here", 0), ("shifted", 10)):
        (folder / f"{name}.gltf").write_text(json.dumps(model))
        draw = f"i = Image.new('RGB', ({SIZE}, {SIZE})); ImageDraw.Draw(i).polygon({[(x + shift, y) for x, y in corners()]}, 'white')"
        subprocess.run([PYTHON, "-c", f"from PIL import Image, ImageDraw; {draw}; i.save({str(folder / name)!r} + '.png')"], check=True)
        models.append({"fileName": f"{name}.gltf", "sampleImageName": f"{name}.png", "camera": {"translation": POSITION}})
    (folder / "Manifest.json").write_text(json.dumps({"models": models}))


def silhouettes(python, folder, *options):
    done = subprocess.run([*python, str(WILD), PROGRAM, str(folder), "--silhouettes", *options], capture_output=True, text=True)
    return done.returncode, done.stdout.splitlines(), done.stderr


class Silhouettes(unittest.TestCase):
    @unittest.skipUnless(PYTHON, "no numpy or no PIL")
    def test_contour_is_found_where_the_picture_has_it_and_missed_elsewhere(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            write_models(folder)
            files = sorted(folder.iterdir())
            code, lines, error = silhouettes([PYTHON], folder)
            self.assertEqual(files, sorted(folder.iterdir()), "nothing is written beside the models")
        self.assertEqual((code, error), (0, ""))
        shares = {line.split()[1]: float(line.split()[0].rstrip("%")) for line in lines[:2]}
        self.assertEqual(shares["here.gltf"], 100)
        # The two upright sides are 10 pixels off; the other two lie on edges or near them.
        self.assertLess(shares["shifted.gltf"], 60)
        self.assertIn(f"2 contours, mean {sum(shares.values()) / 2:.1f}"[:-2], lines[3])
        self.assertIn("below 90 %: 1", lines[3])
        self.assertEqual([line.split()[1] for line in lines[4:]], ["shifted.gltf"])

    def test_what_is_missing_is_said_in_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            code, lines, error = silhouettes([sys.executable, "-S", "-E"], folder)
            self.assertEqual((code, lines), (1, []))
            self.assertRegex(error, r"^wild.py: --silhouettes: \S+ has no numpy \(Debian: python3-numpy, python3-pil\)\n$")
            if PYTHON:
                self.assertRegex(silhouettes([PYTHON], folder)[2], r"^wild.py: no pictures with cameras below \S+\n$")


if __name__ == "__main__":
    unittest.main()
