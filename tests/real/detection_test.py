#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Detectors on what the driver of a LiDAR delivers: points, without the directions of shots that met nothing.
Usage: detection_test.py [--table] [unittest options]

Recorded are a UAV around a Livox Mid-360 at rest outdoors, and a VLP-16 at rest in a room where nothing flies. SWIFTLET_REAL_DATA
names their folder, by default ../shared/data/real beside the repository. The same flight is simulated on a campus and in a forest.
--table prints the table of docs/detection.md instead of testing.
"""
import functools
import os
import pathlib
import sys
import unittest

try:
    import numpy as np
    import swiftlet
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

DATA = pathlib.Path(os.environ.get("SWIFTLET_REAL_DATA", pathlib.Path(__file__).resolve().parents[3] / "shared/data/real"))
TICK_NS, SWEEP_NS = 2_000_000, 100_000_000
FOUND_M = 0.7  # a detection nearer than this to the UAV is one of it
PATH_M = [[-0.67, -1.27, 1.65], [-1.09, -1.03, 1.61], [-1.29, -0.1, 1.6], [-1.4, 0.41, 1.6], [-1.53, 1.38, 1.58], [-1.36, 1.6, 1.56],
          [-0.8, 1.73, 1.59], [0.04, 1.66, 1.57]]  # of the recorded UAV in the frame of the Mid-360
LIDAR_M = 1.0  # height of the Mid-360 above the ground


class Software:
    """Detector of a vehicle at rest; its poses come from outside."""

    def __init__(self, detector, T_body=np.eye(4)):
        agent = {"localization": {"type": "ground_truth"}, "detector": {"type": "vofod", **detector}, "guidance": {"type": "hover"}}
        self.software = swiftlet.Onboard(swiftlet.load({"vehicles": [{"model": "f330", "start": {"position_m": [0, 0, 0]},
                                                                      "sensors": [{"type": "lidar"}], "agent": agent}]}))
        self.T_body, self.t_ns, self.found = T_body, -TICK_NS, []

    def step(self, t_ns, scans=()):
        """Ticks up to this instant, with scans that are complete then."""
        while self.t_ns < t_ns:
            self.t_ns += TICK_NS
            self.software.add("pose", t_ns=self.t_ns, pose=self.T_body, v_mps=np.zeros(3), omega_radps=np.zeros(3))
            for scan in scans if self.t_ns >= t_ns else ():
                self.software.add_scan(scan)
            self.software.step(self.t_ns)
            reported = self.software.detections
            if reported is not None:
                self.found += list(zip(reported.t_ns.tolist(), np.array(reported.position_m)))


def scan_of_points(points_m, offset_s, t_ns):
    """A scan of points in the frame of the LiDAR, and of their times after the start of the sweep."""
    range_m = np.linalg.norm(points_m, axis=1)
    return swiftlet.make_scan(range_m[None], (points_m / range_m[:, None])[None], t_ns, offset_s=offset_s[None], duration_s=0.1)


def detections_of(scans, **detector):
    """[(t_ns, position)] in the frame of the LiDAR, which is at rest."""
    software = Software(detector)
    for t_ns, scan in scans:
        software.step(t_ns + SWEEP_NS, [scan])
    software.step(software.t_ns + 3 * SWEEP_NS)
    return software.found


def score(found, uav_m):
    """Number of sweeps in which the UAV is found, and the false detections; uav_m: its position in each sweep."""
    sweeps, false = set(), []
    for t_ns, at_m in found:
        sweep = t_ns // SWEEP_NS
        if sweep < len(uav_m) and np.linalg.norm(at_m - uav_m[sweep]) < FOUND_M:
            sweeps.add(sweep)
        else:
            false.append((t_ns / 1e9, at_m))
    return len(sweeps), false


@functools.cache
def mid360():
    """Scans of the recorded frames, and the mean of the returns of the UAV in each, which has nothing near it."""
    scans, uav_m = [], []
    for part in "ab":
        file = np.load(DATA / f"mid360_uav_{part}.npz")
        for frame in np.unique(file["frame"]):
            chosen = file["frame"] == frame
            points_m = file["xyz_mm"][chosen] / 1000.0
            t_ns = len(scans) * SWEEP_NS
            shots = file["shots"][len(uav_m) % len(file["shots"])]
            scans.append((t_ns, scan_of_points(points_m, file["index"][chosen] / float(shots) * 0.1, t_ns)))
            range_m = np.linalg.norm(points_m, axis=1)
            uav_m.append(points_m[(range_m > 1.5) & (range_m < 3.2) & (points_m[:, 2] > 0.34 * range_m)].mean(axis=0))
    return scans, uav_m


@functools.cache
def vlp16():
    """Scans of the recorded turns: the returns, and the times of their shots."""
    packets = np.fromfile(DATA / "vlp16_13turns.bin", np.uint8).reshape(-1, 1206)
    blocks = packets[:, :1200].reshape(-1, 100)
    azimuth_deg = np.repeat((blocks[:, 2] + 256.0 * blocks[:, 3]) / 100.0, 2)
    azimuth_deg[1::2] += 0.2  # two firings of 16 lasers in a block
    shots = blocks[:, 4:].reshape(-1, 16, 3)
    range_m = 0.002 * (shots[..., 0] + 256.0 * shots[..., 1])
    elevation_rad = np.radians([-15, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15])
    turn = np.cumsum(np.diff(azimuth_deg, prepend=azimuth_deg[0]) < -180.0)
    azimuth_rad, elevation_rad = np.broadcast_arrays(np.radians(azimuth_deg)[:, None], elevation_rad)
    directions = np.stack([np.cos(elevation_rad) * np.sin(azimuth_rad), np.cos(elevation_rad) * np.cos(azimuth_rad),
                           np.sin(elevation_rad)], axis=-1)
    scans = []
    for k in range(1, turn[-1]):
        returned = (turn == k)[:, None] & (range_m > 0)
        offset_s = np.broadcast_to(np.radians(azimuth_deg % 360.0)[:, None] / (2 * np.pi) * 0.0999, range_m.shape)
        t_ns = (k - 1) * SWEEP_NS
        scans.append((t_ns, scan_of_points((range_m[..., None] * directions)[returned], offset_s[returned], t_ns)))
    return scans


@functools.cache
def simulated(world, seed=7):
    """The recorded flight in a simulated world: (scans with all directions, scans of their points, place of the UAV in each)."""
    origin_m = np.array([-12.5, -10.0, 0.0] if world == "campus" else [0.0, 0.0, 0.0])
    base = swiftlet.load(world, {"seed": seed, "duration_s": 9.7})
    ground_m = 0.0 if world == "campus" else 0.8
    height_m = LIDAR_M + ground_m
    path_m = (np.array(PATH_M) + [0, 0, height_m] + origin_m).tolist()
    ideal = {"localization": {"type": "ground_truth"}}
    observer = {"name": "observer", "model": "x500", "start": {"position_m": (origin_m + [0, 0, height_m - 0.15]).tolist()},
                "sensors": [{"type": "lidar", "name": "mid360", "model": "mid360", "mount": {"position_m": [0, 0, 0.15]}}],
                "agent": {**ideal, "guidance": {"type": "hover"}}}
    target = {"name": "target", "model": "f330", "start": {"position_m": path_m[0]},
              "agent": {**ideal, "guidance": {"type": "waypoints", "speed_mps": 0.6, "waypoints_m": path_m[1:]}}}
    simulator = swiftlet.Simulator(swiftlet.load(base, {"vehicles": [observer, target], "recorders": [], "snapshots": []}))
    scans, points, uav_m, seen_m = [], [], [], []
    while not simulator.finished:
        simulator.tick()
        states = simulator.states
        seen_m.append(states.position_m[1] - states.position_m[0] - [0, 0, 0.15])
        for scan in simulator.vehicle(0).scans:
            t_ns = len(scans) * SWEEP_NS
            hit = scan.range_m > 0
            offset_s = np.broadcast_to(scan.column_offset_s, hit.shape)
            scans.append((t_ns, swiftlet.make_scan(scan.range_m, scan.directions_lidar, t_ns, offset_s=scan.column_offset_s, duration_s=0.1)))
            points.append((t_ns, scan_of_points(np.array(scan.points_lidar_m()), offset_s[hit], t_ns)))
            uav_m.append(np.mean(seen_m[-25:], axis=0))
    return scans[:95], points[:95], uav_m[:95]


DETECTORS = {"vofod": {}, "track_before_detect": {"type": "track_before_detect"}}


def print_table():
    print("| scans | detector | UAV found | false detections |\n| --- | --- | --- | --- |")
    for name, detector in DETECTORS.items():
        for world in ("campus", "forest"):
            scans, points, uav_m = simulated(world)
            for what, chosen in (("all directions", scans), ("points alone", points)):
                found, false = score(detections_of(chosen, **detector), uav_m)
                print(f"| simulated {world}, {what} | `{name}` | {found} of {len(scans)} | {len(false)} |", flush=True)
        scans, uav_m = mid360()
        found, false = score(detections_of(scans, **detector), uav_m)
        print(f"| recorded Mid-360 | `{name}` | {found} of {len(scans)} | {len(false)} |", flush=True)
        if "-v" in sys.argv:
            for t_s, at_m in false:
                print(f"    {t_s:.2f} s at {np.round(at_m, 2)}")
        found = detections_of(vlp16(), **detector)
        print(f"| recorded VLP-16 | `{name}` | - | {len(found)}, {sum(t_ns > 1e9 for t_ns, _ in found)} of them after 1 s |", flush=True)
        if "-v" in sys.argv:
            for t_ns, at_m in found:
                print(f"    {t_ns / 1e9:.2f} s at {np.round(at_m, 2)}")


@unittest.skipUnless((DATA / "mid360_uav_a.npz").exists(), f"no recorded scans in {DATA}")
class RecordedScans(unittest.TestCase):
    def test_a_flying_uav_is_found_by_points_alone(self):
        scans, uav_m = mid360()
        found, false = score(detections_of(scans), uav_m)
        self.assertGreaterEqual(found, 60)
        self.assertLessEqual(len(false), 12, false)

    def test_a_still_room_is_background(self):
        self.assertEqual([t_ns for t_ns, _ in detections_of(vlp16()) if t_ns > 1e9], [])


class SimulatedScans(unittest.TestCase):
    def test_points_alone_are_enough(self):
        for world in ("campus", "forest"):
            with self.subTest(world):
                scans, points, uav_m = simulated(world)
                found, false = score(detections_of(points), uav_m)
                found_by_all, false_by_all = score(detections_of(scans), uav_m)
                self.assertGreaterEqual(found, found_by_all - 5)
                self.assertLessEqual(len(false), len(false_by_all))


if __name__ == "__main__":
    if "--table" in sys.argv:
        print_table()
    else:
        unittest.main()
