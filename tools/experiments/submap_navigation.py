# SPDX-License-Identifier: BSD-3-Clause
"""Through the map of its submaps, on SLAM alone [Orsulic 2021, Fig. 6]

Twice around a building by RRT through the map of the vehicle's own submaps, with a LiDAR range of 15 m, so that local SLAM drifts.
When a loop is closed, submaps move, and the map moves with them.
"""
import numpy as np
from shared.tables import short_number
from shared.slam import describe, moved_by, record

SCENARIO = "submap_navigation"
SLICE_M = 2.1  # height of the drawn cells
SHOWN_M = 25.0  # largest |x| and |y| of the drawn cells


def fly_through_submaps(source, changes):
    """One flight, and occupied_m: the occupied cells of the final map at SLICE_M, (n, 2) in the vehicle's estimate of the world."""
    simulator, log = record(source, changes)
    cells = simulator.vehicle(0).maps()["mapping"]
    centers_m = cells["centers_local_m"][cells["state"] >= cells["states"].index("occupied")].astype(float)
    centers_m = moved_by(np.broadcast_to(log.T_world_local[-1], (len(centers_m), 4, 4)), centers_m)
    drawn = (abs(centers_m[:, 2] - SLICE_M) <= 0.5 * cells["edge_m"]) & (abs(centers_m[:, :2]).max(axis=1, initial=0) <= SHOWN_M)
    return {**describe(simulator, log), "occupied_m": centers_m[drawn, :2].round(2).tolist()}


def draw(experiment, flight):
    from matplotlib.figure import Figure
    figure = Figure(figsize=(7, 6))
    axes = figure.subplots()
    axes.plot(*np.array(flight["occupied_m"]).T, "s", color="0.5", markersize=1, label="occupied")
    for name, style, label in (("p_shown_m", "-", "as the vehicle knows it"), ("p_true_m", "--", "true")):
        axes.plot(*np.array(flight["course"][name])[:, :2].T, style, label=label)
    axes.set(title=f"Cells of the map at {SLICE_M} m, and the path that was flown (Fig. 6)", xlabel="x [m]", ylabel="y [m]",
             aspect="equal")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=3)  # below the axes
    experiment.write_figure("submap-navigation.svg", figure)


def run(experiment):
    seeds = range(1, experiment.repetitions(20, 1) + 1)
    flights = experiment.map(fly_through_submaps, [{"source": SCENARIO, "changes": {"seed": seed}} for seed in seeds])
    done = sum(flight["outcome"] == "done" for flight in flights)
    least_m = min(flight["min_clearance_surface_m.uav1"] for flight in flights)
    experiment.claim("a path is planned in the map of submaps, and flown", f"{done} of {len(flights)} flights",
                     done == len(flights), f"twice around the building; least clearance {least_m:.2f} m")
    experiment.at_most("contacts", sum(flight["outcome"] == "crashed" for flight in flights), 0, 1)
    after_m = float(np.median([flight["rms_after_m"] for flight in flights]))
    local_m = float(np.median([flight["rms_local_after_m"] for flight in flights]))
    experiment.row("error of the position after the first closure [m]", short_number(after_m, 2), value=after_m,
                   note=f"median of root mean squares; by local SLAM alone {local_m:.2f} m; corrections of up to "
                   f"{max(flight['largest_m'] for flight in flights):.2f} m")
    columns = ["outcome", "simulated_s", "path_length_m.uav1", "min_clearance_surface_m.uav1", "rms_local_after_m", "rms_after_m",
               "largest_m"]
    experiment.write_csv("flights.csv", ["seed", *columns],
                         [[seed, *(flight[column] for column in columns)] for seed, flight in zip(seeds, flights)])
    draw(experiment, flights[0])
