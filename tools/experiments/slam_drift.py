# SPDX-License-Identifier: BSD-3-Clause
"""SLAM in five worlds with three LiDARs, calm and agile (beyond Orsulic 2021)

Closed paths, free of obstacles for every seed, 300 m each, flown at 2 m/s (calm) and at 4 to 6 m/s (agile). Drift: relative error
of local SLAM over 50 m of path, median of a flight. Error after closures: root mean square error of the position from the first
correction on. There is no published figure.
"""
import numpy as np
from shared.slam import describe, drift_percent, record

# World: name of the vehicle (its noise depends on it), start position [m] and heading [deg], waypoints [m], length of a round [m],
# agile speed [m/s], further changes.
WORLDS = {
    "campus": ("uav1", [-12.5, -10, 3], 0, [[12.5, -10, 3], [12.5, 10, 4], [-12.5, 10, 4], [-12.5, -10, 3]], 90, 6, {}),
    "forest": ("uav1", [-27, -12, 4], 15, [[-12, -8, 4], [0, 0, 4], [10, 12, 4], [27, 15, 4], [10, 12, 4], [0, 0, 4], [-12, -8, 4],
                                           [-27, -12, 4]], 126, 4, {}),
    "warehouse": ("uav1", [-17.3, -5.68, 3.6], 0, [[17.3, -5.68, 3.6], [17.3, 0, 3.6], [-17.3, 0, 3.6], [-17.3, -5.68, 3.6]],
                  80.5, 5, {}),
    "hall": ("observer", [-5, -3, 2], 0, [[5, -3, 2.5], [5, 3, 2], [-5, 3, 2.5], [-5, -3, 2]], 32, 4,
             {"vehicles[0].agent.guidance.yaw": "fixed"}),
    "field": ("observer", [-12, -12, 4], 0, [[12, -12, 4], [12, 12, 4.5], [-12, 12, 4], [-12, -12, 4]], 96, 6,
              {"world.num_trees": 60}),
}
QUICK_WORLDS = ("campus", "warehouse", "hall")  # without leaves, which cost time
LIDARS = {"puck_lite_sheet": ("Puck LITE", 0.6), "os1_128_sheet": ("OS1-128", 0.3), "mid360_sheet": ("Mid-360", 0.3)}  # name, limit of the drift [%]
ERROR_MAX_M = 0.08  # limit of the median error after closures
CALM_MPS = 2.0
PATH_M, DRIFT_M = 300.0, 50.0  # length of a flight and of the sections that drift is measured over


def changes_of(world, lidar, agile, seed, quick):
    name, start_m, yaw_deg, waypoints_m, round_m, agile_mps, more = WORLDS[world]
    path_m = max(round_m + 45.0, 100.0) if quick else PATH_M  # a closure needs a round and two submaps
    speed_mps = agile_mps if agile else CALM_MPS
    duration_s = round(path_m / ((0.65 if agile else 0.93) * speed_mps), 1)  # corners are slower, and more so for an agile vehicle
    return {"seed": seed, "duration_s": duration_s, "snapshots": [], "vehicles": [{
        "name": name, "model": "x500", "start": {"position_m": start_m, "yaw_deg": yaw_deg},
        "sensors": [{"type": "lidar", "model": lidar, "mount": {"position_m": [0, 0, 0.15]}},
                    {"type": "imu", "model": "imu_adis16448"}],
        "agent": {"localization": {"type": "slam", "global": {"enabled": True}},
                  "control": {"limits": {"set": "agile" if agile else "medium"}},
                  "guidance": {"type": "waypoints", "speed_mps": speed_mps, "loop": True, "waypoints_m": waypoints_m}}}], **more}


def fly_round(source, changes):
    """One flight, its path_m, its drift_percent (NaN: too short), and lost_s: time without a valid estimate."""
    simulator, log = record(source, changes)
    return {**describe(simulator, log), "path_m": float(np.linalg.norm(np.diff(log.p_true_m, axis=0), axis=1).sum()),
            "drift_percent": drift_percent(log, DRIFT_M), "lost_s": float(np.sum(log.valid == 0) * (log.t_s[1] - log.t_s[0]))}


def median_of(flights, key):
    return float(np.nanmedian([flight[key] for flight in flights]))


def by_world(flights, key):
    """"campus 0.021, forest 0.034": medians."""
    worlds = dict.fromkeys(flight["world"] for flight in flights)
    return ", ".join(f"{world} {median_of([f for f in flights if f['world'] == world], key):.2g}" for world in worlds)


def draw(experiment, flights):
    from matplotlib.figure import Figure
    figure = Figure(figsize=(7, 6))
    panels = figure.subplots(2, sharex=True)
    worlds = list(dict.fromkeys(flight["world"] for flight in flights))
    for axes, key, label in zip(panels, ("drift_percent", "rms_after_m"), ("drift of local SLAM [%]", "error after closures [m]")):
        for i, (lidar, (name, _)) in enumerate(LIDARS.items()):
            for agile, marker in ((False, "o"), (True, "^")):
                its = [flight for flight in flights if (flight["lidar"], flight["agile"]) == (lidar, agile)]
                x = [worlds.index(flight["world"]) + 0.2 * (i - 1) + 0.08 * agile for flight in its]  # side by side within a world
                axes.plot(x, [flight[key] for flight in its], marker, color=f"C{i}", markersize=4,
                          label=f"{name}, {'agile' if agile else 'calm'}")
        axes.set(ylabel=label, yscale="log", xticks=range(len(worlds)), xticklabels=worlds)
    panels[0].set(title=f"SLAM without anything else, drift over {DRIFT_M:.0f} m")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="upper center", bbox_to_anchor=(0.5, 0.06), ncols=3)
    experiment.write_figure("slam-drift.svg", figure)


def run(experiment):
    seeds, worlds = range(1, experiment.repetitions(1, 1) + 1), QUICK_WORLDS if experiment.quick else WORLDS
    cases = [{"world": world, "lidar": lidar, "agile": agile, "seed": seed}
             for world in worlds for lidar in LIDARS for agile in (False, True) for seed in seeds]
    flown = experiment.map(fly_round, [{"source": case["world"], "changes": changes_of(**case, quick=experiment.quick)}
                                       for case in cases])
    flights = [{**case, **flight} for case, flight in zip(cases, flown)]
    for lidar, (name, limit_percent) in LIDARS.items():
        for agile in (False, True):
            its = [flight for flight in flights if (flight["lidar"], flight["agile"]) == (lidar, agile)]
            experiment.at_most(f"{name}, {'agile' if agile else 'calm'}: drift of local SLAM over 50 m [%]",
                               median_of(its, "drift_percent"), limit_percent, 2, "median; " + by_world(its, "drift_percent"))
    for lidar, (name, _) in LIDARS.items():
        its = [flight for flight in flights if flight["lidar"] == lidar]
        worst_m = max(flight["rms_after_m"] for flight in its)
        experiment.at_most(f"{name}: error after closures [m]", median_of(its, "rms_after_m"), ERROR_MAX_M, 2,
                           f"median of root mean squares; {by_world(its, 'rms_after_m')}; worst {worst_m:.2g}; "
                           f"by local SLAM alone {median_of(its, 'rms_local_after_m'):.2g}")
    path_m, lost_s = sum(flight["path_m"] for flight in flights), sum(flight["lost_s"] for flight in flights)
    experiment.at_most("contacts", sum(flight["outcome"] == "crashed" for flight in flights), 0, 1,
                       f"{len(flights)} flights, {path_m:.0f} m, {lost_s:.1f} s without a valid estimate")
    columns = ["world", "lidar", "agile", "seed", "outcome", "path_m", "lost_s", "drift_percent", "corrections",
               "rms_local_after_m", "rms_after_m"]
    experiment.write_csv("flights.csv", columns, [[flight[column] for column in columns] for flight in flights])
    draw(experiment, flights)
