#!/usr/bin/env python3
"""Scenarios, runs and their arrays from Python, beside the program. Usage: see support.py."""
import gc
import json
import math
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

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
            result = self.program("check", file)
            self.assertEqual(result.returncode, 2)
            self.assertEqual(f"swiftlet: {raised.exception}\n", result.stderr)

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
        result = self.program("run", self.team, "--out", "out", "--set", "vehicles[0].start.yaw_deg=30", "--seed", "7", "--set",
                            "vehicles[eye].start.position_m=[1.0, 2.0, 3.0]", "--set", "name=other", "-q")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual((self.path / "out/scenario.yaml").read_text(), second.yaml)
        self.assertEqual(second.vehicle_names, ["eye", "other"])

    def test_values_of_numpy_and_paths_are_those_of_python(self):
        plain = {"base": str(self.team), "wind": {"mean_mps": [1, 2, 0]}, "seed": 4}
        numpy = {"base": self.team, "wind": {"mean_mps": np.array([1, 2, 0])}, "seed": np.int64(4)}
        self.assertEqual(swiftlet.load(numpy).yaml, swiftlet.load(plain).yaml)
        self.assertEqual(swiftlet.load(self.team, wind=numpy["wind"], seed=numpy["seed"]).yaml,
                         swiftlet.load(self.team, wind=plain["wind"], seed=4).yaml)

    def test_wrong_types_are_type_errors(self):
        for arguments, message in (((None,), "source"), ((3,), "source"), ((b"square",), "source"), ((["square"],), "source"),
                                   ((self.team, "seed=3"), "changes"), ((self.team, [("seed", 3)]), "changes"),
                                   ((self.team, {1: 2}), "changes"), ((self.team, {"seed": {3}}), r"found \{3\}"),
                                   (({"vehicles": [object()]},), "object")):
            for function in (swiftlet.load, swiftlet.check, swiftlet.fly):
                with self.assertRaisesRegex(TypeError, message):
                    function(*arguments)


class Runs(support.InFolder):
    def hash_of_the_program(self):
        result = self.program("run", self.team, "--out", "program", "-q")
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads((self.path / "program/summary.json").read_text())["state_hash"]

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
            self.assertEqual((self.path / "out" / name).read_bytes(), (self.path / "program" / name).read_bytes(), name)
        self.assertEqual(json.loads((self.path / "out/summary.json").read_text())["outcome"], simulator.summary()["outcome"])

    def test_a_world_is_shared_by_runs(self):
        first = swiftlet.Simulator(swiftlet.load(self.team))
        second = swiftlet.Simulator(swiftlet.load(self.team), world=first.world)
        first.run()
        second.run()
        self.assertEqual(first.state_hash, second.state_hash)

    def test_a_world_of_another_seed_or_with_other_settings_is_refused(self):
        world = swiftlet.Simulator(swiftlet.load(self.team, seed=1)).world
        with self.assertRaisesRegex(swiftlet.InputError, "world: expected one of seed 2 .*, found one of seed 1"):
            swiftlet.Simulator(swiftlet.load(self.team, seed=2), world=world)
        for changes in ({"world": {"type": "hall"}}, {"world.ground": False}):
            with self.assertRaisesRegex(swiftlet.InputError, "world: expected that of the scenario"):
                swiftlet.Simulator(swiftlet.load(self.team, changes, seed=1), world=world)
        fixed = swiftlet.Simulator(swiftlet.load(self.team, world_seed=5, seed=1))
        swiftlet.Simulator(swiftlet.load(self.team, world_seed=5, seed=2), world=fixed.world)

    def test_wrong_types_are_type_errors_and_odd_values_value_errors(self):
        scenario = swiftlet.load(self.team)
        simulator = swiftlet.Simulator(scenario)
        for call in (lambda: swiftlet.Simulator(self.team), lambda: swiftlet.Simulator(scenario, threads="all"),
                     lambda: swiftlet.Simulator(scenario, threads=1.5), lambda: swiftlet.Simulator(scenario, world=scenario),
                     lambda: swiftlet.Simulator(scenario, thread=1), lambda: swiftlet.Simulator(scenario, out=3),
                     lambda: swiftlet.fly(self.team, watch=3), lambda: simulator.tick(2.5), lambda: simulator.tick("1"),
                     lambda: simulator.run("1"), lambda: simulator.run(until=1), lambda: simulator.vehicle(None),
                     lambda: simulator.vehicle(0.5), lambda: simulator.vehicle(b"eye"), lambda: simulator.vehicle("eye").samples(3),
                     lambda: simulator.states[0], lambda: swiftlet.allow_plugins(True)):
            self.assertRaises(TypeError, call)
        for call in (lambda: swiftlet.Simulator(scenario, threads=-1), lambda: simulator.tick(-1), lambda: simulator.run(math.nan)):
            self.assertRaises(ValueError, call)
        for call in (lambda: simulator.vehicle("eey"), lambda: simulator.vehicle("eye").samples("imuu"), lambda: simulator.states["p"]):
            self.assertRaises(KeyError, call)
        self.assertRaises(IndexError, lambda: simulator.vehicle(2))
        self.assertEqual(simulator.t_ns, 0)

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
        refused, counted, eye = [], [], simulator.vehicle("eye")

        def other():
            for i in range(200):
                time.sleep(0.001)
                counted.append(i)
            for call in (simulator.tick, simulator.finish, simulator.summary, eye.maps, lambda: simulator.events, lambda: eye.scans,
                         lambda: eye.tracks, lambda: eye.estimate, lambda: eye.samples("imu")):
                try:
                    call()
                except RuntimeError as error:
                    refused.append(str(error))
            os.kill(os.getpid(), signal.SIGINT)

        threading.Thread(target=other).start()
        with self.assertRaises(KeyboardInterrupt):
            simulator.run()
        self.assertEqual(refused, ["this simulator is in use by another call"] * 9)
        self.assertEqual(len(counted), 200)


class Forks(support.InFolder):
    def in_a_fork(self, act):
        """What `act` returns, or its error as a text, in a process that is forked from this one."""
        ours, theirs = multiprocessing.Pipe(duplex=False)

        def answer():
            try:
                theirs.send(act())
            except Exception as error:
                theirs.send(f"{type(error).__name__}: {error}")
        child = multiprocessing.get_context("fork").Process(target=answer)
        child.start()
        try:
            self.assertTrue(ours.poll(120), "the forked process hangs")
            result = ours.recv()
            child.join(60)
            self.assertEqual(child.exitcode, 0)
            return result
        finally:
            child.kill()

    def test_after_a_simulator_forked_processes_refuse_to_fly_and_name_the_remedy(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team), threads=2)
        simulator.tick()
        for act in (lambda: swiftlet.fly(self.team, threads=1), lambda: swiftlet.check(self.team), lambda: simulator.tick(),
                    lambda: simulator.run(), lambda: simulator.finish(),
                    lambda: swiftlet.Simulator(swiftlet.load(self.team), world=simulator.world, threads=1)):
            self.assertRegex(self.in_a_fork(act), 'RuntimeError: .*"spawn"')
        simulator.run()  # here nothing has changed
        self.assertTrue(simulator.finished)

    def test_forked_processes_read_scenarios_and_run_software(self):
        swiftlet.check(self.team)

        def act():
            software = swiftlet.Onboard(swiftlet.load(self.team))
            software.add("pose", t_ns=1, pose=np.eye(4), v_mps=(0, 0, 0), omega_radps=(0, 0, 0))
            software.step(1)
            return software.estimate.valid.item()
        self.assertIs(self.in_a_fork(act), True)

    def test_a_forked_process_leaves_the_run_of_its_parent_alone(self):
        simulators = [swiftlet.Simulator(swiftlet.load(self.team), threads=2, out=self.path / "out")]
        simulators[0].tick()

        def act():
            position_m = simulators[0].states.position_m[0].tolist()
            simulators.clear()
            gc.collect()
            return position_m
        self.assertEqual(self.in_a_fork(act), simulators[0].states.position_m[0].tolist())
        simulators[0].run()
        simulators[0].finish()
        self.assertTrue((self.path / "out/summary.json").is_file())

    def test_before_the_first_simulator_forked_processes_fly(self):
        result = subprocess.run([sys.executable, "-c", f"""
import multiprocessing, swiftlet
def fly(threads):
    return swiftlet.fly({str(self.team)!r}, threads=threads)["state_hash"]
swiftlet.load("square")
with multiprocessing.get_context("fork").Pool(2) as pool:
    print(len(set(pool.map_async(fly, [1, 2]).get(timeout=120))))
"""], capture_output=True, text=True, timeout=240)
        self.assertEqual((result.stdout, result.returncode), ("1\n", 0), result.stderr)


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
