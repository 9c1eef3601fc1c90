#!/usr/bin/env bash
# The examples, built against the installed package. Usage: examples_test.sh BUILD_DIR
set -euo pipefail
. "$(dirname "$0")/in_project.sh"

# The examples: each checks its own result and reports it.
in_project "$examples" examples all
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
# A program refuses module types that are not registered in it.
if recorder/own_recorder "$examples/guidance/orbit.yaml" "$work/recorded" 2>refused; then exit 1; fi
grep -q 'guidance.type: expected one of .*, found .orbit' refused
if [ -d pcl ]; then pcl/register_scans "$examples/pcl/hall.yaml"; fi  # where this build has the component
