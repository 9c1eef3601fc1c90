# SPDX-License-Identifier: BSD-3-Clause
"""Effect of reflectivity on the lower recall of real flights [Vrba 2025, Fig. 11]

The same three flights with and without the returns that a dark, oblique or far surface does not give back. Up to 20 m they make no
difference; the difference grows with the distance.
"""
import numpy as np
import swiftlet
from shared.detection import covariances_m2, draw_by_distance, fly_agile, visible


def run(experiment):
    modeled = fly_agile(experiment, "detection_real", 375.0)
    kept = fly_agile(experiment, "detection_real", 375.0, {"vehicles[0].sensors[0].detection.always": True})
    ours, without = visible(modeled, "detector").recall(), visible(kept, "detector").recall()
    experiment.claim("recall below the simulation in which every return is kept", f"{ours:.3f} against {without:.3f}",
                     ours < without, "the same flights with and without returns lost to reflectivity and range")
    ranges_m = np.arange(0.0, 46.0)
    draw_by_distance(experiment, {"modeled returns": modeled, "every return kept": kept}, [
        ("theory: noise alone", ranges_m, swiftlet.functions.error_means_m(covariances_m2(ranges_m)))])
