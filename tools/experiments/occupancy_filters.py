# SPDX-License-Identifier: BSD-3-Clause
"""Multi-state map against log-odds while an object flies through [Vrba 2025, Fig. 3]

One voxel 10 m before an OS1-128 is empty, except for a flying object of 0.3 m from 2 s to 4.5 s. G(v) is the multi-state map of
the detector `vofod`, with the latencies of Table VI. L(v) is the log-odds map `occupancy` with OctoMap's parameters, without
latency. Both maps process the same scans.
"""
import numpy as np
import swiftlet

STEP_S, SCAN_STEPS = 0.02, 5  # step of the software [s], steps from scan to scan
END_S = 8.0  # end of the run
ENTERS_S, LEAVES_S = 2.0, 4.5  # times of the first scan with the object and of the first without it
OBJECT_RADIUS_M = 0.15  # sphere
VOXEL_M = np.array([10.125, 0.125, 0.125])  # center of the voxel and of the object; the LiDAR is at 0
STATES = ["free", "uncertain", "tentative", "confident"]  # eq. (7), as the detector's map names them
G_UNCERTAIN = -750.0  # confident free below [Vrba 2025, Table II]
G_UNKNOWN = -740.0  # value of the multi-state map where nothing is known [Vrba 2025, Table II]
RAY_MAX_M = 20.0  # beams without return clear up to this range [Vrba 2025, Table II]
L_OCCUPIED, L_FREE = 0.0, -0.4  # limits of confident occupied and confident free, eq. (5): even odds, below by one miss

# An OS1-128 of 1024 columns; the eighth with the voxel and the air around it, which the detector's rule B searches.
AZIMUTH_RAD = np.radians(np.arange(-64, 64) * 360 / 1024)
ELEVATION_RAD = np.radians(np.linspace(22.5, -22.5, 128))[:, None]
BEAMS = np.stack(np.broadcast_arrays(np.cos(ELEVATION_RAD) * np.cos(AZIMUTH_RAD), np.cos(ELEVATION_RAD) * np.sin(AZIMUTH_RAD),
                                     np.sin(ELEVATION_RAD)), axis=-1)


def software():
    """Detector and log-odds map of one vehicle; all other parameters are those of the paper and of OctoMap, the defaults."""
    agent = {"localization": {"type": "ground_truth"}, "detector": {"type": "vofod", "ray_max_m": RAY_MAX_M},
             "mapping": {"type": "occupancy", "edge_m": 0.25, "every_column": 1, "clear_range_m": RAY_MAX_M}}
    start = {"position_m": [0, 0, 0]}
    return swiftlet.Onboard(swiftlet.load({"vehicles": [{"start": start, "sensors": [{"type": "lidar"}], "agent": agent}]}))


def ranges_m(present):
    """Ranges to the surface of the object; 0 where there is no return."""
    along_m = BEAMS @ VOXEL_M
    inside_m2 = OBJECT_RADIUS_M**2 - (VOXEL_M @ VOXEL_M - along_m**2)
    return np.where((inside_m2 > 0) & (along_m > 0) & present, along_m - np.sqrt(np.maximum(inside_m2, 0)), 0)


def voxel(cells, unknown):
    """(value, name of the state) of the voxel; unknown: those of voxels at their first value, which are not listed."""
    at = np.flatnonzero(np.linalg.norm(cells["centers_local_m"] - VOXEL_M, axis=1) < 0.01)
    return (float(cells["value"][at[0]]), cells["states"][cells["state"][at[0]]]) if at.size else unknown


def fly():
    """[(t_s, G, state of G, L, state of L)] of the voxel after each scan."""
    vehicle, samples = software(), []
    for k in range(round(END_S / STEP_S)):
        t_s, t_ns = round(k * STEP_S, 3), round(k * STEP_S * 1e9)
        vehicle.add("pose", t_ns=t_ns, pose=np.eye(4), v_mps=np.zeros(3), omega_radps=np.zeros(3))
        if k % SCAN_STEPS == 0:
            vehicle.add_scan(swiftlet.make_scan(ranges_m(ENTERS_S <= t_s < LEAVES_S), BEAMS, t_ns, duration_s=0.0, T_body_lidar=np.eye(4)))
        vehicle.step(t_ns)
        if k % SCAN_STEPS == 0:
            maps = vehicle.maps()
            L, _ = voxel(maps["mapping"], (0.0, "unknown"))
            L_state = "confident" if L >= L_OCCUPIED else "free" if L <= L_FREE else "uncertain"
            samples.append((t_s, *voxel(maps["detector"], (G_UNKNOWN, "uncertain")), L, L_state))
    return samples


def draw(experiment, samples):
    from matplotlib.figure import Figure
    t_s, G, G_state, L, L_state = zip(*samples)
    figure = Figure(figsize=(7, 6))
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    top.set_title("A flying object in an empty voxel from 2 s to 4.5 s (Fig. 3)")
    top.step(t_s, L, "C1", where="post", label="log-odds L(v)")
    top.axhline(L_OCCUPIED, color="gray", linestyle=":", label="occupied")
    top.axhline(L_FREE, color="gray", linestyle="--", label="free")
    middle.step(t_s, G, "C0", where="post", label="multi-state G(v)")
    middle.axhline(G_UNCERTAIN, color="gray", linestyle="--", label="free below")
    for state, style, label in ((L_state, "C1--", "L(v)"), (G_state, "C0-", "G(v)")):
        bottom.step(t_s, [STATES.index(name) for name in state], style, where="post", label=label)
    bottom.set_yticks(range(len(STATES)), STATES)
    bottom.set_xlabel("time [s]")
    for panel, name in ((top, "L [-]"), (middle, "G [-]"), (bottom, "state")):
        panel.set_ylabel(name)
        panel.axvspan(ENTERS_S, LEAVES_S, color="C2", alpha=0.15)
        panel.legend(loc="upper left", bbox_to_anchor=(1, 1))
    experiment.write_figure("occupancy-filters.svg", figure)


def freed_after_s(samples, column):
    """Time from the first scan without the object to the first in which the voxel is confident free."""
    return next((sample[0] - LEAVES_S for sample in samples if sample[0] >= LEAVES_S and sample[column] == "free"), np.inf)


def run(experiment):
    samples = fly()
    experiment.write_csv("occupancy-filters.csv", ["t_s", "G", "G_state", "L", "L_state"], samples)
    draw(experiment, samples)
    G_confident, L_confident = (sum(sample[column] == "confident" for sample in samples) for column in (2, 4))
    experiment.claim("scans in which G(v) is confident occupied", str(G_confident), G_confident == 0)
    experiment.claim("scans in which L(v) is confident occupied", str(L_confident), L_confident > 0)
    G_s, L_s = freed_after_s(samples, 2), freed_after_s(samples, 4)
    experiment.claim("confident free again after it left: G(v) sooner than L(v)", f"{G_s:.1f} s against {L_s:.1f} s", G_s < L_s)
