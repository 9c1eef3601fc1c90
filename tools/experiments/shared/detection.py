# SPDX-License-Identifier: BSD-3-Clause
"""Flying-object detection against truth [Vrba 2025, eqs. 67 to 71]: vehicle 0 observes, all others are targets."""
import math

import numpy as np
import swiftlet

from shared.rotations import rotations

TRUE_POSITIVE_M = 3.0  # an estimate nearer than this to a target is a true positive [Vrba 2025, sec. V-A]
SAME_M = 1.0  # a track nearer than this follows the target
IGNORED_S = 10.0  # start of a flight that is not evaluated: rays must first clear the map
BIN_M, FARTHEST_M = 5.0, 90.0  # width of a bin of distance; sightings from here on are left out
FEWEST = 5  # sightings that a bin needs to be drawn
VEHICLE = 300  # class of vehicles in true_class
OS1_DEG, OS0_DEG, MID360_DEG = (-22.5, 22.5), (-45.0, 45.0), (-7.0, 52.0)  # lowest and highest beam

# One target in one scan. t_s: middle of the sweep; visible: in the vertical field of view, nothing in between; x_m, y_m, z_m: the
# target in the observer's estimate of the world; error_m, track, est_x_m ...: of the nearest estimate in that world; without
# any, the error is infinite.
COLUMNS = ["t_s", "target", "range_m", "visible", "x_m", "y_m", "z_m", "error_m", "track", "est_x_m", "est_y_m", "est_z_m"]


def pose(p_m, q_xyzw):
    """(4, 4) of a position and a quaternion."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotations(q_xyzw), p_m
    return T


def transformed(T, points_m):
    return points_m @ T[:3, :3].T + T[:3, 3]


def is_hidden(scan, p_world_m):
    """Does the beam that fires closest to the direction of this place end before it, at something other than a vehicle?"""
    T = scan.true_T_world_lidar
    d_lidar_m = np.einsum("cji,cj->ci", T[:, :3, :3], p_world_m - T[:, :3, 3])
    range_m = np.linalg.norm(d_lidar_m, axis=1)
    cosine = np.einsum("rci,ci->rc", scan.directions_lidar, (d_lidar_m / range_m[:, None]).astype(np.float32))
    row, col = np.unravel_index(np.argmax(cosine), cosine.shape)
    hit_m = scan.true_range_m[row, col]
    return bool(0.0 < hit_m < range_m[min(col, len(T) - 1)] and scan.true_class[row, col] != VEHICLE)


def targets_of(scan, fov_deg, truth):
    """The first seven columns of COLUMNS for each target."""
    T_world_body, T_believed_world, targets_m = truth
    T_lidar_world = np.linalg.inv(T_world_body @ scan.T_body_lidar)
    in_lidar_m, believed_m = transformed(T_lidar_world, targets_m), transformed(T_believed_world, targets_m)
    rows = []
    for i, p_m in enumerate(in_lidar_m):
        range_m = np.linalg.norm(p_m)
        in_view = fov_deg[0] < math.degrees(math.asin(p_m[2] / range_m)) < fov_deg[1]
        visible = in_view and not is_hidden(scan, targets_m[i])
        rows.append([scan.t_s + 0.5 * scan.duration_s, i, float(range_m), int(visible), *believed_m[i].tolist()])
    return rows


def fly_sightings(source, changes, fov_deg):
    """One flight from IGNORED_S on: {"detector": rows, "tracker": rows of COLUMNS, "reported": number of estimates of each of the
    two, "false": those far from every target, "tracks": identities}.

    The detector is evaluated on each scan that it processes, however late it reports; the tracker at each new scan, with the tracks
    of that instant.
    """
    scenario = swiftlet.load(source, changes)
    tick_ns = round(1e9 * scenario.tick_s)
    simulator = swiftlet.Simulator(scenario, threads=1)
    observer = simulator.vehicle(0)
    result = {"detector": [], "tracker": [], "reported": {"detector": 0, "tracker": 0}, "false": {"detector": 0, "tracker": 0}}
    truth = []  # per tick: pose of the observer, transformation to the estimated world, places of the targets
    newest = waiting = processed = None  # sightings of scans: the newest one; those of the detector
    tracks_due = False  # no tracks since the newest scan
    identities = set()

    def at(t_ns):  # the nearest tick, of two the earlier one
        return truth[max(0, min((int(t_ns) + (tick_ns - 1) // 2) // tick_ns - 1, len(truth) - 1))]

    def add(stage, rows, estimates):
        off_m = np.empty((len(estimates), len(rows)))
        for i, t_ns in enumerate(estimates.t_ns):
            _, T_believed_world, targets_m = at(t_ns)
            off_m[i] = np.linalg.norm(estimates.position_m[i] - transformed(T_believed_world, targets_m), axis=1)
        result["reported"][stage] += len(estimates)
        result["false"][stage] += int((off_m.min(axis=1) >= TRUE_POSITIVE_M).sum())
        for target, row in enumerate(rows):
            nearest = [math.inf, 0, math.nan, math.nan, math.nan]
            if len(estimates) > 0:
                i = int(np.argmin(off_m[:, target]))
                track = int(estimates.id[i]) if stage == "tracker" else 0
                nearest = [float(off_m[i, target]), track, *estimates.position_m[i].tolist()]
            result[stage].append(row + nearest)

    while not simulator.finished:
        simulator.tick()
        states, estimate = simulator.states, observer.estimate
        T_world_body = pose(states.position_m[0], states.q_xyzw[0])
        T_believed_world = estimate.correction_pose @ estimate.local_pose @ np.linalg.inv(T_world_body)
        truth.append((T_world_body, T_believed_world, states.position_m[1:].copy()))
        evaluated = simulator.t_s >= IGNORED_S
        for scan in observer.scans:
            newest = waiting = targets_of(scan, fov_deg, at(scan.t_ns + round(5e8 * scan.duration_s)))
            tracks_due = evaluated
        if observer.detections is not None:  # they belong to the scan that the detector took when it was last free
            if processed[0][0] >= IGNORED_S:
                add("detector", processed, observer.detections)
            processed = None
        if processed is None:
            processed, waiting = waiting, None
        if tracks_due and observer.has_tracks:
            tracks_due = False
            add("tracker", newest, observer.tracks)
            identities.update(observer.tracks.id.tolist())
    return {**result, "tracks": sorted(identities)}


def fly_agile(experiment, scenario, full_s, changes=None):
    """Flights of one observer and one target; the seed draws their trajectories as well."""
    return experiment.map(fly_sightings, [{
        "source": f"reproduce/{scenario}", "fov_deg": OS1_DEG,
        "changes": {"seed": seed, "duration_s": 40.0 if experiment.quick else full_s,
                    "vehicles[0].agent.guidance.seed": 2 * seed - 1, "vehicles[1].agent.guidance.seed": 2 * seed,
                    **(changes or {})}}
        for seed in range(1, experiment.repetitions(3, 1) + 1)])


class Sightings:
    """Columns of the sightings of one stage, as attributes, and `found`."""

    def __init__(self, rows):
        self.rows = np.array(rows, float).reshape(-1, len(COLUMNS))
        for name, column in zip(COLUMNS, self.rows.T):
            setattr(self, name, column)
        self.found = self.error_m < TRUE_POSITIVE_M

    def recall(self):
        return float(self.found.mean()) if len(self.found) else math.nan

    def errors_m(self):
        return self.error_m[self.found]

    def between(self, from_m, to_m):
        return Sightings(self.rows[(self.range_m >= from_m) & (self.range_m < to_m)])

    def bins(self):
        """{middle of the bin [m]: its sightings}, of bins with enough of them."""
        bins = {from_m + BIN_M / 2: self.between(from_m, from_m + BIN_M) for from_m in np.arange(0.0, FARTHEST_M, BIN_M)}
        return {middle_m: there for middle_m, there in bins.items() if len(there.found) >= FEWEST}


def visible(flights, stage):
    """The sightings of all flights in which the target is visible."""
    sightings = Sightings([row for flight in flights for row in flight[stage]])
    return Sightings(sightings.rows[sightings.visible > 0]).between(0.0, FARTHEST_M)


def draw_by_distance(experiment, cases, theory=()):
    """NAME.svg and NAME.csv, as [Vrba 2025, Fig. 11]: error and recall by distance; solid: detector, dashed: tracker, band:
    quartiles. cases: {name: flights}; theory: (label, distances [m], errors [m]) for each curve."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=(10, 4))
    errors, recall = figure.subplots(1, 2)
    rows = []
    for number, (name, flights) in enumerate(cases.items()):
        for stage, style in (("detector", "o-"), ("tracker", "s--")):
            look = {"color": f"C{number}", "markersize": 4, "label": stage + (f", {name}" if len(cases) > 1 else "")}
            bins = visible(flights, stage).bins()
            recall.plot(list(bins), [there.recall() for there in bins.values()], style, **look)
            rows += [[name, stage, middle_m - BIN_M / 2, middle_m + BIN_M / 2, len(there.found), there.recall(),
                      float(there.errors_m().mean()) if there.found.any() else math.nan] for middle_m, there in bins.items()]
            found = {middle_m: there.errors_m() for middle_m, there in bins.items() if there.found.sum() >= FEWEST}
            errors.plot(list(found), [error_m.mean() for error_m in found.values()], style, **look)
            if stage == "detector":
                low_m, high_m = ([np.quantile(error_m, share) for error_m in found.values()] for share in (0.25, 0.75))
                errors.fill_between(list(found), low_m, high_m, color=look["color"], alpha=0.2)
    for number, (label, distances_m, errors_m) in enumerate(theory):
        errors.plot(distances_m, errors_m, (":", "x-.")[number % 2], color="black", label=label)
    errors.set(xlabel="distance [m]", ylabel="error [m]", ylim=(0.0, None))
    recall.set(xlabel="distance [m]", ylabel="recall [-]", ylim=(0.0, 1.05))
    errors.legend(fontsize="small")
    experiment.write_figure(f"{experiment.name}.svg", figure)
    experiment.write_csv(f"{experiment.name}.csv", ["case", "stage", "from_m", "to_m", "sightings", "recall", "error_m"], rows)


def covariances_m2(ranges_m, **noise):
    """(n, 3, 3) [m^2] covariances of points at these distances, measured along x with the noise of eq. (66)."""
    ranges_m = np.asarray(ranges_m, float)
    return swiftlet.functions.point_covariances(np.tile([1.0, 0.0, 0.0], (len(ranges_m), 1)), ranges_m, np.eye(3), **noise)
