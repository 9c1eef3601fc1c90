# SPDX-License-Identifier: BSD-3-Clause
"""Corrections of closures, blended in three forms and at once [Orsulic 2021, Figs. 1 and 2]

A correction of 1 m is blended in three forms, by their equations. Then vehicles circle a building twice and close their loops.
Eq. 2 as printed moves the pose by 7 % of the correction at once, and as the authors released it by 1.1 %. The limited form, a
polynomial of fifth degree, has no step, and at most 0.25 m/s and 0.1 m/s².
In two of the four flights shown, local SLAM drifts by 3 m along a bare wall in the second lap, and reports that it is
degenerate: the LiDAR reaches 15 m.
"""
import numpy as np
from shared.tables import short_number
from shared.slam import fly_on_slam

SCENARIO = "campus_closure"
FORMS = {"none": "at once", "printed": "eq. 2 as printed", "released": "eq. 2 as released", "limited": "limited"}
STEEPNESS, MIDDLE_S, WINDOW_S = 1.5, 3.0, 7.0  # [Orsulic 2021, eq. 2]
SPEED_MAX_MPS, ACCELERATION_MAX_MPS2, JERK_MAX_MPS3 = 0.25, 0.1, 0.15  # limits of the limited form: keys of global.blend
STEP_S = 1e-3  # time step of the computed corrections
STEP_MAX_M = 1e-5  # within a tick: no step


def blend(form, distance_m=1.0):
    """(times [s], remaining part of a correction [m]) until nothing remains."""
    if form == "limited":  # from rest to rest, with the peaks of speed, acceleration and jerk of 10 s^3 - 15 s^4 + 6 s^5
        whole_s = 1.001 * max(1.875 * distance_m / SPEED_MAX_MPS, (10 / 3**0.5 * distance_m / ACCELERATION_MAX_MPS2)**0.5,
                              (60 * distance_m / JERK_MAX_MPS3)**(1 / 3))
    else:
        whole_s = WINDOW_S
    t_s = STEP_S * np.arange(np.ceil(whole_s / STEP_S) + 1)
    if form == "limited":
        s = t_s / whole_s
        left = 1 - s**3 * (10 - 15 * s + 6 * s**2)
    elif form == "printed":
        left = 1 / (1 + STEEPNESS * np.exp(t_s - MIDDLE_S))
    else:
        left = 1 / (1 + np.exp(STEEPNESS * (t_s - MIDDLE_S)))
    left[-1] = 0.0
    return t_s, distance_m * left


def compare_blends(experiment):
    for form in ("printed", "released", "limited"):
        t_s, left_m = blend(form)
        at_once_percent = 100 * (1 - left_m[0])
        v_mps = np.diff(left_m[:-1]) / STEP_S
        note = (f"{100 * left_m[-2]:.2f} % more in the end; at most {abs(v_mps).max():.3f} m/s and "
                f"{abs(np.diff(v_mps)).max() / STEP_S:.3f} m/s^2 in between")
        what = f"{FORMS[form]}: share of a correction of 1 m applied at once [%]"
        if form == "limited":
            experiment.at_most(what, at_once_percent, 0.001, 3, note)
            experiment.within("time over which a correction is spread [s]", t_s[-1], 0.15, 2, "1 m, the limited form")
        else:
            experiment.row(what, short_number(at_once_percent, 3), note=note, value=at_once_percent)


def compare_flights(experiment, flights):
    """flights: by the form."""
    for form, its in flights.items():
        worst = {name: max(flight[name] for flight in its) for name in ("largest_m", "step_m", "speed_mps", "acceleration_mps2")}
        note = (f"{len(its)} flights; corrections of up to {worst['largest_m']:.2f} m; at most {worst['speed_mps']:.3f} m/s and "
                f"{worst['acceleration_mps2']:.3f} m/s^2 otherwise")
        if form == "limited":
            experiment.claim("steps in the pose when a loop is closed", f"at most {worst['step_m']:.1e} m",
                             worst["step_m"] < STEP_MAX_M, note)
            experiment.at_most("limited: speed of the correction in flight [m/s]", worst["speed_mps"], SPEED_MAX_MPS, 3)
            experiment.at_most("limited: acceleration of the correction in flight [m/s^2]", worst["acceleration_mps2"],
                               ACCELERATION_MAX_MPS2, 3)
        else:
            experiment.row(f"{FORMS[form]}: largest step of the pose [m]", short_number(worst["step_m"], 3), note=note,
                           value=worst["step_m"])
    flown = sum(flights.values(), [])
    experiment.at_most("contacts", sum(flight["outcome"] == "crashed" for flight in flown), 0, 1, f"{len(flown)} flights")


def draw(experiment, flights):
    from matplotlib.figure import Figure
    blends = Figure(figsize=(7, 4))
    axes = blends.subplots()
    for form in ("printed", "released", "limited"):
        axes.plot(*(values[::50] for values in blend(form)), label=FORMS[form])
    axes.set(title="Blending of a correction of 1 m (Fig. 2)", xlabel="time since the correction [s]",
             ylabel="remaining correction [m]")
    axes.legend()
    experiment.write_figure("safe-loop-closure-blend.svg", blends)

    rounds = Figure(figsize=(7, 6))
    height, place = rounds.subplots(2, sharex=True)
    for form, its in flights.items():
        course = its[0]["course"]
        off_m = np.subtract(course["p_shown_m"], course["p_true_m"])
        height.plot(course["t_s"], off_m[:, 2], label=FORMS[form])
        place.plot(course["t_s"], np.hypot(off_m[:, 0], off_m[:, 1]))
    height.set(title="Two laps around the building: error of the published position (Fig. 1)", ylabel="height [m]")
    place.set(xlabel="time [s]", ylabel="horizontal [m]")
    height.legend()
    experiment.write_figure("safe-loop-closure.svg", rounds)


def run(experiment):
    seeds = experiment.repetitions(20, 1)
    runs = []
    for form in FORMS:  # the limited form has more flights, to bound the probability of a contact
        count = 5 * seeds if form == "limited" and not experiment.quick else seeds
        runs += [(form, seed) for seed in range(1, count + 1)]
    flown = experiment.map(fly_on_slam, [{"source": SCENARIO, "changes": {
        "seed": seed, "vehicles[0].agent.localization.global.blend.form": form}} for form, seed in runs])
    flights = {form: [flight for (its_form, _), flight in zip(runs, flown) if its_form == form] for form in FORMS}
    compare_blends(experiment)
    compare_flights(experiment, flights)
    columns = ["outcome", "corrections", "largest_m", "step_m", "speed_mps", "acceleration_mps2", "rms_local_after_m",
               "rms_after_m"]
    experiment.write_csv("flights.csv", ["form", "seed", *columns],
                         [[form, seed, *(flight[column] for column in columns)] for (form, seed), flight in zip(runs, flown)])
    draw(experiment, flights)
