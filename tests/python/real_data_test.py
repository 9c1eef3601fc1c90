#!/usr/bin/env python3
"""The onboard software on records of real sensors. Usage: see support.py.

SWIFTLET_REAL_DATA (default: ../shared/data/real) names a folder with the capture of an OS1-128 on a car that speeds up, and its metadata:
OS-1-128_v2.3.0_1024x10_lb_n3.pcap and OS-1-128_v2.3.0_1024x10.json of ouster-lidar/ouster-sdk, as NAME.pcap and NAME.json.
"""
import sys
import unittest

import numpy as np

import support
import swiftlet

sys.path.insert(0, str(support.SOURCE / "examples/robot"))
import convert_ouster  # noqa: E402

NAME = "ouster_os1_128_3sweeps_imu"
SPEED_MPS = 5  # the car drives already at the start, at an unknown speed
DATA = support.REAL_DATA
if not (DATA / f"{NAME}.pcap").exists():
    print(f"skipped: expected {NAME}.pcap in the folder of SWIFTLET_REAL_DATA, found none")
    sys.exit(77)


class Car(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sweeps, cls.imu, cls.T_body_lidar = convert_ouster.read(DATA / f"{NAME}.pcap", DATA / f"{NAME}.json")

    def drive(self, mount=None, own_mount=None, by_points=False):
        """SLAM on the raw beams; the pose when the last sweep is complete. `mount`: of the scenario, `own_mount`: of each scan."""
        lidar = {"type": "lidar", "name": "os1", "model": "os1_128", "mount": mount or {}}
        software = swiftlet.Onboard(swiftlet.load({"vehicles": [{
            "start": {"position_m": [0, 0, 0]}, "sensors": [lidar, {"type": "imu"}],
            "agent": {"localization": {"type": "slam", "latency_s": 0, "local": {"imu": {"start_velocity_sigma_mps": SPEED_MPS}}}}}]}))
        waiting = list(self.sweeps)
        for t_ns, omega_radps, f_mps2 in self.imu:
            software.add("imu", t_ns=t_ns, omega_radps=omega_radps, f_mps2=f_mps2)
            while waiting and waiting[0]["t_ns"] + 1e9 * waiting[0]["offset_s"][-1] <= t_ns:
                sweep = waiting.pop(0)
                if by_points:
                    points_m = sweep["origins_lidar_m"] + sweep["range_m"][..., None] * sweep["directions_lidar"]
                    offset_s = np.broadcast_to(sweep["offset_s"], sweep["range_m"].shape)[sweep["range_m"] > 0]
                    points_m = points_m[sweep["range_m"] > 0]
                    range_m = np.linalg.norm(points_m, axis=1)
                    sweep = {"t_ns": sweep["t_ns"], "range_m": range_m[None], "offset_s": offset_s[None],
                             "directions_lidar": (points_m / range_m[:, None])[None]}
                software.add_scan(swiftlet.make_scan(**sweep, sensor="os1", T_body_lidar=own_mount))
            software.step(t_ns)
            if not waiting:
                break
        self.assertEqual((waiting, software.fault), ([], ""))
        return software.estimate.local_pose

    def test_mount_of_the_scenario_turns_travel_forward(self):
        position_m = [float(v) for v in self.T_body_lidar[:3, 3]]
        for by_points in (False, True):
            forward = self.drive({"position_m": position_m, "rpy_deg": [0, 0, 180]}, by_points=by_points)
            print("forward", forward[:3, 3])
            self.assertAlmostEqual(forward[0, 3], 0.60, delta=0.02)
        np.testing.assert_allclose(self.drive(own_mount=self.T_body_lidar, by_points=True), forward, atol=1e-6)

    def test_without_the_mount_the_car_drives_backward(self):
        self.assertLess(self.drive()[0, 3], 0)


if __name__ == "__main__":
    support.main()
