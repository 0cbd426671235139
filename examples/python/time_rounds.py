"""100,000 rounds of N3 from Python, over the processor time of C++: time_rounds.py
TIME-ROUNDS-PROGRAM.

The least of 15 runs each; proposals of the library, of numpy, and of scipy where it is there.
"""

import subprocess
import sys
import time

import numpy as np

import gmis

MEANS, DEVIATION, ROUNDS = (-3.0, 0.0, 3.0), 2.0, 100_000


def f(x):
    return np.exp(-0.2 * x * x) * (1.0 + 0.5 * np.sin(3.0 * x))


class Normal:
    """A normal proposal as a user writes one."""

    def __init__(self, mean):
        self.mean = mean

    def rvs(self, size, random_state):
        return random_state.normal(self.mean, DEVIATION, size)

    def pdf(self, x):
        z = (x - self.mean) / DEVIATION
        return np.exp(-0.5 * z * z) / (DEVIATION * np.sqrt(2.0 * np.pi))


def seconds_and_mean(proposals):
    least = float("inf")
    for _ in range(15):
        start = time.process_time()
        mean = gmis.estimate("N3", f, proposals, ROUNDS, seed=1).mean
        least = min(least, time.process_time() - start)
    return least, mean


kinds = {"gmis.Normals": gmis.Normals(MEANS, [DEVIATION] * 3), "numpy": [Normal(mean) for mean in MEANS]}
try:
    from scipy.stats import norm

    kinds["scipy.stats.norm"] = [norm(mean, DEVIATION) for mean in MEANS]
except ImportError:
    pass
cpp, cpp_mean = map(float, subprocess.run(sys.argv[1], capture_output=True, text=True, check=True).stdout.split())
print(f"{'C++':18} {1e3 * cpp:6.1f} ms         mean {cpp_mean:.12g}")
for name, proposals in kinds.items():
    seconds, mean = seconds_and_mean(proposals)
    print(f"{name:18} {1e3 * seconds:6.1f} ms  {seconds / cpp:5.2f}  mean {mean:.12g}")
