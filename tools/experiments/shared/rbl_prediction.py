# SPDX-License-Identifier: BSD-3-Clause
"""Least distance between vehicles on rule-based Lloyd, predicted from the conditions of a flight of `batch/rbl_safety`: docs/rbl.md
derives it and names the symbols."""
import math

import numpy as np

DISTANCE_M = 1.1  # D, distance to keep: two encumbrances and the margin
TOUCHING_M = 0.81  # center distance at which two X500 at equal height touch; a smaller prediction guarantees nothing
CONTROL_ERROR_M = 0.1  # e, largest tracking error of a vehicle
RARE_SIGMAS, RESERVED_SIGMAS = 3.5, 2.0  # exceeded by one sample in 4000; reserved for the uncertainty of neighbors
RANGE_M = 15.0  # R, range of the sensor
REACTION_S = 0.3  # r, with the update period
MANEUVER_MPS2 = 2.0  # q, assumed standard deviation of a neighbor's acceleration
KNOWN_SHARE = 0.25  # relative accuracy at which an intruder's speed counts as known
# Speed [m/s] and acceleration [m/s^2] of each set of motion limits, below the upper limits of RBL.
LIMITS = {"slow": (1.0, 1.0), "medium": (4.0, 2.0), "fast": (4.0, 2.5), "agile": (4.0, 2.5)}
SLOWEST_INTRUDER_MPS = 0.8  # a slower one does not fly the 31 m to the middle within 40 s
NO_INTRUDER, INTRUDER = "promised, no intruder flies through", "promised, an intruder"
BLIND = "impossible, an intruder may come from an unobserved direction"
LATE, NOISE = "impossible, an intruder is known too late", "impossible, samples may be too far off"


def from_rest_m(time_s, speed_mps, acceleration_mps2):
    """Distance flown from rest: s(t) of rbl.md."""
    faster_s = min(max(time_s, 0.0), speed_mps / acceleration_mps2)
    return 0.5 * acceleration_mps2 * faster_s**2 + speed_mps * max(0.0, time_s - faster_s)


def predict(flight):
    """(kind, least distance to expect [m]) of a flight of the batch, from its parameters alone."""
    noise, delay_s, rate_hz, intruder_mps = (flight[name] for name in ("noise", "delay_s", "rate_hz", "intruder_mps"))
    speed_mps, acceleration_mps2 = LIMITS[flight["limits"]]
    team_m = DISTANCE_M - 2.0 * CONTROL_ERROR_M - 0.5 * (RARE_SIGMAS - RESERVED_SIGMAS) * noise * DISTANCE_M
    if intruder_mps < SLOWEST_INTRUDER_MPS:
        return NO_INTRUDER if team_m > TOUCHING_M else NOISE, team_m
    if "180" in flight["cameras"]:
        return BLIND, 0.0
    # The own speed lets the vehicle stop before an equally fast one that enters the range between two samples.
    unknown_s = 1.0 / rate_hz + delay_s + REACTION_S
    stopping_mps = acceleration_mps2 * (math.sqrt(unknown_s**2 + (RANGE_M - DISTANCE_M) / acceleration_mps2) - unknown_s)
    # A line through m samples of this noise has a slope with the standard deviation noise * range * rate * sqrt(12 / m^3).
    samples = max(2.0, np.cbrt(12.0 * (noise * RANGE_M * rate_hz / (KNOWN_SHARE * intruder_mps)) ** 2))
    meeting_s = (RANGE_M - DISTANCE_M) / (intruder_mps + min(speed_mps, stopping_mps))
    evade_s = meeting_s - (samples + 1.0) / rate_hz - delay_s - REACTION_S  # one sample may be lost
    recognized = intruder_mps > MANEUVER_MPS2 / (2.0 * rate_hz)
    aside_m = from_rest_m(evade_s, speed_mps, acceleration_mps2) if recognized else 0.0
    return LATE if aside_m <= TOUCHING_M else INTRUDER if team_m > TOUCHING_M else NOISE, min(team_m, aside_m)
