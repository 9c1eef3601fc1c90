# SPDX-License-Identifier: BSD-3-Clause
"""A map that never clears locks the vehicle in [Kamler 2025, sec. 3.4]

UAVs that pass leave occupied cells, which lock the vehicle in unless the map clears them.
"""


def run(experiment):
    seeds = range(1, experiment.repetitions(10, 1) + 1)
    miss = "vehicles[0].agent.mapping.p_miss"
    rows, arrived = [], {}
    for name, changes in (("conservative", {miss: 0.5}), ("forgets", {})):
        flights = experiment.fly("reproduce/rbl_ghosts", [{"seed": seed, **changes} for seed in seeds])
        times_s = [flight.get("time_to_done_s.uav1") for flight in flights]
        rows += [[name, seed, int(time_s is not None), time_s] for seed, time_s in zip(seeds, times_s)]
        arrived[name] = sum(time_s is not None for time_s in times_s) / len(seeds)
    experiment.claim("a map that never clears locks the vehicle in", f"{100 * arrived['conservative']:.0f} % arrive",
                     arrived["conservative"] == 0.0, "sec. 3.4, leaves mapped as obstacles")
    experiment.claim("a map that forgets does not", f"{100 * arrived['forgets']:.0f} % arrive", arrived["forgets"] == 1.0)
    experiment.write_csv("ghosts.csv", ["map", "seed", "arrived", "time_s"], rows)
