#!/usr/bin/env python3
"""Flies the first seconds of a scenario with its recorders and cameras, as a user would, and looks at what it leaves.

Usage: scenario_test.py SWIFTLET SCENARIO.yaml. CMake makes a test of every file in scenarios/: a new scenario is covered
without a further line."""
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy
import yaml

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from expect import expect

DURATION_S = 1.5
PICTURE_S = 1.2  # every camera takes its pictures then; by now a sweep of every LiDAR is complete
GOOD_OUTCOMES = ("done", "timeout")  # a run that is cut off ends as timeout


def fly(swiftlet, scenario, out):
    version = subprocess.run([str(swiftlet), "--version"], capture_output=True, text=True).stdout
    cameras = ["snapshots=[]"] if "without pictures" in version else [f"snapshots[*].times_s=[{PICTURE_S}]",
                                                                      "snapshots[*].every_s=0"]
    command = [swiftlet, "run", scenario, "--out", out, "--duration", DURATION_S, "--quiet"]
    command += [word for camera in cameras for word in ("--set", camera)]
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    printed = (result.stdout + result.stderr).strip()
    expect(result.returncode == 0, f"exit status {result.returncode}: {printed}")
    expect(printed == "", f"a quiet run printed: {printed}")
    again = subprocess.run([str(swiftlet), "check", str(out / "scenario.yaml")], capture_output=True, text=True)
    expect(again.returncode == 0, f"the resolved scenario cannot be flown again: {again.stderr.strip()}")


def numbers_of(value, path=""):
    """All numbers of a JSON value with their paths."""
    if isinstance(value, dict):
        for key, below in value.items():
            yield from numbers_of(below, f"{path}.{key}")
    elif isinstance(value, list):
        for i, below in enumerate(value):
            yield from numbers_of(below, f"{path}[{i}]")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield path, value


def check_summary(summary, scenario):
    expect(summary["outcome"] in GOOD_OUTCOMES, f"the outcome is {summary['outcome']}")
    expect(summary["scenario"] == scenario["name"], "the summary is of another scenario")
    expect(0.0 < summary["simulated_s"] <= DURATION_S + 1e-9, f"{summary['simulated_s']} s were simulated")
    for path, number in numbers_of(summary):
        expect(math.isfinite(number), f"summary.json: {path} is {number}")
    vehicles = summary["metrics"]["vehicles"]
    names = [vehicle["name"] for vehicle in scenario["vehicles"]]
    expect(sorted(vehicles) == sorted(names), f"metrics of {sorted(vehicles)}, vehicles {sorted(names)}")


def check_png(path):
    """A complete PNG file; an even surface would leave nothing but zeros after PNG's filters, hence compress to nothing."""
    content = path.read_bytes()
    expect(content[:8] == b"\x89PNG\r\n\x1a\n", f"{path.name} is no PNG")
    chunks, at = {}, 8
    while at < len(content):
        size, kind = struct.unpack(">I4s", content[at:at + 8])
        data = content[at + 8:at + 8 + size]
        expect(struct.unpack(">I", content[at + 8 + size:at + 12 + size])[0] == zlib.crc32(kind + data),
               f"{path.name}: a chunk is broken")
        chunks[kind] = chunks.get(kind, b"") + data
        at += 12 + size
    expect(b"IEND" in chunks, f"{path.name} ends early")
    width, height = struct.unpack(">II", chunks[b"IHDR"][:8])
    pixels = numpy.frombuffer(zlib.decompress(chunks[b"IDAT"]), numpy.uint8)
    expect(pixels.size > width * height, f"{path.name} has too few pixels")
    shown = numpy.count_nonzero(pixels) / pixels.size
    expect(shown > 0.02, f"{path.name} shows nothing: {100 * shown:.2f} % of its bytes differ from their neighbors")


def check_pictures(out, scenario):
    for camera in scenario["snapshots"]:
        pictures = [p for p in out.rglob("*.png") if camera["name"] in str(p.relative_to(out))]
        expect(pictures, f"camera {camera['name']} took no picture")
        for path in pictures:
            check_png(path)


def check_recordings(out, scenario):
    for path in out.rglob("*"):
        empty = path.is_file() and path.stat().st_size == 0
        expect(not empty or path.name == "events.jsonl", f"{path.relative_to(out)} is empty")  # nothing may have happened
        expect(not path.name.endswith(".part"), f"{path.relative_to(out)} was not finished")
    types = {recorder["type"] for recorder in scenario["recorders"]}
    for vehicle in scenario["vehicles"]:
        if "tum" not in types:
            break
        tum = out / "trajectories" / f"{vehicle['name']}.tum"
        poses = numpy.loadtxt(tum, ndmin=2)
        expect(poses.shape[1] == 8 and poses.shape[0] > 10, f"{tum.name} has the shape {poses.shape}")
        expect(numpy.all(numpy.diff(poses[:, 0]) > 0.0), f"{tum.name} goes back in time")
        start, end = poses[0, 1:4], poses[-1, 1:4]
        expect(numpy.linalg.norm(end - start) < 20.0 * DURATION_S, f"{vehicle['name']} was thrown from {start} to {end}")
    if "events" in types:
        for line in (out / "events.jsonl").read_text().splitlines():
            expect(json.loads(line)["kind"] != "crash", f"a crash: {line}")


def main(swiftlet, scenario_file):
    with tempfile.TemporaryDirectory(prefix="swiftlet_scenario_") as folder:
        out = pathlib.Path(folder) / "out"
        fly(swiftlet, scenario_file, out)
        scenario = yaml.safe_load((out / "scenario.yaml").read_text())
        check_summary(json.loads((out / "summary.json").read_text()), scenario)
        check_pictures(out, scenario)
        check_recordings(out, scenario)


if __name__ == "__main__":
    try:
        main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve())
    except AssertionError as problem:
        sys.exit(f"{sys.argv[2]}: {problem}")
