# SPDX-License-Identifier: BSD-3-Clause
"""Crossings of a circle or a sphere, in which each vehicle flies to the opposite side [Kamler 2025, sec. 2.4]."""
import math

import numpy as np
import swiftlet

SCENARIO = "reproduce/rbl_crossing"  # physics, world and duration; the vehicles are those of crossing_vehicles
HEIGHT_M = {"circle": 5.0, "sphere": 20.0}  # [m] center above the ground
START_SPREAD_M = 0.1  # [m] greatest random offset of a start along an axis
GOLDEN_ANGLE_RAD = math.pi * (3.0 - math.sqrt(5.0))  # [rad] between successive vehicles of the spiral


def direction(shape, num_vehicles, i, poles=False):
    """Unit vector from the center to vehicle i: evenly spaced on the circle, along a golden-angle spiral on the sphere. poles: the
    spiral reaches from pole to pole."""
    if shape == "circle":
        angle_rad, z = 2.0 * math.pi * i / num_vehicles, 0.0
    else:
        angle_rad, z = GOLDEN_ANGLE_RAD * i, 1.0 - 2.0 * i / (num_vehicles - 1) if poles else 1.0 - (2.0 * i + 1.0) / num_vehicles
    rho = math.sqrt(1.0 - z * z)
    return np.array([rho * math.cos(angle_rad), rho * math.sin(angle_rad), z])


def crossing_vehicles(seed, shape, num_vehicles, radius_m, guidance, perfect=False, poles=False):
    """The `vehicles` of a scenario. The seed moves their starts. guidance: keys of the scenario, without goal_m; perfect: neighbors
    are measured without error, else as by UVDAR."""
    random = swiftlet.functions.Random(seed, "crossing.start")
    vehicles = []
    for i in range(num_vehicles):
        center_m = np.array([0.0, 0.0, HEIGHT_M[shape]])
        from_m = radius_m * direction(shape, num_vehicles, i, poles)
        start_m = center_m + from_m
        for axis in range(2 if shape == "circle" else 3):
            start_m[axis] += -START_SPREAD_M + 2.0 * START_SPREAD_M * random.uniform(i, axis)
        vehicles.append({
            "name": f"uav{i + 1}", "model": "x500",
            "start": {"position_m": start_m.tolist(), "yaw_deg": math.atan2(-from_m[1], -from_m[0]) * 180.0 / math.pi},
            "sensors": [{"type": "neighbors", "name": "uvdar", "model": "neighbors_uvdar", "ideal": perfect}],
            "agent": {"localization": {"type": "ground_truth"},
                      "control": {"limits": {"horizontal_jerk_mps3": 10, "vertical_jerk_mps3": 10}},
                      "guidance": {**guidance, "goal_m": (center_m - from_m).tolist()}}})
    return vehicles


def fly_crossing(seed, shape, num_vehicles, radius_m, guidance, perfect=False, poles=False, changes=None):
    """One flight: length_m and time_s of each vehicle up to its goal (time None: not arrived), contact, min_separation_m."""
    vehicles = crossing_vehicles(seed, shape, num_vehicles, radius_m, guidance, perfect, poles)
    scenario = swiftlet.load(SCENARIO, {"seed": seed, "vehicles": vehicles, "recorders": [], "snapshots": [], **(changes or {})})
    simulator = swiftlet.Simulator(scenario, threads=1)
    flying, length_m, time_s, last_m = list(range(num_vehicles)), np.zeros(num_vehicles), [None] * num_vehicles, None
    while not simulator.finished:
        simulator.tick()
        position_m = simulator.states.position_m.copy()
        if last_m is not None:
            length_m[flying] += np.linalg.norm(position_m - last_m, axis=1)[flying]
        last_m = position_m
        for i in [i for i in flying if simulator.vehicle(i).mission == "done"]:
            time_s[i] = simulator.t_s
            flying.remove(i)
    summary = simulator.summary()
    return {"seed": seed, "length_m": length_m.tolist(), "time_s": time_s, "contact": summary["outcome"] == "crashed",
            "min_separation_m": summary["metrics"]["run"]["min_separation_m"]}


class Crossings:
    """Flights of one case, and the columns of the document's tables, which are those of the flights that succeed."""

    def __init__(self, experiment, seeds, name, **case):
        self.name, self.perfect = name, case.get("perfect", False)
        self.flights = experiment.map(fly_crossing, [{"seed": seed, **case} for seed in range(1, seeds + 1)])
        arrived = [sum(time_s is not None for time_s in flight["time_s"]) for flight in self.flights]
        succeeded = [flight for flight, count in zip(self.flights, arrived)
                     if not flight["contact"] and count == case["num_vehicles"]]
        self.success = len(succeeded) / seeds  # share of flights without contact in which all vehicles arrive
        self.arrived = sum(arrived) / (seeds * case["num_vehicles"])  # share of all vehicles
        self.contact = sum(flight["contact"] for flight in self.flights) / seeds  # share of flights
        self.length_m = [length_m for flight in succeeded for length_m in flight["length_m"]]  # one per vehicle
        self.time_s = [time_s for flight in succeeded for time_s in flight["time_s"]]
        self.slowest_s = [max(flight["time_s"]) for flight in succeeded]  # one per flight
        self.mean_time_s = {  # key: seed; vehicles that arrive, flights without contact
            flight["seed"]: float(np.mean([time_s for time_s in flight["time_s"] if time_s is not None]))
            for flight, count in zip(self.flights, arrived) if count > 0 and not flight["contact"]}
        self.least_distance_m = min(flight["min_separation_m"] for flight in self.flights)


def write_flights(experiment, cases):
    """flights.csv: one row for each flight, with means and the slowest time of the vehicles that arrived."""
    rows = []
    for case in cases:
        for flight in case.flights:
            arrived = [(length_m, time_s) for length_m, time_s in zip(flight["length_m"], flight["time_s"]) if time_s is not None]
            means = np.mean(arrived, axis=0).tolist() if arrived else [math.nan, math.nan]
            slowest_s = max((time_s for _, time_s in arrived), default=math.nan)
            rows.append([case.name, int(case.perfect), flight["seed"], len(arrived), int(flight["contact"]), *means, slowest_s,
                         flight["min_separation_m"]])
    experiment.write_csv("flights.csv", ["case", "perfect_neighbors", "seed", "arrived", "contact", "length_m", "time_s",
                                         "slowest_s", "min_separation_m"], rows)
