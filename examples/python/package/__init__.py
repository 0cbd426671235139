"""gmis for Python: multiple importance sampling over numpy arrays, and rendering of scene files.

Proposals are a list of objects like scipy's frozen distributions,
`rvs(size=n, random_state=generator)` and `pdf(x)`, or `Normals`. The integrand takes all samples at
once and returns one number, or one row of numbers, for each.
"""

import dataclasses
import json

import numpy

from ._mis import Balance, Comparison, Cutoff, Groups, Maximum, Normals, Power, densities, interval_rule, line_rule, weights
from . import _mis

try:
    from . import _render
    from ._render import SceneError
except ImportError:  # a build without the reader of scene files
    _render = None


SCHEMES = ("R1", "R2", "R3", "N1", "N2", "N3")


@dataclasses.dataclass(frozen=True)
class Estimate:
    """The estimate of an integral; of an integrand with channels, arrays with one entry for
    each."""

    mean: float  # the estimate
    variance: float  # of one round; NaN for a single one
    standard_error: float  # of the mean; NaN for a single round
    rounds: int
    samples: int
    density_evaluations: int  # that the method needs
    integrand_evaluations: int
    rejected: dict  # samples that count as zero because something is wrong, by cause


def estimate(method, f, proposals, rounds, seed=0, counts=None, fractions=None, samples=None):
    """Estimates the integral of f from independent rounds of samples.

    `method` is a scheme, "R1" to "N3", a pair of selection and weighting, "S1W1" to "S3W5",
    Groups(size), or a heuristic such as Power(2). A round has one sample of each proposal, or
    `counts[i]`, or `samples` in all divided by `fractions`.
    """
    return Estimate(**_mis.estimate(method, f, proposals, rounds, seed, counts, fractions, samples))


class Problem:
    """An integral with its proposals at the points of a quadrature rule, for exact moments.

    `rule` is (points, weights), such as `line_rule` and `interval_rule` make: the first axis of the
    points goes over points. f has one channel.
    """

    def __init__(self, f, proposals, rule, name="problem"):
        points, node_weights = (numpy.asarray(part, dtype=float) for part in rule)
        self.f, self.proposals, self.name = f, proposals, name
        self._table = _mis.TabulatedProblem(
            numpy.asarray(f(points)), node_weights, densities(proposals, points)
        )

    @property
    def integral(self):
        """The integral of f, by the rule."""
        return self._table.integral

    def moments(self, method, counts=None, fractions=None, samples=None):
        """Exact mean and variance of the estimate of one round; arguments as of `estimate`."""
        return self._table.moments(method, counts, fractions, samples)

    def optimal_fractions(self, costs=(), least=0.0):
        """Fractions, each at least `least`, that minimise variance times cost of R3."""
        return self._table.optimal_fractions(list(costs), least)

    def optimal_counts(self, total, costs=()):
        """Counts, `total` in all, that make variance times cost of N3 small."""
        return numpy.array(self._table.optimal_counts(total, list(costs)))


def compare(problem, contenders=SCHEMES, seconds=0.2, seed=1):
    """Compares rounds: their variance, their time, and what follows from both.

    A contender is the name of a scheme or of a pair, Groups(size), or a name with what it stands
    for: (name, method), (name, {"method": method, "counts": [2, 1]}) with any arguments of
    `estimate` about a round, or (name, rounds), where `rounds(count, seed)` returns the estimates
    of `count` independent rounds of your own. Variances are exact up to 10 proposals, those of
    your own rounds measured in `seconds` of processor time each.
    """

    def made(contender):
        name, what = contender if isinstance(contender, tuple) else (str(contender), contender)
        if callable(what):
            return _mis.own_contender(name, what)
        asked = {"counts": None, "fractions": None, "samples": None} | (what if isinstance(what, dict) else {"method": what})
        return _mis.contender(name, problem._table, problem.f, problem.proposals, **asked)

    return _mis.compare(problem.name, problem.integral, [made(each) for each in contenders], seconds, seed)


def rows(comparison):
    """The lines of a comparison as a list of dictionaries; a number that is not finite is None."""
    return json.loads(comparison.json())["rows"]


@dataclasses.dataclass(frozen=True)
class Rendering:
    """A picture and all that is known of it. Arrays have a row for each row of pixels, from the
    top."""

    beauty: numpy.ndarray  # linear RGB
    variance: numpy.ndarray  # of the values of `beauty`; None where it is unknown
    albedo: numpy.ndarray  # RGB of the surfaces that camera rays hit first
    normal: numpy.ndarray  # unit vectors in the world, towards the camera, averaged over the pixel
    depth: numpy.ndarray  # distance from the camera; 0 where nothing is hit
    error: float  # estimated relative error of the picture; None after one iteration
    interval: tuple  # 95 % interval of `error`; None where it cannot be trusted
    log: dict  # columns iteration, cpu_seconds, wall_seconds, error, lower, upper
    prices: list  # iterations and seconds to reach errors
    iterations: int
    stopped_by: str
    wall_seconds: float
    cpu_seconds: float
    is_trustworthy: bool  # False where too many contributions were rejected
    notes: list  # warnings about the scene file


def render(scene, error=None, seconds=None, iterations=None, integrator="auto", size=None, seed=0, threads=0,
           max_depth=16):
    """Renders a .pbrt or glTF file, or a built-in scene by its name.

    Ends at the first limit that is met: relative `error`, wall `seconds`, `iterations`; 64
    iterations without any. `size` is (width, height), `threads` 0 all cores. Ctrl-C ends it with
    the picture so far. Where rare, bright samples rule the error it is not known well enough to end
    the run: give seconds, too.
    """
    if _render is None:
        raise ImportError("this build of gmis renders nothing: CLI11 or nlohmann_json was missing")
    return Rendering(
        **_render.render(str(scene), error, seconds, iterations, integrator, size, seed, threads, max_depth)
    )
