#!/usr/bin/env python3
"""The program as a user meets it: exit statuses, messages, what is left behind. Usage: cli_test.py SWIFTLET SOURCE_DIR"""
import csv
import json
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

SWIFTLET, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
HOVER = """name: hover
duration_s: {duration}
world: {{type: empty}}
vehicles:
  - name: uav1
    model: x500
    start: {{position_m: [0, 0, 5]}}
    agent: {{localization: {{type: ground_truth}}, guidance: {{type: hover}}}}
recorders: [{{type: tum}}, {{type: csv}}, {{type: events}}]
"""

DRAWS = "without pictures" not in subprocess.run([SWIFTLET, "--version"], capture_output=True, text=True).stdout
needs_pictures = unittest.skipUnless(DRAWS, "the program is built without pictures")


class Cli(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)
        self.scenario = self.path / "hover.yaml"
        self.scenario.write_text(HOVER.format(duration=1))

    def run_swiftlet(self, *arguments, timeout=120, **options):
        return subprocess.run([str(SWIFTLET), *map(str, arguments)], cwd=self.path, capture_output=True, text=True,
                              timeout=timeout, **options)

    def left_behind(self):
        return sorted(p.name for p in self.path.iterdir() if p != self.scenario)

    def refused(self, *arguments, expected=()):
        result = self.run_swiftlet(*arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(result.stdout, "")
        for text in expected:
            self.assertIn(text, result.stderr)
        self.assertEqual(self.left_behind(), [])
        return result.stderr

    def test_a_run_leaves_a_complete_directory_and_prints_its_path(self):
        result = self.run_swiftlet("run", self.scenario, "--out", "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        summary = json.loads((self.path / "out/summary.json").read_text())
        self.assertIn(summary["outcome"], ("done", "timeout"))
        self.assertRegex(summary["state_hash"], "^[0-9a-f]{16}$")
        self.assertEqual(summary["simulated_s"], 1.0)
        for name in ("scenario.yaml", "trajectories/uav1.tum", "trajectories/uav1.estimate.tum", "events.jsonl"):
            self.assertTrue((self.path / "out" / name).is_file(), name)
        self.assertIn("out", result.stdout)
        self.assertEqual(self.left_behind(), ["out"])

    def test_the_resolved_scenario_gives_the_same_hash(self):
        quiet = self.run_swiftlet("run", self.scenario, "--out", "a", "--seed", 5, "--quiet")
        self.assertEqual((quiet.returncode, quiet.stdout, quiet.stderr), (0, "", ""))
        self.run_swiftlet("run", "a/scenario.yaml", "--out", "b", "--threads", 1, "-q", check=True)
        hashes = {json.loads((self.path / d / "summary.json").read_text())["state_hash"] for d in "ab"}
        self.assertEqual(len(hashes), 1)

    def test_a_wrong_key_is_reported_with_its_place_and_a_suggestion(self):
        self.scenario.write_text(HOVER.format(duration=1).replace("duration_s", "duration"))
        message = self.refused("run", self.scenario, "--out", "out", expected=["hover.yaml:2:1", "duration_s"])
        self.assertIn("did you mean", message)
        self.refused("check", self.scenario, expected=["hover.yaml:2:1"])

    def test_wrong_command_lines_are_refused_with_the_expectation(self):
        for arguments, expected in ((["fly"], []), (["run"], []), (["run", "nowhere.yaml"], ["nowhere.yaml"]),
                                    (["runn"], ['"runn"', 'did you mean "run"']),
                                    (["run", "--quite", self.scenario], ["'swiftlet run --help'"]),
                                    (["world", self.scenario, "--out", "world.stl"], [".ply"]), (["render", "nowhere"], []),
                                    (["list", "sensor"], []), (["bench", "nothing"], [])):
            self.refused(*arguments, expected=expected)
        for option, value, expected in (("--set", "seed", ""), ("--set", "sede=3", "seed"), ("--threads", "many", ""),
                                        ("--threads", "5000", "expected a whole number in [0, 1024]"),
                                        *(("--seed", seed, "whole number") for seed in ("-1", "99999999999999999999", "1.5", "x")),
                                        *(("--duration", duration, "--duration: expected a number")
                                          for duration in ("nan", "inf", "-1", "1e300", "1s"))):
            self.refused("run", self.scenario, option, value, expected=[expected])

    def test_a_directory_that_is_no_run_is_never_replaced(self):
        (self.path / "thesis").mkdir()
        (self.path / "thesis/chapter1.tex").write_text("years of work")
        for out in ("thesis", "thesis/chapter1.tex/below"):
            result = self.run_swiftlet("run", self.scenario, "--out", out)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(out, result.stderr)
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        self.assertTrue((self.path / "thesis/chapter1.tex").is_file())

    def test_a_map_in_the_directory_that_the_run_replaces_is_refused_and_stays(self):
        flight = ("run", SOURCE / "scenarios/campus_slam.yaml", "--duration", "3", "--quiet", "--set", "snapshots=[]",
                  "--set", "vehicles[0].agent.mapping=none", "--set", "recorders=[{type: slam_map}]", "--out", "first")
        self.assertEqual(self.run_swiftlet(*flight).returncode, 0)
        saved = self.path / "first/maps/uav1.slam"
        before = saved.read_bytes()
        again = (*flight[:-2], "--set", f"vehicles[0].agent.localization.global.map={saved}", "--out")
        result = self.run_swiftlet(*again, "first")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("vehicles[0].agent.localization.global.map: expected a file outside of", result.stderr)
        self.assertEqual(saved.read_bytes(), before)
        self.assertEqual(self.run_swiftlet(*again, "second").returncode, 0)

    def test_check_is_silent_about_valid_files(self):
        for valid in (self.scenario, *sorted((SOURCE / "scenarios/batch").glob("*.yaml"))):  # scenario_test.py checks the scenarios
            result = self.run_swiftlet("check", valid)
            self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "", ""), valid)

    def test_check_and_run_report_the_parts_of_a_file_that_do_not_fit(self):
        room = "".join(f"v {x} {y} {z}\n" for z in (0, 3) for y in (-4, 4) for x in (894, 906))
        (self.path / "room.obj").write_text(room + "f 1 2 4 3\nf 1 5 6 2\nf 1 2\n")
        self.scenario.write_text(HOVER.format(duration=1).replace("type: empty", "type: mesh, file: room.obj, class: ground"))
        lidar = "vehicles[0].sensors=[{type: lidar, model: puck_lite, name: l}]"
        prior = "vehicles[0].agent.detector={type: vofod, prior: {mesh: room.obj}}"
        checked = self.run_swiftlet("check", self.scenario, "--set", lidar, "--set", prior)
        self.assertEqual((checked.returncode, checked.stdout), (0, ""), checked.stderr)
        run = self.run_swiftlet("run", self.scenario, "--set", lidar, "--set", prior, "--out", "out", check=True)
        counters = {c["setting"]: c for c in json.loads((self.path / "out/summary.json").read_text())["counters"]}
        for setting, what in (("vehicles[0].agent.detector.map.size_m", "voxels of the prior outside the map"),
                              ("vehicles[0].agent.detector.prior.mesh", "faces left out: line 11"),
                              ("world.file", "faces left out: line 11")):
            self.assertIn(f"{setting}: ", checked.stderr)
            self.assertIn(what, checked.stderr)
            self.assertIn(what, run.stdout)
            self.assertIn(what, counters[setting]["what"])
        self.assertEqual(counters["world.file"]["of"], 3)

    def test_check_refuses_what_run_refuses_with_the_same_message(self):
        wrong = {
            "vehicles[0].agent.guidance={type: agile, speed_max_mps: 30}": "hover.yaml:8:12: vehicles[0].agent: guidance agile",
            "recorders[0]={type: csv, vehicles: [uav7]}": "uav7",
            "vehicles[0].airframe.rotors=[{position_m: [0.1, 0, 0]}]": "rotors",
            "world={type: mesh, file: nowhere.obj}": "nowhere.obj",
            "vehicles[0].agent.detector={type: vofod}": "detector.type: vofod: expected a sensor of type lidar on uav1",
            "vehicles[0].agent.localization={type: ins}": "localization.type: ins: expected a sensor of type imu on uav1",
            "vehicles[0].agent.guidance={type: waypoints}": "waypoints_m: expected at least one waypoint",
            "snapshots=[{type: top}]": "snapshots[0].times_s: expected",
            "snapshots=[{type: top, times_s: [1], overlays: [trakcs]}]": 'did you mean "tracks"?',
        }
        for setting, word in wrong.items():
            with self.subTest(setting):
                run = self.refused("run", self.scenario, "--out", "out", "--set", setting, expected=[word])
                self.assertEqual(run, self.refused("check", self.scenario, "--set", setting))

    def test_a_crash_is_an_error_for_scripts_that_ask(self):
        self.scenario.write_text(HOVER.format(duration=3).replace("type: empty", "type: field")
                                 .replace("{localization: {type: ground_truth}, guidance: {type: hover}}", "{type: none}"))
        fall = ["run", self.scenario, "-q"]
        self.assertEqual(self.run_swiftlet(*fall, "--out", "a").returncode, 0)
        result = self.run_swiftlet(*fall, "--out", "b", "--fail-on-crash")
        self.assertEqual((result.returncode, result.stderr), (1, "swiftlet: crashed: uav1; the run is in b\n"))
        self.assertTrue((self.path / "b/summary.json").is_file(), "the run is kept all the same")

    def test_everything_that_can_be_named_is_listed(self):
        for kind, word in {"metrics": "path_length_m", "outcomes": "crashed", "overlays": "rbl.cell", "patterns": "ouster",
                           "detectors": "vofod", "trackers": "imm", "mapping": "occupancy", "batches": "square_gusts",
                           "relative_localization": "sliding_window", "datasets": "forest_flight"}.items():
            self.assertIn(word, self.run_swiftlet("list", kind).stdout, kind)
        self.assertIn("A UAV guides a smaller one through a gap of 1.15 m and back\n", self.run_swiftlet("list", "scenarios").stdout)
        self.assertIn("One UAV in managed forests from open to dense", self.run_swiftlet("list", "datasets").stdout)

    @unittest.skipIf(b"__asan_init" in pathlib.Path(SWIFTLET).read_bytes(), "the address sanitizer lives on more memory than that")
    def test_what_does_not_fit_into_memory_is_refused_by_key_before_the_flight(self):
        detector = "vehicles[0].agent.detector={type: vofod, map: {size_m: [400, 400, 100]}}"
        stderr = self.refused("run", self.scenario, "--out", "out", "--memory-limit", 500, "--set", detector,
                              expected=["vehicles[0].agent.detector.map.size_m: expected a setting that fits into 500 MiB"])
        self.assertEqual(stderr.count("\n"), 1)

    def test_a_guide_that_cannot_work_is_refused(self):
        guide = "vehicles[0].agent."
        for key, value, expected in (
                ("guidance.secondary", "uav9", 'guidance.secondary: expected the name of another vehicle (secondary), found "uav9"'),
                ("mapping", "{type: none}", "mapping: expected a type other than none"),
                ("relative_localization", "{type: none}", "relative_localization: expected a type other than none"),
                ("guidance.goal_yaws_deg", "[1, 2, 3]", "goal_yaws_deg: expected as many as goals_m, or none")):
            self.refused("check", "guided_gap", "--set", "%s%s=%s" % (guide, key, value), expected=[expected])

    def test_recorders_write_nowhere_else(self):
        for command in (("check", self.scenario), ("run", self.scenario, "--out", "out")):
            for place in ("../x.mcap", "/tmp/x.mcap", "summary.json"):
                self.refused(*command, "--set", "recorders[0]={type: mcap, file: %s}" % place, expected=["recorders[0].file"])

    @unittest.skipUnless(os.path.exists("/dev/full"), "needs /dev/full")
    def test_output_that_cannot_be_written_is_an_error(self):
        for command in ("reference", "list"):
            with open("/dev/full", "w") as full:
                result = subprocess.run([str(SWIFTLET), command], stdout=full, stderr=subprocess.PIPE, text=True)
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertIn("No space left on device", result.stderr)

    def test_the_files_of_the_page_on_scenarios_are_valid(self):
        page = (SOURCE / "docs/scenarios.md").read_text()
        blocks = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
        self.assertGreaterEqual(len(blocks), 3)
        for block in blocks:
            (self.path / "block.yaml").write_text(block)
            result = self.run_swiftlet("check", "block.yaml")
            self.assertEqual((result.returncode, result.stderr), (0, ""), block)

    def test_a_reader_that_has_enough_is_no_error(self):
        for command in ("reference", "list"):
            read, write = os.pipe()
            os.close(read)  # as head does when it has its lines
            result = subprocess.run([str(SWIFTLET), command], stdout=write, stderr=subprocess.PIPE, text=True)
            os.close(write)
            self.assertEqual((result.returncode, result.stderr), (141, ""), command)

    def test_a_file_at_its_limit_is_an_error_not_a_signal(self):
        import resource
        result = self.run_swiftlet("run", self.scenario, "--out", "out", "-q",
                                   preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000)))
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("File too large", result.stderr)
        self.assertEqual(self.left_behind(), [])

    def test_the_table_of_bench_has_the_share_of_each_stage_of_the_agents(self):
        result = self.run_swiftlet("bench", "one_vehicle", "forest_patrol", "--csv", "bench.csv", timeout=900)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stdout, r"% of the agents' time: localization [\d.]+ .*detection [\d.]+")
        with open(self.path / "bench.csv", newline="") as table:
            header, *rows = csv.reader(table)
        self.assertEqual([len(row) for row in rows], [len(header)] * 2)
        one_vehicle, patrol = (dict(zip(header, row)) for row in rows)
        stages = [column for column in header if column.startswith("agents_") and column.endswith("_share")]
        shares = {column: float(patrol[column]) for column in stages}
        self.assertAlmostEqual(sum(shares.values()), 1.0, delta=1e-5)
        self.assertGreater(shares["agents_detection_share"], 0.0)
        self.assertEqual(shares["agents_mapping_share"], 0.0)  # no vehicle maps there
        self.assertEqual([one_vehicle[column] for column in stages], [""] * len(stages))

    def test_help_is_everywhere(self):
        self.assertIn("run", self.run_swiftlet("--help").stdout)
        for command in ("run", "batch", "report", "render", "world", "check", "list", "reference", "bench", "uncertainty"):
            result = self.run_swiftlet(command, "--help")
            self.assertEqual(result.returncode, 0)
            self.assertIn("Usage", result.stdout)

    def test_the_uncertainty_of_a_sensor_is_a_table_and_a_plot(self):
        self.refused("uncertainty", "--sensor", "no_such_lidar", expected=["no_such_lidar"])
        result = self.run_swiftlet("uncertainty", "--sensor", "os1_128", "--sigma-position", "0.05", "--sigma-rotation", "0.005",
                                   "--voxel", "0.25", "--out", "u")
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = (self.path / "u" / "uncertainty.csv").read_text().splitlines()
        at_12m = dict(zip(lines[0].split(","), map(float, lines[11].split(","))))
        # Across the ray sqrt(0.05^2 + (12 * 0.005)^2) in two directions, along it sqrt(0.05^2 + 0.03^2): 0.11 to 0.13 m.
        self.assertAlmostEqual(at_12m["range_m"], 12.0)
        self.assertTrue(0.10 < at_12m["expected_error_m"] < 0.125, at_12m)

    def test_a_killed_run_leaves_nothing_that_looks_finished(self):
        self.scenario.write_text(HOVER.format(duration=100000))
        for how in (signal.SIGKILL, signal.SIGINT):
            run = self.start_run()
            time.sleep(0.7)
            run.send_signal(how)
            run.communicate(timeout=30)
            self.assertNotEqual(run.returncode, 0)
            self.assertFalse((self.path / "out").exists())
        # The next run cleans up what the killed one left.
        self.scenario.write_text(HOVER.format(duration=1))
        self.run_swiftlet("run", self.scenario, "--out", "out", "-q", check=True)
        self.assertEqual(self.left_behind(), ["out"])

    def start_run(self, stop_signals=signal.SIG_DFL):
        def set_signals():  # whatever those of the test itself are
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, stop_signals)
        return subprocess.Popen([str(SWIFTLET), "run", str(self.scenario), "--out", "out", "-q"], cwd=self.path,
                                stderr=subprocess.PIPE, preexec_fn=set_signals)

    def test_a_stopped_run_cleans_up_whenever_it_is_stopped(self):
        # During the flight, while the world is built, and during a build of minutes.
        for how, world in ((signal.SIGINT, "empty"), (signal.SIGTERM, "field"), (signal.SIGHUP, "forest, size_m: [300, 300]")):
            self.scenario.write_text(HOVER.format(duration=100000).replace("type: empty", f"type: {world}"))
            run = self.start_run()
            while run.poll() is None and not list(self.path.glob(".out.partial-*")):
                time.sleep(0.01)
            run.send_signal(how)
            message = run.communicate(timeout=60)[1].decode()
            self.assertEqual(run.returncode, 128 + how, message)
            self.assertIn("interrupted", message)
            self.assertEqual(self.left_behind(), [])

    def test_nothing_is_written_behind_links_in_a_run_directory(self):
        self.run_swiftlet("run", self.scenario, "--out", "out", "-q", check=True)
        outside = self.path / "outside"
        outside.mkdir()
        (outside / "file").write_text("precious")
        for name, command in {"report.html": ("report", "out"), "replay.html": ("replay", "out"),
                              "w.ply": ("world", self.scenario, "--out", "out/w.ply"),
                              "w.objects.csv": ("world", self.scenario, "--out", "out/w.ply")}.items():
            for link in (name, name + ".part"):
                (self.path / "out" / link).unlink(missing_ok=True)
                (self.path / "out" / link).symlink_to("../outside/file")
            self.run_swiftlet(*command, "-q", check=True)
            self.assertEqual((outside / "file").read_text(), "precious", name)
        (self.path / "out/render").symlink_to("../outside")
        if DRAWS:
            self.assertEqual(self.run_swiftlet("render", "out", "--time", 0.1).returncode, 2)
        self.assertEqual([p.name for p in outside.iterdir()], ["file"])

    def test_pipes_in_place_of_files_are_refused_at_once(self):
        self.run_swiftlet("run", self.scenario, "--out", "out", "-q", check=True)
        for name in ("scenario.yaml", "summary.json", "events.jsonl"):
            file = self.path / "out" / name
            before = file.read_bytes()
            file.unlink()
            os.mkfifo(file)
            for command in ("report", "replay", "render"):
                result = self.run_swiftlet(command, "out", timeout=60)
                if command == "report" or name == "scenario.yaml":
                    self.assertEqual(result.returncode, 2, (name, command, result.stderr))
                    self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
            file.unlink()
            file.write_bytes(before)
        os.mkfifo(self.path / "pipe.yaml")
        for arguments in (("run", "pipe.yaml"), ("check", "pipe.yaml"), ("batch", "pipe.yaml"), ("run", "."), ("run", "/dev/zero"),
                          ("dataset", "pipe.yaml", "--out", "data"), ("report", "pipe.yaml"), ("batch", "merge", "pipe.yaml", "--out", "m")):
            result = self.run_swiftlet(*arguments, timeout=60)
            self.assertEqual(result.returncode, 2, (arguments, result.stderr))
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)

    def test_a_missing_folder_for_temporary_files_does_not_matter(self):
        for command in (("check", self.scenario), ("world", self.scenario, "--map", "map.png")):
            result = self.run_swiftlet(*command, env={**os.environ, "TMPDIR": "/nonexistent"})
            if DRAWS or "--map" not in command:
                self.assertEqual(result.returncode, 0, result.stderr)

    def test_signals_that_are_ignored_stay_ignored(self):
        self.scenario.write_text(HOVER.format(duration=2))
        run = self.start_run(stop_signals=signal.SIG_IGN)  # as by nohup
        while run.poll() is None and not list(self.path.glob(".out.partial-*")):
            time.sleep(0.01)
        run.send_signal(signal.SIGHUP)
        run.communicate(timeout=60)
        self.assertEqual(run.returncode, 0)

    @unittest.skipUnless(os.path.exists("/dev/full"), "needs /dev/full")
    def test_an_output_that_cannot_be_written_is_an_error(self):
        result = self.run_swiftlet("run", self.scenario, "--out", "/dev/full/out")
        self.assertEqual(result.returncode, 2)

    def test_the_world_is_exported_with_its_truth(self):
        self.scenario.write_text(HOVER.format(duration=1).replace("type: empty", "type: forest_thesis"))
        result = self.run_swiftlet("world", self.scenario, "--out", "w.ply")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue((self.path / "w.ply").read_bytes().startswith(b"ply\n"))
        self.assertGreaterEqual(len(list(self.path.glob("w*.csv"))), 1)

    def test_a_shell_completes_commands_options_and_names(self):
        script = self.path / "completion.bash"
        script.write_text(self.run_swiftlet("completion", check=True).stdout)

        def completed(*words):
            line = " ".join(f"'{word}'" for word in ("swiftlet", *words))
            command = (f"source {script}; COMP_WORDS=({line}); COMP_WORDS[0]={SWIFTLET}; COMP_CWORD={len(words)}; "
                       "_swiftlet; printf '%s\\n' \"${COMPREPLY[@]}\"")
            return subprocess.run(["bash", "-c", command], capture_output=True, text=True, cwd=self.path, check=True).stdout.split()

        self.assertEqual(completed("reno"), [])
        self.assertEqual(completed("ren"), ["render"])
        self.assertIn("--duration", completed("run", "--du"))
        self.assertEqual(completed("run", "forest_pat"), ["forest_patrol"])
        self.assertIn("hover.yaml", completed("check", "hov"))

    def test_the_manual_page_has_every_command(self):
        page = self.run_swiftlet("man", check=True).stdout
        self.assertTrue(page.startswith(".TH SWIFTLET 1"))
        for command in ("run", "batch", "world"):
            self.assertIn(f".SS swiftlet {command}\n", page)
        self.assertIn("\\fB\\-\\-map\\fR", page)

    @needs_pictures
    def test_a_map_of_the_world_is_drawn_without_a_flight(self):
        self.refused("world", self.scenario, "--map", "world.jpg", expected=["--map world.jpg", ".png"])
        self.refused("world", self.scenario, expected=["--out", "--map"])
        self.refused("world", self.scenario, "--out", "world.ply", "--paper", "85", expected=["--paper", "--map"])
        result = self.run_swiftlet("world", self.scenario, "--map", "maps/world.png", "--cut", "2")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("maps/world.png", result.stdout)
        self.assertTrue((self.path / "maps/world.png").read_bytes().startswith(b"\x89PNG"))
        self.assertFalse((self.path / "maps/world.svg").exists())
        result = self.run_swiftlet("world", self.scenario, "--map", "paper/world.png", "--paper", "85")
        self.assertEqual(result.returncode, 0, result.stderr)
        size_px = struct.unpack(">II", (self.path / "paper/world.png").read_bytes()[16:24])
        self.assertEqual(size_px[0], 1004)  # 85 mm at 300 dpi
        self.assertIn('width="85.0', (self.path / "paper/world.svg").read_text())

    @needs_pictures
    def test_a_finished_run_can_be_rendered(self):
        self.run_swiftlet("run", self.scenario, "--out", "out", "-q", check=True)
        result = self.run_swiftlet("render", "out", "--camera", "follow:uav1", "--time", "0.5")
        self.assertEqual(result.returncode, 0, result.stderr)
        pictures = list((self.path / "out/render").rglob("*.png"))
        self.assertEqual(len(pictures), 1)
        self.assertTrue(pictures[0].read_bytes().startswith(b"\x89PNG"))
        for wrong in (["--time", "5"], ["--time", "-1"], ["--camera", "nope"], ["--camera", "follow:uav9"],
                      ["--out", "hover.yaml"], ["--until", "x"]):
            refused = self.run_swiftlet("render", "out", *wrong)
            self.assertEqual(refused.returncode, 2, wrong)
            self.assertIn(wrong[0] if wrong[0] != "--out" else wrong[1], refused.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=1)
