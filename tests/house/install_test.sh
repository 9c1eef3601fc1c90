#!/usr/bin/env bash
# Installs the build to its own prefix and builds external projects against it. Usage: install_test.sh BUILD_DIR
set -euo pipefail
build=$1
here=$(cd "$(dirname "$0")" && pwd)
examples=$here/../../examples
work=$build/install_test
compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' "$build/CMakeCache.txt")
rm -rf "$work"
cmake --install "$build" --prefix "$work/prefix" >/dev/null

# Builds an external project that finds only the installed package.
in_project() {  # source binary option...
  local source=$1 binary=$work/$2
  shift 2
  cmake -S "$source" -B "$binary" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER="$compiler" \
    -DCMAKE_PREFIX_PATH="$work/prefix" "$@" >/dev/null
  cmake --build "$binary"
}
in_project "$here/consumer" consumer
"$work/consumer/robot"
"$work/consumer/flight"

# A robot has Eigen and Clipper, and no package that only the simulator needs.
without=()
for package in embree yaml-cpp OpenMP fmt nlohmann_json PNG ZLIB Threads SQLite3 CLI11 PCL; do
  without+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON")
done
in_project "$here/consumer" on_board -DON_BOARD=ON "${without[@]}"
"$work/on_board/robot"
cmake -S "$here/../.." -B "$work/core" -G Ninja -DSWIFTLET_SIM=OFF -DCMAKE_CXX_COMPILER="$compiler" "${without[@]}" >/dev/null
cmake --build "$work/core" --target swiftlet_core_math >/dev/null

# The examples: each checks its own result and reports it.
in_project "$examples" examples
cd "$work/examples"
agent/own_agent
guidance/own_guidance "$examples/guidance/orbit.yaml"
detector/own_detector
sensor/own_sensor
recorder/own_recorder "$examples/recorder/plan.yaml" "$work/recorded"
[ "$(grep -c '<polyline' "$work/recorded/plan.svg")" = 3 ]
batch/batch
# SLAM of recorded data ends at the true displacement from the start, to 0.1 m.
records=$work/examples/records
"$work/prefix/bin/swiftlet" run "$examples/robot/records.yaml" --threads 1 -q --out "$records"
robot/recorded_slam "$records/scans/uav1_puck" "$records/csv/uav1/imu.csv" 0 0 0.25 >"$records/slam.tum"
awk 'NR == FNR { if (!/^#/) { if (!n++) { x0 = $2; y0 = $3; z0 = $4 } x = $2 - x0; y = $3 - y0; z = $4 - z0 }; next }
  { u = $2; v = $3; w = $4 }
  END { off = sqrt((u - x)^2 + (v - y)^2 + (w - z)^2); print "SLAM of records is " off " m off after " sqrt(x^2 + y^2) " m"
        exit !(off < 0.1 && x > 5) }' "$records/trajectories/uav1.tum" "$records/slam.tum"
# The same records with padded points of an Ouster, and with doubles, give the same trajectory. Times in seconds are refused.
rewrite_records() {  # folder, names of the fields, their types as of Python's struct, COUNT of each
  python3 - "$records/scans/uav1_puck" "$@" <<'END'
import glob, os, shutil, struct, sys
source, target, names, types, counts = sys.argv[1], sys.argv[2], *(word.split() for word in sys.argv[3:])
os.makedirs(target)
shutil.copy(f"{source}/pcd_index.csv", target)
kinds = {"f": ("F", 4), "d": ("F", 8), "B": ("U", 1), "H": ("U", 2), "I": ("U", 4)}
sizes = {("F", "4"): "f", ("U", "4"): "I", ("U", "2"): "H", ("U", "1"): "B"}
for file in glob.glob(f"{source}/*.pcd"):
    head, data = open(file, "rb").read().split(b"DATA binary\n", 1)
    lines = {line.split()[0]: line.split()[1:] for line in head.decode().splitlines()}
    row = struct.Struct("<" + "".join(sizes[kind] for kind in zip(lines["TYPE"], lines["SIZE"])))
    out = struct.Struct("<" + "".join(count + kind for kind, count in zip(types, counts)))
    points = []
    for values in row.iter_unpack(data):
        point = dict(zip(lines["FIELDS"], values))
        if types[names.index("t")] != "I":
            point["t"] *= 1e-9
        values = [(point.get(name, 0) if k == 0 else 0, kind) for name, kind, count in zip(names, types, counts)
                  for k in range(int(count))]
        points.append(out.pack(*(value if kind in "fd" else int(value) for value, kind in values)))
    with open(f"{target}/{os.path.basename(file)}", "wb") as written:
        written.write((f"FIELDS {' '.join(names)}\nSIZE {' '.join(str(kinds[t][1]) for t in types)}\n"
                       f"TYPE {' '.join(kinds[t][0] for t in types)}\nCOUNT {' '.join(counts)}\nWIDTH {len(points)}\nHEIGHT 1\n"
                       f"POINTS {len(points)}\nDATA binary\n").encode() + b"".join(points))
END
}
rewrite_records "$work/padded" "x y z _ intensity t reflectivity ring ambient _ range _" "f f f B f I H H H B I B" "1 1 1 4 1 1 1 1 1 2 1 12"
rewrite_records "$work/doubles" "x y z t" "d d d I" "1 1 1 1"
for rewritten in padded doubles; do
  robot/recorded_slam "$work/$rewritten" "$records/csv/uav1/imu.csv" 0 0 0.25 | cmp - "$records/slam.tum"
done
rewrite_records "$work/seconds" "x y z t" "f f f f" "1 1 1 1"
if robot/recorded_slam "$work/seconds" "$records/csv/uav1/imu.csv" 0 0 0.25 2>seconds; then exit 1; fi
grep -q 'expected a field t of TYPE U' seconds
# A module loaded as a plugin and one compiled into a program give the same flight.
swiftlet=$work/prefix/bin/swiftlet
spiral=$examples/plugin/spiral.yaml
plugin=(--set "plugins=[$work/examples/plugin/libspiral.so]")
"$swiftlet" run "$spiral" "${plugin[@]}" --allow-plugins -q --out by_plugin
plugin/my_swiftlet run "$spiral" -q --out by_program
[ "$(grep state_hash by_plugin/summary.json)" = "$(grep state_hash by_program/summary.json)" ]
cmp by_plugin/trajectories/uav1.tum by_program/trajectories/uav1.tum
refused() {  # message command...: exit status 2, and the message
  local message=$1 status=0
  shift
  "$@" >/dev/null 2>refused || status=$?
  [ "$status" = 2 ] && grep -q "$message" refused || { echo "$*: $status"; cat refused; exit 1; }
}
# A plugin is code: only the command line may allow it. Its keys are read as strictly as all others.
refused 'plugins: expected --allow-plugins' "$swiftlet" check "$spiral" "${plugin[@]}"
refused 'did you mean "radius_m"' "$swiftlet" check "$spiral" "${plugin[@]}" --allow-plugins --set vehicles[0].agent.guidance.radus_m=1
refused 'guidance.type: expected one of .*found "spiral"' "$swiftlet" check "$spiral"
refused 'a shared library, found "nowhere.so"' "$swiftlet" check "$spiral" --set 'plugins=[nowhere.so]' --allow-plugins
"$swiftlet" reference --plugin plugin/libspiral.so | grep '`climb_mps`' >/dev/null
"$swiftlet" list guidance --plugin plugin/libspiral.so | grep 'climbs around its start' >/dev/null
# A plugin for another version, and a library that is no plugin.
echo 'const char* swiftlet_plugin_version(void) { return "0.0.1 (old)"; } void swiftlet_plugin_register(void) {}' >old.c
echo 'int nothing;' >none.c
cc -shared -fPIC -o libold.so old.c
cc -shared -fPIC -o libnone.so none.c
refused 'found "libold.so", which has no SWIFTLET_PLUGIN, or that of an older version; build it again' "$swiftlet" check "$spiral" \
  --set 'plugins=[libold.so]' --allow-plugins
refused 'which has no SWIFTLET_PLUGIN' "$swiftlet" check "$spiral" --set 'plugins=[libnone.so]' --allow-plugins

# A program refuses module types that are not registered in it.
if recorder/own_recorder "$examples/guidance/orbit.yaml" "$work/recorded" 2>refused; then exit 1; fi
grep -q 'guidance.type: expected one of .*, found .orbit' refused
if [ -d pcl ]; then pcl/register_scans "$examples/pcl/hall.yaml"; fi  # where this build has the component

# The installed program finds the installed assets, not the source tree's.
cd "$work"
env -u SWIFTLET_ASSETS "$work/prefix/bin/swiftlet" list vehicles
