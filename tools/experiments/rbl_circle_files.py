# SPDX-License-Identifier: BSD-3-Clause
"""rbl-circle with the settings of its authors' experiment files [Kamler 2025, sec. 2.4]

Samples, planes, rates, thresholds and signs are those of the authors' files, where known. Other conditions are as in rbl-circle.
"""
from rbl_circle import NUMBERS, RADIUS_M, VARIANTS, fly_case, compare_gain, compare_table
from shared.crossing import write_flights

AZIMUTH_RETURN_2D_RADPS = 1.5  # [rad/s] at which the destination turns back in 2D; in 3D twice that


def files(variant):
    """Guidance by the settings of the authors' experiment files."""
    guidance = {"type": "rbl", "model": "rbl_thesis_files", "variant": variant}
    return {**guidance, "rules": {"azimuth_return_radps": AZIMUTH_RETURN_2D_RADPS}} if variant == "2d" else guidance


def run(experiment):
    seeds = experiment.repetitions(100, 2)
    flown = []
    for n in NUMBERS:
        cases = {variant: fly_case(experiment, seeds, "circle", n, RADIUS_M, files(variant)) for variant in VARIANTS}
        for case in cases.values():
            compare_table(experiment, case)
        for slow, name in (("2d", "2D"), ("3d_clipped", "3D clipped")):
            compare_gain(experiment, f"N={n}: 3D with z-rule faster than {name} by [%]", cases["3d_z"], cases[slow])
        flown += cases.values()
    write_flights(experiment, flown)
