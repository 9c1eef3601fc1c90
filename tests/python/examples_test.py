#!/usr/bin/env python3
"""The examples of examples/python, run as a user would. Usage: see support.py."""
import os
import pathlib
import subprocess
import sys

import support


class Examples(support.InFolder):
    def run_example(self, name, *arguments):
        result = subprocess.run([sys.executable, str(support.SOURCE / "examples/python" / name), *map(str, arguments)],
                                cwd=self.path, capture_output=True, text=True, timeout=550,
                                env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1"))
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout

    def test_first_flight(self):
        self.assertIn('did you mean "yaw_deg"', self.run_example("first_flight.py"))

    def test_own_detector(self):
        self.assertIn("hanging", self.run_example("own_detector.py"))

    def test_batch_and_its_plot(self):
        self.assertIn("wind   8 m/s", self.run_example("batch_plot.py", self.path / "plot.png"))

    def test_dataset_and_classifier(self):
        self.assertIn("points right", self.run_example("train_classifier.py", support.PROGRAM))

    def test_learning(self):
        self.assertIn("after", self.run_example("learn.py"))

    def test_every_example_is_run_here(self):
        mine = pathlib.Path(__file__).read_text()
        for path in sorted((support.SOURCE / "examples/python").glob("*.py")):
            self.assertIn(f'"{path.name}"', mine)


if __name__ == "__main__":
    support.main()
