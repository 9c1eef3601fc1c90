#!/usr/bin/env python3
"""What the law of rooms (cmake/Rooms.cmake) leaves to a test. Usage: layers_test.py SOURCE_DIR BUILD_DIR

The compiler enforces the law by include paths: here it is made to compile what breaks the law, which must fail. Headers of
other packages lie on everybody's path, so which room may know which package is read from the #include lines.
"""
import json
import pathlib
import re
import shlex
import subprocess
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from tracked import tracked

THIRD_PARTY = {  # header pattern: rooms in which it may appear
    r"^(bt[A-Z]|bullet/|Bullet|LinearMath/)": ["sim/physics"],
    r"^embree": ["sim/raycast"],
    r"^(GL|EGL)/": ["sim/render"],
    r"^png\.h": ["sim/render"],
    r"^yaml-cpp": ["sim/scenario"],
    r"^(zstd|zlib|lz4)": ["sim/recorders", "sim/replay", "sim/world"],
    r"^nlohmann": ["sim/recorders", "sim/replay", "sim/run", "sim/batch", "sim/dataset", "sim/report"],
    r"^xxhash": ["sim/run", "sim/batch", "sim/dataset"],
    r"^sqlite3": ["sim/batch"],
    r"^pybind11/": ["sim/python"],
    r"^omp\.h": ["sim/run", "sim/raycast"],
    r"^Random123": ["core/math"],
    r"^fmt/": ["sim/*"],
    r"^(CLI/|spdlog/)": [],
    r"^boost/": ["core/*", "sim/batch", "sim/report"],
    r"^pcl/": ["core/pcl"],
    r"^(ceres|ompl)/": ["core/*"],
    r"^octomap/": ["sim/octomap"],
    r"^polyclipping/": ["core/planning"],
    r"^(fstream|filesystem|iostream|cstdio|chrono|thread|random)$": ["sim/*"],
}
# Headers never show a type of another package than Eigen and the standard library, unless they are a room's own.
HEADER_ONLY_IN_CPP = re.compile(r"^(bt[A-Z]|embree|E?GL/|png\.h|yaml-cpp|zstd|zlib|lz4|nlohmann|xxhash|sqlite3|Random123|pcl/|ceres/|ompl/|octomap/|polyclipping/|boost/)")
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')

PROBES = [  # target, header, may it include that?
    ("swiftlet_core_guidance_flocking", "swiftlet/core/map/occupancy_view.hpp", True),
    ("swiftlet_core_guidance_flocking", "core/guidance/heading.hpp", True),
    ("swiftlet_core_guidance_flocking", "core/map/lanes.hpp", False),  # private to its room
    ("swiftlet_core_guidance_flocking", "swiftlet/core/detection/vofod.hpp", False),  # a room that it must not use
    ("swiftlet_core_guidance_flocking", "swiftlet/sim/world/scene.hpp", False),  # core knows no simulator
    ("swiftlet_core_slam_graph", "core/slam/matching/surface_map.hpp", True),  # a part of its room before it
    ("swiftlet_core_slam_graph", "core/slam/sharing/map_join.hpp", False),  # and one after it
    ("swiftlet_core_agent", "swiftlet/sim/errors/errors.hpp", False),
    ("swiftlet_sim_sensors", "swiftlet/sim/raycast/ray_scene.hpp", True),
    ("swiftlet_sim_sensors", "swiftlet/sim/scenario/scenario.hpp", False),
    ("swiftlet_sim_metrics", "swiftlet/sim/scenario/scenario.hpp", False),
    ("swiftlet_sim_recorders", "swiftlet/sim/run/simulation.hpp", False),
    ("swiftlet_sim_run", "swiftlet/core/tracking/motion_filter.hpp", True),  # handed on by the agent
    ("swiftlet_sim_run", "sim/raycast/embree_scene.hpp", False),
    ("test_core_map", "core/map/lanes.hpp", True),  # tests see all of their room
    ("test_core_map", "swiftlet/core/guidance/rbl.hpp", False),
    ("test_sim_sensors", "sim/raycast/embree_scene.hpp", False),
    ("swiftlet_program", "swiftlet/sim/batch/run_batch.hpp", True),
    ("swiftlet_program", "sim/batch/episode.hpp", False),
]


def allowed_third_party(room, header):
    for pattern, rooms in THIRD_PARTY.items():
        if re.match(pattern, header):
            return any(room == r or (r.endswith("/*") and room.startswith(r[:-1])) for r in rooms)
    return True


def forbidden_packages(root):
    for path in tracked(root, "*.[ch]pp"):
        parts = path.relative_to(root).parts
        if parts[:2] == ("include", "swiftlet"):
            parts = parts[2:]
        if parts[0] not in ("core", "sim"):
            continue
        room = "/".join(parts[:2])
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            where = f"{path.relative_to(root)}:{number}: {match.group(1)}"
            if ".." in match.group(1).split("/"):
                yield f"{where}: a path that goes up evades the law of rooms"
            elif not allowed_third_party(room, match.group(1)):
                yield f"{where}: not in {room}"
            elif path.suffix == ".hpp" and HEADER_ONLY_IN_CPP.match(match.group(1)) and "internal" not in path.name:
                yield f"{where}: third-party types stay in .cpp files (or a *_internal.hpp of the room)"


def compiler_lets_pass(build):
    """What differs from PROBES."""
    commands = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        target = re.search(r" -o \S*CMakeFiles/(\w+)\.dir", entry["command"]).group(1)
        commands.setdefault(target, shlex.split(entry["command"]))
    for target, header, allowed in PROBES:
        words = commands[target]
        paths = [word for word in words if word.startswith("-I")]
        probe = subprocess.run([words[0], "-std=c++20", "-E", "-isystem", "/usr/include/eigen3", *paths, "-x", "c++", "-"],
                               input=f'#include "{header}"\n', capture_output=True, text=True, cwd=build)
        if (probe.returncode == 0) != allowed:
            yield f"{target} {'cannot' if allowed else 'can'} include {header}\n{probe.stderr}"


def undescribed_rooms(root):
    page = (root / "docs/architecture.md").read_text()
    rooms = re.findall(r"swiftlet_room\((\S+?)[ )]", (root / "CMakeLists.txt").read_text())
    yield from (f"docs/architecture.md: no row about {room}" for room in rooms if f"| `{room}` |" not in page)


def main():
    root, build = (pathlib.Path(path) for path in sys.argv[1:3])
    found = [*forbidden_packages(root), *compiler_lets_pass(build), *undescribed_rooms(root)]
    print("\n".join(found))
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
