# SPDX-License-Identifier: BSD-3-Clause
"""SLAM with faults of stamps, IMU, start and mount (beyond Orsulic 2021)

A vehicle flies by the truth at 3 m/s. SLAM runs beside it on its scans and IMU samples, with one fault a flight. Error: the largest of
the position while the estimate is valid, with the standard deviation reported then. NEES: mean normalized error squared of the pose,
6 for a correct covariance. The limits are our own. KISS-ICP and RKO-LIO, for comparison, ran on flights with other seeds.
"""
import re

import numpy as np
import swiftlet
from shared.rotations import rotations
from shared.tables import short_number
from slam_drift import WORLDS

FLOWN = ("campus", "warehouse", "forest")
LIDARS = {"mid360": "Mid-360", "os1_128": "OS1-128", "puck_lite": "Puck LITE"}
FIRST_SEED = 9105
FLIGHT_S, WRONG_INPUT_S, QUICK_S = 40.0, 20.0, 12.0  # durations from the start of SLAM on
SETTLED_S = 5.0  # NEES counts from here on; the start pose is exact by definition
CLOCK_S = 1.0  # clocks of the software and of all sensors at the start of the flight, so that early stamps are positive
WRONG_M, CONFIDENT_M = 1.0, 0.1  # an error above the first with a sigma below the second is confidently wrong

# Judged: what it is, its value from a flight and the flight without a fault, and its limit.
ERROR = ("error [m]", lambda flight, ideal: flight["worst_m"], 0.10)
NEES = ("NEES [-]", lambda flight, ideal: flight["nees"], 20)
RATIO = ("error (RMS) relative to that without a fault [-]", lambda flight, ideal: flight["rms_m"] / ideal["rms_m"], 2)
COST = ("final error beyond that without a fault [m]", lambda flight, ideal: flight["final_m"] - ideal["final_m"], 0.10)
FINAL = ("final error [m]", lambda flight, ideal: flight["final_m"], 0.3)
UNREPORTED = ("flights without a report [-]", lambda flight, ideal: not flight["reports"], 0)
LOST = ("lost without a report [-]", lambda flight, ideal: not flight["worst_m"] < WRONG_M and not flight["reports"], 0)

# How a flight is judged, changed keys of IMU, LiDAR, localization and vehicle, factors of the data, and when SLAM starts: at the first
# instant from from_s on with at least tilt_deg. Late IMU samples are delivered late, because none arrives before its stamp.
UNKNOWN_START = {"local.imu.start_velocity_sigma_mps": 5, "local.imu.start_tilt_sigma_deg": 15}
FAULTS = {
    "no fault": {"judged": (ERROR, NEES)},
    **{f"IMU stamps {ms} ms early": {"judged": (ERROR, NEES), "imu": {"clock.offset_s": CLOCK_S - 1e-3 * ms}} for ms in (40, 20, 10)},
    **{f"IMU stamps {ms} ms late": {"judged": (ERROR, NEES), "imu": {"clock.offset_s": CLOCK_S + 1e-3 * ms, "latency_s": 1e-3 * ms}}
       for ms in (10, 20, 40)},
    "IMU noise x 10": {"judged": (RATIO,), "imu": {"gyro_noise_density_radps_psqrthz": 3.39e-3,
                                                   "accel_noise_density_mps2_psqrthz": 0.04}},
    "IMU at 50 Hz": {"judged": (RATIO,), "imu": {"rate_hz": 50}},
    "vibration": {"judged": (RATIO,), "imu": {"vibration": {"accel_mps2": 0.5, "gyro_radps": 0.02}}},  # amplitudes of the preset imu_icm42688
    "IMU pauses for 1 s": {"judged": (COST,), "imu": {"outages": [{"start_s": 8, "end_s": 9}]}},  # in a corner of the campus
    "no IMU": {"judged": (LOST,), "slam": {"imu": "none"}},
    "start at 3 m/s": {"judged": (FINAL,), "slam": UNKNOWN_START, "from_s": 4},
    "start in a turn": {"judged": (FINAL,), "slam": UNKNOWN_START, "from_s": 4, "tilt_deg": 12,
                        "vehicle": {"agent.control.limits.set": "fast"}},
    "accelerometer negated": {"judged": (UNREPORTED,), "factors": {"f_mps2": -1}},
    "accelerometer in g": {"judged": (UNREPORTED,), "factors": {"f_mps2": 1 / 9.80665}},
    "gyroscope in deg/s": {"judged": (UNREPORTED,), "factors": {"omega_radps": 180 / np.pi}},
    "ranges in mm": {"judged": (UNREPORTED,), "factors": {"range_m": 1000}},
    **{f"LiDAR turned by {deg} deg": {"judged": (UNREPORTED,), "lidar": {"mount_error.rotation_deg": [0, 0, deg]}} for deg in (90, 180)},
}
OTHERS = {  # KISS-ICP 4bd9a105, RKO-LIO a335c17d, defaults, campus: root mean square error after the best alignment
    "no fault": ["KISS-ICP: Mid-360 0.22 m, OS1-128 0.26 m, Puck LITE 1.4 m", "RKO-LIO: Mid-360 0.033 m, Puck LITE 1.3 m"],
    "IMU stamps 10 ms late": ["RKO-LIO: Mid-360 0.034 m, Puck LITE 1.0 m"],
    "IMU stamps 20 ms late": ["RKO-LIO: Mid-360 0.033 m, Puck LITE 1.3 m"],
    "IMU stamps 40 ms late": ["RKO-LIO: Mid-360 0.19 m, Puck LITE 1.5 m"],
    "start at 3 m/s": ["RKO-LIO: Mid-360 0.039 m, Puck LITE 1.4 m", "KISS-ICP: Puck LITE 1.8 m"],
}
QUICK = [("campus", "mid360", fault) for fault in ("no fault", "IMU stamps 20 ms late", "vibration", "IMU pauses for 1 s",
                                                   "accelerometer in g")]


def changes_of(world, lidar, fault, seed):
    name, start_m, yaw_deg, waypoints_m, _, _, more = WORLDS[world]
    clock = {"offset_s": CLOCK_S}
    vehicle = {"name": name, "model": "x500", "start": {"position_m": start_m, "yaw_deg": yaw_deg},
               "sensors": [{"type": "lidar", "model": lidar, "mount": {"position_m": [0, 0, 0.15]}, "clock": clock},
                           {"type": "imu", "model": "imu_adis16448", "clock": clock}],
               "agent": {"localization": {"type": "ground_truth"},
                         "guidance": {"type": "waypoints", "speed_mps": 3, "loop": True, "waypoints_m": waypoints_m}}}
    return {"seed": seed, "duration_s": 1000, "snapshots": [], "recorders": [], "vehicles": [vehicle], **more,
            **{f"vehicles[0].{prefix}{key}": value for part, prefix in (("lidar", "sensors[0]."), ("imu", "sensors[1]."), ("vehicle", ""))
               for key, value in fault.get(part, {}).items()}}


def start_software(scenario, fault, p_m, R):
    """SLAM that starts at the true position and heading, and takes the vehicle for level."""
    return swiftlet.Onboard(swiftlet.load(scenario, {
        "vehicles[0].start": {"position_m": p_m.tolist(), "yaw_deg": float(np.degrees(np.arctan2(R[1, 0], R[0, 0])))},
        "vehicles[0].agent.localization": {"type": "slam"},
        **{f"vehicles[0].agent.localization.{key}": value for key, value in fault.get("slam", {}).items()}}))


def feed(software, fault, vehicle):
    """Passes on the samples and scans of this tick."""
    factor = {"omega_radps": 1, "f_mps2": 1, "range_m": 1, **fault.get("factors", {})}
    samples = vehicle.samples("imu")
    for i in range(len(samples) if "imu" not in fault.get("slam", {}) else 0):
        try:
            software.add("imu", t_ns=samples.t_ns[i], **{key: factor[key] * samples[key][i] for key in ("omega_radps", "f_mps2")})
        except ValueError:
            continue  # Onboard refuses a first sample in wrong units and accepts those after it, by which SLAM has to report them
    for scan in vehicle.scans:
        software.add_scan(scan if factor["range_m"] == 1 else swiftlet.make_scan(
            factor["range_m"] * scan.range_m, scan.directions_lidar, scan.t_ns, offset_s=scan.column_offset_s,
            T_body_lidar=scan.T_body_lidar, range_max_m=factor["range_m"] * scan.range_max_m))


def fly_fault(world, lidar, fault, seed, duration_s):
    """One flight: its errors at the end of each scan, and what SLAM reported."""
    fault = FAULTS[fault]
    scenario = swiftlet.load(world, changes_of(world, lidar, fault, seed))
    simulator = swiftlet.Simulator(scenario, threads=1)
    vehicle, software, rows, reports = simulator.vehicle(0), None, [], []
    while software is None or simulator.t_s < start_s + duration_s:
        simulator.tick()
        p_m, R = simulator.states.position_m[0], rotations(simulator.states.q_xyzw)[0]
        if software is None:
            if simulator.t_s < fault.get("from_s", 0) or R[2, 2] > np.cos(np.radians(fault.get("tilt_deg", 0))):
                continue
            software, start_s = start_software(scenario, fault, p_m, R), simulator.t_s
        feed(software, fault, vehicle)
        software.step(simulator.t_ns + int(1e9 * CLOCK_S))
        if len(vehicle.scans):
            T, covariance = software.estimate.local_pose, software.estimate.cov_m2
            turned = 0.5 * (T[:3, :3].T @ R - R.T @ T[:3, :3])  # cross product matrix of the attitude error, a small angle
            error = np.append(p_m - T[:3, 3], [turned[2, 1], turned[0, 2], turned[1, 0]])
            rows.append((simulator.t_s - start_s, software.estimate.valid, np.linalg.norm(error[:3]),
                         np.sqrt(np.diag(covariance)[:3].max()), error @ np.linalg.lstsq(covariance, error, rcond=None)[0]))
            reports += [text for text in (software.fault, software.warning) if text and text not in reports]
    return describe(rows, reports)


def describe(rows, reports):
    """Errors of a flight; NaN where the estimate is not valid. final_m: at the end. offset_ms: positive for late IMU stamps."""
    t_s, valid, error_m, sigma_m, nees = np.array(rows).T
    error_m = np.where(valid > 0, error_m, np.nan)
    nees = nees[(valid > 0) & (t_s > SETTLED_S)]
    found = re.findall(r"stamps are (\d+) us (late|early) \(sigma (\d+) us\)", "; ".join(reports))
    offset_us, side, offset_sigma_us = found[-1] if found else (np.nan, "late", np.nan)
    worst = np.argmax(np.nan_to_num(error_m))
    return {"worst_m": float(error_m[worst]), "rms_m": float(np.sqrt(np.mean(error_m[valid > 0]**2))) if valid.any() else np.nan,
            "final_m": float(error_m[-1]), "sigma_m": float(sigma_m[worst]), "nees": float(np.mean(nees)) if len(nees) else np.nan,
            "valid_share": float(np.mean(valid)), "offset_ms": 1e-3 * float(offset_us) * (1 if side == "late" else -1),
            "offset_sigma_ms": 1e-3 * float(offset_sigma_us),
            "confidently_wrong": bool(np.any((error_m > WRONG_M) & (sigma_m < CONFIDENT_M))),
            "reports": [text for text in reports if "stamps are" not in text]}


def note_of(flight):
    offset = "" if np.isnan(flight["offset_ms"]) else f", offset {flight['offset_ms']:.1f} ± {flight['offset_sigma_ms']:.1f} ms"
    invalid = "" if flight["valid_share"] == 1.0 else f", {100 * flight['valid_share']:.0f} % valid"
    worst_m, sigma_m, nees = (short_number(flight[key], 2) for key in ("worst_m", "sigma_m", "nees"))
    return f"{flight['world']} {LIDARS[flight['lidar']]} {worst_m} m (sigma {sigma_m} m, NEES {nees}{offset}{invalid})"


def run(experiment):
    seeds = range(FIRST_SEED, FIRST_SEED + experiment.repetitions(1, 1))
    cases = QUICK if experiment.quick else [(world, lidar, fault) for world in FLOWN for lidar in LIDARS for fault in FAULTS]
    duration_s = {fault: WRONG_INPUT_S if UNREPORTED in FAULTS[fault]["judged"] else FLIGHT_S for fault in FAULTS}
    runs = [{"world": world, "lidar": lidar, "fault": fault, "seed": seed, "duration_s": QUICK_S if experiment.quick else duration_s[fault]}
            for world, lidar, fault in cases for seed in seeds]
    flights = [{**one, **flown} for one, flown in zip(runs, experiment.map(fly_fault, runs))]
    ideal = {(flight["world"], flight["lidar"], flight["seed"]): flight for flight in flights if flight["fault"] == "no fault"}
    for fault in dict.fromkeys(flight["fault"] for flight in flights):
        its = [flight for flight in flights if flight["fault"] == fault]
        reports = dict.fromkeys(text for flight in its for text in flight["reports"])
        note = "; ".join([*map(note_of, its), *reports, *OTHERS.get(fault, [])])
        for what, value_of, limit in FAULTS[fault]["judged"]:
            values = [value_of(flight, ideal[flight["world"], flight["lidar"], flight["seed"]]) for flight in its]
            value = sum(values) if limit == 0 else np.max(values)  # a number of flights, or the worst of them
            experiment.at_most(f"{fault}: {what}", float(value), limit, 2, note)
            note = ""
    wrong = [flight for flight in flights if flight["confidently_wrong"]]
    experiment.at_most(f"flights off by more than {WRONG_M:g} m with a sigma below {CONFIDENT_M:g} m", len(wrong), 0, 1,
                       "; ".join(f"{flight['fault']}, {flight['world']}, {LIDARS[flight['lidar']]}" for flight in wrong))
    columns = [*runs[0], "worst_m", "sigma_m", "rms_m", "final_m", "nees", "valid_share", "offset_ms", "offset_sigma_ms",
               "confidently_wrong", "reports"]
    experiment.write_csv("flights.csv", columns, [[" / ".join(flight[column]) if column == "reports" else flight[column]
                                                  for column in columns] for flight in flights])
