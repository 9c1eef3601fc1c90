# SPDX-License-Identifier: BSD-3-Clause
"""Effect of a poor GNSS receiver on the pose graph [Orsulic 2021, Fig. 8]

Up, twice around a building and down again, with the receiver `gnss_m8p`, whose model drifts by 2 m in a minute. The compass gives
the initial heading and the first fix the initial position [sec. III-C]. The graph is optimized every minute. Height at landing:
error of the climb from the first node of the final graph to the last one. With the weights of eqs. 5 and 6 it stays in the
millimeters. With a hundred times the weight (eq. 7) the path follows the receiver.
"""
import pathlib
import struct
import tempfile

import numpy as np
from shared.experiment import result_of
from shared.tables import short_number
from shared.slam import course, record

USES = {  # how fixes are weighted: keys of global.gnss; None: no GNSS
    "without GNSS": None,
    "per axis (eq. 5)": {"weighting": "per_axis", "huber": 1000},
    "isotropic, largest deviation (eq. 6)": {"weighting": "isotropic", "huber": 1000},
    "squared deviation, as released": {"weighting": "released", "huber": 1000},
    "isotropic, a = 100 (eq. 7)": {"weighting": "isotropic", "a": 100, "huber": 1000},
    "isotropic, Huber loss": {"weighting": "isotropic", "huber": 1},
}
LIMITED = ("without GNSS", "isotropic, Huber loss")  # uses that keep the limit
HEIGHT_MAX_M = 0.1  # limit of the error of the height at landing
ROUND_M = [[25, 0, 2.7], [25, 20, 2.7], [0, 20, 2.7], [0, 0, 2.7]]  # from the start


def changes_of(use, seed, quick):
    vehicle = "vehicles[0]."
    gnss = {"use_gnss": use is not None, **({} if use is None else {"gnss": use})}
    return {"seed": seed, "duration_s": 65 if quick else 110, "recorders": [{"type": "slam_map"}], "snapshots": [],
            vehicle + "start.position_m": [-12.5, -10, 1.3], vehicle + "start.known": "pose" if use is None else "nothing",
            vehicle + "agent.localization": {"type": "slam", "global": {"enabled": True, "optimize_every_s": 60, **gnss}},
            vehicle + "agent.guidance": {"type": "waypoints", "frame": "start", "speed_mps": 2, "loop": False, "waypoints_m": [
                [0, 0, 2.7], *ROUND_M * (1 if quick else 2), [0, 0, 0]]}}


def graph_heights(file):
    """(times [s], heights [m]) of the nodes of a saved pose graph."""
    data, at = file.read_bytes(), len(b"Swiftlet map of SLAM\n") + 4 + 8 + 8  # version, size, checksum
    voxel_m, poses = struct.unpack_from("<dQ", data, at)
    z_m = np.frombuffer(data, "<f8", 12 * poses, at + 16).reshape(poses, 12)[:, 11]  # rotation, then position
    at += 16 + 96 * poses
    for factor_bytes in (400, 388, 36, 72):  # relative poses, known poses, gravity, positions
        at += 8 + factor_bytes * struct.unpack_from("<Q", data, at)[0]
    nodes = np.frombuffer(data, "<i8, <i4", struct.unpack_from("<Q", data, at)[0], at + 8)  # time [ns], pose
    return 1e-9 * nodes["f0"], z_m[nodes["f1"]]


def fly_gnss(source, changes):
    """One flight: outcome, course and climb_error_m, that of the final graph from its first node to the last."""
    with tempfile.TemporaryDirectory() as folder:
        simulator, log = record(source, changes, out=pathlib.Path(folder) / "run")
        simulator.finish()
        t_s, z_m = graph_heights(pathlib.Path(folder) / "run" / "maps" / "uav1.slam")
    true_m = np.interp(t_s[[0, -1]], log.t_s, log.p_true_m[:, 2])
    climb_error_m = float(z_m[-1] - z_m[0] - (true_m[1] - true_m[0]))
    return {**result_of(simulator.summary()), "climb_error_m": climb_error_m, "course": course(log)}


def gnss_climb_error_m(its_course):
    """Error [m] of the climb from the first fix to the last."""
    fixes_m, true_m = np.array(its_course["p_gnss_m"])[:, 2], np.array(its_course["p_true_m"])[:, 2]
    fixes_m = fixes_m[~np.isnan(fixes_m)]
    return abs(fixes_m[-1] - fixes_m[0] - (true_m[-1] - true_m[0]))


def draw(experiment, flights):
    """The first flight of each use."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=(7, 8))
    for axis, (axes, name) in enumerate(zip(figure.subplots(3, sharex=True), ("east", "north", "height"))):
        first = flights["without GNSS"][0]["course"]
        axes.plot(first["t_s"], np.array(first["p_true_m"])[:, axis], color="0.7", linewidth=4, label="truth")
        axes.plot(first["t_s"], np.array(first["p_gnss_m"])[:, axis], "k:", label="GNSS")
        for use, its in flights.items():
            t_s, shown_m = np.array(its[0]["course"]["t_s"]), np.array(its[0]["course"]["p_shown_m"])
            axes.plot(t_s[t_s >= 1], shown_m[t_s >= 1, axis], linewidth=1, label=use)  # the start is known by then
        axes.set(ylabel=f"{name} [m]")
    axes.set(xlabel="time [s]")
    figure.axes[0].set(title="Estimated position (Fig. 8)")
    figure.legend(*axes.get_legend_handles_labels(), loc="upper center", bbox_to_anchor=(0.5, 0.04), ncols=2)
    experiment.write_figure("gps-weighting.svg", figure)


def run(experiment):
    seeds = range(1, experiment.repetitions(20, 2) + 1)
    flown = experiment.map(fly_gnss, [{"source": "campus", "changes": changes_of(use, seed, experiment.quick)}
                                      for use in USES.values() for seed in seeds])
    flights = {use: flown[i * len(seeds):(i + 1) * len(seeds)] for i, use in enumerate(USES)}
    for use, its in flights.items():
        height_m = float(np.median([abs(flight["climb_error_m"]) for flight in its]))
        what = f"{use}: height at landing [m]"
        if use in LIMITED:
            experiment.at_most(what, height_m, HEIGHT_MAX_M, 2, "median")
        else:
            experiment.row(what, short_number(height_m, 2), note="median", value=height_m)
    height_m = float(np.median([gnss_climb_error_m(flight["course"]) for flight in flights["without GNSS"]]))
    experiment.row("GNSS itself: height at landing [m]", short_number(height_m, 2), value=height_m,
                   note="median; the receiver's model drifts by 2 m in a minute")
    experiment.at_most("contacts", sum(flight["outcome"] == "crashed" for flight in flown), 0, 1, f"{len(flown)} flights")
    experiment.write_csv("flights.csv", ["use", "seed", "outcome", "climb_error_m"],
                         [[use, seed, flight["outcome"], flight["climb_error_m"]]
                          for use, its in flights.items() for seed, flight in zip(seeds, its)])
    draw(experiment, flights)
