"""Tests of the statistics of bench/benches/effects.py: paces, works, ratios and their intervals.

Usage: effects_test.py [unittest's options]
"""

import math
import pathlib
import random
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
from benches import effects  # noqa: E402


def run_of(did, iterations, error):
    return {"did": did, "iterations": iterations, "relMSE": error}


class Statistics(unittest.TestCase):
    def test_a_pace_is_all_seconds_over_all_iterations_and_a_work_takes_it(self):
        clock = effects.Clock()
        clock.take("a", 1.0, 8)
        clock.take("a", 6.0, 32)
        self.assertEqual(clock.pace("a"), 7 / 40)
        self.assertAlmostEqual(effects.work([run_of("a", 20, 0.1), run_of("a", 40, 0.3)], "relMSE", clock).mean, (2 + 12) / 2 * 7 / 40)

    def test_where_both_do_the_same_the_clock_has_no_part(self):
        clock = effects.Clock()
        for did, seconds in (("a", 1.0), ("a", 1.4), ("b", 1.0), ("b", 1.4)):
            clock.take(did, seconds, 10)
        works = {did: effects.work([run_of(did, 10, 0.5)] * 4, "relMSE", clock) for did in "ab"}
        self.assertEqual(works["a"].spread, 0)
        self.assertEqual(effects.ratio(works["a"], works["a"], 4), (1, 1, 1))
        # Two timings of each, .2 / 1.2 off on either side: the standard error of a pace is a sixth.
        _, lower, upper = effects.ratio(works["a"], works["b"], 4)
        self.assertAlmostEqual(math.log(upper), 1.645 * math.sqrt(2) / 6)
        self.assertAlmostEqual(lower * upper, 1)

    def test_intervals_hold_the_truth(self):
        # 400 ratios of equal works by four seeds and seven timings of either side. If an interval
        # holds the truth with a probability of .9, fewer than 335 do with one of 4e-5; if with .95,
        # more than 395 do with one of 1.3e-5.
        draw, held = random.Random(20261130), 0
        for _ in range(400):
            clock, works = effects.Clock(), {}
            for did in "abcdefgh":
                for _ in range(7):
                    clock.take(did, draw.gauss(1, 0.1), 10)
            for did in "ab":
                works[did] = effects.work([run_of(did, 10, draw.gauss(1, 0.1)) for _ in range(4)], "relMSE", clock)
            _, lower, upper = effects.ratio(works["a"], works["b"], 4)
            held += lower <= 1 <= upper
        self.assertGreaterEqual(held, 335)
        self.assertLess(held, 396)

    def test_hopeless_is_what_is_dear_by_every_measure(self):
        works = {"best": [1, 2], "dear once": [5, 2.9], "dear": [1.5, 3]}
        self.assertEqual(effects.not_hopeless(works), ["best", "dear once"])
        self.assertEqual(effects.not_hopeless({}), [])


if __name__ == "__main__":
    unittest.main()
