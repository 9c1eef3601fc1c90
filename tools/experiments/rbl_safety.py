# SPDX-License-Identifier: BSD-3-Clause
"""Conditions that break the cells, with and without braking planes (beyond Kamler 2025)

Single conditions on a circle of 10 m, with the default settings and with those of the document. Then the flights of
`batch/rbl_safety` beside the least distance to expect, as [rbl.md](../rbl.md#what-distance-to-expect) derives it. No distance can
be promised where an intruder may come from a blind sector or is known too late, and where samples may be too far off.
"""
import math
import pathlib
import shutil
import subprocess

import numpy as np
import swiftlet
from shared.crossing import SCENARIO, crossing_vehicles
from shared.rbl_prediction import BLIND, INTRUDER, LATE, NO_INTRUDER, NOISE, predict
from shared.statistics import mean_and_deviation
from swiftlet.functions import Random

VEHICLES, RADIUS_M, HEIGHT_M = 10, 10.0, 8.0  # circle: vehicles, radius, height of its center above the ground
RBL = {"type": "rbl", "variant": "3d_z", "z_max_m": 2.0 * HEIGHT_M, "cells": {"step_m": 0.35}}
SENSORS = {  # changes of the sensor for neighbors
    "a hovering vehicle in one goal": {}, "one sample in 2 s": {"rate_hz": 0.5}, "90 % dropout": {"dropout_probability": 0.9},
    "delay of 0.4 s": {"latency_s": 0.4}, "noise of 0.2 of the range": {"sigma_range_relative": 0.2},
    "an intruder at 4 m/s": {"ideal": True}}
INTRUDER_MPS = 4.0
QUICK_EPISODES = "282,710,848,976"  # episodes of the batch, drawn at random once


def scene(condition, document, seed):
    """Changes of the scenario: vehicles that cross the circle under one condition."""
    guidance = {**RBL, "model": "rbl_thesis"} if document else RBL
    vehicles = crossing_vehicles(seed, "circle", VEHICLES, RADIUS_M, guidance)
    for vehicle in vehicles:
        vehicle["start"]["position_m"][2] = vehicle["agent"]["guidance"]["goal_m"][2] = HEIGHT_M
        vehicle["sensors"][0].update(SENSORS[condition])
    if condition.startswith("a hovering"):
        vehicles[5]["agent"]["guidance"] = {"type": "hover"}
    if condition.startswith("an intruder"):
        u = [Random(seed, "rbl-safety.case").uniform(0, i) for i in range(3)]
        azimuth_rad, side_m, meeting_s = 2.0 * math.pi * u[0], -2.0 + 4.0 * u[1], 2.0 + 6.0 * u[2]
        ahead = np.array([math.cos(azimuth_rad), math.sin(azimuth_rad), 0.0])
        middle_m = side_m * np.array([-ahead[1], ahead[0], 0.0]) + [0.0, 0.0, HEIGHT_M]
        start_m = middle_m - (20.0 + INTRUDER_MPS * meeting_s) * ahead
        way = {"type": "waypoints", "speed_mps": INTRUDER_MPS, "waypoints_m": [(middle_m + 30.0 * ahead).tolist()]}
        first = vehicles[0]
        vehicles.append({**first, "name": "intruder", "start": {**first["start"], "position_m": start_m.tolist()},
                         "agent": {**first["agent"], "guidance": way}})
    return {"seed": seed, "duration_s": 60.0, "metrics.stop_on_crash": True, "vehicles": vehicles, "recorders": [], "snapshots": []}


def fly_conditions(experiment):
    seeds, table = range(1, experiment.repetitions(6, 1) + 1), []
    for condition in SENSORS:
        for document in (False, True):
            flights = experiment.fly(SCENARIO, [scene(condition, document, seed) for seed in seeds])
            contacts = sum(flight["outcome"] == "crashed" for flight in flights) / len(flights)
            least_m = min(flight["min_separation_m"] for flight in flights)
            times_s = [[time_s for name, time_s in flight.items() if name.startswith("time_to_done_s.")] for flight in flights]
            time_s = mean_and_deviation([time_s for of_flight in times_s if None not in of_flight for time_s in of_flight])[0]
            when = "in no flight all arrive" if math.isnan(time_s) else f"{time_s:.1f} s"
            experiment.row(f"{condition}{', document' * document}: flights with contact [-]", f"{contacts:.2f}", value=contacts,
                           note=f"least distance {least_m:.2f} m, {when}")
            table.append([condition, int(document), contacts, least_m, time_s])
    experiment.write_csv("conditions.csv", ["condition", "document", "contacts", "least_m", "time_s"], table)


def fly_batch(experiment):
    """The flights of batch/rbl_safety, flown by the program that is built beside the module: dicts of parameters and metrics."""
    program, folder = pathlib.Path(swiftlet.__file__).parents[2] / "swiftlet", experiment.folder / "batch"
    if not experiment.resume:
        shutil.rmtree(folder, ignore_errors=True)
    options = ["--resume"] * folder.exists() + ["--episodes", QUICK_EPISODES] * experiment.quick + ["-q"] * experiment.quiet
    subprocess.run([program, "batch", "batch/rbl_safety", "--out", folder, "--jobs", str(experiment.jobs), *options], check=True)
    return swiftlet.read_batch(folder).wide


def compare_batch(experiment):
    flights = fly_batch(experiment)
    for flight in flights:
        flight["kind"], flight["predicted_m"] = predict(flight)
        flight["contact"] = flight["outcome"] == "crashed"
        flight["nearer"] = flight["min_separation_m"] < flight["predicted_m"]
    promised = [flight for flight in flights if flight["kind"] in (NO_INTRUDER, INTRUDER)]
    for what, key, ours in (("batch: no contact where a distance is promised", "contact", "flights with contact"),
                            ("batch: no vehicle comes nearer than promised", "nearer", "flights came nearer")):
        count = sum(flight[key] for flight in promised)
        experiment.claim(what, f"{count} of {len(promised)} {ours}", count == 0)
    kinds = {kind: [flight for flight in flights if flight["kind"] == kind] for kind in (NO_INTRUDER, INTRUDER, BLIND, LATE, NOISE)}
    kinds = {kind: of_kind for kind, of_kind in kinds.items() if of_kind}
    for kind, of_kind in kinds.items():
        contacts, nearer = (sum(flight[key] for flight in of_kind) for key in ("contact", "nearer"))
        least_m = min(flight["min_separation_m"] for flight in of_kind)
        with_intruder = sum(flight["crash_time_s.intruder"] != "" for flight in of_kind)
        arrived = [value != "" for flight in of_kind for name, value in flight.items() if name.startswith("time_to_done_s.uav")]
        experiment.row(f"batch, {kind}: flights with contact [-]", f"{contacts} of {len(of_kind)}", value=contacts,
                       note=f"{with_intruder} with the intruder; least distance {least_m:.2f} m; {nearer} flights below the "
                       f"prediction; {100 * np.mean(arrived):.0f} % of the vehicles arrive in time")
    columns = ["variant", "seed", "noise", "delay_s", "rate_hz", "cameras", "limits", "wind_mps", "intruder_mps", "kind",
               "predicted_m", "min_separation_m", "outcome"]
    experiment.write_csv("batch.csv", columns, [[flight[column] for column in columns] for flight in flights])
    experiment.write_figure("rbl-safety.svg", draw(kinds))


def draw(kinds):
    """Least distance of each flight over the predicted one. kinds: {kind: flights}."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=(7, 4))
    axes = figure.add_subplot(title="Least distance, predicted and flown", xlabel="predicted [m]", ylabel="flown [m]")
    for kind, flights in kinds.items():
        axes.plot(*zip(*((flight["predicted_m"], flight["min_separation_m"]) for flight in flights)), "o", alpha=0.6, label=kind)
    axes.plot([0.0, 1.2], [0.0, 1.2], "k--", label="as predicted")
    axes.set(xlim=(0, None), ylim=(0, None))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), fontsize="small")  # below the axes
    return figure


def run(experiment):
    fly_conditions(experiment)
    compare_batch(experiment)
