# SPDX-License-Identifier: BSD-3-Clause
"""A batch over wind and seeds in worker processes, its table, and its plot where matplotlib is installed.

    python3 examples/python/batch_plot.py [PICTURE.png]
"""
import sys

import numpy as np

import swiftlet

WINDS_MPS = (0.0, 4.0, 8.0)
SEEDS = (1, 2, 3)


def fly():
    runs = [{"wind.mean_mps": [wind, 0, 0], "seed": seed, "duration_s": 6} for wind in WINDS_MPS for seed in SEEDS]
    return swiftlet.fly_many("square", runs)


def plot(rows, path):
    try:
        import matplotlib
    except ImportError:
        print("matplotlib is not installed: no picture")
        return
    matplotlib.use("Agg")
    from matplotlib import pyplot
    pyplot.plot([r["wind.mean_mps"][0] for r in rows], [r["tracking_error_max_m.uav"] for r in rows], "o")
    pyplot.xlabel("mean wind [m/s]")
    pyplot.ylabel("greatest tracking error [m]")
    pyplot.savefig(path)
    print(f"written: {path}")


if __name__ == "__main__":  # the workers import this file
    rows = fly()
    for wind in WINDS_MPS:
        errors_m = [r["tracking_error_max_m.uav"] for r in rows if r["wind.mean_mps"][0] == wind]
        print(f"wind {wind:3.0f} m/s: {np.mean(errors_m):.3f} m off at most, mean of {len(errors_m)} seeds")
    try:
        print(rows.to_frame()[["seed", "state_hash"]].describe())
    except ImportError:
        print("pandas is not installed: rows are dicts")
    assert len({r["state_hash"] for r in rows}) == len(rows)
    if len(sys.argv) > 1:
        plot(rows, sys.argv[1])
