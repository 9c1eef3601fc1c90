#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Experiments reproduce what was published. Usage: claims_test.py SOURCE_DIR quick|full"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import matplotlib  # noqa: F401
    import swiftlet  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

SOURCE, VERSION = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
QUICK = ["uncertainty-table", "occupancy-filters", "slam-faults", "voxel-probability", "expected-error", "communication", "narrow-gap",
         "forest-guidance", "guidance-timing", "submap-navigation", "safe-loop-closure"]
FULL = QUICK + ["gap-success", "rbl-circle-printed", "rbl-sphere", "rbl-forest", "rbl-real", "rbl-ghosts", "detection-ideal",
                "detection-noisy", "detection-multi", "detection-real"]



class Claims(unittest.TestCase):
    def test_results_are_those_published(self):
        for name in QUICK if VERSION == "quick" else FULL:
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                options = ["--quick"] if VERSION == "quick" else []
                run = subprocess.run([sys.executable, str(SOURCE / "tools/experiments"), name, "--out", folder, *options],
                                     capture_output=True, text=True)
                self.assertEqual(run.returncode, 0, run.stderr)
                result = json.loads((pathlib.Path(folder) / name / "result.json").read_text())
                self.assertTrue(result["rows"])
                for row in result["rows"]:
                    self.assertNotEqual(row["verdict"], "differs", row)
                self.assertTrue(result["files"])
                for file in result["files"]:
                    self.assertGreater((pathlib.Path(folder) / name / file).stat().st_size, 0, file)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
