# SPDX-License-Identifier: BSD-3-Clause
"""A learning environment: a vehicle learns to fly to a goal, by a search over a linear policy, in worker processes.

    python3 examples/python/learn.py [ROUNDS]
"""
import sys

import numpy as np

from swiftlet.learning import VectorEnv, VehicleEnv

SCENARIO = {"name": "reach", "duration_s": 6.0, "world": {"type": "empty"},
            "vehicles": [{"name": "uav", "start": {"position_m": [0, 0, 5]},
                          "agent": {"localization": {"type": "ground_truth"}}}]}


def act(policies, seen):
    """Velocity from the displacement to the goal and the own velocity; one policy per environment, (3,): two gains and a yaw rate."""
    move = policies[:, 0:1] * seen[:, 0:3] + policies[:, 1:2] * seen[:, 3:6]
    return np.clip(np.concatenate([move, policies[:, 2:3]], axis=1), -1.0, 1.0)  # the action space


def returns(envs, policies, seed):
    seen, _ = envs.reset(seed=seed)
    total, alive = np.zeros(envs.num_envs), np.ones(envs.num_envs, bool)
    for _ in range(60):
        seen, reward, terminated, truncated, _ = envs.step(act(policies, seen))
        total += reward * alive
        alive &= ~(terminated | truncated)
    return total


if __name__ == "__main__":  # the workers import this file
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 4
    random = np.random.default_rng(1)
    envs = VectorEnv(VehicleEnv, 16, (SCENARIO,))
    mean, spread = np.zeros(3), np.array([4.0, 4.0, 0.2])
    before = returns(envs, np.zeros((16, 3)), seed=1000).mean()
    for number in range(rounds):
        policies = mean + spread * random.normal(size=(16, 3))
        scores = returns(envs, policies, seed=100 * number)
        best = policies[np.argsort(scores)[-4:]]
        mean, spread = best.mean(axis=0), 0.7 * spread
        print(f"round {number + 1}: best {scores.max():.1f}, policy {mean.round(2)}")
    after = returns(envs, np.tile(mean, (16, 1)), seed=1000).mean()
    envs.close()
    print(f"mean return {before:.1f} before, {after:.1f} after")
    assert after > before + 2.0
