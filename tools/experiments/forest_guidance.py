# SPDX-License-Identifier: BSD-3-Clause
"""A UAV guides a small one through 20 forests [Pritzl 2024, Table II]

The seed draws the forest. The guide localizes by LiDAR odometry that drifts. The borders of the allowed space are the five
published distances, in turn.
"""
from shared.guidance import fly_guided

BORDERS_M = (31.6, 36.5, 35.1, 41.6, 35.0)  # distances of the five flights of Table II
QUICK_BORDER_M = 12.0
CHANGES = {
    "duration_s": 300,
    "vehicles[0].sensors": [{"type": "lidar", "name": "os0", "model": "os0_128_sheet", "mount": {"position_m": [0, 0, 0.15]}},
                            {"type": "odometry", "name": "lio", "model": "odometry_lio"},
                            {"type": "imu", "name": "imu", "model": "imu_adis16448"}],
    "vehicles[0].agent.localization": {"type": "odometry"},
}


def draw(flights, borders_m):
    from matplotlib.figure import Figure
    figure = Figure(figsize=(7, 4))
    axes = figure.add_subplot(title="Distance flown in each forest", xlabel="forest", ylabel="distance [m]")
    forests = range(1, len(flights) + 1)
    axes.plot(forests, [flight["farthest_m"] for flight in flights], "o", label="flown")
    axes.plot(forests, borders_m, "_", markersize=12, label="border")
    axes.set_ylim(0, 1.1 * max(flight["farthest_m"] for flight in flights))
    axes.set_xticks(forests)
    axes.legend(loc="lower left")
    return figure


def run(experiment):
    seeds = range(1, experiment.repetitions(20, 1) + 1)
    borders_m = [QUICK_BORDER_M if experiment.quick else BORDERS_M[(seed - 1) % len(BORDERS_M)] for seed in seeds]
    flights = experiment.map(fly_guided, [
        {"source": "forest_guidance",
         "changes": {**CHANGES, "seed": seed, "vehicles[0].agent.guidance.advance.distance_m": border_m}}
        for seed, border_m in zip(seeds, borders_m)])
    count = len(flights)
    done, contacts = sum(flight["done"] for flight in flights), sum(flight["crashed"] for flight in flights)
    flown_m, time_s = (sum(flight[key] for flight in flights) / count for key in ("farthest_m", "time_s"))
    experiment.at_least("flights that reach the border [%]", 100.0 * done / count, 100.0, 3,
                        f"{done} of {count}, each in another forest")
    experiment.at_most("contacts", contacts, 0, 1,
                       f"least clearance {min(flight['least_clearance_m'] for flight in flights):.2f} m")
    experiment.row("distance of a flight [m]", f"{flown_m:.1f}", value=flown_m,
                   note=f"mean, in {time_s:.0f} s; the borders are the published distances")
    experiment.write_csv("flights.csv", ["seed", "done", "contact", "border_m", "flown_m", "time_s", "least_clearance_m"],
                         [[seed, int(flight["done"]), int(flight["crashed"]), border_m, flight["farthest_m"], flight["time_s"],
                           flight["least_clearance_m"]] for seed, border_m, flight in zip(seeds, borders_m, flights)])
    experiment.write_figure("forest-guidance.svg", draw(flights, borders_m))
