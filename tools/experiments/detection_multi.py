# SPDX-License-Identifier: BSD-3-Clause
"""Three targets, one repeatedly behind a wall [Vrba 2025, Figs. 9 and 10]

Flights of 517 s in a hall of 15 x 10 m; the wall hides one target for 5 to 7 of every 21 s. The observer has an OS0-128, an IMU and
an odometry that drifts by 0.2 to 0.3 m. Without the IMU its attitude would be wrong by up to 49°. A track nearer than 1 m follows
its target. The figure shows targets (lines) and their tracks (crosses) per axis, gray while the moving target is hidden.
"""
import numpy as np
from shared.detection import COLUMNS, OS0_DEG, SAME_M, Sightings, fly_sightings

TARGETS = ["moving", "still, left", "still, right"]
MOVING = 0  # number of the target that the wall hides
HIDDEN_S, PATIENCE_S = 1.0, 5.0  # hidden for longer than this, the target is to be found again within this
DRAWN_S = 110.0  # part of the first flight that the figure shows


def fly_hall(changes):
    """Counts of one flight, and the beginning of its sightings by the tracker."""
    tracks = fly_sightings("reproduce/detection_multi", changes, OS0_DEG)["tracker"]
    sightings = Sightings(tracks)
    close = sightings.error_m < SAME_M
    targets_of_track = {}  # numbers of the targets that each track follows, one after another
    for track, target in zip(sightings.track[close], sightings.target[close]):
        followed = targets_of_track.setdefault(track, [])
        if followed[-1:] != [target]:
            followed.append(target)
    came_out, found_again = recoveries(Sightings(sightings.rows[sightings.target == MOVING]))
    return {"targets_followed": len(set(sightings.target[close])), "came_out": came_out, "found_again": found_again,
            "cross_associations": sum(len(followed) - 1 for followed in targets_of_track.values()),
            "drawn": [row for row in tracks if row[COLUMNS.index("t_s")] <= DRAWN_S] if changes["seed"] == 1 else []}


def recoveries(moving):
    """(how often the target comes out from behind the wall, how often it is then followed again in time)."""
    came_out_s, found_again = [], 0
    last_visible_s, lost = moving.t_s[0], False
    for t_s, visible, error_m in zip(moving.t_s, moving.visible, moving.error_m):
        if visible and t_s - last_visible_s > HIDDEN_S:
            came_out_s.append(t_s)
            lost = True
        if visible:
            last_visible_s = t_s
        if lost and error_m < SAME_M and t_s - came_out_s[-1] < PATIENCE_S:
            found_again += 1
            lost = False
    if lost and moving.t_s[-1] - came_out_s[-1] < PATIENCE_S:
        came_out_s.pop()  # the flight ends before
    return len(came_out_s), found_again


def draw(experiment, rows):
    from matplotlib.figure import Figure
    sightings = Sightings(rows)
    figure = Figure(figsize=(9, 8))
    panels = figure.subplots(3, 1, sharex=True)
    for axis, panel in zip("xyz", panels):
        for target, name in enumerate(TARGETS):
            its = Sightings(sightings.rows[sightings.target == target])
            close = its.error_m < SAME_M
            panel.plot(its.t_s, getattr(its, f"{axis}_m"), color=f"C{target}", label=name)
            panel.plot(its.t_s[close][::3], getattr(its, f"est_{axis}_m")[close][::3], "x", color=f"C{target}", markersize=3)
            if target == MOVING:
                panel.fill_between(its.t_s, 0, 1, where=its.visible == 0, transform=panel.get_xaxis_transform(), color="0.85")
        panel.set_ylabel(f"{axis} [m]")
    panels[0].legend(loc="upper right", fontsize="small")
    panels[-1].set_xlabel("time [s]")
    experiment.write_figure("detection-multi.svg", figure)


def run(experiment):
    seeds = range(1, experiment.repetitions(20, 2) + 1)
    duration_s = 60.0 if experiment.quick else 517.0
    flights = experiment.map(fly_hall, [{"changes": {"seed": seed, "duration_s": duration_s}} for seed in seeds])
    columns = ["targets_followed", "cross_associations", "came_out", "found_again"]
    counts = np.array([[flight[column] for column in columns] for flight in flights])
    followed = int((counts[:, 0] == len(TARGETS)).sum())
    _, crossed, came_out, found_again = counts.sum(axis=0).tolist()
    experiment.claim("runs in which all three targets were followed", f"{followed} of {len(flights)}", followed == len(flights))
    experiment.claim("cross-associations", str(crossed), crossed == 0)
    experiment.claim("found again after the wall", f"{found_again} of {came_out}", 0 < came_out == found_again)
    draw(experiment, flights[0]["drawn"])
    experiment.write_csv("detection-multi.csv", ["seed"] + columns, [[seed, *row] for seed, row in zip(seeds, counts.tolist())])
