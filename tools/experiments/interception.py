# SPDX-License-Identifier: BSD-3-Clause
"""MPC, FRPN, proportional navigation and pursuit after random targets [Vrba 2025, sec. VI-B]

The document reports captures of targets of up to 5 m/s without figures. The protocol is that of Pliska et al. (2024): a random
trajectory of 100 s, a net of 2 m radius, perfect knowledge of the target, and a start 5 to 20 m from it; 100 trajectories with 5
starts each. The paper's trajectories and the interceptor's limits are not public, two accounts differ about the target (up to 8 or
10 m/s), and published figures are from a transcription by others. So no row has a verdict. FRPN captures more often than published
and proportional navigation less often. [interception.md](../interception.md#compared-with-the-laws) compares the MPC with the laws.
"""
import math

from shared.tables import short_number
from shared.statistics import mean_and_deviation
from swiftlet.functions import Random

SCENARIO = "reproduce/interception"
METHODS = ("frpn", "proportional_navigation", "pure_pursuit", "mpc")
TARGETS = {"8 m/s": (8.0, 4.0), "10 m/s": (10.0, 8.0)}  # greatest speed [m/s] and acceleration [m/s^2]
SLOWEST_TARGET_MPS = 3.0
HEIGHT_M = 25.0  # height of the target's start, above the origin of the world
NEAREST_START_M, FARTHEST_START_M = 5.0, 20.0  # distance between start and target
STEEPEST_START_RAD = 0.5  # elevation of the start from the target, up or down
FIRST_TRAJECTORY = 100  # the planner is tuned on other trajectories


def protocol_flight(method, target, trajectory, start):
    """Changes of the scenario for one trajectory from one start. Each trajectory has its own speed and acceleration."""
    number = FIRST_TRAJECTORY + trajectory
    random = Random(1, "interception.protocol")
    top_speed_mps, top_acceleration_mps2 = target
    speed_mps = SLOWEST_TARGET_MPS + (top_speed_mps - SLOWEST_TARGET_MPS) * random.uniform(number, 0)
    draws = [random.uniform(number, 16 * (start + 1) + i) for i in range(3)]
    azimuth_rad = 2.0 * math.pi * draws[0]
    elevation_rad = STEEPEST_START_RAD * (2.0 * draws[1] - 1.0)
    distance_m = NEAREST_START_M + (FARTHEST_START_M - NEAREST_START_M) * draws[2]
    level_m = distance_m * math.cos(elevation_rad)
    start_m = (level_m * math.cos(azimuth_rad), level_m * math.sin(azimuth_rad), HEIGHT_M + distance_m * math.sin(elevation_rad))
    return {"seed": number + 1,
            "vehicles[0].agent.guidance.method": method,
            "vehicles[0].start.position_m": [round(x, 3) for x in start_m],
            "vehicles[1].agent.guidance.seed": number + 1,
            "vehicles[1].agent.guidance.speed_mps": round(speed_mps, 4),
            "vehicles[1].agent.guidance.acceleration_mps2": round(top_acceleration_mps2 * speed_mps / top_speed_mps, 4)}


def run(experiment):
    trajectories, starts = experiment.repetitions(100, 2), 1 if experiment.quick else 5
    conditions = (f"{trajectories} trajectories, {starts} starts each; the paper gives neither its trajectories nor the "
                  "interceptor's limits")
    cases = [(target, method) for target in TARGETS for method in METHODS]
    places = [(trajectory, start) for trajectory in range(trajectories) for start in range(starts)]
    flights = experiment.fly(SCENARIO, [protocol_flight(method, TARGETS[target], *place)
                                        for target, method in cases for place in places])
    table = []
    for i, (target, method) in enumerate(cases):
        of_case = flights[i * len(places):(i + 1) * len(places)]
        captures, first_s, least_m = ([flight[f"{metric}.interceptor"] for flight in of_case]
                                      for metric in ("captures", "time_to_first_capture_s", "least_net_distance_m"))
        table += zip([f"{target} {method}"] * len(places), *zip(*places), captures, first_s, least_m)
        captured = {trajectory for (trajectory, _), count in zip(places, captures) if count > 0}
        share = sum(count > 0 for count in captures) / len(captures)
        for what, value, digits, note in (
                ("trajectories captured [-]", len(captured) / trajectories, 3, f"{share:.3f} of all flights; {conditions}"),
                ("captures in 100 s", mean_and_deviation(captures)[0], 3, "each passage through the disc counts"),
                ("first capture after [s]", mean_and_deviation(first_s)[0], 3, "of the flights with a capture"),
                ("least distance from the net's middle [m]", mean_and_deviation(least_m)[0], 2, "mean over flights")):
            experiment.row(f"{target} {method}: {what}", short_number(value, digits), note=note, value=value)
    experiment.write_csv("flights.csv", ["case", "trajectory", "start", "captures", "first_s", "least_m"], table)
