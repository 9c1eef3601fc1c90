# SPDX-License-Identifier: BSD-3-Clause
"""Detector and tracker with noise, against theory [Vrba 2025, Table V and Fig. 11]

Three flights of 400 s with the noise of eq. (66) in the estimated pose and the ranges. The expected error at a
distance follows from the mean error of detection-ideal, as a bias, and the noise of the pose. The noise of the range
is left out, because a detection is the mean of many points of one sweep: its points share the error of the pose,
whereas their range errors average out.
"""
import math

import numpy as np
import swiftlet
from shared.detection import covariances_m2, draw_by_distance, fly_agile, visible

MIN_DETECTIONS = 30  # least number of detections in a distance bin for its comparison with theory
SAMPLES = 1000000  # number of draws for the mean of a norm; more reduce its random error


def theory_with_bias_m(range_m, bias_m):
    """Expected error of a detection [m]: mean of |bias + noise of the pose|; the bias points to the sensor."""
    sigma_m = np.sqrt(np.diagonal(covariances_m2([range_m], sigma_range_m=0.0)[0]))
    noise_m = sigma_m * np.random.default_rng(1).standard_normal((SAMPLES, 3))
    return float(np.linalg.norm(noise_m - [bias_m, 0.0, 0.0], axis=1).mean())


def run(experiment):
    noisy = fly_agile(experiment, "detection_noisy", 400.0)
    ideal = fly_agile(experiment, "detection_ideal", 355.0)
    detections, tracks = visible(noisy, "detector"), visible(noisy, "tracker")
    without_noise = visible(ideal, "detector").bins()
    expected_m, deviations = {}, {}  # keys: middle of the distance bin [m]
    for middle_m, with_noise in detections.bins().items():
        if middle_m not in without_noise:
            continue
        if min(with_noise.found.sum(), without_noise[middle_m].found.sum()) >= MIN_DETECTIONS:
            expected_m[middle_m] = theory_with_bias_m(middle_m, float(without_noise[middle_m].errors_m().mean()))
            deviations[middle_m] = abs(float(with_noise.errors_m().mean()) / expected_m[middle_m] - 1.0)
    worst_m = max(deviations, key=deviations.get, default=math.nan)
    experiment.at_most("mean error against theory plus bias, worst distance [share]",
                       deviations.get(worst_m, math.nan), 0.20, 2,
                       f"at {worst_m:g} m, of {len(deviations)} distances with {MIN_DETECTIONS} detections or more; "
                       "the bias is that of the flights without noise")
    experiment.claim("recall of the tracker above the detector's",
                     f"{tracks.recall():.3f} against {detections.recall():.3f}", tracks.recall() >= detections.recall())
    for stage, sightings in (("detections", detections), ("tracks", tracks)):
        error_m = float(sightings.errors_m().mean())
        experiment.row(f"mean position error of {stage} [m]", f"{error_m:.3f}", value=error_m)
    ranges_m = np.arange(0.0, 61.0)
    draw_by_distance(experiment, {"noise": noisy, "no noise": ideal}, [  # theory by eq. (66), without and with the bias
        ("theory: noise alone", ranges_m, swiftlet.functions.error_means_m(covariances_m2(ranges_m))),
        ("theory and bias", list(expected_m), list(expected_m.values()))])
