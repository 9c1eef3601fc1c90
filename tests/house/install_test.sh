#!/usr/bin/env bash
# The installed package, used by foreign programs, the software of a robot and a plugin. Usage: install_test.sh BUILD_DIR
set -euo pipefail
. "$(dirname "$0")/in_project.sh"

in_project "$here/consumer" consumer all
"$work/consumer/robot"
"$work/consumer/flight"

# A robot has Eigen, Clipper, Boost.Math and Random123, and no package that only the simulator needs.
without=()
for package in embree yaml-cpp OpenMP fmt nlohmann_json PNG ZLIB Threads SQLite3 CLI11 PCL; do
  without+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON")
done
in_project "$here/consumer" on_board all -DON_BOARD=ON "${without[@]}"
"$work/on_board/robot"
cmake -S "$here/../.." -B "$work/core" -G Ninja -DSWIFTLET_SIM=OFF -DCMAKE_CXX_COMPILER="$compiler" "${without[@]}" >/dev/null
cmake --build "$work/core" --target swiftlet_core_math >/dev/null

in_project "$examples" examples "spiral my_swiftlet"
cd "$work/examples"
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

# The installed program finds the installed assets, not the source tree's.
cd "$work"
env -u SWIFTLET_ASSETS "$work/prefix/bin/swiftlet" list vehicles
