# SPDX-License-Identifier: BSD-3-Clause
"""Detector and tracker with noise, against theory [Vrba 2025, Table V and Fig. 11]

Three flights of 400 s with the noise of eq. (66). Theory is the bias at the same distance, which is the mean error of
detection-ideal, plus the noise of the pose. A detection is the mean of many points of one sweep: they share the noise of the pose,
and that of the range averages out.
"""
import math

import numpy as np
import swiftlet
from shared.detection import covariances_m2, draw_by_distance, fly_agile, visible

FEWEST = 30  # detections that a bin needs to be compared with theory
SAMPLES = 1000000  # draws of the noise, for the mean of its norm


def theory_with_bias_m(range_m, bias_m):
    """Mean of |bias + noise| [m], the bias along the ray towards the sensor."""
    sigma_m = np.sqrt(np.diagonal(covariances_m2([range_m], sigma_range_m=0.0)[0]))
    noise_m = sigma_m * np.random.default_rng(1).standard_normal((SAMPLES, 3))
    return float(np.linalg.norm(noise_m - [bias_m, 0.0, 0.0], axis=1).mean())


def run(experiment):
    noisy = fly_agile(experiment, "detection_noisy", 400.0)
    ideal = fly_agile(experiment, "detection_ideal", 355.0)
    detections, tracks = visible(noisy, "detector"), visible(noisy, "tracker")
    exact = visible(ideal, "detector").bins()
    expected_m, off = {}, {}  # keys: middle of the distance bin [m]
    for middle_m, there in detections.bins().items():
        if middle_m in exact and min(there.found.sum(), exact[middle_m].found.sum()) >= FEWEST:
            expected_m[middle_m] = theory_with_bias_m(middle_m, float(exact[middle_m].errors_m().mean()))
            off[middle_m] = abs(float(there.errors_m().mean()) / expected_m[middle_m] - 1.0)
    worst_m = max(off, key=off.get, default=math.nan)
    experiment.at_most("mean error against theory plus bias, worst distance [share]", off.get(worst_m, math.nan), 0.20, 2,
                       f"at {worst_m:g} m, of {len(off)} distances with {FEWEST} detections or more; the bias is that of the "
                       "flights without noise")
    experiment.claim("recall of the tracker above the detector's", f"{tracks.recall():.3f} against {detections.recall():.3f}",
                     tracks.recall() >= detections.recall())
    for stage, sightings in (("detections", detections), ("tracks", tracks)):
        error_m = float(sightings.errors_m().mean())
        experiment.row(f"mean position error of {stage} [m]", f"{error_m:.3f}", value=error_m)
    ranges_m = np.arange(0.0, 61.0)
    draw_by_distance(experiment, {"noise": noisy, "no noise": ideal}, [
        ("theory: noise alone", ranges_m, swiftlet.functions.error_means_m(covariances_m2(ranges_m))),
        ("theory and bias", list(expected_m), list(expected_m.values()))])
