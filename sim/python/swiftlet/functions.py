# SPDX-License-Identifier: BSD-3-Clause
"""Functions of `core` on arrays: uncertainty of points, rule-based Lloyd, random numbers of the simulator."""
import json as _json

from . import _core
from ._core import Random, box_probability, correct_voxel_probabilities, error_means_m, error_quantiles_m, point_covariances

__all__ = ["Random", "Rbl", "box_probability", "correct_voxel_probabilities", "error_means_m", "error_quantiles_m", "point_covariances"]


class Rbl:
    """Rule-based Lloyd [Kamler 2025] of one agent. cell and rules have the keys of `guidance: {type: rbl}` in docs/reference.md;
    planar: the 2D algorithm."""

    def __init__(self, cell=None, rules=None, planar=False):
        self._rbl = _core._Rbl(_json.dumps(cell or {}), _json.dumps(rules or {}), planar)

    def step(self, position_m, neighbors_m, goal_m, dt_s, *, z_min_m=0.0, z_max_m=100.0, obstacles_m=(), obstacle_edge_m=0.2):
        """One update; all places in one frame. neighbors_m (n, 3); obstacles_m (m, 3), centers of occupied voxels of that edge.

        Returns centroid_m (3,), the point to fly to, sensing_centroid_m, destination_m, empty_cell, and the state of the rules: beta_m,
        theta_rad, phi_rad.
        """
        return self._rbl.step(position_m, neighbors_m, goal_m, dt_s, z_min_m=z_min_m, z_max_m=z_max_m, obstacles_m=obstacles_m,
                              obstacle_edge_m=obstacle_edge_m)
