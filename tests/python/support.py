"""What the tests of the Python module share. Usage of each: TEST.py SWIFTLET SOURCE_DIR, the module on PYTHONPATH."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
REAL_DATA = pathlib.Path(os.environ.get("SWIFTLET_REAL_DATA", SOURCE.parent / "shared/data/real"))  # records of real sensors, if any

# Two vehicles, one of which sees the other by an OS1-128.
TEAM = """name: team
duration_s: 0.6
world: {type: empty, ground: true}
wind: {mean_mps: [2, 0, 0], gusts: true}
vehicles:
  - name: eye
    model: t650
    start: {position_m: [0, 0, 4]}
    sensors: [{type: lidar, name: os1, model: os1_128}, {type: imu}]
    agent: {localization: {type: ground_truth}, detector: {type: vofod}, tracker: {type: vofod}, guidance: {type: hover}}
  - name: other
    model: x500
    start: {position_m: [6, 1, 4]}
    agent: {type: stack, localization: {type: ground_truth}, guidance: {type: trajectory}}
recorders: [{type: tum}, {type: events}]
"""


class InFolder(unittest.TestCase):
    """Each test has a folder of its own, with the scenario team.yaml in it."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)
        self.team = self.path / "team.yaml"
        self.team.write_text(TEAM)

    def program(self, *arguments):
        return subprocess.run([str(PROGRAM), *map(str, arguments)], cwd=self.path, capture_output=True, text=True,
                              timeout=240)


def main():
    unittest.main(argv=sys.argv[:1])
