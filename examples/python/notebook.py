"""A notebook as a script, in cells that Jupyter and editors understand (# %%): notebook.py
[FOLDER].

Figures go to FOLDER where one is given and matplotlib is there; else to the screen.
"""

# %% Three proposals, one integrand, six schemes
import pathlib
import sys

import numpy as np

import gmis

f = lambda x: np.exp(-0.2 * x**2) * (1.0 + 0.5 * np.sin(3.0 * x))
proposals = gmis.Normals(means=[-3, 0, 3], deviations=[2, 2, 2])
for scheme in gmis.SCHEMES:
    estimate = gmis.estimate(scheme, f, proposals, rounds=100_000, seed=1)
    print(f"{scheme}  {estimate.mean:.4f}, error {estimate.standard_error:.4f}")


# %% Proposals of your own: whole arrays, never a call a sample
class Laplace:
    def __init__(self, centre, scale):
        self.centre, self.scale = centre, scale

    def rvs(self, size, random_state):
        return random_state.laplace(self.centre, self.scale, size)

    def pdf(self, x):
        return np.exp(-np.abs(x - self.centre) / self.scale) / (2.0 * self.scale)


own = [Laplace(-1.0, 2.0), Laplace(1.0, 2.0)]
estimate = gmis.estimate(gmis.Power(2), f, own, rounds=100_000, counts=[2, 1])
print(f"power heuristic: {estimate.mean:.4f} ± {estimate.standard_error:.4f}")

# %% Exact moments, the best sample allocation, weights
problem = gmis.Problem(f, proposals, gmis.line_rule(0, 3, 48), name="three normals")
for scheme in gmis.SCHEMES:
    mean, variance = problem.moments(scheme)
    print(f"{scheme}  exact variance of a round {variance:.6g}")
counts = problem.optimal_counts(12)
_, variance = problem.moments("N3", counts=counts)
print(f"N3 with counts {counts}: {variance:.6g}")
x = np.linspace(-8.0, 8.0, 200)
weights = gmis.weights(gmis.Balance(), [1, 1, 1], gmis.densities(proposals, x))

# %% Schemes side by side, and a round of your own
def antithetic(count, seed):
    x = np.random.default_rng(seed).normal(0.0, 2.0, count)
    density = np.exp(-x * x / 8.0) / np.sqrt(8.0 * np.pi)
    return (f(x) + f(-x)) / (2.0 * density)


contenders = [*gmis.SCHEMES, "S3W1", gmis.Groups(2), ("antithetic", antithetic)]
contenders.append(("power, 2:1:2", {"method": gmis.Power(2), "counts": [2, 1, 2]}))
comparison = gmis.compare(problem, contenders, seconds=0.02)
print(comparison)

# %% A scene: its picture, and the error on the way
picture = gmis.render("cornell", error=0.1, seconds=20, size=(64, 48))
print(f"{picture.iterations} iterations, relative error {picture.error:.3f} in {picture.interval}")

# %% Figures
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no matplotlib here: no figures")
    sys.exit(0)
figure, panels = plt.subplots(2, 2, figsize=(10, 8), layout="constrained")
for i in range(3):
    panels[0, 0].plot(x, weights[i], label=f"proposal {i + 1}")
panels[0, 0].set(title="weights of the balance heuristic", xlabel="x")
panels[0, 0].legend()
for row in gmis.rows(comparison):
    seconds = np.geomspace(1e-5, 1.0)
    panels[0, 1].loglog(seconds, np.sqrt(row["seconds_to_1_percent"] * 1e-4 / seconds), label=row["contender"])
panels[0, 1].set(title="relative standard error", xlabel="processor time [s]")
panels[0, 1].legend()
panels[1, 0].imshow(np.clip(picture.beauty, 0.0, 1.0) ** (1.0 / 2.2))
panels[1, 0].set(title="cornell")
log = picture.log
panels[1, 1].loglog(log["iteration"], log["error"], "o-")
panels[1, 1].fill_between(log["iteration"], log["lower"], log["upper"], alpha=0.3)
panels[1, 1].set(title="estimated error and its interval", xlabel="iteration")
if len(sys.argv) > 1:
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "notebook.png", dpi=80)
else:
    plt.show()
