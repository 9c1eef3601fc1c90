# SPDX-License-Identifier: BSD-3-Clause
"""5 to 15 vehicles start on a circle and cross to the opposite points, in 2D and 3D [Kamler 2025, sec. 2.4]

Each case is flown with neighbors measured as by UVDAR, and with perfect neighbors, which are measured without error.
The document flies each case ten times. Its text gives a radius of the circle of 5 m, but its path lengths are possible
only with 10 m. Times are not compared, because the published flights use another reference tracker. With 15 vehicles,
the z-rule saves no time over clipped 3D, unlike in the document: here, clipped 3D is already 15 % faster than 2D, there
9 %.
"""
import math

from shared.crossing import Crossings, write_flights
from shared.tables import short_number
from shared.statistics import mean_and_deviation

RADIUS_M = 10.0
NUMBERS = (5, 10, 15)  # numbers of vehicles
VARIANTS = ("2d", "3d", "3d_clipped", "3d_z")  # keys of RBL's `variant`
# [m] Smallest permitted distance between the centers of two vehicles: twice the encumbrance, the radius of the space
# that a vehicle needs for itself.
SAFE_DISTANCE_M = 1.0
NORMAL_95 = 1.96  # [sigma] half-width of the central 95 % of a normal distribution


def thesis(variant):
    """Configuration of RBL guidance with the parameters of the document."""
    return {"type": "rbl", "model": "rbl_thesis", "variant": variant, "cells": {"step_m": 0.35}}


def fly_case(experiment, seeds, shape, num_vehicles, radius_m, guidance, **options):
    """Flies a crossing with each seed from 1 to `seeds`. options: perfect and poles of shared.crossing.fly_crossing."""
    name = f"{shape} N={num_vehicles} R={radius_m:g} {guidance['variant']}"
    return Crossings(experiment, seeds, name, shape=shape, num_vehicles=num_vehicles, radius_m=radius_m,
                     guidance=guidance, **options)


def compare_table(experiment, case):
    """Compares a case with its line in the document's tables: path length, time and time of the slowest vehicle.

    Values within 10 % of the published ones are reproduced. Smaller lengths are better; smaller times prove nothing.
    """
    experiment.at_least(f"{case.name}: success [-]", case.success, 1.0, 3,
                        f"{len(case.flights)} flights, least distance {case.least_distance_m:.2f} m")
    for column, samples in (("L [m]", case.length_m), ("t [s]", case.time_s), ("t_max [s]", case.slowest_s)):
        what = f"{case.name}: {column}"
        mean, deviation, count = mean_and_deviation(samples)
        ratio = mean / experiment.published(what).value
        verdict_if_less = "better" if column == "L [m]" else "other conditions"
        ours = f"{mean:.2f} ± {deviation:.2f}" if count > 1 else short_number(mean, 4)
        experiment.row(what, ours, verdict_if_less if ratio < 0.9 else "reproduced" if ratio < 1.1 else "differs",
                       value=mean, tolerance="+ 10 %")


def check_safety(experiment, case):
    """Checks that vehicles with perfect neighbors keep SAFE_DISTANCE_M and reach their goals in all flights."""
    experiment.claim(f"{case.name}, perfect neighbors: least distance [m], success [-]",
                     f"{case.least_distance_m:.3f}, {case.success:.2f}",
                     case.least_distance_m >= SAFE_DISTANCE_M and case.success == 1.0,
                     "1.0: the sum of the encumbrances")


def compare_gain(experiment, what, fast, slow):
    """Compares the time that case `fast` saves over case `slow`, in percent, with the published saving.

    Flights of both cases with the same seed have the same starts and are paired. Only the sign is compared, and only if
    the 95 % confidence interval does not contain zero.
    """
    gains_percent = [100.0 * (1.0 - fast.mean_time_s[seed] / time_s) for seed, time_s in slow.mean_time_s.items()
                     if seed in fast.mean_time_s]
    gain_percent, deviation_percent, count = mean_and_deviation(gains_percent)
    half_interval_percent = NORMAL_95 * deviation_percent / math.sqrt(max(count, 1))
    significant = abs(gain_percent) > half_interval_percent
    same_sign = gain_percent * experiment.published(what).value > 0.0
    experiment.row(what, f"{gain_percent:.1f} ± {half_interval_percent:.1f}",
                   ("reproduced" if same_sign else "differs") if significant else "other conditions",
                   "95 % confidence interval" + ("" if significant else ", which contains zero"), value=gain_percent,
                   tolerance="same sign")


def run(experiment):
    seeds = experiment.repetitions(100, 2)
    cases = {(n, variant): fly_case(experiment, seeds, "circle", n, RADIUS_M, thesis(variant))
             for n in NUMBERS for variant in VARIANTS}
    for case in cases.values():
        compare_table(experiment, case)
    mean_s = {key: mean_and_deviation(case.time_s)[0] for key, case in cases.items()}
    experiment.at_least("N=15: 3D with z-rule faster than 2D by [%]",
                        100.0 * (1.0 - mean_s[15, "3d_z"] / mean_s[15, "2d"]), 4.0, 3,
                        "12.5 % by the published mean times")
    for n in (10, 15):
        compare_gain(experiment, f"N={n}: 3D with z-rule faster than 3D clipped by [%]", cases[n, "3d_z"],
                     cases[n, "3d_clipped"])
    perfect = [fly_case(experiment, seeds, "circle", n, RADIUS_M, thesis(variant), perfect=True)
               for n in NUMBERS for variant in VARIANTS]
    for case in perfect:
        check_safety(experiment, case)
    write_flights(experiment, [*cases.values(), *perfect])
    published_s = {key: experiment.published(f"{case.name}: t [s]").value for key, case in cases.items()}
    experiment.write_figure("rbl-circle.svg", draw_times({"published": published_s, "ours": mean_s}))


def draw_times(panels):
    """Plots the mean time against the number of vehicles. panels: {title: {(number, variant): time [s]}}."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=(7, 3.5))
    for axes, (title, times_s) in zip(figure.subplots(1, 2, sharey=True), panels.items()):
        for variant in VARIANTS:
            axes.plot(NUMBERS, [times_s[n, variant] for n in NUMBERS], marker="o", label=variant)
        axes.set(title=title, xlabel="vehicles", xticks=NUMBERS, ylim=(0, None))
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel("mean time to the goal [s]")
    figure.axes[1].legend(loc="lower right")
    return figure
