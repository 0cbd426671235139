"""Each check of this folder against small trees with one fault, which it must name, and against
trees without."""

import math
import pathlib
import random
import re
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "faults"), str(HERE.parent.parent / "bench")]

import fault_list
import layers
import measuring
import tokens
from benches import cycles
from cycles import description


class Layers(unittest.TestCase):
    def faults(self, **headers):
        """The faults of headers, whose name is their path with _ for / and whose value are the
        headers that they include."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            path_of = lambda name: name.replace("_", "/") + ".hpp"
            for name, included in headers.items():
                file = root / "gmis" / path_of(name)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text("".join(f'#include "gmis/{path_of(other)}"\n' for other in included.split()))
            return list(layers.faults_of(root))

    def test_arrows_down(self):
        self.assertEqual(self.faults(core_a="", mis_b="core_a", transport_walk_c="core_a", transport_splitting_e="mis_b transport_walk_c", render_d="transport_walk_c", render="render_d"), [])

    def test_transport_without_scene(self):
        self.assertIn("may include only", self.faults(transport_walk_a="scene_b")[0])

    def test_mis_in_splitting_only(self):
        self.assertIn("only splitting may include mis", self.faults(transport_walk_a="mis_b")[0])

    def test_core_includes_nothing(self):
        self.assertIn("only itself", self.faults(core_a="mis_b")[0])

    def test_a_layer_includes_no_summary(self):
        self.assertIn("layers above it", self.faults(transport_a="gmis")[0])

    def test_summaries(self):
        self.assertEqual(self.faults(mis="mis_a core_b", gmis="render_c", mis_methods="mis_methods_d", mis_methods_d="mis_e"), [])
        self.assertIn("mis.hpp includes", self.faults(mis="render_c")[0])

    def test_cycle(self):
        found = self.faults(scene_walk_a="scene_photons_b", scene_photons_b="scene_state_c", scene_state_c="scene_walk_d")
        self.assertEqual(len(found), 1)
        for room in ("walk", "photons", "state"):
            self.assertIn(room, found[0])

    def test_arrow_up(self):
        layers.ROOMS["mis"] = [".", "methods"]
        try:
            self.assertEqual(self.faults(mis_methods_a="mis_b"), [])
            self.assertIn("an arrow up", self.faults(mis_b="mis_methods_a")[0])
        finally:
            del layers.ROOMS["mis"]


CODE = """#pragma once
namespace gmis {  // a comment with a function(in) { it }
template <Scalar T, class F = std::function<void(int)>>
  requires(sizeof(T) > 2)
class Grid {
 public:
  explicit Grid(T size) : size_{size}, cells_(first(size) < 3) { build(size); }
  [[nodiscard]] T operator()(T x) const { return x < size_ ? x * size_ : T(0); }
  bool operator<(const Grid& other) const { return size_ < other.size_; }
  struct Cell { T x = T(1); };

 private:
  T size_;
};
template <class T>
T free(T a, T b) { return a - b; }
inline constexpr int most = 3;
}
"""


class Faults(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        file = pathlib.Path(self.folder.name) / "grid.hpp"
        file.write_text(CODE)
        self.headers = tokens.headers_in(pathlib.Path(self.folder.name))

    def tearDown(self):
        self.folder.cleanup()

    def planted(self, line):
        file = pathlib.Path(self.folder.name) / "faults.txt"
        file.write_text("@ test\n" + line + "\n")
        fault, = fault_list.read_faults(file)
        place, why = fault_list.place_of(fault, self.headers)
        return place.planted(fault.new) if place else why

    def test_scopes(self):
        found = {"::".join(scope.path) for scope in self.headers["grid.hpp"].scopes}
        self.assertLessEqual({"Grid", "Grid::Grid", "Grid::operator()", "Grid::operator<", "Grid::Cell", "Grid::Cell::x", "Grid::size_", "free", "most"}, found)

    def test_replaced_left_out_added(self):
        self.assertIn("a  +  b", self.planted("free/plus: a «- → +»"))
        self.assertIn("Grid(T size) : size_{size}, cells_(first(size) < 3) { }", " ".join(self.planted("Grid::Grid/drop_build: «build(size); → »").split()))
        self.assertIn("? x * T(1.01) * size_", " ".join(self.planted("operator()/scaled: x * « → T(1.01) *» size_").split()))

    def test_whitespace_does_not_matter(self):
        self.assertIn("return x  <=  size_", self.planted("Grid::operator()/equal:   x   «< → <=»   size_ ?x*size_"))

    def test_what_is_gone(self):
        self.assertIn("no longer in", self.planted("free/plus: a «* → +»"))
        self.assertIn("there is no", self.planted("gone/plus: a «- → +»"))
        self.assertIn("2 times", self.planted("operator</twice: size_« → + 1»"))

    def test_mechanical(self):
        found = {what for header in self.headers.values() for _, _, _, what in fault_list.mutations(header, "free")}
        self.assertEqual(found, {"- → +"})
        found = {what for header in self.headers.values() for _, _, _, what in fault_list.mutations(header, "Grid::Grid")}
        self.assertEqual(found, {"statement left out"})


class Tables(unittest.TestCase):
    def test_between_marks(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "page.md"
            file.write_text("a\n<!-- x: written by ./run bench x -->\nold\n<!-- end of x -->\nb\n")
            measuring.write_into(file, "x", "| new |\n")
            text = file.read_text()
            self.assertTrue(text.startswith("a\n<!-- x: written by ./run bench x -->\n| new |\n<!-- end of x -->\n"))
            self.assertTrue(text.endswith("\nb\n"))

    def test_pictures(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "picture.pfm"
            measuring.write_pfm(file, [1.0, 2.0, 3.0], "1x1")
            self.assertEqual(list(measuring.read_pfm(file)), [1.0, 2.0, 3.0])


class BesideCycles(unittest.TestCase):
    def read(self, name):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "scene.pbrt"
            file.write_text(description.without_phong((HERE.parents[1] / cycles.SCENES[name]).read_text()))
            return description.read(file)

    def test_scenes(self):
        for name in cycles.SCENES:
            scene = self.read(name)
            self.assertTrue([shape for shape in scene.shapes if shape.emission] or scene.distant, name)

    def test_lamp_shines_down(self):
        lamp = next(shape for shape in self.read("cornell").shapes if shape.emission)
        centre, x, y, normal = description.rectangle(lamp)
        for found, expected in ((centre, [2.8, 5.48, 2.8]), (normal, [0, -1, 0]), (sorted(map(abs, description.minus(x, y))), [0, 1.1, 1.3])):
            for a, b in zip(found, expected):
                self.assertAlmostEqual(a, b)

    def test_lamp_inside_glass(self):
        scene = self.read("light_behind_glass")
        self.assertEqual([description.around(shape, scene) for shape in scene.shapes if shape.emission], [1.5])

    def test_turned_block(self):
        # The block of paper4: 0.72 wide, turned by 28 degrees, around (0, -0.35).
        block = next(shape for shape in self.read("paper4").shapes if len(shape.points) == 8)
        c, s = math.cos(math.radians(28)), math.sin(math.radians(28))
        for a, b in zip(block.points[2], [-0.36 * c - 0.36 * s, 0.725, 0.36 * s - 0.36 * c - 0.35]):
            self.assertAlmostEqual(a, b)

    def test_camera_looks_along_forward(self):
        # paper4: from (.35, 1.3, -5.2) to (.02, .5, 0).
        camera = self.read("paper4").camera
        length = math.sqrt(0.33**2 + 0.8**2 + 5.2**2)
        for row, forward, origin in zip(camera, (-0.33, -0.8, 5.2), (0.35, 1.3, -5.2)):
            self.assertAlmostEqual(row[2], forward / length)
            self.assertAlmostEqual(row[3], origin)
        self.assertGreater(camera[0][0], 0)
        into = description.transform("LookAt", [0.35, 1.3, -5.2, 0.02, 0.5, 0, 0, 1, 0])
        for a, b in zip(description.moved(into, [0.02, 0.5, 0]), (0, 0, length)):
            self.assertAlmostEqual(a, b)

    def test_mixture_for_phong(self):
        text = description.without_phong('Material "phong" "rgb reflectance" [ .3 .3 .1 ] "rgb specular" [ .5 .5 .5 ] "float exponent" 48')
        for part in ("reflectance\" [ 0.6 0.6 0.2 ]", "roughness\" 0.2 ", "amount\" 0.5"):
            self.assertIn(part, text)

    def test_fresnel(self):
        self.assertAlmostEqual(description.fresnel(1, 0.2, 3.9), (0.8**2 + 3.9**2) / (1.2**2 + 3.9**2))
        # Without absorption: glass at 60 degrees, from Snell's law.
        inside = math.sqrt(1 - 0.75 / 2.25)
        s, p = (0.5 - 1.5 * inside) / (0.5 + 1.5 * inside), (0.75 - inside) / (0.75 + inside)
        self.assertAlmostEqual(description.fresnel(0.5, 1.5, 0), (s * s + p * p) / 2)

    def test_metal(self):
        eta, k = description.metal({"reflectance": [0.3, 0.5, 0.9]})
        for channel, expected in enumerate((0.3, 0.5, 0.9)):
            self.assertAlmostEqual(description.fresnel(1, eta[channel], k[channel]), expected)
        self.assertEqual(description.alpha_of({"roughness": [0.25]}), 0.5)
        self.assertEqual(description.alpha_of({"roughness": [0.25], "remaproughness": [False]}), 0.25)

    def test_sphere_mesh(self):
        points, triangles = description.sphere_mesh(4)
        normals = [description.cross(description.minus(points[b], points[a]), description.minus(points[c], points[a])) for a, b, c in triangles]
        self.assertEqual(len(triangles), 5120)
        self.assertTrue(all(description.dot(n, points[t[0]]) > 0 for n, t in zip(normals, triangles)))
        self.assertAlmostEqual(sum(math.sqrt(description.dot(n, n)) for n in normals) / 2 / (4 * math.pi), 1, places=2)

    def test_meshes_for_spheres(self):
        text = description.with_meshes('Shape "sphere" "float radius" .3 Shape "disk"')
        (indices,), (points,), (normals,) = ([[float(x) for x in values.split()] for values in re.findall(f'{name}" \\[([^]]*)', text)] for name in ("indices", "P", "N"))
        self.assertEqual(len(indices), 3 * 20 * 4**description.DIVISIONS)
        for values, radius in ((points, 0.3), (normals, 1)):
            self.assertEqual(len(values), 3 * (max(indices) + 1))
            self.assertAlmostEqual(description.dot(values[-3:], values[-3:]), radius**2, places=5)
        self.assertTrue(text.endswith('Shape "disk"'))

    def test_halves(self):
        self.assertEqual([list(half) for half in cycles.halves_of([[1.0], [2.0], [9.0], [4.0], [6.0]], 2)], [[2.5], [4.0]])

    def test_blocks_that_differ(self):
        numbers = random.Random(5)
        pictures = [[numbers.uniform(0.9, 1.1) for _ in range(3 * 32 * 32)] for _ in range(8)]
        darker = [[0.97 * value if k < 3 * 32 * 16 else value for k, value in enumerate(picture)] for picture in pictures]
        ratio, median, apart, vague, is_off = cycles.compare(pictures[:4], pictures[4:], "32x32")
        self.assertEqual((apart, is_off), (0, False))
        self.assertAlmostEqual(ratio, 1, places=2)
        self.assertEqual(cycles.compare(darker[:4], pictures[4:], "32x32")[2], 0.5)

    def test_pictures_that_differ_in_noise(self):
        def noisy(mean):  # blocks of 16x16 pixels, each 10 % off
            values = [[mean * numbers.uniform(0.83, 1.17) for _ in range(6)] for _ in range(6)]
            return [values[y // 16][x // 16] for y in range(96) for x in range(96) for _ in range(3)]

        numbers = random.Random(7)
        ours, alike, darker = ([noisy(mean) for _ in range(12)] for mean in (1, 1, 0.92))
        self.assertFalse(cycles.compare(alike, ours, "96x96")[4])
        ratio, _, apart, vague, is_off = cycles.compare(darker, ours, "96x96")
        self.assertAlmostEqual(ratio, 0.92, delta=0.02)
        self.assertEqual((apart < 0.1, vague, is_off), (True, 1, True))


if __name__ == "__main__":
    unittest.main()
