# SPDX-License-Identifier: BSD-3-Clause
"""Processor time of planning for two vehicles [Pritzl 2024, sec. III-B]

Plans of the guide during five flights of 32 m through forests, on a map of 0.1 m, on one core of another computer than the
published one, so the tolerance is a factor. The time of a plan is the processor time of the tick in which the guide plans; one tick
in 25 also completes a scan, which adds up to 0.05 s. The stages of algorithm 1 are not timed apart.
"""
import time

import numpy as np
import swiftlet
from shared.tables import short_number

WHAT = "algorithm 1 [s]"
TIMES_FASTER = 8.9 / 0.3  # limit: a plan takes at most 0.3 s
PLANNING, PLANNED = "planning", ("primary moving", "secondary moving", "goal reached")  # notes of the guide's mission
LATENCY = "vehicles[0].agent.guidance.planning_latency_s"


def time_plans(changes):
    """plans_s: processor time of each plan; failed: number of plans without a path."""
    # Without a latency the guide takes a plan in the tick after the one that makes it.
    simulator = swiftlet.Simulator(swiftlet.load("forest_guidance", {LATENCY: 0, **changes}), threads=1)
    guide, note, tick_s, plans_s, failed = simulator.vehicle(0), "", 0.0, [], 0
    while not simulator.finished:
        before_s, start_s = tick_s, time.thread_time()
        simulator.tick()
        tick_s = time.thread_time() - start_s
        if note == PLANNING and guide.mission_note != PLANNING and not guide.mission_note.startswith("hovering"):
            plans_s.append(before_s)
            failed += guide.mission_note not in PLANNED
        note = guide.mission_note
    return {"plans_s": plans_s, "failed": failed}


def draw(plans_s, published_s):
    from matplotlib.figure import Figure
    figure = Figure(figsize=(7, 4))
    axes = figure.add_subplot(title="Time of a plan, algorithm 1 (sec. III-B)", xlabel="time [s]", ylabel="plans", xscale="log")
    axes.hist(plans_s, bins=np.geomspace(min(plans_s), max(plans_s), 21), label="ours")
    axes.axvline(published_s, color="black", linestyle="--", label="published")
    axes.legend()
    return figure


def run(experiment):
    shorter = {"duration_s": 40} if experiment.quick else {}
    seeds = range(1, experiment.repetitions(5, 1) + 1)
    flights = experiment.map(time_plans, [{"changes": {"seed": seed, **shorter}} for seed in seeds])
    plans_s = sum((flight["plans_s"] for flight in flights), [])
    median_s, published_s = float(np.median(plans_s)), experiment.published(WHAT).value
    failed = sum(flight["failed"] for flight in flights)
    experiment.row(WHAT, short_number(median_s, 2), "other conditions" if TIMES_FASTER * median_s <= published_s else "differs",
                   f"median of {len(plans_s)}, at most {max(plans_s):.3f} s; {failed} plans failed", value=median_s,
                   tolerance=f"{TIMES_FASTER:.3g} times faster")
    experiment.write_csv("guidance-timing.csv", ["seed", "plan_s"],
                         [[seed, plan_s] for seed, flight in zip(seeds, flights) for plan_s in flight["plans_s"]])
    experiment.write_figure("guidance-timing.svg", draw(plans_s, published_s))
