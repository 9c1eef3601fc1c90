#!/usr/bin/env python3
"""`swiftlet batch` as a user meets it: kills, Ctrl-C, shards, the command of an episode. Usage: batch_test.py SWIFTLET"""
import contextlib
import json
import os
import pathlib
import random
import resource
import shlex
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from results import rows

SWIFTLET = pathlib.Path(sys.argv[1]).resolve()
SCENARIO = """name: hover
duration_s: {duration}
world: {{type: empty}}
wind: {{gusts: true}}
vehicles:
  - {{name: a, start: {{position_m: [0, 0, 5]}}, agent: {{localization: {{type: ground_truth}}}}}}
"""
BATCH = """name: kill
scenario: hover
variants: [{name: calm}, {name: windy, set: {wind.wind_at_6m_mps: 15}}]
sweep: {parameters: [{key: wind.mean_mps, name: mean, values: ["[0, 0, 0]", "[3, 0, 0]"]}]}
seeds: {count: 15}
"""
SHARD_VARIABLES = ("SLURM_", "OMPI_", "PMI_", "JOB_COMPLETION_INDEX")


def count(database):
    if not database.exists():
        return 0
    with contextlib.closing(sqlite3.connect(database)) as connection:
        try:
            return connection.execute("SELECT count(*) FROM episodes").fetchone()[0]
        except sqlite3.OperationalError:  # killed before the tables were made
            return 0


class Batch(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)
        (self.path / "hover.yaml").write_text(SCENARIO.format(duration=1))
        (self.path / "batch.yaml").write_text(BATCH)
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith(SHARD_VARIABLES)}

    def command(self, *arguments):
        return [str(SWIFTLET), *map(str, arguments)]

    def run_swiftlet(self, *arguments, **options):
        return subprocess.run(self.command(*arguments), cwd=self.path, capture_output=True, text=True, timeout=250,
                              env=self.environment | options.pop("more", {}), **options)

    def undisturbed(self):
        self.run_swiftlet("batch", "batch.yaml", "--out", "undisturbed", "--jobs", 2, "-q", check=True)
        return rows(self.path / "undisturbed/results.sqlite")

    def start(self, *arguments):
        return subprocess.Popen(self.command(*arguments), cwd=self.path, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True, env=self.environment)

    def test_a_batch_killed_at_many_moments_ends_as_one_that_was_not(self):
        begin = time.monotonic()
        expected = self.undisturbed()
        whole_s = time.monotonic() - begin
        self.assertEqual(len(expected["episodes"]), 60)
        moments = random.Random(1)
        database = self.path / "killed/results.sqlite"
        kills = stored = 0
        for attempt in range(100):
            batch = self.start("batch", "batch.yaml", "--out", "killed", "--jobs", 2, "--resume", "-q")
            try:
                # The first attempts are killed after some episodes, independent of the machine's speed. Later ones are
                # killed at random times, some in the middle of the first output.
                if kills < 3:
                    while batch.poll() is None and count(database) < stored + 5:
                        time.sleep(0.01)
                # Other processes may slow the machine down, so every attempt gets more time than the one before.
                longest_s = 0.1 * whole_s if kills < 3 else (0.15 + 0.25 * whole_s) * (1.0 + 0.05 * attempt)
                batch.communicate(timeout=moments.uniform(0.0, longest_s))
                self.assertEqual(batch.returncode, 0)
                break
            except subprocess.TimeoutExpired:
                batch.send_signal(signal.SIGKILL)
                batch.communicate()
                kills += 1
            now = count(database)
            self.assertGreaterEqual(now, stored, "a finished episode was lost")
            stored = now
        else:
            self.fail("never finished")
        self.assertGreaterEqual(kills, 3)
        self.assertEqual(rows(database), expected)
        self.assertFalse(list((self.path / "killed").glob("results.sqlite-*")), "the journal is folded in")

    def test_ctrl_c_stores_finished_episodes_leaves_no_process_and_names_the_option_to_resume(self):
        (self.path / "hover.yaml").write_text(SCENARIO.format(duration=20))
        batch = self.start("batch", "batch.yaml", "--out", "out", "--jobs", 2)
        for _ in range(600):
            if count(self.path / "out/results.sqlite") >= 2:
                break
            time.sleep(0.1)
        batch.send_signal(signal.SIGINT)
        _, message = batch.communicate(timeout=30)
        self.assertEqual(batch.returncode, 1)
        self.assertIn("--resume", message)
        self.assertGreaterEqual(count(self.path / "out/results.sqlite"), 2)
        children = subprocess.run(["ps", "-o", "pid=", "--ppid", str(batch.pid)], capture_output=True, text=True).stdout
        self.assertEqual(children, "")

    def test_the_command_of_an_episode_repeats_it_alone(self):
        self.undisturbed()
        with contextlib.closing(sqlite3.connect(self.path / "undisturbed/results.sqlite")) as connection:
            command, expected = connection.execute("SELECT command, state_hash FROM episodes WHERE episode = 37").fetchone()
        words = shlex.split(command)
        self.assertEqual(words[:2], ["swiftlet", "run"])
        self.run_swiftlet(*words[1:], "--out", "again", "-q", check=True)
        self.assertEqual(json.loads((self.path / "again/summary.json").read_text())["state_hash"], expected)

    def test_the_worst_episodes_play_in_the_report(self):
        worst = ("--set", "report.worst_by=path_length_m", "--set", "seeds.count=2", "--replays", 2, "--out", "out")
        self.run_swiftlet("batch", "batch.yaml", *worst, "-q", check=True)
        with contextlib.closing(sqlite3.connect(self.path / "out/results.sqlite")) as connection:
            query = ("SELECT e.episode, e.state_hash FROM episodes e JOIN metrics m ON m.episode = e.episode "
                     "WHERE m.name = 'path_length_m' ORDER BY m.value DESC LIMIT 2")
            expected = connection.execute(query).fetchall()
        for episode, state_hash in expected:
            run = self.path / "out/replays" / str(episode)
            self.assertEqual(json.loads((run / "summary.json").read_text())["state_hash"], state_hash)
            self.assertIn("<html", (run / "replay.html").read_text()[:1000])
        self.run_swiftlet("report", "out", "-q", check=True)
        page = (self.path / "out/report.html").read_text()
        for episode, _ in expected:
            self.assertIn(f'<iframe src="replays/{episode}/replay.html"', page)
        # A replay of another flight is not shown; its episode is flown again.
        summary = self.path / f"out/replays/{expected[0][0]}/summary.json"
        summary.write_text(summary.read_text().replace(expected[0][1], "0123456789abcdef"))
        self.run_swiftlet("report", "out", "-q", check=True)
        self.assertNotIn(f'"replays/{expected[0][0]}/replay.html"', (self.path / "out/report.html").read_text())
        self.run_swiftlet("batch", "batch.yaml", *worst, "--resume", "-q", check=True)
        self.assertEqual(json.loads(summary.read_text())["state_hash"], expected[0][1])
        part = self.run_swiftlet("batch", "batch.yaml", "--out", "part", "--replays", 1, "--shard", "1/2")
        self.assertEqual(part.returncode, 2)
        self.assertIn("--replays", part.stderr)
        self.assertFalse((self.path / "part").exists())

    def test_shards_of_options_and_of_the_environment_merge_to_the_whole(self):
        expected = self.undisturbed()
        self.run_swiftlet("batch", "batch.yaml", "--out", "parts", "--shard", "1/3", "--jobs", 1, "-q", check=True)
        self.run_swiftlet("batch", "batch.yaml", "--out", "parts", "--jobs", 1, "-q", check=True, more={
            "SLURM_ARRAY_TASK_ID": "1", "SLURM_ARRAY_TASK_COUNT": "3", "SLURM_ARRAY_TASK_MIN": "0", "SLURM_ARRAY_TASK_MAX": "2"})
        incomplete = self.run_swiftlet("batch", "merge", "--out", "parts")
        self.assertEqual(incomplete.returncode, 1)
        self.assertIn("20 episodes are missing", incomplete.stderr)
        self.run_swiftlet("batch", "batch.yaml", "--out", "parts", "--jobs", 1, "-q", check=True,
                          more={"JOB_COMPLETION_INDEX": "2", "SWIFTLET_NUM_SHARDS": "3"})
        self.run_swiftlet("batch", "merge", "--out", "parts", check=True)
        self.assertEqual(rows(self.path / "parts/results.sqlite"), expected)

    @unittest.skipIf(any(init in pathlib.Path(SWIFTLET).read_bytes() for init in (b"__asan_init", b"__tsan_init")),
                     "sanitizers live on more memory than that")
    def test_exhausted_memory_is_reported_as_such(self):
        result = self.run_swiftlet("batch", "batch.yaml", "--out", "out", "--memory-limit", 5, "--set", "seeds.count=1")
        self.assertEqual(result.returncode, 1)
        with contextlib.closing(sqlite3.connect(self.path / "out/results.sqlite")) as connection:
            self.assertEqual(set(connection.execute("SELECT status FROM episodes")), {("out_of_memory",)})

    def test_damaged_results_are_reported_as_such(self):
        self.undisturbed()
        database = self.path / "undisturbed/results.sqlite"
        whole = database.read_bytes()
        for damaged in (b"nonsense" * 1000, whole[:9000] + b"\xa5" * 30000 + whole[39000:], whole[:20000]):
            database.write_bytes(damaged)
            for arguments in (("batch", "batch.yaml", "--out", "undisturbed", "--resume"), ("report", "undisturbed"),
                              ("batch", "merge", "--out", "other", "undisturbed")):
                result = self.run_swiftlet(*arguments)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn("expected results of a batch", result.stderr)
                self.assertEqual(result.stderr.count("\n"), 1, result.stderr)

    def test_a_full_disk_is_reported_and_stored_episodes_stay(self):
        def no_room():  # a limit of the process in place of a full disk: the same path through the program
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (120_000, resource.RLIM_INFINITY))

        result = self.run_swiftlet("batch", "batch.yaml", "--out", "out", "--jobs", 1, preexec_fn=no_room)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, r"out/results.sqlite: .*; \d+ episodes are stored; continue with --resume")
        stored = count(self.path / "out/results.sqlite")
        self.assertIn(f"; {stored} episodes are stored", result.stderr)
        self.run_swiftlet("batch", "batch.yaml", "--out", "out", "--resume", "-q", check=True)
        self.assertEqual(rows(self.path / "out/results.sqlite"), self.undisturbed())

    def test_two_batches_never_write_one_database(self):
        (self.path / "hover.yaml").write_text(SCENARIO.format(duration=100))
        first = self.start("batch", "batch.yaml", "--out", "out", "--jobs", 1, "-q")
        self.addCleanup(first.communicate)
        self.addCleanup(first.kill)
        for _ in range(100):
            if (self.path / "out/results.sqlite").exists():
                break
            time.sleep(0.1)
        second = self.run_swiftlet("batch", "batch.yaml", "--out", "out", "--resume")
        self.assertEqual(second.returncode, 2)
        self.assertIn("another", second.stderr)

    def test_a_batch_of_another_meaning_is_refused(self):
        self.run_swiftlet("batch", "batch.yaml", "--out", "out", "-q", "--set", "seeds.count=1", check=True)
        (self.path / "hover.yaml").write_text(SCENARIO.format(duration=1.5))
        result = self.run_swiftlet("batch", "batch.yaml", "--out", "out", "--resume", "--set", "seeds.count=1")
        self.assertEqual(result.returncode, 2)
        self.assertIn("another meaning (the scenario, or a model or file that it names)", result.stderr)

    def test_failed_episodes_are_reported_with_their_command_and_by_the_exit_status(self):
        (self.path / "batch.yaml").write_text(
            "name: fails\nscenario: hover\ntimeout_s: 0.7\nseeds: {count: 1}\n"
            "sweep: {parameters: [{key: duration_s, values: [0.2, 1000000]}]}\n")
        result = self.run_swiftlet("batch", "batch.yaml", "--out", "out")
        self.assertEqual(result.returncode, 1)
        self.assertIn("timed_out", result.stderr)
        self.assertIn("--set duration_s=1000000 --seed 1", result.stderr)
        self.assertEqual(count(self.path / "out/results.sqlite"), 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
