# SPDX-License-Identifier: BSD-3-Clause
"""What the ROS messages of a synthetic run must say, worked out from what went in (expected.json), and the comparison."""
import csv
import json
import math
import pathlib
import re

import numpy as np

POINT_TYPES = {2: "<u1", 4: "<u2", 6: "<u4", 7: "<f4", 8: "<f8"}  # sensor_msgs/PointField


def load(directory):
    return json.loads((pathlib.Path(directory) / "expected.json").read_text())


class Comparison:
    """Counts the values compared and the differences, and prints the first of these."""

    def __init__(self):
        self.compared = 0
        self.differing = 0

    def expect(self, ok, what):
        self.compared += 1
        if not ok:
            self.differing += 1
            if self.differing <= 20:
                print("differs:", what)

    def equal(self, found, wanted, what, tolerance=0.0):
        found, wanted = np.asarray(found), np.asarray(wanted)
        if found.shape != wanted.shape:
            return self.expect(False, f"{what}: shape {found.shape}, not {wanted.shape}")
        if found.dtype.kind in "US" or wanted.dtype.kind in "US":
            ok = found == wanted
        else:
            found, wanted = found.astype(float), wanted.astype(float)
            ok = (np.abs(found - wanted) <= tolerance) | (np.isnan(found) & np.isnan(wanted))
        self.compared += max(found.size - 1, 0)
        self.expect(bool(np.all(ok)), f"{what}: found {found.ravel()[:4]}, wanted {wanted.ravel()[:4]}")

    def finish(self, reader, least):
        print(f"{reader} read {self.compared} values, {self.differing} differ")
        return 0 if self.differing == 0 and self.compared >= least else 1


def rotation(q):
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def cloud_of(message):
    """The points of a sensor_msgs/PointCloud2."""
    fields = message["fields"]
    return np.frombuffer(message["data"], np.dtype({
        "names": [f["name"] for f in fields], "formats": [POINT_TYPES[f["datatype"]] for f in fields],
        "offsets": [f["offset"] for f in fields], "itemsize": message["point_step"]}))


def points_lidar(scan):
    return np.array(scan["origins"]) + np.array(scan["range"])[:, None] * np.array(scan["directions"])


def firing_s(scan):
    """When each beam was fired after the stamp; all at once in a frozen scan."""
    i = np.arange(scan["rows"] * scan["cols"])
    offsets = np.array(scan["column_offset_s"])[i % scan["cols"]] + np.array(scan["row_offset_s"])[i // scan["cols"]]
    return offsets * (1 if scan["duration_ns"] else 0)


def points_world(scan):
    poses = scan["T_world_lidar"]
    columns = np.arange(len(scan["range"])) % scan["cols"]
    points = points_lidar(scan)
    return np.array([rotation(poses[c % len(poses)]["q"]) @ p + poses[c % len(poses)]["p"]
                     for p, c in zip(points, columns)])


def enu_of(fix, datum):
    """East, north, up of a fix from the datum (both latitude, longitude in degrees, altitude) on WGS 84."""
    def ecef(latitude, longitude, altitude):
        a, b = 6378137.0, 6356752.314245179
        lat, lon = math.radians(latitude), math.radians(longitude)
        n = a * a / math.hypot(a * math.cos(lat), b * math.sin(lat))
        return np.array([(n + altitude) * math.cos(lat) * math.cos(lon), (n + altitude) * math.cos(lat) * math.sin(lon),
                         (b * b / (a * a) * n + altitude) * math.sin(lat)])

    lat, lon = math.radians(datum[0]), math.radians(datum[1])
    east = np.array([-math.sin(lon), math.cos(lon), 0.0])
    up = np.array([math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)])
    north = np.cross(up, east)
    offset = ecef(*fix) - ecef(*datum)
    return np.array([east @ offset, north @ offset, up @ offset])


def reflectivity_byte(reflectivity, diffuse_max):
    r = np.maximum(np.asarray(reflectivity, dtype=np.float64), 1e-30)
    bright = diffuse_max + (255 - diffuse_max) * np.minimum(np.log10(r) / 3, 1)
    return np.where(r <= 1, diffuse_max * r, bright)


def check_rows(messages, directory, expected, result, first_stamp_ns=-10**18):
    """What ROS has no types for has a field for each column of the table that the recorder csv writes."""
    def ros_name(name):
        return re.sub("[^A-Za-z0-9_]", "_", name)

    def plain(name, text):
        if re.fullmatch("t_s|received_s", name):
            return max(int(text.replace(".", "")), first_stamp_ns)
        return float(text) if re.fullmatch("-?[0-9.]+(e-?[0-9]+)?|nan", text) else ros_name(text)

    tables = {"/spread": "spread"}
    for vehicle in expected["vehicles"]:
        for topic in ("altimeter", "compass", "neighbors", "scores"):
            tables[f"/{ros_name(vehicle)}/{topic}"] = f"{vehicle}/{topic}"
        tables[f"/{ros_name(vehicle)}/radio/neighbor"] = f"{vehicle}/message_neighbor"
    result.equal(sorted(messages), sorted([*tables, "/events"]), "topics of rows")
    events = [event for tick in expected["ticks"] for event in tick["events"]]
    found = [message for _, _, message in messages.get("/events", [])]
    result.equal([[m["kind"], m["partner"], m["note"]] for m in found],
                 [[e["kind"], e["partner"], e["note"]] for e in events], "events")
    result.equal([[m[f"position_{axis}_m"] for axis in "xyz"] for m in found], [e["p"] for e in events], "events' places")
    for topic, table in tables.items():
        with open(pathlib.Path(directory) / "csv" / f"{table}.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        found = messages.get(topic, [])
        result.equal(len(found), len(rows), f"{topic}: number of messages")
        result.expect(len(rows) > 0, f"{topic}: rows")
        for (_, _, message), row in zip(found, rows):
            result.equal(list(message), ["header", *row], f"{topic} fields")
            for name, text in row.items():
                wanted = plain(name, text)
                result.equal(type(wanted)(message[name]), wanted, f"{topic} {name}")  # JSON has large integers as texts


class RosCheck:
    """Compares messages, given as nested dicts with stamps in ns, with what went in."""

    def __init__(self, expected, first_time_ns=0, first_stamp_ns=-10**18):
        self.expected = expected
        self.names = [re.sub("[^A-Za-z0-9_]", "_", name) for name in expected["vehicles"]]
        self.first_time_ns = first_time_ns
        self.first_stamp_ns = first_stamp_ns
        self.result = Comparison()

    def check(self, messages):
        """messages: topic -> list of (type without package path, time_ns, message dict), in order of writing."""
        wanted = self.wanted()
        self.result.equal(sorted(messages), sorted(wanted), "topics")
        for topic, entries in wanted.items():
            found = messages.get(topic, [])
            self.result.equal(len(found), len(entries), f"{topic}: number of messages")
            pairs = enumerate(zip(found, entries))
            for index, ((type_name, time_ns, message), (wanted_type, wanted_time, compare)) in pairs:
                where = f"{topic}[{index}]"
                self.result.equal(type_name, wanted_type, f"{where} type")
                self.result.equal(time_ns, max(wanted_time, self.first_time_ns), f"{where} time")
                compare(message, where)

    def wanted(self):
        """topic -> list of (type, tick time, function that compares a message)."""
        topics = {}

        def add(topic, type_name, t_ns, function, *arguments):
            topics.setdefault(topic, []).append(
                (type_name, t_ns, lambda message, where: function(message, where, *arguments)))

        static = []
        for tick in self.expected["ticks"]:
            t = tick["t_ns"]
            add("/clock", "Clock", t, self.clock, t)
            frames = []
            for name, v in zip(self.names, tick["vehicles"]):
                frames.append(("world", f"{name}/body", v))
                if v["estimate"]["valid"]:
                    frames.append(("world", f"{name}/local", v["estimate"]["correction"]))
            add("/tf", "TFMessage", t, self.transforms, t, frames)
            for name, v in zip(self.names, tick["vehicles"]):
                add(f"/{name}/truth/pose", "PoseStamped", t, self.truth, t, v)
                if v["estimate"]["valid"]:
                    add(f"/{name}/estimate", "Odometry", t, self.estimate, name, v["estimate"])
                for sample in v["imu"]:
                    add(f"/{name}/imu", "Imu", t, self.imu, name, sample)
                for sample in v["odometry"]:
                    add(f"/{name}/odometry", "Odometry", t, self.odometry, name, sample)
                for sample in v["gnss"]:
                    add(f"/{name}/gnss", "NavSatFix", t, self.gnss, name, sample)
                add(f"/{name}/detections", "MarkerArray", t, self.detections, t, v["detection"])
                if v["track"]["written"]:
                    add(f"/{name}/tracks", "MarkerArray", t, self.tracks, t, v["track"])
                for scan in v["scans"]:
                    frame = f"{name}/{scan['sensor']}"
                    if all(child != frame for _, child, _ in static):
                        static.append((f"{name}/body", frame, scan["T_body_lidar"]))
                        add("/tf_static", "TFMessage", t, self.transforms, t, list(static))
                    add(f"/{frame}/points", "PointCloud2", t, self.points, frame, scan)
        return topics

    def header(self, message, where, stamp_ns, frame):
        self.result.equal(message["header"]["stamp"], max(stamp_ns, self.first_stamp_ns), where + " stamp")
        self.result.equal(message["header"]["frame_id"], frame, where + " frame_id")

    def pose(self, pose, where, p, q):
        self.result.equal([pose["position"][k] for k in "xyz"], p, where + " position")
        self.result.equal([pose["orientation"][k] for k in "xyzw"], q, where + " orientation")

    def vector(self, vector, where, wanted, tolerance=0.0):
        self.result.equal([vector[k] for k in "xyz"], wanted, where, tolerance)

    def clock(self, message, where, t):
        self.result.equal(message["clock"], t, where)

    def transforms(self, message, where, t, wanted):
        self.result.equal(len(message["transforms"]), len(wanted), where + " number")
        for found, (parent, child, pose) in zip(message["transforms"], wanted):
            self.header(found, where, t, parent)
            self.result.equal(found["child_frame_id"], child, where + " child")
            self.vector(found["transform"]["translation"], where + " translation", pose["p"])
            self.result.equal([found["transform"]["rotation"][k] for k in "xyzw"], pose["q"], where + " rotation")

    def truth(self, message, where, t, v):
        self.header(message, where, t, "world")
        self.pose(message["pose"], where, v["p"], v["q"])

    def estimate(self, message, where, name, estimate):
        self.header(message, where, estimate["t_ns"], "world")
        pose = estimate["pose"]
        self.pose(message["pose"]["pose"], where, pose["p"], pose["q"])
        J = np.eye(6)
        J[3:, 3:] = rotation(pose["q"])
        covariance = J @ np.reshape(estimate["covariance"], (6, 6)) @ J.T
        self.result.equal(np.reshape(message["pose"]["covariance"], (6, 6)), covariance, where + " covariance", 1e-11)
        self.twist(message, where, pose, estimate["v"], estimate["omega"], name)

    def twist(self, message, where, pose, v, omega, name):
        self.result.equal(message["child_frame_id"], f"{name}/body", where + " child")
        self.vector(message["twist"]["twist"]["linear"], where + " v", rotation(pose["q"]).T @ v, 1e-12)
        self.vector(message["twist"]["twist"]["angular"], where + " omega", omega)

    def odometry(self, message, where, name, sample):
        self.header(message, where, sample["t_ns"], f"{name}/local")
        self.pose(message["pose"]["pose"], where, sample["pose"]["p"], sample["pose"]["q"])
        self.twist(message, where, sample["pose"], sample["v"], [0, 0, 0], name)

    def imu(self, message, where, name, sample):
        self.header(message, where, sample["t_ns"], f"{name}/body")
        self.result.equal(message["orientation_covariance"][0], -1, where + " says: no orientation")
        self.vector(message["angular_velocity"], where + " omega", sample["omega"])
        self.vector(message["linear_acceleration"], where + " f", sample["f"])

    def gnss(self, message, where, name, sample):
        self.header(message, where, sample["t_ns"], f"{name}/body")
        self.result.equal([message["status"]["status"], message["status"]["service"]], [0, 1], where + " status")
        fix = [message["latitude"], message["longitude"], message["altitude"]]
        self.result.equal(enu_of(fix, self.expected["datum"]), sample["p"], where + " position", 1e-6)
        diagonal = np.diag(np.square(sample["sigma"]))
        self.result.equal(np.reshape(message["position_covariance"], (3, 3)), diagonal, where + " covariance", 1e-12)
        self.result.equal(message["position_covariance_type"], 2, where + " covariance type")

    def markers(self, message, where, t, wanted):
        """wanted: (ns, id, type, stamp) of each marker after the one that deletes those before."""
        first, *markers = message["markers"]
        self.header(first, where + " first", t, "world")
        self.result.equal(first["action"], 3, where + " deletes all")
        self.result.equal([[m["ns"], str(m["id"]), str(m["type"]), str(m["action"])] for m in markers],
                          [[ns, str(number), str(kind), "0"] for ns, number, kind, _ in wanted], where + " markers")
        for marker, (*_, stamp) in zip(markers, wanted):
            self.header(marker, where, stamp, "world")
            self.result.equal([len(marker["colors"]), marker["mesh_resource"], marker["frame_locked"]], [0, "", False],
                              where + " unused")
        return markers

    def detections(self, message, where, t, detection):
        box, = self.markers(message, where, t, [("detections", 0, 1, detection["t_ns"])])
        self.pose(box["pose"], where, detection["p"], [0, 0, 0, 1])
        self.vector(box["scale"], where + " extent", np.maximum(detection["extent"], 0.1))

    def tracks(self, message, where, t, track):
        number, stamp = track["id"], track["t_ns"]
        place, spread, path, name = self.markers(message, where, t, [
            ("tracks", number, 2, stamp), ("covariance", number, 2, stamp), ("velocity", number, 0, stamp),
            ("names", number, 9, stamp)])
        self.pose(place["pose"], where, track["p"], [0, 0, 0, 1])
        self.vector(spread["pose"]["position"], where + " center of covariance", track["p"])
        axes = rotation([spread["pose"]["orientation"][k] for k in "xyzw"])
        sigma = np.array([spread["scale"][k] for k in "xyz"]) / 6
        self.result.equal(axes @ np.diag(sigma**2) @ axes.T, np.reshape(track["covariance"], (3, 3)),
                          where + " covariance", 1e-9)
        self.result.equal([[p[k] for k in "xyz"] for p in path["points"]],
                          [track["p"], np.add(track["p"], track["v"])], where + " velocity", 1e-12)
        self.result.equal(name["text"], str(number), where + " name")

    def points(self, message, where, frame, scan):
        self.header(message, where, scan["stamp_ns"], frame)
        fields = message["fields"]
        cloud = cloud_of(message)
        self.result.equal([f["count"] for f in fields], [1] * len(fields), where + " counts")
        self.result.equal(message["row_step"], message["point_step"] * message["width"], where + " row_step")
        self.result.equal([message["is_bigendian"], message["is_dense"]], [False, True], where + " flags")
        self.result.equal(len(cloud), message["width"] * message["height"], where + " size")

        rows, cols = scan["rows"], scan["cols"]
        i = np.arange(rows * cols)
        by_time = np.lexsort((np.array(scan["row_offset_s"])[i // cols], i % cols))
        ranges = np.array(scan["range"])
        offsets = firing_s(scan)
        if rows == 4:
            order, fields_wanted = by_time, ["x", "y", "z", "intensity", "tag", "line", "timestamp"]
        elif rows == 16:
            order, fields_wanted = by_time[ranges[by_time] > 0], ["x", "y", "z", "intensity", "ring", "time"]
        else:
            order = i
            fields_wanted = ["x", "y", "z", "intensity", "t", "reflectivity", "ring", "ambient", "range"]
        self.result.equal([f["name"] for f in fields], fields_wanted, where + " fields")
        self.result.equal([message["height"], message["width"]], [rows, cols] if order is i else [1, len(order)],
                          where + " shape")
        hit = ranges[order] > 0
        xyz = np.where(hit[:, None], points_lidar(scan)[order], 0.0)
        self.result.equal(np.stack([cloud[k] for k in "xyz"], -1), xyz, where + " xyz", 3e-6)
        reflectivity = np.array(scan["reflectivity"])[order]
        if rows == 4:
            self.result.equal(cloud["intensity"], np.where(hit, reflectivity_byte(reflectivity, 150), 0), where, 0.501)
            self.result.equal(cloud["line"], order // cols, where + " line")
            self.result.equal(cloud["tag"], 0 * order, where + " tag")
            self.result.equal(cloud["timestamp"], scan["stamp_ns"] + offsets[order] * 1e9, where + " timestamp", 1)
        elif rows == 16:
            self.result.equal(cloud["intensity"], reflectivity_byte(reflectivity, 100), where + " intensity", 0.501)
            self.result.equal(cloud["ring"], rows - 1 - order // cols, where + " ring")
            self.result.equal(cloud["time"], offsets[order], where + " time", 1e-8)
        else:
            self.result.equal(cloud["intensity"], scan["intensity"], where + " intensity")
            self.result.equal(cloud["reflectivity"], np.where(hit, reflectivity_byte(reflectivity, 100), 0), where, 0.501)
            self.result.equal(cloud["ring"], i // cols, where + " ring")
            self.result.equal(cloud["ambient"], 0 * i, where + " ambient")
            from_axis = np.where(hit, ranges + np.hypot(*np.array(scan["origins"]).T[:2]), 0.0)
            self.result.equal(cloud["range"], from_axis * 1000, where + " range", 0.501)
            self.result.equal(cloud["t"], offsets * 1e9, where + " t", 1)
