# SPDX-License-Identifier: BSD-3-Clause
"""Flights of a vehicle that guides another one [Pritzl 2024], and their results."""
import math

import numpy as np
import swiftlet

from shared.rotations import rotations

GUIDING = "secondary moving"  # mission note of the guide while the guided vehicle flies along its path
NEAR_M = 1.0  # distance from the passage within which errors of the relative position count
THROUGH_M = 0.6  # least distance from the middle of the passage: jitter at the middle is no pass


def in_world(passage, along_m, across_m, height_m):
    """[x, y, z] [m] of a point. passage: x and y [m] of its center, yaw [rad] of the direction through it."""
    x_m, y_m, yaw_rad = passage
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    return [x_m + c * along_m - s * across_m, y_m + s * along_m + c * across_m, height_m]


def relative_errors_m(states, guide):
    """(n, 3) errors of the guide's estimates of other vehicles' positions relative to its own body, in world axes."""
    relatives = guide.relatives
    if len(relatives) == 0 or states.crashed.any():
        return np.zeros((0, 3))
    T_world_body = guide.estimate.correction_pose @ guide.estimate.local_pose
    position_body_m = (relatives.position_m - T_world_body[:3, 3]) @ T_world_body[:3, :3]
    true_m = states.position_m[relatives.other] - states.position_m[0]
    return position_body_m @ rotations(states.q_xyzw[0]).T - true_m


def fly_guided(source, changes, passage=None):
    """One flight until its end or the first contact. The guide is the first vehicle, the last one has to pass.

    done: all goals reached; crashed: any contact; passes: crossings of the passage; farthest_m: largest horizontal distance from
    where guiding begins; least_clearance_m: over all vehicles and surfaces; error_sum_m, along_wall_sum_m, num_errors: errors of
    the guide's estimate of the other vehicle's position near the passage.
    """
    simulator = swiftlet.Simulator(swiftlet.load(source, {"metrics.stop_on_crash": True, **changes}), threads=1)
    states, guide = simulator.states, simulator.vehicle(0)
    passes, side, began_m, farthest_m = 0, 0, None, 0.0
    error_sum_m, along_wall_sum_m, num_errors = 0.0, 0.0, 0
    x_m, y_m, yaw_rad = passage or (0.0, 0.0, 0.0)
    center_m = np.array([x_m, y_m])
    through, wall = np.array([math.cos(yaw_rad), math.sin(yaw_rad)]), np.array([-math.sin(yaw_rad), math.cos(yaw_rad)])
    while not simulator.finished:
        simulator.tick()
        p_m = states.position_m[-1, :2].copy()
        if guide.mission_note == GUIDING:
            began_m = p_m if began_m is None else began_m
            farthest_m = max(farthest_m, float(np.linalg.norm(p_m - began_m)))
        if passage is None:
            continue
        along_m = through @ (p_m - center_m)
        if abs(along_m) > THROUGH_M:
            passes += side == -np.sign(along_m)
            side = np.sign(along_m)
        if len(states) > 1 and np.linalg.norm(p_m - center_m) <= NEAR_M:
            errors_m = relative_errors_m(states, guide)
            error_sum_m += float(np.linalg.norm(errors_m, axis=1).sum())
            along_wall_sum_m += float(np.abs(errors_m[:, :2] @ wall).sum())
            num_errors += len(errors_m)
    vehicles = simulator.summary()["metrics"]["vehicles"]
    clearances_m = [vehicle[f"min_clearance_{other}_m"] for vehicle in vehicles.values() for other in ("surface", "vehicle")]
    return {"done": vehicles[guide.name]["time_to_done_s"] is not None, "crashed": bool(states.crashed.any()),
            "time_s": simulator.t_s, "passes": int(passes), "farthest_m": farthest_m,
            "least_clearance_m": min(clearance_m for clearance_m in clearances_m if clearance_m is not None),
            "error_sum_m": error_sum_m, "along_wall_sum_m": along_wall_sum_m, "num_errors": num_errors}
