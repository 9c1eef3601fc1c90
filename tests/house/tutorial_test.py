#!/usr/bin/env python3
"""Runs docs/tutorial.md as it stands and compares its figures with the results. Usage: tutorial_test.py SWIFTLET SOURCE_DIR

A block of YAML becomes the file that the text before it names; a block of sh is run. The comment in `0.3 cm<!-- expect: mid360 20 % -->` names
the quantity and its tolerance.
"""
import csv
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from expect import expect

BLOCK = re.compile(r"^```(yaml|sh)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NAME = re.compile(r"`(\w+\.yaml)`")
FIGURE = re.compile(r"([\d.]+) (cm|m)<!-- expect: (\w+) (\d+) % -->")
FIELD_ROW = re.compile(r"^\| (\d) \| `(\w+)` \| ([\d.]+) s \| ([\d.]+) m \|$", re.MULTILINE)
FIELD_TOLERANCE = 0.1
UNIT_M = {"cm": 0.01, "m": 1.0}
METRIC = "estimate_position_rmse_m"


def follow(page, folder, environment):
    """Writes the files of the page and runs its commands, in order."""
    for block in BLOCK.finditer(page):
        kind, text = block.groups()
        if kind == "yaml":
            name = NAME.findall(page[:block.start()])[-1]
            (folder / name).write_text(text)
        elif "alias" not in text:  # the program is in PATH here
            result = subprocess.run(["bash", "-ec", text], cwd=folder, env=environment, capture_output=True, text=True)
            expect(result.returncode == 0, f"exit status {result.returncode} of\n{text}{result.stderr}")


def check_mistake(folder, environment):
    """A correct file passes without a word; a misspelled key is named with its place and the right one."""
    def check(name):
        return subprocess.run(["swiftlet", "check", name], cwd=folder, env=environment, capture_output=True, text=True)
    for name in ("survey.yaml", "study.yaml"):
        result = check(name)
        expect((result.returncode, result.stdout, result.stderr) == (0, "", ""), f"check {name}: {result.stdout}{result.stderr}")
    lines = (folder / "survey.yaml").read_text().replace("speed_mps", "sped_mps")
    (folder / "bad.yaml").write_text(lines)
    line = 1 + next(i for i, text in enumerate(lines.splitlines()) if "sped_mps" in text)
    message = check("bad.yaml").stderr
    for part in (f"bad.yaml:{line}:", '"sped_mps"', 'did you mean "speed_mps"'):
        expect(part in message, f"expected {part} in: {message}")


def summary(folder, run):
    return json.loads((folder / run / "summary.json").read_text())


def error_m(of):
    return of["metrics"]["vehicles"]["uav"][METRIC]


def results(folder):
    """Error [m] by the name that the page gives it: of the first run, and the root mean square of each variant."""
    squares = {}
    with open(folder / "study/episodes.csv", newline="") as file:
        for row in csv.DictReader(file):
            squares.setdefault(row["variant"], []).append(float(row[f"uav.{METRIC}"]) ** 2)
    rms = {variant: math.sqrt(sum(values) / len(values)) for variant, values in squares.items()}
    return {"first": error_m(summary(folder, "first")), **rms}


def check_figures(page, found):
    stated = FIGURE.findall(page)
    expect(sorted(name for _, _, name, _ in stated) == sorted(found), f"the page states {stated}, found {found}")
    for number, unit, name, percent in stated:
        ratio = found[name] / (float(number) * UNIT_M[unit])
        tolerance = 1.0 + 0.01 * int(percent)
        expect(1.0 / tolerance <= ratio <= tolerance, f"{name}: the page states {number} {unit}, found {found[name]:.5f} m")


def check_field(page, folder):
    """Seeds, outcomes, times and errors of the table, and the events that the text quotes."""
    rows = FIELD_ROW.findall(page)
    expect(len(rows) == 4, f"expected four rows of flights over the field, found {rows}")
    for seed, outcome, flown_s, error in rows:
        run = summary(folder, f"field_{seed}")
        expect(run["outcome"] == outcome, f"seed {seed}: the page states {outcome}, found {run['outcome']}")
        for stated, found in ((float(flown_s), run["simulated_s"]), (float(error), error_m(run))):
            expect(abs(found - stated) <= FIELD_TOLERANCE * stated, f"seed {seed}: the page states {stated}, found {found}")
        events = [json.loads(line) for line in (folder / f"field_{seed}/events.jsonl").read_text().splitlines()]
        notes = {(event["kind"], event["note"]) for event in events}
        for event, seeds in (
            (("mission", "SLAM is degenerate: the scans do not constrain every direction"), "1234"),
            (("mission_failed", "position too uncertain"), "4"),
        ):
            expect((event in notes) == (seed in seeds), f"seed {seed}: expected {event} in the seeds {seeds} alone, found {notes}")


def main(swiftlet, source):
    page = (source / "docs/tutorial.md").read_text()
    with tempfile.TemporaryDirectory(prefix="swiftlet_tutorial_") as name:
        folder = pathlib.Path(name) / "survey"
        folder.mkdir()
        (folder.parent / "swiftlet").symlink_to(swiftlet)
        environment = {**os.environ, "PATH": f"{folder.parent}:{os.environ['PATH']}"}
        follow(page, folder, environment)
        check_mistake(folder, environment)
        check_figures(page, results(folder))
        check_field(page, folder)
        expect((folder / "first/replay.html").is_file(), "first/replay.html is missing")
        picture = (source / "docs/images/tutorial/error.svg").read_text()
        expect(picture.strip() in (folder / "study/report.html").read_text(), "docs/images/tutorial/error.svg is not a plot of study/report.html")


if __name__ == "__main__":
    try:
        main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve())
    except AssertionError as problem:
        sys.exit(f"docs/tutorial.md: {problem}")
