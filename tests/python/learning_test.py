#!/usr/bin/env python3
"""Environments for learning, batches and datasets. Usage: see support.py."""
import numpy as np

import support
import swiftlet
from swiftlet.learning import Box, Reach, TeamEnv, VectorEnv, VehicleEnv

ONE = {"name": "one", "duration_s": 1.0, "world": {"type": "empty"}, "wind": {"gusts": True},
       "vehicles": [{"start": {"position_m": [0, 0, 5]}, "agent": {"localization": {"type": "ground_truth"}}}]}
THREE = dict(ONE, world={"type": "empty", "ground": True}, metrics={"stop_on_crash": False}, vehicles=[
    {"name": name, "start": {"position_m": [3.0 * i, 0, 2]}, "agent": {"localization": {"type": "ground_truth"}}}
    for i, name in enumerate(("a", "b", "c"))])


class Fails(Reach):
    def evaluate(self, simulator):
        raise ValueError("this task fails")


def failing_env():
    return VehicleEnv(ONE, Fails())


def episode(env, seed, actions):
    seen, info = env.reset(seed=seed)
    rows = [seen]
    for action in actions:
        seen, reward, terminated, truncated, _ = env.step(action)
        rows.append(np.append(seen, [reward, terminated, truncated]))
        if terminated or truncated:
            break
    return rows, info["seed"], env.simulator.state_hash


class Gymnasium(support.InFolder):
    def actions(self, count=12):
        box = Box(-1, 1, (4,), seed=4)
        return [box.sample() for _ in range(count)]

    def test_the_same_seed_and_actions_give_the_same_bits(self):
        first, second = (episode(VehicleEnv(ONE), 3, self.actions()) for _ in range(2))
        other = episode(VehicleEnv(ONE), 4, self.actions())
        self.assertEqual(first[2], second[2])
        self.assertNotEqual(first[2], other[2])
        for a, b in zip(first[0], second[0]):
            np.testing.assert_array_equal(a, b)

    def test_an_environment_is_reset_to_what_a_new_one_is(self):
        env = VehicleEnv(ONE)
        episode(env, 9, self.actions(3))
        self.assertEqual(episode(env, 3, self.actions())[2], episode(VehicleEnv(ONE), 3, self.actions())[2])

    def test_a_step_before_the_first_reset_and_a_seed_that_is_no_integer_are_refused(self):
        env = VehicleEnv(ONE)
        with self.assertRaisesRegex(RuntimeError, "expected a reset before the first step"):
            env.step(np.zeros(4))
        for seed in (1.5, "3"):
            self.assertRaises(TypeError, lambda: env.reset(seed=seed))
        env.reset(seed=np.int64(3))

    def test_a_drawn_seed_is_reported_and_repeats_the_episode(self):
        env = VehicleEnv(ONE)
        _, seed, state_hash = episode(env, None, self.actions())
        self.assertEqual(episode(env, seed, self.actions())[2], state_hash)

    def test_it_has_the_form_that_learners_expect(self):
        env = VehicleEnv(ONE)
        seen, info = env.reset(seed=1)
        self.assertEqual((seen.shape, seen.dtype), (env.observation_space.shape, np.float32))
        self.assertTrue(env.action_space.contains(env.action_space.sample()))
        self.assertIn("seed", info)
        ends = []
        while not ends or not any(ends[-1]):
            seen, reward, terminated, truncated, info = env.step(np.zeros(4, np.float32))
            self.assertTrue(type(reward) is float and type(terminated) is bool and type(truncated) is bool)
            ends.append((terminated, truncated))
        self.assertEqual(len(ends), 10)  # 1 s, an action every 0.1 s
        self.assertEqual(ends[-1], (False, True))
        env.close()

    def test_an_action_outside_of_the_action_space_is_refused(self):
        env = VehicleEnv(ONE)
        env.reset(seed=1)
        env.step(np.array([1, -1, 1, -1], np.float32))
        for action, message in (((2.0, 0, 0, 0), r"action of uav1: vx: expected a number in \[-1, 1\], found 2"),
                                ((0, 0, -1.5, 0), r"action of uav1: vz: .*, found -1.5"),
                                ((0, 0, 0, np.nan), "action of uav1: yaw rate: .*, found nan"),
                                ((0, 0, 0), "action of uav1: expected 4 numbers"), (0.5, "action of uav1: expected 4 numbers")):
            with self.assertRaisesRegex(ValueError, message):
                env.step(action)
        env.step(np.zeros(4))  # none of these was flown
        self.assertEqual(round(env.simulator.t_s, 6), 0.2)
        team = TeamEnv(THREE)
        team.reset(seed=1)
        with self.assertRaisesRegex(ValueError, "action of b: vy: .*, found 1.01"):
            team.step({"a": np.zeros(4), "b": (0, 1.01, 0, 0)})

    def test_a_count_of_vehicles_is_a_team(self):
        scenario = dict(THREE, vehicles=[{"count": 3, "agent": {"localization": {"type": "ground_truth"}}}])
        env = TeamEnv(scenario)
        seen, _ = env.reset(seed=1)
        self.assertEqual(set(seen), {"uav1", "uav2", "uav3"})
        env.step({name: np.zeros(4) for name in env.agents})


class PettingZoo(support.InFolder):
    def test_a_team_acts_by_names_and_crashed_vehicles_leave(self):
        env = TeamEnv(THREE, changes={"duration_s": 4})
        seen, infos = env.reset(seed=2)
        self.assertEqual(set(seen), {"a", "b", "c"})
        self.assertEqual(env.possible_agents, ["a", "b", "c"])
        down, stay = np.array([0, 0, -1, 0]), np.zeros(4)
        over = {}
        while env.agents:
            actions = {name: down if name == "b" else stay for name in env.agents}
            seen, rewards, terminations, truncations, infos = env.step(actions)
            self.assertEqual(set(seen), set(actions))
            over.update({n: "crash" for n, t in terminations.items() if t})
            over.update({n: "time" for n, t in truncations.items() if t})
        self.assertEqual(over["a"], "time")
        self.assertEqual(set(over), {"a", "b", "c"})
        self.assertTrue(over["b"] == "crash" or not env.simulator.states.crashed[1])


class Vector(support.InFolder):
    def test_rows_are_those_of_single_environments_and_what_is_over_begins_again(self):
        envs = VectorEnv(VehicleEnv, 3, (ONE,), workers=2)
        self.addCleanup(envs.close)
        seen, infos = envs.reset(seed=20)
        self.assertEqual([i["seed"] for i in infos], [20, 21, 22])
        singles = [VehicleEnv(ONE) for _ in range(3)]
        np.testing.assert_array_equal(seen, [e.reset(seed=20 + i)[0] for i, e in enumerate(singles)])
        actions = np.array([[0.5, 0, 0, 0], [0, 0.5, 0, 0.1], [0, 0, 0.2, 0]])
        for _ in range(10):
            seen, reward, terminated, truncated, infos = envs.step(actions)
            rows = [e.step(a) for e, a in zip(singles, actions)]
            np.testing.assert_array_equal(seen, [r[0] for r in rows])
            np.testing.assert_array_equal(reward, [r[1] for r in rows])
        self.assertTrue(truncated.all())
        seen, reward, terminated, truncated, infos = envs.step(actions)  # begins anew, whatever the action
        self.assertFalse(truncated.any() or terminated.any() or reward.any())
        self.assertTrue(all("seed" in i for i in infos))

    def test_an_error_in_a_worker_is_raised_with_its_traceback(self):
        envs = VectorEnv(failing_env, 2, workers=1)
        self.addCleanup(envs.close)
        envs.reset(seed=1)
        with self.assertRaisesRegex(RuntimeError, "this task fails"):
            envs.step(np.zeros((2, 4)))


class Results(support.InFolder):
    def test_many_runs_are_those_flown_one_by_one(self):
        runs = [{"seed": 1}, {"seed": 2, "duration_s": 0.3}]
        rows = swiftlet.fly_many(ONE, runs, jobs=2)
        for row, run in zip(rows, runs):
            self.assertEqual(row["state_hash"], swiftlet.fly(ONE, run)["state_hash"])
        self.assertEqual([r["seed"] for r in rows], [1, 2])
        with self.assertRaises(swiftlet.InputError):
            swiftlet.fly_many(ONE, [{"sed": 1}])

    def test_a_batch_of_the_program_is_read(self):
        (self.path / "batch.yaml").write_text(
            "name: b\nscenario: team.yaml\nset: {duration_s: 0.1, \"vehicles[eye].sensors\": [], "
            "\"vehicles[eye].agent.detector\": none, \"vehicles[eye].agent.tracker\": none}\nseeds: {first: 1, count: 2}\n")
        result = self.program("batch", "batch.yaml", "--out", "results", "--jobs", "1")
        self.assertEqual(result.returncode, 0, result.stderr)
        batch = swiftlet.read_batch(self.path / "results")
        self.assertEqual([(e["seed"], e["status"]) for e in batch.episodes], [(1, "done"), (2, "done")])
        self.assertIn("flight_time_s.eye", batch.wide[0])
        with self.assertRaises(FileNotFoundError):
            swiftlet.read_batch(self.path / "nowhere")
        try:
            import pandas  # noqa: F401
        except ImportError:
            return
        self.assertEqual(list(batch.wide.to_frame()["seed"]), [1, 2])

    def test_a_dataset_is_read_frame_by_frame(self):
        result = self.program("dataset", support.SOURCE / "tests/dataset/small/small.yaml", "--out", "data", "--jobs", "1", "--set",
                            "recorders=[]", "--set", "splits=[{name: train, flights: 1, first_seed: 100}]")
        self.assertEqual(result.returncode, 0, result.stderr)
        data = swiftlet.datasets.Dataset(self.path / "data", "train")
        self.assertGreater(len(data), 3)
        for frame in data:
            n = len(frame.points_lidar_m)
            self.assertEqual((len(frame.label), len(frame.instance), len(frame.truth), frame.points_lidar_m.shape), (n, n, n, (n, 3)))
            np.testing.assert_allclose(np.linalg.det(frame.T_world_lidar), 1.0, atol=1e-6)
            self.assertGreater(len(frame.boxes), 0)
            self.assertIn("num_points", frame.boxes[0])
            self.assertIsInstance(frame.boxes, swiftlet.results.Rows)
            self.assertEqual(repr(frame), f"Frame {frame.index} of sequence {frame.sequence} at {frame.t_s:.3f} s: {n} returns, {len(frame.boxes)} boxes")
        self.assertEqual(len(swiftlet.datasets.Dataset(self.path / "data", "valid")), 0)


if __name__ == "__main__":
    support.main()
