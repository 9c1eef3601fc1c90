# SPDX-License-Identifier: BSD-3-Clause
"""A measured point with noise of range, position and attitude: published combinations, covariance, samples [Vrba 2025, sec. IV-A].

The ray is the x axis of the LiDAR. Errors and covariances are in the frame of the LiDAR.
"""
import itertools

import numpy as np
from swiftlet.functions import point_covariances

SIGMA_RAD = (0.005, 0.05, 0.5)  # standard deviation of the attitude, per axis, eqs. (50) to (53)
SIGMA_M = (0.01, 0.1, 1.0)  # standard deviation of range and position, per axis
RANGE_M = (24.0, 48.0, 72.0)  # ranges of Table I
COMBINATIONS = tuple(itertools.product(SIGMA_RAD, SIGMA_M, RANGE_M))


def covariances_m2(sigma_rad, sigma_m, range_m):
    """(n, 3, 3) covariances of points at the ranges (n,), J Sigma_w J^T of eq. (44)."""
    range_m = np.atleast_1d(range_m)
    return point_covariances(np.tile([1.0, 0.0, 0.0], (range_m.size, 1)), range_m, np.eye(3), sigma_range_m=sigma_m,
                             sigma_position_m=[sigma_m] * 3, sigma_attitude_rad=[sigma_rad] * 3)


def sample_errors_m(rng, count, sigma_rad, sigma_m, range_m):
    """(count, 3) positions of true points relative to the measured one for random noise, eqs. (38) to (41), not linearized."""
    along_m = sigma_m * rng.standard_normal((count, 1))  # range
    shift_m = sigma_m * rng.standard_normal((count, 3))  # position
    beta, gamma = sigma_rad * rng.standard_normal((2, count))  # attitude about y and z; about x, the ray, it has no effect
    direction = np.stack([np.cos(gamma) * np.cos(beta), np.sin(gamma) * np.cos(beta), -np.sin(beta)], axis=1)
    return (range_m + along_m) * direction + shift_m - [range_m, 0.0, 0.0]


def panels(title, y_labels, sharey="row"):
    """(figure, axes): panels over the range, a row for each label, a column for each attitude noise."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=(10, 1.0 + 3.0 * len(y_labels)), layout="constrained")
    figure.suptitle(title)
    axes = figure.subplots(len(y_labels), len(SIGMA_RAD), sharex=True, sharey=sharey, squeeze=False)
    for panel, sigma_rad in zip(axes[0], SIGMA_RAD):
        panel.set_title(f"σ_rad = {sigma_rad:g} rad")
    for panel in axes[-1]:
        panel.set_xlabel("range [m]")
    for row, label in zip(axes, y_labels):
        row[0].set_ylabel(label)
    return figure, axes
