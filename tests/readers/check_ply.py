# SPDX-License-Identifier: BSD-3-Clause
"""Usage: check_ply.py DIR. Reads the PLY files of write_recordings by their headers alone and compares every value; where
CloudCompare is installed, it reads one of them too."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

import expectation

TYPES = {"float": "<f4", "uchar": "<u1", "ushort": "<u2", "uint": "<u4"}


def read_ply(path):
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    lines = data[:end].decode("ascii").splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"], lines[:2]
    elements = [line.split() for line in lines if line.startswith("element ")]
    assert [e[1] for e in elements] == ["vertex"], elements
    properties = [line.split()[1:] for line in lines if line.startswith("property ")]
    dtype = np.dtype([(name, TYPES[kind]) for kind, name in properties])
    cloud = np.frombuffer(data[end:], dtype)
    assert len(cloud) == int(elements[0][2]), (len(cloud), elements)
    return cloud


def check_scan(path, scan, result):
    cloud = read_ply(path)
    hit = np.flatnonzero(np.array(scan["range"]) > 0)
    result.equal(len(cloud), len(hit), f"{path}: points")
    result.equal(np.stack([cloud[k] for k in "xyz"], -1), expectation.points_world(scan)[hit], f"{path}: xyz", 5e-6)
    for name in ("intensity", "reflectivity", "class", "instance", "part", "range_true", "incidence"):
        result.equal(cloud[name], np.array(scan[name])[hit], f"{path}: {name}")
    result.equal(cloud["ring"], hit // scan["cols"], f"{path}: ring")
    result.equal(cloud["column"], hit % scan["cols"], f"{path}: column")
    result.equal(cloud["t"], expectation.firing_s(scan)[hit] * 1e9, f"{path}: t", 1)


def check_map(path, expected, result):
    voxels = read_ply(path)
    result.equal(len(voxels), len(expected["voxels"]), f"{path}: voxels")
    for i, name in enumerate(("x", "y", "z", "state", "value")):
        wanted = np.array([float(v[i]) for v in expected["voxels"]])  # a voxel of a known world is infinite
        result.equal(np.nan_to_num(voxels[name].astype(float), posinf=9e9), np.nan_to_num(wanted, posinf=9e9), f"{path}: {name}", 1e-6)
    header = path.read_bytes().split(b"end_header")[0].decode("ascii")
    result.equal(f"comment edge_m {expected['edge']:g}" in header, True, f"{path}: edge")


def check_maps(directory, expected, result):
    for vehicle in expected["vehicles"]:
        for voxel_map in expected["maps"]:
            for when in ("000000.050s", "000000.200s", "end"):
                check_map(directory / "maps" / f"{vehicle}_{voxel_map['name']}_{when}.ply", voxel_map, result)


def read_by_cloudcompare(path):
    """Positions, or None where CloudCompare is not installed."""
    if not shutil.which("CloudCompare"):
        return None
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "cloud.asc"
        subprocess.run(["CloudCompare", "-SILENT", "-O", path, "-C_EXPORT_FMT", "ASC", "-SAVE_CLOUDS", "FILE", out],
                       env=os.environ | {"QT_QPA_PLATFORM": "offscreen"}, check=True, capture_output=True)
        print("CloudCompare read", path.name)
        return np.loadtxt(out)[:, :3]


def check_cloudcompare(path, scan, result):
    found = read_by_cloudcompare(path)
    if found is not None:
        hit = np.array(scan["range"]) > 0
        result.equal(found, expectation.points_world(scan)[hit], "CloudCompare", 1e-5)


def main():
    directory = pathlib.Path(sys.argv[1])
    expected = expectation.load(directory)
    result = expectation.Comparison()
    count = {}
    for tick in expected["ticks"]:
        for name, vehicle in zip(expected["vehicles"], tick["vehicles"]):
            for scan in vehicle["scans"]:
                stream = f"{name}_{scan['sensor']}"
                path = directory / "scans" / stream / f"{count.get(stream, 0):06d}.ply"
                check_scan(path, scan, result)
                if not count:
                    check_cloudcompare(path, scan, result)
                count[stream] = count.get(stream, 0) + 1
    check_maps(directory, expected, result)
    sys.exit(result.finish("PLY by its header", least=10000))


if __name__ == "__main__":
    main()
