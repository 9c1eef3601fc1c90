# SPDX-License-Identifier: BSD-3-Clause
"""10 to 60 vehicles start on a sphere and cross to the opposite points [Kamler 2025, sec. 2.4]

Neighbors are measured as by UVDAR or without error, as in rbl-circle. A sphere with a radius of 5 m does not fit
between the height limits of Table 2.2 (1 to 10 m), so its center is at 20 m and the upper limit is 40 m. Times are
not compared, because the published flights use another reference tracker. The z-rule saves no time, because starts
and goals differ in height already. Spheres with a radius of 10 m and teams of 30 and 60 vehicles are not in the
document. With 60 vehicles, the downwash of higher vehicles pushes the lowest one to the ground in most flights;
vehicles do not touch each other.
"""
from rbl_circle import fly_case, check_safety, compare_table, thesis
from shared.crossing import HEIGHT_M, write_flights
from shared.statistics import mean_and_deviation

VARIANTS = ("3d", "3d_z")
LIMITS = {"z_min_m": 1.0, "z_max_m": 2.0 * HEIGHT_M["sphere"]}  # [m] height limits of the vehicles' cells


def run(experiment):
    seeds = experiment.repetitions(100, 2)
    crowds = experiment.repetitions(10, 1)
    flown = []
    for radius_m in (5.0, 10.0):
        for variant in VARIANTS:
            guidance = {**thesis(variant), **LIMITS}
            if radius_m == 5.0:  # published, with neighbors measured as by UVDAR
                flown.append(fly_case(experiment, seeds, "sphere", 10, radius_m, guidance))
                compare_table(experiment, flown[-1])
            flown.append(fly_case(experiment, seeds, "sphere", 10, radius_m, guidance, perfect=True))
            check_safety(experiment, flown[-1])
    team, crowd = (fly_case(experiment, crowds, "sphere", n, 10.0, {**thesis("3d_z"), **LIMITS}, perfect=True) for n in (30, 60))
    check_safety(experiment, team)
    result = f"{crowd.success:.2f}"
    if crowd.success > 0.0:
        result += f"; {mean_and_deviation(crowd.length_m)[0]:.2f}, {mean_and_deviation(crowd.time_s)[0]:.2f}"
    experiment.row(f"{crowd.name}: success [-]; L [m], t [s]", result, value=crowd.success,
                   note=f"perfect neighbors; no published flights; least distance {crowd.least_distance_m:.2f} m")
    write_flights(experiment, [*flown, team, crowd])
