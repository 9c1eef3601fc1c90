#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Evaluations that experiments share, on flights with results in closed form, and a start of SLAM in flight. Usage: shared_test.py SOURCE_DIR"""
import itertools
import json
import math
import pathlib
import sys
import tempfile
import unittest
from types import SimpleNamespace
from unittest import mock

try:
    import numpy as np
    import swiftlet
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(sys.argv[1]).resolve() / "tools/experiments"))
import slam_faults  # noqa: E402
from shared import crossing, detection, guidance, point_noise, rbl_prediction, slam  # noqa: E402
from shared.rotations import rotations  # noqa: E402

RNG = np.random.default_rng(1)
TICK_S = 0.01  # of synthetic flights
EAST, NORTH = [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)]  # attitudes xyzw
near = np.testing.assert_allclose


def fly(function, places_m, sensors, agent, *arguments):
    """Calls function with a short scenario in which vehicles hover at these places."""
    agent = {"localization": {"type": "ground_truth"}, "guidance": {"type": "hover"}, **agent}
    vehicles = [{"name": f"uav{i}", "model": "x500", "start": {"position_m": p_m}, "sensors": sensors, "agent": agent}
                for i, p_m in enumerate(places_m)]
    with tempfile.TemporaryDirectory() as folder:
        scenario = pathlib.Path(folder) / "hover.yaml"
        scenario.write_text(json.dumps({"name": "hover", "duration_s": 1.1, "world": {"type": "empty"}, "vehicles": vehicles}))
        return function(scenario, *arguments)


def replay(function, p_m, missions, *arguments):
    """Calls function with a simulator that puts two vehicles at the places p_m (ticks, 2, 3). missions: those of the first one, which has
    a wrong estimate of its own pose, and one of the other vehicle's relative position that is off by 0.3 m in x and 0.4 m in y."""
    states = mock.MagicMock(position_m=np.zeros((2, 3)), q_xyzw=np.array([NORTH, EAST]), crashed=np.zeros(2, bool), __len__=lambda _: 2)
    correction, local = detection.pose([7.0, 8.0, 9.0], NORTH), detection.pose([1.0, 2.0, 3.0], [0.6, 0.0, 0.8, 0.0])
    first, other = mock.Mock(estimate=SimpleNamespace(correction_pose=correction, local_pose=local)), mock.Mock(mission="")
    metrics = {"time_to_done_s": None, "min_clearance_surface_m": 2.0, "min_clearance_vehicle_m": None}
    summary = {"outcome": "finished", "metrics": {"run": {"min_separation_m": 1.0}, "vehicles": {first.name: metrics}}}
    simulator = mock.Mock(states=states, t_s=0.0, finished=False, vehicle=[first, other].__getitem__, summary=lambda: summary)

    def tick():
        i = int(simulator.t_s)
        simulator.t_s, simulator.finished, states.position_m[:] = i + 1.0, i + 1 == len(p_m), p_m[i]
        first.mission = first.mission_note = missions[i]
        to_believed = correction @ local @ np.linalg.inv(detection.pose(states.position_m[0], NORTH))
        first.relatives = mock.MagicMock(other=np.array([1]), __len__=lambda _: 1, position_m=detection.transformed(
            to_believed, states.position_m[[1]] + [0.3, 0.4, 0.0]))
    simulator.tick = tick
    with mock.patch.multiple(swiftlet, load=mock.DEFAULT, Simulator=lambda *_, **__: simulator):
        return function(*arguments)


class Slam(unittest.TestCase):
    tick = np.arange(2000)[:, None]
    p_m = 0.03 * tick * [0.6, 0.8, 0.0]  # straight, at 3 m/s

    def log(self, p_local_m, shift_m=0.0, revision=0, turn=np.eye(3)):
        """Flight along p_m, with p_local_m and an attitude turned by `turn` as estimate and shift_m as correction."""
        T_local, T_world_local = np.tile(np.eye(4), (2, len(self.tick), 1, 1))
        T_local[:, :3, :3], T_local[:, :3, 3], T_world_local[:, :3, 3] = turn @ rotations(NORTH), p_local_m, shift_m
        return SimpleNamespace(t_s=TICK_S * self.tick[:, 0], p_true_m=self.p_m, q_true_xyzw=0 * self.tick + NORTH, T_local=T_local,
                               T_world_local=T_world_local, p_shown_m=p_local_m + shift_m, revision=np.ravel(0 * self.tick + revision))

    def test_rotations_are_those_of_quaternions(self):
        def product(a, b):
            return np.append(a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3]), a[3] * b[3] - a[:3] @ b[:3])
        q_xyzw, v = RNG.standard_normal((20, 4)), np.array([1.0, 2.0, 3.0, 0.0])
        q_xyzw /= np.linalg.norm(q_xyzw, axis=1, keepdims=True)
        for q, R in zip(q_xyzw, rotations(q_xyzw)):
            turned = product(product(q, v), q * [-1, -1, -1, 1])[:3]
            near(R @ v[:3], turned, atol=1e-12)
            near(slam.moved_by(detection.pose([4.0, 5.0, 6.0], q)[None], v[None, :3]), [turned + [4.0, 5.0, 6.0]])
            near(R @ R.T, np.eye(3), atol=1e-12)
            np.testing.assert_array_equal(rotations(q), R)

    def test_drift_is_relative_to_the_path(self):
        self.assertAlmostEqual(slam.drift_percent(self.log(1.01 * self.p_m), 10.0), 1.0)
        self.assertTrue(math.isnan(slam.drift_percent(self.log(self.p_m), 100.0)), "the path is too short")
        R = rotations([0.0, 0.0, math.sin(0.01), math.cos(0.01)])
        self.assertAlmostEqual(slam.drift_percent(self.log(self.p_m @ R.T + [1, 2, 3], turn=R), 10.0), 0.0, msg="another local frame")
        self.assertAlmostEqual(slam.drift_percent(self.log(self.p_m, turn=R), 10.0), 100 * 2 * math.sin(0.01), msg="wrong attitude")

    def test_jumps_of_the_correction_are_steps(self):
        begun = 1 * (self.tick >= 30) + (self.tick >= 60)
        shift_m = (self.tick >= 30) * [0.0, 0.3, 0.0] + (self.tick >= 60) * [0.4, 0.0, 0.0]
        found = slam.measure_corrections(self.log(self.p_m, shift_m, begun))
        expected = {"corrections": 2, "largest_m": 0.4, "step_m": 0.4, "speed_mps": 0.0, "acceleration_mps2": 0.0}
        near([found[key] for key in expected], list(expected.values()), atol=1e-9, err_msg=str(found))

    def test_smooth_corrections_have_no_step(self):
        a_mps2, t_s = 0.5, np.clip(TICK_S * self.tick - 1.0, 0.0, 2.0)  # constant acceleration for 1 s, then as much deceleration
        way_m = a_mps2 * np.where(t_s < 1.0, 0.5 * t_s**2, 1.0 - 0.5 * (2.0 - t_s)**2)
        begun_or_ended = 1 * (t_s > 1e-9) + (t_s > 2.0 - 1e-9)
        found = slam.measure_corrections(self.log(self.p_m, way_m * [0.0, 0.6, 0.8], begun_or_ended))
        near([found[key] for key in ("corrections", "largest_m", "acceleration_mps2")], [1, a_mps2, a_mps2])
        self.assertAlmostEqual(found["speed_mps"], a_mps2, delta=a_mps2 * TICK_S)
        self.assertLess(found["step_m"], 1.01 * a_mps2 * TICK_S**2)

    def test_errors_count_from_the_first_correction(self):
        offset_m = np.array([0.3, 0.0, 0.4])
        found = slam.measure_errors(self.log(self.p_m + offset_m, np.where(self.tick < 100, 50.0, -offset_m), self.tick >= 100))
        near([found["rms_local_after_m"], found["rms_after_m"]], [0.5, 0.0], atol=1e-9)
        found = slam.measure_errors(self.log(self.p_m + offset_m, (self.tick < 1000) * [0.0, 1.2, 0.0]))
        near([found["rms_local_after_m"], found["rms_after_m"]], [0.5, math.sqrt(0.5**2 + 0.5 * 1.2**2)], err_msg="no correction")

    def test_flights_by_the_truth_have_no_errors(self):
        simulator, log = fly(slam.record, [[1, 2, 5]], [{"type": "gnss", "latency_s": 0.1}], {}, {"seed": 2})
        flight = json.loads(json.dumps(slam.describe(simulator, log)))
        self.assertEqual([flight[key] for key in ("corrections", "step_m", "rms_after_m")], [0, 0.0, 0.0])
        near(np.diff(flight["course"]["t_s"]), [0.5, 0.5])
        self.assertTrue(np.isnan(log.p_gnss_m[0]).all(), "no fix yet")
        self.assertGreater(len(np.unique(log.p_gnss_m[np.isfinite(log.p_gnss_m[:, 0])], axis=0)), 3, "each fix replaces the one before")


class SlamStart(unittest.TestCase):
    def test_motion_is_not_taken_for_standstill(self):
        for seed in (9106, 9107):  # rings of a Puck LITE look alike while the vehicle flies along walls; 18 m are flown
            flight = slam_faults.fly_fault("campus", "puck_lite", "start at 3 m/s", seed, 6.0)
            self.assertEqual(flight["valid_share"], 1.0, flight)
            self.assertLess(flight["final_m"], 1.5, flight)

    def test_a_turned_lidar_is_not_explained_by_late_stamps(self):
        flight = slam_faults.fly_fault("forest", "os1_128", "LiDAR turned by 180 deg", 9105, 3.0)
        self.assertLess(flight["worst_m"], 0.6, flight)


class Guidance(unittest.TestCase):
    def test_passes_lead_from_side_to_side(self):
        near(guidance.in_world((10.0, 20.0, 0.0), 3.0, 1.0, 2.0), [13.0, 21.0, 2.0])
        near(guidance.in_world((10.0, 20.0, math.pi / 2), 3.0, 1.0, 2.0), [9.0, 23.0, 2.0])
        # Through, back to the middle and away again, and back with jitter in the middle.
        y_m = [-2, -1, -0.5, 0.1, 1, 2, 0.5, -0.1, 0.2, 2, 1, 0.3, -0.3, 0.3, -0.3, -1, -2, 0.1, -3]
        notes = [guidance.GUIDING if 3 <= tick < 18 else "" for tick in range(len(y_m))]
        flight = replay(guidance.fly_guided, [[[5, 5, 5], [0, y, 1]] for y in y_m], notes, "", {}, (0.0, 0.0, math.pi / 2))
        self.assertEqual([flight[key] for key in ("passes", "done", "least_clearance_m")], [2, False, 2.0])
        self.assertAlmostEqual(flight["farthest_m"], 2.1, msg="from where guiding begins")
        count = sum(abs(y) <= guidance.NEAR_M for y in y_m)
        near([flight[key] for key in ("num_errors", "error_sum_m", "along_wall_sum_m")], [count, 0.5 * count, 0.3 * count])


class Rbl(unittest.TestCase):
    def test_directions_are_evenly_spaced(self):
        for shape, count, poles, spread in (("circle", 7, False, 1.001), ("sphere", 60, False, 1.2), ("sphere", 60, True, 2.0)):
            away = np.array([crossing.direction(shape, count, i, poles) for i in range(count)])
            near(np.linalg.norm(away, axis=1), 1.0)
            near(away.mean(axis=0), 0.0, atol=1.0 / count)
            nearest = np.sort(np.linalg.norm(away[:, None] - away, axis=2), axis=1)[:, 1]
            self.assertLess(nearest.max() / nearest.min(), spread)
            self.assertEqual(poles, abs(away[0, 2]) == abs(away[-1, 2]) == 1.0)

    def test_vehicles_face_their_opposite_goals(self):
        for shape in ("circle", "sphere"):
            for vehicle in crossing.crossing_vehicles(1, shape, 6, 10.0, {}):
                start_m, goal_m = np.array(vehicle["start"]["position_m"]), np.array(vehicle["agent"]["guidance"]["goal_m"])
                near(start_m + goal_m, [0.0, 0.0, 2.0 * crossing.HEIGHT_M[shape]], rtol=0, atol=crossing.START_SPREAD_M)
                turned_rad = math.radians(vehicle["start"]["yaw_deg"]) - math.atan2(goal_m[1], goal_m[0])
                self.assertAlmostEqual(math.cos(turned_rad), 1.0)

    def test_lengths_end_at_the_goal(self):
        p_m = [[[3 * tick, 0, 0], [0, 4 * tick, 0]] for tick in range(6)]
        flight = replay(crossing.fly_crossing, p_m, ["", "", "done", "done", "done", "done"], 1, "circle", 2, 10.0, {})
        self.assertEqual([flight[key] for key in ("length_m", "time_s", "contact")], [[6.0, 20.0], [3.0, None], False])

    def test_columns_count_flights_that_succeed(self):
        times_s = [[5.0, 7.0], [6.0, None], [1.0, 2.0], [None, None], [8.0, 6.0]]
        flights = [{"seed": i + 1, "length_m": [10.0, 30.0], "time_s": time_s, "contact": i == 2, "min_separation_m": 4.0 - i}
                   for i, time_s in enumerate(times_s)]
        experiment = mock.Mock(**{"map.return_value": flights})
        case = crossing.Crossings(experiment, 5, "two", num_vehicles=2)
        self.assertEqual((case.success, case.arrived, case.contact, case.least_distance_m), (2 / 5, 7 / 10, 1 / 5, 0.0))
        self.assertEqual((case.length_m, case.time_s, case.slowest_s), ([10, 30, 10, 30], [5, 7, 8, 6], [7, 8]))
        self.assertEqual(case.mean_time_s, {1: 6, 2: 6, 5: 7})
        crossing.write_flights(experiment, [case])
        _, columns, rows = experiment.write_csv.call_args.args
        table = np.array(rows)[:, [columns.index(column) for column in ("arrived", "length_m", "time_s", "slowest_s")]].astype(float)
        near(table, [[2, 20, 6, 7], [1, 10, 6, 6], [2, 20, 1.5, 2], [0, math.nan, math.nan, math.nan], [2, 20, 7, 8]])

    def predict(self, noise=0.0, delay_s=0.0, rate_hz=10.0, intruder_mps=0.01, limits="medium", cameras="[{fov_deg: 360}]"):
        return rbl_prediction.predict({"noise": noise, "delay_s": delay_s, "rate_hz": rate_hz, "intruder_mps": intruder_mps,
                                       "limits": limits, "cameras": cameras})

    def test_only_distances_without_contact_are_promised(self):
        kinds = {self.predict(intruder_mps=4.0, cameras="[{fov_deg: 180}]")[0]}
        for intruder_mps, rate_hz, delay_s in itertools.product((0.01, 1.0, 2.0, 4.0), (0.5, 2.0, 10.0), (0.0, 0.4)):
            found = [self.predict(noise, delay_s, rate_hz, intruder_mps) for noise in (0.0, 0.02, 0.05, 0.1, 0.2)]
            for kind, least_m in found:
                self.assertEqual(kind.startswith("promised"), least_m > rbl_prediction.TOUCHING_M)
                kinds.add(kind)
            self.assertTrue((np.diff([least_m for _, least_m in found]) <= 0.0).all(), "more noise promises no more")
        self.assertEqual(len(kinds), 5, "every kind is there")
        self.assertLess(self.predict(0.02, 0.4, 10.0, 4.0)[1], self.predict(0.0, 0.4, 10.0, 4.0)[1], "with noise, a speed is known later")
        self.assertEqual(self.predict(0.0, 0.0, 0.5, 0.9, "slow")[1], 0.0, "a slow intruder is taken for a maneuver")

    def test_predictions_are_those_of_an_encounter(self):
        team_m, gap_m, t_s, decisive = self.predict()[1], rbl_prediction.RANGE_M - rbl_prediction.DISTANCE_M, np.arange(0.0, 20.0, 1e-4), 0
        for limits, (most_mps, a_mps2) in rbl_prediction.LIMITS.items():
            for rate_hz, delay_s, intruder_mps in ((2.0, 0.0, 4.0), (2.0, 0.3, 3.0), (5.0, 0.4, 3.0), (10.0, 0.0, 4.0)):
                late_s, v_mps = delay_s + rbl_prediction.REACTION_S, np.arange(0.0, most_mps + 1e-9, 1e-4)
                own_mps = v_mps[2 * v_mps * (1 / rate_hz + late_s) + v_mps**2 / a_mps2 <= gap_m].max()  # two of this speed can stop
                # Two samples are needed, another one is lost, and the intruder comes into range just after a sample.
                aside_mps = np.clip(a_mps2 * (t_s - 3 / rate_hz - late_s), 0.0, most_mps)
                aside_m = 1e-4 * aside_mps[(own_mps + intruder_mps) * t_s < gap_m].sum()
                self.assertAlmostEqual(self.predict(0.0, delay_s, rate_hz, intruder_mps, limits)[1], min(aside_m, team_m), delta=0.002)
                decisive += 0.0 < aside_m < team_m
        self.assertGreater(decisive, 3, "else only the team would be tested")


class Detection(unittest.TestCase):
    def test_targets_behind_a_wall_are_hidden(self):
        azimuth_rad, elevation_rad = np.radians(np.meshgrid(np.arange(-80, 81, 2), np.arange(-30, 31, 2)))
        x, y, z = np.cos(elevation_rad) * np.cos(azimuth_rad), np.cos(elevation_rad) * np.sin(azimuth_rad), np.sin(elevation_rad)
        T_world_body, T_body_lidar = detection.pose([1.0, 2.0, 3.0], NORTH), detection.pose([0.0, 0.0, 0.1], EAST)
        T_world_lidar, wall_m = T_world_body @ T_body_lidar, 5.0 / x * (y > 0.0)  # a wall at x = 5 m, on the left
        scan = SimpleNamespace(t_s=4.0, duration_s=0.1, T_body_lidar=T_body_lidar, true_T_world_lidar=T_world_lidar[None],
                               true_range_m=wall_m, true_class=np.zeros(x.shape, int), directions_lidar=np.float32(np.stack([x, y, z], 2)))
        in_lidar_m = np.array([[8.0, 3.0, 0.0], [8.0, -3.0, 0.0], [3.0, 1.0, 0.0], [3.0, 0.0, 3.0]])  # behind, right, before, above
        targets_m = detection.transformed(T_world_lidar, in_lidar_m)
        found = np.array(detection.targets_of(scan, (-22.5, 22.5), (T_world_body, detection.pose([0.0, 0.5, 0.0], EAST), targets_m))).T
        near(found[:4], [[4.05] * 4, range(4), np.linalg.norm(in_lidar_m, axis=1), [0, 1, 1, 0]], err_msg=str(detection.COLUMNS[:4]))
        near(found[4:], (targets_m + [0.0, 0.5, 0.0]).T, err_msg="in the observer's world")
        scan.true_class[:] = detection.VEHICLE
        self.assertFalse(detection.is_hidden(scan, targets_m[0]), "a vehicle hides nothing")

    def test_recall_counts_visible_targets(self):
        def flight(*sightings):
            return {"tracker": [[0, 0, range_m, visible, 0, 0, 0, error_m, 0, 0, 0, 0] for range_m, visible, error_m in sightings]}
        off_m, far_m = detection.TRUE_POSITIVE_M, detection.FARTHEST_M
        first = flight((7.0, 1, 0.5), (7.5, 1, off_m), (8.0, 0, 0.1), (9.9, 1, math.inf), (5.0, 1, 1.5))
        seen = detection.visible([first, flight((10.0, 1, 2.0), (far_m, 1, 0.1))], "tracker")
        self.assertEqual((len(seen.found), seen.recall(), seen.errors_m().tolist()), (5, 3 / 5, [0.5, 1.5, 2.0]))
        self.assertEqual(seen.between(7.5, 10.0).recall(), 0.0)
        self.assertFalse(detection.Sightings(seen.rows[:detection.FEWEST - 1]).bins(), "too few to be drawn")
        self.assertTrue(math.isnan(detection.visible([flight()], "tracker").recall()), "no sightings")
        many = [(range_m, 1, 0.1) for range_m in np.linspace(0.0, far_m, 1000, endpoint=False)]
        bins = detection.visible([flight(*many)], "tracker").bins()
        self.assertEqual(sum(len(there.found) for there in bins.values()), len(many), "bins part the sightings")
        for middle_m, there in bins.items():
            near(there.range_m, middle_m, rtol=0, atol=detection.BIN_M / 2)

    @mock.patch.object(detection, "IGNORED_S", 0.0)
    def test_errors_are_distances_to_the_target(self):
        sensors = [{"type": "lidar", "model": "os1_128"}, {"type": "imu"}]
        agent = {"detector": {"type": "vofod"}, "tracker": {"type": "vofod"}}
        targets_m = np.array([[6, 1, 4], [6, -4, 4]])
        flight = fly(detection.fly_sightings, [[0, 0, 4], *targets_m.tolist()], sensors, agent, {"duration_s": 0.7}, detection.OS1_DEG)
        for stage in ("detector", "tracker"):
            seen = detection.Sightings(flight[stage])
            self.assertTrue(seen.visible.all() and seen.found.any())
            near(seen.rows[:, 4:7], targets_m[seen.target.astype(int)], atol=0.1)
            off_m = np.linalg.norm(seen.rows[:, 9:12] - seen.rows[:, 4:7], axis=1)
            near(seen.error_m, np.where(np.isnan(off_m), np.inf, off_m), atol=1e-3)
            self.assertLess(seen.errors_m().max(), 1.0, "not the other target's")
            self.assertEqual(flight["false"][stage], flight["reported"][stage] - seen.found.sum())

    def test_samples_have_the_covariance(self):
        for sigma_rad, sigma_m, range_m in ((0.005, 0.1, 24.0), (0.005, 1.0, 72.0), (0.05, 0.001, 1.0)):
            covariance_m2 = point_noise.covariances_m2(sigma_rad, sigma_m, range_m)[0]
            across_m2 = sigma_m**2 + (sigma_rad * range_m)**2  # position, and an arc by the attitude
            near(covariance_m2, np.diag([2 * sigma_m**2, across_m2, across_m2]), rtol=1e-6, atol=1e-12)
            errors_m = point_noise.sample_errors_m(RNG, 100000, sigma_rad, sigma_m, range_m)
            near(np.cov(errors_m.T), covariance_m2, rtol=0, atol=0.03 * covariance_m2.max())

    def test_noise_of_attitude_keeps_the_range(self):
        points_m = point_noise.sample_errors_m(RNG, 100000, 0.5, 0.0, 10.0) + [10.0, 0.0, 0.0]
        near(np.linalg.norm(points_m, axis=1), 10.0)
        near(points_m.mean(axis=0), [10.0 * math.exp(-0.5**2), 0.0, 0.0], atol=0.1, err_msg="mean of a cosine: exp(-sigma^2 / 2)")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
