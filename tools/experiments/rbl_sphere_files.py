# SPDX-License-Identifier: BSD-3-Clause
"""rbl-sphere with the settings of its authors' experiment files [Kamler 2025, sec. 2.4]

Samples, planes, rates, thresholds and signs are those of the authors' files, where known. Starts are spread from pole to pole;
other conditions are as in rbl-sphere. The two vehicles at the poles meet on one vertical line, and one or both of them often miss
their goals, so success differs. With the starts of rbl-sphere, off the poles, all ten arrive.
"""
from rbl_circle import fly_case, compare_gain, compare_table
from rbl_circle_files import files
from rbl_sphere import LIMITS, VARIANTS
from shared.crossing import write_flights


def run(experiment):
    seeds = experiment.repetitions(100, 2)
    cases = {variant: fly_case(experiment, seeds, "sphere", 10, 5.0, {**files(variant), **LIMITS}, poles=True)
             for variant in VARIANTS}
    for case in cases.values():
        compare_table(experiment, case)
    compare_gain(experiment, "N=10: 3D with z-rule faster than 3D by [%]", cases["3d_z"], cases["3d"])
    write_flights(experiment, cases.values())
