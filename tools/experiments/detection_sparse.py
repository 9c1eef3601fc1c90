# SPDX-License-Identifier: BSD-3-Clause
"""Detection range of sparse returns: the detector of [Vrba 2025] and track before detect

An OS1-128 and a Mid-360 over open ground, where an agile target flies up to 40 m away, and in a forest with three targets; poses
have the noise of [Vrba 2025, eq. 66]. Nothing is tuned on these seeds. Counted is each scan from 10 s on with a target in the field
of view and nothing in between. The detector `vofod` needs several returns of one sweep; `track_before_detect` follows targets from
single returns on. Precision is the share of reports within 3 m of a target. A false track never comes within 1 m of one.
"""
import numpy as np
from shared.detection import IGNORED_S, MID360_DEG, OS1_DEG, SAME_M, Sightings, fly_sightings, visible

FIRST_SEED = 401
NEAR_M, FAR_M = 25.0, 40.0  # range of the rows, and of the figure
MID360 = {"vehicles[0].sensors[0]": {
    "type": "lidar", "name": "mid360", "model": "mid360_sheet", "mount": {"position_m": [0, 0, 0.15]},
    "external_pose": {"enabled": True, "sigma_position_m": 0.05, "sigma_rotation_rad": 0.005}}}
SENSORS = {  # name: (scenario, changes, field of view)
    "Mid-360": ("detection_real", MID360, MID360_DEG), "OS1-128": ("detection_real", {}, OS1_DEG),
    "Mid-360 in a forest": ("detection_forest", MID360, MID360_DEG),
    "OS1-128 in a forest": ("detection_forest", {"vehicles[0].sensors[0].pattern.columns": 512}, OS1_DEG)}
SOFTWARE = {"vofod": {}, "track_before_detect": {"vehicles[0].agent.detector": {"type": "track_before_detect"},
                                                 "vehicles[0].agent.tracker": {"type": "detector"}}}
METHODS = {  # name: (software, stage)
    "vofod": ("vofod", "detector"), "tracker of vofod": ("vofod", "tracker"),
    "track_before_detect": ("track_before_detect", "detector")}


def runs_of(experiment, scenario, changes, fov_deg):
    """Arguments of fly_sightings for each flight with one sensor and one software."""
    is_open = scenario == "detection_real"
    duration_s = 20.0 if experiment.quick else 60.0 if is_open else 45.0
    for seed in range(FIRST_SEED, FIRST_SEED + experiment.repetitions(4 if is_open else 2, 1)):
        paths = {"vehicles[0].agent.guidance.seed": 2 * seed - 1, "vehicles[1].agent.guidance.seed": 2 * seed} if is_open else {}
        yield {"source": f"reproduce/{scenario}", "fov_deg": fov_deg,
               "changes": {"seed": seed, "duration_s": duration_s, **paths, **changes}}


def note_of(flights, stage, observed_s):
    """False reports, switches of identity and targets that were never found, in words."""
    reported, false = (sum(flight[count][stage] for flight in flights) for count in ("reported", "false"))
    false_tracks = switches = in_view = never = 0
    for flight in flights:
        tracks = Sightings(flight["tracker"])
        false_tracks += len(set(flight["tracks"]) - set(tracks.track[tracks.error_m < SAME_M]))
        for target in np.unique(tracks.target):
            its = Sightings(tracks.rows[tracks.target == target])
            switches += np.count_nonzero(np.diff(its.track[its.found]))
            begins = np.flatnonzero(np.diff(its.visible, prepend=0.0) > 0)
            for begin, end in zip(begins, [*begins[1:], len(its.visible)]):
                if its.range_m[begin] < FAR_M:
                    in_view += 1
                    never += not np.any(its.found[begin:end] & (its.visible[begin:end] > 0))
    return (f"precision {1.0 - false / max(reported, 1):.3f}; {60.0 * false_tracks / observed_s:.2f} false tracks a minute; "
            f"{switches} switches of identity; came into view {in_view} times, {never} never found")


def run(experiment):
    from matplotlib.figure import Figure
    figure = Figure(figsize=(9, 7))
    rows = []
    for (sensor, (scenario, changes, fov_deg)), panel in zip(SENSORS.items(), figure.subplots(2, 2, sharex=True, sharey=True).flat):
        for method, (software, stage) in METHODS.items():
            runs = list(runs_of(experiment, scenario, {**changes, **SOFTWARE[software]}, fov_deg))
            flights = experiment.map(fly_sightings, runs)  # once for both stages of a software
            sightings = visible(flights, stage)
            bins = sightings.between(0.0, FAR_M).bins()
            panel.plot(list(bins), [there.recall() for there in bins.values()], "o-", label=method)
            rows += [[sensor, method, middle_m, len(there.found), there.recall()] for middle_m, there in bins.items()]
            note = note_of(flights, stage, sum(run["changes"]["duration_s"] - IGNORED_S for run in runs))
            recall = sightings.between(0.0, NEAR_M).recall()
            experiment.row(f"{sensor}, {method}: recall up to {NEAR_M:.0f} m", f"{recall:.3f}", note=note, value=recall)
        panel.set(title=sensor, xlabel="distance [m]", ylabel="recall [-]", ylim=(0.0, 1.05))
        panel.label_outer()
        panel.legend(fontsize="small")
    experiment.write_figure("detection-sparse.svg", figure)
    experiment.write_csv("detection-sparse.csv", ["sensor", "method", "middle_m", "sightings", "recall"], rows)
