# SPDX-License-Identifier: BSD-3-Clause
"""PACNav and the vision-based model beside RBL [Kamler 2025, sec. 2.5]

Ten vehicles cross the circle of rbl-circle with perfect neighbors, by PACNav [Ahmad 2022] and the vision-based model [Mezey 2024].
rbl-circle flies RBL under the same conditions. The document publishes no figures. Uninformed vehicles of PACNav follow a neighbor
and have no goal of their own, so not all of them reach the goal that is counted here. The vision-based model is made for flocks
that move together. It guarantees no distance, and vehicles touch.
"""
from shared.crossing import Crossings, write_flights
from shared.statistics import mean_and_deviation

NUM_VEHICLES = 10
RADIUS_M = 10.0
UNINFORMED = {f"vehicles[{i}].agent.guidance.informed": False for i in range(1, NUM_VEHICLES, 2)}  # every second vehicle
METHODS = {"PACNav, all informed": ("pacnav", {}),  # type of the guidance, changes of the scenario
           "PACNav, every second informed": ("pacnav", UNINFORMED),
           "vision-based": ("mezey", {})}


def run(experiment):
    seeds = experiment.repetitions(100, 1)
    cases = []
    for method, (guidance, changes) in METHODS.items():
        case = Crossings(experiment, seeds, f"circle N={NUM_VEHICLES}, {method}", shape="circle", num_vehicles=NUM_VEHICLES,
                         radius_m=RADIUS_M, guidance={"type": guidance}, perfect=True, changes=changes)
        experiment.row(f"{case.name}: success [-]", f"{case.success:.2f}", value=case.success,
                       note=f"{100 * case.arrived:.0f} % of the vehicles arrive, contact in {100 * case.contact:.0f} % of the "
                            f"flights, least distance {case.least_distance_m:.2f} m")
        if case.success > 0.0:
            time_s = mean_and_deviation(case.time_s)[0]
            experiment.row(f"{case.name}: L [m], t [s]", f"{mean_and_deviation(case.length_m)[0]:.2f}, {time_s:.2f}", value=time_s,
                           note="of the flights that succeeded")
        cases.append(case)
    write_flights(experiment, cases)
