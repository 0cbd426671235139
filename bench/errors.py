"""Errors of pictures against two references; the bias that pictures of several seeds share."""

import itertools
import math
import statistics


def products(one, other, references):
    """Products of two relative errors, each against its own reference: one for each pixel, the
    mean over channels."""
    terms = [(x - a) * (y - b) / (((a + b) / 2) ** 2 + 0.01) for x, y, a, b in zip(one, other, *references)]
    return [sum(terms[k:k + 3]) / 3 for k in range(0, len(terms), 3)]


def relmse(picture, references):
    """The squared relative error against the mean of two references, without their noise: the mean
    over all pixels, and that without the worst thousandth of them."""
    squares = sorted(products(picture, picture, references))
    return statistics.fmean(squares), statistics.fmean(squares[:len(squares) - len(squares) // 1000])


def mean_of_blocks(values, width):
    """The mean over pixels without the thousandth that lie farthest off on either side, and its
    standard error from blocks of 8 × 8 pixels: merging spreads a photon over neighbours, and what
    the reference has hardly found lies in a few pixels."""
    order = sorted(range(len(values)), key=values.__getitem__)
    few = max(1, len(values) // 1000)
    left = order[few:-few]
    sums = {}
    for pixel in left:
        block = (pixel // width // 8, pixel % width // 8)
        sums[block] = sums.get(block, 0.0) + values[pixel]
    mean = sum(sums.values()) / len(left)
    of_block = mean * len(left) / len(sums)
    return mean, math.sqrt(sum((s - of_block)**2 for s in sums.values())) / len(left)


def squared_bias(pictures, references, width):
    """The squared relative bias that pictures of several seeds share, and its standard error: the
    mean product of the errors of two seeds, one against either reference, so that no noise of a
    picture or of a reference is in it."""
    pairs = [products(a, b, references) for a, b in itertools.permutations(pictures, 2)]
    if not pairs:
        return math.nan, math.nan
    return mean_of_blocks([statistics.fmean(values) for values in zip(*pairs)], width)
