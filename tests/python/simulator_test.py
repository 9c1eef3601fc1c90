#!/usr/bin/env python3
"""Scenarios, runs and their arrays from Python, beside the program. Usage: support.py tells."""
import gc
import json
import os
import signal
import threading
import time
import unittest

import numpy as np

import support
import swiftlet


class Scenarios(support.InFolder):
    def test_mistakes_are_exceptions_with_the_message_of_the_program(self):
        for wrong in ("vehicels: []", "duration_s: long", "vehicles:\n  - {name: a, agent: {localization: {type: inss}}}",
                      "world: {type: forest, stems_per_ha: -1}", "base: nowhere.yaml", "seed: [1"):
            file = self.path / "wrong.yaml"
            file.write_text(f"name: wrong\n{wrong}\n")
            with self.assertRaises(swiftlet.InputError) as raised:
                swiftlet.check(file)
            told = self.program("check", file)
            self.assertEqual(told.returncode, 2)
            self.assertEqual(f"swiftlet: {raised.exception}\n", told.stderr)

    def test_a_mistake_that_shows_only_before_the_first_tick_is_found_by_check(self):
        self.team.write_text(support.TEAM.replace("[6, 1, 4]", "[0.1, 0, 4]"))
        swiftlet.load(self.team)
        with self.assertRaisesRegex(swiftlet.InputError, r"team.yaml:\d+:\d+: vehicles\[1\].start.position_m: .* apart|from"):
            swiftlet.check(self.team)

    def test_a_misspelt_change_is_refused_with_what_was_meant(self):
        with self.assertRaisesRegex(swiftlet.InputError, 'did you mean "start"'):
            swiftlet.load(self.team, {"vehicles[0].strat.yaw_deg": 90})
        guidance = {"vehicles[eye].agent.guidance": {"type": "waypoints", "waypoints_m": [[0, 0, 5]], "spedd": 3}}
        for changes, meant in ((guidance, "speed_mps"), ({"vehicles[eey].model": "f450"}, "eye"), ({"durration": 3}, "duration_s")):
            with self.assertRaisesRegex(swiftlet.InputError, f'did you mean "{meant}"'):
                swiftlet.load(self.team, changes)
        with self.assertRaisesRegex(swiftlet.InputError, 'did you mean "seed"'):
            swiftlet.load(self.team, sed=3)

    def test_changes_are_laid_on_one_after_another(self):
        first = swiftlet.load(self.team, {"vehicles[0].start.yaw_deg": 30}, seed=7)
        second = swiftlet.load(first, {"vehicles[eye].start.position_m": np.array([1.0, 2.0, 3.0])}, name="other")
        self.assertEqual((first.name, second.name, second.seed), ("team", "other", 7))
        told = self.program("run", self.team, "--out", "out", "--set", "vehicles[0].start.yaw_deg=30", "--seed", "7", "--set",
                            "vehicles[eye].start.position_m=[1.0, 2.0, 3.0]", "--set", "name=other", "-q")
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertEqual((self.path / "out/scenario.yaml").read_text(), second.yaml)
        self.assertEqual(second.vehicle_names, ["eye", "other"])


class Runs(support.InFolder):
    def hash_of_the_program(self):
        told = self.program("run", self.team, "--out", "told", "-q")
        self.assertEqual(told.returncode, 0, told.stderr)
        return json.loads((self.path / "told/summary.json").read_text())["state_hash"]

    def test_a_run_has_the_hash_of_the_command_line_for_any_threads_and_watched_or_not(self):
        wanted = self.hash_of_the_program()
        for threads in (1, 2):
            self.assertEqual(swiftlet.fly(self.team, threads=threads)["state_hash"], wanted)
        seen = []
        summary = swiftlet.fly(self.team, watch=lambda s: seen.append((s.t_s, s.vehicle("eye").scans, s.state_hash)))
        self.assertEqual(summary["state_hash"], wanted)
        self.assertEqual(len(seen), 150)
        self.assertEqual(seen[-1][2], wanted)
        self.assertGreater(sum(len(scans) for _, scans, _ in seen), 3)

    def test_a_run_directory_is_that_of_the_program(self):
        self.hash_of_the_program()
        simulator = swiftlet.Simulator(swiftlet.load(self.team), out=self.path / "out")
        simulator.run()
        self.assertFalse((self.path / "out").exists())  # not before it is complete
        simulator.finish()
        for name in ("scenario.yaml", "events.jsonl", "trajectories/eye.tum", "trajectories/other.estimate.tum"):
            self.assertEqual((self.path / "out" / name).read_bytes(), (self.path / "told" / name).read_bytes(), name)
        self.assertEqual(json.loads((self.path / "out/summary.json").read_text())["outcome"], simulator.summary()["outcome"])

    def test_a_world_is_shared_by_runs(self):
        first = swiftlet.Simulator(swiftlet.load(self.team))
        second = swiftlet.Simulator(swiftlet.load(self.team), world=first.world)
        first.run()
        second.run()
        self.assertEqual(first.state_hash, second.state_hash)

    def test_ticks_are_counted_until_the_end(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team))
        simulator.run(until_s=0.2)
        self.assertEqual(simulator.t_ns, 200_000_000)
        self.assertEqual(simulator.tick(1000), 100)
        self.assertTrue(simulator.finished)
        self.assertEqual(simulator.tick(), 0)

    def test_ctrl_c_ends_a_long_run(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team, duration_s=1e6))
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            simulator.run()
        self.assertGreater(simulator.t_s, 0.0)

    def test_other_threads_of_python_go_on_while_a_run_flies_but_may_not_use_it(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team, duration_s=1e6))
        refused, counted, flying = [], [], threading.Event()

        def other():
            for i in range(200):
                time.sleep(0.001)
                counted.append(i)
            try:
                simulator.tick()
            except RuntimeError as error:
                refused.append(str(error))
            os.kill(os.getpid(), signal.SIGINT)

        threading.Thread(target=other).start()
        with self.assertRaises(KeyboardInterrupt):
            simulator.run()
        self.assertEqual(refused, ["this simulator is at work in another call"])
        self.assertEqual(len(counted), 200)


class Arrays(support.InFolder):
    def test_states_look_into_the_simulator(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team))
        states = simulator.states
        np.testing.assert_array_equal(states.position_m, [[0, 0, 4], [6, 1, 4]])
        before, address = states.position_m.copy(), states.position_m.__array_interface__["data"][0]
        simulator.tick(50)
        self.assertEqual(simulator.states.position_m.__array_interface__["data"][0], address)
        self.assertIs(simulator.states.position_m, states.position_m)
        self.assertTrue((states.position_m != before).any())
        self.assertEqual(int(states.t_ns[0]), simulator.t_ns)
        # All columns are parts of the same rows.
        stride = states.position_m.strides[0]
        self.assertTrue(all(states[name].strides[0] == stride for name in states.keys()))
        self.assertLess(abs(states.v_mps.__array_interface__["data"][0] - address), stride)

    def test_arrays_cannot_be_written(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team))
        with self.assertRaises(ValueError):
            simulator.states.position_m[0, 0] = 1.0

    def test_arrays_outlive_their_simulator(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team))
        positions = simulator.states.position_m
        scans = []
        while not simulator.finished:
            simulator.tick()
            scans += simulator.vehicle("eye").scans
        copies = [(scan.range_m.copy(), scan.true_class.copy()) for scan in scans]
        ranges = [(scan.range_m, scan.true_class) for scan in scans]
        last = positions.copy()
        del simulator, scans
        gc.collect()
        swiftlet.fly(self.team)  # memory that was free is used now
        np.testing.assert_array_equal(positions, last)
        for (range_m, true_class), (range_copy, class_copy) in zip(ranges, copies):
            np.testing.assert_array_equal(range_m, range_copy)
            np.testing.assert_array_equal(true_class, class_copy)

    def test_what_an_agent_knows_is_there(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team))
        found = imu = 0
        while not simulator.finished:
            simulator.tick()
            eye = simulator.vehicle("eye")
            imu += len(eye.samples("imu"))
            if eye.detections is not None:
                found += 1
                self.assertEqual(eye.detections.position_m.shape, (len(eye.detections), 3))
        self.assertGreater(imu, 100)
        self.assertGreater(found, 2)
        np.testing.assert_allclose(eye.estimate.local_pose[:3, 3], simulator.states.position_m[0], atol=1e-9)
        np.testing.assert_allclose(np.linalg.det(eye.estimate.local_pose[:3, :3]), 1.0)
        self.assertEqual(eye.tracks.cov_m2.shape, (len(eye.tracks), 9, 9))
        self.assertEqual(eye.mission, "endless")
        detector = eye.maps()["detector"]
        self.assertEqual(detector["centers_local_m"].shape, (len(detector["state"]), 3))
        with self.assertRaisesRegex(KeyError, "altimeter"):
            eye.samples("altimetr")

    def test_points_of_a_scan_are_its_returns(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team))
        scans = []
        while not scans:
            simulator.tick()
            scans = simulator.vehicle("eye").scans
        scan = scans[0]
        hit = scan.range_m > 0
        points = scan.origins_lidar_m[hit] + scan.range_m[hit][:, None] * scan.directions_lidar[hit]
        np.testing.assert_allclose(scan.points_lidar_m(), points, atol=1e-5)
        self.assertEqual((scan.rows, scan.cols), scan.range_m.shape)
        self.assertLess(np.abs(scan.true_range_m - scan.range_m)[hit & (scan.true_range_m > 0)].mean(), 0.1)


if __name__ == "__main__":
    support.main()
