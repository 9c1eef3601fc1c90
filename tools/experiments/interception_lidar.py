# SPDX-License-Identifier: BSD-3-Clause
"""Interception by LiDAR alone: captures by speed and method, noise, wind and latency [Vrba 2025, sec. VI-B]

The interceptor has a map of the field and detects the intruder with its LiDAR only. Each flight draws its field, both starts and
the intruder's trajectory, and lasts 60 s at most. A capture counts in a flight without contact. The document gives no figures, so
the limits are our own. [interception.md](../interception.md#with-a-lidar) discusses the results.
"""
import functools
import itertools

import numpy as np
import swiftlet
from shared.experiment import result_of
from shared.tables import short_number
from shared.statistics import mean_and_deviation
from swiftlet.functions import Random

SCENARIO = "reproduce/interception_lidar"
METHODS = ("mpc", "frpn", "proportional_navigation", "pure_pursuit")
DOCUMENT_SPEED_MPS = 5.0  # greatest speed of the document's targets
SPEEDS_MPS = (1.0, 3.0, 5.0, 8.0, 10.0)  # greatest speed of the target
ACCELERATION_TIME_S = 1.0 / 0.6  # intruder: greatest speed over greatest acceleration
FIRST_FLIGHT = 500  # the planner is tuned on other flights
NEAREST_M = 10.0  # least distance between the two starts
STARTS_MIN_M, STARTS_MAX_M = np.array([-16.0, -16.0, 6.5]), np.array([16.0, 16.0, 10.5])  # box of starts, within the intruder's box
END_EVENTS = {"mission_done", "mission_failed", "crash"}  # a flight ends with the first of them
SENSOR, AGENT = "vehicles[0].sensors[0].", "vehicles[0].agent."
EYES = {  # the Mid-360 is upside down because the net hangs below; few of its beams hit a target, so its detector fuses scans
    "OS1-128": {},
    "Mid-360": {SENSOR + "model": "mid360_sheet", SENSOR + "mount": {"position_m": [0, 0, -0.12], "rpy_deg": [180, 0, 0]},
                AGENT + "detector": {"type": "track_before_detect"}, AGENT + "tracker": {"type": "detector"},
                AGENT + "guidance.search": {"timeout_s": 60, "fov_bottom_deg": -52, "fov_top_deg": 7, "range_m": 25}}}
DISTURBANCES = {
    "detections 0.3 s late": {AGENT + "detector.timing.classification_latency_s": 0.3},
    "detections 0.5 s late": {AGENT + "detector.timing.classification_latency_s": 0.5},
    "wind of 5 m/s with moderate gusts": {"wind": {"mean_mps": [5, 0, 0], "gusts": True, "wind_at_6m_mps": 15.4}},
    "wind of 8 m/s with severe gusts": {"wind": {"mean_mps": [8, 0, 0], "gusts": True, "wind_at_6m_mps": 23.2}}}


def hunt(flight, method, speed_mps, changes):
    """Changes of the scenario for one flight: field, starts, the intruder's trajectory and greatest speed."""
    number = FIRST_FLIGHT + flight
    random = Random(1, "interception.lidar")

    def place_m(draw):
        return STARTS_MIN_M + (STARTS_MAX_M - STARTS_MIN_M) * [random.uniform(number, 4 * draw + axis) for axis in range(3)]

    interceptor_m = place_m(0)
    intruder_m = next(p_m for p_m in map(place_m, itertools.count(1)) if np.linalg.norm(p_m - interceptor_m) >= NEAREST_M)
    return {"seed": number,
            "vehicles[0].agent.guidance.method": method,
            "vehicles[0].start.position_m": interceptor_m.round(2).tolist(),
            "vehicles[1].start.position_m": intruder_m.round(2).tolist(),
            "vehicles[1].agent.guidance.seed": number,
            "vehicles[1].agent.guidance.speed_mps": speed_mps,
            "vehicles[1].agent.guidance.acceleration_mps2": round(speed_mps / ACCELERATION_TIME_S, 3), **changes}


def fly_hunt(changes):
    """Flies until a mission ends or a vehicle crashes."""
    simulator = swiftlet.Simulator(swiftlet.load(SCENARIO, changes), threads=1)
    while not simulator.finished and END_EVENTS.isdisjoint(simulator.events.kind):
        simulator.tick()
    return result_of(simulator.summary())


def fly_hunts(experiment, table, name, flights, method, speed_mps, changes):
    """(time of each capture without contact [s], number of flights with contact); one row a flight in the table."""
    runs = experiment.map(fly_hunt, [{"changes": hunt(flight, method, speed_mps, changes)} for flight in range(flights)])
    times_s, contacts = [], 0
    for flight, run in enumerate(runs):
        contact = run["crash_time_s.interceptor"] is not None or run["crash_time_s.intruder"] is not None
        captured = run["captures.interceptor"] > 0 and not contact
        contacts += contact
        times_s += [run["time_to_first_capture_s.interceptor"]] if captured else []
        table.append([name, flight, int(captured), int(contact), run["time_to_first_capture_s.interceptor"],
                      run["track_recall.interceptor"]])
    return times_s, contacts


def text_of(times_s, flights, contacts):
    when = f" after {short_number(np.mean(times_s), 3)} s in the mean, {short_number(max(times_s), 3)} s at most" if times_s else ""
    return f"{len(times_s)} of {flights}{when}" + (f", {contacts} with contact" if contacts else "")


def draw(results):
    """Captured share and mean time of the captures over the target's speed. results: {(LiDAR, method): [(speed, share, time)]}."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=(9, 6.5), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True)
    for (eye, method), cells in results.items():
        speeds_mps, shares, means_s = zip(*cells)
        row = panels[list(EYES).index(eye)]
        for panel, values, label in zip(row, (shares, means_s), ("captured [-]", "mean time of the captures [s]")):
            panel.plot(speeds_mps, values, "o-", label=method)
            panel.set(title=eye, xlabel="greatest speed of the target [m/s]", ylabel=label)
    for panel in panels.flat:
        panel.set_ylim(bottom=0)
    panels[0, 1].legend()
    return figure


def run(experiment):
    table, results = [], {}
    fly = functools.partial(fly_hunts, experiment, table)

    flights = experiment.repetitions(100, 2)
    times_s, contacts = fly("document", flights, "mpc", DOCUMENT_SPEED_MPS, {})
    document = "OS1-128, IMM, MPC, up to 5 m/s: "
    experiment.at_least(document + "captured within 60 s without contact [-]", len(times_s) / flights, 0.99, 3,
                        text_of(times_s, flights, contacts))
    experiment.at_most(document + "contacts", contacts, 0, 1)

    flights = experiment.repetitions(20, 1)
    for name, changes in DISTURBANCES.items():
        times_s, contacts = fly(name, flights, "mpc", DOCUMENT_SPEED_MPS, changes)
        share = len(times_s) / flights
        experiment.row(f"OS1-128, mpc, up to 5 m/s, {name}: captured [-]", short_number(share, 3), value=share,
                       note=text_of(times_s, flights, contacts))

    flights = experiment.repetitions(12, 1)
    speeds_mps = (DOCUMENT_SPEED_MPS,) if experiment.quick else SPEEDS_MPS
    for eye, method in itertools.product(EYES, METHODS):
        cells = [fly(f"{eye}, {method}, up to {speed_mps:g} m/s", flights, method, speed_mps, EYES[eye])
                 for speed_mps in speeds_mps]
        results[eye, method] = [(speed_mps, len(times_s) / flights, mean_and_deviation(times_s)[0])
                                for speed_mps, (times_s, _) in zip(speeds_mps, cells)]
        share = sum(len(times_s) for times_s, _ in cells) / (flights * len(cells))
        experiment.row(f"{eye}, {method}: captured [-]", short_number(share, 3), value=share, note="; ".join(
            f"up to {speed_mps:g} m/s: {text_of(times_s, flights, contacts)}"
            for speed_mps, (times_s, contacts) in zip(speeds_mps, cells)))
    experiment.write_csv("hunts.csv", ["case", "flight", "captured", "contact", "first_s", "track_recall"], table)
    experiment.write_figure("interception-speed.svg", draw(results))
