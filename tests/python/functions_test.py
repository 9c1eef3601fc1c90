#!/usr/bin/env python3
"""The onboard software and functions of core alone, on arrays of one's own. Usage: see support.py."""
import math
import threading

import numpy as np

import support
import swiftlet
from swiftlet import functions

# One sample of each kind, complete.
SAMPLES = {
    "imu": dict(t_ns=1, omega_radps=(0, 0, 0.1), f_mps2=(0, 0, 9.81)),
    "odometry": dict(t_ns=1, pose=np.eye(4), v_mps=(1, 0, 0)),
    "gnss": dict(t_ns=1, position_m=(1, 2, 3), v_mps=(0, 0, 0), sigma_m=(1, 1, 2), sigma_v_mps=(0.1, 0.1, 0.1)),
    "altimeter": dict(t_ns=1, height_m=2, sigma_m=0.1),
    "compass": dict(t_ns=1, yaw_rad=-1.5, sigma_rad=0.05),
    "pose": dict(t_ns=1, pose=np.eye(4), v_mps=(0, 0, 0), omega_radps=(0, 0, 0)),
    "neighbors": dict(t_ns=1, neighbor=-1, position_body_m=(3, 0, 0), cov_m2=np.eye(3)),
}
SLAM = {"name": "slam", "vehicles": [{"start": {"position_m": [0, 0, 2]}, "agent": {"localization": {"type": "slam"}},
                                      "sensors": [{"type": "lidar", "model": "puck_lite"}, {"type": "imu"}]}]}
X_AND_Y = np.array([[[1.0, 0, 0], [0, 1.0, 0]]])


@swiftlet.guidance("waits")
class Waits:
    """Stays within its step until another thread lets it go on."""
    entered, leave = threading.Event(), threading.Event()

    def step(self, now):
        self.entered.set()
        self.leave.wait(60)


@swiftlet.guidance("sees", clouds=True)
class Sees:
    """Keeps the points of its last cloud."""
    points_m = None

    def step(self, now):
        for cloud in now.clouds:
            Sees.points_m = cloud.points_local_m.copy()


def feed(onboard, vehicle):
    """What the sensors of a simulated vehicle measured in this tick, as arrays."""
    for kind in SAMPLES:
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

    def fly_slam(self, scan_of):
        """SLAM on the simulated scans that `scan_of` makes again; error at the end of a flight of 3 m."""
        source = swiftlet.Simulator(swiftlet.load({
            "name": "recorded", "duration_s": 1.6, "world": {"type": "hall"},
            "vehicles": [{"start": {"position_m": [0, 0, 2]}, "sensors": [{"type": "lidar", "model": "puck_lite"}, {"type": "imu"}],
                          "agent": {"localization": {"type": "ground_truth"}, "guidance": {
                              "type": "waypoints", "waypoints_m": [[-3, 0, 2]]}}}]}))
        alone = swiftlet.Onboard(swiftlet.load(SLAM))
        scans = 0
        while not source.finished:
            source.tick()
            vehicle = source.vehicle(0)
            imu = vehicle.samples("imu")
            for i in range(len(imu)):
                alone.add("imu", t_ns=int(imu.t_ns[i]), omega_radps=imu.omega_radps[i], f_mps2=imu.f_mps2[i])
            for scan in vehicle.scans:
                alone.add_scan(scan_of(scan))
                scans += 1
            alone.step(source.t_ns)
        self.assertGreater(scans, 12)
        self.assertTrue(alone.estimate.valid)
        return np.linalg.norm(alone.estimate.local_pose[:3, 3] - source.states.position_m[0])

    def test_a_vehicle_localizes_itself_by_own_point_clouds_and_imu(self):
        def image(scan):  # as a driver would give it: points, and nothing else
            points = scan.origins_lidar_m + scan.range_m[..., None] * scan.directions_lidar
            range_m = np.where(scan.range_m > 0, np.linalg.norm(points, axis=2), 0)
            unit = points / np.maximum(np.linalg.norm(points, axis=2, keepdims=True), 1e-6)
            return swiftlet.make_scan(range_m, unit, scan.t_ns, duration_s=scan.duration_s, sensor=scan.sensor,
                                      range_max_m=scan.range_max_m)
        self.assertLess(self.fly_slam(image), 0.15)

    def test_a_vehicle_localizes_itself_by_half_of_each_sweep_in_any_order_with_the_time_of_each_point(self):
        def half(scan):
            points, right = scan.points_lidar_m(), scan.points_lidar_m()[:, 1] < 0
            times_s = np.broadcast_to(scan.column_offset_s, scan.range_m.shape)[scan.range_m > 0]
            order = np.random.default_rng(1).permutation(np.flatnonzero(right))
            range_m = np.linalg.norm(points[order], axis=1)
            return swiftlet.make_scan(range_m[None], (points[order] / range_m[:, None])[None], scan.t_ns,
                                      duration_s=scan.duration_s, offset_s=times_s[order][None], sensor=scan.sensor)
        self.assertLess(self.fly_slam(half), 0.15)

    def test_mount_of_the_sensor_places_its_scans(self):
        direction = np.array([[[1.0, 0, 0], [0, 1.0, 0]]])
        for mount, own, expected in (({"position_m": [0, 0, 1], "rpy_deg": [0, 0, 90]}, None, [[0, 5, 1], [-3, 0, 1]]),
                                     ({"position_m": [0, 0, 1], "rpy_deg": [0, 0, 90]}, np.eye(4), [[5, 0, 0], [0, 3, 0]])):
            Sees.points_m = None
            alone = swiftlet.Onboard(swiftlet.load(self.team, {
                "vehicles[eye].agent.guidance": {"type": "sees"}, "vehicles[eye].sensors[0].mount": mount}))
            alone.add("pose", **SAMPLES["pose"])
            alone.add_scan(swiftlet.make_scan([[5.0, 3.0]], direction, 1, sensor="os1", T_body_lidar=own))
            alone.step(1)
            np.testing.assert_allclose(Sees.points_m, expected, atol=1e-6)

    def test_faults_warnings_events_and_counters_are_reported(self):
        alone = swiftlet.Onboard(swiftlet.load(SLAM))
        self.assertEqual((alone.fault, alone.warning, alone.mission, len(alone.events)), ("", "", "running", 0))
        alone.add("imu", **SAMPLES["imu"])
        alone.step(1)
        self.assertEqual(alone.fault, "")
        alone.step(500_000_000)
        self.assertEqual((alone.fault, alone.mission, alone.mission_note), ("no IMU", "failed", "no IMU"))
        self.assertEqual(alone.warning, "SLAM: dead reckoning by the IMU alone")
        self.assertEqual((list(alone.events.kind)[-1], list(alone.events.note)[-1]), ("mission_failed", "no IMU"))
        self.assertIn("agent.localization.local.known_share_min", [counter["setting"] for counter in alone.counters])

    def test_a_call_meets_no_other_call_of_the_same_software(self):
        alone = swiftlet.Onboard(swiftlet.load(self.team, {"vehicles[eye].agent.guidance": {"type": "waits"}}))
        alone.add("pose", **SAMPLES["pose"])
        stepping = threading.Thread(target=alone.step, args=(1,))
        stepping.start()
        self.assertTrue(Waits.entered.wait(60))
        scan = swiftlet.make_scan([[1.0, 1.0]], X_AND_Y, 1, sensor="os1")
        for call in (lambda: alone.step(2), lambda: alone.add("pose", **SAMPLES["pose"]), lambda: alone.add_scan(scan),
                     lambda: alone.estimate, lambda: alone.detections, lambda: alone.tracks, lambda: alone.relatives,
                     lambda: alone.reference, lambda: alone.rotor_command, lambda: alone.fault, lambda: alone.warning,
                     lambda: alone.events, lambda: alone.counters, alone.maps):
            with self.assertRaisesRegex(RuntimeError, "this Onboard is in use by another call"):
                call()
        Waits.leave.set()
        stepping.join()
        alone.add("pose", **{**SAMPLES["pose"], "t_ns": 2})
        alone.step(2)
        self.assertTrue(alone.estimate.valid)


class Samples(support.InFolder):
    def refused(self, error, message, kind, **columns):
        with self.assertRaisesRegex(error, message):
            self.alone.add(kind, **columns)

    def setUp(self):
        super().setUp()
        self.alone = swiftlet.Onboard(swiftlet.load(self.team))

    def test_every_column_of_a_sample_is_needed_as_numbers_of_its_shape(self):
        for kind, columns in SAMPLES.items():
            self.alone.add(kind, **columns)
            for name, value in columns.items():
                self.refused(TypeError, f"^{kind}: {name}: expected a value, found none", kind,
                             **{key: column for key, column in columns.items() if key != name})
                for wrong in (None, "north", "1", [1, "a"], 1j, np.ones(np.shape(value) + (2,)), {}, [[1], [1, 2]]):
                    self.refused(TypeError, f"^{kind}: {name}: expected .*, found ", kind, **{**columns, name: wrong})
                if name in ("t_ns", "neighbor"):
                    self.refused(TypeError, f"^{kind}: {name}: expected an integer, found 1.5", kind, **{**columns, name: 1.5})
                    continue
                for wrong in (math.nan, math.inf):
                    self.refused(ValueError, f"^{kind}: {name}: expected .*, found .*(nan|inf)", kind,
                                 **{**columns, name: np.full(np.shape(value), wrong)})

    def test_values_that_nothing_can_measure_are_refused(self):
        turned = np.diag([1.0, 1.0, -1.0, 1.0])
        for kind, name, wrong in (("gnss", "sigma_m", (1, 1, -1)), ("gnss", "sigma_v_mps", (-1, 1, 1)),
                                  ("altimeter", "sigma_m", -0.1), ("compass", "sigma_rad", -0.1),
                                  ("pose", "pose", turned), ("odometry", "pose", 2 * np.eye(4)), ("pose", "pose", np.zeros((4, 4))),
                                  ("neighbors", "neighbor", 2), ("neighbors", "neighbor", -2),
                                  ("neighbors", "cov_m2", -np.eye(3)), ("neighbors", "cov_m2", [[1, 1, 0], [0, 1, 0], [0, 0, 1]])):
            self.refused(ValueError, f"^{kind}: {name}: expected ", kind, **{**SAMPLES[kind], name: wrong})

    def test_names_that_do_not_exist_are_refused_with_what_was_meant(self):
        self.refused(TypeError, 'imu: .*did you mean "omega_radps"', "imu", t_ns=0, omega_radsp=(0, 0, 0), f_mps2=(0, 0, 0))
        self.refused(KeyError, "altimeter", "sonar", t_ns=0)
        with self.assertRaises(TypeError):
            self.alone.add(3, t_ns=0)
        with self.assertRaises(TypeError):
            self.alone.add_scan(np.ones((2, 3)))
        for vehicle in (-1, 2):
            with self.assertRaisesRegex(IndexError, f"vehicle: expected a number below 2, found {vehicle}"):
                swiftlet.Onboard(swiftlet.load(self.team), vehicle)
        for wrong in ((str(self.team),), (swiftlet.load(self.team), "eye"), (swiftlet.load(self.team), 0.5)):
            with self.assertRaises(TypeError):
                swiftlet.Onboard(*wrong)

    def test_times_do_not_go_back(self):
        def sample(kind, t_ns):
            self.alone.add(kind, **{**SAMPLES[kind], "t_ns": t_ns})

        def scan(t_ns, sensor="os1"):
            self.alone.add_scan(swiftlet.make_scan([[1.0, 1.0]], X_AND_Y, t_ns, sensor=sensor))
        sample("pose", 4_000_000)
        sample("pose", 4_000_000)  # equal times are fine
        sample("imu", 3_000_000)   # kinds are delivered apart
        scan(2_000_000)
        front = swiftlet.make_scan([[1.0, 1.0]], X_AND_Y, 1_000_000, sensor="front", T_body_lidar=np.eye(4))
        self.alone.add_scan(front)
        for call, message in ((lambda: sample("pose", 3_999_999), "pose: t_ns: expected 4000000"),
                              (lambda: scan(1_000_000), "scan of os1: t_ns: expected 2000000"),
                              (lambda: self.alone.step(3_000_000), "step: t_ns: expected 4000000, as of the latest pose")):
            with self.assertRaisesRegex(ValueError, message):
                call()
        self.alone.step(4_000_000)
        for t_ns in (3_000_000, 4_000_000):
            with self.assertRaisesRegex(ValueError, f"step: t_ns: .*step before, 4000000, found {t_ns}"):
                self.alone.step(t_ns)
        with self.assertRaises(TypeError):
            self.alone.step(0.008)
        self.alone.add_scan(swiftlet.make_scan([[1.0, 1.0]], X_AND_Y, 5_000_000, sensor="os1", duration_s=0.003))
        with self.assertRaisesRegex(ValueError, "step: t_ns: expected 8000000, as of the latest scan of os1 at the end of its sweep"):
            self.alone.step(7_999_999)
        self.alone.step(8_000_000)

    def test_imu_in_other_units_or_upside_down_is_refused(self):
        for wrong, message in ((dict(f_mps2=(0, 0, 1.0)), "at rest, found .* if it is in g"), (dict(f_mps2=(0, 0, -9.81)), "z up, found .*; negate it"),
                               (dict(omega_radps=(0, 0, 90.0)), "rad/s, found .0, 0, 90")):
            alone = swiftlet.Onboard(swiftlet.load(SLAM))
            with self.assertRaisesRegex(ValueError, f"^IMU: expected .*{message}"):
                for i in range(100):
                    alone.add("imu", **{**SAMPLES["imu"], **wrong, "t_ns": i})

    def test_a_scan_needs_a_mount(self):
        scan = swiftlet.make_scan([[1.0, 1.0]], X_AND_Y, 0, sensor="os2")
        with self.assertRaisesRegex(ValueError, 'add_scan: expected T_body_lidar, or .*"os1", found "os2"; did you mean "os1"'):
            self.alone.add_scan(scan)


class Scans(support.InFolder):
    def make(self, **changes):
        return swiftlet.make_scan(**{"range_m": [[5.0, 3.0]], "directions_lidar": X_AND_Y, "t_ns": 0, **changes})

    def test_odd_values_are_refused_by_name(self):
        for name, wrong in (("range_m", [[-5.0, 3.0]]), ("range_m", [[-math.inf, 3.0]]), ("range_m", [5.0, 3.0]), ("range_m", [[]]),
                            ("duration_s", -0.1), ("duration_s", 100.0), ("duration_s", math.nan),
                            ("range_max_m", 0.0), ("range_max_m", -1.0), ("range_max_m", math.nan), ("range_max_m", math.inf),
                            ("sigma_range_m", -0.02), ("sigma_range_m", math.nan),
                            ("directions_lidar", 2 * X_AND_Y), ("directions_lidar", 0 * X_AND_Y),
                            ("directions_lidar", math.nan * X_AND_Y), ("directions_lidar", np.ones((3, 2, 3))),
                            ("reflectivity", [[1.0]]), ("reflectivity", [[math.nan, 1.0]]),
                            ("offset_s", [0.0]), ("offset_s", [0.0, -0.1]), ("offset_s", [0.0, math.nan]), ("offset_s", [0.0, 50e6]),
                            ("origins_lidar_m", np.zeros((2, 3))), ("origins_lidar_m", 15.8 * X_AND_Y), ("origins_lidar_m", math.nan * X_AND_Y),
                            ("range_m", [[5000.0, 3000.0]]), ("T_body_lidar", 2 * np.eye(4))):
            with self.assertRaisesRegex(ValueError, f"^{name}.*: expected "):
                self.make(**{name: wrong})

    def test_wrong_types_are_refused(self):
        for name, wrong in (("range_m", [["5", "3"]]), ("range_m", None), ("range_m", [[5, 3j]]), ("range_m", [[5, 3], [5]]),
                            ("directions_lidar", "xy"), ("t_ns", 0.5), ("t_ns", "0"), ("duration_s", "0.1"), ("sensor", 3),
                            ("range_max_m", "far"), ("reflectivity", "white"), ("offset_s", "0"), ("T_body_lidar", np.eye(3)), ("origins_lidar_m", "0"),
                            ("offsets", [0, 0])):
            with self.assertRaisesRegex(TypeError, name):
                self.make(**{name: wrong})

    def test_points_in_the_place_of_unit_vectors_are_refused(self):
        points = np.array([[[3.0, 4.0, 0.0], [0.0, 10.0, 0.0]]])
        range_m = np.linalg.norm(points, axis=2)
        with self.assertRaisesRegex(ValueError, r"directions_lidar: expected unit vectors, found one of length 5.0* at \[0, 0\]"):
            self.make(range_m=range_m, directions_lidar=points)
        scan = self.make(range_m=range_m, directions_lidar=points / range_m[..., None])
        np.testing.assert_allclose(scan.points_lidar_m(), points[0])

    def test_a_beam_without_return_needs_no_direction(self):
        for nothing in (0.0, math.nan, math.inf, 1e3):
            directions = X_AND_Y.copy()
            directions[0, 0] = math.nan
            scan = self.make(range_m=[[nothing, 3.0]], directions_lidar=directions)
            np.testing.assert_allclose(scan.points_lidar_m(), [[0, 3, 0]])

    def test_nan_is_unknown_and_other_ranges_without_return_are_free(self):
        directions = np.broadcast_to(X_AND_Y[:, :1], (1, 4, 3))
        scan = self.make(range_m=[[0.0, math.nan, math.inf, 5.0]], directions_lidar=directions)
        np.testing.assert_array_equal(scan.masked, [[0, 1, 0, 0]])
        np.testing.assert_array_equal(scan.range_m, [[0, 0, 0, 5]])

    def test_ranges_are_measured_from_the_origins_of_the_beams(self):
        origins = np.array([[[0, 0.1, 0], [0.2, 0, 0]]])
        scan = self.make(origins_lidar_m=origins, offset_s=[0.1, 0.0])
        np.testing.assert_allclose(scan.points_lidar_m(), [[0.2, 3, 0], [5, 0.1, 0]], rtol=1e-6)
        np.testing.assert_allclose(scan.origins_lidar_m, origins[:, ::-1], rtol=1e-6)

    def test_columns_and_points_come_in_the_order_of_their_times(self):
        rng = np.random.default_rng(4)
        directions = rng.normal(size=(3, 5, 3))
        directions /= np.linalg.norm(directions, axis=2, keepdims=True)
        range_m = rng.uniform(1, 9, (3, 5))
        points = range_m[..., None] * directions
        columns_s, points_s = rng.permutation(5) / 100, rng.permutation(15).reshape(3, 5) / 100
        scan = self.make(range_m=range_m, directions_lidar=directions, offset_s=columns_s)
        self.assertEqual((scan.rows, scan.cols, scan.duration_s), (3, 5, 0.04))
        np.testing.assert_allclose(scan.column_offset_s, np.sort(columns_s))
        np.testing.assert_allclose(scan.points_lidar_m(), points[:, np.argsort(columns_s)].reshape(-1, 3), rtol=1e-5)
        scan = self.make(range_m=range_m, directions_lidar=directions, offset_s=points_s, reflectivity=points_s, duration_s=0.2)
        self.assertEqual((scan.rows, scan.cols, scan.duration_s), (1, 15, 0.2))
        np.testing.assert_allclose(scan.column_offset_s, np.arange(15) / 100, rtol=1e-6)
        np.testing.assert_allclose(scan.reflectivity[0], np.arange(15) / 100, rtol=1e-6)
        np.testing.assert_allclose(scan.points_lidar_m(), points.reshape(-1, 3)[np.argsort(points_s, axis=None)], rtol=1e-5)
        with self.assertRaisesRegex(ValueError, "offset_s: expected a number from 0 to 0.1"):
            self.make(range_m=range_m, directions_lidar=directions, offset_s=points_s, duration_s=0.1)

    def test_a_scan_has_the_mounting_that_is_given(self):
        mount = np.eye(4)
        mount[:3, 3] = (0.1, 0, 0.25)
        np.testing.assert_array_equal(self.make(T_body_lidar=mount).T_body_lidar, mount)
        np.testing.assert_array_equal(self.make().T_body_lidar, np.eye(4))


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

    def test_odd_arguments_are_refused_by_name(self):
        point, C = [[1.0, 0, 0]], [np.eye(3)]
        for function, arguments, name, odd, wrong in (
                (functions.point_covariances, (point, [1.0], np.eye(3)), ("directions_lidar", "range_m", "R_world_lidar"),
                 ([[math.nan, 0, 0]], [1.0, 2.0], np.full((3, 3), math.nan)), ("x", ["a"], np.eye(2))),
                (functions.error_quantiles_m, (C, 0.9), ("covariances_m2", "p"), ([np.zeros((3, 3))], 1.5), ("C", "0.9")),
                (functions.error_means_m, (C,), ("covariances_m2",), ([-np.eye(3)],), ([["a"]],)),
                (functions.correct_voxel_probabilities, (point, C, 0.1), ("points_world_m", "covariances_m2", "edge_m"),
                 ([[math.inf, 0, 0]], [np.eye(3)] * 2, 0.0), ("x", "C", "0.1")),
                (functions.box_probability, ((0, 0, 0), np.eye(3), (-1, -1, -1), (1, 1, 1)),
                 ("mean_m", "covariance_m2", "min_m", "max_m"),
                 ((math.nan, 0, 0), np.diag([1, 1, -1]), (2, 0, 0), (math.nan, 1, 1)), ("x", np.eye(4), (0, 0), None))):
            function(*arguments)
            for i in range(len(arguments)):
                with self.assertRaises(ValueError):
                    function(*arguments[:i], odd[i], *arguments[i + 1:])
                with self.assertRaisesRegex(TypeError, name[i]):
                    function(*arguments[:i], wrong[i], *arguments[i + 1:])
            with self.assertRaises(TypeError):
                function(*arguments, nothing=1)


class Flocking(support.InFolder):
    def test_rbl_goes_to_its_goal_and_away_from_neighbors(self):
        alone = functions.Rbl(planar=True).step((0, 0, 2), [], (10, 0, 2), 0.1)
        self.assertGreater(alone["centroid_m"][0], 0.3)
        near = functions.Rbl(planar=True).step((0, 0, 2), [(1.2, 0, 2)], (10, 0, 2), 0.1)
        self.assertLess(near["centroid_m"][0], alone["centroid_m"][0])
        wall = functions.Rbl(planar=True).step((0, 0, 2), [], (10, 0, 2), 0.1,
                                               obstacles_m=[(1.5, y, 2) for y in np.arange(-4, 4, 0.2)])
        self.assertLess(wall["centroid_m"][0], alone["centroid_m"][0])

    def test_odd_arguments_are_refused_by_name(self):
        right = dict(position_m=(0, 0, 2), neighbors_m=[], goal_m=(9, 0, 2), dt_s=0.1)
        rbl = functions.Rbl()
        rbl.step(**right)
        for name, odd, wrong in (("position_m", (math.nan, 0, 0), "x"), ("neighbors_m", [(math.inf, 0, 0)], ["a"]),
                                 ("goal_m", (0, 0, math.inf), (0, 0)), ("dt_s", 0.0, "0.1"), ("obstacles_m", [(1, 2)], "x"),
                                 ("obstacle_edge_m", -0.2, None), ("z_max_m", -1.0, "high")):
            with self.assertRaisesRegex(ValueError, f"^{name}"):
                rbl.step(**{**right, name: odd})
            with self.assertRaisesRegex(TypeError, name):
                rbl.step(**{**right, name: wrong})
        with self.assertRaises(TypeError):
            rbl.step(**right, nothing=1)

    def test_its_keys_are_read_strictly(self):
        with self.assertRaisesRegex(swiftlet.InputError, 'did you mean "encumbrance_m"'):
            functions.Rbl({"encumberance_m": 0.5})


if __name__ == "__main__":
    support.main()
