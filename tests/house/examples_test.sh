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
robot/recorded_slam "$records/scans/uav1_puck" "$records/csv/uav1/imu.csv" "$examples/robot/mount.txt" >"$records/slam.tum"
awk 'NR == FNR { if (!/^#/) { if (!n++) { x0 = $2; y0 = $3; z0 = $4 } x = $2 - x0; y = $3 - y0; z = $4 - z0 }; next }
  { u = $2; v = $3; w = $4 }
  END { off = sqrt((u - x)^2 + (v - y)^2 + (w - z)^2); print "SLAM of records is " off " m off after " sqrt(x^2 + y^2) " m"
        exit !(off < 0.1 && x > 5) }' "$records/trajectories/uav1.tum" "$records/slam.tum"
# The same records with padded points of an Ouster, doubles, text, compressed data, and times of the clock in seconds.
rewrite_records() {  # folder, DATA, names of the fields, their types as of Python's struct, COUNT of each
  python3 - "$records/scans/uav1_puck" "$@" <<'END'
import csv, glob, os, shutil, struct, sys
source, target, data_kind, names, types, counts = sys.argv[1], sys.argv[2], sys.argv[3], *(word.split() for word in sys.argv[4:])
os.makedirs(target)
shutil.copy(f"{source}/pcd_index.csv", target)
starts = {row[0]: float(row[1]) for row in list(csv.reader(open(f"{source}/pcd_index.csv")))[1:]}
kinds = {"f": ("F", 4), "d": ("F", 8), "B": ("U", 1), "H": ("U", 2), "I": ("U", 4)}
sizes = {("F", "4"): "f", ("U", "4"): "I", ("U", "2"): "H", ("U", "1"): "B"}
for file in glob.glob(f"{source}/*.pcd"):
    head, data = open(file, "rb").read().split(b"DATA binary\n", 1)
    lines = {line.split()[0]: line.split()[1:] for line in head.decode().splitlines()}
    row = struct.Struct("<" + "".join(sizes[kind] for kind in zip(lines["TYPE"], lines["SIZE"])))
    points = []
    for values in row.iter_unpack(data):
        point = dict(zip(lines["FIELDS"], values))
        point["timestamp"] = starts[os.path.basename(file)] + point["t"] * 1e-9
        point["microseconds"] = point["t"] // 1000
        if "microseconds" in names: point["t"] = point["microseconds"]
        points.append([[point.get(name, 0) if kind in "fd" else int(point.get(name, 0))] + [0] * (int(count) - 1)
                       for name, kind, count in zip(names, types, counts)])
    if data_kind == "ascii":
        body = "".join(" ".join(repr(v) for values in point for v in values) + "\n" for point in points).encode()
    elif data_kind == "binary":
        body = b"".join(struct.pack("<" + count + kind, *values) for point in points
                        for values, kind, count in zip(point, types, counts))
    else:  # field by field, in literal runs of LZF
        plain = b"".join(struct.pack("<" + count + kind, *point[i]) for i, (kind, count) in enumerate(zip(types, counts)) for point in points)
        packed = b"".join(bytes([len(run) - 1]) + run for run in (plain[i:i + 32] for i in range(0, len(plain), 32)))
        body = struct.pack("<II", len(packed), len(plain)) + packed
    with open(f"{target}/{os.path.basename(file)}", "wb") as written:
        written.write((f"FIELDS {' '.join(names)}\nSIZE {' '.join(str(kinds[t][1]) for t in types)}\n"
                       f"TYPE {' '.join(kinds[t][0] for t in types)}\nCOUNT {' '.join(counts)}\nWIDTH {len(points)}\nHEIGHT 1\n"
                       f"POINTS {len(points)}\nDATA {data_kind}\n").encode() + body)
END
}
rewrite_records "$work/padded" binary "x y z _ intensity t reflectivity ring ambient _ range _" "f f f B f I H H H B I B" "1 1 1 4 1 1 1 1 1 2 1 12"
rewrite_records "$work/doubles" binary "t z y x" "I d d d" "1 1 1 1"
rewrite_records "$work/compressed" binary_compressed "x y z ring t" "f f f H I" "1 1 1 3 1"
rewrite_records "$work/text" ascii "x y z t" "f f f I" "1 1 1 1"
for rewritten in padded doubles compressed text; do
  robot/recorded_slam "$work/$rewritten" "$records/csv/uav1/imu.csv" "$examples/robot/mount.txt" | cmp - "$records/slam.tum"
done
rewrite_records "$work/clock" binary "x y z timestamp" "f f f d" "1 1 1 1"
robot/recorded_slam "$work/clock" "$records/csv/uav1/imu.csv" "$examples/robot/mount.txt" >clock.tum
paste <(tail -n 1 clock.tum) <(tail -n 1 "$records/slam.tum") |
  awk '{ exit !(($2 - $10)^2 + ($3 - $11)^2 + ($4 - $12)^2 < 1e-4) }'
refuses() {  # expected text, arguments of recorded_slam
  if robot/recorded_slam "${@:2}" >/dev/null 2>refused; then exit 1; fi
  grep -q "$1" refused
}
rewrite_records "$work/microseconds" binary "x y z t microseconds" "f f f I I" "1 1 1 1 1"
refuses 'whole numbers in nanoseconds' "$work/microseconds" "$records/csv/uav1/imu.csv" "$examples/robot/mount.txt"
awk -F, -v OFS=, 'NR > 1 { for (i = 5; i < 8; ++i) $i = -$i } 1' "$records/csv/uav1/imu.csv" >negated.csv
refuses 'negated.csv:51: .*z up, found .*; negate it' "$records/scans/uav1_puck" negated.csv "$examples/robot/mount.txt"
echo '1 0 0 0  0 1 0 0  0 0 2 0' >stretched.txt
refuses 'stretched.txt:.*expected a rotation' "$records/scans/uav1_puck" "$records/csv/uav1/imu.csv" stretched.txt
# A program refuses module types that are not registered in it.
if recorder/own_recorder "$examples/guidance/orbit.yaml" "$work/recorded" 2>refused; then exit 1; fi
grep -q 'guidance.type: expected one of .*, found .orbit' refused
if [ -d pcl ]; then pcl/register_scans "$examples/pcl/hall.yaml"; fi  # where this build has the component
