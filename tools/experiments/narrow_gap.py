# SPDX-License-Identifier: BSD-3-Clause
"""A door of a warehouse, from 1.2 m down to 0.9 m [Pritzl 2024, Table III]

Ten flights a width out of a warehouse and back, with the published safe distances; the seed draws the starts. A pass is attempted
if it is the first, or the one before it succeeds. The pass that fails at 0.9 m is not flown, because the planner finds no path: in
a map of 0.1 m a door of 0.9 m is only wide enough when the grid lies well.
"""
import math

from shared.guidance import fly_guided
from swiftlet.functions import Random

DOORS_M = {1.2: (0.5, 1.0), 1.1: (0.45, 1.0), 1.0: (0.4, 1.0), 0.9: (0.4, 0.8)}  # width: safe distance, least share of passes
PASSAGE = [20.1, 0.0, 0.0]  # x [m], y [m], yaw [rad] of the door: in the middle of the wall of the scenario
STARTS_M = ((15.6, -2.5, 1.5), (17.4, 0.0, 1.5))  # starts of guide and guided vehicle, world frame
SPREAD_M = 0.3  # largest shift of a start along x and y, to both sides
PASSES = 2  # passes through the door in a flight


def flight_through(width_m, safe_distance_m, seed):
    random = Random(seed, "narrow-gap")
    starts_m = [[x + SPREAD_M * (2 * random.uniform(i, 0) - 1), y + SPREAD_M * (2 * random.uniform(i, 1) - 1), z]
                for i, (x, y, z) in enumerate(STARTS_M)]
    return {"source": "reproduce/narrow_gap", "passage": PASSAGE, "changes": {
        "seed": seed, "world.door_width_m": width_m, "vehicles[0].start.position_m": starts_m[0],
        "vehicles[1].start.position_m": starts_m[1], "vehicles[1].start.yaw_deg": 360.0 * random.uniform(2, 0),
        "vehicles[0].agent.guidance.planner.secondary.clearance_m": safe_distance_m}}


def draw(published_percent, ours_percent):
    from matplotlib.figure import Figure
    figure = Figure(figsize=(7, 4))
    axes = figure.add_subplot(title="Passes of the door (Table III)", xlabel="width of the door", ylabel="passes that succeed [%]")
    places = range(len(DOORS_M))
    axes.bar([place - 0.2 for place in places], published_percent, 0.4, label="published")
    axes.bar([place + 0.2 for place in places], ours_percent, 0.4, label="ours")
    axes.set_xticks(places, [f"{width_m:.1f} m" for width_m in DOORS_M])
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=2)  # below the axes
    return figure


def run(experiment):
    seeds = range(1, experiment.repetitions(10, 1) + 1)
    flights = iter(experiment.map(fly_guided, [flight_through(width_m, safe_distance_m, seed)
                                               for width_m, (safe_distance_m, _) in DOORS_M.items() for seed in seeds]))
    rows, published_percent, ours_percent = [], [], []
    for width_m, (_, least_share) in DOORS_M.items():
        of_door = [next(flights) for _ in seeds]
        passes = sum(min(flight["passes"], PASSES) for flight in of_door)
        attempts = passes + sum(flight["passes"] < PASSES for flight in of_door)
        contacts, num_errors = sum(flight["crashed"] for flight in of_door), sum(flight["num_errors"] for flight in of_door)
        error_m = sum(flight["error_sum_m"] for flight in of_door) / max(num_errors, 1)
        least_m = min(flight["least_clearance_m"] for flight in of_door)
        what = f"{width_m:.1f} m: passes that succeed [%]"
        experiment.at_least(what, 100.0 * passes / attempts, 100.0 * least_share, 3,
                            f"{passes} of {attempts}, {contacts} contacts, least clearance {least_m:.2f} m, error at the door "
                            f"{error_m:.3f} m")
        published_percent.append(experiment.published(what).value)
        ours_percent.append(100.0 * passes / attempts)
        rows += [[width_m, seed, flight["passes"], int(flight["crashed"]), flight["time_s"], flight["least_clearance_m"],
                  flight["error_sum_m"] / flight["num_errors"] if flight["num_errors"] else math.nan]
                 for seed, flight in zip(seeds, of_door)]
    experiment.write_csv("flights.csv", ["width_m", "seed", "passes", "contact", "time_s", "least_clearance_m",
                                         "error_near_door_m"], rows)
    experiment.write_figure("narrow-gap.svg", draw(published_percent, ours_percent))
