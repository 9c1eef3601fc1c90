# SPDX-License-Identifier: BSD-3-Clause
"""Statistics of many runs."""
import math

import numpy as np


def mean_and_deviation(samples):
    """(mean, sample standard deviation (n - 1), number of samples) without NaN and None; NaN where there are too few."""
    samples = np.array([s for s in samples if s is not None and not math.isnan(s)], float)
    mean = float(samples.mean()) if samples.size else math.nan
    deviation = float(samples.std(ddof=1)) if samples.size > 1 else math.nan
    return mean, deviation, samples.size


def wilson(successes, attempts, z=1.959963984540054):
    """(low, high): 95 % score interval of a share [Wilson 1927]."""
    if attempts == 0:
        return 0.0, 1.0
    share, spread = successes / attempts, z * z / attempts
    center = (share + spread / 2) / (1 + spread)
    half = z / (1 + spread) * math.sqrt(share * (1 - share) / attempts + spread / (4 * attempts))
    return center - half, center + half
