# SPDX-License-Identifier: BSD-3-Clause
"""Detector and tracker without any noise [Vrba 2025, Table V and Fig. 11]

Three flights of 355 s with the limits of Table IV. Seeds draw the trajectories; their paces give paths as long as the table's.
Counted is each scan from 10 s on with the target in the field of view and nothing in between. An estimate within 3 m of the truth
is a true positive. In the figure, solid lines are the detector's and dashed ones the tracker's.

The tracker misses the target mostly in the first scans after it comes into view: a detection is 0.11 to 0.22 s old. The detector
has a lower recall at long range, because a detection needs two returns and the median at 30 m is two.
"""
from shared.detection import draw_by_distance, fly_agile, visible

BIAS = "bias: circumscribed radius of the target [m]"  # a detection lies on the near side, at most so far from the center
NEAR_M = 20.0  # range up to which rays clear the map


def run(experiment):
    flights = fly_agile(experiment, "detection_ideal", 355.0)
    detections, tracks = visible(flights, "detector"), visible(flights, "tracker")
    near = tracks.between(0.0, NEAR_M)
    bias_m = experiment.published(BIAS).value
    share = float((detections.errors_m() <= bias_m).mean())
    experiment.at_least("share of true positives within the bias of 0.325 m", share, 0.99, 4,
                        f"{detections.found.sum()} detections")
    experiment.at_least("recall of the tracker up to 20 m", near.recall(), 0.95, 3,
                        f"{len(near.found)} scans, from the first in which the target is in view")
    experiment.row("recall of the detector, all distances", f"{detections.recall():.3f}", value=detections.recall())
    draw_by_distance(experiment, {"no noise": flights}, [("circumscribed radius of the target", [0.0, 60.0], [bias_m, bias_m])])
