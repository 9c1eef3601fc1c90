# SPDX-License-Identifier: BSD-3-Clause
"""Expected error of a measured point over its range [Vrba 2025, Fig. 5]

Mean distance of the true point from the measured one. Lines are Nakagami's mean, eqs. 61 to 63 with Ω = tr Σ
([errata](../papers.md)). Crosses are 10⁶ samples without linearization. The table also compares Nakagami's mean with the exact
mean of the linearized, normal distribution, and the exact mean with the samples.
"""
import numpy as np
from shared.point_noise import COMBINATIONS, SIGMA_M, SIGMA_RAD, covariances_m2, panels, sample_errors_m
from swiftlet.functions import error_means_m

FARTHEST_M = 80.0  # range at the end of the figure
EXPECTED_M = 2.0  # error whose range is published


def exact_mean_m(covariance_m2):
    """Mean length of a normal vector with the covariance diag(a, b, b): 2 sqrt(2 / pi) times the mean standard deviation over all
    directions. Directions that are uniform on the sphere have a uniform cosine to the x axis."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    cosine_sq = (0.5 + 0.5 * nodes) ** 2
    a, b = covariance_m2[0, 0], covariance_m2[1, 1]
    return 2.0 * np.sqrt(2.0 / np.pi) * 0.5 * weights @ np.sqrt(a * cosine_sq + b * (1.0 - cosine_sq))


def sample(index, count):
    """Mean error of random true points, without linearization, for one combination."""
    errors_m = sample_errors_m(np.random.default_rng(index), count, *COMBINATIONS[index])
    return float(np.linalg.norm(errors_m, axis=1).mean())


def draw(experiment, sampled_m):
    figure, (axes,) = panels("Expected error of a measured point (Fig. 5)", ["expected error [m]"], sharey=False)
    range_m = np.arange(0.0, FARTHEST_M + 1.0)
    for panel, sigma_rad in zip(axes, SIGMA_RAD):
        for sigma_m in SIGMA_M:
            panel.plot(range_m, error_means_m(covariances_m2(sigma_rad, sigma_m, range_m)), label=f"σ_m = {sigma_m:g} m")
        panel.plot(*zip(*((one[2], mean_m) for one, mean_m in zip(COMBINATIONS, sampled_m) if one[0] == sigma_rad)), "kx",
                   label="Monte-Carlo")
    axes[0].legend()
    experiment.write_figure("expected-error.svg", figure)


def run(experiment):
    count = 100_000 if experiment.quick else 1_000_000
    sampled_m = experiment.map(sample, [{"index": index, "count": count} for index in range(len(COMBINATIONS))], "combinations")
    draw(experiment, sampled_m)
    covariances = np.concatenate([covariances_m2(*one) for one in COMBINATIONS])
    nakagami_m, exact_m = error_means_m(covariances), np.array([exact_mean_m(covariance) for covariance in covariances])
    experiment.write_csv("expected-error.csv", ["sigma_rad", "sigma_m", "range_m", "nakagami_m", "normal_m", "sampled_m"],
                         np.column_stack([COMBINATIONS, nakagami_m, exact_m, sampled_m]).tolist())

    for sigma_rad in (0.05, 0.5):
        ranges_m = np.arange(0.0, FARTHEST_M, 0.1)
        reached = error_means_m(covariances_m2(sigma_rad, 0.01, ranges_m)) >= EXPECTED_M
        experiment.at_most(f"range at which 2 m are expected, sigma_rad {sigma_rad:g} [m]",
                           ranges_m[reached.argmax()] if reached.any() else np.inf, 50.0, 3)
    experiment.at_most("Nakagami's mean against the exact one [share]", np.abs(nakagami_m / exact_m - 1.0).max(), 0.01, 2,
                       "the price of eqs. 61 to 63, worst of 27")
    linearization = np.abs(exact_m / sampled_m - 1.0).reshape(len(SIGMA_RAD), -1).max(axis=1)
    for sigma_rad, share in zip(SIGMA_RAD[:2], linearization):
        experiment.at_most(f"linearized against true mean, sigma_rad {sigma_rad:g} [share]", share, 0.01, 2)
    experiment.row("linearized against true mean, sigma_rad 0.5 [share]", f"{linearization[2]:.2g}", value=linearization[2],
                   note="half a radian is no small angle: the linearized error is too large by this")
