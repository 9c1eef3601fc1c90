#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A small dataset from the program, read by the published bit layout of SemanticKITTI with numpy alone.
Usage: dataset_test.py SWIFTLET"""
import csv
import json
import pathlib
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

import numpy as np
import yaml

SWIFTLET = pathlib.Path(sys.argv[1]).resolve()
VEHICLE = 300
SMALL = pathlib.Path(__file__).resolve().parent / "small"


def rotation(q):
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def read_gray16(path):
    """A 16-bit gray PNG by its specification; only the filters None and Sub, as they are written."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, body = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        content = data[at + 8:at + 8 + length]
        assert zlib.crc32(kind + content) == struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0]
        if kind == b"IHDR":
            width, height, bits, color = struct.unpack(">IIBB", content[:10])
            assert (bits, color) == (16, 0)
        elif kind == b"IDAT":
            body += content
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(body), np.uint8).reshape(height, 1 + 2 * width)
    assert set(rows[:, 0]) <= {0, 1}
    pixels = rows[:, 1:].reshape(height, width, 2).copy()
    for row in np.flatnonzero(rows[:, 0] == 1):
        pixels[row] = np.cumsum(pixels[row], axis=0, dtype=np.uint64) & 255
    return pixels.view(">u2")[:, :, 0].astype(np.uint16)


def read_boxes(path):
    with open(path) as file:
        return list(csv.DictReader(file))


def run(*arguments, **options):
    return subprocess.run([str(SWIFTLET), *map(str, arguments)], capture_output=True, text=True, timeout=280, **options)


def content(directory):
    """Every file with its bytes, but those of one generation only."""
    return {str(p.relative_to(directory)): p.read_bytes() for p in sorted(directory.rglob("*")) if p.is_file()}


class Dataset(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        shutil.copytree(SMALL, cls.path, dirs_exist_ok=True)
        cls.file = cls.path / "small.yaml"
        cls.out = cls.path / "out"
        cls.result = run("dataset", cls.file, "--out", cls.out, "--jobs", 2)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def sequences(self):
        return sorted((self.out / "sequences").iterdir())

    def test_it_is_written(self):
        self.assertEqual(self.result.returncode, 0, self.result.stderr)
        self.assertEqual([p.name for p in self.sequences()], ["00", "01", "02", "03", "04", "05"])
        manifest = json.loads((self.out / "manifest.json").read_text())
        self.assertTrue(manifest["complete"])
        self.assertEqual([s["seed"] for s in manifest["sequences"]], [100, 100, 101, 101, 200, 200])

    def test_scans_and_labels_follow_the_layout_of_semantic_kitti(self):
        table = yaml.safe_load((self.out / "semantic-kitti.yaml").read_text())
        seen = set()
        for sequence in self.sequences():
            times = np.loadtxt(sequence / "times.txt", ndmin=1)
            poses = np.loadtxt(sequence / "poses.txt", ndmin=2).reshape(-1, 3, 4)
            self.assertEqual(len(times), len(poses))
            self.assertTrue(np.all(np.diff(times) > 0))
            self.assertTrue(np.allclose(poses[:, :, :3] @ poses[:, :, :3].transpose(0, 2, 1), np.eye(3), atol=1e-9))
            calib = {line.split(":")[0]: np.array(line.split(":")[1].split(), float)
                     for line in (sequence / "calib.txt").read_text().splitlines()}
            self.assertTrue(np.array_equal(calib["Tr"].reshape(3, 4), np.eye(3, 4)))
            for frame in range(len(times)):
                scan = np.fromfile(sequence / f"velodyne/{frame:06d}.bin", np.float32).reshape(-1, 4)
                label = np.fromfile(sequence / f"labels/{frame:06d}.label", np.uint32)
                self.assertEqual(len(scan), len(label))
                self.assertGreater(len(scan), 300)
                self.assertTrue(np.all(np.isfinite(scan)))
                seen |= set((label & 0xFFFF).tolist())
                instances = (label >> 16)[(label & 0xFFFF) == VEHICLE]
                self.assertTrue(set(instances.tolist()) <= {1, 2, 3})
                # What lies on the ground has the world's height of the ground: poses and points agree, where the sweep
                # does not roll.
                if json.loads((sequence / "sequence.json").read_text())["sensor"] == "fast":
                    ground = scan[(label & 0xFFFF) == 40, :3]
                    z = (ground @ poses[frame][:, :3].T + poses[frame][:, 3])[:, 2]
                    if len(z) > 200:
                        self.assertLess(np.abs(np.median(z)), 0.1)
        self.assertTrue(seen <= set(table["labels"]), seen)
        self.assertIn(40, seen)
        self.assertIn(VEHICLE, seen)
        # As semantic-kitti-api uses it: a lookup table over all labels, train numbers without gaps, colors and splits.
        learning = table["learning_map"]
        self.assertEqual(sorted(learning.values()), list(range(len(learning))))
        self.assertEqual({v: k for k, v in learning.items()}, table["learning_map_inv"])
        self.assertEqual(set(table["color_map"]), set(table["labels"]))
        self.assertEqual(table["split"], {"train": [0, 1, 2, 3], "valid": [4, 5]})
        self.assertAlmostEqual(sum(table["content"].values()), 1.0, places=6)

    def test_point_truth_and_images_have_the_same_points(self):
        record = np.dtype([("t_ns", "<u4"), ("ring", "<u2"), ("column", "<u2"), ("range_m", "<f4"), ("incidence", "<f4")])
        sequence = self.sequences()[0]
        info = json.loads((sequence / "sequence.json").read_text())
        for frame in range(info["statistics"]["frames"]):
            scan = np.fromfile(sequence / f"velodyne/{frame:06d}.bin", np.float32).reshape(-1, 4)
            truth = np.fromfile(sequence / f"point_truth/{frame:06d}.bin", record)
            self.assertEqual(len(scan), len(truth))
            measured = np.linalg.norm(scan[:, :3], axis=1)
            # The range counts from 16 mm off the axis; its noise is 3 cm.
            error = measured - truth["range_m"]
            self.assertLess(abs(error.mean()), 0.02)
            self.assertTrue(0.02 < error.std() < 0.04, error.std())
            self.assertTrue(np.all((truth["incidence"] >= 0) & (truth["incidence"] <= np.pi / 2 + 1e-6)))
            self.assertTrue(np.all(truth["t_ns"] < 100_000_000))
            self.assertTrue(np.all(np.diff(truth["t_ns"][truth["ring"] == truth["ring"][0]].astype(int)) > 0))
            image = read_gray16(sequence / f"images/range/{frame:06d}.png")
            self.assertEqual(image.shape, (64, 512))
            self.assertEqual(np.count_nonzero(image), len(scan))
            shown = image[truth["ring"], truth["column"]] * 0.002
            self.assertLess(np.abs(shown - measured).max(), 0.016 + 0.002)
            intensity = read_gray16(sequence / f"images/intensity/{frame:06d}.png")
            self.assertTrue(np.array_equal(intensity > 0, image > 0))

    def test_boxes_hold_the_points_of_their_vehicles(self):
        inside = outside = detected = 0
        for sequence in self.sequences():
            for box in read_boxes(sequence / "boxes.csv"):
                frame = int(box["frame"])
                scan = np.fromfile(sequence / f"velodyne/{frame:06d}.bin", np.float32).reshape(-1, 4)
                label = np.fromfile(sequence / f"labels/{frame:06d}.label", np.uint32)
                mine = scan[label == (int(box["instance"]) << 16 | VEHICLE), :3]
                self.assertEqual(len(mine), int(box["num_points"]))
                center = np.array([float(box[k]) for k in ("x_m", "y_m", "z_m")])
                self.assertAlmostEqual(np.linalg.norm(center), float(box["range_m"]), places=6)
                self.assertTrue(0.0 <= float(box["visible_fraction"]) <= 1.0)
                R = rotation([float(box[k]) for k in ("qx", "qy", "qz", "qw")])
                half = 0.5 * np.array([float(box[k]) for k in ("length_m", "width_m", "height_m")])
                local = np.abs((mine - center) @ R)
                # Noise of 3 cm along the beam, and what it moves within a sweep away from its mean time.
                within = np.all(local <= half + 0.25, axis=1)
                inside += np.count_nonzero(within)
                outside += np.count_nonzero(~within)
                detected += len(mine) > 0
                self.assertGreaterEqual(float(box["visible_fraction"]), 0.001 if len(mine) > 5 else 0.0)
        self.assertGreater(detected, 10)
        self.assertEqual(outside, 0, f"{inside} inside")

    def test_the_boxes_of_the_world_agree_with_the_trajectories(self):
        for sequence in self.sequences():
            for box in read_boxes(sequence / "boxes.csv"):
                tum = np.loadtxt(sequence / f"trajectories/{box['vehicle']}.tum")
                t = float(box["t_s"])
                if not tum[0, 0] <= t <= tum[-1, 0]:
                    continue
                p = np.array([np.interp(t, tum[:, 0], tum[:, i]) for i in (1, 2, 3)])
                center = np.array([float(box[k]) for k in ("x_world_m", "y_world_m", "z_world_m")])
                # The box's center lies near the center of mass.
                self.assertLess(np.linalg.norm(center - p), 0.3)

    def test_tables_and_recordings_are_there(self):
        sequence = self.sequences()[0]
        imu = np.genfromtxt(sequence / "csv/uav1/imu.csv", delimiter=",", names=True)
        gnss = np.genfromtxt(sequence / "csv/uav1/gnss.csv", delimiter=",", names=True)
        self.assertGreater(len(imu), 100)
        self.assertGreater(gnss.size, 0)
        self.assertAlmostEqual(float(np.mean(imu["f_z_mps2"])), 9.81, delta=1.0)
        beliefs = np.loadtxt(sequence / "estimate.tum", ndmin=2)
        self.assertEqual(len(beliefs), len(np.loadtxt(sequence / "times.txt", ndmin=1)))
        self.assertTrue((sequence / "record.mcap").read_bytes().startswith(b"\x89MCAP0\r\n"))
        self.assertFalse((self.sequences()[1] / "record.mcap").exists())

    def test_flights_keep_clear_of_trees_and_of_each_other(self):
        for sequence in self.sequences():
            info = json.loads((sequence / "sequence.json").read_text())
            self.assertGreater(info["statistics"]["least_clearance_m"], 0.1)

    def test_the_data_card_counts_points_and_shows_charts(self):
        card = (self.out / "README.md").read_text()
        points = sum(json.loads((s / "sequence.json").read_text())["statistics"]["points"] for s in self.sequences())
        self.assertIn(f"{points:,}".replace(",", " "), card)
        own = others = 0
        for sequence in self.sequences():
            carrier = json.loads((sequence / "sequence.json").read_text())["instance"]
            for file in sequence.glob("labels/*.label"):
                label = np.fromfile(file, np.uint32)
                of_vehicles = (label >> 16)[(label & 0xFFFF) == VEHICLE]
                own += int(np.sum(of_vehicles == carrier))
                others += int(np.sum(of_vehicles != carrier))
        self.assertGreater(others, 0)
        self.assertIn(f"| - other vehicles | | {others:,} | |".replace(",", " "), card)
        self.assertIn(f"| - the LiDAR's own carrier | | {own:,} | |".replace(",", " "), card)
        for chart in ("classes", "ranges", "distances"):
            self.assertIn(f"charts/{chart}.svg", card)
            self.assertIn("<svg", (self.out / f"charts/{chart}.svg").read_text())

    def test_verify_accepts_the_dataset_and_notices_a_flipped_byte(self):
        result = run("dataset", "verify", self.out, "--frames", 4)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("4 simulated again bit for bit", result.stdout)
        copy = self.path / "copy"
        for name in ("sequences/02/velodyne/000003.bin", "sequences/00/labels/000001.label", "semantic-kitti.yaml"):
            shutil.copytree(self.out, copy)
            data = bytearray((copy / name).read_bytes())
            data[len(data) // 2] ^= 1
            (copy / name).write_bytes(data)
            result = run("dataset", "verify", copy, "--frames", 0)
            self.assertEqual(result.returncode, 1)
            self.assertIn(f"{name}: expected the hash", result.stderr)
            shutil.rmtree(copy)

    def test_verify_notices_data_that_no_simulation_gives_even_with_matching_hashes(self):
        copy = self.path / "forged"
        shutil.copytree(self.out, copy)
        info_file = copy / "sequences/00/sequence.json"
        info = json.loads(info_file.read_text())
        info["reflectivities"][0] *= 0.5  # another ground: other intensities
        info_file.write_text(json.dumps(info))
        result = run("dataset", "verify", copy, "--frames", 0)
        self.assertEqual(result.returncode, 1)
        self.assertIn("sequences/00/sequence.json: expected", result.stderr)
        # The manifest is forged with it, its hash by the tool of those who made the hash.
        if shutil.which("xxhsum") is None:
            self.skipTest("xxhsum is not installed")
        manifest = json.loads((copy / "manifest.json").read_text())
        hashed = subprocess.run(["xxhsum", "-H128", info_file], capture_output=True, text=True, check=True).stdout
        for file in manifest["files"]:
            if file["path"] == "sequences/00/sequence.json":
                file["bytes"] = info_file.stat().st_size
                file["xxh128"] = hashed.split()[0]
        (copy / "manifest.json").write_text(json.dumps(manifest))
        frames = sum(json.loads((s / "sequence.json").read_text())["statistics"]["frames"] for s in self.sequences())
        result = run("dataset", "verify", copy, "--frames", frames)
        self.assertEqual(result.returncode, 1)
        self.assertIn("differs when simulated again", result.stderr)

    def test_ctrl_c_keeps_finished_flights_and_names_the_option_to_resume(self):
        for how in (signal.SIGINT, signal.SIGTERM):
            target = self.path / f"stopped{int(how)}"
            process = subprocess.Popen([str(SWIFTLET), "dataset", str(self.file), "--out", str(target), "--jobs", "1"],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            for _ in range(2000):
                if list(target.glob("sequences/[0-9]*")):
                    break
                time.sleep(0.01)
            process.send_signal(how)
            message = process.communicate(timeout=60)[1]
            self.assertEqual(process.returncode, 128 + how, message)
            self.assertIn("of 3 flights are finished and kept; continue with --resume", message)
            self.assertGreaterEqual(len(list(target.glob("sequences/[0-9]*"))), 1)

    def test_killed_at_random_moments_and_resumed_it_is_the_same_to_the_byte(self):
        target = self.path / "killed"
        dice = random.Random(5)
        finished = set()
        for attempt in range(40):
            arguments = [str(SWIFTLET), "dataset", str(self.file), "--out", str(target), "--jobs", "2", "-q", "--resume"]
            process = subprocess.Popen(arguments)
            if attempt < 8:
                time.sleep(dice.uniform(0.05, 1.5))
                process.send_signal(signal.SIGKILL)
            process.wait(timeout=280)
            present = {p.name for p in (target / "sequences").glob("[0-9]*")} if target.exists() else set()
            self.assertTrue(finished <= present, "a finished sequence was lost")
            finished = present
            for name in present:  # a directory with a final name is complete
                self.assertTrue((target / "sequences" / name / "sequence.json").exists())
            if attempt >= 8:
                self.assertEqual(process.returncode, 0)
                break
            time.sleep(0.3)  # the killed one's workers go with it
        self.assertEqual(content(target), content(self.out))

    def test_resume_refuses_another_configuration_and_without_it_nothing_is_overwritten(self):
        result = run("dataset", self.file, "--out", self.out)
        self.assertEqual(result.returncode, 2)
        self.assertIn("--resume", result.stderr)
        result = run("dataset", self.file, "--out", self.out, "--resume", "--set", "splits[0].flights=1")
        self.assertEqual(result.returncode, 2)
        self.assertIn("another one", result.stderr)

    def test_a_full_disk_is_an_error_that_names_the_file_and_keeps_what_is_finished(self):
        target = self.path / "full"

        def no_room():  # a limit of the process in place of a full disk: the same path through the program
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, resource.RLIM_INFINITY))

        result = run("dataset", self.file, "--out", target, "--jobs", 1, preexec_fn=no_room)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, r"cannot write .*sequences/\.0\d\.partial/.*: File too large")
        self.assertIn("continue with --resume", result.stderr)
        self.assertEqual(list((target / "sequences").glob("[0-9]*")), [])
        result = run("dataset", self.file, "--out", target, "--resume", "-q")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(content(target), content(self.out))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
