"""Shared by the programs inside other renderers: means and errors of their pictures."""

import math
import statistics


def mean_of(pictures):
    """Mean luminance of some pictures of other seeds, and its standard error: the larger one of
    that by the seeds and that by the pixels, taken as independent."""
    luminances = [[0.2126 * p[k] + 0.7152 * p[k + 1] + 0.0722 * p[k + 2] for k in range(0, len(p), 3)] for p in pictures]
    means = [statistics.fmean(one) for one in luminances]
    count, pixels, squares = len(means), len(luminances[0]), 0.0
    for values in zip(*luminances):
        middle = sum(values) / count
        squares += sum((value - middle)**2 for value in values) / (count - 1)
    return statistics.fmean(means), max(statistics.stdev(means), math.sqrt(squares) / pixels) / math.sqrt(count)


def relmse(picture, a, b):
    """Mean over all pixels, and without the worst 0.1 % of them; a and b: two pictures of the truth
    whose noise is independent."""
    pixels = sorted(sum((picture[k + c] - a[k + c]) * (picture[k + c] - b[k + c]) / (((a[k + c] + b[k + c]) / 2)**2 + 0.01) for c in range(3)) / 3
                    for k in range(0, len(a), 3))
    return statistics.fmean(pixels), statistics.fmean(pixels[:len(pixels) - max(1, len(pixels) // 1000)])


def average(pictures):
    return [statistics.fmean(values) for values in zip(*pictures)]


def apart(one, other):
    return f"{(one[0] - other[0]) / math.hypot(one[1], other[1]):+.1f}"
