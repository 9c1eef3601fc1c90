#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What Python costs, in processor time, and as ratios of what is measured side by side. Usage: measure.py"""
import statistics
import threading
import time
import timeit

import swiftlet

ROUNDS = 5
TEAM = {"name": "ten", "duration_s": 8, "world": {"type": "empty"}, "vehicles": [
    {"name": f"v{i}", "start": {"position_m": [3.0 * i, 0, 5]},
     "agent": {"type": "stack", "localization": {"type": "ground_truth"}, "guidance": {"type": "hover"}}} for i in range(10)]}


def seconds(act):
    start = time.thread_time()
    act()
    return time.thread_time() - start


def ready(source, **keys):
    return swiftlet.Simulator(swiftlet.load(source, **keys), threads=1)


def watched(simulator):
    while not simulator.finished:
        simulator.tick()
        simulator.states.position_m


def share(source, **keys):
    ratios, alone = [], []
    for _ in range(ROUNDS):
        a, b = ready(source, **keys), ready(source, **keys)
        alone.append(seconds(a.run))
        ratios.append(alone[-1] / seconds(lambda: watched(b)))
        steps = a.t_s / 0.004 * len(a.vehicle_names)
    return statistics.median(ratios), steps / statistics.median(alone)


def calls():
    simulator = ready("square")
    simulator.tick(5)
    vehicle = simulator.vehicle(0)
    names = dict(simulator=simulator, vehicle=vehicle)
    for call in ("simulator.states.position_m", "simulator.t_s", "simulator.vehicle(0)", "vehicle.estimate.local_pose",
                 "vehicle.tracks.position_m", "simulator.commands"):
        count = 20000
        call_us = seconds(lambda: timeit.timeit(call, number=count, globals=names)) / count * 1e6
        print(f"{call:32s} {call_us:6.2f} us")


def two_threads():
    """How much faster two simulators fly in two threads than one after the other, of wall time; needs two idle processors."""
    ratios = []
    for _ in range(ROUNDS):
        one, two, a, b = (ready(TEAM) for _ in range(4))
        start = time.perf_counter()
        one.run()
        two.run()
        middle = time.perf_counter()
        threads = [threading.Thread(target=s.run) for s in (a, b)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        ratios.append((middle - start) / (time.perf_counter() - middle))
    return max(ratios)


def environment():
    from swiftlet.learning import VehicleEnv
    import numpy as np
    env = VehicleEnv("square", decision_s=0.1)
    env.reset(seed=1)
    steps = 150
    action = np.zeros(4)

    def act():
        for _ in range(steps):
            env.step(action)
    return steps * 25 / seconds(act)


if __name__ == "__main__":
    calls()
    for name, source in (("square, 1 vehicle", "square"), ("10 vehicles", TEAM)):
        ratio, steps_per_s = share(source)
        print(f"{name}: watched {ratio:.0%} of the speed of C++, {steps_per_s:,.0f} vehicle-steps a processor second")
    ratio, _ = share("field", duration_s=2)
    print(f"field, with LiDAR: watched {ratio:.0%} of the speed of C++")
    print(f"environment: {environment():,.0f} vehicle-steps a processor second")
    print(f"two simulators in two threads: {two_threads():.2f} times one after the other")
