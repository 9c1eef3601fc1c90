# SPDX-License-Identifier: BSD-3-Clause
"""rbl-circle on the radius of 5 m that the text prints [Kamler 2025, sec. 2.4]

Lengths and times are published for 10 m only. On 5 m, vehicles with perfect neighbors also keep the sum of two encumbrances,
1.0 m.
"""
from rbl_circle import NUMBERS, VARIANTS, fly_case, check_safety, thesis
from shared.crossing import write_flights

RADIUS_M = 5.0


def run(experiment):
    seeds = experiment.repetitions(100, 2)
    cases = [fly_case(experiment, seeds, "circle", n, RADIUS_M, thesis(variant), perfect=True)
             for n in NUMBERS for variant in VARIANTS]
    for case in cases:
        check_safety(experiment, case)
    write_flights(experiment, cases)
