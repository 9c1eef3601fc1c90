# SPDX-License-Identifier: BSD-3-Clause
"""Rotation matrices of quaternions."""
import numpy as np


def rotations(q_xyzw):
    """(..., 3, 3) from unit quaternions (..., 4)."""
    x, y, z, w = np.moveaxis(q_xyzw, -1, 0)
    R = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                  [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                  [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    return np.moveaxis(R, (0, 1), (-2, -1))
