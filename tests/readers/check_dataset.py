# SPDX-License-Identifier: BSD-3-Clause
"""Usage: check_dataset.py SWIFTLET READ_PCD NPM_DIR. Writes a small dataset with every kind of recording and reads these
with software that is not ours: npm's MCAP reader, rosbag, the Point Cloud Library, CloudCompare. What they find must be
what the scans say, read by the published layout of SemanticKITTI, and what the tables say."""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import rosbag

import check_mcap
import check_ply
import check_rosbag
import expectation

SMALL = pathlib.Path(__file__).resolve().parents[1] / "dataset/small/small.yaml"
LIDARS = {"lidar": 0, "fast": 1}  # the sequences of a flight, by sensor


def scan_of(sequence, frame):
    return np.fromfile(sequence / f"velodyne/{frame:06d}.bin", np.float32).reshape(-1, 4)


def in_order(points):
    """Recorders differ in the order of the points."""
    points = np.asarray(points, float)
    return points[np.lexsort(points.T)]


def check_ros(messages, sequences, result, where):
    """Messages of one flight against its sequences."""
    for sensor, number in LIDARS.items():
        sequence = sequences[number]
        carrier = json.loads((sequence / "sequence.json").read_text())["vehicle"]
        clouds = messages[f"/{carrier}/{sensor}/points"]
        stamps = [round(float(t) * 1e9) for t in (sequence / "times.txt").read_text().split()]
        result.equal([m["header"]["stamp"] for _, _, m in clouds], stamps, f"{where}: stamps of {sensor}", 1)
        for frame, (_, _, message) in enumerate(clouds):
            cloud = expectation.cloud_of(message)
            xyz = np.stack([cloud[k] for k in "xyz"], -1)
            xyz = xyz[np.any(xyz != 0, axis=1)]
            wanted = scan_of(sequence, frame)[:, :3]
            result.equal(in_order(xyz), in_order(wanted), f"{where}: {sensor} frame {frame}")
        truth = np.loadtxt(sequence / f"trajectories/{carrier}.tum")
        poses = [m["pose"] for _, _, m in messages[f"/{carrier}/truth/pose"]]
        found = [[p["position"][k] for k in "xyz"] + [p["orientation"][k] for k in "xyzw"] for p in poses]
        result.equal(found, truth[:, 1:], f"{where}: trajectory of {carrier}")
    imu = np.genfromtxt(sequences[0] / "csv/uav1/imu.csv", delimiter=",", names=True)
    found = [m["linear_acceleration"]["z"] for _, _, m in messages["/uav1/imu"]]
    result.equal(found, imu["f_z_mps2"], f"{where}: IMU")


def check_clouds(sequences, read_pcd, result):
    """One file a scan, in the first sequence of the flight."""
    for sensor, number in LIDARS.items():
        sequence = sequences[number]
        carrier = json.loads((sequence / "sequence.json").read_text())["vehicle"]
        folder = sequences[0] / f"scans/{carrier}_{sensor}"
        frames = len(list((sequence / "velodyne").iterdir()))
        result.equal(len(list(folder.glob("*.pcd"))), frames, f"{sensor}: PCD files")
        for frame in range(frames):
            wanted = scan_of(sequence, frame)[:, :3]
            raw = subprocess.run([read_pcd, folder / f"{frame:06d}.pcd"], check=True, capture_output=True).stdout
            result.equal(np.frombuffer(raw, np.float32).reshape(-1, 4)[:, :3], wanted, f"PCL: {sensor} {frame}")
            ply = check_ply.read_ply(folder / f"{frame:06d}.ply")
            result.equal(np.stack([ply[k] for k in "xyz"], -1), wanted, f"PLY: {sensor} {frame}")
        found = check_ply.read_by_cloudcompare(folder / "000000.ply")
        if found is not None:
            result.equal(found, scan_of(sequence, 0)[:, :3], f"CloudCompare: {sensor}", 1e-5)


def main():
    swiftlet, read_pcd, npm_dir = map(pathlib.Path, sys.argv[1:])
    result = expectation.Comparison()
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        subprocess.run([swiftlet, "dataset", SMALL, "--out", out, "-q"], check=True)
        sequences = sorted((out / "sequences").iterdir())
        for first in range(0, len(sequences), len(LIDARS)):
            flight = sequences[first:first + len(LIDARS)]
            check_clouds(flight, read_pcd, result)
            result.expect(check_rosbag.check_tools(flight[0] / "record.bag"), "rosbag check")
            with rosbag.Bag(str(flight[0] / "record.bag")) as bag:
                check_ros(check_rosbag.read_bag(bag), flight, result, "rosbag")
            if check_mcap.has_node():
                check_mcap.install_readers(npm_dir)
                _, messages = check_mcap.read_file(flight[0] / "record.mcap", npm_dir, result)
                check_ros(messages, flight, result, "MCAP")
    sys.exit(result.finish("Foreign software", least=100000))


if __name__ == "__main__":
    main()
