# SPDX-License-Identifier: BSD-3-Clause
"""Probability that a measured point lies in the right voxel [Vrba 2025, Fig. 6]

Probability that the true point lies in the voxel of 1 m in which it was measured. The document does not state where in the voxel
the point lies: solid lines have it in the middle, dashed lines anywhere with equal probability. Crosses are 10⁶ samples without
linearization, of points in the middle. `swiftlet uncertainty` computes this for any sensor and noise.
"""
import math

import numpy as np
from shared.point_noise import COMBINATIONS, SIGMA_M, SIGMA_RAD, covariances_m2, panels, sample_errors_m
from swiftlet.functions import box_probability

EDGE_M = 1.0  # voxel edge, as published
RANGE_M = np.arange(0.0, 81.0)  # ranges in the figure


def in_the_middle(sigma_rad, sigma_m, range_m):
    """Probability of the right voxel for a point measured in its middle, eq. (65)."""
    half_m = np.full(3, EDGE_M / 2)
    return box_probability(np.zeros(3), covariances_m2(sigma_rad, sigma_m, range_m)[0], -half_m, half_m)


def anywhere(sigma_rad, sigma_m, range_m):
    """The same for a point anywhere in the voxel with equal probability: the product over the axes of the mean of max(0, 1 - |x|),
    x: error in edges."""
    sigmas = np.sqrt(np.diagonal(covariances_m2(sigma_rad, sigma_m, range_m)[0])) / EDGE_M
    return math.prod(math.erf(math.sqrt(0.5) / s) - s * math.sqrt(2.0 / math.pi) * -math.expm1(-0.5 / s**2) for s in sigmas)


def sample(index, count):
    """Share of random true points, without linearization, in the right voxel, for one combination."""
    errors_m = sample_errors_m(np.random.default_rng(index), count, *COMBINATIONS[index])
    return float((np.abs(errors_m) < EDGE_M / 2).all(axis=1).mean())


def draw(experiment, sampled):
    figure, (axes,) = panels("Probability of the right voxel of 1 m (Fig. 6)", ["probability [-]"])
    rows = []
    for panel, sigma_rad in zip(axes, SIGMA_RAD):
        for i, sigma_m in enumerate(SIGMA_M):
            middle, mean = ([of(sigma_rad, sigma_m, range_m) for range_m in RANGE_M] for of in (in_the_middle, anywhere))
            rows += [[sigma_rad, sigma_m, *values] for values in zip(RANGE_M.tolist(), middle, mean)]
            panel.plot(RANGE_M, middle, f"C{i}", label=f"σ_m = {sigma_m:g} m")
            panel.plot(RANGE_M, mean, f"C{i}--", linewidth=1, label="point anywhere in it" if i == 0 else None)
        panel.plot(*zip(*((one[2], share) for one, share in zip(COMBINATIONS, sampled) if one[0] == sigma_rad)), "kx",
                   label="Monte-Carlo")
    axes[1].legend()
    experiment.write_csv("voxel-probability.csv", ["sigma_rad", "sigma_m", "range_m", "middle", "anywhere"], rows)
    experiment.write_figure("voxel-probability.svg", figure)


def run(experiment):
    count = 100_000 if experiment.quick else 1_000_000
    sampled = experiment.map(sample, [{"index": index, "count": count} for index in range(len(COMBINATIONS))], "combinations")
    draw(experiment, sampled)
    experiment.at_least("right voxel at 20 m, sigma_rad 0.005, sigma_m 0.01 m", in_the_middle(0.005, 0.01, 20.0), 0.99, 3)
    experiment.at_most("right voxel at 40 m, sigma_rad 0.05, sigma_m 0.01 m", in_the_middle(0.05, 0.01, 40.0), 0.2, 3)
    experiment.at_most("right voxel at 40 m, sigma_rad 0.5, sigma_m 0.01 m", in_the_middle(0.5, 0.01, 40.0), 0.01, 3)
    experiment.at_most("linearized against true probability, worst of 27 combinations",
                       max(abs(in_the_middle(*one) - share) for one, share in zip(COMBINATIONS, sampled)), 0.01, 2,
                       f"{count:.0e} samples without linearization")
