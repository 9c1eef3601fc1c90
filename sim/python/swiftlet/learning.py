# SPDX-License-Identifier: BSD-3-Clause
"""Environments for learning: one vehicle as Gymnasium has it, a team as PettingZoo's parallel interface, many in worker processes.

Gymnasium and PettingZoo need not be installed: the classes have their methods, and spaces of their own where `gymnasium` is not
there. An action is a velocity in the world and a rate of the heading, each from -1 to 1 of its greatest value; one outside of the
action space is a ValueError. Between two actions whole ticks pass. Episodes are runs of a scenario: the seed of `reset` is the run's, and the same seed and actions give the same bits.
"""
import multiprocessing as _multiprocessing
import operator as _operator
import traceback as _traceback

import numpy as np

from . import Simulator, load

try:
    from gymnasium import Env as _Env
    from gymnasium.spaces import Box
except ImportError:
    _Env = object

    class Box:
        """A box of numbers: the part of gymnasium.spaces.Box that learners use."""

        def __init__(self, low, high, shape=None, dtype=np.float32, seed=None):
            shape = np.shape(low) if shape is None else tuple(shape)
            self.low, self.high = (np.broadcast_to(np.asarray(x, dtype), shape).copy() for x in (low, high))
            self.shape, self.dtype = shape, np.dtype(dtype)
            self._random = np.random.default_rng(seed)

        def seed(self, seed=None):
            self._random = np.random.default_rng(seed)

        def sample(self):
            low, high = (np.clip(x, -1e6, 1e6) for x in (self.low, self.high))
            return self._random.uniform(low, high).astype(self.dtype)

        def contains(self, x):
            x = np.asarray(x)
            return x.shape == self.shape and bool(np.all(x >= self.low) and np.all(x <= self.high))

        def __repr__(self):
            return f"Box({self.low.min()}, {self.high.max()}, {self.shape}, {self.dtype})"

try:
    from pettingzoo import ParallelEnv as _ParallelEnv
except ImportError:
    _ParallelEnv = object

__all__ = ["Box", "Reach", "TeamEnv", "VectorEnv", "VehicleEnv"]


class Reach:
    """A task: every vehicle flies to a goal of its own, which is drawn around its start.

    An observation is, in meters and m/s, world axes: the displacement to the goal (3), the velocity (3), and that to the nearest other
    vehicle (3, zero when there is none), all divided by `scale_m`. The reward is the progress in meters; arriving gives 10, a crash
    costs 10 and both end the episode of that vehicle. Other tasks have the same five methods.
    """

    def __init__(self, distance_m=8.0, arrived_m=0.5, scale_m=10.0):
        self.distance_m, self.arrived_m, self.scale_m = distance_m, arrived_m, scale_m

    def observation_space(self):
        return Box(-np.inf, np.inf, (9,), np.float32)

    def reset(self, simulator, random):
        start = simulator.states.position_m
        way = random.normal(size=start.shape) * (1.0, 1.0, 0.2)
        self.goals = start + self.distance_m * way / np.linalg.norm(way, axis=1, keepdims=True)
        self.goals[:, 2] = np.maximum(self.goals[:, 2], 1.5)
        self.left_m = np.linalg.norm(self.goals - start, axis=1)

    def observe(self, simulator):
        p, v = simulator.states.position_m, simulator.states.v_mps
        nearest = np.zeros_like(p)
        if len(p) > 1:
            apart = p[None] - p[:, None]
            far = np.einsum("ijk,ijk->ij", apart, apart)
            np.fill_diagonal(far, np.inf)
            nearest = apart[np.arange(len(p)), far.argmin(axis=1)]
        return (np.concatenate([self.goals - p, v, nearest], axis=1) / self.scale_m).astype(np.float32)

    def evaluate(self, simulator):
        """(reward, is the episode over) of every vehicle."""
        left = np.linalg.norm(self.goals - simulator.states.position_m, axis=1)
        arrived, crashed = left < self.arrived_m, simulator.states.crashed
        reward = self.left_m - left + 10.0 * arrived - 10.0 * crashed
        self.left_m = left
        return reward, arrived | crashed

    def info(self, simulator, vehicle):
        return {"left_m": float(self.left_m[vehicle]), "crashed": bool(simulator.states.crashed[vehicle])}


class _Episodes:
    """Runs of a scenario, one after another; common to both interfaces."""

    def __init__(self, scenario, task, decision_s, speed_max_mps, yaw_rate_max_radps, threads, changes):
        self.scenario = load(scenario, changes)
        fast = {}
        for i in range(len(self.scenario.vehicle_names)):
            fast[f"vehicles[{i}].agent.guidance"] = {"type": "commanded"}
        self.scenario = load(self.scenario, fast)
        self.task = task or Reach()
        self.ticks = max(1, round(decision_s / self.scenario.tick_s))
        self.scale = np.array([speed_max_mps] * 3 + [yaw_rate_max_radps])
        self.threads = threads
        self.simulator = self._world = self._world_key = None
        self.seed = None

    def reset(self, seed):
        # A randomly drawn seed is reported as well, so that the episode can be repeated.
        self.seed = int(np.random.SeedSequence().entropy % 2**31) if seed is None else _operator.index(seed)
        scenario = load(self.scenario, seed=self.seed)
        key = _line(scenario.yaml, "world_seed") if _line(scenario.yaml, "world_seed") not in ("", "0") else None
        world = self._world if key is not None and key == self._world_key else None
        self.simulator = Simulator(scenario, threads=self.threads, world=world)
        self._world, self._world_key = self.simulator.world, key
        self.task.reset(self.simulator, np.random.default_rng(self.seed))

    def checked(self, vehicle, action):
        """The action of a vehicle, by number. Raises ValueError where it lies outside of the action space."""
        action, name = np.asarray(action, float), self.scenario.vehicle_names[vehicle]
        if action.shape != (4,):
            raise ValueError(f"action of {name}: expected 4 numbers, found an array of shape {action.shape}")
        for component, value in zip(("vx", "vy", "vz", "yaw rate"), action):
            if not -1.0 <= value <= 1.0:
                raise ValueError(f"action of {name}: {component}: expected a number in [-1, 1], found {value:g}")
        return action

    def step(self, actions):
        if self.simulator is None:
            raise RuntimeError("expected a reset before the first step")
        self.simulator.commands[:, :4] = actions * self.scale
        self.simulator.tick(self.ticks)


def _line(yaml, key):
    return next((line.split(":", 1)[1].strip() for line in yaml.splitlines() if line.startswith(key + ":")), "")


class VehicleEnv(_Env):
    """One vehicle, as gymnasium.Env. Other vehicles of the scenario stand still.

    scenario: of `load`; its guidance is replaced. task: such as Reach(). decision_s: [s] between two actions. An action is float32
    (4,): vx, vy, vz by speed_max_mps and the rate of the heading by yaw_rate_max_radps, from -1 to 1; others are a ValueError.
    """

    metadata = {"render_modes": []}
    render_mode = None

    def __init__(self, scenario="square", task=None, *, decision_s=0.1, speed_max_mps=4.0, yaw_rate_max_radps=1.0, threads=1,
                 changes=None):
        self._runs = _Episodes(scenario, task, decision_s, speed_max_mps, yaw_rate_max_radps, threads, changes)
        self._actions = np.zeros((len(self._runs.scenario.vehicle_names), 4))
        self.action_space = Box(-1.0, 1.0, (4,), np.float32)
        self.observation_space = self._runs.task.observation_space()

    @property
    def simulator(self):
        return self._runs.simulator

    def reset(self, *, seed=None, options=None):
        self._runs.reset(seed)
        return self._runs.task.observe(self.simulator)[0], {"seed": self._runs.seed}

    def step(self, action):
        self._actions[0] = self._runs.checked(0, action)
        self._runs.step(self._actions)
        task = self._runs.task
        reward, over = task.evaluate(self.simulator)
        return (task.observe(self.simulator)[0], float(reward[0]), bool(over[0]), self.simulator.finished and not over[0],
                task.info(self.simulator, 0))

    def render(self):
        return None

    def close(self):
        self._runs.simulator = None


class TeamEnv(_ParallelEnv):
    """All vehicles of a scenario, as pettingzoo.ParallelEnv: dicts by the vehicles' names. A vehicle that is done leaves `agents` and hovers."""

    metadata = {"render_modes": [], "name": "swiftlet_team"}
    render_mode = None

    def __init__(self, scenario, task=None, *, decision_s=0.1, speed_max_mps=4.0, yaw_rate_max_radps=1.0, threads=1, changes=None):
        self._runs = _Episodes(scenario, task, decision_s, speed_max_mps, yaw_rate_max_radps, threads, changes)
        self.possible_agents = list(self._runs.scenario.vehicle_names)
        self.agents = []
        self._number = {name: i for i, name in enumerate(self.possible_agents)}
        self.action_spaces = {name: Box(-1.0, 1.0, (4,), np.float32) for name in self.possible_agents}
        self.observation_spaces = {name: self._runs.task.observation_space() for name in self.possible_agents}

    @property
    def simulator(self):
        return self._runs.simulator

    def observation_space(self, agent):
        return self.observation_spaces[agent]

    def action_space(self, agent):
        return self.action_spaces[agent]

    def reset(self, seed=None, options=None):
        self._runs.reset(seed)
        self.agents = list(self.possible_agents)
        rows = self._runs.task.observe(self.simulator)
        return {a: rows[self._number[a]] for a in self.agents}, {a: {"seed": self._runs.seed} for a in self.agents}

    def step(self, actions):
        rows = np.zeros((len(self.possible_agents), 4))
        for name, action in actions.items():
            rows[self._number[name]] = self._runs.checked(self._number[name], action)
        self._runs.step(rows)
        task, finished = self._runs.task, self.simulator.finished
        reward, over = task.evaluate(self.simulator)
        seen = task.observe(self.simulator)
        numbers = {a: self._number[a] for a in self.agents}
        result = ({a: seen[i] for a, i in numbers.items()}, {a: float(reward[i]) for a, i in numbers.items()},
                  {a: bool(over[i]) for a, i in numbers.items()}, {a: bool(finished and not over[i]) for a, i in numbers.items()},
                  {a: task.info(self.simulator, i) for a, i in numbers.items()})
        self.agents = [] if finished else [a for a, i in numbers.items() if not over[i]]
        return result

    def render(self):
        return None

    def close(self):
        self._runs.simulator = None


def _work(pipe, make, arguments, count):
    """A worker process: some environments, stepped in their order."""
    try:
        envs = [make(*arguments) for _ in range(count)]
        over = [False] * count
        while True:
            what, values = pipe.recv()
            if what == "close":
                return
            rows = []
            for i, env in enumerate(envs):
                if what == "reset" or over[i]:
                    seen, info = env.reset(seed=values[i] if what == "reset" else None)
                    rows.append((seen, 0.0, False, False, info))
                else:
                    rows.append(env.step(values[i]))
                over[i] = rows[-1][2] or rows[-1][3]
            pipe.send(("rows", rows))
    except (EOFError, KeyboardInterrupt):
        return
    except BaseException:  # noqa: B902: reported to the waiting parent process, whatever it is
        pipe.send(("error", _traceback.format_exc()))


class VectorEnv:
    """Many environments in worker processes, as gymnasium.vector.VectorEnv.

    make(*arguments) makes one and can be pickled, such as VehicleEnv and its scenario. An environment whose episode is over is reset by the next step, whose
    action is ignored (`metadata["autoreset_mode"]` is NEXT_STEP). Seeds of reset are seed, seed + 1, ... by environment.
    """

    metadata = {"autoreset_mode": "NextStep"}

    def __init__(self, make, num_envs, arguments=(), workers=None):
        self.num_envs = num_envs
        workers = max(1, min(workers or _multiprocessing.cpu_count(), num_envs))
        context = _multiprocessing.get_context("spawn")  # a fork of a process with threads may hang
        shares = [num_envs // workers + (i < num_envs % workers) for i in range(workers)]
        self._workers = []
        for share in shares:
            ours, theirs = context.Pipe()
            process = context.Process(target=_work, args=(theirs, make, arguments, share), daemon=True)
            process.start()
            theirs.close()
            self._workers.append((process, ours, share))
        one = make(*arguments)
        self.single_action_space, self.single_observation_space = one.action_space, one.observation_space
        one.close()

    def _request(self, what, values):
        first = 0
        for _, pipe, share in self._workers:
            pipe.send((what, values[first:first + share]))
            first += share
        rows = []
        for _, pipe, _ in self._workers:
            try:
                kind, reply = pipe.recv()
            except EOFError:
                kind, reply = "error", "a worker process ended"
            if kind == "error":
                self.close()
                raise RuntimeError(f"in a worker process:\n{reply}")
            rows += reply
        seen, rewards, terminated, truncated, infos = zip(*rows)
        return np.stack(seen), np.array(rewards), np.array(terminated), np.array(truncated), list(infos)

    def reset(self, *, seed=None, options=None):
        seeds = [None if seed is None else seed + i for i in range(self.num_envs)]
        seen, _, _, _, infos = self._request("reset", seeds)
        return seen, infos

    def step(self, actions):
        return self._request("step", np.asarray(actions))

    def close(self):
        for process, pipe, _ in self._workers:
            try:
                pipe.send(("close", None))
            except (BrokenPipeError, OSError):
                pass
            pipe.close()
            process.join(timeout=10)
            if process.is_alive():
                process.terminate()
        self._workers = []
