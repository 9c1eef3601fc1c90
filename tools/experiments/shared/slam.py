# SPDX-License-Identifier: BSD-3-Clause
"""Flights of one vehicle on SLAM, against truth."""
import types

import numpy as np
import swiftlet

from shared.experiment import result_of
from shared.rotations import rotations

COURSE_S = 0.5  # between the samples of a course, for figures
SAMPLE_S = 0.1  # between the instants of errors: period of the scans


def record(source, changes, out=None):
    """Flies a scenario until its end or its first contact. Returns the simulator and, with one row for each tick:

    t_s, valid (n,), p_true_m (n, 3), q_true_xyzw (n, 4), T_local (n, 4, 4): pose by local SLAM, T_world_local (n, 4, 4): correction
    as far as it is shown, revision (n,): number of changes of the correction, p_shown_m (n, 3): position in the world as the
    vehicle knows it, p_gnss_m (n, 3): the last fix, NaN before the first.
    """
    simulator = swiftlet.Simulator(swiftlet.load(source, {"metrics.stop_on_crash": True, **changes}), threads=1, out=out)
    vehicle = simulator.vehicle(0)
    rows, p_gnss_m = [], np.full(3, np.nan)
    while not simulator.finished:
        simulator.tick()
        states, estimate, fixes = simulator.states, vehicle.estimate, vehicle.samples("gnss")
        if len(fixes):
            p_gnss_m = fixes.position_m[-1]
        rows.append((simulator.t_s, states.position_m[0].copy(), states.q_xyzw[0].copy(), estimate.local_pose,
                     estimate.correction_pose, estimate.correction_revision, estimate.valid, p_gnss_m))
    names = ("t_s", "p_true_m", "q_true_xyzw", "T_local", "T_world_local", "revision", "valid", "p_gnss_m")
    log = types.SimpleNamespace(**{name: np.array(column) for name, column in zip(names, zip(*rows))})
    log.p_shown_m = moved_by(log.T_world_local, log.T_local[:, :3, 3])
    return simulator, log


def moved_by(T, p_m):
    """(n, 3) [m] each point by its pose."""
    return np.einsum("nij,nj->ni", T[:, :3, :3], p_m) + T[:, :3, 3]


def changed(log):
    """(n,) does a new correction begin, or the present one end, in this tick?"""
    return np.diff(log.revision.astype(int), prepend=log.revision[0]) != 0


def measure_corrections(log):
    """How corrections move the vehicle's position in the world: their number, the largest [m], the largest step [m] in a tick in
    which one begins or ends, without the motion that goes on, and the greatest speed and acceleration in all other ticks."""
    dt_s = log.t_s[1] - log.t_s[0]
    p_local_m, change = log.T_local[1:, :3, 3], changed(log)[1:]
    v_mps = (log.p_shown_m[1:] - moved_by(log.T_world_local[:-1], p_local_m)) / dt_s
    speed_mps = np.linalg.norm(v_mps, axis=1)
    leap_mps = np.linalg.norm(np.diff(v_mps, axis=0, prepend=np.zeros((1, 3))), axis=1)
    smooth = ~change & ~np.insert(change[:-1], 0, True)  # neither this tick nor the one before
    moving = change | (speed_mps > 1e-12)
    begins = change & ~np.insert(moving[:-1], 0, False)
    before = np.maximum.accumulate(np.where(begins, np.arange(len(begins)), 0))  # tick before the last begin
    moved_m = np.linalg.norm(log.p_shown_m[1:] - moved_by(log.T_world_local[before], p_local_m), axis=1)
    return {"corrections": int(begins.sum()), "largest_m": float(moved_m.max()),
            "step_m": float(dt_s * leap_mps[change].max(initial=0.0)), "speed_mps": float(speed_mps[~change].max(initial=0.0)),
            "acceleration_mps2": float(leap_mps[smooth].max(initial=0.0) / dt_s)}


def measure_errors(log):
    """Root mean square errors of the position [m] from the first correction on (the whole flight if there is none): by local SLAM
    alone, and in the world."""
    every = ticks(log, SAMPLE_S)
    after = slice(np.argmax(changed(log)) if changed(log).any() else 0, None)
    sampled = np.arange(len(log.t_s))[after]
    sampled = sampled[(sampled + 1) % every == 0]
    rms_m = {}
    for name, p_m in (("rms_local_after_m", log.T_local[:, :3, 3]), ("rms_after_m", log.p_shown_m)):
        rms_m[name] = float(np.sqrt(np.mean(np.sum((p_m - log.p_true_m)[sampled]**2, axis=1))))
    return rms_m


def drift_percent(log, length_m):
    """Median relative error of local SLAM over sections of the path [%], one every length_m / 10. NaN: the path is too short."""
    every = slice(ticks(log, SAMPLE_S) - 1, None, ticks(log, SAMPLE_S))
    p_true_m, R_true, T_local = log.p_true_m[every], rotations(log.q_true_xyzw[every]), log.T_local[every]
    way_m = np.insert(np.cumsum(np.linalg.norm(np.diff(p_true_m, axis=0), axis=1)), 0, 0.0)
    drifts, next_m = [], 0.0
    for i, begin_m in enumerate(way_m):
        j = np.searchsorted(way_m, begin_m + length_m)
        if j == len(way_m):
            break
        if begin_m < next_m:
            continue
        moved_true_m = R_true[i].T @ (p_true_m[j] - p_true_m[i])
        moved_m = T_local[i, :3, :3].T @ (T_local[j, :3, 3] - T_local[i, :3, 3])
        drifts.append(100 * np.linalg.norm(moved_m - moved_true_m) / (way_m[j] - begin_m))
        next_m = begin_m + 0.1 * length_m
    return float(np.median(drifts)) if drifts else float("nan")


def ticks(log, period_s):
    return round(period_s / (log.t_s[1] - log.t_s[0]))


def course(log):
    """Two samples a second: t_s and places in the world [m]."""
    every = slice(None, None, ticks(log, COURSE_S))
    return {name: getattr(log, name)[every].tolist() for name in ("t_s", "p_true_m", "p_shown_m", "p_gnss_m")}


def fly_on_slam(source, changes):
    """One flight: its metrics, corrections, errors, and course."""
    simulator, log = record(source, changes)
    return describe(simulator, log)


def describe(simulator, log):
    return {**result_of(simulator.summary()), **measure_corrections(log), **measure_errors(log), "course": course(log)}
