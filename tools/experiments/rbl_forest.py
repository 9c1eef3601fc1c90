# SPDX-License-Identifier: BSD-3-Clause
"""A Mid-360 through a forest on the map that it builds [Kamler 2025, sec. 3.4]

Another forest for each seed. The published flights use a map given in advance, and another reference tracker.
"""
import math

from shared.statistics import mean_and_deviation

SCENARIO = "reproduce/rbl_forest"
VEHICLE = "uav1"


def fly_forest(experiment, case, changes):
    """Flies one forest for each dict of changes: (rows of flights.csv, share of flights that arrive, their lengths and times)."""
    flights = experiment.fly(SCENARIO, [{"metrics.stop_on_crash": True, **run} for run in changes])
    rows, lengths_m, times_s = [], [], []
    for run, flight in zip(changes, flights):
        done = flight["outcome"] == "done"
        length_m, time_s = flight[f"path_length_m.{VEHICLE}"], flight[f"time_to_done_s.{VEHICLE}"]
        rows.append([case, run["seed"], int(done), length_m, time_s, flight[f"min_clearance_surface_m.{VEHICLE}"]])
        if done:
            lengths_m.append(length_m)
            times_s.append(time_s)
    return rows, len(lengths_m) / len(flights), lengths_m, times_s


def write_flights(experiment, rows):
    experiment.write_csv("flights.csv", ["case", "seed", "success", "length_m", "time_s", "least_clearance_m"],
                         [[math.nan if cell is None else cell for cell in row] for row in rows])


def compare_forest(experiment, changes):
    """The rows of rbl-forest, with some changes of the scenario."""
    runs = [{"seed": seed, **changes} for seed in range(1, experiment.repetitions(100, 1) + 1)]
    rows, success, lengths_m, times_s = fly_forest(experiment, "forest", runs)
    experiment.at_least("success [-]", success, 1.0, 3, "another forest for each seed")
    experiment.at_most("L [m]", mean_and_deviation(lengths_m)[0], 1.1 * experiment.published("L [m]").value, 4)
    time_s, deviation_s, count = mean_and_deviation(times_s)
    experiment.row("t [s]", f"{time_s:.2f}" + (f" ± {deviation_s:.2f}" if count > 1 else ""), note="the printed v of 0.85 m/s does not fit L / t = 0.61 m/s",
                   value=time_s)
    experiment.at_least("least clearance of the whole vehicle [m]", min(row[-1] for row in rows), 0.0, 3)
    write_flights(experiment, rows)


def run(experiment):
    compare_forest(experiment, {})
