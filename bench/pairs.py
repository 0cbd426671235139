"""One option of gmis-render with two values, compared by their efficiency."""

import statistics

from measuring import render


class Pair:
    def __init__(self, option, plain, other):
        self.option, self.plain, self.other = option, plain, other

    def head(self):
        return (f"relMSE {self.plain}", self.other, "without the worst 0.1 % of the pixels", self.other, "processor seconds", self.other,
                "efficiency", "without the worst")

    def cells(self, options, scene, *arguments):
        """Means over the seeds, whose runs take turns. Efficiency: relMSE × seconds of the plain
        value over that of the other."""
        figures = {self.plain: [], self.other: []}
        for seed in range(1, options.seeds + 1):
            for value, rows in figures.items():
                stats = render(options, scene, *arguments, f"--{self.option} {value} --iterations {options.iterations} --seed {seed}")
                rows.append((stats["error"]["relmse"], stats["error"]["relmse_trimmed"], stats["seconds"]["cpu"]))
        plain, other = ([statistics.fmean(column) for column in zip(*rows)] for rows in figures.values())
        return [f"{figure:.5f}" if k < 2 else f"{figure:.2f}" for k in range(3) for figure in (plain[k], other[k])] + [
            f"{plain[k] * plain[2] / (other[k] * other[2]):.2f}" for k in range(2)]
