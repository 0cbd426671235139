#!/usr/bin/env python3
"""gmis.render against the program gmis-render, to the bit: render_test.py GMIS-RENDER|-."""

import os
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

import gmis

PROGRAM = ""


def pfm(file):
    """The pixels of a colour PFM file, rows from the top."""
    with open(file, "rb") as stream:
        assert stream.readline().strip() == b"PF"
        width, height = map(int, stream.readline().split())
        order = "<" if float(stream.readline()) < 0.0 else ">"
        return np.frombuffer(stream.read(), order + "f4").reshape(height, width, 3)[::-1]


class Render(unittest.TestCase):
    def test_the_picture_is_that_of_the_program(self):
        for scene, integrator in (("cornell", "auto"), ("tinted", "auto"), ("paper2", "vcm")):
            with tempfile.TemporaryDirectory() as folder:
                subprocess.run([PROGRAM, scene, "--integrator", integrator, "--size", "32x20", "--iterations", "12",
                                "--seed", "3", "--threads", "1", "--quiet", "--out", f"{folder}/out.pfm"], check=True)
                expected = pfm(f"{folder}/out.pfm")
            picture = gmis.render(scene, iterations=12, integrator=integrator, size=(32, 20), seed=3, threads=1)
            np.testing.assert_array_equal(picture.beauty, expected)
            self.assertEqual((picture.iterations, picture.stopped_by), (12, "iterations"))

    def test_layers_and_log(self):
        picture = gmis.render("cornell", iterations=16, size=(24, 16))
        for name, shape in (("beauty", (16, 24, 3)), ("variance", (16, 24, 3)), ("albedo", (16, 24, 3)),
                            ("normal", (16, 24, 3)), ("depth", (16, 24))):
            self.assertEqual(getattr(picture, name).shape, shape, name)
        self.assertTrue(np.all(np.linalg.norm(picture.normal, axis=2) < 1.0 + 1e-5))
        self.assertTrue(np.all((picture.albedo >= 0.0) & (picture.albedo <= 1.0)))
        self.assertGreater(picture.depth.max(), 0.0)
        self.assertEqual(picture.log["iteration"][-1], 16)
        self.assertAlmostEqual(picture.log["error"][-1], picture.error)
        self.assertTrue(picture.prices)
        self.assertGreater(picture.cpu_seconds, 0.0)
        again = gmis.render("cornell", iterations=16, size=(24, 16), threads=1)
        np.testing.assert_array_equal(picture.beauty, again.beauty)

    def test_an_error_ends_the_run(self):
        picture = gmis.render("cornell", error=0.2, seconds=60, size=(32, 24))
        self.assertEqual(picture.stopped_by, "error")
        self.assertLess(picture.error, 0.2)
        self.assertTrue(picture.interval[0] < picture.error < picture.interval[1])

    def test_ctrl_c_leaves_the_picture_so_far(self):
        timer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        picture = gmis.render("cornell", seconds=60, size=(32, 24))
        self.assertEqual(picture.stopped_by, "interrupt")
        self.assertGreater(picture.beauty.max(), 0.0)

    def test_bad_arguments(self):
        for arguments in ({"scene": "no_such_scene.pbrt"}, {"scene": "cornell", "error": -1.0},
                          {"scene": "cornell", "size": (0, 4)}, {"scene": "cornell", "integrator": "none"},
                          {"scene": "cornell", "iterations": 0}, {"scene": "cornell", "max_depth": 0}):
            with self.subTest(**arguments), self.assertRaises(ValueError):
                gmis.render(**arguments)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    if PROGRAM == "-":
        print("this build renders nothing: skipped")
        sys.exit(77)
    unittest.main()
