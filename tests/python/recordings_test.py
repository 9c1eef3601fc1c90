#!/usr/bin/env python3
"""SLAM on recordings of real sensors, in the folder that SWIFTLET_REAL_DATA names (default: ../shared/data/real). Usage: see support.py."""
import sys
import unittest

import numpy as np

import support
import swiftlet

FOLDER = support.REAL_DATA
if not (FOLDER / "kitti_turn_a.npz").is_file():
    print("skipped: expected kitti_turn_a.npz in the folder of SWIFTLET_REAL_DATA, found none")
    sys.exit(77)


def rotation(x, y, z, w):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def yaw_deg(T):
    return np.degrees(np.arctan2(T[1, 0], T[0, 0]))


def length_m(poses):
    return sum(np.linalg.norm(b[:3, 3] - a[:3, 3]) for a, b in zip(poses, poses[1:]))


class Kitti(unittest.TestCase):
    """A car in a curve, 10 Hz, without IMU and without times of points (HDL-64)."""

    def test_lidar_alone_follows_a_curve_as_kiss_icp(self):
        frames = {}
        for part in "abcd":
            for key, xyz_4mm in np.load(FOLDER / f"kitti_turn_{part}.npz").items():
                frames[int(key[-3:])] = 0.004 * xyz_4mm
        software = swiftlet.Onboard(swiftlet.load({"vehicles": [{
            "start": {"position_m": [0, 0, 2]}, "sensors": [{"type": "lidar"}],
            "agent": {"localization": {"type": "slam", "imu": "none", "latency_s": 0,
                                       "local": {"imu": {"start_velocity_sigma_mps": 10}}}}}]}))
        poses = []
        for i, (_, points_m) in enumerate(sorted(frames.items()), 1):
            range_m = np.linalg.norm(points_m, axis=1)
            t_ns = i * 100_000_000
            software.add_scan(swiftlet.make_scan(range_m[None], (points_m / range_m[:, None])[None], t_ns, duration_s=0))
            software.step(t_ns)
            self.assertTrue(software.estimate.valid)
            poses.append(software.estimate.local_pose)
        kiss = []
        for _, x, y, z, *q_xyzw in np.loadtxt(FOLDER / "kitti_turn_kiss.txt"):
            T = np.eye(4)
            T[:3, :3], T[:3, 3] = rotation(*q_xyzw), (x, y, z)
            kiss.append(T)
        turned_deg = [yaw_deg(np.linalg.inv(path[0]) @ path[-1]) for path in (poses, kiss)]
        self.assertLess(abs(turned_deg[0] - turned_deg[1]), 0.5)
        self.assertLess(abs(length_m(poses) / length_m(kiss) - 1), 0.02)


if __name__ == "__main__":
    support.main()
