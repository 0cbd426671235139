"""Tests of bench/figures.py over a small project: marks, stamps, staleness, quoted values.

Usage: figures_test.py [unittest's options]
"""

import contextlib
import io
import os
import pathlib
import shutil
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import figures  # noqa: E402

PAGE = """# Page

The error falls to <!-- value speed: geometric mean: error -->0.5<!-- /value --> of it.
A pair: <!-- value speed: a / pt: error -->1<!-- /value -->.

<!-- speed: written by ./measure -->
| scene | by | error |
| --- | --- | --- |
| a | pt | 1 |
| a | vcm | **2** |
| geometric mean | | 0.5 |
<!-- end of speed -->

More text.
"""
REGISTRY = "[@code]\nsources = include\n[speed]\nminutes = 1\nsources = @code bench/measure.py\n"


class Figures(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for name, text in {
            "docs/page.md": PAGE,
            "bench/figures.ini": REGISTRY,
            "bench/measure.py": "# a note\nprint(1)\n",
            "include/a.hpp": "int a;  // a note\nconst char* b = \"// no note\";\n",
        }.items():
            file = self.root / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        self.page = self.root / "docs" / "page.md"
        measure = self.root / "measure"
        measure.write_text(
            f"#!/usr/bin/env python3\nimport pathlib, sys\nsys.path.insert(0, {str(pathlib.Path(figures.__file__).parent)!r})\n"
            "import figures\nproject = figures.Project(pathlib.Path('.'))\nfigure, = project.figures()\n"
            "project.put(figure.page, 'speed', './measure', figure.body.replace('0.5', '0.25'))\n"
        )
        measure.chmod(0o755)

    def project(self):
        return figures.Project(self.root)

    def figure(self):
        return self.project().figures()[0]

    def state(self):
        return self.project().state(self.figure())

    def write(self, name, text):
        (self.root / name).write_text(text)

    def test_a_figure_without_a_stamp_is_stale(self):
        self.assertIn("without a stamp", self.state())

    def test_put_writes_body_and_stamp_and_keeps_the_page(self):
        self.assertTrue(self.project().put(self.page, "speed", "./measure", "| x |\n"))
        text = self.page.read_text()
        self.assertIn("<!-- speed: written by ./measure -->\n| x |\n<!-- end of speed -->\n<!-- stamp of speed: digest ", text)
        self.assertTrue(text.startswith(PAGE.split("<!-- speed:")[0]))
        self.assertTrue(text.endswith("\n\nMore text.\n"))
        self.assertIsNone(self.state())
        self.assertTrue(self.project().put(self.page, "speed", "./measure", "| y |\n"))
        self.assertEqual(self.page.read_text().count("stamp of speed"), 1)
        self.assertEqual(self.page.read_text().count("<sub>"), 1)
        self.assertFalse(self.project().put(self.page, "other", "./measure", "| x |\n"))

    def test_a_column_may_have_a_colon(self):
        self.page.write_text(PAGE.replace("| by | error |", "| by | g++: error |").replace(": error -->", ": g++: error -->"))
        self.assertEqual(self.project().check(), [])

    def test_a_word_with_a_minus_takes_files_out(self):
        self.write("bench/figures.ini", REGISTRY.replace("sources = include", "sources = include -include/b*"))
        self.project().put(self.page, "speed", "./measure")
        self.write("include/b.hpp", "int c;\n")
        self.assertIsNone(self.state())
        self.write("include/c.hpp", "int c;\n")
        self.assertIn("sources have changed", self.state())

    def test_words_may_change_and_code_may_not(self):
        self.project().put(self.page, "speed", "./measure")
        self.write("include/a.hpp", "// another note\nint   a;\nconst char* b = \"// no note\";\n")
        self.write("bench/measure.py", "print(1)\n")
        self.assertIsNone(self.state())
        self.write("include/a.hpp", "int a;\nconst char* b = \"// other text\";\n")
        self.assertIn("have changed", self.state())
        self.write("include/a.hpp", "int a;  // a note\nconst char* b = \"// no note\";\n")
        self.assertIsNone(self.state())
        self.write("include/new.hpp", "int c;\n")
        self.assertIn("have changed", self.state())

    def test_run_measures_stamps_and_takes_values(self):
        with contextlib.redirect_stderr(io.StringIO()) as said:
            self.assertTrue(self.project().run(["speed"]))
        self.assertRegex(said.getvalue(), r"\./measure took 0\.\d minutes\nfigures: all took 0\.\d minutes")
        self.assertIsNone(self.state())
        text = self.page.read_text()
        self.assertIn("geometric mean: error -->0.25<!-- /value -->", text)
        self.assertEqual(self.project().check(), [])

    def test_minutes_are_sixty_seconds(self):
        self.assertEqual(figures.minutes_since(time.monotonic() - 90), "1.5 minutes")

    def confirm(self, before, ratios, but=(), only_fixed=False):
        project = self.project()
        return project.confirm(project.confirmable(before, but, only_fixed), ratios)

    def test_confirm_keeps_what_was_fresh_and_rests_on_the_program(self):
        self.project().put(self.page, "speed", "./measure")
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(self.root, folder, dirs_exist_ok=True)
            before = figures.Project(pathlib.Path(folder))
            self.write("include/a.hpp", "int c;\n")
            self.assertEqual(self.confirm(before, "0.99 to 1.01"), [])
            self.write("bench/figures.ini", REGISTRY + "confirm = yes\n")
            old = self.figure()
            self.write("bench/measure.py", "print(2)\n")
            self.assertEqual(self.confirm(before, "0.99 to 1.01"), [])
            self.write("bench/measure.py", "print(1)\n")
            row = next(line for line in self.figure().body.splitlines() if "geometric mean" in line).split("|")[1].strip()
            self.assertEqual(self.confirm(before, "0.99 to 1.01", [row]), [])
            self.assertEqual(self.confirm(before, "0.99 to 1.01", ["another"]), ["speed"])
            self.assertIsNone(self.state())
            self.assertEqual((self.figure().commit, self.figure().date), (old.commit, old.date))
            self.assertIn("makes the same pictures with 0.99 to 1.01 times the instructions.</sub>", self.page.read_text())
            self.assertEqual(self.confirm(before, "0.99 to 1.01"), [])
            # Again: it is compared with what it was measured with.
            self.write("include/a.hpp", "int d;\n")
            self.assertIn("have changed", self.state())
            self.assertEqual(self.confirm(before, "0.97 to 1.00", only_fixed=True), [])
            self.write("bench/figures.ini", REGISTRY + "confirm = fixed counts\n")
            self.assertEqual(self.confirm(before, "0.97 to 1.00", only_fixed=True), ["speed"])
            self.write("include/a.hpp", "int e;\n")
            self.assertEqual(self.confirm(before, "0.97 to 1.00"), ["speed"])
            self.assertIn("with 0.97 to 1.00 times the instructions.</sub>", self.page.read_text())
            self.assertEqual((self.figure().measured, self.figure().commit), (old.digest, old.commit))
            # It was measured with other sources.
            self.write("include/a.hpp", "int g;\n")
            (before.root / "include/a.hpp").write_text("int f;\n")
            self.assertEqual(self.confirm(before, "0.99 to 1.01"), [])
            self.assertIn("have changed", self.state())

    def test_a_command_that_fails_leaves_no_stamp(self):
        self.write("measure", "#!/bin/sh\nexit 1\n")
        self.assertFalse(self.project().run([]))
        self.assertIn("without a stamp", self.state())
        self.assertFalse(self.project().run(["unknown"]))

    def test_a_command_that_writes_nothing_leaves_no_stamp(self):
        self.write("measure", "#!/bin/sh\nexit 0\n")
        self.assertFalse(self.project().run([]))
        self.assertIn("without a stamp", self.state())

    def test_what_a_command_lacks_is_said_and_it_does_not_run(self):
        for lack, said in (("argument = GMIS_TEST_NO_SUCH_VARIABLE", "set GMIS_TEST_NO_SUCH_VARIABLE"), ("needs = no_such_program", "install no_such_program")):
            self.write("bench/figures.ini", f"{REGISTRY}{lack}\n")
            self.assertIn(said, self.project().lacks("speed"))
            self.assertFalse(self.project().run([]))
            self.assertIn("without a stamp", self.state())

    @unittest.skipIf((os.cpu_count() or 1) < 2, "one processor")
    def test_figures_that_take_one_processor_are_made_side_by_side(self):
        names = ("one", "two")
        self.page.write_text("".join(f"<!-- {name}: written by ./measure_{name} -->\n| x |\n<!-- end of {name} -->\n" for name in names))
        self.write("bench/figures.ini", "".join(f"[{name}]\nprocessors = 1\nsources = include\n" for name in names))
        for name, other in zip(names, reversed(names)):
            # Waits for the other one, then writes as often as would lose an entry if they did not
            # take turns.
            self.write(f"measure_{name}", (self.root / "measure").read_text().split("figure, =")[0] + (
                f"import time\npathlib.Path('{name}.begun').touch()\nend = time.monotonic() + 30\n"
                f"while not pathlib.Path('{other}.begun').exists():\n  assert time.monotonic() < end\n  time.sleep(0.01)\n"
                f"for k in range(50): project.put(pathlib.Path('docs/page.md'), '{name}', './measure_{name}', f'| {{k}} |')\n"))
            (self.root / f"measure_{name}").chmod(0o755)
        self.assertTrue(self.project().run([]))
        self.assertEqual([figure.body for figure in self.project().figures()], ["| 49 |\n"] * 2)

    def test_sound_pages_have_no_faults(self):
        self.assertEqual(self.project().check(), [])

    def test_a_table_of_numbers_has_marks_or_a_reason(self):
        table = "| scene | time |\n| --- | ---: |\n| a | {} |\n| b | {} |\n"
        fault = "docs/page.md:16: a table of numbers without marks: which command writes it?"
        for cells in (("1", "2.5 %"), ("0.41 µs", "−3e-5"), ("12 ± .4", "4,590"), ("1", "none")):
            with self.subTest(cells):
                self.page.write_text(PAGE + "\n" + table.format(*cells))
                self.assertEqual(self.project().check(), [fault])
        for reason in ("no measurement: by arithmetic", "measured once: commit 0123456"):
            self.page.write_text(PAGE + f"\n<!-- {reason} -->\n" + table.format("1", "2"))
            self.assertEqual(self.project().check(), [])
        self.page.write_text(PAGE + "\n<!-- no measurement: -->\n" + table.format("1", "2"))
        self.assertEqual(len(self.project().check()), 1)
        for text in (table.format("fast", "slow"), "| exit code | |\n| --- | --- |\n| 0 | all is well |\n"):
            self.page.write_text(PAGE + "\n" + text)
            self.assertEqual(self.project().check(), [])

    def test_faults_are_named(self):
        for before, after, fault in (
            ("error -->0.5<", "error -->0.6<", "docs/page.md:3: the text says 0.6, the table 0.5"),
            ("geometric mean: error", "median: error", "no value"),
            ("a / pt: error", "a / lt: error", "no value"),
            ("The error falls to <!-- v", "The error falls to\n<!-- v", "must not begin"),
            ("<!-- speed: written", "<!-- fast: written", "no section"),
        ):
            with self.subTest(fault):
                text = PAGE.replace(before, after).replace("end of speed", "end of fast" if "fast" in after else "end of speed")
                self.page.write_text(text)
                self.assertTrue(any(fault in f for f in self.project().check()), self.project().check())
        self.page.write_text(PAGE.replace("end of speed", "end of something"))
        with self.assertRaises(ValueError):
            self.project().check()
        self.page.write_text(PAGE)
        self.write("bench/figures.ini", REGISTRY + "[gone]\nsources = include\n")
        self.assertIn("bench/figures.ini: gone stands in no page", self.project().check())
        self.write("bench/figures.ini", "[speed]\nsources = nowhere\n")
        self.assertTrue(any("depends on no file" in f for f in self.project().check()))


if __name__ == "__main__":
    unittest.main()
