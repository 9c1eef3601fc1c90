#!/usr/bin/env python3
"""Guidance, detectors and agents written in Python. Usage: see support.py."""
import math
import re
import traceback

import numpy as np

import support
import swiftlet


@swiftlet.guidance("orbit", doc="circles around a point")
class Orbit:
    center_m = swiftlet.key((0.0, 0.0, 4.0), "[m] center of the circle, world frame")
    radius_m = swiftlet.key(3.0, "[m] radius of the circle", min=0.5)
    speed_mps = swiftlet.key(1.5, "[m/s] along it", min=0.0)
    sense = swiftlet.key("left", "[-] sense of rotation", words=("left", "right"))

    def __init__(self, setup):
        self.angle_rad = 0.0
        self.start_m = setup.T_local_body_start[:3, 3]

    def step(self, now):
        self.angle_rad += (1 if self.sense == "left" else -1) * self.speed_mps / self.radius_m * now.dt_s
        outward = np.array([math.cos(self.angle_rad), math.sin(self.angle_rad), 0.0])
        return swiftlet.Goal(self.center_m + self.radius_m * outward, yaw_rad=0.5, mission="endless")


@swiftlet.guidance("fails_late")
class FailsLate:
    """Hovers, then divides by zero."""

    def step(self, now):
        if now.t_s > 0.2:
            return 1 / 0


@swiftlet.guidance("talks")
class Talks:
    def step(self, now):
        now.send("hello", f"{now.id}".encode())
        HEARD.extend((now.id, bytes(b)) for b in now.messages.payload_bytes)


@swiftlet.guidance("keeps")
class Keeps:
    def step(self, now):
        KEPT.append(now)


@swiftlet.detector("small_and_high", doc="small clusters of points in the air")
class SmallAndHigh:
    height_m = swiftlet.key(1.5, "[m] what is lower stands on the ground", min=0.0)

    def step(self, now):
        for cloud in now.clouds:
            points = cloud.points_local_m[cloud.points_local_m[:, 2] > self.height_m]
            if len(points) == 0:
                return []
            box = points.max(axis=0) - points.min(axis=0)
            return [swiftlet.Detection((points.max(axis=0) + points.min(axis=0)) / 2, extent_m=box, num_points=len(points))]
        return None


@swiftlet.agent("keeper", doc="holds a position with two loops", true_pose=True)
class Keeper:
    place_m = swiftlet.key((0.0, 0.0, 4.0), "[m] to hold, world")

    def __init__(self, setup):
        frame = self.frame = setup.airframe
        hubs, turns = np.array(frame.rotor_positions_body_m), np.array(frame.rotor_directions)
        rows = [np.ones(len(hubs)), hubs[:, 1], -hubs[:, 0], -turns * frame.torque_to_thrust_m]
        self.forces_of = np.linalg.pinv(np.array(rows))

    def step(self, now):
        pose = now.samples("pose")
        if len(pose) == 0:
            return None
        T, v, omega = pose.pose[-1], pose.v_mps[-1], pose.omega_radps[-1]
        R, k, a = T[:3, :3], 1.5, 8.0
        thrust = k * k * (self.place_m - T[:3, 3]) - 2 * k * v + np.array([0, 0, 9.81])
        tilt = R.T @ np.cross(R[:, 2], thrust / np.linalg.norm(thrust))
        torque = self.frame.inertia_diagonal_kgm2 * (a * a * tilt - 2 * a * omega)
        force = self.forces_of @ np.array([self.frame.mass_kg * thrust @ R[:, 2], *torque])
        speed = np.sqrt(np.maximum(force, 0) / self.frame.thrust_constant_N_per_radps2)
        low, high = self.frame.rotor_speed_min_radps, self.frame.rotor_speed_max_radps
        return swiftlet.Command(np.clip((speed - low) / (high - low), 0, 1), T_world_body=T, v_world_mps=v,
                                reference_m=self.place_m)


HEARD, KEPT = [], []
GUIDANCE = "vehicles[eye].agent.guidance"


class Modules(support.InFolder):
    def test_guidance_of_python_flies_by_its_name_and_the_same_for_any_threads(self):
        changes = {GUIDANCE: {"type": "orbit", "radius_m": 2.0}, "vehicles[other].agent.guidance": {"type": "orbit", "sense": "right"},
                   "vehicles[other].start.position_m": [3, 0, 4], "duration_s": 2}
        hashes = set()
        for threads in (1, 2, 1):
            simulator = swiftlet.Simulator(swiftlet.load(self.team, changes), threads=threads)
            simulator.run()
            hashes.add(simulator.state_hash)
        self.assertEqual(len(hashes), 1)
        x, y, _ = simulator.states.position_m[0]
        self.assertGreater(math.hypot(x, y), 0.7)
        self.assertIn("radius_m: 2", swiftlet.load(self.team, changes).yaml)

    def test_keys_of_python_are_read_as_strictly_as_any_other(self):
        for guidance, message in (({"type": "orbit", "radus_m": 2}, 'did you mean "radius_m"'),
                                  ({"type": "orbit", "radius_m": -1}, "radius_m"),
                                  ({"type": "orbit", "sense": "up"}, 'one of "left", "right"'),
                                  ({"type": "orbitt"}, 'did you mean "orbit"')):
            with self.assertRaisesRegex(swiftlet.InputError, message):
                swiftlet.load(self.team, {GUIDANCE: guidance})

    def test_an_error_is_a_traceback_of_python_and_ends_the_run(self):
        for threads in (1, 2):
            simulator = swiftlet.Simulator(swiftlet.load(self.team, {GUIDANCE: {"type": "fails_late"}}), threads=threads,
                                           out=self.path / "out")
            text = ""
            try:
                simulator.run()
            except ZeroDivisionError:
                text = traceback.format_exc()
            self.assertIn("return 1 / 0", text)
            self.assertAlmostEqual(simulator.t_s, 0.204)
            with self.assertRaisesRegex(RuntimeError, "this run ended with an error"):
                simulator.tick()
            with self.assertRaises(RuntimeError):
                simulator.finish()
            self.assertEqual(sorted(p.name for p in self.path.iterdir()), ["team.yaml"])

    def test_what_a_step_returns_is_checked(self):
        class Wrong:
            def step(self, now):
                return "north"
        swiftlet.guidance("wrong")(Wrong)
        with self.assertRaisesRegex(TypeError, "a goal: expected 3 numbers, found 'north'"):
            swiftlet.fly(self.team, {GUIDANCE: {"type": "wrong"}})

    def refused(self, kind, returned, error, message):
        class Odd:
            def step(self, now):
                return returned
        getattr(swiftlet, kind)("odd")(Odd)
        place = {"guidance": GUIDANCE, "detector": "vehicles[eye].agent.detector", "agent": "vehicles[other].agent"}[kind]
        for threads in (1, 2):
            with self.assertRaisesRegex(error, r"Odd\.step: " + message):
                swiftlet.fly(self.team, {place: {"type": "odd"}}, threads=threads)

    def test_a_number_that_is_not_finite_is_an_error_of_the_class_that_returned_it(self):
        nan, here = math.nan, (0, 0, 4)
        for returned in ((nan, 0, 4), (0, 0, math.inf), swiftlet.Goal((0, nan, 4)), swiftlet.Goal(here, velocity_mps=(nan, 0, 0)),
                         swiftlet.Goal(here, acceleration_mps2=(0, 0, -math.inf)), swiftlet.Goal(here, yaw_rad=nan),
                         swiftlet.Goal(here, yaw_rate_radps=nan), swiftlet.Goal(here, speed_limit_mps=nan),
                         swiftlet.Goal(here, frame="local", yaw_rad=math.inf)):
            self.refused("guidance", returned, ValueError, r".*: expected .*, found .*(nan|inf)")
        for returned in (swiftlet.Detection((nan, 0, 0)), swiftlet.Detection(here, sigma_m=nan),
                         swiftlet.Detection(here, extent_m=(0, nan, 0)), swiftlet.Detection(here, confidence=math.inf)):
            self.refused("detector", [returned], ValueError, r".*: expected finite numbers, found .*(nan|inf)")
        hover = [0.5] * 4
        for returned in ([0.5, 0.5, nan, 0.5], swiftlet.Command([math.inf] * 4), swiftlet.Command(hover, v_world_mps=(nan, 0, 0)),
                         swiftlet.Command(hover, reference_m=(0, 0, nan)), swiftlet.Command(hover, T_world_body=nan * np.eye(4)),
                         swiftlet.Command(hover, T_world_body=np.zeros((4, 4)))):
            self.refused("agent", returned, ValueError, ".*: expected ")

    def test_a_value_of_a_wrong_type_is_a_type_error_of_the_class_that_returned_it(self):
        for returned in ("north", (0, 0), ("a", "b", "c"), 3, {"position_m": 3}, np.zeros((3, 1)), swiftlet.Detection((0, 0, 0))):
            self.refused("guidance", returned, TypeError, "a goal: expected 3 numbers, found ")
        for returned in ("north", 3, [(0, 0, 0)], swiftlet.Detection((0, 0, 0)), [swiftlet.Detection((0, 0, 0)), None]):
            self.refused("detector", returned, TypeError, "expected a list of Detection, or None, found ")
        for returned in ("full", ["a"] * 4, {"rotors": 3}):
            self.refused("agent", returned, TypeError, "rotors: expected numbers, found ")

    def test_a_class_and_its_keys_are_checked_where_they_are_written(self):
        def step(self, now):
            return None
        for act in (lambda: swiftlet.guidance(Orbit), lambda: swiftlet.detector(3), lambda: swiftlet.agent("a")(step),
                    lambda: swiftlet.guidance("a")(type("NoStep", (), {})), lambda: swiftlet.guidance("a", cloud=True),
                    lambda: swiftlet.guidance("a", clouds="yes"), lambda: swiftlet.detector("a", doc=3),
                    lambda: swiftlet.key(None, "[m] of it"), lambda: swiftlet.key(1.0, 3), lambda: swiftlet.key((1, 2), "[m] of it"),
                    lambda: swiftlet.key(["a"], "[m] of it"), lambda: swiftlet.key("a", "[-] of it", words="abc"),
                    lambda: swiftlet.key(1.0, "[m] of it", min="0"), lambda: swiftlet.key(1.0, "[m] of it", low=0),
                    lambda: swiftlet.Goal("north"), lambda: swiftlet.Goal((0, 0)), lambda: swiftlet.Goal((0, 0, 0), speed=1),
                    lambda: swiftlet.Goal((0, 0, 0), yaw_rad="east"), lambda: swiftlet.Detection(None),
                    lambda: swiftlet.Command("full"), lambda: swiftlet.Command([0] * 4, T_world_body=np.eye(3))):
            self.assertRaises(TypeError, act)
        for act in (lambda: swiftlet.key(math.nan, "[m] of it"), lambda: swiftlet.key(0.1, "[m] of it", min=0.5),
                    lambda: swiftlet.key((0, 0, 9), "[m] of it", max=5), lambda: swiftlet.key(2**31, "[-] of it"),
                    lambda: swiftlet.key("up", "[-] of it", words=("left", "right")), lambda: swiftlet.key(1.0, "of it"),
                    lambda: swiftlet.Goal((0, 0, 0), frame="body"), lambda: swiftlet.Goal((0, 0, 0), mission="over")):
            self.assertRaises(ValueError, act)

    def test_the_input_of_a_step_is_gone_after_it(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team, {GUIDANCE: {"type": "keeps"}}))
        simulator.tick()
        with self.assertRaisesRegex(RuntimeError, "copy them to keep them"):
            KEPT[-1].estimate

    def test_a_detector_of_python_is_scored(self):
        summary = swiftlet.fly(self.team, {"vehicles[eye].agent.detector": {"type": "small_and_high"}, "duration_s": 1.2})
        self.assertGreater(summary["metrics"]["vehicles"]["eye"]["detection_recall"], 0.7)
        simulator = swiftlet.Simulator(swiftlet.load(self.team, {"vehicles[eye].agent.detector": {"type": "small_and_high"}}))
        errors = []
        while not simulator.finished:
            simulator.tick()
            found = simulator.vehicle("eye").detections
            if found is not None and len(found):
                errors.append(np.linalg.norm(found.position_m[0] - simulator.states.position_m[1]))
        self.assertGreater(len(errors), 2)
        self.assertLess(np.median(errors), 0.5)

    def test_an_agent_of_python_flies_a_vehicle(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team, {
            "vehicles[other].agent": {"type": "keeper", "place_m": [6, 0, 4.5]}, "duration_s": 5}))
        simulator.run()
        self.assertLess(np.linalg.norm(simulator.states.position_m[1] - [6, 0, 4.5]), 0.4)
        self.assertFalse(simulator.states.crashed.any())

    def test_messages_pass_by_radio(self):
        HEARD.clear()
        swiftlet.fly(self.team, {GUIDANCE: {"type": "talks"}, "vehicles[other].agent.guidance": {"type": "talks"}}, threads=1)
        self.assertIn((0, b"1"), HEARD)
        self.assertIn((1, b"0"), HEARD)

    def test_a_class_may_be_registered_again_but_takes_no_name_of_the_library(self):
        class Other:
            def step(self, now):
                return (0.0, 0.0, 9.0)
        swiftlet.guidance("again")(Orbit)
        swiftlet.guidance("again")(Other)
        swiftlet.load(self.team, {GUIDANCE: {"type": "again"}})
        with self.assertRaisesRegex(ValueError, "'hover' already"):
            swiftlet.guidance("hover")(Other)


class Commands(support.InFolder):
    def test_vehicles_fly_what_is_written_into_an_array(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team, {
            GUIDANCE: {"type": "commanded"}, "vehicles[other].agent.guidance": {"type": "commanded", "by": "position"},
            "wind.mean_mps": [0, 0, 0], "wind.gusts": False, "duration_s": 4}))
        simulator.tick()
        simulator.commands[0] = (0.0, 1.0, 0.0, 0.0)
        simulator.commands[1] = (6.0, 2.0, 5.0, 0.0)
        simulator.run()
        np.testing.assert_allclose(simulator.states.v_mps[0], (0, 1, 0), atol=0.1)
        np.testing.assert_allclose(simulator.states.position_m[1], (6, 2, 5), atol=0.2)

    def test_the_lines_of_the_page_fly(self):
        page = (support.SOURCE / "docs/python.md").read_text()
        lines, = (block for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "simulator.commands" in block)
        flown = {"swiftlet": swiftlet}
        exec(lines, flown)
        np.testing.assert_allclose(flown["simulator"].states.v_mps[0], (1, 0, 0), atol=0.2)

    def test_a_row_has_the_four_numbers_of_a_goal_or_one_for_each_rotor(self):
        for changes, columns in (({GUIDANCE: {"type": "commanded"}}, 4), ({"vehicles[other].agent": {"type": "rotors"}}, 4),
                                 ({"vehicles[other].agent": {"type": "rotors"}, "vehicles[other].model": "f550"}, 6)):
            simulator = swiftlet.Simulator(swiftlet.load(self.team, changes))
            self.assertEqual(simulator.commands.shape, (2, columns))
            simulator.commands[1] = range(columns)
            self.assertEqual(simulator.commands[1].tolist(), list(range(columns)))
            self.assertFalse(simulator.commands[0].any())

    def test_a_command_that_is_no_number_is_refused(self):
        simulator = swiftlet.Simulator(swiftlet.load(self.team, {GUIDANCE: {"type": "commanded"}}))
        simulator.commands[0, 1] = np.nan
        with self.assertRaisesRegex(ValueError, "commands of eye: expected finite numbers, found nan"):
            simulator.tick()


if __name__ == "__main__":
    support.main()
