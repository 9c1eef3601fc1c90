# SPDX-License-Identifier: BSD-3-Clause
"""Processor time of each stage of detector and tracker [Vrba 2025, Table VI]

Processor time of one core, on the scans of 60 s of the flight of detection-noisy. The published figures are of a Ryzen 3900X with
twelve cores. The latencies of the detector are such that each of its stages works in a tick of its own. The tracker works on the
same scans and detections without the detector's map. newPointCloud() is the time of a vehicle with a tracker less that of one
without, newDetections() includes the hand-over of the detections, and updateTrack() is the whole newPointCloud() by the number of
tracks.
"""
import time

import numpy as np
import swiftlet
from shared.statistics import mean_and_deviation

SCENARIO = "reproduce/detection_noisy"
DETECTOR, TRACKER = "vehicles[0].agent.detector", "vehicles[0].agent.tracker"
SEEDS = {"seed": 1, "vehicles[0].agent.guidance.seed": 1, "vehicles[1].agent.guidance.seed": 2}
LATENCIES_S = {"classification_latency_s": 0.02, "raycasting_latency_s": 0.04, "separation_latency_s": 0.02,
               "separation_period_s": 0.1}
TICKS_OF_SCAN = 25  # a scan each 0.1 s, a tick each 4 ms
# Ticks after a scan in which the stages work. Removal begins in the first tick of the run, and again each separation_period_s.
SCAN, FIND_SEPARATE, CLASSIFY, REMOVE_SEPARATE, APPLY_RAYS = 0, 1, 5, 6, 10


@swiftlet.detector("replayed")
class Replayed:
    """Reports the detections of another detector in the same tick."""
    found = None  # table of detections, or None

    def __init__(self, setup):
        pass

    def step(self, now):
        found = Replayed.found
        if found is None:
            return None
        return [swiftlet.Detection(found.position_m[i], extent_m=found.extent_m[i], num_points=int(found.num_points[i]),
                                   confidence=float(found.confidence[i]), t_ns=int(found.t_ns[i])) for i in range(len(found))]


def timed_step_ms(vehicle, t_ns, poses, scans):
    for i in range(len(poses)):
        vehicle.add("pose", **{name: poses[name][i] for name in poses.keys()})
    for scan in scans:
        vehicle.add_scan(scan)
    started_s = time.thread_time()
    vehicle.step(t_ns)
    return 1e3 * (time.thread_time() - started_s)


def stage_times_ms(duration_s):
    """{stage of Table VI: time of each call [ms]}"""
    none = {"type": "none"}
    onboard = [swiftlet.Onboard(swiftlet.load(SCENARIO, {**SEEDS, **changes})) for changes in (
        {**{f"{DETECTOR}.timing.{name}": latency_s for name, latency_s in LATENCIES_S.items()}, TRACKER: none},
        {DETECTOR: {"type": "replayed"}, TRACKER: none}, {DETECTOR: {"type": "replayed"}})]
    flown = swiftlet.load(SCENARIO, {**SEEDS, "duration_s": duration_s, DETECTOR: none, TRACKER: none})
    simulator = swiftlet.Simulator(flown, threads=1)
    observer = simulator.vehicle(0)
    ticks = []  # per tick: times [ms] with detector, neither and tracker; numbers of tracks and detections
    while not simulator.finished:
        simulator.tick()
        times_ms = []
        for vehicle in onboard:
            times_ms.append(timed_step_ms(vehicle, simulator.t_ns, observer.samples("pose"), observer.scans))
            if vehicle is onboard[0]:
                Replayed.found = vehicle.detections
        ticks.append([*times_ms, len(onboard[2].tracks), len(Replayed.found or ())])
    ticks = ticks[TICKS_OF_SCAN - 1:]  # from the first scan on
    scans = len(ticks) // TICKS_OF_SCAN
    by_scan = np.array(ticks[:scans * TICKS_OF_SCAN]).reshape(scans, TICKS_OF_SCAN, -1)
    detector, neither, tracker, tracks, detections = by_scan.transpose(2, 1, 0)  # each: ticks after a scan, scans
    new_cloud_ms = tracker[SCAN] - neither[SCAN]
    followed = tracks[SCAN] > 0
    return {"clustering and classification": detector[CLASSIFY],
            "ray casting": detector[SCAN] - neither[SCAN] + detector[APPLY_RAYS],
            "removal of separate background": detector[FIND_SEPARATE] + detector[REMOVE_SEPARATE],
            "newPointCloud()": new_cloud_ms,
            "newDetections()": tracker[CLASSIFY][detections[CLASSIFY] > 0],
            "updateTrack()": new_cloud_ms[followed] / tracks[SCAN][followed]}


def run(experiment):
    from matplotlib.figure import Figure
    times_ms = stage_times_ms(8.0 if experiment.quick else 60.0)
    published = [experiment.published(f"{stage} [ms]") for stage in times_ms]
    means_ms, rows = [], []
    for (stage, stage_ms), theirs in zip(times_ms.items(), published):
        mean_ms, deviation_ms, calls = mean_and_deviation(stage_ms)
        longest_ms, their_longest_ms = float(stage_ms.max()), experiment.published(f"{stage}, longest [ms]").value
        experiment.row(f"{stage} [ms]", f"{mean_ms:.2f} ± {deviation_ms:.2f}",
                       "other conditions" if mean_ms < theirs.value else "differs",
                       f"at most {longest_ms:.1f} against {their_longest_ms:g}; {calls} calls", value=mean_ms,
                       tolerance="at most as long")
        means_ms.append(mean_ms)
        rows.append([stage, mean_ms, deviation_ms, longest_ms, calls, theirs.value, theirs.deviation, their_longest_ms])
    experiment.at_most("the three stages of the detector together, a scan [ms]", sum(means_ms[:3]),
                       sum(theirs.value for theirs in published[:3]), 3, "one core; published: a Ryzen 3900X of twelve")
    experiment.write_csv("detection-timing.csv", ["stage", "mean_ms", "deviation_ms", "maximum_ms", "calls", "published_mean_ms",
                                                  "published_deviation_ms", "published_maximum_ms"], rows)
    figure = Figure(figsize=(7, 4))
    panel = figure.subplots()
    panel.barh(np.arange(len(rows)) - 0.2, [theirs.value for theirs in published], 0.4, label="published")
    panel.barh(np.arange(len(rows)) + 0.2, means_ms, 0.4, label="ours")
    panel.set(xlabel="time of a call [ms]", xscale="log", yticks=range(len(rows)), yticklabels=list(times_ms))
    panel.invert_yaxis()
    panel.legend()
    experiment.write_figure("detection-timing.svg", figure)
