#!/usr/bin/env python3
"""Random scenarios have the same bits whatever instructions Embree is set to use, on 1 and on 2 threads.

    instruction_sets_test.py SWIFTLET COUNT [FIRST_SEED]
"""
import json
import os
import random
import subprocess
import sys
import tempfile

NEEDED = {  # by Embree, of the flags of a processor; it refuses what the processor has not
    "isa=sse2": {"sse2"},
    "isa=sse4.2": {"sse4_2"},
    "isa=avx": {"avx"},
    "isa=avx2": {"avx2", "fma"},
    "isa=avx512,frequency_level=simd512": {"avx512f", "avx512dq", "avx512cd", "avx512bw", "avx512vl"},
}
FLAGS = next((set(line.split()) for line in open("/proc/cpuinfo") if line.startswith("flags")), set())
SETTINGS = [setting for setting, needed in NEEDED.items() if needed <= FLAGS]
WORLDS = {  # type: (how far from the middle vehicles start, how high)
    "empty": (20.0, (2.0, 8.0)),
    "field": (20.0, (3.0, 12.0)),
    "forest": (15.0, (3.0, 15.0)),
    "forest_thesis": (15.0, (2.0, 8.0)),
    "warehouse": (8.0, (1.5, 6.0)),
    "two_rooms_gap": (3.0, (1.0, 2.5)),
    "hall": (6.0, (1.0, 4.0)),
    "campus": (20.0, (3.0, 15.0)),
}


def random_lidar(draw):
    lidar = {"type": "lidar", "model": draw.choice(["os1_128", "os0_128", "mid360", "puck_lite", "os1_128_uniform"])}
    if lidar["model"].startswith("os"):
        lidar["pattern"] = {"columns": draw.choice([64, 128, 256])}
    lidar["rolling"] = draw.random() < 0.7
    lidar["ideal"] = draw.random() < 0.2
    lidar["self_mask"] = draw.random() < 0.3
    lidar["rate_hz"] = draw.choice([10, 20])
    if draw.random() < 0.3:
        lidar["beam"] = {"sub_rays": draw.choice([5, 9]), "divergence_deg": draw.uniform(0.05, 0.6)}
    if draw.random() < 0.5:
        lidar["mount"] = {"position_m": [0, 0, draw.uniform(0.05, 0.2)], "rpy_deg": [0, draw.uniform(-30, 30), 0]}
    return lidar


def random_scenario(draw, seed):
    world = draw.choice(list(WORLDS))
    reach_m, heights_m = WORLDS[world]
    vehicles = []
    for k in range(draw.choice([1, 2, 3])):
        # Beams meet edges at round numbers.
        place = [draw.uniform(-reach_m, reach_m), draw.uniform(-reach_m, reach_m), draw.uniform(*heights_m)]
        if draw.random() < 0.5:
            place = [round(x) for x in place]
        vehicles.append({
            "name": f"uav{k + 1}",
            "model": draw.choice(["x500", "t650", "f330", "f450", "f550"]),
            "start": {"position_m": place, "above_ground": True, "yaw_deg": draw.choice([0, 90, draw.uniform(0, 360)]),
                      "velocity_mps": [draw.uniform(-3, 3), draw.uniform(-3, 3), 0]},
            "sensors": [random_lidar(draw)] + ([{"type": "altimeter"}] if draw.random() < 0.5 else []),
            "agent": {"type": "stack", "localization": {"type": "ground_truth"}, "guidance": {"type": "hover"}},
        })
    scenario = {"name": f"random_{seed}", "seed": seed, "duration_s": 0.32, "world": {"type": world}, "vehicles": vehicles}
    if world in ("forest", "field"):
        scenario["world"]["size_m"] = [40, 40]
    return scenario


def fly(swiftlet, scenario, folder, setting, threads):
    file = os.path.join(folder, "scenario.yaml")
    with open(file, "w") as f:
        json.dump(scenario, f)  # JSON is YAML
    out = os.path.join(folder, "run")
    subprocess.run(["rm", "-rf", out], check=True)
    environment = dict(os.environ, SWIFTLET_EMBREE=setting)
    result = subprocess.run([swiftlet, "run", file, "--out", out, "--quiet", "--threads", str(threads)], env=environment,
                            capture_output=True, text=True)
    if result.returncode == 2 and "start" in result.stderr:
        return None  # no room there: another place
    if result.returncode != 0:
        sys.exit(f"{scenario['name']}: exit {result.returncode}: {result.stderr}\n{json.dumps(scenario)}")
    with open(os.path.join(out, "summary.json")) as f:
        return json.load(f)["state_hash"]


def main():
    swiftlet, count = sys.argv[1], int(sys.argv[2])
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    flown, failed = 0, []
    while flown < count:
        scenario = random_scenario(random.Random(seed), seed)
        seed += 1
        with tempfile.TemporaryDirectory() as folder:
            expected = fly(swiftlet, scenario, folder, SETTINGS[0], 1)
            if expected is None:
                continue
            flown += 1
            for k, setting in enumerate(SETTINGS[1:]):
                found = fly(swiftlet, scenario, folder, setting, 1 + k % 2)
                if found != expected:
                    failed.append(f"{json.dumps(scenario)}: {SETTINGS[0]} gives {expected}, {setting} gives {found}")
    for line in failed:
        print(line)
    print(f"{flown} scenarios, {len(failed)} differ")
    sys.exit(1 if failed else 0)


main()
