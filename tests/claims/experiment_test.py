#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Common parts of the experiments: tables, verdicts, flights that resume, files, the command line. Usage: experiment_test.py SOURCE_DIR"""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

try:
    import matplotlib  # noqa: F401
    import swiftlet  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

SOURCE = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(SOURCE / "tools/experiments"))
from shared import pages  # noqa: E402
from shared.experiment import Experiment  # noqa: E402
from shared.statistics import mean_and_deviation, wilson  # noqa: E402
from shared.tables import markdown, short_number  # noqa: E402

HOVER = {"name": "hover", "duration_s": 0.2, "world": {"type": "empty"}, "wind": {"gusts": True}, "vehicles": [
    {"name": "uav1", "model": "x500", "start": {"position_m": [0, 0, 5]},
     "agent": {"localization": {"type": "ground_truth"}, "guidance": {"type": "hover"}}}]}


class Experiments(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)

    def experiment(self, name="rbl-real", **options):
        experiment = Experiment(name, "doc", self.path / name, quiet=True, **options)
        self.addCleanup(experiment.close)
        return experiment

    def test_verdicts_follow_the_tolerance(self):
        experiment = self.experiment()
        length = "aggressive: L [m]"  # published: 35.56
        experiment.within(length, 35.56 * 1.2, 0.25, 3)
        experiment.within(length, 35.56 * 1.3, 0.25, 3)
        experiment.at_most("c", 2.0, 1.9, 2)
        experiment.at_least("d", 2.0, 1.9, 2)
        experiment.claim("e", "holds", True)
        experiment.row("f", "text")
        shown = [(row["published"], row["tolerance"], row["verdict"]) for row in experiment.rows]
        self.assertEqual(shown, [("35.56", "± 25 %", "reproduced"), ("35.56", "± 25 %", "differs"),
                                 ("-", "<= 1.9: missed", "no published figure"), ("-", ">= 1.9: kept", "no published figure"),
                                 ("-", "it holds: kept", "no published figure"), ("-", "", "no published figure")])
        self.assertEqual([row["what"] for row in experiment.missed], [length, "c"])
        with self.assertRaises(KeyError):
            experiment.within("c", 2.0, 0.1, 2)

    def test_numbers_are_short(self):
        for value, digits, text in ((6.68e-4, 3, "6.68e-04"), (25.154, 4, "25.15"), (0.054, 2, "0.054"), (0.0, 2, "0.0"), (1e7, 2, "1.0e+07"),
                                    (math.nan, 3, "-")):
            self.assertEqual(short_number(value, digits), text)

    def test_tables_escape_bars(self):
        experiment = self.experiment()
        experiment.row("P(x | y)", "2", value=2.0)
        self.assertIn("| P(x \\| y) | - |", markdown(experiment.rows))

    def test_a_quick_version_names_its_runs(self):
        experiment = self.experiment(quick=True)
        self.assertEqual(experiment.repetitions(100, 2), 2)
        experiment.write_results()
        text = (experiment.folder / "result.md").read_text()
        self.assertIn("# rbl-real, quick version\n", text)
        self.assertIn(", 2 runs a case; fewer and shorter than the full version.", text)
        self.assertEqual(json.loads((experiment.folder / "result.json").read_text())["repetitions"], 2)
        self.assertEqual(self.experiment(repetitions=7).repetitions(100, 2), 7)

    def test_csv_rows_are_as_long_as_the_header(self):
        experiment = self.experiment()
        experiment.write_csv("a.csv", ["a, b", "c"], [[1, 0.1], [math.nan, "x"]])
        self.assertEqual((experiment.folder / "a.csv").read_text(), '"a, b",c\n1,0.1\n,x\n')
        with self.assertRaises(ValueError):
            experiment.write_csv("b.csv", ["a"], [[1, 2]])

    def test_figures_have_the_same_bytes_twice(self):
        from matplotlib.figure import Figure
        def bytes_of(file):
            figure = Figure()
            figure.subplots().plot([1, 2], [3, 4])
            experiment.write_figure(file, figure)
            return (experiment.folder / file).read_bytes()
        experiment = self.experiment()
        self.assertEqual(bytes_of("a.svg"), bytes_of("b.svg"))

    def test_flights_come_in_their_order_for_any_number_of_jobs(self):
        runs = [{"seed": seed} for seed in (1, 2, 3)]
        scenario = self.path / "hover.yaml"
        scenario.write_text(json.dumps(HOVER))
        hashes = [[flight["state_hash"] for flight in self.experiment(f"jobs-{jobs}", jobs=jobs).fly(scenario, runs)] for jobs in (1, 2)]
        self.assertEqual(hashes[0], hashes[1])
        self.assertEqual(len(set(hashes[0])), 3)

    def test_a_killed_experiment_runs_only_what_is_missing(self):
        calls = [{"base": 10, "exponent": exponent} for exponent in range(4)]
        first = self.experiment(jobs=2)
        whole = first.map(math_pow, calls)
        first.close()
        log = self.path / "rbl-real/flights.jsonl"
        lines = log.read_text().splitlines(keepends=True)
        # Foreign lines, a finished one with a mark, and one that was cut off by the kill.
        kept = json.loads(lines[1])
        log.write_text("[1, 2]\n{\"key\": 3}\n" + lines[0] + json.dumps({**kept, "result": -1}) + "\n" + lines[2][:30])
        resumed = self.experiment(resume=True)
        results = resumed.map(math_pow, calls)
        resumed.close()
        self.assertEqual(sum(result == -1 for result in results), 1, "what is finished is not computed again")
        self.assertEqual([w for w, r in zip(whole, results) if r != -1], [r for r in results if r != -1])
        self.assertEqual(self.experiment().map(math_pow, calls), whole, "not asked to resume")

    def test_the_error_of_one_run_ends_the_experiment(self):
        with self.assertRaises(TypeError):
            self.experiment(jobs=2).map(math_pow, [{"base": 1, "exponent": 2}, {"base": "x", "exponent": 2}])

    def test_statistics(self):
        mean, deviation, count = mean_and_deviation([1.0, 3.0, None, math.nan])
        self.assertEqual((mean, count), (2.0, 2))
        self.assertAlmostEqual(deviation, math.sqrt(2.0))
        for successes in (0, 3, 10):  # the bounds solve (share - p)^2 = z^2 p (1 - p) / n
            for bound in wilson(successes, 10):
                self.assertAlmostEqual((successes / 10 - bound) ** 2, 1.959963984540054 ** 2 * bound * (1 - bound) / 10)
        self.assertEqual(wilson(0, 0), (0.0, 1.0))

    def test_pages_take_full_results_of_commits_and_keep_the_rest(self):
        (self.path / "docs/results").mkdir(parents=True)
        (self.path / "docs/images/reproduction").mkdir(parents=True)
        page = self.path / "docs/results/rbl.md"
        page.write_text("# x\n\n## `rbl-forest`\n\nkept\n\n## `rbl-real`\n\nold\n")
        overview = self.path / "docs/reproduction.md"
        overview.write_text(f"# y\n\n{pages.BEGIN}old\n{pages.END}\n\nlast\n")
        known = {"rbl-real": "Title [Kamler 2025]\n\nExplanation.", "rbl-forest": "Forest [Kamler 2025]"}
        for quick, revision, status in ((True, "0123abcd", 2), (False, "0123abcd+", 2), (False, "unknown", 2), (False, "0123abcd", 0)):
            self.assertIn("## `rbl-real`\n\nold", page.read_text())
            experiment = self.experiment(quick=quick)
            experiment.row("conservative: L [m]", "52", "reproduced")
            experiment.row("f", "text")
            with unittest.mock.patch("swiftlet.git_revision", revision):
                experiment.write_results()
            self.assertEqual(pages.write(self.path, known, self.path / "docs"), status)
        sections = pages.sections_of(page.read_text())
        self.assertEqual(sections["rbl-forest"], "kept\n")
        self.assertTrue(sections["rbl-real"].startswith("Explanation.\n\n| what |"))
        lines = overview.read_text().splitlines()
        self.assertEqual((lines[0], lines[-1]), ("# y", "last"))
        self.assertIn("| [rbl-real](results/rbl.md#rbl-real) | conservative: L [m] | 53.84 | 52 | 1 reproduced |", lines)

    def run_program(self, *arguments):
        return subprocess.run([sys.executable, str(SOURCE / "tools/experiments"), *arguments], cwd=self.path, capture_output=True, text=True,
                              timeout=300)

    def test_wrong_arguments_are_refused_with_the_list(self):
        self.assertIn("uncertainty-table", self.run_program("--list").stdout)
        for arguments, texts in ((["rbl-circel"], ["uncertainty-table", 'did you mean "rbl-circle"?']), (["--jobs", "-1"], ["--jobs", "-1"]),
                                 (["--repetitions", "0"], ["--repetitions", "0"])):
            result = self.run_program(*arguments)
            self.assertEqual(result.returncode, 2)
            for text in texts:
                self.assertIn(text, result.stderr)


    def test_an_ended_experiment_ends_its_workers(self):
        program = subprocess.Popen([sys.executable, str(SOURCE / "tools/experiments"), "rbl-ghosts", "--jobs", "2"], cwd=self.path,
                                   stderr=subprocess.DEVNULL, start_new_session=True)
        while not (self.path / "reproduce/rbl-ghosts/flights.jsonl").exists():
            time.sleep(0.05)
        time.sleep(1.0)  # the workers begin
        program.terminate()
        self.assertEqual(program.wait(30), 143)
        deadline_s = time.monotonic() + 30
        with self.assertRaises(ProcessLookupError):
            while time.monotonic() < deadline_s:
                os.killpg(program.pid, 0)
                time.sleep(0.1)

    def test_one_run_at_a_time_writes_a_folder(self):
        first, second = self.experiment(), self.experiment(resume=True)
        first.map(math_pow, [{"base": 2, "exponent": 3}])
        with self.assertRaisesRegex(BlockingIOError, "another run of rbl-real"):
            second.map(math_pow, [{"base": 2, "exponent": 3}])

    def test_a_folder_that_cannot_be_made_is_one_message(self):
        (self.path / "file").write_text("")
        result = self.run_program("rbl-ghosts", "--quick", "--out", "file/x")
        self.assertEqual(result.returncode, 2)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)


def math_pow(base, exponent):
    return base ** exponent


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
