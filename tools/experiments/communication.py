# SPDX-License-Identifier: BSD-3-Clause
"""Rates and sizes of messages while guiding [Pritzl 2024, Table IV and Fig. 9]

Messages over the simulated radio with headers, sent while the guided vehicle flies along its path, in flights through a gap and
through forests.
"""
import swiftlet
from shared.guidance import GUIDING

SENDERS = {"path for the secondary": 0, "odometry of the secondary": 1}  # numbers of the vehicles
BIN_BYTES = 16  # width of a bin of the histogram


def listen(source, changes):
    """guided_s: time of guiding; sizes_bytes: of the messages of each sender in that time."""
    scenario = swiftlet.load(source, changes)
    simulator = swiftlet.Simulator(scenario, threads=1)
    guide = simulator.vehicle(0)
    guided_s, sizes_bytes, before_bytes = 0.0, {name: [] for name in SENDERS}, dict.fromkeys(SENDERS, 0)
    while not simulator.finished:
        simulator.tick()
        topics = simulator.summary()["radio"]["topics"]  # totals since the start, also of messages that are lost
        sent_bytes = {name: sum(topic["bytes"] for topic in topics if topic["from"] == sender) for name, sender in SENDERS.items()}
        if guide.mission_note == GUIDING:
            guided_s += scenario.tick_s
            for name in SENDERS:
                if sent_bytes[name] > before_bytes[name]:
                    sizes_bytes[name].append(sent_bytes[name] - before_bytes[name])
        before_bytes = sent_bytes
    return {"guided_s": guided_s, "sizes_bytes": sizes_bytes}


def draw(path_bytes):
    from matplotlib.figure import Figure
    figure = Figure(figsize=(7, 4))
    axes = figure.add_subplot(title="Sizes of the path messages (Fig. 9)", xlabel="size [bytes]", ylabel="messages")
    axes.hist(path_bytes, bins=range(0, max(path_bytes) + BIN_BYTES + 1, BIN_BYTES))
    return figure


def run(experiment):
    scenarios = ["guided_gap"] if experiment.quick else ["guided_gap", "forest_guidance"]
    flights = experiment.map(listen, [{"source": source, "changes": {"seed": seed}}
                                      for seed in range(1, experiment.repetitions(3, 1) + 1) for source in scenarios])
    guided_s = sum(flight["guided_s"] for flight in flights)
    sizes_bytes = {name: sum((flight["sizes_bytes"][name] for flight in flights), []) for name in SENDERS}
    for name in ("odometry of the secondary", "path for the secondary"):
        rate_hz, most_kB = len(sizes_bytes[name]) / guided_s, max(sizes_bytes[name]) / 1000
        experiment.within(f"{name}: rate [Hz]", rate_hz, 0.05, 3, f"{guided_s:.0f} s of guiding in {len(flights)} flights")
        for what, ours in (("smallest [kB]", min(sizes_bytes[name]) / 1000), ("largest [kB]", most_kB),
                           ("most a second [kB/s]", rate_hz * most_kB)):
            experiment.at_most(f"{name}: {what}", ours, experiment.published(f"{name}: {what}").value, 3)
    experiment.write_csv("messages.csv", ["message", "bytes"], [[name, size] for name in SENDERS for size in sizes_bytes[name]])
    experiment.write_figure("communication.svg", draw(sizes_bytes["path for the secondary"]))
