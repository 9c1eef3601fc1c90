#!/usr/bin/env bash
# Installs the build to a prefix of its own and builds a foreign project against it. Usage: install_test.sh BUILD_DIR
set -euo pipefail
build=$1
here=$(cd "$(dirname "$0")" && pwd)
work=$build/install_test
rm -rf "$work"
cmake --install "$build" --prefix "$work/prefix" >/dev/null
cmake -S "$here/consumer" -B "$work/consumer" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix" >/dev/null
cmake --build "$work/consumer"
"$work/consumer/robot"
"$work/consumer/flight"
# The component pcl, where this build has it.
if [ -e "$work"/prefix/lib*/cmake/swiftlet/swiftletPclTargets.cmake ]; then
  cmake -S "$here/../../examples/pcl" -B "$work/pcl" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix" >/dev/null
  cmake --build "$work/pcl"
  "$work/pcl/register_scans" "$here/../../examples/pcl/hall.yaml"
fi
# The installed program finds the installed assets, not the source tree's.
cd "$work"
env -u SWIFTLET_ASSETS "$work/prefix/bin/swiftlet" list vehicles
