# SPDX-License-Identifier: BSD-3-Clause
"""The two real flights in a forest [Kamler 2025, Table 3.2]

Flown at the published mean speed. Neither the forest nor the parameters were published. The two columns of the table are printed equal,
although the text mentions scaled cells and weighting.
"""
import numpy as np
from rbl_forest import fly_forest, write_flights
from shared.statistics import mean_and_deviation

START_M, GOAL_M = np.array([-22.0, -33.0, 2.0]), np.array([22.0, 33.0, 5.0])  # start and goal of the scenario, world frame
FLIGHTS = {"conservative": (45.0, 0.55), "aggressive": (32.0, 0.8)}  # distance of the goal [m], speed [m/s]


def run(experiment):
    seeds = range(1, experiment.repetitions(10, 1) + 1)
    rows = []
    for name, (distance_m, speed_mps) in FLIGHTS.items():
        goal_m = START_M + distance_m / np.linalg.norm(GOAL_M - START_M) * (GOAL_M - START_M)
        guidance = "vehicles[0].agent.guidance."
        flown, success, lengths_m, times_s = fly_forest(experiment, name, [
            {"seed": seed, guidance + "goal_m": goal_m.tolist(), guidance + "speed_mps": speed_mps,
             "world.keep_clear.clearings[0].center_m": goal_m[:2].tolist()} for seed in seeds])  # no goal lies in a crown
        rows += flown
        experiment.at_least(f"{name}: success [-]", success, 1.0, 3)
        length_m, time_s = mean_and_deviation(lengths_m)[0], mean_and_deviation(times_s)[0]
        experiment.row(f"{name}: L [m]", f"{length_m:.2f}", note="neither the forest nor the parameters were published", value=length_m)
        experiment.row(f"{name}: t [s]", f"{time_s:.2f}", note="at the published mean speed", value=time_s)
    write_flights(experiment, rows)
