#!/usr/bin/env python3
"""The layer rule: which room may include what. Usage: layers_test.py SOURCE_DIR

tools -> sim -> core -> Eigen, std. Rooms may include only the rooms named here; third-party headers stay in theirs.
A room that is not in the table fails, so that a new one is thought about.
"""
import pathlib
import re
import sys

ROOMS = {  # room: rooms it may include besides itself and the public types of core
    "core/config": [],
    "core/airframe": [],
    "core/math": [],
    "core/uncertainty": ["core/math"],
    "core/messages": ["core/math"],
    "core/localization": ["core/math"],
    "core/control": ["core/math"],
    "core/planning": ["core/math"],
    "core/guidance": ["core/math", "core/messages", "core/planning", "core/control", "core/localization", "core/map"],
    "core/map": ["core/math"],
    "core/pcl": ["core/detection"],
    "core/detection": ["core/math", "core/uncertainty", "core/map", "core/localization"],
    "core/tracking": ["core/math", "core/uncertainty", "core/map", "core/localization", "core/detection"],
    "core/mapping": ["core/map", "core/localization"],
    "core/stages": ["core/localization", "core/detection", "core/tracking", "core/mapping", "core/guidance"],
    "core/agent": ["core/math", "core/localization", "core/control", "core/guidance", "core/map", "core/detection",
                   "core/tracking", "core/mapping", "core/stages"],
    "sim/io": [],
    "sim/parallel": [],
    "sim/plot": ["sim/io"],
    "sim/world": ["core/math", "sim/io"],
    "sim/raycast": ["core/math", "sim/world"],
    "sim/physics": ["core/math", "sim/parallel", "sim/world", "sim/raycast"],
    "sim/sensors": ["core/math", "sim/parallel", "sim/world", "sim/raycast"],
    "sim/radio": ["core/math", "sim/world", "sim/raycast"],
    "sim/metrics": ["core/math", "sim/world", "sim/raycast", "sim/physics", "sim/sensors"],
    "sim/recorders": ["core/math", "core/messages", "sim/io", "sim/world", "sim/raycast", "sim/sensors"],
    "sim/registry": ["sim/world", "sim/sensors", "sim/recorders"],
    "sim/report": ["sim/io", "sim/plot", "sim/batch", "sim/metrics", "sim/scenario", "sim/run"],
    "sim/render": ["core/math", "sim/io", "sim/world", "sim/raycast", "sim/sensors"],
    "sim/scenario": ["core/agent", "core/messages", "core/localization", "core/guidance", "core/control", "core/math", "sim/io", "sim/world",
                     "sim/raycast", "sim/physics", "sim/sensors", "sim/radio", "sim/recorders", "sim/render",
                     "sim/metrics"],
    "sim/run": ["core/agent", "core/detection", "core/map", "core/localization", "core/guidance", "core/control", "core/math", "sim/io", "sim/parallel", "sim/world",
                "sim/raycast", "sim/physics", "sim/sensors", "sim/radio", "sim/recorders", "sim/render",
                "sim/metrics", "sim/scenario"],
    "sim/batch": ["core/math", "sim/io", "sim/world", "sim/raycast", "sim/physics", "sim/radio", "sim/recorders", "sim/render",
                  "sim/metrics", "sim/scenario", "sim/run"],
    "sim/dataset": ["core/agent", "core/stages", "core/guidance", "core/planning", "core/math", "sim/world", "sim/raycast", "sim/sensors", "sim/recorders",
                    "sim/render", "sim/scenario", "sim/run", "sim/batch", "sim/io", "sim/plot"],
}
# The public scenario is one struct of every room's configuration: its header may be read where a RunInfo is.
PUBLIC_SIM_FOR_ALL = {"swiftlet/sim/errors.hpp"}
PUBLIC_SIM_USERS = {"sim/registry", "sim/scenario", "sim/run", "sim/batch", "sim/report", "sim/dataset", "sim/recorders", "sim/render", "sim/metrics"}
THIRD_PARTY = {  # header pattern: rooms in which it may appear
    r"^(bt[A-Z]|bullet/|Bullet|LinearMath/)": ["sim/physics"],
    r"^embree": ["sim/raycast"],
    r"^GL/": ["sim/render"],
    r"^png\.h": ["sim/render"],
    r"^yaml-cpp": ["sim/scenario"],
    r"^assimp": ["sim/world"],
    r"^(zstd|zlib|lz4)": ["sim/recorders", "sim/world"],
    r"^nlohmann": ["sim/recorders", "sim/run", "sim/batch", "sim/dataset", "sim/report", "tools"],
    r"^xxhash": ["sim/run", "sim/batch", "sim/dataset"],
    r"^sqlite3": ["sim/batch"],
    r"^omp\.h": ["sim/run", "sim/raycast", "tools"],
    r"^Random123": ["core/math"],
    r"^fmt/": ["sim/*", "tools"],
    r"^(CLI/|spdlog/)": ["tools"],
    r"^boost/": ["core/*", "sim/batch", "sim/report"],
    r"^pcl/": ["core/pcl"],
    r"^(ceres|ompl|octomap)/": ["core/*"],
    r"^(fstream|filesystem|iostream|cstdio|chrono|thread|random)$": ["sim/*", "tools"],
}
# Boundary headers inside sim and core never show a third-party type other than Eigen.
HEADER_ONLY_IN_CPP = re.compile(r"^(bt[A-Z]|embree|GL/|png\.h|yaml-cpp|assimp|zstd|zlib|lz4|nlohmann|xxhash|sqlite3|Random123|pcl/|ceres/|ompl/|octomap/|boost/)")
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')


def room_of(path):
    return "/".join(path.parts[:2])


def allowed_third_party(room, header):
    for pattern, rooms in THIRD_PARTY.items():
        if re.match(pattern, header):
            return any(room == r or (r.endswith("/*") and room.startswith(r[:-1])) for r in rooms)
    return True


def violations(root):
    for folder in ("core", "sim"):
        for path in sorted((root / folder).rglob("*.[ch]pp")):
            relative = path.relative_to(root)
            room = room_of(relative)
            if room not in ROOMS:
                yield f"{relative}: the room '{room}' is not in the table of {pathlib.Path(__file__).name}"
                continue
            for number, line in enumerate(path.read_text().splitlines(), 1):
                match = INCLUDE.match(line)
                if not match:
                    continue
                header = match.group(1)
                where = f"{relative}:{number}: {header}"
                allowed_sim = room in PUBLIC_SIM_USERS or (folder == "sim" and header in PUBLIC_SIM_FOR_ALL)
                if header.startswith("swiftlet/sim/") and not allowed_sim:
                    yield f"{where}: {room} must not know the public types of sim"
                elif re.match(r"^(core|sim)/", header):
                    used = room_of(pathlib.PurePath(header))
                    if used != room and used not in ROOMS[room]:
                        yield f"{where}: {room} must not use {used}"
                elif not allowed_third_party(room, header):
                    yield f"{where}: not in {room}"
                elif path.suffix == ".hpp" and HEADER_ONLY_IN_CPP.match(header) and "internal" not in path.name:
                    yield f"{where}: third-party types stay in .cpp files (or a *_internal.hpp of the room)"
    for path in sorted((root / "include/swiftlet/core").glob("*.hpp")):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if match and not re.match(r"^(swiftlet/core/|Eigen/|[a-z_]+$)", match.group(1)):
                yield f"{path.relative_to(root)}:{number}: {match.group(1)}: the public types of core use Eigen and std only"


def main():
    found = list(violations(pathlib.Path(sys.argv[1])))
    print("\n".join(found))
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
