# SPDX-License-Identifier: BSD-3-Clause
"""Ten and more vehicles cross a sphere [Kamler 2025, sec. 2.4]

Neighbors are measured as by UVDAR or are perfect, as in rbl-circle. A sphere of 5 m does not fit between the height limits of
Table 2.2 (1 to 10 m), so the sphere is at 20 m and the upper limit at 40 m. Times are not compared, because the published flights use
another reference tracker. The z-rule gains nothing, because the goals differ in height already. Spheres of 10 m with 30 and 60
vehicles are beyond the document: in a crowd of 60 the wakes of higher vehicles push the lowest one to the ground in most flights;
no two touch.
"""
from rbl_circle import fly_case, check_safety, compare_table, thesis
from shared.crossing import HEIGHT_M, write_flights
from shared.statistics import mean_and_deviation

VARIANTS = ("3d", "3d_z")
LIMITS = {"z_min_m": 1.0, "z_max_m": 2.0 * HEIGHT_M["sphere"]}  # [m] heights in which the cells lie


def run(experiment):
    seeds = experiment.repetitions(100, 2)
    crowds = experiment.repetitions(10, 1)
    flown = []
    for radius_m in (5.0, 10.0):
        for variant in VARIANTS:
            guidance = {**thesis(variant), **LIMITS}
            if radius_m == 5.0:  # the published radius
                flown.append(fly_case(experiment, seeds, "sphere", 10, radius_m, guidance))
                compare_table(experiment, flown[-1])
            flown.append(fly_case(experiment, seeds, "sphere", 10, radius_m, guidance, perfect=True))
            check_safety(experiment, flown[-1])
    team, crowd = (fly_case(experiment, crowds, "sphere", n, 10.0, {**thesis("3d_z"), **LIMITS}, perfect=True) for n in (30, 60))
    check_safety(experiment, team)
    ours = f"{crowd.success:.2f}"
    if crowd.success > 0.0:
        ours += f"; {mean_and_deviation(crowd.length_m)[0]:.2f}, {mean_and_deviation(crowd.time_s)[0]:.2f}"
    experiment.row(f"{crowd.name}: success [-]; L [m], t [s]", ours, value=crowd.success,
                   note=f"perfect neighbors; beyond the limit; least distance {crowd.least_distance_m:.2f} m")
    write_flights(experiment, [*flown, team, crowd])
