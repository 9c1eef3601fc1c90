# SPDX-License-Identifier: BSD-3-Clause
"""Gaussian approximation of a measured point against Monte-Carlo [Vrba 2025, Table I]

The Gaussian approximation of a measured point is compared with 10⁵ Monte-Carlo samples, by the difference of probability over
100 × 100 × 100 regions that cover the samples. The document does not state the orientation of the regions. With regions along the
ray every row agrees to a few percent. Along the world's axes, at a random attitude, more regions are empty, which lowers the mean
by a fifth. The probabilities of the approximation are integrals for regions along the ray, and shares of 5 · 10⁶ samples for the
others.
"""
import math

import numpy as np
from shared.point_noise import COMBINATIONS, RANGE_M, SIGMA_M, covariances_m2, panels, sample_errors_m

SAMPLES = 100_000  # N, as published
CELLS = 100  # regions along an axis, as published
CHUNKS = 50  # samples of the approximation for regions along the world's axes, in N
REGIONS = ("along the ray", "along the world")


def shares(points_m, low_m, cell_m):
    """Share of the points in each region, flat; points outside of the regions count as none."""
    at = np.floor((points_m - low_m) / cell_m).astype(np.int64)
    inside = ((at >= 0) & (at < CELLS)).all(axis=1)
    return np.bincount(at[inside] @ [CELLS * CELLS, CELLS, 1], minlength=CELLS**3) / len(points_m)


def integrated(covariance_m2, low_m, cell_m):
    """Probability of each region under a normal distribution with a diagonal covariance."""
    edges = (low_m[:, None] + cell_m[:, None] * np.arange(CELLS + 1)) / np.sqrt(2.0 * np.diagonal(covariance_m2))[:, None]
    x, y, z = np.diff(0.5 * np.vectorize(math.erf)(edges))
    return (x[:, None, None] * y[:, None] * z).ravel()


def compare(index, repetition, along_world):
    """Difference of probability over the regions, for one combination: [largest, mean, deviation]."""
    rng = np.random.default_rng([index, repetition, along_world])
    # Attitude relative to the regions: a random orthogonal matrix.
    R = np.linalg.qr(rng.standard_normal((3, 3)))[0] if along_world else np.eye(3)
    covariance_m2 = covariances_m2(*COMBINATIONS[index])[0]
    points_m = sample_errors_m(rng, SAMPLES, *COMBINATIONS[index]) @ R.T
    low_m = points_m.min(axis=0)
    cell_m = (points_m.max(axis=0) - low_m) * (1.0 + 1e-9) / CELLS  # the last region has the farthest point
    if along_world:
        to_world = np.sqrt(np.diagonal(covariance_m2))[:, None] * R.T
        approximation = sum(shares(rng.standard_normal((SAMPLES, 3)) @ to_world, low_m, cell_m) for _ in range(CHUNKS)) / CHUNKS
    else:
        approximation = integrated(covariance_m2, low_m, cell_m)
    difference = np.abs(shares(points_m, low_m, cell_m) - approximation)
    return [float(difference.max()), float(difference.mean()), float(difference.std())]


def name_of(quantity, combination):
    """Row of a combination, as in published.csv."""
    return "{}, sigma_rad {:g}, sigma_m {:g} m, d {:g} m".format(quantity, *combination)


def draw(experiment, results):
    figure, axes = panels("Gaussian approximation against Monte-Carlo (Table I)", ["mean difference [-]", "largest difference [-]"])
    for row, quantity, column in ((axes[0], "mean", 1), (axes[1], "largest", 0)):
        published = [experiment.published(name_of(quantity, one)).value for one in COMBINATIONS]
        ray, world = results[..., column].mean(axis=2)
        for label, values, marker in (("published", published, "ko"), (REGIONS[0], ray, "C0x"), (REGIONS[1], world, "C1+")):
            for panel, of_attitude in zip(row, np.reshape(values, (3, 9))):
                panel.plot(of_attitude, marker, label=label)
        row[0].set_ylim(bottom=0.0)
    for panel in axes[1]:
        panel.set_xticks(range(9), [f"{sigma_m:g} m, {range_m:g} m" for sigma_m in SIGMA_M for range_m in RANGE_M], rotation=90)
        panel.set_xlabel("position noise, range")
    axes[0, 2].legend()
    experiment.write_figure("uncertainty-table.svg", figure)


def run(experiment):
    repetitions = experiment.repetitions(3, 1)
    cases = [{"index": index, "repetition": repetition, "along_world": along_world} for along_world in (False, True)
             for index in range(len(COMBINATIONS)) for repetition in range(repetitions)]
    found = experiment.map(compare, cases, "combinations")
    experiment.write_csv("uncertainty-table.csv",
                         ["regions", "sigma_rad", "sigma_m", "range_m", "repetition", "largest", "mean", "deviation"],
                         [[REGIONS[case["along_world"]], *COMBINATIONS[case["index"]], case["repetition"], *one]
                          for case, one in zip(cases, found)])
    results = np.reshape(found, (2, len(COMBINATIONS), repetitions, 3))  # [regions, combination, repetition, quantity]
    draw(experiment, results)

    # Over all regions of all combinations; of the largest the median over repetitions.
    largest = np.sort(results[..., 0].max(axis=1))[:, (repetitions - 1) // 2]
    mean = results[..., 1].mean(axis=(1, 2))
    most = 1.25 * experiment.published("largest difference").value
    experiment.within("mean difference over all regions", mean[0], 0.25, 3)
    experiment.at_most("largest difference", largest[0], most, 3)
    experiment.within("standard deviation over all regions", np.sqrt((results[0, ..., 2] ** 2).mean()), 0.25, 3)
    experiment.within("mean, regions along the world's axes", mean[1], 0.25, 3,
                      "a flat distribution fills less of a box that lies at an angle")
    experiment.at_most("largest, regions along the world's axes", largest[1], most, 3, "median over sets of random attitudes")
    for combination, means in zip(COMBINATIONS, results[0, ..., 1].mean(axis=1)):
        experiment.within(name_of("mean", combination), means, 0.25, 3)
