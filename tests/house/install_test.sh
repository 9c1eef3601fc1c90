#!/usr/bin/env bash
# Installs the build to a prefix of its own and builds foreign projects against it. Usage: install_test.sh BUILD_DIR
set -euo pipefail
build=$1
here=$(cd "$(dirname "$0")" && pwd)
examples=$here/../../examples
work=$build/install_test
compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' "$build/CMakeCache.txt")
rm -rf "$work"
cmake --install "$build" --prefix "$work/prefix" >/dev/null

# Every installed header stands alone: it compiles by itself, with the package alone. What it takes from Eigen
# and from the standard library is read once for all.
cd "$work"/prefix/include/swiftlet-*
headers=$(find . -name '*.hpp' | sed 's,^\./,,' | sort)
options="-std=c++20 -Werror -Wno-ignored-attributes -I. $(pkg-config --cflags eigen3)"
printf '#include <%s>\n' Eigen/Geometry filesystem functional map memory optional span string vector >"$work/common.hpp"
c++ $options -x c++-header "$work/common.hpp" -o "$work/common.hpp.gch"
alone="echo \"#include \\\"\$1\\\"\" | c++ $options -include '$work/common.hpp' -fsyntax-only -x c++ - ||
  { echo \"\$1 does not stand alone\"; exit 1; }"
echo "$headers" | xargs -P "$(nproc)" -I HEADER sh -c "$alone" sh HEADER
echo "$(echo "$headers" | wc -l) headers stand alone"

# A project of somebody else's that knows the installed package only.
in_project() {  # source binary
  cmake -S "$1" -B "$work/$2" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$work/prefix" >/dev/null
  cmake --build "$work/$2"
}
in_project "$here/consumer" consumer
"$work/consumer/robot"
"$work/consumer/flight"

# The examples: each judges its own result, and says it.
in_project "$examples" examples
cd "$work/examples"
agent/own_agent
guidance/own_guidance "$examples/guidance/orbit.yaml"
detector/own_detector
sensor/own_sensor
recorder/own_recorder "$examples/recorder/plan.yaml" "$work/recorded"
[ "$(grep -c '<polyline' "$work/recorded/plan.svg")" = 3 ]
batch/batch
# What a program did not plug in, it refuses by name.
if recorder/own_recorder "$examples/guidance/orbit.yaml" "$work/recorded" 2>refused; then exit 1; fi
grep -q 'guidance.type: expected one of .*, found .orbit' refused
if [ -d pcl ]; then pcl/register_scans "$examples/pcl/hall.yaml"; fi  # where this build has the component

# The installed program finds the installed assets, not the source tree's.
cd "$work"
env -u SWIFTLET_ASSETS "$work/prefix/bin/swiftlet" list vehicles
