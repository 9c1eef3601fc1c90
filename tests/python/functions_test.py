#!/usr/bin/env python3
"""The onboard software and functions of core alone, on arrays of one's own. Usage: support.py tells."""
import math

import numpy as np

import support
import swiftlet
from swiftlet import functions

KINDS = ("imu", "odometry", "gnss", "altimeter", "compass", "pose", "neighbors")


def feed(onboard, vehicle):
    """What the sensors of a simulated vehicle measured in this tick, as arrays."""
    for kind in KINDS:
        samples = vehicle.samples(kind)
        for i in range(len(samples)):
            onboard.add(kind, **{name: samples[name][i] for name in samples.keys()})
    for scan in vehicle.scans:
        onboard.add_scan(scan)


class Software(support.InFolder):
    def test_alone_it_does_to_the_bit_what_it_does_in_the_simulator(self):
        scenario = swiftlet.load(self.team)
        simulator, alone = swiftlet.Simulator(scenario), swiftlet.Onboard(scenario, 0)
        finished = 0
        while not simulator.finished:
            simulator.tick()
            eye = simulator.vehicle(0)
            feed(alone, eye)
            alone.step(simulator.t_ns)
            np.testing.assert_array_equal(alone.estimate.local_pose, eye.estimate.local_pose)
            np.testing.assert_array_equal(alone.rotor_command, eye.rotor_command)
            self.assertEqual(alone.detections is None, eye.detections is None)
            if eye.detections is not None:
                finished += 1
                np.testing.assert_array_equal(alone.detections.position_m, eye.detections.position_m)
            np.testing.assert_array_equal(alone.tracks.position_m, eye.tracks.position_m)
        self.assertGreater(finished, 2)
        np.testing.assert_array_equal(alone.maps()["detector"]["value"], eye.maps()["detector"]["value"])

    def test_a_vehicle_localizes_itself_by_own_point_clouds_and_imu(self):
        source = swiftlet.Simulator(swiftlet.load({
            "name": "recorded", "duration_s": 1.6, "world": {"type": "hall"},
            "vehicles": [{"start": {"position_m": [0, 0, 2]}, "sensors": [{"type": "lidar", "model": "puck_lite"}, {"type": "imu"}],
                          "agent": {"localization": {"type": "ground_truth"}, "guidance": {
                              "type": "waypoints", "waypoints_m": [[-3, 0, 2]]}}}]}))
        alone = swiftlet.Onboard(swiftlet.load({
            "name": "slam", "vehicles": [{"start": {"position_m": [0, 0, 2]}, "sensors": [{"type": "lidar", "model": "puck_lite"},
                                                                                          {"type": "imu"}],
                                          "agent": {"localization": {"type": "slam"}}}]}))
        scans = 0
        while not source.finished:
            source.tick()
            vehicle = source.vehicle(0)
            imu = vehicle.samples("imu")
            for i in range(len(imu)):
                alone.add("imu", t_ns=int(imu.t_ns[i]), omega_radps=imu.omega_radps[i], f_mps2=imu.f_mps2[i])
            for scan in vehicle.scans:  # as a driver would give it: points, and nothing else
                points = scan.origins_lidar_m + scan.range_m[..., None] * scan.directions_lidar
                range_m = np.where(scan.range_m > 0, np.linalg.norm(points, axis=2), 0)
                unit = points / np.maximum(np.linalg.norm(points, axis=2, keepdims=True), 1e-6)
                alone.add_scan(swiftlet.make_scan(range_m, unit, scan.t_ns, duration_s=scan.duration_s,
                                                  sensor=scan.sensor, range_max_m=scan.range_max_m))
                scans += 1
            alone.step(source.t_ns)
        self.assertGreater(scans, 12)
        self.assertTrue(alone.estimate.valid)
        error_m = np.linalg.norm(alone.estimate.local_pose[:3, 3] - source.states.position_m[0])
        self.assertLess(error_m, 0.15)

    def test_what_is_told_wrongly_is_refused(self):
        alone = swiftlet.Onboard(swiftlet.load(self.team))
        with self.assertRaisesRegex(KeyError, 'did you mean "omega_radps"'):
            alone.add("imu", t_ns=0, omega_radsp=(0, 0, 0))
        with self.assertRaisesRegex(TypeError, "f_mps2: expected 3 numbers"):
            alone.add("imu", t_ns=0, f_mps2=(0, 0))
        with self.assertRaisesRegex(KeyError, "altimeter"):
            alone.add("sonar", t_ns=0)
        with self.assertRaisesRegex(ValueError, "as range_m has them"):
            swiftlet.make_scan(np.ones((2, 3)), np.ones((3, 2, 3)), 0)


class Uncertainty(support.InFolder):
    def test_covariance_of_a_point_is_that_of_the_document(self):
        rng = np.random.default_rng(2)
        d = rng.normal(size=(5, 3))
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        R *= np.linalg.det(R)
        r = rng.uniform(1, 30, 5)
        got = functions.point_covariances(d, r, R, sigma_range_m=0.02, sigma_position_m=(0.1, 0.2, 0.3),
                                          sigma_attitude_rad=(0.01, 0.02, 0.03))
        S = np.diag(np.square([0.02, 0.1, 0.2, 0.3, 0.01, 0.02, 0.03]))
        for i in range(5):
            turned = [r[i] * R @ np.cross(e, d[i]) for e in np.eye(3)]
            J = np.column_stack([R @ d[i], np.eye(3), *turned])
            np.testing.assert_allclose(got[i], J @ S @ J.T, atol=1e-12)

    def test_errors_of_points_are_those_of_samples(self):
        C = np.diag([0.04, 0.01, 0.0225])
        norms = np.linalg.norm(np.random.default_rng(3).multivariate_normal(np.zeros(3), C, 200000), axis=1)
        self.assertAlmostEqual(functions.error_means_m([C])[0], norms.mean(), delta=0.005)
        self.assertAlmostEqual(functions.error_quantiles_m([C], 0.9)[0], np.quantile(norms, 0.9), delta=0.02)

    def test_probability_of_a_box_is_a_product_without_correlation(self):
        def phi(x):
            return 0.5 * (1 + math.erf(x / math.sqrt(2)))
        sigmas, low, high = (0.1, 0.2, 0.3), (-0.1, -0.1, -0.3), (0.2, 0.1, 0.1)
        wanted = np.prod([phi(h / s) - phi(l / s) for s, l, h in zip(sigmas, low, high)])
        got = functions.box_probability((0, 0, 0), np.diag(np.square(sigmas)), low, high)
        self.assertAlmostEqual(got, wanted, places=6)
        voxel = functions.correct_voxel_probabilities([[0.05, 0.05, 0.05]], [np.eye(3) * 1e-6], 0.1)
        self.assertAlmostEqual(voxel[0], 1.0, places=5)


class Flocking(support.InFolder):
    def test_rbl_goes_to_its_goal_and_away_from_neighbors(self):
        alone = functions.Rbl(planar=True).step((0, 0, 2), [], (10, 0, 2), 0.1)
        self.assertGreater(alone["centroid_m"][0], 0.3)
        near = functions.Rbl(planar=True).step((0, 0, 2), [(1.2, 0, 2)], (10, 0, 2), 0.1)
        self.assertLess(near["centroid_m"][0], alone["centroid_m"][0])
        wall = functions.Rbl(planar=True).step((0, 0, 2), [], (10, 0, 2), 0.1,
                                               obstacles_m=[(1.5, y, 2) for y in np.arange(-4, 4, 0.2)])
        self.assertLess(wall["centroid_m"][0], alone["centroid_m"][0])

    def test_its_keys_are_read_strictly(self):
        with self.assertRaisesRegex(swiftlet.InputError, 'did you mean "encumbrance_m"'):
            functions.Rbl({"encumberance_m": 0.5})


if __name__ == "__main__":
    support.main()
