# SPDX-License-Identifier: BSD-3-Clause
"""Usage: check_text.py DIR. numpy and Python's json read TUM, CSV and JSON Lines files; every value is compared."""
import csv
import json
import pathlib
import sys

import numpy as np

import expectation


def check_tum(directory, expected, result):
    for v, name in enumerate(expected["vehicles"]):
        truth = [[tick["t_ns"] * 1e-9, *tick["vehicles"][v]["p"], *tick["vehicles"][v]["q"]] for tick in expected["ticks"]]
        estimates = [tick["vehicles"][v]["estimate"] for tick in expected["ticks"]]
        estimate = [[e["t_ns"] * 1e-9, *e["pose"]["p"], *e["pose"]["q"]] for e in estimates if e["valid"]]
        for suffix, wanted in (("", truth), (".estimate", estimate)):
            path = directory / "trajectories" / f"{name}{suffix}.tum"
            result.equal(np.loadtxt(path), wanted, path.name, 1e-15)
            lines = path.read_text().splitlines()
            result.expect(lines[0].startswith("# "), "comment first")
            result.expect(all(line == line.strip() and line.count(" ") == 7 for line in lines[1:]), "single blanks")


def table(directory, vehicle, topic):
    with open(directory / "csv" / vehicle / f"{topic}.csv", newline="") as file:
        return list(csv.DictReader(file))


def columns(row, names):
    return [float(row[name]) for name in names.split()]


def upper(covariance):
    return np.reshape(covariance, (3, 3))[np.triu_indices(3)]


COV = "cov_xx_m2 cov_xy_m2 cov_xz_m2 cov_yy_m2 cov_yz_m2 cov_zz_m2"


def check_csv(directory, expected, result):
    for v, name in enumerate(expected["vehicles"]):
        ticks = [(tick["t_ns"], tick["vehicles"][v]) for tick in expected["ticks"]]
        rows = table(directory, name, "state")
        result.equal(len(rows), len(ticks), "rows of state")
        for row, (t, want) in zip(rows, ticks):
            result.equal(columns(row, "t_s x_m y_m z_m qx qy qz qw"), [t * 1e-9, *want["p"], *want["q"]], "state", 1e-15)
            result.equal(columns(row, "vx_mps vy_mps vz_mps omega_x_radps omega_y_radps omega_z_radps clearance_m"),
                         [*want["v"], *want["omega"], want["clearance"]], "state")
            result.equal(columns(row, "rotor0_radps rotor1_radps rotor2_radps rotor3_radps"), want["rotors"], "rotors")
            estimate = want["estimate"]
            wanted = [estimate["t_ns"] * 1e-9, *estimate["pose"]["p"], *estimate["pose"]["q"], *estimate["v"],
                      *estimate["omega"]] if estimate["valid"] else [np.nan] * 14
            result.equal(columns(row, "est_t_s est_x_m est_y_m est_z_m est_qx est_qy est_qz est_qw est_vx_mps est_vy_mps "
                                      "est_vz_mps est_omega_x_radps est_omega_y_radps est_omega_z_radps"),
                         wanted, "estimate", 1e-15)
        wanted = [[s["t_ns"] * 1e-9, *s["omega"], *s["f"]] for _, want in ticks for s in want["imu"]]
        result.equal([[float(x) for x in row.values()] for row in table(directory, name, "imu")], wanted, "imu", 1e-15)
        rows = table(directory, name, "gnss")
        wanted = [[s["t_ns"] * 1e-9, *s["p"], *s["sigma"]] for _, want in ticks for s in want["gnss"]]
        result.equal([columns(row, "t_s x_m y_m z_m sigma_x_m sigma_y_m sigma_z_m") for row in rows], wanted, "gnss", 1e-15)
        rows = table(directory, name, "odometry")
        wanted = [[*s["pose"]["p"], *s["pose"]["q"], *s["v"]] for _, want in ticks for s in want["odometry"]]
        result.equal([columns(row, "x_m y_m z_m qx qy qz qw vx_mps vy_mps vz_mps") for row in rows], wanted, "odometry")
        for row, (_, want) in zip(table(directory, name, "neighbors"), ticks):
            result.equal(row["neighbor"], expected["vehicles"][want["neighbor"]["id"]], "neighbor")
            result.equal(columns(row, "x_body_m y_body_m z_body_m " + COV),
                         [*want["neighbor"]["p"], *upper(want["neighbor"]["covariance"])], "neighbor")
        detections = [want["detection"] for _, want in ticks]
        rows = table(directory, name, "detections")
        result.equal([columns(row, "t_s x_m y_m z_m " + COV + " extent_x_m extent_y_m extent_z_m num_points confidence")
                      for row in rows],
                     [[d["t_ns"] * 1e-9, *d["p"], *upper(d["covariance"]), *d["extent"], d["points"], d["confidence"]]
                      for d in detections], "detections", 1e-15)
        scores = [score for _, want in ticks for score in want["scores"]]
        rows = table(directory, name, "scores")
        result.equal([columns(row, "t_s distance_m visible_points found id position_error_m speed_error_mps "
                                   "direction_error_rad nees latency_s") for row in rows],
                     [[score["t_ns"] * 1e-9, *score["numbers"]] for score in scores], "scores", 1e-15)
        names = [expected["vehicles"][score["target"]] if score["target"] >= 0 else "" for score in scores]
        result.equal([[row["stage"], row["target"]] for row in rows],
                     [[score["stage"], name] for score, name in zip(scores, names)], "names of scores")
        tracks = [want["track"] for _, want in ticks if want["track"]["written"]]
        rows = table(directory, name, "tracks")
        result.equal([columns(row, "id x_m y_m z_m " + COV) for row in rows],
                     [[track["id"], *track["p"], *upper(track["covariance"])] for track in tracks], "tracks")


def check_events(directory, expected, result):
    lines = [json.loads(line) for line in (directory / "events.jsonl").read_text().splitlines()]
    wanted = [(tick["t_ns"], event) for tick in expected["ticks"] for event in tick["events"]]
    result.equal(len(lines), len(wanted), "number of events")
    for line, (t, event) in zip(lines, wanted):
        vehicle = expected["vehicles"][event["vehicle"]] if event["vehicle"] >= 0 else None
        result.expect(line == {"t_s": t / 1e9, "kind": event["kind"], "vehicle": vehicle, "partner": event["partner"],
                               "position_m": event["p"], "note": event["note"]}, f"event {line}")


def check_paths(directory, expected, result):
    """finish() names everything that is there, and nothing is left unfinished."""
    files = {path.relative_to(directory) for path in directory.rglob("*") if path.is_file()}
    named = [pathlib.Path(path) for path in expected["paths"]]
    for path in named:
        result.expect((directory / path).exists(), f"{path} exists")
    for path in files - {pathlib.Path("expected.json")}:
        result.expect(any(path == n or n in path.parents for n in named), f"{path} was named by finish()")
        result.expect(path.suffix != ".part", f"{path} is complete")


def main():
    directory = pathlib.Path(sys.argv[1])
    expected = expectation.load(directory)
    result = expectation.Comparison()
    check_tum(directory, expected, result)
    check_csv(directory, expected, result)
    check_events(directory, expected, result)
    check_paths(directory, expected, result)
    sys.exit(result.finish("numpy, csv and json", least=3000))


if __name__ == "__main__":
    main()
