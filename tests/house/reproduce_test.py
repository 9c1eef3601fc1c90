#!/usr/bin/env python3
"""The program of the experiments (tools/reproduce) as a user meets it. Usage: reproduce_test.py SWIFTLET_REPRODUCE"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = pathlib.Path(sys.argv[1]).resolve()


class Reproduce(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)

    def run_program(self, *arguments):
        return subprocess.run([str(PROGRAM), "reproduce", *arguments], cwd=self.path, capture_output=True, text=True, timeout=300)

    def test_an_experiment_leaves_its_table_and_plot(self):
        result = self.run_program("occupancy-filters", "--out", "experiments")
        self.assertEqual(result.returncode, 0, result.stderr)
        folder = self.path / "experiments" / "occupancy-filters"
        rows = json.loads((folder / "result.json").read_text())["rows"]
        self.assertTrue(rows and all(row["verdict"] in ("reproduced", "no published figure") for row in rows), rows)
        self.assertFalse(any("missed" in row["tolerance"] for row in rows), rows)
        for name in ("result.md", "occupancy-filters.csv", "occupancy-filters.svg"):
            self.assertTrue((folder / name).stat().st_size > 0, name)

    def test_an_unknown_experiment_is_refused_with_the_list(self):
        self.assertIn("uncertainty-table", self.run_program("--list").stdout)
        result = self.run_program("no-such-thing")
        self.assertEqual(result.returncode, 2)
        for text in ("no-such-thing", "occupancy-filters"):
            self.assertIn(text, result.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
