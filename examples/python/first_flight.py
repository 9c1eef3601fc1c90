# SPDX-License-Identifier: BSD-3-Clause
"""First flight: a scenario, a run tick by tick, its states and scans as arrays.

    python3 examples/python/first_flight.py
"""
import numpy as np

import swiftlet

# A scenario by name, with changes as by `--set`. Misspelt keys are rejected with their location.
scenario = swiftlet.load("field", duration_s=2.0, seed=5)
try:
    swiftlet.load("field", {"vehicles[0].start.yaw_dgr": 90})
except swiftlet.InputError as error:
    print(f"refused: {error}")

simulator = swiftlet.Simulator(scenario)
start_m = simulator.states.position_m.copy()  # `states` is a view of the current tick, so copy it
num_scans = 0
while not simulator.finished:
    simulator.tick()
    for scan in simulator.vehicle(0).scans:
        num_scans += 1
        returns = scan.range_m > 0
        if num_scans % 5 == 1:
            noise_m = np.abs(scan.range_m - scan.true_range_m)[returns]
            print(f"{simulator.t_s:.2f} s: {scan}, {returns.sum()} returns, noise {np.median(noise_m) * 1000:.0f} mm")

flown_m = np.linalg.norm(simulator.states.position_m - start_m, axis=1)
print("flown [m]:", dict(zip(simulator.vehicle_names, flown_m.round(2))))
print("outcome:", simulator.summary()["outcome"], "hash:", simulator.state_hash)
assert num_scans > 10 and not simulator.states.crashed.any()
